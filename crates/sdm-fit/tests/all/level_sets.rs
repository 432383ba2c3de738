//! Level sets on grids become B-splines ([P05, sec. 4]).

#![allow(clippy::unwrap_used, reason = "a set-up that fails must fail the test")]

use distance_field::{DistanceField, Grid, LevelSetField};
use nalgebra::Vector2;
use nurbs_core::{BsplineCurve, Interval, KnotVector, ParametricCurve};
use sdm_fit::{ActiveCurve, Constraints, FitOptions, Smoothing, Target, fit};
use std::f64::consts::TAU;

/// `r = 1 + 0.3 cos 5φ`.
fn star() -> LevelSetField<2> {
    let f = |p: &Vector2<f64>| p.norm() - 1.0 - 0.3 * (5.0 * p.y.atan2(p.x)).cos();
    let grid = Grid::sample(Vector2::repeat(-1.5), Vector2::repeat(3.0 / 255.0), [256, 256], f).unwrap();
    LevelSetField::<2>::new(&grid).unwrap()
}

/// A closed cubic through points at equal shares of the length of a contour.
fn around(contour: &mesh_core::Polyline<2>, controls: usize) -> BsplineCurve<2> {
    let at = |k: usize| contour.point_at(contour.length() * (k % controls) as f64 / controls as f64).coords;
    let points = (0..controls + 3).map(at).collect();
    BsplineCurve::new(KnotVector::uniform_periodic(3, controls).unwrap(), points, None).unwrap()
}

/// Largest distance between the star and the curve, sampled from both sides.
fn gap(curve: &BsplineCurve<2>, star: &LevelSetField<2>) -> f64 {
    let domain: Interval = curve.domain();
    let samples: Vec<_> = (0..4000).map(|k| curve.point(domain.lerp(f64::from(k) / 4000.0))).collect();
    let forth = samples.iter().map(|x| star.distance(x)).fold(0.0, f64::max);
    let projector = footpoint::CurveProjector::new(curve);
    let back = (0..4000)
        .map(|k| TAU * f64::from(k) / 4000.0)
        .map(|a| Vector2::new(a.cos(), a.sin()) * (1.0 + 0.3 * (5.0 * a).cos()))
        .map(|x| projector.project(&x).distance)
        .fold(0.0, f64::max);
    forth.max(back)
}

#[test]
fn a_star_comes_back_with_36_control_points() {
    let star = star();
    assert_eq!(star.contours().len(), 1);
    let start = around(&star.contours()[0], 36);
    let target = Target::Model { field: &star, sensors: 6, boundary: true };
    let options = FitOptions::default().with_smoothing(Smoothing::CONTINUATION);
    let fitted = fit(ActiveCurve::new(start).unwrap(), target, &Constraints::none(), &options).unwrap();
    let curve = fitted.shape.curve();
    let size = 2.6;
    let error = gap(curve, &star);
    assert!(error <= 1e-4 * size, "{error}: {}", fitted.report);
}
