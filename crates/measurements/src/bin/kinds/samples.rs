//! Distances without a projector: dense samples, refined.

use nalgebra::SVector;
use nurbs_core::Interval;

pub(crate) fn diagonal<const D: usize>(points: &[SVector<f64, D>]) -> f64 {
    let low = points.iter().fold(points[0], |a, p| a.inf(p));
    let high = points.iter().fold(points[0], |a, p| a.sup(p));
    (high - low).norm()
}

/// Break points and the ends of the domain.
pub(crate) fn with_ends(mut breaks: Vec<f64>, domain: &Interval) -> Vec<f64> {
    breaks.insert(0, domain.start());
    breaks.push(domain.end());
    breaks
}

/// Parameters that divide every span into `n` parts.
pub(crate) fn dense(breaks: &[f64], n: usize) -> Vec<f64> {
    let part =
        |w: &[f64]| -> Vec<f64> { (0..n).map(|k| w[0] + (w[1] - w[0]) * k as f64 / n as f64).collect() };
    breaks.windows(2).flat_map(part).chain(breaks.last().copied()).collect()
}

/// Distance from the best of a pattern search that begins at each of the nearest samples.
pub(crate) fn refined<const D: usize>(
    points: &[SVector<f64, D>],
    samples: &[Vec<f64>; 2],
    x: &SVector<f64, D>,
    point: &dyn Fn([f64; 2]) -> SVector<f64, D>,
) -> f64 {
    let columns = samples[1].len();
    let mut order: Vec<(f64, usize)> = points.iter().map(|p| (p - x).norm_squared()).zip(0..).collect();
    let kept = 60.min(order.len());
    order.select_nth_unstable_by(kept - 1, |a, b| a.0.total_cmp(&b.0));
    order.truncate(kept);
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut seeds: Vec<[usize; 2]> = Vec::new();
    for (_, k) in order {
        let at = [k / columns, k % columns];
        if !seeds.iter().any(|s| (0..2).all(|d| s[d].abs_diff(at[d]) <= 2)) {
            seeds.push(at);
        }
    }
    let domain = [0, 1].map(|d| [samples[d][0], samples[d][samples[d].len() - 1]]);
    let mut least = f64::INFINITY;
    for seed in seeds.into_iter().take(5) {
        let mut centre = [0, 1].map(|d| samples[d][seed[d]]);
        let mut best = (point(centre) - x).norm();
        let mut step = [0, 1].map(|d| (domain[d][1] - domain[d][0]) / samples[d].len() as f64);
        for _ in 0..44 {
            for _ in 0..20 {
                let mut moved = None;
                for (i, j) in [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (-1, 1), (1, -1), (1, 1)] {
                    let to = [centre[0] + f64::from(i) * step[0], centre[1] + f64::from(j) * step[1]];
                    let to = [0, 1].map(|d| to[d].clamp(domain[d][0], domain[d][1]));
                    let found = (point(to) - x).norm();
                    if found < best {
                        (best, moved) = (found, Some(to));
                    }
                }
                let Some(to) = moved else { break };
                centre = to;
            }
            step = step.map(|s| 0.5 * s);
        }
        least = least.min(best);
    }
    least
}
