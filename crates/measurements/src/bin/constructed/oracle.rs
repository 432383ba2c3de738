//! Distances without a projector: dense samples, and a damped Gauss-Newton iteration from every dip.

use nalgebra::{Matrix2, Vector2, Vector3};
use nurbs_core::{BsplineSurface, Interval, ParametricSurface};

/// Samples of a surface, span by span.
pub(crate) struct Oracle<'a> {
    surface: &'a BsplineSurface,
    domain: [Interval; 2],
    parameters: [Vec<f64>; 2],
    points: Vec<Vector3<f64>>,
}

impl<'a> Oracle<'a> {
    /// About `most` samples in each direction, and at least six per span.
    pub(crate) fn new(surface: &'a BsplineSurface, most: usize) -> Self {
        let domain = surface.domain();
        let [u, v] = surface.breaks();
        let parameters = [(u, domain[0]), (v, domain[1])].map(|(mut breaks, domain)| {
            breaks.insert(0, domain.start());
            breaks.push(domain.end());
            let n = (most / (breaks.len() - 1)).max(6);
            let part =
                |w: &[f64]| (0..n).map(|k| w[0] + (w[1] - w[0]) * k as f64 / n as f64).collect::<Vec<_>>();
            let mut all: Vec<f64> = breaks.windows(2).flat_map(part).collect();
            all.push(domain.end());
            all
        });
        let points = (parameters[0].iter())
            .flat_map(|&u| parameters[1].iter().map(move |&v| [u, v]))
            .map(|[u, v]| surface.point(u, v))
            .collect();
        Self { surface, domain, parameters, points }
    }

    /// An upper bound of the distance, as a rule the distance itself.
    pub(crate) fn distance(&self, x: &Vector3<f64>) -> f64 {
        let [rows, columns] = [0, 1].map(|d| self.parameters[d].len());
        let squares: Vec<f64> = self.points.iter().map(|p| (p - x).norm_squared()).collect();
        let mut dips = Vec::new();
        for i in 0..rows {
            for j in 0..columns {
                let here = squares[i * columns + j];
                let around = |k: usize, l: usize| squares[k * columns + l] < here;
                let (up, down) = ((i + 1).min(rows - 1), i.saturating_sub(1));
                let (right, left) = ((j + 1).min(columns - 1), j.saturating_sub(1));
                if !(around(up, j) || around(down, j) || around(i, left) || around(i, right)) {
                    dips.push((here, [i, j]));
                }
            }
        }
        dips.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut least = dips.first().map_or(f64::INFINITY, |dip| dip.0.sqrt());
        for (_, [i, j]) in dips.into_iter().take(40) {
            least = least.min(self.refined(x, [self.parameters[0][i], self.parameters[1][j]]));
        }
        least
    }

    /// Levenberg's method with bounds.
    fn refined(&self, x: &Vector3<f64>, start: [f64; 2]) -> f64 {
        let mut at = start;
        let mut damping = 1e-3;
        let mut jet = self.surface.jet(at[0], at[1]);
        let mut best = (jet.point - x).norm();
        for _ in 0..120 {
            let r = jet.point - x;
            let gradient = Vector2::new(jet.du.dot(&r), jet.dv.dot(&r));
            let metric = Matrix2::new(
                jet.du.norm_squared(),
                jet.du.dot(&jet.dv),
                jet.du.dot(&jet.dv),
                jet.dv.norm_squared(),
            );
            let bend = Matrix2::new(jet.duu.dot(&r), jet.duv.dot(&r), jet.duv.dot(&r), jet.dvv.dot(&r));
            let mut free = [true; 2];
            for d in 0..2 {
                let (low, high) = (self.domain[d].start(), self.domain[d].end());
                free[d] = !((at[d] <= low && gradient[d] > 0.0) || (at[d] >= high && gradient[d] < 0.0));
            }
            let mut hessian = metric + bend;
            if hessian.determinant() <= 0.0 || hessian.trace() <= 0.0 {
                hessian = metric;
            }
            for d in 0..2 {
                hessian[(d, d)] += damping * metric[(d, d)].max(f64::MIN_POSITIVE);
            }
            let step = match free {
                [true, true] => {
                    hessian.try_inverse().map_or(Vector2::zeros(), |inverse| -(inverse * gradient))
                }
                [true, false] => Vector2::new(-gradient[0] / hessian[(0, 0)], 0.0),
                [false, true] => Vector2::new(0.0, -gradient[1] / hessian[(1, 1)]),
                [false, false] => break,
            };
            let to = [0, 1].map(|d| (at[d] + step[d]).clamp(self.domain[d].start(), self.domain[d].end()));
            let there = self.surface.jet(to[0], to[1]);
            let distance = (there.point - x).norm();
            if distance < best {
                (at, jet, best) = (to, there, distance);
                damping *= 0.1;
            } else {
                damping = (damping * 10.0).max(1e-12);
                if damping > 1e12 {
                    break;
                }
            }
        }
        best
    }
}
