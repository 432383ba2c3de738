//! Multilevel B-splines through the public interface.

use cloud_param::{Error, MultilevelOptions, MultilevelStatus, Trend, Weighting, multilevel};
use nalgebra::Vector3;
use nurbs_core::{Interval, ParametricSurface};
use proptest::prelude::*;

fn scattered(count: u32, f: impl Fn(f64, f64) -> f64) -> Vec<Vector3<f64>> {
    (0..count)
        .map(|i| {
            (
                4.0 * (f64::from(i) * 0.754877666).fract() - 1.0,
                2.0 * (f64::from(i) * 0.569840291).fract() + 5.0,
            )
        })
        .map(|(x, y)| Vector3::new(x, y, f(x, y)))
        .collect()
}

#[test]
fn planes_come_back_exactly() {
    let plane = |x: f64, y: f64| 3.0 - 0.5 * x + 0.25 * y;
    let points = scattered(500, plane);
    for weighting in [Weighting::Squared, Weighting::Linear] {
        let options = MultilevelOptions::default().with_weighting(weighting);
        let (field, report) = multilevel(&points, None, &options).unwrap();
        assert!(report.rms < 1e-11);
        assert_eq!(report.status, MultilevelStatus::Converged);
        assert!((field.value(0.3, 6.1) - plane(0.3, 6.1)).abs() < 1e-10);
        let slope = field.gradient(0.3, 6.1);
        assert!((slope[0] + 0.5).abs() < 1e-9 && (slope[1] - 0.25).abs() < 1e-9);
    }
    let level = MultilevelOptions::default().with_trend(Trend::Mean);
    let (field, _) = multilevel(&scattered(500, |_, _| 1.0), None, &level).unwrap();
    assert!((field.value(1.0, 6.0) - 1.0).abs() < 1e-14);
}

#[test]
fn every_level_comes_nearer_and_the_tolerance_ends_it() {
    let points = scattered(20_000, |x, y| (2.0 * x).sin() * (3.0 * y).cos());
    let options = MultilevelOptions::default().with_tolerance(1e-3);
    let (_, report) = multilevel(&points, None, &options).unwrap();
    assert_eq!(report.status, MultilevelStatus::Converged);
    assert!(report.rms <= 2e-3);
    assert!(report.history.windows(2).all(|w| w[1].rms < w[0].rms));
    let (_, coarse) = multilevel(&points, None, &options.with_max_levels(2)).unwrap();
    assert_eq!((coarse.status, coarse.history.len()), (MultilevelStatus::MaxLevels, 2));
}

#[test]
fn the_linear_weights_are_less_sensitive_to_outliers() {
    let mut points = scattered(4000, |x, y| 0.2 * x * y);
    for p in points.iter_mut().step_by(97) {
        p.z += 10.0;
    }
    let error = |weighting| {
        let options = MultilevelOptions::default().with_weighting(weighting).with_max_levels(5);
        let (field, _) = multilevel(&points, None, &options).unwrap();
        let clean = points.iter().enumerate().filter(|(i, _)| i % 97 != 0);
        clean.map(|(_, p)| (field.value(p.x, p.y) - p.z).powi(2)).sum::<f64>()
    };
    assert!(error(Weighting::Linear) < error(Weighting::Squared));
}

#[test]
fn domains_and_errors() {
    let points = scattered(100, |x, _| x);
    let options = MultilevelOptions::default();
    let far = Interval::new(100.0, 200.0).unwrap();
    assert!(matches!(
        multilevel(&points, Some([far, far]), &options),
        Err(Error::TooFewPoints { usable: 0, .. })
    ));
    let column = [Vector3::new(1.0, 2.0, 3.0); 4];
    assert!(matches!(multilevel(&column, None, &options), Err(Error::EmptyDomain { .. })));
    assert!(multilevel(&[], None, &options).is_err());
    assert!(multilevel(&points, None, &options.with_max_levels(0)).is_err());
    assert!(multilevel(&points, None, &options.with_tolerance(f64::NAN)).is_err());
    let mut dirty = points;
    dirty[3].z = f64::NAN;
    let (_, report) = multilevel(&dirty, None, &options).unwrap();
    assert_eq!((report.points, report.used), (100, 99));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 32, ..ProptestConfig::default() })]

    #[test]
    fn the_surface_is_the_graph(seed in 0.0..1.0f64, levels in 1usize..5) {
        let points = scattered(300, |x, y| (x + seed).sin() + y * seed);
        let options = MultilevelOptions::default().with_max_levels(levels).with_tolerance(0.0);
        let (field, _) = multilevel(&points, None, &options).unwrap();
        let surface = field.to_surface().unwrap();
        for p in points.iter().step_by(7) {
            let on = surface.point(p.x, p.y);
            prop_assert!((on.x - p.x).abs() < 1e-12 && (on.y - p.y).abs() < 1e-12);
            prop_assert!((on.z - field.value(p.x, p.y)).abs() < 1e-12);
            let (slope, jet) = (field.gradient(p.x, p.y), surface.jet(p.x, p.y));
            prop_assert!((slope[0] - jet.du.z).abs() < 1e-9 && (slope[1] - jet.dv.z).abs() < 1e-9);
        }
    }
}
