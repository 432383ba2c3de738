//! Jets of curves and surfaces, one at a time and in batches.
//!
//! Identifiers are `group/name…`; `jet/bicubic/single` is the unit that all ratios are taken to.
#![allow(missing_docs, reason = "criterion's macros make undocumented functions")]
#![allow(clippy::expect_used, reason = "the shapes are known to be valid")]

mod scalar_loop;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use nurbs_core::nalgebra::{Vector2, Vector3};
use nurbs_core::{BsplineCurve, BsplineSurface, KnotVector, ParametricCurve, ParametricSurface};
use std::hint::black_box;

/// Parameters per iteration.
const COUNT: usize = 1024;

/// The fractional parts of multiples of an irrational number: spread evenly, in no order.
fn spread(i: usize, step: f64) -> f64 {
    (i as f64 * step).fract()
}

fn parameters(count: usize) -> Vec<[f64; 2]> {
    (0..count).map(|i| [spread(i, 0.618_033_988_749_895), spread(i, 0.754_877_666_246_693)]).collect()
}

/// A wavy surface with `n` control points in each direction.
fn surface(p: usize, q: usize, n: usize, rational: bool) -> BsplineSurface {
    let knots = |degree| KnotVector::uniform_clamped(degree, n).expect("valid knots");
    let at = |k: usize| k as f64 / (n - 1) as f64;
    let net = (0..n * n)
        .map(|k| (at(k / n), at(k % n)))
        .map(|(x, y)| Vector3::new(x, y, 0.1 * (9.0 * x).sin() * (7.0 * y).cos()))
        .collect();
    let weights = rational.then(|| (0..n * n).map(|k| 1.0 + 0.3 * spread(k, 0.7)).collect());
    BsplineSurface::new(knots(p), knots(q), net, weights).expect("valid surface")
}

fn curve(p: usize, rational: bool) -> BsplineCurve<2> {
    let n = 20;
    let points = (0..n).map(|i| Vector2::new(i as f64, (0.9 * i as f64).sin())).collect();
    let weights = rational.then(|| (0..n).map(|k| 1.0 + 0.3 * spread(k, 0.7)).collect());
    BsplineCurve::new(KnotVector::uniform_clamped(p, n).expect("valid knots"), points, weights)
        .expect("valid curve")
}

fn single_jets(c: &mut Criterion) {
    let params = parameters(COUNT);
    let mut group = c.benchmark_group("jet");
    group.throughput(Throughput::Elements(COUNT as u64));
    let bicubic = surface(3, 3, 20, false);
    group.bench_function("bicubic/single", |b| {
        b.iter(|| {
            for &[u, v] in &params {
                black_box(bicubic.jet(u, v));
            }
        });
    });
    let net: Vec<[f64; 3]> = bicubic.control_points().iter().map(|p| [p.x, p.y, p.z]).collect();
    let knots = bicubic.knots_u().as_slice();
    group.bench_function("bicubic/scalar-loop", |b| {
        b.iter(|| {
            for &[u, v] in &params {
                let spans = [scalar_loop::span(knots, 3, u), scalar_loop::span(knots, 3, v)];
                black_box(scalar_loop::bicubic_jet([knots; 2], &net, 20, spans, u, v));
            }
        });
    });
    let spans: Vec<[usize; 2]> =
        params.iter().map(|&[u, v]| [bicubic.knots_u().span(u), bicubic.knots_v().span(v)]).collect();
    group.bench_function("bicubic/single-known-span", |b| {
        b.iter(|| {
            for (&[u, v], &[i, j]) in params.iter().zip(&spans) {
                black_box(bicubic.jet_in_span(i, j, u, v));
            }
        });
    });
    group.bench_function("bicubic/scalar-loop-known-span", |b| {
        b.iter(|| {
            for (&[u, v], &spans) in params.iter().zip(&spans) {
                black_box(scalar_loop::bicubic_jet([knots; 2], &net, 20, spans, u, v));
            }
        });
    });
    for (name, p, q, rational) in [
        ("bicubic-rational/single", 3, 3, true),
        ("bilinear/single", 1, 1, false),
        ("biquadratic/single", 2, 2, false),
        ("biquartic/single", 4, 4, false),
        ("biquintic/single", 5, 5, false),
        ("degree-1x3/single", 1, 3, false),
        ("degree-7x7/single", 7, 7, false),
    ] {
        let s = surface(p, q, 20, rational);
        group.bench_function(name, |b| {
            b.iter(|| {
                for &[u, v] in &params {
                    black_box(s.jet(u, v));
                }
            });
        });
    }
    group.bench_function("bicubic/point", |b| {
        b.iter(|| {
            for &[u, v] in &params {
                black_box(bicubic.point(u, v));
            }
        });
    });
}

