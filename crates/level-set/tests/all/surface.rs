//! Level sets in space as meshes.

use distance_field::{Grid, LevelSetField, MlsField};
use level_set::Error;
use level_set::surface::{Crossing, dual_contour, mesh_of_cloud, of_field, remesh, surface_gap};
use mesh_core::{HalfEdgeMesh, TriangleMesh};
use nalgebra::{Point3, Vector3};

fn sampled(n: usize, f: impl Fn(&Vector3<f64>) -> f64) -> Grid<3> {
    Grid::sample(Vector3::repeat(-1.6), Vector3::repeat(3.2 / (n - 1) as f64), [n; 3], f).unwrap()
}

#[test]
fn a_torus_is_closed_and_near() {
    let grid = sampled(41, |p| (p.xy().norm() - 1.0).hypot(p.z) - 0.4);
    let field = LevelSetField::<3>::new(&grid).unwrap();
    let mesh = dual_contour(&grid, of_field(&field)).unwrap();
    let topology = mesh.topology();
    assert!(topology.is_solid(), "{topology:?}");
    assert_eq!(HalfEdgeMesh::new(&mesh).euler_characteristic(), 0);
    let volume = 2.0 * std::f64::consts::PI.powi(2) * 0.16;
    assert!((mesh.signed_volume() - volume).abs() < 0.03 * volume);
    let gap = surface_gap(&field, &mesh).unwrap();
    assert!(gap.forth < 0.1 * 0.08 && gap.back < 0.1 * 0.08, "{gap:?}");
}

/// A box from the exact distances and normals of its faces: edges and corners are where they are, to rounding.
#[test]
fn sharp_edges_are_kept() {
    let half = Vector3::new(1.03, 0.77, 0.51);
    let turned = nalgebra::Rotation3::from_euler_angles(0.3, 0.5, 0.2);
    let local = |p: &Vector3<f64>| turned.inverse() * p;
    let value = |p: &Vector3<f64>| (local(p).abs() - half).max();
    let normal = |p: &Vector3<f64>| {
        let p = local(p);
        let face = (p.abs() - half).imax();
        let mut n = Vector3::zeros();
        n[face] = p[face].signum();
        turned * n
    };
    let grid = sampled(33, value);
    let crossing = |a: &Vector3<f64>, b: &Vector3<f64>| {
        let (mut low, mut high) = (*a, *b);
        for _ in 0..60 {
            let middle = (low + high) * 0.5;
            if (value(&middle) < 0.0) == (value(a) < 0.0) { low = middle } else { high = middle }
        }
        Crossing { point: low, normal: normal(&low) }
    };
    let mesh = dual_contour(&grid, crossing).unwrap();
    assert!(mesh.topology().is_solid());
    let volume = 8.0 * half.x * half.y * half.z;
    assert!((mesh.signed_volume() - volume).abs() < 2e-3 * volume, "{} {volume}", mesh.signed_volume());
    // A corner is a vertex where its cell has crossings with all three faces, and nearly one elsewhere.
    let mut exact = 0;
    for corner in 0..8u32 {
        let sign = |k: u32| if corner >> k & 1 == 1 { 1.0 } else { -1.0 };
        let place = turned * half.component_mul(&Vector3::new(sign(0), sign(1), sign(2)));
        let near = mesh.vertices().iter().map(|v| (v.coords - place).norm()).fold(f64::INFINITY, f64::min);
        assert!(near < 0.05, "{corner}: {near}");
        exact += usize::from(near < 1e-9);
    }
    assert!(exact >= 4, "{exact}");
}

/// Noise makes cells of all kinds; the mesh stays a manifold.
#[test]
fn meshes_of_noise_are_manifolds() {
    let noise = |p: &Vector3<f64>| {
        if p.amax() > 1.4 {
            return 1.0;
        }
        (37.0 * p.x).sin()
            + (41.0 * p.y + 1.0).sin()
            + (43.0 * p.z + 2.0).sin()
            + (29.0 * (p.x + p.y - p.z)).cos()
    };
    let grid = sampled(25, noise);
    let field = LevelSetField::<3>::new(&grid).unwrap();
    let mesh = dual_contour(&grid, of_field(&field)).unwrap();
    let topology = mesh.topology();
    assert!(topology.boundary_edges == 0 && topology.inconsistent_edges == 0, "{topology:?}");
    // Two sheets of the same cells may run along one edge; no more than a few do.
    assert!(topology.non_manifold_edges * 200 < topology.edges, "{topology:?}");
}

