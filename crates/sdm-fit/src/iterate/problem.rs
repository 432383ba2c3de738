//! The fit of a shape as a problem of the common loop.

use super::{
    CORRELATED, DIVERGENCE_RATIO, GLOBAL_SEARCH_INTERVAL, NEGLIGIBLE_GAIN, PATIENCE, ROUNDED_COST, ROUNDING,
    Run, extent,
};
use crate::Error;
use crate::assemble::{Normal, assemble};
use crate::fairing::Fairing;
use crate::noise::{Noise, disagreement};
use crate::report::FitStep;
use crate::shape::{ActiveShape, Penalty};
use crate::smoothing::{LambdaEstimate, estimate_lambda};
use crate::target::Feet;
use crate::weights::{measure, weights};
use distance_field::{ErrorTerm, Search};
use nalgebra::SVector;
use sdm_core::{
    Exhausted, FootpointPolicy, Problem, Status, StepControl, StepDirection, StepTaken, Stop, Trial,
};

/// Displacement as a share of the size up to which footpoints are followed from the last ones.
const WARM_START_DISPLACEMENT: f64 = 0.02;
/// Least damping: what rounding leaves of a direction in which nothing changes.
const LEAST_LIFT: f64 = 1e-13;
/// Largest lift of a matrix that is not positive definite.
const LARGEST_LIFT: f64 = 10.0;

/// The quadratic models of one iteration with their energies.
pub(super) struct Linear<const D: usize> {
    normal: Normal<D>,
    /// Half the negative gradient of the models and all energies.
    vector: Vec<SVector<f64, D>>,
    weights: Vec<f64>,
    cost: f64,
    lambda: f64,
    estimate: LambdaEstimate,
    /// Evaluations before this iteration.
    evaluations: usize,
}

/// A shape that a step leads to.
pub(super) struct Moved<const D: usize, S> {
    shape: S,
    feet: Feet<D>,
    cost: f64,
    displacement: f64,
}

impl<const D: usize, S> Trial for Moved<D, S> {
    fn cost(&self) -> f64 {
        self.cost
    }
}

