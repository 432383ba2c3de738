//! Shapes with nothing to hold on to, and of extreme sizes: finite answers, no panic.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

use crate::projector_support::answer::{Answer, Judge};
use crate::projector_support::shapes::{parabola, rectangle};
use footpoint::{CurveProjector, Mode, ProjectionOptions, SurfaceProjector};
use nalgebra::{SVector, Vector2, Vector3};
use nurbs_core::{BsplineCurve, BsplineSurface, Frame, KnotVector, Sphere, Torus};

const MODES: [Mode; 3] = [Mode::Certified, Mode::Fast, Mode::Local];

fn v(x: f64, y: f64, z: f64) -> Vector3<f64> {
    Vector3::new(x, y, z)
}

/// A surface of the given degree whose `n × n` control points are made from indices.
fn net(degree: usize, n: usize, point: impl Fn(usize, usize) -> Vector3<f64>) -> BsplineSurface {
    let knots = KnotVector::uniform_clamped(degree, n).unwrap();
    let points = (0..n * n).map(|k| point(k / n, k % n)).collect();
    BsplineSurface::new(knots.clone(), knots, points, None).unwrap()
}

/// Projects in every mode; the certified distance must be the expected one.
fn check_surface(surface: &BsplineSurface, x: &Vector3<f64>, expected: f64) {
    let projector = SurfaceProjector::new(surface);
    for mode in MODES {
        let foot = projector.project_with(x, &ProjectionOptions::default().with_mode(mode)).unwrap();
        check(surface, x, &foot.into(), expected, mode);
    }
}

fn check_curve<const D: usize>(curve: &BsplineCurve<D>, x: &SVector<f64, D>, expected: f64) {
    let projector = CurveProjector::new(curve);
    for mode in MODES {
        let foot = projector.project_with(x, &ProjectionOptions::default().with_mode(mode)).unwrap();
        check(curve, x, &foot.into(), expected, mode);
    }
}

fn check<const D: usize>(
    shape: &impl Judge<D>,
    x: &SVector<f64, D>,
    found: &Answer<D>,
    expected: f64,
    mode: Mode,
) {
    let tolerance = 1e-9 * (expected + shape.size());
    assert_eq!(shape.inconsistency(x, found), None, "{mode:?} {found:?}");
    assert!(found.distance >= expected - tolerance, "{mode:?} {expected} {found:?}");
    if mode == Mode::Certified {
        assert!((found.distance - expected).abs() <= tolerance, "{expected} {found:?}");
        assert!(found.lower_bound <= expected + 1e-3 * tolerance, "{expected} {found:?}");
        assert!(found.distance - found.lower_bound <= 1e3 * tolerance, "{expected} {found:?}");
        assert!(found.status.is_converged(), "{found:?}");
    }
}

#[test]
fn surfaces_that_are_a_point() {
    for degree in 1..=5 {
        let surface = net(degree, 6, |_, _| v(1.0, 2.0, 3.0));
        check_surface(&surface, &v(1.0, 2.0, 3.0), 0.0);
        check_surface(&surface, &v(1.0, 2.0, 4.0), 1.0);
        check_surface(&surface, &v(-1e9, 2.0, 3.0), 1e9 + 1.0);
    }
}

#[test]
fn surfaces_that_are_a_line() {
    for degree in 1..=4 {
        // Constant in one direction, and a square folded onto its diagonal.
        let strip = net(degree, 6, |i, _| v(i as f64, 0.0, 0.0));
        let folded = net(degree, 6, |i, j| v((i + j) as f64 * 0.5, 0.0, 0.0));
        for surface in [strip, folded] {
            check_surface(&surface, &v(2.0, 3.0, 4.0), 5.0);
            check_surface(&surface, &v(2.5, 0.0, 0.0), 0.0);
            check_surface(&surface, &v(-3.0, 0.0, 4.0), 5.0);
            check_surface(&surface, &v(5.0, 1e-9, 0.0), 1e-9);
        }
    }
}

#[test]
fn curves_of_no_length() {
    for degree in 1..=5 {
        let knots = KnotVector::uniform_clamped(degree, degree + 3).unwrap();
        let points = vec![Vector2::new(0.5, 0.5); degree + 3];
        let curve = BsplineCurve::new(knots, points, None).unwrap();
        check_curve(&curve, &Vector2::new(0.5, 0.5), 0.0);
        check_curve(&curve, &Vector2::new(3.5, 4.5), 5.0);
    }
}

