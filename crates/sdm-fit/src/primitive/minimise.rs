//! Least squares of orthogonal distances: Levenberg and Marquardt to come near, Newton to finish.

use super::PrimitiveStatus;
use super::model::{MAX_UNKNOWNS, Model, Step};
use super::sums::{Worth, cost, factor, gradient};
use nalgebra::{Cholesky, DMatrix, DVector, SVector};
use sdm_core::{
    Controller, Problem, Status, StepControl, StepDirection, StepLimits, StepTaken, Stop, Trial,
    minimise as iterate,
};
use std::convert::Infallible;

/// Share of the largest singular value up to which a motion leaves the distances as they are.
const UNDETERMINED: f64 = 1e-12;

/// How far a step may move the shape at the end, in units of the size of the cloud.
const SETTLED: f64 = 1e-10;

/// Share of the sum of squares that one more step may be expected to gain.
const GAIN: f64 = 1e-10;
/// Mean squared distance, in units of the size of the cloud, that is rounding.
const ROUNDING_SQ: f64 = 1e-28;

/// A minimum, or how far the search came.
#[derive(Clone, Debug)]
pub(super) struct Minimum<M> {
    pub(super) model: M,
    pub(super) cost: f64,
    pub(super) status: PrimitiveStatus,
    pub(super) iterations: usize,
    pub(super) conditioning: f64,
}

/// The linearised problem with columns of unit length.
pub(super) struct Linear {
    /// `R`, its columns divided by `lengths`.
    r: DMatrix<f64>,
    q: DVector<f64>,
    lengths: DVector<f64>,
    conditioning: f64,
}

impl Linear {
    fn new(factor: &DMatrix<f64>) -> Self {
        let n = factor.ncols() - 1;
        let mut r = factor.view((0, 0), (n, n)).upper_triangle();
        let q = factor.view((0, n), (n, 1)).column(0).into_owned();
        let lengths = DVector::from_fn(n, |k, _| {
            let length = r.column(k).norm();
            if length > 0.0 { length } else { 1.0 }
        });
        for k in 0..n {
            r.column_mut(k).unscale_mut(lengths[k]);
        }
        let values = r.clone().svd(false, false).singular_values;
        let conditioning = if values.max() > 0.0 { values.min() / values.max() } else { 0.0 };
        Self { r, q, lengths, conditioning }
    }

    /// The damped step in scaled unknowns; `None` if a number is not finite.
    fn step(&self, damping: f64) -> Option<DVector<f64>> {
        let n = self.q.len();
        let mut rows = DMatrix::zeros(2 * n, n);
        rows.rows_mut(0, n).copy_from(&self.r);
        rows.rows_mut(n, n).fill_diagonal(damping.sqrt());
        let mut right = DVector::zeros(2 * n);
        right.rows_mut(0, n).copy_from(&(-&self.q));
        let qr = rows.qr();
        let step = qr.r().solve_upper_triangular(&qr.q().tr_mul(&right))?;
        step.iter().all(|x| x.is_finite()).then_some(step)
    }

    fn unscaled(&self, step: &DVector<f64>) -> Step {
        let mut out = [0.0; MAX_UNKNOWNS];
        for k in 0..step.len() {
            out[k] = step[k] / self.lengths[k];
        }
        out
    }
}

/// Minimises from a start. The cloud lies about the origin and has a size of about 1.
pub(super) fn minimise<const D: usize, M: Model<D>>(
    start: M,
    points: &[SVector<f64, D>],
    worth: Worth,
    max_iterations: usize,
) -> Minimum<M> {
    let initial = cost(&start, points, worth);
    let mut found = Minimum {
        model: start,
        cost: initial,
        status: PrimitiveStatus::MaxIterations,
        iterations: 0,
        conditioning: 0.0,
    };
    // Newton's method may be tried too early (the matrix is indefinite, the gradient grows): then it is called again later.
    for settled in [1e-3, 1e-6, 1e-9] {
        let arrived = approach(&mut found, points, worth, settled, max_iterations);
        if found.conditioning <= UNDETERMINED {
            if arrived {
                found.status = PrimitiveStatus::Undetermined;
            }
            return found;
        }
        if finish(&mut found, points, worth) {
            found.status = PrimitiveStatus::Converged;
            return found;
        }
        if is_exact(found.cost, points.len()) {
            found.status = PrimitiveStatus::Converged;
            return found;
        }
        if !arrived {
            return found;
        }
    }
    found.status = PrimitiveStatus::Stalled;
    found
}

