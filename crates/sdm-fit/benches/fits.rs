//! Iterations of fits by each error term, everything else shared.
//!
//! Identifiers are `group/points-controls-term`; times are per point and iteration, on all threads.
#![allow(missing_docs, reason = "criterion's macros make undocumented functions")]
#![allow(clippy::expect_used, reason = "the shapes are known to be valid")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use distance_field::ErrorTerm;
use nalgebra::{Vector2, Vector3};
use nurbs_core::{BsplineCurve, KnotVector};
use sdm_fit::{
    ActiveCurve, BaseShape, Constraints, FitOptions, NetSize, Smoothing, SurfaceOptions, Target, fit,
    fit_surface, initial_surface,
};
use std::f64::consts::TAU;
use std::hint::black_box;
use std::time::Duration;

const TERMS: [ErrorTerm; 3] = [ErrorTerm::Point, ErrorTerm::Tangent, ErrorTerm::SquaredDistance];
/// Iterations of each fit.
const STEPS: usize = 8;

/// The fractional parts of multiples of an irrational number: spread evenly, in no order.
fn spread(i: usize, step: f64) -> f64 {
    (i as f64 * step).fract()
}

/// A lobed tube, closed in u, that misses its surface by ripples that the control points cannot follow.
fn surfaces(c: &mut Criterion) {
    let point = |i: usize| {
        let (a, h) = (TAU * spread(i, 0.754_877_666_246_693), spread(i, 0.569_840_290_998_053));
        let ripple = 0.01 * (97.0 * a).sin() * (83.0 * h).cos();
        let r = 2.0 + 0.3 * (3.0 * a).sin() * h + 0.2 * (9.0 * h).cos() + ripple;
        Vector3::new(r * a.cos(), r * a.sin(), 5.0 * h)
    };
    let points: Vec<_> = (0..16_384).map(point).collect();
    let size = NetSize { controls: [30, 30], ..NetSize::default() };
    let start = initial_surface(&points, BaseShape::Cylinder, size).expect("a tube").surface;
    let mut group = c.benchmark_group("surface-fit");
    group.throughput(Throughput::Elements((points.len() * STEPS) as u64));
    for term in TERMS {
        let options = SurfaceOptions::default();
        let options = options.with_fit(
            options
                .fit
                .with_term(term)
                .with_smoothing(Smoothing::CONTINUATION)
                .with_cost_tolerance(0.0)
                .with_max_iterations(STEPS),
        );
        group.bench_function(format!("16384-30x30-{term}"), |b| {
            b.iter(|| fit_surface(black_box(&points), start.clone(), &options).expect("a tube"));
        });
    }
}

/// A wavy closed curve from a circle.
fn curves(c: &mut Criterion) {
    let turn = |i: usize, n: usize| TAU * i as f64 / n as f64;
    let points: Vec<_> = (0..1024)
        .map(|i| {
            (turn(i, 1024), 1.0 + 0.2 * (5.0 * turn(i, 1024)).cos() + 0.01 * (211.0 * turn(i, 1024)).sin())
        })
        .map(|(a, r)| Vector2::new(r * a.cos(), r * a.sin()))
        .collect();
    let circle = (0..27).map(|i| Vector2::new(turn(i, 24).cos(), turn(i, 24).sin())).collect();
    let knots = KnotVector::uniform_periodic(3, 24).expect("enough control points");
    let start =
        ActiveCurve::new(BsplineCurve::new(knots, circle, None).expect("a circle")).expect("no weights");
    let mut group = c.benchmark_group("curve-fit");
    group.throughput(Throughput::Elements((points.len() * STEPS) as u64));
    for term in TERMS {
        let options = FitOptions::default()
            .with_term(term)
            .with_smoothing(Smoothing::CONTINUATION)
            .with_cost_tolerance(0.0)
            .with_max_iterations(STEPS);
        let target = Target::Points { points: &points, weights: None };
        group.bench_function(format!("1024-24-{term}"), |b| {
            b.iter(|| {
                fit(black_box(start.clone()), target, &Constraints::none(), &options).expect("a curve")
            });
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(3));
    targets = curves, surfaces
}
criterion_main!(benches);
