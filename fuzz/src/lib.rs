//! What the fuzz targets have in common.

use pc_io::mesh_core::MeshProjector;
use pc_io::mesh_core::nalgebra::Point3;
use pc_io::{Content, Format, ReadOptions, read_bytes};

/// Reads bytes as one format. Whatever is read must be consistent and no larger than the bytes can tell.
pub fn read_as(data: &[u8], format: Format) {
    check(data, ReadOptions::default().with_format(format), None);
}

/// Reads bytes, their format recognised, with every hint.
pub fn recognise_and_read(data: &[u8]) {
    for hint in Format::ALL {
        check(data, ReadOptions::default().with_drop_non_finite(true), Some(hint));
    }
}

fn check(data: &[u8], options: ReadOptions, hint: Option<Format>) {
    let Ok(loaded) = read_bytes(data, hint, &options) else { return };
    let report = loaded.report;
    assert!(report.points <= data.len() * 64 + 8, "{report}");
    assert!(report.triangles <= data.len() * 64 + 8, "{report}");
    if let Content::Mesh(mesh) = loaded.content
        && mesh.triangles().len() < 1000
        && let Ok(projector) = MeshProjector::new(&mesh)
        && let Ok(foot) = projector.project(&Point3::new(0.5, 0.25, 2.0))
    {
        assert!(foot.triangle < mesh.triangles().len());
        assert!(foot.distance >= 0.0);
    }
}