/// Whether nothing but rounding is left of the distances, so that there is nothing to lower.
fn is_exact(cost: f64, points: usize) -> bool {
    cost <= ROUNDING_SQ * points as f64
}

/// Control of the steps; dampings are squared shares of the lengths of the columns. The cost has to fall.
const LIMITS: StepLimits = StepLimits {
    decrease: 1e-4,
    shortest: 1e-6,
    first: 1e-3,
    least: 1e-15,
    last: 1e12,
    drops: false,
    slack: 0.0,
};
/// Damping below which a short step means that the gradient is small.
pub(super) const SLIGHT_DAMPING: f64 = 1.0;

/// Levenberg and Marquardt until a full step moves the shape by less than `settled`, or none lowers the cost. False if steps run out.
fn approach<const D: usize, M: Model<D>>(
    found: &mut Minimum<M>,
    points: &[SVector<f64, D>],
    worth: Worth,
    settled: f64,
    max_iterations: usize,
) -> bool {
    let short = settled * (points.len() as f64).sqrt();
    let mut problem = Approach { found, points, worth, short, max_iterations };
    let mut control = Controller::new(StepControl::LevenbergMarquardt, LIMITS);
    let Ok(status) = iterate(&mut problem, &mut control, usize::MAX);
    status != Status::MaxIterations
}

struct Approach<'a, const D: usize, M> {
    found: &'a mut Minimum<M>,
    points: &'a [SVector<f64, D>],
    worth: Worth,
    /// Length of a step that is short.
    short: f64,
    max_iterations: usize,
}

/// A shape that a step leads to.
pub(super) struct Moved<M> {
    pub(super) model: M,
    pub(super) cost: f64,
}

impl<M> Trial for Moved<M> {
    fn cost(&self) -> f64 {
        self.cost
    }
}

impl<const D: usize, M: Model<D>> Problem for Approach<'_, D, M> {
    type Linear = Linear;
    type Step = DVector<f64>;
    type Trial = Moved<M>;
    type Error = Infallible;

    fn linearise(&mut self) -> Result<Linear, Stop<Infallible>> {
        let linear = Linear::new(&factor(&self.found.model, self.points, self.worth));
        self.found.conditioning = linear.conditioning;
        Ok(linear)
    }

    fn cost(&self, _: &Linear) -> f64 {
        self.found.cost
    }

    fn direction(
        &mut self,
        linear: &Linear,
        damping: f64,
    ) -> Result<StepDirection<DVector<f64>>, Stop<Infallible>> {
        let Some(step) = linear.step(damping) else { return Err(Stop::Ended(Status::Stalled)) };
        if step.norm() <= self.short && damping < SLIGHT_DAMPING {
            return Err(Stop::Ended(Status::Converged));
        }
        let slope = 2.0 * linear.r.tr_mul(&linear.q).dot(&step);
        Ok(StepDirection::along(step, slope))
    }

    fn advance(
        &mut self,
        linear: &Linear,
        step: &DVector<f64>,
        factor: f64,
    ) -> Result<Option<Moved<M>>, Stop<Infallible>> {
        if self.found.iterations >= self.max_iterations {
            return Err(Stop::Ended(Status::MaxIterations));
        }
        self.found.iterations += 1;
        let moved = self.found.model.moved(&linear.unscaled(&(step * factor)));
        Ok(moved.map(|model| Moved { cost: cost(&model, self.points, self.worth), model }))
    }

    fn accept(&mut self, _: Linear, trial: Moved<M>, _: StepTaken) -> Result<(), Stop<Infallible>> {
        (self.found.model, self.found.cost) = (trial.model, trial.cost);
        Ok(())
    }
}

