//! Coordinates, weights and queries of all magnitudes: an answer with a bound, or an error with the number.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

use footpoint::{CurveProjector, Error, Mode, ProjectionOptions, Status, SurfaceProjector, no_progress};
use nalgebra::{Vector2, Vector3};
use nurbs_core::{
    BsplineCurve, BsplineSurface, Interval, KnotVector, MAX_COORDINATE, MAX_WEIGHT_RATIO, ParametricCurve,
};

const MODES: [Mode; 3] = [Mode::Certified, Mode::Fast, Mode::Local];

fn knots() -> KnotVector {
    KnotVector::new(2, vec![0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0]).unwrap()
}

fn curve(scale: f64, weights: Option<[f64; 4]>) -> Result<BsplineCurve<2>, nurbs_core::Error> {
    let points = [[0.0, 0.0], [1.0, 2.0], [3.0, 2.0], [4.0, 0.0]].map(|p| Vector2::from(p) * scale);
    BsplineCurve::new(knots(), points.to_vec(), weights.map(|w| w.to_vec()))
}

fn surface(scale: f64, weights: Option<Vec<f64>>) -> Result<BsplineSurface, nurbs_core::Error> {
    let bezier = KnotVector::bezier(2, Interval::UNIT)?;
    let net =
        (0..9).map(|k| Vector3::new(f64::from(k / 3), f64::from(k % 3), 0.3 * f64::from(k % 4)) * scale);
    BsplineSurface::new(bezier.clone(), bezier, net.collect(), weights)
}

/// Every eighth power of ten that a double can have.
fn magnitudes() -> impl Iterator<Item = f64> {
    (-40..=38).map(|k| 10f64.powi(8 * k)).filter(|m| *m > 0.0)
}

#[test]
fn the_size_of_a_model_changes_nothing_but_the_exponents() {
    let x = Vector2::new(2.3, 4.1);
    let plain = CurveProjector::new(&curve(1.0, Some([1.0, 0.5, 2.0, 1.0])).unwrap());
    let y = Vector3::new(0.7, 1.1, 2.0);
    let plain_surface = SurfaceProjector::new(&surface(1.0, None).unwrap());
    for exponent in [-1060, -1000, -530, -100, -65, 65, 100, 230] {
        let factor = nurbs_core::magnitude::scaled_by_power_of_two(1.0, exponent);
        let scaled = CurveProjector::new(&curve(factor, Some([1.0, 0.5, 2.0, 1.0])).unwrap());
        let scaled_surface = SurfaceProjector::new(&surface(factor, None).unwrap());
        // Subnormal numbers have few digits.
        let digits = if exponent < -1000 { 1e-2 } else { 1e-12 };
        for mode in MODES {
            let options = ProjectionOptions::default().with_mode(mode);
            let (a, b) = (
                plain.project_with(&x, &options).unwrap(),
                scaled.project_with(&(x * factor), &options).unwrap(),
            );
            assert!(
                (a.parameter - b.parameter).abs() < digits && a.status == b.status,
                "{exponent}: {a}, {b}"
            );
            assert!((b.distance / factor - a.distance).abs() < digits * a.distance);
            let (a, b) = (
                plain_surface.project_with(&y, &options).unwrap(),
                scaled_surface.project_with(&(y * factor), &options).unwrap(),
            );
            assert!(
                (a.parameter[0] - b.parameter[0]).abs() < digits && a.status == b.status,
                "{exponent}: {a}, {b}"
            );
            assert!((b.signed_distance / factor - a.signed_distance).abs() < digits * a.distance);
            assert!((b.lower_bound / factor - a.lower_bound).abs() <= digits * a.distance);
        }
    }
}

#[test]
fn weights_may_be_large_or_small_together() {
    let x = Vector2::new(2.3, 4.1);
    let weights = [1.0, 0.5, 2.0, 1.0];
    let plain = curve(1.0, Some(weights)).unwrap();
    let foot = CurveProjector::new(&plain).project(&x);
    for factor in [1e300, 1e154, 1e120, 1e-120, 1e-154, 1e-300] {
        let scaled = weights.map(|w| w * factor);
        let other = curve(1.0, Some(scaled)).unwrap();
        // What is stored is what was given.
        assert_eq!(other.weights(), Some(&scaled[..]));
        assert!((other.point(0.3) - plain.point(0.3)).norm() < 1e-14);
        assert!((other.derivatives(0.3, 2)[2] - plain.derivatives(0.3, 2)[2]).norm() < 1e-12);
        let found = CurveProjector::new(&other).project(&x);
        assert!((found.distance - foot.distance).abs() < 1e-14, "{found}");
        assert!(found.status == Status::Converged && found.gap() < 1e-6);
        let flat = SurfaceProjector::new(&surface(1.0, Some(vec![factor; 9])).unwrap());
        let same = SurfaceProjector::new(&surface(1.0, None).unwrap());
        let y = Vector3::new(0.7, 1.1, 2.0);
        assert!((flat.project(&y).distance - same.project(&y).distance).abs() < 1e-14);
    }
}

