//! The step of one iteration: a linear system, and control of how far it is followed.

use super::Run;
use crate::Error;
use crate::assemble::Normal;
use crate::options::StepControl;
use crate::shape::ActiveShape;
use crate::target::Feet;
use crate::weights::measure;
use nalgebra::SVector;

/// Share of the promised decrease that a step must bring (Armijo), and the shortest step.
const DECREASE: f64 = 1e-4;
const SHORTEST: f64 = 1e-6;
/// First damping of Levenberg and Marquardt as a share of the mean of the diagonal, and the last.
const DAMPING: [f64; 2] = [1e-4, 1e8];
/// Least damping: what rounding leaves of a direction in which nothing changes.
const LEAST: f64 = 1e-13;
/// Largest lift of a matrix that is not positive definite.
const LIFT: f64 = 10.0;

/// A step that was tried.
pub(super) struct Trial<const D: usize, S> {
    pub(super) shape: S,
    pub(super) feet: Feet<D>,
    pub(super) cost: f64,
    pub(super) displacement: f64,
    pub(super) factor: f64,
}

/// What a search for a step came to.
pub(super) enum Searched<const D: usize, S> {
    Found(Trial<D, S>),
    /// No step lowers the cost; `displacement` is what the full one would have been, `gain` what it promised.
    None {
        displacement: f64,
        gain: f64,
    },
    Singular,
    NotFinite,
}

impl<const D: usize, S: ActiveShape<D>> Run<'_, D, S> {
    /// The step under control.
    pub(super) fn search(
        &mut self,
        normal: &Normal<D>,
        vector: &[SVector<f64, D>],
        weights: &[f64],
        cost: f64,
    ) -> Result<Searched<D, S>, Error> {
        let slack = 1e-13 * cost;
        let least = self.options.damping;
        let mut damping = if self.options.control == StepControl::LevenbergMarquardt {
            self.damping.max(least)
        } else {
            least
        };
        loop {
            let Some(step) = self.solve(normal, vector, damping) else { return Ok(Searched::Singular) };
            let longest = self.share(&step, 1.0);
            if !longest.is_finite() {
                return Ok(Searched::NotFinite);
            }
            let slope = -2.0 * vector.iter().zip(&step).map(|(v, s)| v.dot(s)).sum::<f64>();
            match self.options.control {
                StepControl::None => {
                    return Ok(match self.attempt(&step, 1.0, weights)? {
                        Some(trial) => Searched::Found(trial),
                        None => Searched::NotFinite,
                    });
                }
                StepControl::Armijo => {
                    // Side conditions that do not hold yet come first.
                    let slope = if self.side.has_conditions() { slope.min(0.0) } else { slope };
                    let mut factor = 1.0;
                    while factor > SHORTEST {
                        if let Some(trial) = self.attempt(&step, factor, weights)?
                            && trial.cost <= cost + DECREASE * factor * slope + slack
                        {
                            return Ok(Searched::Found(trial));
                        }
                        factor *= 0.5;
                    }
                    return Ok(Searched::None { displacement: longest, gain: slope.abs() });
                }
                StepControl::LevenbergMarquardt => {
                    if let Some(trial) = self.attempt(&step, 1.0, weights)?
                        && trial.cost <= cost + slack
                    {
                        self.damping = if damping <= DAMPING[0].max(least) { 0.0 } else { damping * 0.1 };
                        return Ok(Searched::Found(trial));
                    }
                    damping = (damping * 10.0).max(DAMPING[0]);
                    if damping > DAMPING[1] {
                        return Ok(Searched::None { displacement: longest, gain: slope.abs() });
                    }
                }
            }
        }
    }

    /// The displacements that the models ask for.
    fn solve(
        &mut self,
        normal: &Normal<D>,
        vector: &[SVector<f64, D>],
        damping: f64,
    ) -> Option<Vec<SVector<f64, D>>> {
        let mean = self.layout.mean_diagonal::<D>(&normal.matrix).abs();
        let energy = (self.schedule.lambda, &self.energy);
        let mut lift = LEAST;
        loop {
            let total = (damping + lift) * mean;
            let factor = self.layout.factor::<D>(&normal.matrix, energy, total, &self.side.freedom);
            let step = factor.and_then(|f| self.side.solve(&f, vector, self.shape.coefficients()));
            if step.is_some() {
                self.lifted = lift > LEAST;
                return step;
            }
            // Not positive definite: the Taylor model away from a minimum, or rounding.
            lift *= 100.0;
            if lift > LIFT {
                return None;
            }
        }
    }

    /// The longest displacement as a share of the size.
    fn share(&self, step: &[SVector<f64, D>], factor: f64) -> f64 {
        step.iter().map(|s| s.norm()).fold(0.0, f64::max) * factor / self.size
    }

    /// The shape after a step; `None` if it is not finite.
    fn attempt(
        &mut self,
        step: &[SVector<f64, D>],
        factor: f64,
        weights: &[f64],
    ) -> Result<Option<Trial<D, S>>, Error> {
        let moved: Vec<_> = self.shape.coefficients().iter().zip(step).map(|(d, s)| d + s * factor).collect();
        let mut shape = self.shape.clone();
        if shape.set_coefficients(&moved).is_err() {
            return Ok(None);
        }
        let displacement = self.share(step, factor);
        let feet = self.find(&shape, self.search_for(displacement))?;
        let cost = measure(&feet, weights).0 + self.energy_of(&shape);
        Ok(cost.is_finite().then_some(Trial { shape, feet, cost, displacement, factor }))
    }
}
