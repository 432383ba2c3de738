//! Tessellations keep their tolerance, close where the surface closes, and have no degenerate triangles.

#![allow(clippy::unwrap_used, reason = "a failed construction is a failed test")]

use nalgebra::{Vector2, Vector3};
use nurbs_core::{
    BsplineCurve, BsplineSurface, Cone, Cylinder, Error, Frame, Interval, KnotVector, ParametricCurve,
    ParametricSurface, Sphere, Tessellation, TessellationOptions, Torus,
};
use std::collections::HashMap;

fn wavy() -> BsplineSurface {
    let knots_u = KnotVector::new(3, vec![0., 0., 0., 0., 0.2, 0.7, 1., 1., 1., 1.]).unwrap();
    let knots_v = KnotVector::uniform_clamped(2, 5).unwrap();
    let z = |i: usize, j: usize| ((i * 7 + j * 5) % 4) as f64 * 0.3;
    let points = (0..30).map(|k| Vector3::new((k / 5) as f64, (k % 5) as f64, z(k / 5, k % 5))).collect();
    BsplineSurface::new(knots_u, knots_v, points, None).unwrap()
}

/// Distance of a point from a triangle.
fn distance(p: &Vector3<f64>, [a, b, c]: [Vector3<f64>; 3]) -> f64 {
    let segment = |s: Vector3<f64>, e: Vector3<f64>| {
        let t = ((p - s).dot(&(e - s)) / (e - s).norm_squared()).clamp(0.0, 1.0);
        (p - s - (e - s) * t).norm()
    };
    let n = (b - a).cross(&(c - a));
    let inside = [(a, b), (b, c), (c, a)].iter().all(|(s, e)| n.dot(&(e - s).cross(&(p - s))) >= 0.0);
    let edges = segment(a, b).min(segment(b, c)).min(segment(c, a));
    if inside { edges.min(((p - a).dot(&n) / n.norm()).abs()) } else { edges }
}

fn check(surface: &BsplineSurface, mesh: &Tessellation, tolerance: f64) {
    let corners: Vec<_> = mesh.triangles.iter().map(|t| t.map(|k| mesh.vertices[k as usize])).collect();
    let [u, v] = surface.domain();
    let n = 37;
    for i in 0..=n {
        for j in 0..=n {
            let p = surface.point(u.lerp(i as f64 / n as f64), v.lerp(j as f64 / n as f64));
            let nearest = corners.iter().map(|t| distance(&p, *t)).fold(f64::INFINITY, f64::min);
            assert!(nearest <= tolerance, "{nearest} at {i} {j}");
        }
    }
    for (t, [a, b, c]) in mesh.triangles.iter().zip(&corners) {
        let normal = (b - a).cross(&(c - a));
        assert!(normal.norm() > 1e-12, "degenerate: {t:?}");
        let mean: Vector3<f64> = t.iter().map(|&k| mesh.normals[k as usize]).sum();
        assert!(normal.dot(&mean) > 0.0, "turned: {t:?}");
    }
    for ((p, normal), [a, b]) in mesh.vertices.iter().zip(&mesh.normals).zip(&mesh.parameters) {
        assert!((normal.norm() - 1.0).abs() < 1e-12);
        assert!((surface.point(*a, *b) - p).norm() < 1e-12);
    }
}

/// Edges that belong to one triangle only, and whether all others belong to two of opposite direction.
fn boundary(mesh: &Tessellation) -> usize {
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    for t in &mesh.triangles {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            assert!(edges.insert((a, b), 1).is_none(), "edge used twice in one direction");
        }
    }
    edges.keys().filter(|(a, b)| !edges.contains_key(&(*b, *a))).count()
}

#[test]
fn surfaces_keep_the_tolerance() {
    for tolerance in [0.1, 0.01] {
        let options = TessellationOptions::new(tolerance);
        let f = Frame::from_axis(Vector3::new(1.0, 2.0, 3.0), Vector3::new(1.0, 1.0, 0.2)).unwrap();
        let sphere = Sphere::new(f, 1.0).unwrap().to_nurbs().unwrap();
        let torus = Torus::new(f, 1.0, 0.4).unwrap().to_nurbs().unwrap();
        let cylinder = Cylinder::new(f, 1.0, Interval::UNIT).unwrap().to_nurbs().unwrap();
        let cone = Cone::new(f, 1.0, 0.0, 2.0).unwrap().to_nurbs().unwrap();
        for (surface, closed) in
            [(&sphere, true), (&torus, true), (&cylinder, false), (&cone, false), (&wavy(), false)]
        {
            let mesh = surface.tessellate(&options).unwrap();
            check(surface, &mesh, tolerance);
            assert_eq!(boundary(&mesh) == 0, closed);
        }
        // V − E + F = 2 of a closed sphere with E = 3 F / 2.
        let mesh = sphere.tessellate(&options).unwrap();
        assert_eq!(mesh.vertices.len() - mesh.triangles.len() / 2, 2);
        let loose = sphere.tessellate(&options.with_weld(false)).unwrap();
        check(&sphere, &loose, tolerance);
        assert!(loose.vertices.len() > mesh.vertices.len() && loose.triangles.len() == mesh.triangles.len());
    }
}

#[test]
fn the_number_of_cells_is_no_more_than_twice_what_a_circle_needs() {
    let cylinder = Cylinder::new(Frame::WORLD, 1.0, Interval::UNIT).unwrap().to_nurbs().unwrap();
    let tolerance = 1e-4;
    let mesh = cylinder.tessellate(&TessellationOptions::new(tolerance)).unwrap();
    let needed = std::f64::consts::PI / (1.0 - tolerance).acos();
    assert!((mesh.triangles.len() as f64) < 2.0 * 2.0 * needed, "{} {needed}", mesh.triangles.len());
}

#[test]
fn curves_keep_the_tolerance() {
    let points: Vec<_> = [(0., 0.), (1., 3.), (2., -3.), (3., 3.), (5., 0.), (5., 0.)]
        .map(|(x, y)| Vector2::new(x, y))
        .to_vec();
    let weights = vec![1.0, 2.0, 0.5, 4.0, 1.0, 1.0];
    let curve = BsplineCurve::new(KnotVector::uniform_clamped(3, 6).unwrap(), points, Some(weights)).unwrap();
    for tolerance in [0.3, 1e-3, 1e-6] {
        let line = curve.tessellate(&TessellationOptions::new(tolerance)).unwrap();
        for k in 1..line.points.len() {
            let (a, b) = (line.points[k - 1], line.points[k]);
            assert!((curve.point(line.parameters[k]) - b).norm() < 1e-12);
            for i in 0..=20 {
                let t = line.parameters[k - 1]
                    + (line.parameters[k] - line.parameters[k - 1]) * f64::from(i) / 20.0;
                let p = curve.point(t);
                let s = ((p - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
                assert!((p - a - (b - a) * s).norm() <= tolerance + 1e-14);
            }
        }
        let limit = TessellationOptions::new(tolerance).with_max_vertices(3);
        assert!(matches!(curve.tessellate(&limit), Err(Error::Argument { .. })));
    }
    assert!(curve.tessellate(&TessellationOptions::new(f64::NAN)).is_err());
    assert!(wavy().tessellate(&TessellationOptions::new(1e-9)).is_err());
    assert!(wavy().tessellate(&TessellationOptions::new(0.0)).is_err());
}
