//! Curves that stay with their points, and reports that say where they do not.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use crate::curve_cases::Random;
use distance_field::{ErrorTerm, Kernel};
use nalgebra::{SVector, Vector2, Vector3};
use nurbs_core::{BsplineCurve, KnotVector, ParametricCurve};
use sdm_fit::curve::{Closure, CurveFit, CurveOptions, fit_curve, fit_curves};
use sdm_fit::{Error, FitOptions, Robust, Smoothing, StepControl};
use std::f64::consts::{PI, TAU};

fn polar(r: f64, a: f64) -> Vector2<f64> {
    Vector2::new(r * a.cos(), r * a.sin())
}

/// Points of a curve over `[0, 1]` at random parameters, with noise.
fn random(count: usize, sigma: f64, seed: u64, at: impl Fn(f64) -> Vector2<f64>) -> Vec<Vector2<f64>> {
    let mut random = Random::new(seed);
    (0..count)
        .map(|_| {
            let place = at(random.uniform());
            place + Vector2::new(random.normal(), random.normal()) * sigma
        })
        .collect()
}

/// The same at random lengths: as dense everywhere.
fn even(count: usize, sigma: f64, seed: u64, at: impl Fn(f64) -> Vector2<f64>) -> Vec<Vector2<f64>> {
    let fine: Vec<_> = (0..=4000).map(|k| at(f64::from(k) / 4000.0)).collect();
    let mut lengths = vec![0.0];
    for (k, pair) in fine.windows(2).enumerate() {
        lengths.push(lengths[k] + (pair[1] - pair[0]).norm());
    }
    random(count, sigma, seed, |t| {
        let k = lengths.partition_point(|l| *l <= t * lengths[4000]).clamp(1, 4000);
        let share = (t * lengths[4000] - lengths[k - 1]) / (lengths[k] - lengths[k - 1]);
        fine[k - 1] + (fine[k] - fine[k - 1]) * share
    })
}

/// The largest distance of a curve from a true one, and back.
fn off(curve: &BsplineCurve<2>, truth: impl Fn(f64) -> Vector2<f64>) -> f64 {
    let truth: Vec<_> = (0..4000).map(|k| truth(f64::from(k) / 4000.0)).collect();
    let found: Vec<_> = (0..2000).map(|k| curve.point(curve.domain().lerp(f64::from(k) / 2000.0))).collect();
    let far = |from: &[Vector2<f64>], to: &[Vector2<f64>]| {
        let nearest = |p: &Vector2<f64>| to.iter().map(|q| (q - p).norm()).fold(f64::INFINITY, f64::min);
        from.iter().map(nearest).fold(0.0, f64::max)
    };
    far(&found, &truth).max(far(&truth, &found))
}

fn plain<const D: usize>(points: &[SVector<f64, D>]) -> CurveFit<D> {
    fit_curve(points, None, &CurveOptions::default()).unwrap()
}

fn wave(t: f64) -> Vector2<f64> {
    Vector2::new(30.0 * t, 3.0 * (30.0 * t).sin())
}

#[test]
fn open_curves_end_where_their_points_do() {
    for seed in 1..3 {
        for count in [300_u16, 600] {
            let data = random(usize::from(count), 0.05, seed, wave);
            let fitted = plain(&data);
            let report = &fitted.report;
            // Where there are no points nobody knows.
            let nearest = |q: Vector2<f64>| data.iter().map(|p| (p - q).norm()).fold(f64::INFINITY, f64::min);
            let widest = (0..4000).map(|k| nearest(wave(f64::from(k) / 4000.0))).fold(0.0, f64::max);
            let allowed = 0.2 + widest;
            assert!(off(&fitted.curve, wave) < allowed, "{seed} {count}: {}", off(&fitted.curve, wave));
            assert!(!report.closed && report.covered && report.fault().is_none(), "{report}");
            let coverage = &report.coverage;
            assert!(
                (coverage.length / 66.4 - 1.0).abs() < 0.1 && coverage.length_ratio < 1.1,
                "{coverage:?}"
            );
            assert!((coverage.spacing * f64::from(count) / 66.4 - 1.0).abs() < 0.15, "{coverage:?}");
            assert!(coverage.noise > 0.02 && coverage.noise < 0.08, "{coverage:?}");
        }
    }
}

