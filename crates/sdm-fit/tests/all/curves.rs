//! From points to curves.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use crate::curve_cases::{Random, deviation, lobes, noisy_lobes, points, start};
use distance_field::CurveField;
use nalgebra::{SVector, Vector2, Vector3};
use nurbs_core::{BsplineCurve, KnotVector, ParametricCurve};
use sdm_fit::curve::{
    ActiveCurve, Closure, CurveEnd, CurveOptions, CurveStart, fit_curve, fit_curve_with_progress,
    self_crossings,
};
use sdm_fit::{
    ActiveShape, Constraints, Error, FitOptions, LinearCondition, Robust, Smoothing, Status, Target, fit,
};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

fn circle(count: usize, centre: Vector2<f64>) -> Vec<Vector2<f64>> {
    let at = |k: usize| TAU * (k * 37 % count) as f64 / count as f64;
    (0..count).map(|k| centre + Vector2::new(3.0 * at(k).cos(), at(k).sin())).collect()
}

#[test]
fn noise_is_smoothed_from_every_start_and_without_one() {
    let data = points::<2>("a2_noisy.xyz");
    let options = CurveOptions::default();
    let curves = [Some(start("a2_init_even.json")), Some(start("a2_init_uneven.json")), None];
    for curve in curves {
        let options = if curve.is_none() { options.with_controls(Some(12)) } else { options };
        let fitted = fit_curve(&data, curve.as_ref(), &options).unwrap();
        let report = &fitted.report;
        assert!(report.crossings.is_empty() && self_crossings(&fitted.curve).is_empty());
        // Below the noise of 0.15 by no more than the unknowns explain.
        assert!(report.rms > 0.145 && report.rms < 0.151, "{report}");
        assert!(report.closed && report.lambda > 1e-4, "{report}");
    }
    for seed in 1..4 {
        let data = noisy_lobes(800, 0.15, seed);
        let twelve = fit_curve(&data, None, &options.with_controls(Some(12))).unwrap();
        let off = deviation(&twelve.curve, lobes);
        assert!(off < 0.04 && twelve.report.crossings.is_empty(), "{seed}: {off}, {}", twelve.report);
        let fitted = fit_curve(&data, None, &options).unwrap();
        let off = deviation(&fitted.curve, lobes);
        assert!(off < 0.045 && fitted.report.crossings.is_empty(), "{seed}: {off}, {}", fitted.report);
        assert_eq!(fitted.report.start, CurveStart::Skeleton);
    }
}

#[test]
fn an_open_curve_in_space_is_found_in_any_order() {
    for name in ["b_open3d_ordered.xyz", "b_open3d_shuffled.xyz"] {
        let options = CurveOptions::default().with_controls(Some(24));
        let fitted = fit_curve(&points::<3>(name), None, &options).unwrap();
        let report = &fitted.report;
        assert!(report.rms <= 0.0135 && report.controls == 24, "{name}: {report}");
        assert!(!report.closed && report.is_converged());
        let Closure::Gap { gap, limit } = report.closure else { panic!("{:?}", report.closure) };
        assert!(gap > limit);
    }
}

#[test]
fn a_tolerance_is_met_or_said_not_to_be() {
    let options = CurveOptions::default().with_abs_tolerance(Some(1e-4));
    let fitted = fit_curve(&circle(300, Vector2::zeros()), None, &options).unwrap();
    let report = &fitted.report;
    assert!(report.reached == Some(true) && report.max <= 1e-4 && report.controls <= 20, "{report}");
    for (x, foot) in circle(300, Vector2::zeros()).iter().zip(&fitted.feet) {
        assert!((fitted.curve.point(foot.parameter) - foot.foot).norm() < 1e-12);
        assert!(((x - foot.foot).norm() - foot.distance).abs() < 1e-12);
    }
    // Noise of 0.15 cannot be met; the report says so and the curve stays sane.
    let data = noisy_lobes(300, 0.15, 5);
    let options = CurveOptions::default().with_abs_tolerance(Some(0.01)).with_max_controls(20);
    let report = fit_curve(&data, None, &options).unwrap().report;
    assert_eq!(report.reached, Some(false));
    assert!(report.share_within.unwrap() < 0.9 && report.controls <= 20);
    assert!(report.to_string().contains("not reached"), "{report}");
}

