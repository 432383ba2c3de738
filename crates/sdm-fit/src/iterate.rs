//! The fit of a shape from where it is, by the common loop.

mod problem;

use crate::constraint::{Constraints, Prepared};
use crate::fairing::Fairing;
use crate::layout::{Blocks, Layout};
use crate::options::FitOptions;
use crate::report::{FitReport, FitStep, Fitted};
use crate::shape::{ActiveShape, CellGram};
use crate::smoothing::Schedule;
use crate::target::{Feet, Samples, Target};
use crate::weights::{measure, weights};
use crate::{Error, Status};
use distance_field::{ErrorTerm, Search};
use nalgebra::SVector;
use sdm_core::{Controller, StepLimits, minimise};
use std::ops::ControlFlow;

/// Called after each iteration; may cancel.
pub type Progress<'a> = sdm_core::Progress<'a, FitStep>;

/// A progress callback that does nothing.
///
/// # Errors
/// Never breaks.
pub fn no_progress(_: &FitStep) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Iterations after which footpoints are searched globally all the same.
const GLOBAL_SEARCH_INTERVAL: usize = 5;
/// Size of the shape, in sizes of the first one and the data, that counts as divergence.
const DIVERGENCE_RATIO: f64 = 1e3;
/// Below this von Neumann ratio residuals are correlated: lack of fit, not noise.
const CORRELATED: f64 = 0.6;
/// Share of the cost that a step may promise at a minimum, and displacement as a share of the size that is nearly rounding.
const NEGLIGIBLE_GAIN: f64 = 1e-4;
const ROUNDING: f64 = 1e-7;
/// Root of a cost as a share of the size that is rounding of the distances, where nothing is left to be lowered.
const ROUNDED_COST: f64 = 1e-14;
/// Share of the cost up to which an iteration lowers it slowly; then what it gains at this rate does not become more.
const SLOW_DECREASE: f64 = 0.1;
/// Iterations in a row without a change of the cost after which the fit ends.
const PATIENCE: usize = 3;
/// First damping of Levenberg and Marquardt as a share of the mean of the diagonal.
const FIRST_DAMPING: f64 = 1e-4;

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
        progress,
        samples: &samples,
        side,
        options,
        layout,
        energy,
        grams,
        fairing: None,
        size: extent(&start).max(largest).max(f64::MIN_POSITIVE),
        schedule: Schedule::new(options.smoothing),
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
    let limits = StepLimits { first: FIRST_DAMPING, least: options.damping, ..StepLimits::default() };
    let status = minimise(&mut run, &mut Controller::new(options.control, limits), options.max_iterations)?;
    run.finish(status, initial_rms)
}

/// The state of a fit.
struct Run<'a, const D: usize, S> {
    progress: Progress<'a>,
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
    history: Vec<FitStep>,
    evolution: Vec<Vec<SVector<f64, D>>>,
}

impl<const D: usize, S: ActiveShape<D>> Run<'_, D, S> {
    fn bending_energy(&self, coefficients: &[SVector<f64, D>]) -> f64 {
        let image = self.layout.multiply(&self.energy, coefficients);
        coefficients.iter().zip(&image).map(|(a, b)| a.dot(b)).sum::<f64>().max(0.0)
    }

    /// The factor of the fairing; models of points fix the places in the tangent planes themselves.
    fn fairing_factor(&self) -> f64 {
        if self.options.term == ErrorTerm::Point { 0.0 } else { self.options.fairing }
    }

    /// All energies with their factors, and the penalties.
    fn energy_of(&self, shape: &S) -> f64 {
        let coefficients = shape.coefficients();
        let fair = self.fairing.as_ref().map_or(0.0, |f| f.value(&self.layout, coefficients));
        let penalty: f64 = shape.penalties().iter().map(|p| p.value * p.value).sum();
        self.schedule.lambda * self.bending_energy(coefficients) + fair + penalty
    }

    /// Whether an iteration has not changed the cost: as a share of it, or, where hardly anything is left of it, as the square of a
    /// distance that is rounding. Without noise the cost has no floor to which its share could be measured: it falls on and on, always
    /// more slowly, by what no data resolve.
    fn is_still(&self, before: f64, after: f64) -> bool {
        let change = (before - after).abs();
        let rounding = ROUNDING * self.size;
        change <= self.options.cost_tolerance * before.abs()
            || change <= rounding * rounding && change <= SLOW_DECREASE * before.abs()
    }

    fn finish(mut self, status: Status, initial_rms: f64) -> Result<Fitted<S, D>, Error> {
        if status == Status::Diverged
            && let Some((_, shape)) = self.best.take()
        {
            self.shape = shape;
        }
        let shape = self.shape.clone();
        self.feet = self.find(&shape, self.last_search())?;
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
