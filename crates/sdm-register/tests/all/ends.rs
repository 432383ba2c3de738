//! Ends of open models: those of one side leave the motion along a groove free, those of both sides do not.

use crate::common::Random;
use distance_field::MeshField;
use mesh_core::TriangleMesh;
use nalgebra::{Point3, Vector3};
use sdm_register::{Outliers, Pose, RegisterOptions, RegisterReport, Source, register};

/// A groove along y from 0 to 100 whose section is no arc, and how high it is at x.
fn groove() -> MeshField {
    let section = [[-30.0, 0.0], [-10.0, 0.0], [0.0, -12.0], [8.0, 0.0], [30.0, 3.0]];
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for k in 0..21u32 {
        vertices.extend(section.map(|[x, z]| Point3::new(x, 5.0 * f64::from(k), z)));
        for i in (0..4).filter(|_| k < 20).map(|i| 5 * k + i) {
            triangles.extend([[i, i + 1, i + 6], [i, i + 6, i + 5]]);
        }
    }
    MeshField::new(&TriangleMesh::new(vertices, triangles).unwrap()).unwrap()
}

/// Points of the groove, lengthened or not, from one place along it to another, with some noise.
fn registered(from: f64, to: f64, outliers: Outliers) -> RegisterReport<3> {
    let mut random = Random::new(2);
    let points: Vec<Vector3<f64>> = (0..1500)
        .map(|_| {
            let x = -30.0 + 60.0 * random.uniform();
            let z = match x {
                x if x < -10.0 => 0.0,
                x if x < 0.0 => -1.2 * (x + 10.0),
                x if x < 8.0 => 1.5 * (x - 8.0),
                x => 3.0 / 22.0 * (x - 8.0),
            };
            Vector3::new(x, from + (to - from) * random.uniform(), z) + random.vector() * 0.05
        })
        .collect();
    let options = RegisterOptions::default().with_outliers(outliers);
    register(&groove(), &Source::new(&points), &Pose::identity(), &options).unwrap()
}

#[test]
fn along_a_groove_one_end_fixes_nothing() {
    // In the middle, and with some points beyond one end.
    for (from, to) in [(20.0, 60.0), (-0.3, 40.0), (60.0, 100.4)] {
        let report = registered(from, to, Outliers::Automatic);
        assert!(report.is_converged() && report.free_motions.len() == 1, "{from} {to}: {report}");
        assert!(report.to_string().contains("translation along (0.000000, "), "{from} {to}: {report}");
    }
    // Points beyond both ends have one place only, if they count.
    let report = registered(-8.0, 108.0, Outliers::None);
    assert!(report.free_motions.is_empty(), "{report}");
}