impl<const D: usize, S: ActiveShape<D>> Problem for Run<'_, D, S> {
    type Linear = Linear<D>;
    type Step = Vec<SVector<f64, D>>;
    type Trial = Moved<D, S>;
    type Error = Error;

    fn linearise(&mut self) -> Result<Linear<D>, Stop<Error>> {
        let lambda = self.schedule.lambda;
        let weights = weights(self.samples, &self.feet, self.options.robust);
        let mut normal =
            assemble(&self.layout, &self.shape, self.samples, &self.feet, &weights, self.options.term);
        let estimate = if self.schedule.needs_estimate() {
            self.estimate(&normal, &weights)
        } else {
            LambdaEstimate::NotMade
        };
        self.fairing = Fairing::new(&self.layout, &self.shape, &self.grams, self.fairing_factor());
        if let Some(share) = self.options.fairing_cap
            && let Some(fairing) = self.fairing.take()
        {
            let most = share * measure(&self.feet, &weights).0;
            self.fairing = Some(fairing.capped(&self.layout, self.shape.coefficients(), most));
        }
        if let Some(fairing) = &self.fairing {
            fairing.add_to(&self.layout, &mut normal, self.shape.coefficients());
        }
        self.add_penalties(&mut normal);
        let bending = self.layout.multiply(&self.energy, self.shape.coefficients());
        let vector = normal.vector.iter().zip(&bending).map(|(v, b)| v - b * lambda).collect();
        let cost = measure(&self.feet, &weights).0 + self.energy_of(&self.shape);
        Ok(Linear { normal, vector, weights, cost, lambda, estimate, evaluations: self.evaluations })
    }

    fn cost(&self, linear: &Linear<D>) -> f64 {
        linear.cost
    }

    fn direction(
        &mut self,
        linear: &Linear<D>,
        damping: f64,
    ) -> Result<StepDirection<Self::Step>, Stop<Error>> {
        let Some(step) = self.solve(linear, damping) else { return Err(Stop::Ended(Status::Singular)) };
        if !self.displacement(&step, 1.0).is_finite() {
            return Err(Stop::Ended(Status::Diverged));
        }
        let slope = -2.0 * linear.vector.iter().zip(&step).map(|(v, s)| v.dot(s)).sum::<f64>();
        // Side conditions that do not hold yet come first.
        let slope = if self.side.has_conditions() { slope.min(0.0) } else { slope };
        Ok(StepDirection::along(step, slope))
    }

    fn advance(
        &mut self,
        linear: &Linear<D>,
        step: &Self::Step,
        factor: f64,
    ) -> Result<Option<Moved<D, S>>, Stop<Error>> {
        let moved: Vec<_> = self.shape.coefficients().iter().zip(step).map(|(d, s)| d + s * factor).collect();
        let mut shape = self.shape.clone();
        if shape.set_coefficients(&moved).is_err() {
            return Ok(None);
        }
        let displacement = self.displacement(step, factor);
        let feet = self.find(&shape, self.search_for(displacement))?;
        let cost = measure(&feet, &linear.weights).0 + self.energy_of(&shape);
        Ok(cost.is_finite().then_some(Moved { shape, feet, cost, displacement }))
    }

    fn accept(&mut self, linear: Linear<D>, trial: Moved<D, S>, taken: StepTaken) -> Result<(), Stop<Error>> {
        self.since_global =
            if self.search_for(trial.displacement) == Search::Global { 0 } else { self.since_global + 1 };
        self.shape = trial.shape;
        if self.fairing_factor() > 0.0 {
            self.shape.step_taken();
        }
        self.feet = trial.feet;
        if self.options.evolution {
            self.evolution.push(self.shape.coefficients().to_vec());
        }
        let (sum, max, _) = measure(&self.feet, &linear.weights);
        let rms = sum.sqrt();
        let record = FitStep {
            iteration: self.history.len() + 1,
            lambda: linear.lambda,
            rms,
            max,
            cost: trial.cost,
            displacement: trial.displacement,
            factor: taken.factor,
            damping: taken.damping,
            evaluations: self.evaluations - linear.evaluations,
            samples: linear.weights.iter().filter(|w| **w > 0.0).count(),
            coefficients: self.shape.coefficients().len(),
            lifted: self.lifted,
        };
        self.history.push(record);
        if self.options.control == StepControl::None && self.best.as_ref().is_none_or(|best| rms < best.0) {
            self.best = Some((rms, self.shape.clone()));
        }
        if !trial.cost.is_finite() || extent(self.shape.coefficients()) > DIVERGENCE_RATIO * self.size {
            return Err(Stop::Ended(Status::Diverged));
        }
        if (self.progress)(&record).is_break() {
            return Err(Stop::Ended(Status::Cancelled));
        }
        if self.options.abs_goal.is_some_and(|goal| rms <= goal) {
            return Err(Stop::Ended(Status::Converged));
        }
        let still = self.is_still(linear.cost, trial.cost);
        self.quiet = if still { self.quiet + 1 } else { 0 };
        let settled = self.schedule.is_settled();
        self.schedule.advance(linear.estimate);
        let exact = trial.cost.sqrt() <= ROUNDED_COST * self.size;
        let at_rest =
            taken.is_full() && trial.displacement <= self.options.tolerance || self.quiet >= PATIENCE;
        if settled && (at_rest || exact) {
            return Err(Stop::Ended(Status::Converged));
        }
        Ok(())
    }

    fn exhausted(
        &mut self,
        linear: Linear<D>,
        last: Exhausted<Self::Step>,
    ) -> Result<Option<Linear<D>>, Stop<Error>> {
        if self.options.control == StepControl::None {
            return Err(Stop::Ended(Status::Diverged));
        }
        // Nothing lowers this cost; a later one with less energy may still be lowered.
        if !self.schedule.is_settled() {
            self.schedule.advance(linear.estimate);
            return Ok(None);
        }
        // Or the feet that were followed are not the nearest any more.
        if self.since_global > 0 {
            self.feet = self.find(&self.shape.clone(), Search::Global)?;
            self.since_global = 0;
            return Ok(None);
        }
        let displacement = last.step.map_or(0.0, |step| self.displacement(&step, 1.0));
        let small = last.slope.abs() <= NEGLIGIBLE_GAIN * linear.cost
            || displacement <= self.options.tolerance.max(ROUNDING)
            || linear.cost.sqrt() <= ROUNDED_COST * self.size;
        Err(Stop::Ended(if small { Status::Converged } else { Status::Stalled }))
    }
}

