//! Outlines with narrow teeth and gaps: the fitted curve follows them instead of taking short cuts.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use nalgebra::Vector2;
use nurbs_core::ParametricCurve;
use sdm_fit::curve::{CurveOptions, fit_curve};

/// A comb: a bar with teeth of width .6, different lengths and gaps of width .5, points every quarter.
fn comb() -> Vec<Vector2<f64>> {
    let lengths = [8.0, 5.0, 11.0, 8.0, 3.0, 9.0];
    let mut corners = vec![Vector2::new(0.0, 0.0), Vector2::new(0.0, -6.0), Vector2::new(6.1, -6.0)];
    for (k, length) in lengths.iter().enumerate() {
        let right = 6.1 - 1.1 * k as f64;
        corners.extend([Vector2::new(right, *length), Vector2::new(right - 0.6, *length)]);
        if k + 1 < lengths.len() {
            corners.extend([Vector2::new(right - 0.6, 0.0), Vector2::new(right - 1.1, 0.0)]);
        }
    }
    let mut points = Vec::new();
    for (k, a) in corners.iter().enumerate() {
        let b = corners[(k + 1) % corners.len()];
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small count")]
        let steps = ((b - a).norm() * 4.0).round().max(1.0) as usize;
        points.extend((0..steps).map(|i| a + (b - a) * (i as f64 / steps as f64)));
    }
    points
}

#[test]
fn narrow_teeth_are_followed() {
    let points = comb();
    for tolerance in [Some(0.1), None] {
        let fitted =
            fit_curve(&points, None, &CurveOptions::default().with_abs_tolerance(tolerance)).unwrap();
        let report = &fitted.report;
        assert!(report.closed && report.crossings.is_empty(), "{report} {:?}", report.crossings);
        assert!(report.max <= tolerance.unwrap_or(0.6), "{report}");
        // Nowhere far from the outline either: no loops without points.
        let domain = fitted.curve.domain();
        for k in 0..4000 {
            let place = fitted.curve.point(domain.lerp(f64::from(k) / 4000.0));
            let nearest = points.iter().map(|p| (p - place).norm()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 0.6, "{report}: {place:?} is {nearest} away");
        }
    }
}
