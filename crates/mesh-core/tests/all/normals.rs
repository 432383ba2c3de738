//! Normals of meshes and clouds against closed forms.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

use crate::shapes::{bunny, octasphere, sphere, torus, torus_normal};
use mesh_core::nalgebra::{Point3, Vector3};
use mesh_core::{Error, NormalOptions, Orientation, TriangleMesh, estimate_normals, orient_consistently};

#[test]
fn of_a_cube_and_of_bad_meshes() {
    let corner = |i: u32| Point3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1));
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut triangles: Vec<[u32; 3]> =
        quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let mut vertices: Vec<_> = (0..8).map(corner).collect();
    // A triangle without area, one that is not finite, and a vertex of no triangle.
    vertices.extend([Point3::new(f64::INFINITY, 0.0, 0.0), Point3::new(0.5, 0.5, 0.5)]);
    triangles.extend([[0, 1, 1], [0, 1, 8]]);
    let mesh = TriangleMesh::new(vertices, triangles).unwrap();
    let faces = mesh.face_normals();
    assert_eq!((faces.undefined, faces.normals[0]), (2, -Vector3::z()));
    let normals = mesh.vertex_normals();
    assert_eq!(normals.undefined, 2);
    // Whatever the diagonals of the quads are, the corner's normal is the diagonal of the cube.
    for (vertex, normal) in mesh.vertices().iter().zip(&normals.normals).take(8) {
        let expected = (vertex.coords - Vector3::repeat(0.5)).normalize();
        assert!((normal - expected).norm() < 1e-15);
    }
}

#[test]
fn of_the_vertices_of_a_sphere() {
    for (levels, bound) in [(3, 0.025), (4, 0.0125), (5, 0.00625)] {
        let mesh = octasphere(levels);
        let normals = mesh.vertex_normals();
        assert_eq!(normals.undefined, 0);
        let worst = mesh
            .vertices()
            .iter()
            .zip(&normals.normals)
            .map(|(v, n)| (v.coords - n).norm())
            .fold(0.0, f64::max);
        assert!(worst < bound, "{levels}: {worst}");
    }
}

#[test]
fn of_clouds_are_oriented_outwards() {
    let options = NormalOptions::default();
    for shift in [Vector3::zeros(), Vector3::new(4e6, -5e6, 1e6)] {
        let cloud: Vec<_> = sphere(4000).iter().map(|p| p + shift).collect();
        let estimate = estimate_normals(&cloud, &options).unwrap();
        assert_eq!((estimate.undefined, estimate.components), (0, 1));
        let worst = (sphere(4000).iter().zip(&estimate.normals))
            .map(|(p, n)| (p.coords - n).norm())
            .fold(0.0, f64::max);
        assert!(worst < 0.02, "{worst}");
    }
    let (mesh, parameters) = torus(0.5, 120, 40, 0.7);
    let estimate = estimate_normals(mesh.vertices(), &options).unwrap();
    assert_eq!(estimate.components, 1);
    for (&[u, v], normal) in parameters.iter().zip(&estimate.normals) {
        assert!((torus_normal(u, v) - normal).norm() < 0.1, "{u} {v}");
    }
}

#[test]
fn every_piece_is_oriented() {
    // Two spheres far apart; the normals given are turned at random.
    let mut cloud = sphere(1000);
    cloud.extend(sphere(1000).iter().map(|p| p + Vector3::new(10.0, 0.0, 0.0)));
    let expected: Vec<_> = sphere(1000).iter().chain(&sphere(1000)).map(|p| p.coords).collect();
    let mut normals: Vec<_> =
        expected.iter().enumerate().map(|(i, n)| if i * i % 7 < 3 { -n } else { *n }).collect();
    normals[17] = Vector3::zeros();
    assert_eq!(orient_consistently(&cloud, &mut normals, 6), Ok(2));
    assert_eq!(normals[17], Vector3::zeros());
    assert!(normals.iter().zip(&expected).enumerate().all(|(i, (n, e))| i == 17 || n == e));
}