#[test]
fn curves_are_followed_through_their_crossings() {
    let rose = |t: f64| polar(10.0 * (3.0 * PI * t).cos(), PI * t);
    let limacon = |t: f64| polar(4.0 + 8.0 * (TAU * t).cos(), TAU * t);
    let spiral = |t: f64| polar(1.0 + 9.4 * t, 5.0 * PI * t);

    let seed = 1;
    let fitted = plain(&even(300, 0.05, seed, rose));
    let distance = off(&fitted.curve, rose);
    assert!(fitted.report.closed && fitted.report.covered, "rose {seed}: {}", fitted.report);
    assert!(distance < 0.7 && !fitted.report.crossings.is_empty(), "rose {seed}: {distance}");
    let fitted = plain(&even(300, 0.03, seed, limacon));
    let distance = off(&fitted.curve, limacon);
    assert!(fitted.report.closed && fitted.report.covered, "limacon {seed}: {}", fitted.report);
    assert!(distance < 0.7 && fitted.report.crossings.len() == 1, "limacon {seed}: {distance}");
    let fitted = plain(&even(300, 0.03, seed, spiral));
    let distance = off(&fitted.curve, spiral);
    assert!(!fitted.report.closed && fitted.report.covered, "spiral {seed}: {}", fitted.report);
    assert!(distance < 1.0, "spiral {seed}: {distance}");
}

#[test]
fn the_largest_gap_beside_the_others_decides_on_closure() {
    let wheel = |t: f64| polar(10.0 + 2.0 * (8.0 * TAU * t).cos(), TAU * t);
    for seed in 1..3 {
        let report = plain(&random(600, 0.05, seed, wheel)).report;
        let Closure::Gap { gap, limit } = report.closure else { panic!("{:?}", report.closure) };
        assert!(report.closed && gap <= limit && report.covered, "{seed}: {report}");
    }
    // An arc whose ends are ten even steps apart is open, one with two hundred random points as well.
    let even: Vec<_> = (0..351).map(|k| polar(5.0, f64::from(k * 100 % 351).to_radians())).collect();
    assert!(!plain(&even).report.closed);
    let report = plain(&random(200, 0.0, 7, |t| polar(5.0, 4.8 * t))).report;
    assert!(!report.closed && report.covered, "{report}");
}

#[test]
fn sparse_outlines_keep_their_inlets() {
    // Three narrow inlets, 47 points.
    let outline = |t: f64| polar(10.0 - 7.0 * (1.5 * TAU * t).cos().powi(8), TAU * t);
    let fine: Vec<_> = (0..=4700).map(|k| outline(f64::from(k) / 4700.0)).collect();
    let total: f64 = fine.windows(2).map(|p| (p[1] - p[0]).norm()).sum();
    let (mut points, mut length) = (Vec::new(), 0.0);
    for pair in fine.windows(2) {
        if points.len() < 47 && length >= total * points.len() as f64 / 47.0 {
            points.push(pair[0]);
        }
        length += (pair[1] - pair[0]).norm();
    }
    let shuffled: Vec<_> = (0..47).map(|k| points[k * 20 % 47]).collect();
    let fitted = plain(&shuffled);
    assert!(fitted.report.closed && fitted.report.covered, "{}", fitted.report);
    let distance = off(&fitted.curve, outline);
    assert!(distance < 1.5 && fitted.report.crossings.is_empty(), "{distance} {}", fitted.report);
}

#[test]
fn several_outlines_become_several_curves() {
    let at = |i: usize, n: usize| TAU * (i * 37 % n) as f64 / n as f64;
    let ellipse = |n: usize, c: [f64; 2], r: [f64; 2]| {
        (0..n).map(move |i| Vector2::new(c[0] + r[0] * at(i, n).cos(), c[1] + r[1] * at(i, n).sin()))
    };
    let mut points: Vec<_> = ellipse(90, [0.0, 0.0], [30.0, 20.0]).collect();
    points.extend(ellipse(41, [4.0, 1.0], [10.0, 6.0]));
    let mixed: Vec<_> = (0..131).map(|k| points[k * 50 % 131]).collect();
    let error = fit_curve(&mixed, None, &CurveOptions::default()).map(|f| f.report);
    let Err(Error::SeveralParts { mut sizes }) = error else { panic!("{error:?}") };
    sizes.sort_unstable();
    assert_eq!(sizes, [41, 90]);
    let parts = fit_curves(&mixed, &CurveOptions::default()).unwrap();
    assert_eq!(parts.len(), 2);
    for part in &parts {
        let report = &part.fit.report;
        assert!(report.closed && report.covered && report.max < 0.1, "{report}");
        assert!(part.points.len() == report.points);
    }
    // One curve through both, if that is asked for, has parts without points, and it is said where.
    let one = fit_curve(&mixed, None, &CurveOptions::default().with_closed(Some(true))).unwrap().report;
    assert!(!one.covered && one.fault().is_some(), "{one}");
    // In their order, one after the other, they are two as well; a wide gap may be allowed.
    assert_eq!(fit_curves(&points, &CurveOptions::default()).unwrap().len(), 2);
    let arcs: Vec<_> =
        (0..200).filter(|k| !(80..110).contains(k)).map(|k| wave(f64::from(k) / 199.0)).collect();
    assert_eq!(fit_curves(&arcs, &CurveOptions::default()).unwrap().len(), 2);
    let one = fit_curves(&arcs, &CurveOptions::default().with_max_gap(Some(20.0))).unwrap();
    assert!(one.len() == 1 && one[0].fit.report.covered, "{}", one[0].fit.report);
}

