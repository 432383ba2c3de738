//! Control points and weights together: the extension to NURBS ([P05, sec. 4.1]).
//!
//! As for curves, each step takes the derivatives by the control points `dᵢ` and the logarithms of the weights `wᵢ`, which stay
//! positive: `∂s/∂dᵢ = Rᵢ`, `∂s/∂ln wᵢ = Rᵢ (dᵢ − s)` with the rational basis functions `Rᵢ`.

use super::rational_system::Unknowns;
use crate::freedom::Freedom;
use crate::iterate::Progress;
use crate::layout::{Blocks, Layout};
use crate::rational::{LIMITS, SMALL_DECREASE};
use crate::{Error, FitReport, FitStep, Status};
use distance_field::{DistanceField, Hint, PrincipalFrame, Search, SurfaceField};
use nalgebra::{SVector, Vector3};
use nurbs_core::BsplineSurface;
use sdm_core::{Controller, Problem, StepControl, StepDirection, StepTaken, Stop, Trial, minimise};

/// Steps at most.
const STEPS: usize = 100;
/// Share of the size below which a surface counts as exact, and is not improved further.
pub(super) const EXACT: f64 = 1e-9;
const ROUNDING: f64 = 1e-13;
const EXACTLY: f64 = 1e-11;

/// A state of the iteration.
#[derive(Clone, Debug)]
pub(super) struct Weighted {
    pub(super) surface: BsplineSurface,
    pub(super) frames: Vec<PrincipalFrame<3>>,
    /// Mean squared distance.
    cost: f64,
}

impl Weighted {
    fn new(surface: BsplineSurface, points: &[Vector3<f64>], hints: &[Hint]) -> Result<Self, Error> {
        let search = if hints.is_empty() { Search::Global } else { Search::Local };
        let frames = SurfaceField::new(&surface)?.frames(points, search, hints);
        let used = frames.iter().filter(|f| f.is_finite());
        let cost = used.map(|f| f.distance * f.distance).sum::<f64>() / points.len().max(1) as f64;
        Ok(Self { surface, frames, cost })
    }

    /// Root mean square distance.
    pub(super) fn rms(&self) -> f64 {
        self.cost.sqrt()
    }

    fn hints(&self) -> Vec<Hint> {
        self.frames.iter().map(|frame| frame.hint).collect()
    }

    /// What the report of the loop says, for this state.
    pub(super) fn report(&self, before: Option<FitReport>, status: Status, steps: Vec<FitStep>) -> FitReport {
        let distances = self.frames.iter().map(|f| f.distance.abs()).enumerate();
        let (max_index, max) =
            distances.fold((0, 0.0), |best, (i, d)| if d > best.1 { (i, d) } else { best });
        let mut history = before.as_ref().map_or_else(Vec::new, |report| report.history.clone());
        history.extend(steps);
        (1..).zip(&mut history).for_each(|(number, step)| step.iteration = number);
        FitReport {
            status,
            initial_rms: before.map_or_else(|| history.first().map_or(0.0, |s| s.rms), |b| b.initial_rms),
            rms: self.cost.sqrt(),
            max,
            max_index,
            lambda: 0.0,
            samples: self.frames.len(),
            used: self.frames.iter().filter(|f| f.is_finite()).count(),
            history,
        }
    }
}

/// Levenberg and Marquardt with the tangent model of the distances, from a surface with or without weights.
pub(super) fn improved(
    points: &[Vector3<f64>],
    surface: BsplineSurface,
    progress: Progress<'_>,
) -> Result<(Weighted, Status, Vec<FitStep>), Error> {
    let size = points.iter().map(|p| p.amax()).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let place = Weighted::new(surface, points, &[])?;
    let unknowns = Unknowns::new(&place.surface);
    let layout = Layout::new(&unknowns.cells, unknowns.count);
    let nothing = layout.zeros(1);
    let mut run = Run { points, size, place, unknowns, layout, nothing, steps: Vec::new(), progress };
    let mut control = Controller::new(StepControl::LevenbergMarquardt, LIMITS);
    let status = match minimise(&mut run, &mut control, STEPS)? {
        // The cost falls strictly until rounding is all that is left of it.
        Status::Stalled => Status::Converged,
        // Rounding keeps on changing the last digits.
        Status::MaxIterations if run.place.cost.sqrt() <= EXACTLY * size => Status::Converged,
        status => status,
    };
    // The feet that were followed are the nearest ones, or this tells.
    let found = Weighted::new(run.place.surface, points, &[])?;
    Ok((found, status, run.steps))
}

