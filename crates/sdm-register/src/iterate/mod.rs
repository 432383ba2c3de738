//! A stage of a registration: the common loop in the unknowns of a motion.

mod end;
mod problem;
mod settle;
mod shrinking;

use crate::anderson::Anderson;
use crate::constraint::{Chart, Freedom};
use crate::linearise::NormalSystem;
use crate::report::RegisterStep;
use crate::solve::{Scaled, Spectrum};
use crate::source::Prepared;
use crate::view::{Terms, View};
use crate::weights::{Rejection, Rule, Weighting};
use crate::{Method, Pose, RegisterOptions, Status};
use distance_field::{DistanceField, Search};
use nalgebra::{DMatrix, DVector};
use sdm_core::{Controller, StepLimits, minimise};

/// Called after each step; may cancel.
pub type Progress<'a> = sdm_core::Progress<'a, RegisterStep>;

/// What stays the same in all stages.
pub(crate) struct Job<'a, const D: usize> {
    pub(crate) field: &'a dyn DistanceField<D>,
    pub(crate) chart: &'a Chart<D>,
    pub(crate) options: &'a RegisterOptions<D>,
    pub(crate) progress: Progress<'a>,
}

/// One stage: a cloud, a rule for its weights, and when to stop.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stage<'a, const D: usize> {
    pub(crate) name: &'static str,
    pub(crate) cloud: &'a Prepared<D>,
    pub(crate) method: Method,
    pub(crate) rule: Rule,
    pub(crate) rejection: Rejection,
    /// Whether the points that are rejected at the beginning stay so, and no others: the cost then has no jumps.
    pub(crate) holds_rejection: bool,
    /// Share of the largest eigenvalue up to which a motion is not made.
    pub(crate) null_tolerance: f64,
    /// Whether these are so many points that no step is made, nor followed by a search for feet, which the noise makes meaningless.
    pub(crate) is_long: bool,
    /// Length of the step before the first one, as a share of the size of the cloud.
    pub(crate) moving: f64,
    pub(crate) tolerance: f64,
    pub(crate) max_iterations: usize,
}

/// How a stage ended.
#[derive(Debug)]
pub(crate) struct Outcome<const D: usize> {
    pub(crate) view: View<D>,
    /// Weights of the points before the kernel.
    pub(crate) base: Vec<f64>,
    pub(crate) weighting: Weighting,
    pub(crate) status: Status,
    pub(crate) evaluations: usize,
}

/// The steps of all stages.
pub(crate) type History = Vec<RegisterStep>;

/// A motion below which the cost is all rounding, so that nothing is concluded from its change.
const ROUNDING: f64 = 1e-7;
/// Motions below this share of the standard error of the mean distance mean nothing either.
const NEGLIGIBLE: f64 = 0.02;
/// Control of the steps; dampings are shares of the largest eigenvalue.
const LIMITS: StepLimits = StepLimits {
    decrease: 1e-4,
    shortest: 1e-10,
    first: 1e-3,
    least: 0.0,
    last: 1e8,
    drops: true,
    slack: 1e-12,
};
/// Fewest directions that determine a motion.
pub(crate) const fn fewest(dimension: usize) -> usize {
    dimension
}

/// The models at one pose.
struct Models<const D: usize> {
    system: NormalSystem<D>,
    freedom: Freedom<D>,
    scaled: Scaled,
    vector: DVector<f64>,
    linear: Spectrum,
    /// Matrix and spectrum of Newton's method.
    newton: Option<(DMatrix<f64>, Spectrum)>,
}