#[test]
fn what_cannot_be_computed_with_is_refused_with_the_number() {
    let error = curve(1.0, Some([1.0, 1e-300, 1e300, 1.0])).unwrap_err().to_string();
    assert!(
        error.contains("weight 0 is 1 ") && error.contains("e300") | error.contains("1000000"),
        "{error}"
    );
    assert!(curve(1.0, Some([1.0, 1.0, 1.0, 2.0 / MAX_WEIGHT_RATIO])).is_ok());
    assert!(curve(1.0, Some([1.0, 1.0, 1.0, 0.5 / MAX_WEIGHT_RATIO])).is_err());
    assert!(curve(0.2 * MAX_COORDINATE, None).is_ok());
    for scale in [MAX_COORDINATE, 1e155, 1e300] {
        let error = surface(scale, None).unwrap_err();
        assert!(matches!(error, nurbs_core::Error::Magnitude { value, .. } if value >= scale), "{error}");
    }
}

#[test]
fn every_magnitude_ends_with_an_answer_or_an_error() {
    let mut answers = 0;
    for scale in magnitudes() {
        for weight in [None, Some(1e-60), Some(1e-20), Some(1e3), Some(1e60), Some(1e300)] {
            let Ok(curve) = curve(scale, weight.map(|w| [1.0, w, 1.0, 1.0])) else { continue };
            let weights = weight.map(|w| (0..9).map(|k| if k == 4 { w } else { 1.0 }).collect());
            let Ok(surface) = surface(scale, weights) else { continue };
            let (on_curve, on_surface) = (CurveProjector::new(&curve), SurfaceProjector::new(&surface));
            for reach in [0.0, 1e-9, 1.0, 1e20, 1e100, 1e200] {
                let factor = (scale * reach).min(1e300);
                let (x, y) = (Vector2::new(2.3, 4.1) * factor, Vector3::new(0.7, 1.1, 2.0) * factor);
                for mode in MODES {
                    let options = ProjectionOptions { mode, max_boxes: 200, ..ProjectionOptions::default() };
                    let foot = on_curve.project_with(&x, &options).unwrap();
                    let true_distance = ((foot.point - x) / factor.max(scale)).norm() * factor.max(scale);
                    assert!(
                        (foot.distance - true_distance).abs() <= 1e-9 * factor.max(scale),
                        "{scale:e} {weight:?} {reach:e} {mode:?}: {foot}"
                    );
                    assert!(foot.lower_bound <= foot.distance && foot.lower_bound >= 0.0);
                    let foot = on_surface.project_with(&y, &options).unwrap();
                    let true_distance = ((foot.point - y) / factor.max(scale)).norm() * factor.max(scale);
                    assert!(
                        (foot.distance - true_distance).abs() <= 1e-9 * factor.max(scale),
                        "{scale:e} {weight:?} {reach:e} {mode:?}: {foot}"
                    );
                    assert!(foot.lower_bound <= foot.distance && foot.lower_bound >= 0.0);
                    answers += 1;
                }
            }
        }
    }
    assert!(answers > 1000, "{answers}");
}

#[test]
fn mixed_magnitudes_and_models_far_off_their_size_end_too() {
    for small in [1e-300, 1e-160, 1e-20, 1e20] {
        let points = vec![Vector2::new(0.0, 1.0), Vector2::new(small, 1.0), Vector2::new(2.0 * small, 1.0)];
        let line = BsplineCurve::bezier(points, None).unwrap();
        let projector = CurveProjector::new(&line);
        for mode in MODES {
            let options = ProjectionOptions::default().with_mode(mode);
            let foot = projector.project_with(&Vector2::new(0.5 * small, 3.0), &options).unwrap();
            assert!((foot.distance - 2.0).abs() < 1e-9 && foot.point.y == 1.0, "{small}: {foot}");
            // Next to a line too short to be measured from afar.
            let foot = projector.project_with(&Vector2::new(0.5 * small, 1.0), &options).unwrap();
            assert!((foot.parameter - 0.25).abs() < 1e-6 && foot.distance <= 1e-9 * small, "{small}: {foot}");
        }
        let bent = vec![Vector2::new(small, 1.0), Vector2::new(1.0, small), Vector2::new(1e60, 1e-60)];
        let projector = CurveProjector::new(&BsplineCurve::bezier(bent, None).unwrap());
        for mode in MODES {
            let options = ProjectionOptions::default().with_mode(mode);
            let foot = projector.project_with(&Vector2::new(3.0, -4.0), &options).unwrap();
            assert!(foot.distance.is_finite() && foot.distance < 1e61, "{foot}");
        }
    }
}

#[test]
fn options_that_mean_nothing_are_refused() {
    let curve = CurveProjector::new(&curve(1.0, None).unwrap());
    let surface = SurfaceProjector::new(&surface(1.0, None).unwrap());
    for value in [f64::NAN, f64::INFINITY, -1.0, 1.0] {
        let good = ProjectionOptions::default();
        let all = [
            (good.with_relative_gap(value), "relative_gap"),
            (good.with_size_gap(value), "size_gap"),
            (ProjectionOptions { tie_tolerance: value, ..good }, "tie_tolerance"),
        ];
        for (options, name) in all {
            let is_named = |error: Error| matches!(error, Error::Option { option, .. } if option == name);
            let (x, y) = (Vector2::zeros(), Vector3::zeros());
            assert!(is_named(curve.project_with(&x, &options).unwrap_err()));
            assert!(is_named(surface.project_with(&y, &options).unwrap_err()));
            assert!(is_named(curve.project_many(&[x], &options, &no_progress).unwrap_err()));
            assert!(is_named(surface.project_many(&[y], &options, &no_progress).unwrap_err()));
        }
    }
}