#[test]
fn thin_walls_have_two_sides() {
    // Where the ellipsoid is thin, neighbours across it are as near as those along it.
    let radii = Vector3::new(1.0, 1.0, 0.08);
    let cloud: Vec<_> = sphere(1000).iter().map(|p| Point3::from(p.coords.component_mul(&radii))).collect();
    let expected: Vec<_> =
        cloud.iter().map(|p| p.coords.component_div(&radii.component_mul(&radii)).normalize()).collect();
    let mut normals: Vec<_> =
        expected.iter().enumerate().map(|(i, n)| if i * i % 7 < 3 { -n } else { *n }).collect();
    assert_eq!(orient_consistently(&cloud, &mut normals, 10), Ok(1));
    let wrong = normals.iter().zip(&expected).filter(|(found, expected)| found != expected).count();
    assert_eq!(wrong, 0);
}

#[test]
fn of_the_bunny_agree_with_its_mesh() {
    let mesh = bunny();
    let estimate = estimate_normals(mesh.vertices(), &NormalOptions::default()).unwrap();
    let of_mesh = mesh.vertex_normals();
    // The mesh is coarse: at the edges of the ears a neighbourhood of 16 vertices is no longer a surface.
    let cosines: Vec<_> = estimate.normals.iter().zip(&of_mesh.normals).map(|(a, b)| a.dot(b)).collect();
    let count = |test: &dyn Fn(f64) -> bool| cosines.iter().filter(|&&cosine| test(cosine)).count();
    let (same, opposite) = (count(&|cosine| cosine > 0.5), count(&|cosine| cosine < -0.5));
    let known = mesh.vertices().len() - of_mesh.undefined;
    assert!(10 * same > 9 * known && 50 * opposite < known, "{same} same, {opposite} opposite of {known}");
}

#[test]
fn towards_a_view_point() {
    let cloud = sphere(500);
    let options = NormalOptions::default().with_orientation(Orientation::Towards(Point3::origin()));
    let estimate = estimate_normals(&cloud, &options).unwrap();
    assert!(cloud.iter().zip(&estimate.normals).all(|(p, n)| p.coords.dot(n) < -0.9));
    let nowhere = options.with_orientation(Orientation::Towards(Point3::new(0.0, f64::NAN, 0.0)));
    assert!(matches!(estimate_normals(&cloud, &nowhere), Err(Error::NonFinitePoint { .. })));
}

#[test]
fn degenerate_neighbourhoods_have_none() {
    let line: Vec<_> = (0..50u8).map(|i| Point3::new(1e6 + f64::from(i), 2.0 * f64::from(i), 3.0)).collect();
    let dot = vec![Point3::new(1.0, 2.0, 3.0); 50];
    let two = vec![Point3::origin(), Point3::new(1.0, 0.0, 0.0)];
    let odd = vec![Point3::new(f64::NAN, 0.0, 0.0); 50];
    let huge: Vec<_> = (0..9u8).map(|i| Point3::new(f64::from(i) * 1e300, 1e308, -1e308)).collect();
    for cloud in [vec![], line, dot, two, odd, huge] {
        let estimate = estimate_normals(&cloud, &NormalOptions::default()).unwrap();
        assert_eq!((estimate.undefined, estimate.components), (cloud.len(), 0));
        assert!(estimate.normals.iter().all(|n| *n == Vector3::zeros()));
    }
    let few = NormalOptions::default().with_neighbours(2);
    assert_eq!(estimate_normals(&[], &few), Err(Error::TooFew { what: "neighbours", count: 2, least: 3 }));
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let (mesh, _) = torus(0.5, 90, 40, 0.9);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| estimate_normals(mesh.vertices(), &NormalOptions::default()).unwrap())
    };
    let one = run(1);
    assert!([2, 3, 7].into_iter().all(|threads| run(threads) == one));
}
