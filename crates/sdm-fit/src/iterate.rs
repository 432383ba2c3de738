//! The loop: footpoints, quadratic models, a sparse linear system, a controlled step, again.

mod search;

use crate::assemble::{Normal, assemble};
use crate::constraint::{Constraints, Prepared};
use crate::fairing::Fairing;
use crate::layout::{Blocks, Layout};
use crate::noise::{Noise, disagreement};
use crate::options::{FitOptions, FootpointPolicy, StepControl};
use crate::report::{FitReport, Fitted, StepRecord};
use crate::shape::{ActiveShape, CellGram, Penalty};
use crate::smoothing::{Answer, Schedule, wanted};
use crate::target::{Feet, Samples, Target};
use crate::weights::{measure, weights};
use crate::{Error, Status};
use distance_field::{ErrorTerm, Search};
use nalgebra::SVector;
use search::Searched;
use std::ops::ControlFlow;

/// Called after each iteration; may cancel.
pub type Progress<'a> = &'a (dyn Fn(&StepRecord) -> ControlFlow<()> + Sync);

/// A progress callback that does nothing.
///
/// # Errors
/// Never breaks.
pub fn no_progress(_: &StepRecord) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Displacement as a share of the size up to which footpoints are followed from the last ones.
const NEAR: f64 = 0.02;
/// Iterations after which they are found anew all the same.
const REFRESH: usize = 5;
/// A shape this much larger than the first one and the data has run away.
const AWAY: f64 = 1e3;
/// Below this neighbours agree on what is left: no noise.
const AGREE: f64 = 0.6;
/// Share of the cost whose promise does not matter, and displacement as a share of the size that is nearly rounding.
const MINOR: f64 = 1e-4;
const ROUNDING: f64 = 1e-7;
/// Root of a cost as a share of the size that is rounding of the distances, where nothing is left to be lowered.
const NOTHING: f64 = 1e-14;
/// Share of the cost up to which an iteration lowers it slowly; then what it gains at this rate does not become more.
const SLOW: f64 = 0.1;
/// Iterations in a row without a change of the cost after which the fit ends.
const PATIENCE: usize = 3;

/// Fits a shape to data points or a model from where it is (\[P05, sec. 4\]).
///
/// # Errors
/// Input that cannot be used: see [`Error`]. Not converging is a status of the report.
pub fn fit<const D: usize, S: ActiveShape<D>>(
    shape: S,
    target: Target<'_, D>,
    constraints: &Constraints<D>,
    options: &FitOptions,
) -> Result<Fitted<S, D>, Error> {
    fit_with_progress(shape, target, constraints, options, &no_progress)
}

/// [`fit`] with a callback after each iteration, which may cancel.
///
/// # Errors
/// As for [`fit`].
pub fn fit_with_progress<const D: usize, S: ActiveShape<D>>(
    mut shape: S,
    target: Target<'_, D>,
    constraints: &Constraints<D>,
    options: &FitOptions,
    progress: Progress<'_>,
) -> Result<Fitted<S, D>, Error> {
    options.check()?;
    let samples = Samples::new(target, &shape)?;
    let mut start = shape.coefficients().to_vec();
    let side = Prepared::new(constraints, &mut start)?;
    shape.set_coefficients(&start)?;
    let feet = samples.feet(&shape, Search::Global, None)?;
    let usable = (0..samples.len()).filter(|&i| samples.weight(i, &feet) > 0.0).count();
    if usable == 0 {
        return Err(Error::TooFewPoints { total: samples.len(), finite: 0, needed: 1 });
    }
    let layout = Layout::new(shape.cells(), start.len());
    let grams = shape.energy(options.energy);
    let energy = layout.gram(shape.cells(), &grams);
    let initial_rms = measure(&feet, &weights(&samples, &feet, options.robust)).0.sqrt();
    let largest =
        (0..samples.len()).filter(|&i| feet.usable(i)).map(|i| feet.distance(i)).fold(0.0, f64::max);
    let mut run = Run {
        samples: &samples,
        side,
        options,
        layout,
        energy,
        grams,
        fairing: None,
        size: extent(&start).max(largest).max(f64::MIN_POSITIVE),
        schedule: Schedule::new(options.smoothing),
        damping: 0.0,
        lifted: false,
        quiet: 0,
        since_global: 0,
        evaluations: 1,
        best: None,
        shape,
        feet,
        history: Vec::new(),
        evolution: if options.evolution { vec![start] } else { Vec::new() },
    };
    let ended = (0..options.max_iterations).find_map(|_| run.step(progress).transpose());
    let status = match ended {
        Some(Ok(status)) => status,
        Some(Err(error)) => return Err(error),
        None => Status::MaxIterations,
    };
    run.finish(status, initial_rms)
}

