//! A quick descent on a few points, for searches with many starts: normal equations in arrays of fixed size.

use super::model::{MAX_UNKNOWNS, Model, Step};
use super::sums::Worth;
use nalgebra::SVector;

/// Damping below which a short step means that the gradient is small.
const FREE: f64 = 1.0;

/// A shape on its way down.
#[derive(Clone, Debug)]
pub(super) struct Trial<M> {
    pub(super) model: M,
    pub(super) cost: f64,
    /// Whether the last step was shorter than asked for.
    pub(super) settled: bool,
}

/// Gauss-Newton matrix, gradient and cost.
struct Normal {
    matrix: [[f64; MAX_UNKNOWNS]; MAX_UNKNOWNS],
    vector: Step,
    lengths: Step,
}

impl Normal {
    fn new<const D: usize, M: Model<D>>(model: &M, points: &[SVector<f64, D>], worth: Worth) -> Self {
        let mut normal = Self {
            matrix: [[0.0; MAX_UNKNOWNS]; MAX_UNKNOWNS],
            vector: [0.0; MAX_UNKNOWNS],
            lengths: [1.0; MAX_UNKNOWNS],
        };
        for x in points {
            let rows = model.rows(x);
            let (_, weight) = worth.of(rows.iter().map(|r| r.residual * r.residual).sum());
            if weight == 0.0 {
                continue;
            }
            for row in &rows[..M::ROWS] {
                for i in 0..M::UNKNOWNS {
                    let slope = weight * row.slopes[i];
                    normal.vector[i] -= slope * row.residual;
                    for j in 0..=i {
                        normal.matrix[i][j] += slope * row.slopes[j];
                    }
                }
            }
        }
        for i in 0..M::UNKNOWNS {
            let length = normal.matrix[i][i].sqrt();
            if length > 0.0 {
                normal.lengths[i] = length;
            }
        }
        for i in 0..M::UNKNOWNS {
            normal.vector[i] /= normal.lengths[i];
            for j in 0..=i {
                normal.matrix[i][j] /= normal.lengths[i] * normal.lengths[j];
            }
        }
        normal
    }

    /// The damped step in units of the lengths, by Cholesky's method; `None` if a number is not finite.
    fn step(&self, n: usize, damping: f64) -> Option<Step> {
        let mut l = self.matrix;
        for i in 0..n {
            for j in 0..=i {
                let mut sum = l[i][j] + if i == j { damping } else { 0.0 };
                for k in 0..j {
                    sum -= l[i][k] * l[j][k];
                }
                if i == j {
                    if sum.is_nan() || sum <= 0.0 {
                        return None;
                    }
                    l[i][i] = sum.sqrt();
                } else {
                    l[i][j] = sum / l[j][j];
                }
            }
        }
        let mut x = self.vector;
        for i in 0..n {
            for k in 0..i {
                x[i] -= l[i][k] * x[k];
            }
            x[i] /= l[i][i];
        }
        for i in (0..n).rev() {
            for k in i + 1..n {
                x[i] -= l[k][i] * x[k];
            }
            x[i] /= l[i][i];
        }
        x[..n].iter().all(|v| v.is_finite()).then_some(x)
    }
}

/// Levenberg and Marquardt until a step moves the shape by less than `settled`; `inside` keeps it among proper shapes.
pub(super) fn descend<const D: usize, M: Model<D>>(
    model: M,
    points: &[SVector<f64, D>],
    worth: Worth,
    settled: f64,
    steps: usize,
    inside: bool,
) -> Trial<M> {
    let cost_of = |model: &M| points.iter().map(|x| worth.of(model.distance_sq(x)).0).sum::<f64>();
    let mut trial = Trial { cost: cost_of(&model), model, settled: false };
    let short = settled * (points.len() as f64).sqrt();
    let mut damping = 1e-3;
    let mut left = steps;
    'lower: while left > 0 && trial.cost.is_finite() {
        let normal = Normal::new(&trial.model, points, worth);
        while damping < 1e10 && left > 0 {
            let Some(step) = normal.step(M::UNKNOWNS, damping) else {
                damping = (damping * 10.0).max(1e-14);
                left -= 1;
                continue;
            };
            let motion = step[..M::UNKNOWNS].iter().map(|s| s * s).sum::<f64>().sqrt();
            if motion <= short && damping < FREE {
                trial.settled = true;
                return trial;
            }
            left -= 1;
            let mut change = [0.0; MAX_UNKNOWNS];
            for i in 0..M::UNKNOWNS {
                change[i] = step[i] / normal.lengths[i];
            }
            let moved = trial.model.moved(&change);
            if let Some(next) = if inside { moved.and_then(M::made_proper) } else { moved } {
                let cost = cost_of(&next);
                if cost < trial.cost {
                    (trial.model, trial.cost) = (next, cost);
                    damping = (damping * 0.1).max(1e-14);
                    continue 'lower;
                }
            }
            damping *= 10.0;
        }
        // No step lowers the cost.
        trial.settled = left > 0;
        return trial;
    }
    trial
}