#[test]
fn a_start_that_is_right_is_kept() {
    for periodic in [false, true] {
        let knots = if periodic {
            KnotVector::uniform_periodic(3, 9).unwrap()
        } else {
            KnotVector::new(3, vec![0., 0., 0., 0., 0.15, 0.4, 0.45, 0.8, 1., 1., 1., 1.]).unwrap()
        };
        let ring = |i: usize| {
            let a = TAU * (i % 9) as f64 / 9.0;
            let r = 3.0 + [0.3, -0.5, 0.2, 0.9, -0.4, 0.0, 0.6, -0.2, 0.1][i % 9];
            if periodic { polar(r, a) } else { Vector2::new(i as f64, r) }
        };
        let net: Vec<_> = (0..knots.basis_count()).map(ring).collect();
        let curve = BsplineCurve::new(knots, net, None).unwrap();
        let data: Vec<_> =
            (0..=400).map(|k| curve.point(curve.domain().lerp(f64::from(k) / 400.0))).collect();
        let continuation = Smoothing::Continuation { start: 1e-2, factor: 0.5, floor: 0.0 };
        for smoothing in [continuation, Smoothing::NONE, Smoothing::default()] {
            let options = CurveOptions::default().with_fit(FitOptions::default().with_smoothing(smoothing));
            let fitted = fit_curve(&data, Some(&curve), &options).unwrap();
            for (a, b) in fitted.curve.control_points().iter().zip(curve.control_points()) {
                assert!((a - b).norm() < 1e-12, "{periodic} {smoothing:?}: {}", (a - b).norm());
            }
            assert!(fitted.report.is_converged() && fitted.report.covered, "{}", fitted.report);
        }
    }
}

#[test]
fn clouds_that_are_no_curve_are_not_covered() {
    let mut random = Random::new(3);
    let square: Vec<_> = (0..600).map(|_| Vector2::new(random.uniform(), random.uniform())).collect();
    let report = plain(&square).report;
    assert!(!report.covered && report.fault().is_some(), "{report}");
    let ball: Vec<Vector3<f64>> = (0..1500)
        .map(|_| Vector3::from_fn(|_, _| 2.0 * random.uniform() - 1.0))
        .filter(|p| p.norm() <= 1.0)
        .collect();
    let report = plain(&ball).report;
    assert!(!report.covered, "{report}");
}

#[test]
fn outliers_do_no_harm_where_they_are_left_out() {
    let robust = Robust::Kernel { kernel: Kernel::Tukey, abs_scale: None };
    let options = CurveOptions::default().with_fit(FitOptions::default().with_robust(robust));
    let oval = |t: f64| Vector2::new(9.0 * (TAU * t).cos(), 5.0 * (TAU * t).sin());
    let mut sums = [0.0; 2];
    for seed in 1..3 {
        let mut data = random(400, 0.03, seed, oval);
        let mut more = Random::new(seed + 100);
        data.extend((0..4).map(|_| Vector2::new(24.0 * more.uniform() - 12.0, 14.0 * more.uniform() - 7.0)));
        let found = fit_curve(&data, None, &options).unwrap();
        let distance = off(&found.curve, oval);
        assert!(found.report.closed && found.report.covered, "{seed}: {}", found.report);
        assert!(distance < 0.1 && found.report.used < 404, "{seed}: {distance} {}", found.report);
        sums[0] += distance;
        // All points count unless that is asked for.
        match fit_curve(&data, None, &CurveOptions::default()) {
            Ok(plain) => {
                assert!(!plain.report.covered && plain.report.used == 404, "{seed}: {}", plain.report);
                sums[1] += off(&plain.curve, oval);
            }
            Err(error) => panic!("{error}"),
        }
    }
    assert!(sums[0] <= sums[1], "{sums:?}");
    // One point at the end of the world.
    let mut data = random(300, 0.03, 5, oval);
    data.push(Vector2::new(1e300, -1e300));
    let all = plain(&data);
    assert!(!all.report.covered && all.report.astray == 1 && off(&all.curve, oval) < 0.2, "{}", all.report);
    assert!(all.report.max > 1e299 && all.report.max_index == 300 && all.report.rms.is_finite());
    let report = fit_curve(&data, None, &options).unwrap().report;
    assert!(report.covered && report.max < 0.2, "{report}");
}

