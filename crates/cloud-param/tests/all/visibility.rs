//! Hidden point removal against rays on a mesh.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

use crate::common;
use cloud_param::{Error, Sharpness, View, visible_points};
use mesh_core::{MeshProjector, TriangleMesh, sample_uniform};
use nalgebra::{Point3, Vector3};

fn bunny() -> TriangleMesh {
    let text = include_str!("../../../../fixtures/mesh/bunny.obj");
    let numbers =
        |line: &str| -> Vec<f64> { line.split_whitespace().skip(1).map(|w| w.parse().unwrap()).collect() };
    let points =
        text.lines().filter(|l| l.starts_with("v ")).map(numbers).map(|v| Point3::new(v[0], v[1], v[2]));
    let corner = |w: &str| w.split('/').next().unwrap().parse::<u32>().unwrap() - 1;
    let faces = text.lines().filter(|l| l.starts_with("f ")).map(|l| {
        let c: Vec<u32> = l.split_whitespace().skip(1).map(corner).collect();
        [c[0], c[1], c[2]]
    });
    TriangleMesh::new(points.collect(), faces.collect()).unwrap()
}

/// Shares of the points that are wrongly visible and wrongly hidden.
fn errors(points: &[Vector3<f64>], mesh: &MeshProjector, eye: &Vector3<f64>, view: View) -> [f64; 2] {
    let seen = visible_points(points, view, Sharpness::default()).unwrap();
    let mut wrong = [0.0; 2];
    for i in (0..points.len()).step_by(7) {
        let towards = match view {
            View::From(eye) => eye - points[i],
            View::Along(direction) => -direction,
        }
        .normalize();
        let start = points[i] + towards * eye.norm();
        let hit = mesh.nearest_on_line(&start.into(), &-towards).unwrap();
        let visible = hit.is_none_or(|hit| hit.offset.abs() > eye.norm() * (1.0 - 1e-7));
        wrong[usize::from(visible)] += f64::from(u8::from(seen.visible[i] != visible));
    }
    wrong.map(|w| w * 7.0 / points.len() as f64)
}

#[test]
fn few_points_of_the_bunny_are_wrongly_visible_or_hidden() {
    let mesh = bunny();
    let points: Vec<Vector3<f64>> =
        sample_uniform(&mesh, 35_000, 1).unwrap().iter().map(|s| s.point.coords).collect();
    let size = points.iter().map(Vector3::norm).fold(0.0, f64::max);
    let projector = MeshProjector::new(&mesh).unwrap();
    for direction in [Vector3::new(0.3, 0.2, 1.0), Vector3::new(1.0, 0.1, 0.0), Vector3::new(-0.5, 0.7, -0.6)]
    {
        let eye = direction.normalize() * (4.0 * size);
        for view in [View::From(eye), View::Along(-direction)] {
            let [visible, hidden] = errors(&points, &projector, &eye, view);
            assert!(visible < 0.02 && hidden < 0.02, "{view:?}: {visible} {hidden}");
        }
    }
}

/// The visible sets of another convex hull: qhull 2020.2 by way of scipy 1.17, on the same points reflected in the same sphere. Number and
/// FNV-1a hash of the indices in ascending order.
#[test]
fn a_fixed_radius_shows_what_qhull_shows() {
    let eye = Vector3::new(20.0, 3.0, 4.0);
    for (count, expected) in [
        (2_000, [(806, 0xa029_c18a_e86a_77f5), (1713, 0x2a0e_5ca8_7759_7ec6)]),
        (20_000, [(5720, 0x3a5e_a178_045c_3c81), (8118, 0x9ac1_3611_f663_a92b)]),
        (200_000, [(18605, 0x2bf7_8a2e_078a_238d_u64), (55515, 0x9fc8_084b_089b_ff1f)]),
    ] {
        let points = common::vase(count, 0.05);
        for (power, expected) in [2.5, 3.5].into_iter().zip(expected) {
            let sharpness = Sharpness::Radius(10f64.powf(power));
            let seen = visible_points(&points, View::From(eye), sharpness).unwrap();
            let indices = (0u64..).zip(&seen.visible).filter(|(_, visible)| **visible).map(|(i, _)| i);
            let hash = indices.fold(0xcbf2_9ce4_8422_2325, |h: u64, i| (h ^ i).wrapping_mul(0x100_0000_01b3));
            assert_eq!((seen.count(), hash), expected, "{count} points, 10^{power}");
        }
    }
}

#[test]
fn a_fixed_radius_is_worse_on_dense_clouds() {
    let mesh = bunny();
    let points: Vec<Vector3<f64>> =
        sample_uniform(&mesh, 60_000, 1).unwrap().iter().map(|s| s.point.coords).collect();
    let view = View::Along(Vector3::new(-1.0, 0.0, 0.0));
    let fixed = visible_points(&points, view, Sharpness::Radius(10f64.powf(2.5))).unwrap();
    let automatic = visible_points(&points, view, Sharpness::default()).unwrap();
    assert!(automatic.radius > 2.0 * fixed.radius && automatic.count() > fixed.count());
}

#[test]
fn a_far_eye_sees_what_a_direction_shows() {
    let points = common::vase(4000, 0.0);
    let far = visible_points(&points, View::From(Vector3::x() * 1e4), Sharpness::default()).unwrap();
    let along = visible_points(&points, View::Along(-Vector3::x()), Sharpness::default()).unwrap();
    let different = far.visible.iter().zip(&along.visible).filter(|(a, b)| a != b).count();
    assert!(different < 40, "{different}");
}

#[test]
fn the_unit_and_the_origin_do_not_matter() {
    let points = common::vase(3000, 0.01);
    let view = View::Along(Vector3::new(1.0, 2.0, 0.5));
    let seen = visible_points(&points, view, Sharpness::default()).unwrap();
    let moved: Vec<_> = points.iter().map(|p| p * 1024.0 + Vector3::repeat(65536.0)).collect();
    let again = visible_points(&moved, view, Sharpness::default()).unwrap();
    assert!(seen.visible.iter().zip(&again.visible).filter(|(a, b)| a != b).count() < 5);
}

#[test]
fn odd_input() {
    let view = View::From(Vector3::zeros());
    let default = Sharpness::default();
    assert!(matches!(visible_points(&[], view, default), Err(Error::TooFewPoints { .. })));
    let nan = Vector3::repeat(f64::NAN);
    assert!(visible_points(&[nan], view, default).is_err());
    let seen = visible_points(&[nan, Vector3::x(), Vector3::x() * 2.0], view, default).unwrap();
    assert_eq!(seen.visible, [false, true, false]);
    // A view from one of the points, of one point, of points in a plane through the eye.
    assert_eq!(visible_points(&[Vector3::zeros()], view, default).unwrap().count(), 0);
    assert_eq!(visible_points(&[Vector3::x()], View::Along(Vector3::y()), default).unwrap().count(), 1);
    let flat: Vec<_> = (0..300).map(common::scattered).map(|[a, b]| Vector3::new(a, b, 0.0)).collect();
    assert!(visible_points(&flat, View::From(Vector3::new(-3.0, 0.0, 0.0)), default).unwrap().count() > 5);
    assert_eq!(visible_points(&flat, View::Along(Vector3::z()), default).unwrap().count(), 300);
    assert!(visible_points(&flat, View::Along(Vector3::zeros()), default).is_err());
    assert!(visible_points(&flat, view, Sharpness::Radius(-1.0)).is_err());
}