impl<const D: usize, S: ActiveShape<D>> Run<'_, D, S> {
    /// Adds the penalties of the present shape, linearised, to the normal equations.
    fn add_penalties(&self, normal: &mut Normal<D>) {
        let penalties = self.shape.penalties();
        if penalties.is_empty() {
            return;
        }
        let cells = self.shape.cells();
        normal.matrix = self.layout.with_whole_blocks::<D>(&normal.matrix);
        for Penalty { cell, value, gradient } in &penalties {
            self.layout.add_square(cells, *cell, gradient, &mut normal.matrix);
            for (&column, derivative) in cells.columns(*cell).iter().zip(gradient) {
                normal.vector[column] -= derivative * *value;
            }
        }
    }

    /// The displacements that the models ask for.
    fn solve(&mut self, linear: &Linear<D>, damping: f64) -> Option<Vec<SVector<f64, D>>> {
        let matrix = &linear.normal.matrix;
        let mean = self.layout.mean_diagonal::<D>(matrix).abs();
        let energy = (self.schedule.lambda, &self.energy);
        let mut lift = LEAST_LIFT;
        loop {
            let total = (damping + lift) * mean;
            let factor = self.layout.factor::<D>(matrix, energy, total, &self.side.freedom);
            let step = factor.and_then(|f| self.side.solve(&f, &linear.vector, self.shape.coefficients()));
            if step.is_some() {
                self.lifted = lift > LEAST_LIFT;
                return step;
            }
            // Not positive definite: the Taylor model away from a minimum, or rounding.
            lift *= 100.0;
            if lift > LARGEST_LIFT {
                return None;
            }
        }
    }

    /// The longest displacement of a coefficient as a share of the size.
    fn displacement(&self, step: &[SVector<f64, D>], factor: f64) -> f64 {
        step.iter().map(|s| s.norm()).fold(0.0, f64::max) * factor / self.size
    }

    /// The factor of the energy that the data ask for.
    fn estimate(&mut self, normal: &Normal<D>, weights: &[f64]) -> LambdaEstimate {
        if disagreement(&self.shape, self.samples, &self.feet, weights) < CORRELATED {
            return LambdaEstimate::NoNoise;
        }
        let tangent = (self.options.term != ErrorTerm::Tangent).then(|| {
            assemble(&self.layout, &self.shape, self.samples, &self.feet, weights, ErrorTerm::Tangent)
        });
        let normal = tangent.as_ref().unwrap_or(normal);
        let noise = Noise::of(&self.feet, weights);
        let coefficients = self.shape.coefficients();
        let freedom = &self.side.freedom;
        let near = self.schedule.estimate;
        let found =
            estimate_lambda(&mut self.layout, normal, &self.energy, coefficients, freedom, &noise, near);
        found.map_or(LambdaEstimate::NotMade, LambdaEstimate::Lambda)
    }

    fn search_for(&self, displacement: f64) -> Search {
        let is_near = displacement <= WARM_START_DISPLACEMENT && self.since_global < GLOBAL_SEARCH_INTERVAL;
        self.options.footpoints.search(is_near)
    }

    pub(super) fn find(&mut self, shape: &S, search: Search) -> Result<Feet<D>, Error> {
        self.evaluations += 1;
        self.samples.feet(shape, search, Some(&self.feet))
    }

    /// The search that ends a fit.
    pub(super) fn last_search(&self) -> Search {
        if self.options.footpoints == FootpointPolicy::Local { Search::Local } else { Search::Global }
    }
}