#[test]
fn conics_are_exact_with_a_number_of_control_points_too() {
    let circle: Vec<_> = (0..100).map(|k| polar(5.0, TAU * f64::from(k * 37 % 100) / 100.0)).collect();
    for controls in [6, 7, 8, 11] {
        let options = CurveOptions::default().with_rational(true).with_controls(Some(controls));
        let fitted = fit_curve(&circle, None, &options).unwrap();
        assert_eq!(fitted.report.controls, controls);
        for k in 0..500 {
            let place = fitted.curve.point(fitted.curve.domain().lerp(f64::from(k) / 500.0));
            assert!((place.norm() - 5.0).abs() < 1e-9, "{controls}: {}", fitted.report);
        }
    }
}

#[test]
fn a_search_is_never_worse_than_none() {
    let wheel = |t: f64| polar(10.0 + 2.0 * (5.0 * TAU * t).cos(), TAU * t);
    let data: Vec<_> = (0..400).map(|k| wheel(f64::from(k * 71 % 400) / 400.0)).collect();
    for options in [
        CurveOptions::default().with_controls(Some(8)),
        CurveOptions::default().with_abs_tolerance(Some(0.05)),
        CurveOptions::default(),
    ] {
        let plain = fit_curve(&data, None, &options).unwrap().report;
        let searched = fit_curve(&data, None, &options.with_search(true)).unwrap().report;
        assert!(searched.crossings.len() <= plain.crossings.len(), "{searched}\n{plain}");
        assert!(
            !plain.covered || searched.covered && searched.rms <= plain.rms * 1.0001,
            "{searched}\n{plain}"
        );
    }
}

#[test]
fn thin_sections_stay_one_closed_curve() {
    // Points are dense at the ends and wide apart on the sides, as far as these are from each other.
    let at = |k: i32| {
        let a = TAU * f64::from(k * 77 % 100) / 100.0;
        let a = a - 0.49 * (2.0 * a).sin();
        Vector2::new(20.0 * a.cos(), a.sin())
    };
    let data: Vec<_> = (0..100).map(at).collect();
    for tolerance in [None, Some(0.05)] {
        let fits = fit_curves(&data, &CurveOptions::default().with_abs_tolerance(tolerance)).unwrap();
        assert_eq!(fits.len(), 1);
        let report = &fits[0].fit.report;
        assert!(report.closed && report.covered && report.crossings.is_empty(), "{report}");
        assert!(off(&fits[0].fit.curve, |t| Vector2::new(20.0 * (TAU * t).cos(), (TAU * t).sin())) < 0.5);
    }
}

#[test]
fn steps_that_are_no_newton_steps_are_counted() {
    let knots = KnotVector::uniform_periodic(3, 8).unwrap();
    let net = (0..knots.basis_count()).map(|i| polar(3.0, TAU * (i % 8) as f64 / 8.0)).collect();
    let start = BsplineCurve::new(knots, net, None).unwrap();
    let data: Vec<_> = (0..80).map(|k| polar(1.0, TAU * f64::from(k) / 80.0)).collect();
    let options = |term| {
        let fit =
            FitOptions::default().with_term(term).with_control(StepControl::None).with_max_iterations(3);
        CurveOptions::default().with_fit(fit.with_smoothing(Smoothing::Fixed { lambda: 1e-6 }))
    };
    // Points behind the centres of curvature: the Taylor model is not positive definite there.
    let literal = fit_curve(&data, Some(&start), &options(ErrorTerm::Taylor)).unwrap().report;
    assert!(literal.steps_lifted > 0, "{literal}");
    let point = fit_curve(&data, Some(&start), &options(ErrorTerm::Point)).unwrap().report;
    assert_eq!(point.steps_lifted, 0, "{point}");
}
