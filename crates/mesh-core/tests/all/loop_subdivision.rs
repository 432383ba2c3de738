//! Loop subdivision and its limits.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

use crate::shapes::{bunny, octasphere, spread, torus};
use mesh_core::nalgebra::{Point3, Vector3};
use mesh_core::{HalfEdgeMesh, LoopScheme, TriangleMesh};

/// Part of the triangular lattice: `n × n` rhombi, and a function over it.
fn lattice(n: u32, height: impl Fn(f64, f64) -> f64) -> TriangleMesh {
    let at = |i: u32, j: u32| i * (n + 1) + j;
    let vertices = (0..(n + 1) * (n + 1))
        .map(|k| (f64::from(k / (n + 1)), f64::from(k % (n + 1))))
        .map(|(i, j)| (i + 0.5 * j, j * 0.75f64.sqrt()))
        .map(|(x, y)| Point3::new(x, y, height(x, y)))
        .collect();
    let triangles = (0..n * n)
        .map(|k| (k / n, k % n))
        .flat_map(|(i, j)| {
            [[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]]
        })
        .collect();
    TriangleMesh::new(vertices, triangles).unwrap()
}

/// A fan of `n` triangles around vertex 0, closed or open, with a second ring of scattered heights.
fn fan(n: u32, closed: bool) -> TriangleMesh {
    let rim = if closed { n } else { n + 1 };
    let at = |i: u32| 1 + i % rim;
    let angle = |i: u32| {
        if closed {
            std::f64::consts::TAU * f64::from(i) / f64::from(n)
        } else {
            3.0 * f64::from(i) / f64::from(n)
        }
    };
    let mut vertices = vec![Point3::new(0.1, -0.05, 0.3)];
    for ring in [1.0, 2.0] {
        for i in 0..rim {
            let k = vertices.len();
            let radius = ring + 0.3 * spread(k, 0.754_877);
            vertices.push(Point3::new(
                radius * angle(i).cos(),
                radius * angle(i).sin(),
                0.5 * spread(k * k, 0.569_84),
            ));
        }
    }
    let mut triangles: Vec<[u32; 3]> = (0..n).map(|i| [0, at(i), at(i + 1)]).collect();
    for i in 0..n {
        triangles.push([at(i), rim + at(i), at(i + 1)]);
        triangles.push([at(i + 1), rim + at(i), rim + at(i + 1)]);
    }
    TriangleMesh::new(vertices, triangles).unwrap()
}

#[test]
fn regular_limits_are_those_of_the_box_spline() {
    // The box spline has the covariance 1/4 of the identity: limits of quadratic data are the data plus their mean over
    // it, and gradients those of the data.
    let quadratic = |x: f64, y: f64| 0.7 * x * x - 1.3 * x * y + 0.4 * y * y + 2.0 * x - y + 5.0;
    let mesh = lattice(4, quadratic);
    let scheme = LoopScheme::new(&mesh);
    let centre = mesh.vertices()[12];
    let limit = scheme.limit(12).unwrap();
    assert!((limit.position - centre - Vector3::new(0.0, 0.0, 0.25 * (0.7 + 0.4))).norm() < 1e-14);
    let gradient = [1.4 * centre.x - 1.3 * centre.y + 2.0, -1.3 * centre.x + 0.8 * centre.y - 1.0];
    let normal = Vector3::new(-gradient[0], -gradient[1], 1.0).normalize();
    assert!((limit.normal.unwrap() - normal).norm() < 1e-14);
    let weights: Vec<f64> = scheme.limit_mask(12).unwrap().iter().map(|&(_, weight)| weight).collect();
    assert!((weights[0] - 0.5).abs() < 1e-15 && weights[1..].iter().all(|w| (w - 1.0 / 12.0).abs() < 1e-15));
}

/// Limits do not change by subdivision: position to rounding, tangents in direction.
fn limits_are_invariant(mesh: &TriangleMesh) {
    let coarse = LoopScheme::new(mesh);
    let fine = LoopScheme::new(&coarse.subdivide().unwrap());
    for vertex in (0u32..).take(mesh.vertices().len()) {
        let (one, other) = (coarse.limit(vertex).unwrap(), fine.limit(vertex).unwrap());
        assert!((one.position - other.position).norm() < 1e-13, "{vertex}: {one:?} {other:?}");
        let Some(normal) = one.normal else { continue };
        assert!((normal - other.normal.unwrap()).norm() < 1e-10, "{vertex}: {one:?} {other:?}");
        if coarse.connectivity().is_boundary(vertex) {
            assert!(one.tangents[0].normalize().dot(&other.tangents[0].normalize()) > 1.0 - 1e-12);
        }
    }
}