/// The state of a fit.
struct Run<'a, const D: usize, S> {
    samples: &'a Samples<'a, D>,
    side: Prepared<D>,
    options: &'a FitOptions,
    layout: Layout,
    energy: Blocks,
    /// The energy of each cell, and what it says about the tangent planes of the present step.
    grams: Vec<CellGram>,
    fairing: Option<Fairing>,
    /// Size of the region of shape and data.
    size: f64,
    schedule: Schedule,
    damping: f64,
    /// Whether the matrix of the present step was lifted to be positive definite.
    lifted: bool,
    /// Iterations in a row without a change worth mentioning.
    quiet: usize,
    since_global: usize,
    evaluations: usize,
    /// The state with the least distance, when steps are not controlled.
    best: Option<(f64, S)>,
    shape: S,
    feet: Feet<D>,
    history: Vec<StepRecord>,
    evolution: Vec<Vec<SVector<f64, D>>>,
}

impl<const D: usize, S: ActiveShape<D>> Run<'_, D, S> {
    fn bend(&self, coefficients: &[SVector<f64, D>]) -> f64 {
        let image = self.layout.multiply(&self.energy, coefficients);
        coefficients.iter().zip(&image).map(|(a, b)| a.dot(b)).sum::<f64>().max(0.0)
    }

    /// The factor of the fairing; models of points fix the places in the tangent planes themselves.
    fn faired(&self) -> f64 {
        if self.options.term == ErrorTerm::Point { 0.0 } else { self.options.fairing }
    }

    /// All energies with their factors, and the penalties.
    fn energy_of(&self, shape: &S) -> f64 {
        let coefficients = shape.coefficients();
        let fair = self.fairing.as_ref().map_or(0.0, |f| f.value(&self.layout, coefficients));
        let penalty: f64 = shape.penalties().iter().map(|p| p.value * p.value).sum();
        self.schedule.lambda * self.bend(coefficients) + fair + penalty
    }

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

    /// One iteration; the status if it was the last.
    fn step(&mut self, progress: Progress<'_>) -> Result<Option<Status>, Error> {
        let lambda = self.schedule.lambda;
        let weights = weights(self.samples, &self.feet, self.options.robust);
        let evaluations = self.evaluations;
        let mut normal =
            assemble(&self.layout, &self.shape, self.samples, &self.feet, &weights, self.options.term);
        let answer = if self.schedule.asks() { self.ask(&normal, &weights) } else { Answer::NotAsked };
        self.fairing = Fairing::new(&self.layout, &self.shape, &self.grams, self.faired());
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
        let bend = self.layout.multiply(&self.energy, self.shape.coefficients());
        let vector: Vec<_> = normal.vector.iter().zip(&bend).map(|(v, b)| v - b * lambda).collect();
        let cost = measure(&self.feet, &weights).0 + self.energy_of(&self.shape);
        let searched = self.search(&normal, &vector, &weights, cost)?;
        let trial = match searched {
            Searched::Found(trial) => trial,
            Searched::Singular => return Ok(Some(Status::Singular)),
            Searched::NotFinite => return Ok(Some(Status::Diverged)),
            Searched::None { displacement, gain } => {
                // Nothing lowers this cost; a later one with less energy may still be lowered.
                if !self.schedule.is_settled() {
                    self.schedule.advance(answer);
                    return Ok(None);
                }
                // Or the feet that were followed are not the nearest any more.
                if self.since_global > 0 {
                    self.feet = self.find(&self.shape.clone(), Search::Global)?;
                    self.since_global = 0;
                    return Ok(None);
                }
                let small = gain <= MINOR * cost || displacement <= self.options.tolerance.max(ROUNDING);
                let small = small || cost.sqrt() <= NOTHING * self.size;
                return Ok(Some(if small { Status::Converged } else { Status::Stalled }));
            }
        };
        self.since_global =
            if self.search_for(trial.displacement) == Search::Global { 0 } else { self.since_global + 1 };
        self.shape = trial.shape;
        if self.faired() > 0.0 {
            self.shape.step_taken();
        }
        self.feet = trial.feet;
        if self.options.evolution {
            self.evolution.push(self.shape.coefficients().to_vec());
        }
        let (sum, max, _) = measure(&self.feet, &weights);
        let rms = sum.sqrt();
        let record = StepRecord {
            iteration: self.history.len() + 1,
            lambda,
            rms,
            max,
            cost: trial.cost,
            displacement: trial.displacement,
            factor: trial.factor,
            damping: self.damping,
            evaluations: self.evaluations - evaluations,
            samples: weights.iter().filter(|w| **w > 0.0).count(),
            coefficients: self.shape.coefficients().len(),
            lifted: self.lifted,
        };
        self.history.push(record);
        if self.options.control == StepControl::None && self.best.as_ref().is_none_or(|best| rms < best.0) {
            self.best = Some((rms, self.shape.clone()));
        }
        if !trial.cost.is_finite() || extent(self.shape.coefficients()) > AWAY * self.size {
            return Ok(Some(Status::Diverged));
        }
        if progress(&record).is_break() {
            return Ok(Some(Status::Cancelled));
        }
        if self.options.abs_goal.is_some_and(|goal| rms <= goal) {
            return Ok(Some(Status::Converged));
        }
        let still = self.is_still(cost, trial.cost);
        self.quiet = if still { self.quiet + 1 } else { 0 };
        let full = trial.factor == 1.0 && self.damping == 0.0;
        let settled = self.schedule.is_settled();
        self.schedule.advance(answer);
        let exact = trial.cost.sqrt() <= NOTHING * self.size;
        let at_rest = full && trial.displacement <= self.options.tolerance || self.quiet >= PATIENCE;
        if settled && (at_rest || exact) {
            return Ok(Some(Status::Converged));
        }
        Ok(None)
    }

    /// Whether an iteration has not changed the cost: as a share of it, or, where hardly anything is left of it, as the square of a
    /// distance that is rounding. Without noise the cost has no floor to which its share could be measured: it falls on and on, always
    /// more slowly, by what no data resolve.
    fn is_still(&self, before: f64, after: f64) -> bool {
        let change = (before - after).abs();
        let rounding = ROUNDING * self.size;
        change <= self.options.cost_tolerance * before.abs()
            || change <= rounding * rounding && change <= SLOW * before.abs()
    }

    /// The factor of the energy that the data ask for.
    fn ask(&mut self, normal: &Normal<D>, weights: &[f64]) -> Answer {
        if disagreement(&self.shape, self.samples, &self.feet, weights) < AGREE {
            return Answer::NoNoise;
        }
        let tangent = (self.options.term != ErrorTerm::Tangent).then(|| {
            assemble(&self.layout, &self.shape, self.samples, &self.feet, weights, ErrorTerm::Tangent)
        });
        let normal = tangent.as_ref().unwrap_or(normal);
        let noise = Noise::of(&self.feet, weights);
        let coefficients = self.shape.coefficients();
        let freedom = &self.side.freedom;
        let near = self.schedule.wanted;
        let found = wanted(&mut self.layout, normal, &self.energy, coefficients, freedom, &noise, near);
        found.map_or(Answer::NotAsked, Answer::Wanted)
    }

    fn search_for(&self, displacement: f64) -> Search {
        match self.options.footpoints {
            FootpointPolicy::Global => Search::Global,
            FootpointPolicy::Local => Search::Local,
            FootpointPolicy::Adaptive if displacement > NEAR || self.since_global >= REFRESH => {
                Search::Global
            }
            FootpointPolicy::Adaptive => Search::Local,
        }
    }

    fn find(&mut self, shape: &S, search: Search) -> Result<Feet<D>, Error> {
        self.evaluations += 1;
        self.samples.feet(shape, search, Some(&self.feet))
    }

    fn finish(mut self, status: Status, initial_rms: f64) -> Result<Fitted<S, D>, Error> {
        if status == Status::Diverged
            && let Some((_, shape)) = self.best.take()
        {
            self.shape = shape;
        }
        let shape = self.shape.clone();
        let search =
            if self.options.footpoints == FootpointPolicy::Local { Search::Local } else { Search::Global };
        self.feet = self.find(&shape, search)?;
        let weights = weights(self.samples, &self.feet, self.options.robust);
        let (sum, max, max_index) = measure(&self.feet, &weights);
        let report = FitReport {
            status,
            initial_rms,
            rms: sum.sqrt(),
            max,
            max_index,
            lambda: self.schedule.lambda,
            samples: self.samples.len(),
            used: weights.iter().filter(|w| **w > 0.0).count(),
            history: self.history,
        };
        Ok(Fitted { shape, report, frames: self.feet.frames, evolution: self.evolution })
    }
}

/// Largest side of the box around coefficients.
fn extent<const D: usize>(coefficients: &[SVector<f64, D>]) -> f64 {
    let mut low = SVector::<f64, D>::repeat(f64::INFINITY);
    let mut high = -low;
    for d in coefficients {
        low = low.inf(d);
        high = high.sup(d);
    }
    (high - low).max()
}
