//! Points sampled on the bicubic patches of the Utah teapot, fitted with the same knots: with their parameters the control points
//! come back, and stay where they are in a fit without parameters; from a displaced net and without parameters the shape does.
//! (Its control points do not: parameters that slide along a patch hardly change it. With the boundary given they do.)
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use distance_field::ErrorTerm;
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, Interval, KnotVector, ParametricSurface, SurfaceFitOptions};
use sdm_fit::{
    ActiveSurface, Constraints, FitOptions, FootpointPolicy, Smoothing, SurfaceOptions, Target, fit,
    fit_surface,
};

/// The patches of the fixture.
fn patches() -> Vec<BsplineSurface> {
    let path = format!("{}/../../fixtures/nurbs/utah_teapot_patches.txt", env!("CARGO_MANIFEST_DIR"));
    // Signs stand apart from their numbers.
    let text = std::fs::read_to_string(path).unwrap().replace("- ", "-");
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let mut rows = |count: Option<usize>| -> Vec<Vec<f64>> {
        let count = count.unwrap_or_else(|| lines.next().unwrap().trim().parse().unwrap());
        let row = |line: &str| line.split_whitespace().map(|word| word.parse().unwrap()).collect();
        lines.by_ref().take(count).map(row).collect()
    };
    let (indices, vertices) = (rows(None), rows(None));
    let bezier = KnotVector::bezier(3, Interval::UNIT).unwrap();
    #[allow(clippy::cast_possible_truncation, reason = "small whole numbers")]
    let place = |index: &f64| Vector3::from_column_slice(&vertices[*index as usize]);
    let surface = |row: &Vec<f64>| {
        BsplineSurface::new(bezier.clone(), bezier.clone(), row.iter().map(place).collect(), None).unwrap()
    };
    indices.iter().map(surface).collect()
}

/// A grid of parameters, and the points of a patch there.
fn sample(patch: &BsplineSurface) -> (Vec<[f64; 2]>, Vec<Vector3<f64>>) {
    let at = |k: usize| k as f64 / 12.0;
    let parameters: Vec<[f64; 2]> = (0..13 * 13).map(|k| [at(k / 13), at(k % 13)]).collect();
    let points = parameters.iter().map(|[u, v]| patch.point(*u, *v)).collect();
    (parameters, points)
}

fn size(patch: &BsplineSurface) -> f64 {
    let net = patch.control_points();
    net.iter().map(|p| (p - net[0]).norm()).fold(0.0, f64::max)
}

fn largest_difference(one: &[Vector3<f64>], other: &[Vector3<f64>]) -> f64 {
    one.iter().zip(other).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

fn options(iterations: usize) -> FitOptions {
    FitOptions::default()
        .with_smoothing(Smoothing::NONE)
        .with_footpoints(FootpointPolicy::Global)
        .with_max_iterations(iterations)
        .with_tolerance(1e-13)
        .with_cost_tolerance(0.0)
}

#[test]
fn control_points_come_back_and_stay() {
    let patches = patches();
    assert_eq!(patches.len(), 32);
    for (number, patch) in patches.iter().enumerate() {
        let (parameters, points) = sample(patch);
        let knots = [patch.knots_u().clone(), patch.knots_v().clone()];
        let solved =
            BsplineSurface::approximate(knots, &parameters, &points, &SurfaceFitOptions::default()).unwrap();
        let error = largest_difference(solved.shape.control_points(), patch.control_points());
        assert!(error <= 1e-9 * size(patch), "patch {number}: {error}");
        for term in [ErrorTerm::Point, ErrorTerm::SquaredDistance] {
            let target = Target::Points { points: &points, weights: None };
            let start = ActiveSurface::new(solved.shape.clone()).unwrap();
            let found = fit(start, target, &Constraints::none(), &options(3).with_term(term)).unwrap();
            let moved = largest_difference(found.shape.surface().control_points(), patch.control_points());
            assert!(moved <= 1e-9 * size(patch), "patch {number}, {term:?}: {moved} {}", found.report);
        }
    }
}

#[test]
fn shapes_come_back_from_displaced_nets() {
    // The body, the handle, the spout.
    for number in [0, 8, 14] {
        let patch = &patches()[number];
        let (_, points) = sample(patch);
        let net = patch.control_points().iter().enumerate().map(|(k, p)| {
            let k = k as f64;
            p + Vector3::new((7.0 * k).sin(), (11.0 * k).cos(), (5.0 * k + 1.0).sin()) * 0.01 * size(patch)
        });
        let knots = [patch.knots_u().clone(), patch.knots_v().clone()];
        let [u, v] = knots;
        let start = BsplineSurface::new(u, v, net.collect(), None).unwrap();
        let target = Target::Points { points: &points, weights: None };
        let found =
            fit(ActiveSurface::new(start).unwrap(), target, &Constraints::none(), &options(25)).unwrap();
        let report = &found.report;
        assert!(
            report.initial_rms > 1e-3 * size(patch) && report.rms < 1e-5 * size(patch),
            "{number}: {report}"
        );
    }
}

#[test]
fn inner_control_points_come_back_where_the_boundary_is_given() {
    let whole = |patch: &BsplineSurface| {
        let corners = [(0, 0), (0, 3), (3, 0), (3, 3)].map(|(i, j)| patch.control_point(i, j));
        (0..4).all(|i| (0..i).all(|j| (corners[i] - corners[j]).norm() > 1e-9))
    };
    let patches: Vec<_> = patches().into_iter().filter(whole).collect();
    assert!(patches.len() >= 20);
    for (number, truth) in patches.iter().enumerate() {
        let (points, size) = (sample(truth).1, size(truth));
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
        let off = largest_difference(truth.control_points(), found.surface.control_points());
        assert!(found.report.fit.rms < 1e-10 * size, "{number}: {}", found.report);
        assert!(off < 1e-9 * size, "{number}: {off:e} of {size}, {}", found.report);
    }
}