#[test]
fn limits_are_eigenvectors() {
    for n in 3..12 {
        limits_are_invariant(&fan(n, true));
    }
    for n in 1..9 {
        limits_are_invariant(&fan(n, false));
    }
    limits_are_invariant(&lattice(3, |x, y| (x * y).sin()));
    limits_are_invariant(&bunny());
    limits_are_invariant(&torus(0.7, 12, 7, 0.6).0);
}

#[test]
fn deep_subdivision_converges_to_the_limits() {
    for mesh in [fan(5, true), fan(7, true), fan(1, false), fan(2, false), fan(3, false), fan(6, false)] {
        let limits = LoopScheme::new(&mesh).limits();
        let mut fine = mesh.clone();
        let mut errors = Vec::new();
        for _ in 0..6 {
            let worst =
                limits.iter().zip(fine.vertices()).map(|(l, v)| (l.position - v).norm()).fold(0.0, f64::max);
            errors.push(worst);
            fine = LoopScheme::new(&fine).subdivide().unwrap();
        }
        assert!(errors[5] < 0.05 * errors[1] && errors[5] < 3e-3, "{errors:?}");
        // Normals of the faces around a vertex tend to that of the limit.
        let normal = fine.vertex_normals().normals[0];
        assert!(normal.dot(&limits[0].normal.unwrap()) > 0.995, "{normal} {:?}", limits[0]);
    }
}

#[test]
fn keeps_the_topology() {
    for mesh in [octasphere(1), torus(0.7, 9, 6, 0.3).0, lattice(3, |_, _| 0.0), fan(4, false)] {
        let fine = LoopScheme::new(&mesh).subdivide().unwrap();
        let (one, other) = (HalfEdgeMesh::new(&mesh), HalfEdgeMesh::new(&fine));
        assert_eq!(fine.triangles().len(), 4 * mesh.triangles().len());
        assert!(other.defects().is_empty());
        assert_eq!(one.euler_characteristic(), other.euler_characteristic());
        assert_eq!(one.boundary_loops().len(), other.boundary_loops().len());
        let outside = fine.face_normals();
        assert_eq!(outside.undefined, 0);
    }
    let sphere = LoopScheme::new(&octasphere(3));
    assert!(sphere.limits().iter().all(|l| l.normal.unwrap().dot(&l.position.coords.normalize()) > 0.999));
    // Unshared vertices count as one.
    let soup: Vec<Point3<f64>> = (0..8).flat_map(|t| octasphere(0).corners(t).unwrap()).collect();
    let soup = TriangleMesh::new(soup, (0..8).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect()).unwrap();
    assert!(LoopScheme::new(&soup).subdivide().unwrap().welded_topology().is_solid());
}

#[test]
fn defects_stay_where_they_are() {
    let p = |x: f64, y: f64, z: f64| Point3::new(x, y, z);
    let vertices = vec![
        p(0.0, 0.0, 0.0),
        p(1.0, 0.0, 0.0),
        p(0.0, 1.0, 0.0),
        p(0.0, -1.0, 0.0),
        p(0.0, 0.0, 1.0),
        p(f64::NAN, 0.0, 0.0),
    ];
    let mesh = TriangleMesh::new(vertices, vec![[0, 1, 2], [1, 0, 3], [0, 1, 4], [2, 2, 1]]).unwrap();
    let scheme = LoopScheme::new(&mesh);
    let fine = scheme.subdivide().unwrap();
    assert_eq!((fine.triangles().len(), fine.vertices().len()), (12, 6 + 7));
    assert_eq!(fine.vertices()[..2], mesh.vertices()[..2]);
    assert_eq!(scheme.limit(0).unwrap().position, mesh.vertices()[0]);
    assert_eq!(HalfEdgeMesh::new(&fine).defects().non_manifold_edges.len(), 2);
    assert!(scheme.limit(99).is_none() && scheme.tangent_masks(0).is_none());
    let empty = TriangleMesh::new(vec![], vec![]).unwrap();
    assert_eq!(LoopScheme::new(&empty).subdivide().unwrap(), empty);
}