#[test]
fn points_on_a_spline_give_it_back() {
    let knots = KnotVector::new(3, vec![0., 0., 0., 0., 0.2, 0.5, 0.6, 1., 1., 1., 1.]).unwrap();
    let net: Vec<_> = (0..7)
        .map(|i| Vector3::new(f64::from(i), f64::from(i * i % 5), [0.0, 2.0, 1.0][(i % 3) as usize]))
        .collect();
    let curve = BsplineCurve::new(knots.clone(), net.clone(), None).unwrap();
    let data: Vec<_> = (0..150).map(|k| curve.point(f64::from(k) / 149.0)).collect();
    let moved = net.iter().enumerate().map(|(i, p)| p + Vector3::new(0.05, -0.04, 0.03) * (i % 2) as f64);
    let first = BsplineCurve::new(knots, moved.collect(), None).unwrap();
    let fitted = fit_curve(&data, Some(&first), &CurveOptions::default()).unwrap();
    assert!(fitted.report.max < 1e-9, "{}", fitted.report);
    for (a, b) in fitted.curve.control_points().iter().zip(&net) {
        assert!((a - b).norm() < 1e-6, "{a} {b}");
    }
}

#[test]
fn conics_are_exact_with_weights() {
    let options = CurveOptions::default().with_rational(true);
    let data = circle(120, Vector2::new(1000.0, -500.0));
    let fitted = fit_curve(&data, None, &options).unwrap();
    assert!(fitted.report.max < 1e-9 && fitted.curve.weights().is_some(), "{}", fitted.report);
    // Between the points, too.
    for k in 0..1000 {
        let p = fitted.curve.point(f64::from(k) / 1000.0) - Vector2::new(1000.0, -500.0);
        assert!(((p.x / 3.0).hypot(p.y) - 1.0).abs() < 1e-9);
    }
    let arc = (0..60).map(|k| 0.04 * f64::from(k)).map(|a| Vector3::new(a.cos(), a.sin(), 0.2 * a.cos()));
    let fitted = fit_curve(&arc.collect::<Vec<_>>(), None, &options).unwrap();
    assert!(fitted.report.max < 1e-9 && !fitted.report.closed, "{}", fitted.report);
}

#[test]
fn far_coordinates_and_other_units_change_nothing() {
    let data = noisy_lobes(200, 0.02, 7);
    let options = CurveOptions::default().with_controls(Some(14));
    let plain = fit_curve(&data, None, &options).unwrap().report;
    let shift = Vector2::new(4.2e6, -1.7e6);
    let far: Vec<_> = data.iter().map(|p| p * 1000.0 + shift).collect();
    let far = fit_curve(&far, None, &options).unwrap().report;
    assert!((far.rms / 1000.0 - plain.rms).abs() < 1e-3 * plain.rms, "{plain}\n{far}");
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let data = noisy_lobes(3000, 0.05, 9);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fit_curve(&data, None, &CurveOptions::default().with_controls(Some(16))).unwrap())
    };
    let (one, three) = (with(1), with(3));
    assert_eq!(one.curve, three.curve);
    assert_eq!(one.report, three.report);
}

