//! Offsets against closed forms and differences.

#![allow(clippy::unwrap_used, reason = "a failed construction is a failed test")]

use nalgebra::{Vector2, Vector3};
use nurbs_core::{
    BsplineCurve, BsplineSurface, Circle, Frame, KnotVector, OffsetCurve, OffsetSurface, ParametricCurve,
    ParametricSurface, Sphere, Torus,
};

#[test]
fn offset_of_a_circle_is_a_circle() {
    let circle = Circle::new(Vector2::new(1.0, -2.0), 2.0).unwrap().to_nurbs().unwrap();
    let inner = OffsetCurve::new(&circle, 0.5);
    for i in 0..50 {
        let jet = inner.jet(0.12 * f64::from(i));
        assert!(((jet.point - Vector2::new(1.0, -2.0)).norm() - 1.5).abs() < 1e-13);
        assert!((jet.curvature().unwrap() - 1.0 / 1.5).abs() < 1e-12);
    }
    // At the centre of curvature the offset stands still.
    let centre = OffsetCurve::new(&circle, 2.0).jet(1.0);
    assert!(centre.d1.norm() < 1e-14);
}

#[test]
fn curve_jets_match_differences() {
    let points =
        [(0., 0.), (1., 2.), (2., -1.), (4., 1.), (5., 0.)].map(|(x, y)| Vector2::new(x, y)).to_vec();
    let weights = Some(vec![1.0, 0.5, 2.0, 1.0, 1.5]);
    let base = BsplineCurve::new(KnotVector::uniform_clamped(4, 5).unwrap(), points, weights).unwrap();
    let offset = OffsetCurve::new(base, -0.3);
    let h = 1e-4;
    for i in 1..20 {
        let t = f64::from(i) / 20.0;
        let (a, b, c) = (offset.point(t - h), offset.jet(t), offset.point(t + h));
        assert!(((c - a) / (2.0 * h) - b.d1).norm() < 1e-5 * b.d1.norm().max(1.0));
        assert!(((a + c - b.point * 2.0) / (h * h) - b.d2).norm() < 1e-4 * b.d2.norm().max(1.0));
    }
}

#[test]
fn offset_of_a_sphere_and_a_torus() {
    let f = Frame::from_axis(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.3, 1.0, -0.2)).unwrap();
    let sphere = Sphere::new(f, 2.0).unwrap().to_nurbs().unwrap();
    let larger = OffsetSurface::new(&sphere, 0.25);
    let torus = Torus::new(f, 3.0, 1.0).unwrap().to_nurbs().unwrap();
    let thinner = OffsetSurface::new(&torus, -0.5);
    let expected = Torus::new(f, 3.0, 0.5).unwrap();
    for i in 0..12 {
        for j in 1..12 {
            let (u, w) = (0.5 * f64::from(i), -1.5 + 0.25 * f64::from(j));
            let jet = larger.jet(u, w);
            assert!(((jet.point - f.origin()).norm() - 2.25).abs() < 1e-13);
            assert!((jet.gauss_curvature().unwrap() - 2.25_f64.powi(-2)).abs() < 1e-10);
            assert!((jet.mean_curvature().unwrap() + 1.0 / 2.25).abs() < 1e-11);
            let jet = thinner.jet(u, w + 2.0);
            let foot = expected.footpoint(&jet.point);
            assert!(foot.distance < 1e-13);
            let exact = expected.jet(foot.parameters[0], foot.parameters[1]).principal_frame().unwrap();
            let found = jet.principal_frame().unwrap();
            for k in 0..2 {
                assert!((found.curvatures[k] - exact.curvatures[k]).abs() < 1e-10);
            }
        }
    }
    assert!(larger.try_jet(1.0, std::f64::consts::FRAC_PI_2).is_none());
    assert!(larger.jet(1.0, std::f64::consts::FRAC_PI_2).point.x.is_nan());
}

#[test]
fn surface_jets_match_differences() {
    let knots = KnotVector::uniform_clamped(3, 4).unwrap();
    let z = |i: usize, j: usize| ((i * 3 + j * 5) % 7) as f64 * 0.2;
    let points = (0..16).map(|k| Vector3::new((k / 4) as f64, (k % 4) as f64, z(k / 4, k % 4))).collect();
    let weights = (0..16).map(|k| 1.0 + 0.1 * f64::from(k % 3)).collect();
    let base = BsplineSurface::new(knots.clone(), knots, points, Some(weights)).unwrap();
    let offset = OffsetSurface::new(base, 0.2);
    let h = 1e-4;
    for (u, v) in [(0.2, 0.3), (0.5, 0.5), (0.7, 0.1), (0.9, 0.8)] {
        let jet = offset.jet(u, v);
        let s = |i: f64, j: f64| offset.point(u + i * h, v + j * h);
        let close =
            |x: Vector3<f64>, y: Vector3<f64>| assert!((x - y).norm() < 1e-5 * y.norm().max(1.0), "{x} {y}");
        close((s(1.0, 0.0) - s(-1.0, 0.0)) / (2.0 * h), jet.du);
        close((s(0.0, 1.0) - s(0.0, -1.0)) / (2.0 * h), jet.dv);
        close((s(1.0, 0.0) + s(-1.0, 0.0) - jet.point * 2.0) / (h * h), jet.duu);
        close((s(0.0, 1.0) + s(0.0, -1.0) - jet.point * 2.0) / (h * h), jet.dvv);
        close((s(1.0, 1.0) + s(-1.0, -1.0) - s(1.0, -1.0) - s(-1.0, 1.0)) / (4.0 * h * h), jet.duv);
    }
}
