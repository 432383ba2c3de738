//! Lines against meshes: closed forms, brute force, and no leaks at edges and corners.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use mesh_core::nalgebra::{Matrix3, Point3, Vector3};
use mesh_core::{Error, MeshProjector, TriangleMesh};
use proptest::prelude::*;

/// An octahedron with its corners on the axes, refined `levels` times onto the unit sphere.
fn sphere(levels: usize) -> TriangleMesh {
    let mut points: Vec<Vector3<f64>> =
        [Vector3::x(), Vector3::y(), Vector3::z()].iter().flat_map(|v| [*v, -v]).collect();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for (x, sx) in [(0u32, 1), (1, -1)] {
        for (y, sy) in [(2u32, 1), (3, -1)] {
            for (z, sz) in [(4u32, 1), (5, -1)] {
                triangles.push(if sx * sy * sz > 0 { [x, y, z] } else { [y, x, z] });
            }
        }
    }
    for _ in 0..levels {
        let mut finer = Vec::new();
        for [a, b, c] in triangles {
            let mut middle = |i: u32, j: u32| {
                points.push((points[i as usize] + points[j as usize]).normalize());
                u32::try_from(points.len() - 1).unwrap()
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    TriangleMesh::new(points.into_iter().map(Point3::from).collect(), triangles).unwrap()
}

/// All offsets at which the line meets a triangle, by Cramer's rule.
fn brute_force(mesh: &TriangleMesh, origin: &Point3<f64>, unit: &Vector3<f64>) -> Option<f64> {
    let offset = |index: usize| {
        let [a, b, c] = mesh.corners(index).unwrap();
        let matrix = Matrix3::from_columns(&[b - a, c - a, -unit]);
        let solution = matrix.lu().solve(&(origin - a))?;
        (solution.x >= 0.0 && solution.y >= 0.0 && solution.x + solution.y <= 1.0).then_some(solution.z)
    };
    (0..mesh.triangles().len()).filter_map(offset).min_by(|a, b| a.abs().total_cmp(&b.abs()))
}

#[test]
fn through_corners_and_edges_of_a_closed_mesh_nothing_leaks() {
    let mesh = sphere(3);
    let projector = MeshProjector::new(&mesh).unwrap();
    for &vertex in mesh.vertices() {
        let hit = projector.nearest_on_line(&Point3::origin(), &vertex.coords).unwrap().unwrap();
        assert!((hit.offset.abs() - 1.0).abs() < 1e-14);
        let outside = Point3::from(vertex.coords * 3.0);
        let hit = projector.nearest_on_line(&outside, &-vertex.coords).unwrap().unwrap();
        assert!((hit.offset - 2.0).abs() < 1e-14 && (hit.point - vertex).norm() < 1e-14);
    }
    for index in 0..mesh.triangles().len() {
        let [a, b, _] = mesh.corners(index).unwrap();
        let middle = Vector3::from(a.coords + b.coords) * 0.5;
        let hit = projector.nearest_on_line(&Point3::origin(), &middle).unwrap();
        assert!(hit.is_some_and(|hit| (hit.offset.abs() - middle.norm()).abs() < 1e-14), "{index}");
    }
}

#[test]
fn bad_lines_and_grazing_ones() {
    let projector = MeshProjector::new(&sphere(0)).unwrap();
    let nan = Point3::new(f64::NAN, 0.0, 0.0);
    assert!(matches!(projector.nearest_on_line(&nan, &Vector3::x()), Err(Error::NonFinitePoint { .. })));
    for direction in [Vector3::zeros(), Vector3::new(f64::INFINITY, 0.0, 0.0), Vector3::repeat(f64::NAN)] {
        assert!(projector.nearest_on_line(&Point3::origin(), &direction).is_err());
    }
    // Tiny and huge directions are as good as any.
    for size in [1e-300, 1e300] {
        let hit =
            projector.nearest_on_line(&Point3::new(0.1, 0.2, 5.0), &Vector3::new(0.0, 0.0, -size)).unwrap();
        assert!((hit.unwrap().offset - 4.3).abs() < 1e-14);
    }
    assert_eq!(projector.nearest_on_line(&Point3::new(5.0, 0.0, 0.0), &Vector3::z()).unwrap(), None);
}

proptest! {
    #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(3), ..ProptestConfig::with_cases(128) })]
    #[test]
    fn agrees_with_brute_force(o in prop::array::uniform3(-2.0..2.0f64), d in prop::array::uniform3(-1.0..1.0f64)) {
        prop_assume!(Vector3::from(d).norm() > 0.1);
        let mesh = sphere(2);
        let (origin, unit) = (Point3::from(o), Vector3::from(d).normalize());
        let hit = MeshProjector::new(&mesh).unwrap().nearest_on_line(&origin, &Vector3::from(d)).unwrap();
        match (hit, brute_force(&mesh, &origin, &unit)) {
            (Some(hit), Some(expected)) => {
                prop_assert!((hit.offset - expected).abs() < 1e-12);
                prop_assert!((origin + unit * hit.offset - hit.point).norm() < 1e-12);
            }
            (hit, expected) => prop_assert_eq!(hit.is_some(), expected.is_some()),
        }
    }
}