#[test]
fn bad_input_is_an_error_or_a_status() {
    let options = CurveOptions::default();
    let line: Vec<_> =
        (0..40).map(|k| Vector2::new(f64::from(k * 7 % 40), 2.0 * f64::from(k * 7 % 40))).collect();
    let fitted = fit_curve(&line, None, &options).unwrap();
    assert!(fitted.report.max < 1e-9 && fitted.report.closure == Closure::Line);
    let closed = options.with_closed(Some(true));
    assert!(matches!(fit_curve(&line, None, &closed), Err(Error::Degenerate { .. })));
    assert!(matches!(
        fit_curve(&line[..3], None, &options),
        Err(Error::TooFewPoints { finite: 3, needed: 4, .. })
    ));
    let many = options.with_controls(Some(41));
    assert!(matches!(fit_curve(&line, None, &many), Err(Error::TooFewPoints { needed: 41, .. })));
    let same = vec![Vector2::new(1.0, 2.0); 50];
    assert!(matches!(fit_curve(&same, None, &options), Err(Error::TooFewPoints { finite: 1, .. })));
    assert!(matches!(fit_curve::<2>(&[], None, &options), Err(Error::TooFewPoints { total: 0, .. })));
    for wrong in
        [options.with_degree(0), options.with_abs_tolerance(Some(f64::NAN)), options.with_controls(Some(2))]
    {
        assert!(matches!(fit_curve(&line, None, &wrong), Err(Error::Option { .. })));
    }

    // Points that are not finite are left out and counted; duplicates count as often as they come.
    let mut data = circle(60, Vector2::zeros());
    data.extend_from_within(..20);
    data[7].x = f64::NAN;
    data[9].y = f64::INFINITY;
    let fitted = fit_curve(&data, None, &options.with_controls(Some(10))).unwrap();
    assert_eq!((fitted.report.dropped, fitted.report.points), (2, 80));
    assert!(fitted.feet[7].parameter.is_nan() && fitted.report.rms < 1e-2, "{}", fitted.report);
    let finite = |p: &SVector<f64, 2>| p.iter().all(|c| c.is_finite());
    assert!(fitted.curve.control_points().iter().all(finite));
    // A start that crosses itself is allowed; the report tells what became of it.
    let knots = KnotVector::uniform_periodic(3, 8).unwrap();
    let eight = |k: usize| {
        let a = TAU * (k % 8) as f64 / 8.0;
        Vector2::new(3.0 * a.sin(), (2.0 * a).sin())
    };
    let crossed = BsplineCurve::new(knots, (0..11).map(eight).collect(), None).unwrap();
    assert_eq!(self_crossings(&crossed).len(), 1);
    let fitted = fit_curve(&circle(60, Vector2::zeros()), Some(&crossed), &options).unwrap();
    assert!(fitted.curve.control_points().iter().all(finite));
    assert_eq!(fitted.report.crossings, self_crossings(&fitted.curve));
}

#[test]
fn side_conditions_hold_exactly() {
    let data = noisy_lobes(200, 0.02, 3);
    let half: Vec<_> = data.iter().filter(|p| p.y > 0.0).copied().collect();
    let net = (0..8).map(|i| Vector2::new(3.0 - 6.0 * f64::from(i) / 7.0, 1.0)).collect();
    let curve = BsplineCurve::new(KnotVector::uniform_clamped(3, 8).unwrap(), net, None).unwrap();
    let shape = ActiveCurve::new(curve).unwrap();
    let through = Vector2::new(0.1, 1.4);
    let constraints = Constraints::none()
        .with_held(0, Vector2::new(2.6, 0.0))
        .with_plane(7, Vector2::y(), 0.0)
        .with_direction(0, 1, &Vector2::new(0.0, 1.0))
        .with_point(&shape, [0.5, 0.0], &through);
    let target = Target::Points { points: &half, weights: None };
    let fitted = fit(shape, target, &constraints, &FitOptions::default()).unwrap();
    let d = fitted.shape.coefficients();
    assert!((d[0] - Vector2::new(2.6, 0.0)).norm() < 1e-12 && d[7].y.abs() < 1e-10);
    assert!((d[1] - d[0]).x.abs() < 1e-10 && (fitted.shape.point([0.5, 0.0]) - through).norm() < 1e-10);
    assert!(fitted.report.rms < 0.4 * fitted.report.initial_rms, "{}", fitted.report);
    let mut wrong = constraints.clone();
    wrong.conditions.push(LinearCondition { terms: vec![(7, Vector2::y())], value: 1.0 });
    let shape = fitted.shape.clone();
    assert!(matches!(fit(shape, target, &wrong, &FitOptions::default()), Err(Error::Constraint { .. })));
}