impl<const D: usize> Job<'_, D> {
    pub(crate) fn view(&self, cloud: &Prepared<D>, pose: Pose<D>) -> View<D> {
        View::new(self.field, cloud, pose, Search::Global, None, self.options.scale)
    }

    fn models(&self, stage: &Stage<'_, D>, view: &View<D>, base: &[f64], weighting: &Weighting) -> Models<D> {
        let terms = Terms {
            term: stage.method.term(),
            taylor: stage.method.needs_taylor(),
            symmetric: stage.method == Method::Symmetric,
        };
        let system = view.system(stage.cloud, base, weighting, &terms);
        let freedom = self.chart.freedom(&view.pose);
        let tangent = freedom.reduce(&system.tangent);
        let length = stage.cloud.diagonal * view.pose.scale * 0.5;
        let scaled = Scaled::new(&tangent, &freedom.is_translation, length, stage.null_tolerance);
        let vector = freedom.reduce_vector(&system.vector);
        let linear = scaled.spectrum(&(&tangent + freedom.reduce(&system.term)), &vector);
        let newton = terms.taylor.then(|| {
            let matrix = &tangent + freedom.reduce(&system.taylor) + freedom.curvature(&system);
            let spectrum = scaled.spectrum(&matrix, &vector);
            (matrix, spectrum)
        });
        Models { system, freedom, scaled, vector, linear, newton }
    }

    /// Runs one stage from a view of its cloud.
    pub(crate) fn run(&self, stage: &Stage<'_, D>, view: View<D>, history: &mut History) -> Outcome<D> {
        let start = view.pose;
        let mut run = Run {
            job: self,
            stage,
            history,
            base: view.base_weights(stage.cloud, &stage.rejection),
            view,
            weighting: Weighting::SQUARES,
            trusted: stage.method == Method::Newton,
            damping: 0.0,
            last_motion: f64::INFINITY,
            creeping: 0,
            idle: 0,
            settled_cost: f64::INFINITY,
            evaluations: 0,
            anderson: (stage.method == Method::AndersonPoint
                && !self.options.locks.any()
                && !self.options.scale)
                .then(|| Anderson::new(start, stage.cloud.diagonal)),
        };
        let mut control = Controller::new(self.options.control, LIMITS);
        let Ok(status) = minimise(&mut run, &mut control, stage.max_iterations);
        let field = self.field;
        run.evaluations += usize::from(run.view.complete(field, stage.cloud));
        run.refresh_weights();
        Outcome {
            view: run.view,
            base: run.base,
            weighting: run.weighting,
            status,
            evaluations: run.evaluations,
        }
    }
}

/// The state of a stage.
struct Run<'a, const D: usize> {
    job: &'a Job<'a, D>,
    stage: &'a Stage<'a, D>,
    history: &'a mut History,
    view: View<D>,
    base: Vec<f64>,
    weighting: Weighting,
    /// Whether Newton's model predicted what the last step did.
    trusted: bool,
    /// Damping that the last step left.
    damping: f64,
    last_motion: f64,
    /// Steps one after the other that made no difference, see [`Self::makes_no_difference`].
    creeping: u32,
    /// The same for steps that idle.
    idle: u32,
    /// Where whole steps were tried.
    settled_cost: f64,
    evaluations: usize,
    anderson: Option<Anderson<D>>,
}

impl<const D: usize> Run<'_, D> {
    fn refresh_weights(&mut self) {
        if !self.stage.holds_rejection {
            self.base = self.view.base_weights(self.stage.cloud, &self.stage.rejection);
        }
        let mut distances =
            if self.stage.rule.adapts() { self.view.distances(&self.base) } else { Vec::new() };
        let moving = if self.last_motion.is_finite() { self.last_motion } else { self.stage.moving };
        let moving = moving * self.view.size(self.stage.cloud);
        self.weighting = self.stage.rule.weighting(&mut distances, moving);
    }

    /// The record of a whole step to the present view, with its rms and number of points, since a number of evaluations.
    fn record(
        &self,
        name: &'static str,
        motion: f64,
        (rms, points): (f64, usize),
        evaluations: usize,
    ) -> RegisterStep {
        let unit = self.view.unit();
        RegisterStep {
            stage: self.stage.name,
            step: name,
            points,
            rms: rms * unit,
            motion,
            angle: 0.0,
            damping: 0.0,
            factor: 1.0,
            evaluations: self.evaluations - evaluations,
            scale: self.weighting.scale().map(|scale| scale * unit),
        }
    }
}
