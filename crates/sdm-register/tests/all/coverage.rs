//! How much of what a scan could see has points.

#![allow(clippy::unwrap_used, reason = "tests may panic")]

use crate::bodies::{Bumpy, Random};
use distance_field::MeshField;
use mesh_core::TriangleMesh;
use nalgebra::{Point3, Vector3};
use sdm_register::start::OrientedPoints;
use sdm_register::{Coverage, Pose};

/// A closed box about the origin, with its samples.
fn cuboid(sides: [f64; 3]) -> (MeshField, OrientedPoints) {
    let corner = |i: u32| Point3::from([0, 1, 2].map(|axis| sides[axis] * (f64::from(i >> axis & 1) - 0.5)));
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let mesh = TriangleMesh::new((0..8).map(corner).collect(), triangles).unwrap();
    (MeshField::new(&mesh).unwrap(), OrientedPoints::from_mesh(&mesh, 6000))
}

/// Points on the upper face of the box of sides 4, 4, 1, up to a corner of it.
fn upper(share: f64, random: &mut Random) -> Vec<Vector3<f64>> {
    (0..4000)
        .map(|_| Vector3::new(share * random.unit() - 0.5, share * random.unit() - 0.5, 0.125) * 4.0)
        .collect()
}

#[test]
fn one_face_is_all_that_is_seen_from_above() {
    let (field, samples) = cuboid([4.0, 4.0, 1.0]);
    let mut random = Random(1);
    let whole = Coverage::of(&field, &samples, &upper(1.0, &mut random), &Pose::identity(), None).unwrap();
    assert!(whole.covered > 0.95, "{whole}");
    // 16 of 48 units of area.
    assert!((whole.region - 1.0 / 3.0).abs() < 0.06, "{whole}");
    // A quarter of the face is most of what a scan of a quarter could see: the box around it may be turned.
    let part = Coverage::of(&field, &samples, &upper(0.5, &mut random), &Pose::identity(), None).unwrap();
    assert!(part.covered > 0.6 && part.region < 0.5 * whole.region && part.model < 0.15, "{part}");
}

#[test]
fn a_scan_of_something_else_leaves_most_of_it_bare() {
    let (field, samples) = cuboid([4.0, 4.0, 1.0]);
    let mut random = Random(2);
    // Points all around, of which those near one corner of the face count.
    let around: Vec<_> = (0..3000)
        .map(|_| Vector3::new(random.unit() - 0.5, random.unit() - 0.5, 0.4 + random.unit()) * 4.0)
        .chain((0..60).map(|k| Vector3::new(-1.9 + 0.001 * f64::from(k), -1.9, 0.5)))
        .collect();
    let found = Coverage::of(&field, &samples, &around, &Pose::identity(), Some(1e-3)).unwrap();
    assert!(found.covered < 0.1, "{found}");
}

#[test]
fn a_body_seen_from_all_sides_is_covered() {
    let (body, mut random) = (Bumpy::new(), Random(4));
    let (points, normals) = body.view(None, 6000, &mut random);
    let samples = OrientedPoints::new(&points, &normals).unwrap();
    let cloud: Vec<Point3<f64>> = points.iter().copied().map(Point3::from).collect();
    let field = distance_field::CloudField::new(&cloud, Some(&normals)).unwrap();
    let all = Coverage::of(&field, &samples, &points, &Pose::identity(), None).unwrap();
    assert!(all.covered == 1.0 && all.region > 0.99, "{all}");
    let half = body.view(Some((Vector3::z(), 1.3)), 4000, &mut random).0;
    let one = Coverage::of(&field, &samples, &half, &Pose::identity(), None).unwrap();
    assert!(one.covered > 0.85 && one.model < 0.75, "{one}");
}

#[test]
fn nothing_is_said_without_points_or_samples() {
    let (field, samples) = cuboid([1.0; 3]);
    let none = OrientedPoints::default();
    let points = [Vector3::zeros(), Vector3::repeat(f64::NAN), Vector3::repeat(1e300)];
    assert_eq!(Coverage::of(&field, &samples, &[], &Pose::identity(), None), None);
    assert_eq!(Coverage::of(&field, &none, &points, &Pose::identity(), None), None);
    let far = Coverage::of(&field, &samples, &points[1..], &Pose::identity(), Some(1.0));
    assert_eq!(far, None);
}