fn curve_jets(c: &mut Criterion) {
    let params: Vec<f64> = parameters(COUNT).iter().map(|p| p[0]).collect();
    let mut group = c.benchmark_group("curve-jet");
    group.throughput(Throughput::Elements(COUNT as u64));
    for (name, p, rational) in [
        ("cubic-2d/single", 3, false),
        ("cubic-2d-rational/single", 3, true),
        ("quadratic-2d/single", 2, false),
        ("quintic-2d/single", 5, false),
        ("degree-7-2d/single", 7, false),
    ] {
        let curve = curve(p, rational);
        group.bench_function(name, |b| {
            b.iter(|| {
                for &t in &params {
                    black_box(curve.jet(t));
                }
            });
        });
    }
    let cubic = curve(3, false);
    let points: Vec<[f64; 2]> = cubic.control_points().iter().map(|p| [p.x, p.y]).collect();
    let knots = cubic.knots().as_slice();
    group.bench_function("cubic-2d/scalar-loop", |b| {
        b.iter(|| {
            for &t in &params {
                black_box(scalar_loop::cubic_jet(knots, &points, scalar_loop::span(knots, 3, t), t));
            }
        });
    });
}

fn batches(c: &mut Criterion) {
    let mut group = c.benchmark_group("batch");
    for (name, n, count, rational) in [
        ("bicubic/4096-on-20x20", 20, 4096, false),
        ("bicubic/4096-on-50x50", 50, 4096, false),
        ("bicubic/64-on-20x20", 20, 64, false),
        ("bicubic/100000-on-50x50", 50, 100_000, false),
        ("bicubic-rational/4096-on-20x20", 20, 4096, true),
    ] {
        let s = surface(3, 3, n, rational);
        let params = parameters(count);
        let mut out = vec![s.jet(0.0, 0.0); count];
        group.throughput(Throughput::Elements(count as u64));
        group.bench_function(name, |b| {
            b.iter(|| s.jets(black_box(&params), black_box(&mut out)).expect("equal lengths"));
        });
    }
    let (s, params) = (surface(3, 3, 50, false), parameters(100_000));
    let mut out = vec![s.jet(0.0, 0.0); params.len()];
    group.throughput(Throughput::Elements(params.len() as u64));
    group.bench_function("bicubic/100000-on-50x50-one-by-one", |b| {
        b.iter(|| {
            for (&[u, v], jet) in black_box(&params).iter().zip(black_box(&mut out)) {
                *jet = s.jet(u, v);
            }
        });
    });
    let (s, params) = (surface(3, 3, 20, false), parameters(4096));
    let mut out = vec![Vector3::zeros(); params.len()];
    group.throughput(Throughput::Elements(params.len() as u64));
    group.bench_function("bicubic-points/4096-on-20x20", |b| {
        b.iter(|| s.points(black_box(&params), black_box(&mut out)).expect("equal lengths"));
    });
    let curve = curve(3, false);
    let params: Vec<f64> = params.iter().map(|p| p[0]).collect();
    let mut out = vec![curve.jet(0.0); params.len()];
    group.bench_function("cubic-curve-2d/4096", |b| {
        b.iter(|| curve.jets(black_box(&params), black_box(&mut out)).expect("equal lengths"));
    });
}

criterion_group!(benches, single_jets, batches, curve_jets);
criterion_main!(benches);