#[test]
fn a_curve_is_fitted_to_a_model_by_sensor_points() {
    let knots = KnotVector::uniform_periodic(3, 12).unwrap();
    let at = |i: usize, n: usize| TAU * (i % n) as f64 / n as f64;
    let model = (0..15).map(|i| lobes(at(i, 12)) * 1.1).collect();
    let model = BsplineCurve::new(knots.clone(), model, None).unwrap();
    let field = CurveField::new(&model).unwrap();
    let ring = (0..15).map(|i| Vector2::new(2.4 * at(i, 12).cos(), 1.8 * at(i, 12).sin())).collect();
    let shape = ActiveCurve::new(BsplineCurve::new(knots, ring, None).unwrap()).unwrap();
    let target = Target::Model { field: &field, sensors: 6, boundary: true };
    let options = FitOptions::default().with_smoothing(Smoothing::CONTINUATION);
    let fitted = fit(shape, target, &Constraints::none(), &options).unwrap();
    assert!(fitted.report.rms < 1e-4, "{}", fitted.report);
}

#[test]
fn outliers_can_be_left_out() {
    let mut data = noisy_lobes(400, 0.01, 11);
    let mut random = Random::new(4);
    data.extend((0..40).map(|_| Vector2::new(random.uniform() * 8.0 - 4.0, random.uniform() * 6.0 - 3.0)));
    let fitted = |robust| {
        let loop_options = FitOptions::default().with_robust(robust);
        let options =
            CurveOptions::default().with_controls(Some(16)).with_closed(Some(true)).with_fit(loop_options);
        let first = fit_curve(&data[..400], None, &options).unwrap().curve;
        deviation(&fit_curve(&data, Some(&first), &options).unwrap().curve, lobes)
    };
    let kernel = Robust::Kernel { kernel: distance_field::Kernel::Tukey, abs_scale: None };
    let (plain, trimmed, kernel) =
        (fitted(Robust::None), fitted(Robust::Trimmed { outliers: 0.12 }), fitted(kernel));
    assert!(trimmed < 0.01 && kernel < 0.01 && plain > 2.0 * kernel, "{plain} {trimmed} {kernel}");
}

#[test]
fn cancelling_returns_the_curve_so_far() {
    let data = noisy_lobes(200, 0.05, 2);
    let stop = |record: &sdm_fit::FitStep| {
        if record.iteration >= 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let fitted =
        fit_curve_with_progress(&data, None, &CurveOptions::default().with_controls(Some(12)), &stop)
            .unwrap();
    assert_eq!((fitted.report.status, fitted.report.iterations), (Status::Cancelled, 3));
}

#[test]
fn ends_are_where_and_as_they_are_given() {
    let wave = |t: f64| Vector2::new(6.0 * t, (6.0 * t).sin());
    let points: Vec<_> =
        (0..200).map(|k| wave(0.005 + 0.99 * (f64::from(k * 37 % 200) + 0.5) / 200.0)).collect();
    // Given in the other order, and the second with a direction that the points do not have.
    let slanted = [0.8, 0.6, 0.0];
    let at = |t: f64| [wave(t).x, wave(t).y, 0.0];
    let tangent = [1.0, 1.0, 0.0];
    let ends = [
        Some(CurveEnd { point: at(1.0), direction: None }),
        Some(CurveEnd { point: at(0.0), direction: Some(slanted) }),
    ];
    let options = CurveOptions::default().with_ends(ends);
    let fitted = fit_curve(&points, None, &options).unwrap();
    let (curve, domain) = (&fitted.curve, fitted.curve.domain());
    let [first, last] = [domain.start(), domain.end()].map(|t| curve.jet(t));
    let [low, high] = if first.point.x < last.point.x { [first, last] } else { [last, first] };
    assert!((low.point - wave(0.0)).norm() < 1e-12 && (high.point - wave(1.0)).norm() < 1e-12);
    let sense = if first.point.x < last.point.x { 1.0 } else { -1.0 };
    let way = low.d1.normalize() * sense;
    assert!((way - Vector2::new(0.8, 0.6)).norm() < 1e-10, "{way:?}");
    assert!(fitted.report.covered, "{}", fitted.report);
    // With the right direction it is nearer to the points than with a slanted one.
    let right = [ends[0], Some(CurveEnd { point: at(0.0), direction: Some(tangent) })];
    let better = fit_curve(&points, None, &options.with_ends(right)).unwrap();
    assert!(better.report.rms < 0.5 * fitted.report.rms, "{} {}", better.report, fitted.report);
    assert!(fit_curve(&points, None, &options.with_rational(true)).is_err());
}
