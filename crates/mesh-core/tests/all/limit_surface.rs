//! The exact limit of Loop's scheme against deep subdivision.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a set-up that fails must fail the test")]

use crate::shapes::{octasphere, spread, torus};
use mesh_core::nalgebra::{Point3, Vector3};
use mesh_core::{Error, LoopScheme, LoopSurface, TriangleMesh};

fn scattered(vertices: usize) -> Vec<Point3<f64>> {
    (0..vertices)
        .map(|k| Point3::new(spread(k, 0.754_877), spread(k * k, 0.569_84), spread(k, 0.618_034)))
        .collect()
}

fn tetrahedron() -> TriangleMesh {
    TriangleMesh::new(scattered(4), vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]).unwrap()
}

/// A closed strip around an axis with a pole of `n` neighbours at each end: corners of 3 and more neighbours.
fn spindle(n: u32) -> TriangleMesh {
    let ring = |k: u32| (0..n).map(move |i| (k, std::f64::consts::TAU * f64::from(i) / f64::from(n)));
    let mut vertices = vec![Point3::new(0.0, 0.0, -1.5)];
    for (k, angle) in (0..3).flat_map(ring) {
        let radius = [0.8, 1.3, 0.7][k as usize] + 0.2 * spread(vertices.len(), 0.377);
        vertices.push(Point3::new(radius * angle.cos(), radius * angle.sin(), f64::from(k) - 1.0));
    }
    vertices.push(Point3::new(0.1, 0.0, 1.4));
    let at = |k: u32, i: u32| 1 + k * n + i % n;
    let mut triangles = Vec::new();
    for i in 0..n {
        triangles.push([0, at(0, i + 1), at(0, i)]);
        for k in 0..2 {
            triangles.push([at(k, i), at(k, i + 1), at(k + 1, i)]);
            triangles.push([at(k, i + 1), at(k + 1, i + 1), at(k + 1, i)]);
        }
        triangles.push([3 * n + 1, at(2, i), at(2, i + 1)]);
    }
    TriangleMesh::new(vertices, triangles).unwrap()
}

/// A sheet with a boundary: regular along its sides, irregular at its corners, with a dent of other valences inside.
fn sheet() -> TriangleMesh {
    let n = 4u32;
    let at = |i: u32, j: u32| i * (n + 1) + j;
    let vertices = (0..(n + 1) * (n + 1))
        .map(|k| (f64::from(k / (n + 1)), f64::from(k % (n + 1)), 0.4 * spread(k as usize, 0.754_877)))
        .map(|(x, y, z)| Point3::new(x, y, z))
        .collect();
    let triangles = (0..n * n)
        .map(|k| (k / n, k % n))
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            // One square is cut the other way.
            if (i, j) == (1, 1) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
        })
        .collect();
    TriangleMesh::new(vertices, triangles).unwrap()
}

fn shapes() -> Vec<(&'static str, TriangleMesh)> {
    vec![
        ("tetrahedron", tetrahedron()),
        ("octahedron", octasphere(0)),
        ("spindle of 3", spindle(3)),
        ("spindle of 5", spindle(5)),
        ("spindle of 9", spindle(9)),
        ("torus", torus(0.4, 7, 5, 0.2).0),
        ("sheet", sheet()),
        ("triangle", TriangleMesh::new(scattered(3), vec![[0, 1, 2]]).unwrap()),
    ]
}

/// The barycentric coordinates, in the control triangle, of the corners of each triangle after `levels` divisions.
fn corners_after(levels: u32, triangle: usize) -> (usize, [[f64; 2]; 3]) {
    let mut corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let mut path = Vec::new();
    let mut index = triangle;
    for _ in 0..levels {
        path.push(index % 4);
        index /= 4;
    }
    for child in path.into_iter().rev() {
        let [a, b, c] = corners;
        let middle = |p: [f64; 2], q: [f64; 2]| [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        corners = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]][child];
    }
    (index, corners)
}

