//! Brute force: dense samples, then a pattern search around the best of them.

use nalgebra::{SVector, Vector3};
use nurbs_core::{BsplineCurve, BsplineSurface, KnotVector, ParametricCurve, ParametricSurface};

/// Samples refined per shape.
const SEEDS: usize = 6;
/// Halvings of the pattern: the distance at a smooth minimum is then known to the rounding error.
const HALVINGS: usize = 26;

/// Distance from a curve, at least the true one.
pub(crate) fn curve_distance<const D: usize>(curve: &BsplineCurve<D>, x: &SVector<f64, D>) -> f64 {
    let value = |[t, _]: [f64; 2]| (curve.point(t) - x).norm();
    minimize(value, &[dense(curve.knots(), 40), vec![0.0]])
}

/// Distance from a surface, at least the true one.
pub(crate) fn surface_distance(surface: &BsplineSurface, x: &Vector3<f64>) -> f64 {
    let value = |[u, v]: [f64; 2]| (surface.point(u, v) - x).norm();
    minimize(value, &[dense(surface.knots_u(), 10), dense(surface.knots_v(), 10)])
}

/// Parameters that divide every span into `n` parts.
fn dense(knots: &KnotVector, n: usize) -> Vec<f64> {
    let mut out = vec![knots.domain().start()];
    for span in knots.spans() {
        let span = knots.span_interval(span);
        out.extend((1..n).map(|k| span.lerp(k as f64 / n as f64)));
        out.push(span.end());
    }
    out
}

fn minimize(value: impl Fn([f64; 2]) -> f64, samples: &[Vec<f64>; 2]) -> f64 {
    let mut seeds = Vec::new();
    for (i, &u) in samples[0].iter().enumerate() {
        for (j, &v) in samples[1].iter().enumerate() {
            seeds.push((value([u, v]), [i, j]));
        }
    }
    seeds.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut kept: Vec<(f64, [usize; 2])> = Vec::new();
    for seed in seeds {
        // One seed per neighbourhood.
        let beside = |k: &(f64, [usize; 2])| (0..2).all(|d| k.1[d].abs_diff(seed.1[d]) <= 2);
        if kept.len() < SEEDS && !kept.iter().any(beside) {
            kept.push(seed);
        }
    }
    kept.into_iter().map(|(start, at)| refine(&value, samples, start, at)).fold(f64::INFINITY, f64::min)
}

/// Moves to the best of eight neighbours, or halves the step where none is better.
fn refine(value: &impl Fn([f64; 2]) -> f64, samples: &[Vec<f64>; 2], mut best: f64, at: [usize; 2]) -> f64 {
    let domain = [0, 1].map(|d| [samples[d][0], samples[d][samples[d].len() - 1]]);
    let mut centre = [0, 1].map(|d| samples[d][at[d]]);
    let mut step = [0, 1].map(|d| (domain[d][1] - domain[d][0]) / samples[d].len() as f64);
    for _ in 0..HALVINGS {
        for _ in 0..20 {
            let mut moved = None;
            for (i, j) in [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (-1, 1), (1, -1), (1, 1)] {
                let to = [centre[0] + f64::from(i) * step[0], centre[1] + f64::from(j) * step[1]];
                let to = [0, 1].map(|d| to[d].clamp(domain[d][0], domain[d][1]));
                let found = value(to);
                if found < best {
                    (best, moved) = (found, Some(to));
                }
            }
            let Some(to) = moved else { break };
            centre = to;
        }
        step = step.map(|s| 0.5 * s);
    }
    best
}