#[test]
fn a_level_set_without_a_point_is_an_error() {
    let grid = sampled(5, |_| -1.0);
    let never = |a: &Vector3<f64>, _: &Vector3<f64>| Crossing { point: *a, normal: Vector3::x() };
    let error = dual_contour(&grid, never).unwrap_err();
    assert!(matches!(&error, Error::Empty { what } if what.contains("inside")), "{error}");
}

/// A cube with an edge cut off, from triangles to a grid and back.
#[test]
fn meshes_keep_their_edges_on_the_way_through_a_grid() {
    let point = |x: f64, y: f64, z: f64| Point3::new(x, y, z);
    // A prism over the square with the corner (1, 1) cut off.
    let outline = [(0.0, 0.0), (1.0, 0.0), (1.0, 0.6), (0.6, 1.0), (0.0, 1.0)];
    let vertices: Vec<_> =
        [0.0, 0.8].iter().flat_map(|&z| outline.iter().map(move |&(x, y)| point(x, y, z))).collect();
    let mut triangles = Vec::new();
    for k in 0..5u32 {
        let next = (k + 1) % 5;
        triangles.extend([[k, next, next + 5], [k, next + 5, k + 5]]);
    }
    for k in 1..4u32 {
        triangles.extend([[0, k + 1, k], [5, k + 5, k + 6]]);
    }
    let mesh = TriangleMesh::new(vertices, triangles).unwrap();
    let volume = 0.8 * (1.0 - 0.08);
    assert!((mesh.signed_volume() - volume).abs() < 1e-12);
    let found = remesh(&mesh, 28).unwrap();
    assert!(found.mesh.topology().is_solid());
    assert!((found.mesh.signed_volume() - volume).abs() < 2e-3 * volume, "{}", found.mesh.signed_volume());
    // Corners are where they were; triangles across an edge cut it by a part of a cell.
    assert!(found.back < 1e-6 * found.cell && found.forth < 0.25 * found.cell, "{found:?}");
    for bad in [0, 7, 2001] {
        assert!(matches!(remesh(&mesh, bad), Err(Error::Option { option: "grid", .. })));
    }
}

/// Even points of the unit sphere, above a height.
fn cap(count: u32, lowest: f64) -> (Vec<Point3<f64>>, Vec<Vector3<f64>>) {
    (0..count)
        .map(|i| {
            let (z, angle) =
                (1.0 - f64::from(2 * i + 1) / f64::from(count), 2.399_963_229_728_653 * f64::from(i));
            let ring = (1.0 - z * z).sqrt();
            Vector3::new(ring * angle.cos(), ring * angle.sin(), z)
        })
        .filter(|normal| normal.z > lowest)
        .map(|normal| (Point3::from(normal), normal))
        .unzip()
}

#[test]
fn a_closed_cloud_becomes_a_closed_mesh_and_an_open_one_ends_where_it_ends() {
    let (points, normals) = cap(4000, -2.0);
    let found = mesh_of_cloud(&points, &MlsField::new(&points, Some(&normals)).unwrap(), 40).unwrap();
    assert!(found.mesh.topology().is_closed());
    assert!((found.mesh.signed_volume() - 4.18879).abs() < 0.01, "{}", found.mesh.signed_volume());
    assert!(found.mesh.vertices().iter().all(|p| (p.coords.norm() - 1.0).abs() < 1e-6));
    assert!(found.back < 2e-3, "{}", found.back);

    let (points, normals) = cap(4000, 0.3);
    let found = mesh_of_cloud(&points, &MlsField::new(&points, Some(&normals)).unwrap(), 40).unwrap();
    assert!(!found.mesh.topology().is_closed());
    // As far as the points, less than two spacings (0.056) and a cell (0.06) further.
    let lowest = found.mesh.vertices().iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
    assert!(lowest > 0.2 && lowest < 0.4, "{lowest}");
    assert!(found.forth < 0.1 && found.back < 0.1, "{} {}", found.forth, found.back);
    assert!(mesh_of_cloud(&points, &MlsField::new(&points, None).unwrap(), 3).is_err());
}
