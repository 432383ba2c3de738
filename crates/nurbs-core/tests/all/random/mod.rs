//! Random knot vectors, curves and surfaces.

use nalgebra::Vector3;
use nurbs_core::{BsplineCurve, BsplineSurface, Frame, Interval, KnotVector};
use proptest::prelude::*;

/// Knot vectors of degree 1 to 5, clamped with repeated inner knots or periodic, spans of 0.2 to 1.
pub(crate) fn knots() -> impl Strategy<Value = KnotVector> {
    (1_usize..=5, prop::collection::vec((0.2..1.0, 1_usize..=3), 1..6), any::<bool>(), -5.0..5.0).prop_map(
        |(degree, spans, periodic, start)| {
            if periodic {
                periodic_knots(degree, &spans, start)
            } else {
                clamped_knots(degree, &spans, start)
            }
        },
    )
}

fn clamped_knots(degree: usize, spans: &[(f64, usize)], start: f64) -> KnotVector {
    let mut knots = vec![start; degree + 1];
    let mut t = start;
    for (k, (length, multiplicity)) in spans.iter().enumerate() {
        t += length;
        let last = k + 1 == spans.len();
        let count = if last { degree + 1 } else { (*multiplicity).min(degree) };
        knots.extend(std::iter::repeat_n(t, count));
    }
    KnotVector::new(degree, knots).unwrap()
}

fn periodic_knots(degree: usize, spans: &[(f64, usize)], start: f64) -> KnotVector {
    // Enough simple knots for one period, then copies on both sides.
    let count = spans.len().max(degree + 1);
    let lengths: Vec<f64> = (0..count).map(|i| spans[i % spans.len()].0).collect();
    let period: f64 = lengths.iter().sum();
    let mut base = vec![start];
    for length in &lengths[..count - 1] {
        base.push(base[base.len() - 1] + length);
    }
    let n = count as isize;
    let p = degree as isize;
    let at = |i: isize| base[i.rem_euclid(n) as usize] + period * i.div_euclid(n) as f64;
    KnotVector::periodic(degree, (-p..=n + p).map(at).collect()).unwrap()
}

fn point() -> impl Strategy<Value = Vector3<f64>> {
    [-5.0..5.0, -5.0..5.0, -5.0..5.0].prop_map(Vector3::from)
}

/// Repeats the first `degree` entries at the end of a periodic shape.
fn close<T: Clone>(values: &mut [T], knots: &KnotVector) {
    if knots.is_periodic() {
        let distinct = knots.distinct_count();
        for i in 0..knots.degree() {
            values[distinct + i] = values[i].clone();
        }
    }
}

pub(crate) fn curve() -> impl Strategy<Value = BsplineCurve<3>> {
    (knots(), any::<bool>()).prop_flat_map(|(knots, rational)| {
        let n = knots.basis_count();
        let values = prop::collection::vec((point(), 0.3..3.0), n);
        (Just(knots), values, Just(rational)).prop_map(|(knots, mut values, rational)| {
            close(&mut values, &knots);
            let (points, weights): (Vec<_>, Vec<_>) = values.into_iter().unzip();
            BsplineCurve::new(knots, points, rational.then_some(weights)).unwrap()
        })
    })
}

pub(crate) fn surface() -> impl Strategy<Value = BsplineSurface> {
    (knots(), knots(), any::<bool>()).prop_flat_map(|(u, v, rational)| {
        let values = prop::collection::vec((point(), 0.3..3.0), u.basis_count() * v.basis_count());
        (Just(u), Just(v), values, Just(rational)).prop_map(|(u, v, values, rational)| {
            let mut rows: Vec<Vec<_>> = values.chunks(v.basis_count()).map(<[_]>::to_vec).collect();
            rows.iter_mut().for_each(|row| close(row, &v));
            close(&mut rows, &u);
            let (points, weights): (Vec<_>, Vec<_>) = rows.into_iter().flatten().unzip();
            BsplineSurface::new(u, v, points, rational.then_some(weights)).unwrap()
        })
    })
}

/// A bicubic height field: regular everywhere.
pub(crate) fn regular_surface() -> impl Strategy<Value = BsplineSurface> {
    prop::collection::vec((-1.0..1.0, 0.7..1.4), 30).prop_map(|values| {
        let knots = |n| KnotVector::uniform_clamped(3, n).unwrap();
        let point = |(k, (z, _)): (usize, &(f64, f64))| Vector3::new((k / 5) as f64, (k % 5) as f64, *z);
        let points = values.iter().enumerate().map(point).collect();
        let weights = values.iter().map(|v| v.1).collect();
        BsplineSurface::new(knots(6), knots(5), points, Some(weights)).unwrap()
    })
}

pub(crate) fn frame() -> impl Strategy<Value = Frame> {
    (point(), point(), point()).prop_filter_map("parallel axes", |(o, z, x)| Frame::new(o, z, x).ok())
}

/// Largest value of a function: samples, then golden section search around the best of them.
pub(crate) fn maximize(f: &impl Fn(f64) -> f64, domain: Interval, breaks: &[f64]) -> f64 {
    let n = 400;
    let mut samples: Vec<f64> = (0..=n).map(|i| domain.lerp(f64::from(i) / f64::from(n))).collect();
    samples.extend_from_slice(breaks);
    samples.sort_by(f64::total_cmp);
    // A break beside a sample would leave the bracket of neither to reach beyond the other.
    samples.dedup_by(|b, a| *b - *a < 1e-9 * domain.length());
    let mut best = breaks.iter().map(|&t| f(t)).fold(f64::NEG_INFINITY, f64::max);
    for k in 0..samples.len() {
        best = best.max(f(samples[k]));
        let (mut a, mut b) = (samples[k.saturating_sub(1)], samples[(k + 1).min(samples.len() - 1)]);
        if f(samples[k]) < f(a) || f(samples[k]) < f(b) {
            continue;
        }
        for _ in 0..60 {
            let (c, d) = (b - 0.618_034 * (b - a), a + 0.618_034 * (b - a));
            if f(c) > f(d) { b = d } else { a = c }
        }
        best = best.max(f(0.5 * (a + b)));
    }
    best
}