/// The iteration in control points and weights.
struct Run<'a> {
    points: &'a [Vector3<f64>],
    size: f64,
    place: Weighted,
    unknowns: Unknowns,
    layout: Layout,
    /// No energy.
    nothing: Blocks,
    steps: Vec<FitStep>,
    progress: Progress<'a>,
}

/// A surface that a step leads to, and how far a control point moved.
struct Moved {
    place: Weighted,
    longest: f64,
}

impl Trial for Moved {
    fn cost(&self) -> f64 {
        self.place.cost
    }
}

impl Problem for Run<'_> {
    /// Matrix and half the negative gradient.
    type Linear = (Blocks, Vec<SVector<f64, 1>>);
    type Step = Vec<SVector<f64, 1>>;
    type Trial = Moved;
    type Error = Error;

    fn linearise(&mut self) -> Result<Self::Linear, Stop<Error>> {
        if self.place.cost.sqrt() <= ROUNDING * self.size {
            return Err(Stop::Ended(Status::Converged));
        }
        Ok(self.unknowns.system(&self.layout, &self.place.frames, &self.place.surface, self.points))
    }

    fn cost(&self, _: &Self::Linear) -> f64 {
        self.place.cost
    }

    fn direction(
        &mut self,
        (matrix, vector): &Self::Linear,
        damping: f64,
    ) -> Result<StepDirection<Self::Step>, Stop<Error>> {
        let lift = damping * self.layout.mean_diagonal::<1>(matrix);
        let factor = self.layout.factor::<1>(matrix, (0.0, &self.nothing), lift, &Freedom::full());
        let step = factor.and_then(|factor| factor.solve(vector));
        Ok(step.map_or(StepDirection::Singular, |step| {
            let slope = -2.0 * vector.iter().zip(&step).map(|(v, s)| v.dot(s)).sum::<f64>();
            StepDirection::along(step, slope)
        }))
    }

    fn advance(
        &mut self,
        _: &Self::Linear,
        step: &Self::Step,
        factor: f64,
    ) -> Result<Option<Moved>, Stop<Error>> {
        let step: Vec<_> = step.iter().map(|s| s * factor).collect();
        let Some((surface, longest)) = self.unknowns.moved(&self.place.surface, &step) else {
            return Ok(None);
        };
        let place = Weighted::new(surface, self.points, &self.place.hints())?;
        Ok(Some(Moved { place, longest }))
    }

    fn accept(&mut self, _: Self::Linear, trial: Moved, taken: StepTaken) -> Result<(), Stop<Error>> {
        let before = std::mem::replace(&mut self.place, trial.place);
        let record = FitStep {
            iteration: self.steps.len() + 1,
            lambda: 0.0,
            rms: self.place.rms(),
            max: self.place.frames.iter().map(|f| f.distance.abs()).fold(0.0, f64::max),
            cost: self.place.cost,
            displacement: trial.longest / self.size,
            factor: taken.factor,
            damping: taken.damping,
            evaluations: 1,
            samples: self.points.len(),
            coefficients: self.unknowns.weight_count(),
            lifted: false,
        };
        self.steps.push(record);
        if (self.progress)(&record).is_break() {
            return Err(Stop::Ended(Status::Cancelled));
        }
        let still = before.cost - self.place.cost <= SMALL_DECREASE * before.cost;
        if still { Err(Stop::Ended(Status::Converged)) } else { Ok(()) }
    }
}
