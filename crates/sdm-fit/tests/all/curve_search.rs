//! Curves whose start is far away (\[P05, Fig. 8\]).
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use crate::curve_cases::points;
use nalgebra::{Vector2, Vector3};
use nurbs_core::{BsplineCurve, KnotVector};
use sdm_fit::Error;
use sdm_fit::curve::{CurveOptions, CurveStart, fit_curve};
use std::f64::consts::{PI, TAU};

/// The outline of a long bent body: a band about an arc of three quarters of a turn, with round ends.
fn horseshoe(count: usize) -> Vec<Vector2<f64>> {
    let (radius, half, turn) = (3.0, 0.5, 1.5 * PI);
    let polar = |r: f64, a: f64| Vector2::new(r * a.cos(), r * a.sin());
    let lengths = [(radius + half) * turn, PI * half, (radius - half) * turn, PI * half];
    let total: f64 = lengths.iter().sum();
    let at = |k: usize| {
        let mut s = total * k as f64 / count as f64;
        let piece = lengths.iter().position(|length| {
            let inside = s < *length;
            if !inside {
                s -= length;
            }
            inside
        });
        let cap = |a: f64, from: f64| polar(radius, a) + polar(half, from + s / half);
        match piece {
            Some(0) => polar(radius + half, s / (radius + half)),
            Some(1) => cap(turn, turn),
            Some(2) => polar(radius - half, turn - s / (radius - half)),
            _ => cap(0.0, PI),
        }
    };
    (0..count).map(at).collect()
}

fn circle(radius: f64, centre: Vector2<f64>, controls: usize) -> BsplineCurve<2> {
    let at = |i: usize| {
        let a = TAU * (i % controls) as f64 / controls as f64;
        centre + Vector2::new(a.cos(), a.sin()) * radius
    };
    let knots = KnotVector::uniform_periodic(3, controls).unwrap();
    BsplineCurve::new(knots, (0..controls + 3).map(at).collect(), None).unwrap()
}

#[test]
fn a_start_far_away_finds_the_whole_outline() {
    let data = horseshoe(600);
    let plain = CurveOptions::default();
    for centre in [Vector2::new(3.0, -0.2), Vector2::new(6.0, 5.0), Vector2::new(0.0, 0.0)] {
        let start = circle(0.6, centre, 24);
        let lost = fit_curve(&data, Some(&start), &plain).unwrap().report;
        let options = plain.with_search(true).with_fit(plain.fit.with_evolution(true));
        let found = fit_curve(&data, Some(&start), &options).unwrap();
        let report = &found.report;
        assert!(report.rms < 0.01 && report.max < 0.05 && report.crossings.is_empty(), "{centre}: {report}");
        assert_eq!((report.start, report.controls), (CurveStart::Contour, 24));
        // The start, its growth, and the iterations.
        assert!(found.evolution.len() > 9 && found.evolution[0].control_points() == start.control_points());
        assert!(lost.rms > 5.0 * report.rms || !lost.crossings.is_empty(), "{centre}: {lost}");
    }
    // Without a start.
    let report = fit_curve(&data, None, &plain.with_search(true).with_controls(Some(24))).unwrap().report;
    assert!(report.rms < 0.01 && report.closed && report.crossings.is_empty(), "{report}");
}

#[test]
fn noise_and_gaps_are_bridged() {
    let noisy = points::<2>("a2_noisy.xyz");
    let report = fit_curve(&noisy, None, &CurveOptions::default().with_search(true).with_controls(Some(12)))
        .unwrap()
        .report;
    assert!(report.crossings.is_empty() && report.rms < 0.17, "{report}");
    // A part of the outline is missing that is wider than half the body.
    let data: Vec<_> = horseshoe(600).into_iter().skip(12).collect();
    let report = fit_curve(&data, None, &CurveOptions::default().with_search(true).with_controls(Some(24)))
        .unwrap()
        .report;
    assert!(report.rms < 0.02 && report.crossings.is_empty(), "{report}");
}

#[test]
fn what_encloses_nothing_is_refused() {
    let options = CurveOptions::default().with_search(true);
    let arc: Vec<_> = (0..200).map(|k| f64::from(k) / 200.0).map(|t| Vector2::new(t, 0.1 * t * t)).collect();
    let found = fit_curve(&arc, None, &options).map(|fit| fit.report);
    assert!(matches!(found, Err(Error::Degenerate { .. })), "{found:?}");
    let helix: Vec<_> =
        (0..200).map(|k| f64::from(k) / 20.0).map(|t| Vector3::new(t.cos(), t.sin(), t)).collect();
    assert!(matches!(fit_curve(&helix, None, &options), Err(Error::Option { name: "search", .. })));
}
