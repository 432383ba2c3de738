//! Closest points and crossings among triangles that face a direction, against all triangles one by one.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use mesh_core::{Feature, MeshProjector, TriangleMesh};
use nalgebra::{Point3, Vector3};

/// Numbers that look random and are the same in every run.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| 2.0 * self.next() - 1.0)
    }
}

fn soup(numbers: &mut Numbers, count: u32) -> TriangleMesh {
    let corners = (0..count).flat_map(|_| {
        let centre = numbers.vector();
        [0, 1, 2].map(|_| Point3::from(centre + numbers.vector() * 0.2))
    });
    let corners = corners.collect();
    TriangleMesh::new(corners, (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect()).unwrap()
}

fn normal(mesh: &TriangleMesh, triangle: usize) -> Vector3<f64> {
    let [a, b, c] = mesh.triangles()[triangle].map(|corner| mesh.vertices()[corner as usize]);
    (b - a).cross(&(c - a)).normalize()
}

/// Each triangle as a mesh of its own.
fn apart(mesh: &TriangleMesh) -> Vec<MeshProjector> {
    let alone = |corners: &[u32; 3]| {
        let corners = corners.map(|corner| mesh.vertices()[corner as usize]);
        MeshProjector::new(&TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2]]).unwrap()).unwrap()
    };
    mesh.triangles().iter().map(alone).collect()
}

#[test]
fn the_nearest_triangle_that_agrees_is_found() {
    let mut numbers = Numbers(5);
    let mesh = soup(&mut numbers, 400);
    let (projector, apart) = (MeshProjector::new(&mesh).unwrap(), apart(&mesh));
    let mut others = 0;
    for max_angle in [0.3f64, 1.0, std::f64::consts::FRAC_PI_2, 2.5] {
        for _ in 0..60 {
            let (x, direction) = (Point3::from(numbers.vector() * 1.5), numbers.vector().normalize());
            let agrees = |triangle: usize| normal(&mesh, triangle).dot(&direction) >= max_angle.cos();
            let wanted = (0..400).filter(|&t| agrees(t));
            let feet = wanted.map(|t| (t, apart[t].project(&x).unwrap().distance));
            let best = feet.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
            let found = projector.project_facing(&x, &direction, max_angle).unwrap().unwrap();
            assert_eq!((found.foot.triangle, found.foot.distance), best, "{max_angle}");
            let nearest = projector.project(&x).unwrap();
            assert_eq!(found.is_nearest, nearest.distance == found.foot.distance);
            others += usize::from(!found.is_nearest);
            let again = if found.is_nearest {
                projector.normal_at(found.foot.triangle, found.foot.feature, &found.foot.point)
            } else if found.foot.feature == Feature::Face {
                projector.face_normal(found.foot.triangle)
            } else {
                projector.facing_normal(&found.foot.point, &direction, max_angle)
            };
            assert_eq!(again, found.foot.normal);

            let line = numbers.vector();
            let hits = (0..400).filter(|&t| agrees(t));
            let hits =
                hits.filter_map(|t| Some((t, apart[t].nearest_on_line(&x, &line).unwrap()?.offset.abs())));
            let best = hits.min_by(|a, b| a.1.total_cmp(&b.1));
            let found = projector.nearest_on_line_facing(&x, &line, &direction, max_angle).unwrap();
            assert_eq!(found.map(|hit| (hit.triangle, hit.offset.abs())), best, "{max_angle}");
        }
    }
    assert!(others > 50, "{others}");
}

#[test]
fn no_triangle_need_agree() {
    let corners = vec![Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 0.0)];
    let mesh = MeshProjector::new(&TriangleMesh::new(corners, vec![[0, 1, 2], [0, 1, 1]]).unwrap()).unwrap();
    let x = Point3::new(0.2, 0.2, 1.0);
    assert_eq!(mesh.project_facing(&x, &-Vector3::z(), 1.5).unwrap(), None);
    assert_eq!(mesh.nearest_on_line_facing(&x, &Vector3::z(), &-Vector3::z(), 1.5).unwrap(), None);
    // Upright is no longer within a right angle.
    assert_eq!(mesh.project_facing(&x, &Vector3::x(), std::f64::consts::FRAC_PI_2).unwrap(), None);
    assert!(mesh.project_facing(&Point3::new(f64::NAN, 0.0, 0.0), &Vector3::z(), 1.0).is_err());
}

/// On the edge of a box the faces on both sides count, and the answer is that of the whole mesh.
#[test]
fn on_an_edge_any_face_will_do() {
    let at = |i: u8| Point3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]];
    let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let cube = MeshProjector::new(&TriangleMesh::new((0..8).map(at).collect(), faces).unwrap()).unwrap();
    assert!(cube.is_solid());
    let x = Point3::new(1.5, 0.3, 1.25);
    for direction in [Vector3::x(), Vector3::z()] {
        let found = cube.project_facing(&x, &direction, 0.1).unwrap().unwrap();
        assert!(found.is_nearest);
        assert_eq!(found.foot, cube.project(&x).unwrap());
    }
    let found = cube.project_facing(&x, &Vector3::y(), 0.1).unwrap().unwrap();
    assert_eq!((found.foot.point, found.is_nearest), (Point3::new(1.0, 1.0, 1.0), false));
    // Below the plane of the face that counts.
    assert!(found.foot.signed_distance.unwrap() < 0.0 && found.foot.normal == Vector3::y());
}