/// The Hessian in unknowns scaled by `lengths`, by differences of the gradient. At a minimum, where the gradient vanishes, it
/// does not matter that the unknowns of a neighbouring shape are its own.
fn hessian<const D: usize, M: Model<D>>(
    model: &M,
    points: &[SVector<f64, D>],
    worth: Worth,
    lengths: &DVector<f64>,
) -> Option<DMatrix<f64>> {
    let n = M::UNKNOWNS;
    // Well within the scale of the loss.
    let width = if let Worth::Tukey(scale) = worth { (0.01 * scale).min(1e-5) } else { 1e-5 };
    let h = width * (points.len() as f64).sqrt();
    let mut matrix = DMatrix::zeros(n, n);
    for k in 0..n {
        let mut step = [0.0; MAX_UNKNOWNS];
        step[k] = h / lengths[k];
        let above = gradient(&model.moved(&step)?, points, worth);
        step[k] = -step[k];
        let below = gradient(&model.moved(&step)?, points, worth);
        for i in 0..n {
            matrix[(i, k)] = (above[i] - below[i]) / (2.0 * h * lengths[i]);
        }
    }
    let symmetric = (&matrix + matrix.transpose()) * 0.5;
    symmetric.iter().all(|x| x.is_finite()).then_some(symmetric)
}

/// Newton's method until steps are lost in rounding. False, and nothing changed, if it does not converge.
fn finish<const D: usize, M: Model<D>>(
    found: &mut Minimum<M>,
    points: &[SVector<f64, D>],
    worth: Worth,
) -> bool {
    let root = (points.len() as f64).sqrt();
    let mut model = found.model.clone();
    let (mut last, mut gain) = (f64::INFINITY, f64::INFINITY);
    let mut steps = 0;
    'again: for _ in 0..6 {
        let linear = Linear::new(&factor(&model, points, worth));
        let Some(matrix) = hessian(&model, points, worth, &linear.lengths) else { return false };
        let Some(cholesky) = Cholesky::new(matrix) else { return false };
        for _ in 0..6 {
            let slope = gradient(&model, points, worth).component_div(&linear.lengths);
            let step = -cholesky.solve(&slope);
            let motion = step.norm() / root;
            gain = slope.dot(&step).abs();
            if !motion.is_finite() || (motion > last && last > SETTLED) {
                return false;
            }
            // At the limit of rounding steps no longer become shorter.
            if motion > 0.5 * last || motion == 0.0 {
                break 'again;
            }
            let Some(next) = model.moved(&linear.unscaled(&step)) else { return false };
            let slow = motion > 0.01 * last;
            (model, last) = (next, motion);
            steps += 1;
            if slow {
                continue 'again;
            }
        }
    }
    let value = cost(&model, points, worth);
    let rounding = ROUNDING_SQ * points.len() as f64;
    if last > SETTLED || gain > GAIN * value + rounding || value > found.cost * (1.0 + 1e-9) + rounding {
        return false;
    }
    let linear = Linear::new(&factor(&model, points, worth));
    found.conditioning = linear.conditioning;
    (found.model, found.cost) = (model, value);
    found.iterations += steps;
    true
}

/// Covariance of the elements, `σ̂² G H⁻¹ Gᵀ`, `G` their derivatives by the unknowns. Elements in units of the cloud.
pub(super) fn covariance<const D: usize, M: Model<D>>(
    found: &Minimum<M>,
    points: &[SVector<f64, D>],
    worth: Worth,
    centre: &SVector<f64, D>,
) -> Option<DMatrix<f64>> {
    let n = M::UNKNOWNS;
    let linear = Linear::new(&factor(&found.model, points, worth));
    let matrix = hessian(&found.model, points, worth, &linear.lengths)?;
    let inverse = Cholesky::new(matrix)?.inverse();
    let h = 1e-5 * (points.len() as f64).sqrt();
    let values = found.model.elements(centre).values().len();
    let mut slopes = DMatrix::zeros(values, n);
    for k in 0..n {
        let mut step = [0.0; MAX_UNKNOWNS];
        step[k] = h / linear.lengths[k];
        let above = found.model.moved(&step)?.elements(centre).values();
        step[k] = -step[k];
        let below = found.model.moved(&step)?.elements(centre).values();
        for i in 0..values {
            slopes[(i, k)] = (above[i] - below[i]) / (2.0 * h);
        }
    }
    let freedom = (points.len() * M::ROWS).saturating_sub(n).max(1);
    Some(&slopes * inverse * slopes.transpose() * (found.cost / freedom as f64))
}
