//! Surfaces that keep to their points: threads within a tolerance without folds, ends where the points end.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use nalgebra::Vector3;
use nurbs_core::ParametricSurface;
use sdm_fit::{BaseShape, NetSize, Status, SurfaceOptions, fit_cloud};
use std::f64::consts::TAU;

/// The fractional parts of multiples of two irrational numbers: evenly spread in the unit square.
fn spread(k: usize) -> [f64; 2] {
    [0.754_877_666_246_692_7, 0.569_840_290_998_053_2].map(|step| (step * (k + 1) as f64).fract())
}

#[test]
fn a_thread_comes_within_the_tolerance_without_folds() {
    // A rod of radius 10 with a thread .8 deep, 2.5 from turn to turn.
    let point = |k: usize| {
        let [angle, height] = spread(k);
        let turn = (height * 4.0 - angle).rem_euclid(1.0);
        let r = 10.0 + 0.4 * (TAU * turn).cos() - 0.1 * (2.0 * TAU * turn).cos();
        Vector3::new(r * (TAU * angle).cos(), r * (TAU * angle).sin(), 10.0 * height)
    };
    let points: Vec<_> = (0..4000).map(point).collect();
    let tolerance = 0.05;
    let options = SurfaceOptions::default().with_base(BaseShape::Cylinder);
    let found = fit_cloud(&points, &options.with_abs_tolerance(Some(tolerance))).unwrap();
    let report = &found.report;
    assert!(report.within_tolerance && report.fit.max <= tolerance, "{report}");
    assert_eq!((report.folds.count(), report.fit.status), (0, Status::Converged), "{report}");
    assert!(report.controls[0] * report.controls[1] <= 1200, "{report}");
    assert!(report.fit.history.len() <= 80, "{report}");
}

#[test]
fn few_control_points_end_where_the_points_end() {
    // Five lobes that hardly fit into twelve control points around.
    let point = |k: usize| {
        let [angle, height] = spread(k);
        let r = 60.0
            * (1.0
                + 0.25 * (3.0 * height + 0.4).sin()
                + 0.12 * (5.0 * TAU * angle + 2.0 * height).cos() * (0.3 + height));
        Vector3::new(r * (TAU * angle).cos(), r * (TAU * angle).sin(), 247.0 * height)
    };
    let points: Vec<_> = (0..6000).map(point).collect();
    let size = NetSize { controls: [20, 20], ..NetSize::default() };
    let found = fit_cloud(&points, &SurfaceOptions::default().with_size(size)).unwrap();
    let [u, v] = found.surface.domain();
    for k in 0..200 {
        for end in [v.start(), v.end()] {
            let z = found.surface.point(u.lerp(f64::from(k) / 200.0), end).z;
            assert!(z > -6.0 && z < 253.0, "{z}: {}", found.report);
        }
    }
}