#[test]
fn points_are_those_of_deep_subdivision() {
    for (name, mesh) in shapes() {
        let surface = LoopSurface::new(&mesh).unwrap();
        let mut fine = mesh;
        for levels in 0..4 {
            let scheme = LoopScheme::new(&fine);
            for (index, triangle) in fine.triangles().iter().enumerate() {
                let (face, places) = corners_after(levels, index);
                for (&vertex, place) in triangle.iter().zip(places) {
                    let limit = scheme.limit(vertex).unwrap();
                    let jet = surface.jet(face, place).unwrap();
                    let gap = (jet.position - limit.position).norm();
                    // Irregular vertices themselves are evaluated beside.
                    let control = place.iter().all(|x| *x == 0.0 || *x == 1.0);
                    assert!(
                        gap < if control { 1e-11 } else { 1e-13 },
                        "{name} {levels} {face} {place:?}: {gap}"
                    );
                    let normal = jet.first[0].cross(&jet.first[1]);
                    if let Some(other) = limit.normal.filter(|_| !control) {
                        let turn = (normal.normalize() - other).norm();
                        assert!(turn < 1e-11, "{name} {levels} {face} {place:?}: {turn}");
                    }
                }
            }
            fine = scheme.subdivide().unwrap();
        }
    }
}

#[test]
fn derivatives_agree_with_differences_and_across_edges() {
    for (name, mesh) in shapes() {
        let surface = LoopSurface::new(&mesh).unwrap();
        for face in 0..surface.triangles().len() {
            for (v, w) in [(0.31, 0.24), (0.6, 0.3), (0.12, 0.1), (0.05, 0.9)] {
                let h = 1e-5;
                let at = |a: f64, b: f64| surface.jet(face, [v + a * h, w + b * h]).unwrap();
                let (jet, [a, b, c, d]) = (at(0.0, 0.0), [at(1., 0.), at(-1., 0.), at(0., 1.), at(0., -1.)]);
                let slope = |one: Vector3<f64>, other: Vector3<f64>| (one - other) / (2.0 * h);
                let scale = 1.0 + jet.second.iter().map(|s| s.norm()).fold(0.0, f64::max);
                assert!(
                    (slope(a.position.coords, b.position.coords) - jet.first[0]).norm() < 1e-7 * scale,
                    "{name}"
                );
                assert!(
                    (slope(c.position.coords, d.position.coords) - jet.first[1]).norm() < 1e-7 * scale,
                    "{name}"
                );
                assert!((slope(a.first[0], b.first[0]) - jet.second[0]).norm() < 1e-6 * scale, "{name}");
                assert!((slope(c.first[0], d.first[0]) - jet.second[1]).norm() < 1e-6 * scale, "{name}");
                assert!((slope(c.first[1], d.first[1]) - jet.second[2]).norm() < 1e-6 * scale, "{name}");
            }
        }
    }
}

#[test]
fn affine_maps_go_through() {
    let mesh = spindle(7);
    let map = |p: &Point3<f64>| Point3::new(1e3 + 2.0 * p.x - p.y, p.y + 0.3 * p.z, p.x - 4.0 * p.z);
    let mut moved = LoopSurface::new(&mesh).unwrap();
    let still = moved.clone();
    moved.set_positions(&still.positions().iter().map(map).collect::<Vec<_>>()).unwrap();
    for face in 0..still.triangles().len() {
        for place in [[0.2, 0.3], [0.0, 0.0], [0.5, 0.5], [1e-9, 1e-10]] {
            let [a, b] = [&still, &moved].map(|surface| surface.jet(face, place).unwrap().position);
            assert!((map(&a) - b).norm() < 1e-11, "{face} {place:?}");
        }
    }
    assert!(moved.set_positions(&[]).is_err());
}

#[test]
fn places_at_corners_and_outside_are_no_accident() {
    let surface = LoopSurface::new(&tetrahedron()).unwrap();
    for place in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [-0.1, 0.3], [f64::NAN, 0.2], [1e-300, 0.0]] {
        assert!(surface.jet(0, place).is_some());
    }
    assert!(surface.jet(4, [0.3, 0.3]).is_none());
    let mut out = vec![[1.0; 6]];
    surface.weights(4, [0.3, 0.3], &mut out);
    assert!(out.is_empty());
}

#[test]
fn meshes_without_a_limit_are_refused() {
    let points = scattered(5);
    let three = TriangleMesh::new(points.clone(), vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]]).unwrap();
    assert!(matches!(LoopSurface::new(&three), Err(Error::Subdivision { .. })));
    let pillow = TriangleMesh::new(points, vec![[0, 1, 2], [0, 2, 1]]).unwrap();
    assert!(matches!(LoopSurface::new(&pillow), Err(Error::Subdivision { .. })));
}