#[test]
fn curves_that_turn_back() {
    // There and back again along a line, with a standstill at the turn.
    let points = vec![Vector2::new(0.0, 0.0), Vector2::new(2.0, 0.0), Vector2::new(0.0, 0.0)];
    let curve = BsplineCurve::bezier(points, None).unwrap();
    check_curve(&curve, &Vector2::new(0.5, 2.0), 2.0);
    check_curve(&curve, &Vector2::new(4.0, 4.0), 5.0);
    check_curve(&curve, &Vector2::new(-3.0, 4.0), 5.0);
    // The cusp of (t², t³).
    let points = vec![
        Vector2::new(1.0, -1.0),
        Vector2::new(-1.0 / 3.0, 1.0),
        Vector2::new(-1.0 / 3.0, -1.0),
        Vector2::new(1.0, 1.0),
    ];
    let curve = BsplineCurve::bezier(points, None).unwrap();
    for x in [-0.1, -1.0, -100.0] {
        check_curve(&curve, &Vector2::new(x, 0.0), -x);
    }
    check_curve(&curve, &Vector2::new(0.0, 0.0), 0.0);
}

#[test]
fn equal_control_points_at_a_corner() {
    // Three edges of a square drawn into one corner: no normal there.
    let surface =
        net(3, 4, |i, j| if i < 2 && j < 2 { v(0.0, 0.0, 0.0) } else { v(i as f64, j as f64, 0.0) });
    check_surface(&surface, &v(-3.0, -4.0, 0.0), 5.0);
    check_surface(&surface, &v(-3.0, -4.0, 12.0), 13.0);
    check_surface(&surface, &v(2.0, 2.0, 7.0), 7.0);
}

#[test]
fn huge_and_tiny_shapes() {
    for scale in [1e-50, 1e-12, 1e-6, 1e6, 1e12, 1e50] {
        let size = |surface: BsplineSurface| surface.scaled(scale, &Vector3::zeros()).unwrap();
        let flat = size(rectangle(2.0, 1.0, 0.0));
        check_surface(&flat, &(v(0.5, 0.5, 3.0) * scale), 3.0 * scale);
        check_surface(&flat, &(v(5.0, 5.0, 12.0) * scale), 13.0 * scale);
        let ball = size(Sphere::new(Frame::WORLD, 1.0).unwrap().to_nurbs().unwrap());
        check_surface(&ball, &(v(0.0, 3.0, 4.0) * scale), 4.0 * scale);
        check_surface(&ball, &(v(0.0, 0.3, 0.4) * scale), 0.5 * scale);
        check_surface(&ball, &(v(0.0, 0.0, 0.0) * scale), scale);
        let ring = size(Torus::new(Frame::WORLD, 3.0, 1.0).unwrap().to_nurbs().unwrap());
        check_surface(&ring, &(v(3.0, 4.0, 0.0) * scale), scale);
        let curve = parabola().scaled(scale, &Vector2::zeros()).unwrap();
        check_curve(&curve, &(Vector2::new(0.0, -2.0) * scale), 2.0 * scale);
        check_curve(&curve, &(Vector2::new(4.0, 5.0) * scale), 5.0 * scale);
    }
}

#[test]
fn queries_very_far_away() {
    let ball = Sphere::new(Frame::WORLD, 1.0).unwrap().to_nurbs().unwrap();
    for far in [1e3, 1e6, 1e9, 1e15, 1e100, 1e150] {
        check_surface(&ball, &v(0.0, 0.6 * far, 0.8 * far), far - 1.0);
        check_surface(&rectangle(2.0, 1.0, 0.0), &v(1.0, 0.5, -far), far);
        check_curve(&parabola(), &Vector2::new(0.0, -far), far);
    }
}

#[test]
fn numbers_near_the_end_of_their_range() {
    // Squares overflow: the answer may be poor, but nothing may panic or hang.
    let ball = Sphere::new(Frame::WORLD, 1.0).unwrap().to_nurbs().unwrap();
    let projector = SurfaceProjector::new(&ball);
    for far in [1e160, 1e300, f64::MAX] {
        let _ = projector.project(&v(far, 0.0, 0.0));
        let _ = projector.project(&v(far, -far, far));
        let _ = CurveProjector::new(&parabola()).project(&Vector2::new(far, far));
    }
    for scale in [1e-300, 1e160, 1e300] {
        let (ball, curve) =
            (ball.scaled(scale, &Vector3::zeros()), parabola().scaled(scale, &Vector2::zeros()));
        // Coordinates beyond 1e70 are refused where the shape is made.
        assert_eq!((ball.is_ok(), curve.is_ok()), (scale < 1.0, scale < 1.0), "{scale}");
        if let (Ok(ball), Ok(curve)) = (ball, curve) {
            let _ = SurfaceProjector::new(&ball).project(&v(2.0 * scale, 0.0, 0.0));
            let _ = CurveProjector::new(&curve).project(&(Vector2::new(2.0, 2.0) * scale));
        }
    }
}
