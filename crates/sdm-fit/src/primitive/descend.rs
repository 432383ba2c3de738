//! A quick descent on a few points, for searches with many starts: normal equations in arrays of fixed size.

use super::minimise::{Moved, SLIGHT_DAMPING};
use super::model::{MAX_UNKNOWNS, Model, Step};
use super::sums::Worth;
use nalgebra::SVector;
use sdm_core::{
    Controller, Problem, Status, StepControl, StepDirection, StepLimits, StepTaken, Stop, minimise,
};
use std::convert::Infallible;

/// Control of the steps; dampings are squared shares of the lengths of the columns. The cost has to fall.
const LIMITS: StepLimits = StepLimits {
    decrease: 1e-4,
    shortest: 1e-6,
    first: 1e-3,
    least: 1e-14,
    last: 1e10,
    drops: false,
    slack: 0.0,
};

/// A shape on its way down.
#[derive(Clone, Debug)]
pub(super) struct Trial<M> {
    pub(super) model: M,
    pub(super) cost: f64,
}

/// Gauss-Newton matrix, gradient and cost.
pub(super) struct Normal {
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
    let short = settled * (points.len() as f64).sqrt();
    let cost = cost_of(&model, points, worth);
    let mut problem = Descent { model, cost, points, worth, short, left: steps, inside };
    let mut control = Controller::new(StepControl::LevenbergMarquardt, LIMITS);
    let Ok(_) = minimise(&mut problem, &mut control, usize::MAX);
    Trial { model: problem.model, cost: problem.cost }
}

fn cost_of<const D: usize, M: Model<D>>(model: &M, points: &[SVector<f64, D>], worth: Worth) -> f64 {
    points.iter().map(|x| worth.of(model.distance_sq(x)).0).sum()
}

struct Descent<'a, const D: usize, M> {
    model: M,
    cost: f64,
    points: &'a [SVector<f64, D>],
    worth: Worth,
    /// Length of a step that is short.
    short: f64,
    /// Steps that may still be tried.
    left: usize,
    inside: bool,
}

impl<const D: usize, M: Model<D>> Problem for Descent<'_, D, M> {
    type Linear = Normal;
    type Step = Step;
    type Trial = Moved<M>;
    type Error = Infallible;

    fn linearise(&mut self) -> Result<Normal, Stop<Infallible>> {
        if self.left == 0 {
            return Err(Stop::Ended(Status::MaxIterations));
        }
        if !self.cost.is_finite() {
            return Err(Stop::Ended(Status::Diverged));
        }
        Ok(Normal::new(&self.model, self.points, self.worth))
    }

    fn cost(&self, _: &Normal) -> f64 {
        self.cost
    }

    fn direction(&mut self, normal: &Normal, damping: f64) -> Result<StepDirection<Step>, Stop<Infallible>> {
        if self.left == 0 {
            return Err(Stop::Ended(Status::MaxIterations));
        }
        let Some(step) = normal.step(M::UNKNOWNS, damping) else {
            self.left -= 1;
            return Ok(StepDirection::Singular);
        };
        let motion = step[..M::UNKNOWNS].iter().map(|s| s * s).sum::<f64>().sqrt();
        if motion <= self.short && damping < SLIGHT_DAMPING {
            return Err(Stop::Ended(Status::Converged));
        }
        let slope = -2.0 * step.iter().zip(&normal.vector).map(|(s, v)| s * v).sum::<f64>();
        Ok(StepDirection::along(step, slope))
    }

    fn advance(
        &mut self,
        normal: &Normal,
        step: &Step,
        factor: f64,
    ) -> Result<Option<Moved<M>>, Stop<Infallible>> {
        self.left -= 1;
        let mut change = [0.0; MAX_UNKNOWNS];
        for i in 0..M::UNKNOWNS {
            change[i] = factor * step[i] / normal.lengths[i];
        }
        let moved = self.model.moved(&change);
        let moved = if self.inside { moved.and_then(M::made_proper) } else { moved };
        Ok(moved.map(|model| Moved { cost: cost_of(&model, self.points, self.worth), model }))
    }

    fn accept(&mut self, _: Normal, trial: Moved<M>, _: StepTaken) -> Result<(), Stop<Infallible>> {
        (self.model, self.cost) = (trial.model, trial.cost);
        Ok(())
    }
}
