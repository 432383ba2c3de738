//! Exactness on bicubic patches: the Utah teapot.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, Interval, KnotVector, ParametricSurface};
use sdm_fit::{FitOptions, Smoothing, SurfaceOptions, fit_surface};

/// The patches whose four corners are different points.
fn patches() -> Vec<BsplineSurface> {
    let text = include_str!("../../../fixtures/nurbs/utah_teapot_patches.txt");
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let mut numbers = |_: &str| -> Vec<f64> {
        lines.next().unwrap().replace("- ", "-").split_whitespace().map(|w| w.parse().unwrap()).collect()
    };
    let count = numbers("patches")[0] as usize;
    let indices: Vec<Vec<f64>> = (0..count).map(|_| numbers("indices")).collect();
    let vertices = numbers("vertices")[0] as usize;
    let points: Vec<Vector3<f64>> =
        (0..vertices).map(|_| Vector3::from_row_slice(&numbers("point"))).collect();
    let knots = KnotVector::bezier(3, Interval::UNIT).unwrap();
    let net = |patch: &Vec<f64>| patch.iter().map(|&k| points[k as usize]).collect::<Vec<_>>();
    let whole = |net: &Vec<Vector3<f64>>| {
        let corners = [net[0], net[3], net[12], net[15]];
        (0..4).all(|i| (0..i).all(|j| (corners[i] - corners[j]).norm() > 1e-9))
    };
    let nets = indices.iter().map(net).filter(whole);
    nets.map(|net| BsplineSurface::new(knots.clone(), knots.clone(), net, None).unwrap()).collect()
}

#[test]
fn points_of_a_patch_give_its_control_points() {
    let patches = patches();
    assert!(patches.len() >= 20);
    for (number, truth) in patches.iter().enumerate() {
        let points: Vec<_> =
            (0..400).map(|k| truth.point(f64::from(k / 20) / 19.0, f64::from(k % 20) / 19.0)).collect();
        let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
        // The boundary tells where parameter lines are; the four inner control points are not where they belong.
        let mut net = truth.control_points().to_vec();
        for (k, i) in [5, 6, 9, 10].into_iter().enumerate() {
            let s = |x: f64| (x * (number + k + 1) as f64).sin();
            net[i] += Vector3::new(s(1.3), s(2.1), s(3.7)) * (0.02 * size);
        }
        let start = BsplineSurface::new(truth.knots_u().clone(), truth.knots_v().clone(), net, None).unwrap();
        let fit = FitOptions::default()
            .with_smoothing(Smoothing::Continuation { start: 1e-8, factor: 0.01, floor: 0.0 })
            .with_cost_tolerance(0.0);
        let options = SurfaceOptions::default().with_fixed_boundary(true).with_fit(fit);
        let found = fit_surface(&points, start, &options).unwrap();
        assert!(found.report.fit.rms < 1e-10 * size, "{number}: {}", found.report);
        let off =
            truth.control_points().iter().zip(found.surface.control_points()).map(|(a, b)| (a - b).norm());
        let off = off.fold(0.0, f64::max);
        assert!(off < 1e-9 * size, "{number}: {off:e} of {size}, {}", found.report);
    }
}
