//! Bodies of the fuzz targets: what a reader makes of arbitrary bytes must be an answer that is consistent, or an error.
//!
//! A target is a function of bytes that panics on a fault. libFuzzer calls it with what it makes up (see `README.md`), and
//! the test `seeds` with every file in `seeds/TARGET`, so that what has been found once is looked at in every run.
//!
//! ```
//! let (_, read_ply) = fuzz_targets::TARGETS.iter().find(|(name, _)| *name == "ply").unwrap();
//! read_ply(b"ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nend_header\n");
//! ```

use footpoint::{CurveProjector, SurfaceProjector};
use nalgebra::{SVector, Vector3};
use pc_io::mesh_core::MeshProjector;
use pc_io::mesh_core::nalgebra::Point3;
use pc_io::{Content, Format, ReadOptions, Shape, read_bytes};

/// The body of a target.
pub type Target = fn(&[u8]);

/// All targets by name; each has seeds in the folder of that name.
pub const TARGETS: &[(&str, Target)] = &[
    ("any", any),
    ("json", json),
    ("obj", obj),
    ("off", off),
    ("pcd", pcd),
    ("ply", ply),
    ("project", project),
    ("ptx", ptx),
    ("stl", stl),
    ("xyz", xyz),
];

/// Reads bytes, their format recognised, with every hint.
pub fn any(data: &[u8]) {
    for hint in Format::ALL {
        check(data, ReadOptions::default().with_drop_non_finite(true), Some(hint));
    }
    check(data, ReadOptions::default(), None);
}

/// Reads NURBS JSON.
pub fn json(data: &[u8]) {
    read_as(data, Format::Json);
}

/// Reads OBJ.
pub fn obj(data: &[u8]) {
    read_as(data, Format::Obj);
}

/// Reads OFF.
pub fn off(data: &[u8]) {
    read_as(data, Format::Off);
}

/// Reads PCD.
pub fn pcd(data: &[u8]) {
    read_as(data, Format::Pcd);
}

/// Reads PLY.
pub fn ply(data: &[u8]) {
    read_as(data, Format::Ply);
}

/// Reads PTX.
pub fn ptx(data: &[u8]) {
    read_as(data, Format::Ptx);
}

/// Reads STL.
pub fn stl(data: &[u8]) {
    read_as(data, Format::Stl);
}

/// Reads tables of points: separated by blanks, by commas, and under a count.
pub fn xyz(data: &[u8]) {
    for format in [Format::Xyz, Format::Csv, Format::Pts] {
        read_as(data, format);
    }
}

/// Projects a few points onto the shapes of a NURBS JSON file. The distance must be that of the foot, and what is proven
/// never more.
pub fn project(data: &[u8]) {
    let options = ReadOptions::default().with_format(Format::Json);
    let Ok(loaded) = read_bytes(data, None, &options) else { return };
    let Content::Nurbs(model) = loaded.content else { return };
    for shape in model.into_shapes().into_iter().take(4) {
        match shape {
            Shape::Curve2(curve) => {
                let Ok(projector) = CurveProjector::for_model(&[curve]) else { continue };
                for x in places::<2>() {
                    let foot = projector.project(&x);
                    check_foot(&x, &foot.point, foot.distance, foot.lower_bound);
                }
            }
            Shape::Curve3(curve) => {
                let Ok(projector) = CurveProjector::for_model(&[curve]) else { continue };
                for x in places::<3>() {
                    let foot = projector.project(&x);
                    check_foot(&x, &foot.point, foot.distance, foot.lower_bound);
                }
            }
            Shape::Surface(surface) => {
                let Ok(projector) = SurfaceProjector::for_model(&[surface]) else { continue };
                for x in places::<3>() {
                    let foot = projector.project(&x);
                    check_foot(&x, &foot.point, foot.distance, foot.lower_bound);
                }
            }
        }
    }
}

/// Near the origin and far out, on axes and off.
fn places<const D: usize>() -> impl Iterator<Item = SVector<f64, D>> {
    [0.0, 0.3, 10.0, -1e9]
        .into_iter()
        .map(|size| SVector::from_fn(|i, _| size * [1.0, -0.7, 0.4][i]))
        .chain([SVector::from_fn(|i, _| if i == 0 { 1.0 } else { 0.0 })])
}

fn check_foot<const D: usize>(x: &SVector<f64, D>, foot: &SVector<f64, D>, distance: f64, lower_bound: f64) {
    let size = x.amax().max(foot.amax());
    // What overflows is no distance any more.
    if size < 1e150 {
        let rounding = 1e-9 * (1.0 + size);
        assert!(((x - foot).norm() - distance).abs() <= rounding, "{x} {foot}: {distance}");
        assert!(lower_bound <= distance + rounding, "{x} {foot}: {lower_bound} {distance}");
    }
}

fn read_as(data: &[u8], format: Format) {
    check(data, ReadOptions::default().with_format(format), None);
}

/// Whatever is read must be consistent and no larger than the bytes can tell.
fn check(data: &[u8], options: ReadOptions, hint: Option<Format>) {
    let Ok(loaded) = read_bytes(data, hint, &options) else { return };
    let report = loaded.report;
    assert!(report.points <= data.len() * 64 + 8, "{report}");
    assert!(report.triangles <= data.len() * 64 + 8, "{report}");
    if let Content::Mesh(mesh) = loaded.content
        && mesh.triangles().len() < 1000
        && let Ok(projector) = MeshProjector::new(&mesh)
        && let Ok(foot) = projector.project(&Point3::from(Vector3::new(0.5, 0.25, 2.0)))
    {
        assert!(foot.triangle < mesh.triangles().len());
        assert!(foot.distance >= 0.0);
    }
}
