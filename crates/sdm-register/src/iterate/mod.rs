//! The loop: footpoints, quadratic models, a small linear system, a controlled step, again.

mod control;
mod settle;
mod shrinking;

use self::shrinking::shrinking;
use crate::anderson::Anderson;
use crate::constraint::{Chart, Freedom};
use crate::linearise::NormalSystem;
use crate::report::StepRecord;
use crate::solve::{Scaled, Spectrum};
use crate::source::Prepared;
use crate::view::{Terms, View};
use crate::weights::{Rejection, Rule, Weighting};
use crate::{Method, Pose, RegisterOptions, Status};
use distance_field::{DistanceField, Search};
use nalgebra::{DMatrix, DVector};
use std::ops::ControlFlow;

/// Called after each step; may cancel.
pub type Progress<'a> = &'a (dyn Fn(&StepRecord) -> ControlFlow<()> + Sync);

/// What stays the same in all stages.
pub(crate) struct Problem<'a, const D: usize> {
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
pub(crate) type History = Vec<StepRecord>;

/// How well Newton's model has to foretell the change of the cost to be taken for the next step.
const TRUST: f64 = 0.3;
/// A motion below which the cost is all rounding, so that nothing is concluded from its change.
const ROUNDING: f64 = 1e-7;
/// A step creeps when it lowers the cost by less than the first share, and is longer than the second share of the one before.
/// After so many of them one after the other the rest is a motion along the shape that makes no difference.
const CREEPING: (f64, f64, u32) = (1e-7, 0.9, 8);
/// What the whole of a damped step could gain, in units of the variance of a distance, below which it is not looked for: it would move
/// the pose by less than a quarter of its standard deviation, and the cost of clouds has steps that are larger.
const INSIGNIFICANT: f64 = 0.0625;
/// A step idles when it is shorter than the first number and lowers the cost by less than the second share: clouds that stand for a
/// surface have a cost with small steps and corners, on which the iteration goes to and fro. Ended after so many in a row.
const IDLE: (f64, f64, u32) = (1e-8, 1e-6, 3);
/// Where each step takes long, the share of the standard error of the mean distance below which what is left does not matter, and that
/// up to which a step is made on the feet that are known, if the one before was so much longer.
const MEANINGLESS: f64 = 1e-4;
const LAST: (f64, f64) = (0.05, 0.05);
/// The share of the standard error that may be left after the first step of such a stage, for it to be the last one: it adds half a percent
/// to the uncertainty of the pose.
const AT_ONCE: f64 = 0.1;
/// Motions below this share of the standard error of the mean distance mean nothing either.
const NEGLIGIBLE: f64 = 0.02;
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

impl<const D: usize> Problem<'_, D> {
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
            problem: self,
            stage,
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
        let ended = (0..stage.max_iterations).find_map(|_| run.step(history).break_value());
        let status = ended.unwrap_or(Status::MaxIterations);
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
    problem: &'a Problem<'a, D>,
    stage: &'a Stage<'a, D>,
    view: View<D>,
    base: Vec<f64>,
    weighting: Weighting,
    /// Whether Newton's model foretold what the last step did.
    trusted: bool,
    damping: f64,
    last_motion: f64,
    /// Steps one after the other that made no difference, see [`CREEPING`].
    creeping: u32,
    /// The same for [`IDLE`].
    idle: u32,
    /// Where whole steps were tried.
    settled_cost: f64,
    evaluations: usize,
    anderson: Option<Anderson<D>>,
}

/// A step that was tried.
struct Trial<const D: usize> {
    view: View<D>,
    cost: f64,
    step: DVector<f64>,
    motion: f64,
    factor: f64,
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

    /// One step; breaks with the status and whether a step was made.
    fn step(&mut self, history: &mut History) -> ControlFlow<Status> {
        self.refresh_weights();
        let models = self.problem.models(self.stage, &self.view, &self.base, &self.weighting);
        if models.system.count < fewest(D) {
            return ControlFlow::Break(Status::NoOverlap);
        }
        if !models.system.cost.is_finite() {
            return ControlFlow::Break(Status::Diverged);
        }
        if let Some(status) = self.last_step(&models, history) {
            return ControlFlow::Break(status);
        }
        if self.damping > 0.0
            && self.may_settle(&models)
            && let Some(status) = self.settle(models.system.cost, history)
        {
            return ControlFlow::Break(status);
        }
        let evaluations = self.evaluations;
        let newton = self.newton_is_next(&models);
        let mut name = self.stage.method.name();
        if self.stage.method == Method::Adaptive {
            name = if newton { "newton" } else { self.stage.method.term().name() };
        }
        let mut trial = if self.anderson.is_some() {
            self.accelerated(&models)
        } else {
            self.search(&models, if newton { models.newton.as_ref().map(|n| &n.1) } else { None })
        };
        if trial.is_none() && newton && self.stage.method == Method::Adaptive {
            self.damping = 0.0;
            name = self.stage.method.term().name();
            trial = self.search(&models, None);
        }
        let Some(trial) = trial else {
            if self.may_settle(&models)
                && let Some(status) = self.settle(models.system.cost, history)
            {
                return ControlFlow::Break(status);
            }
            // Nothing lowers the cost: at a minimum its slope is rounding only.
            let spectrum = models.newton.as_ref().map_or(&models.linear, |n| &n.1);
            let step = models.scaled.step(spectrum, 0.0);
            let (rms, points) = self.view.rms(&self.base, &self.weighting);
            let negligible = NEGLIGIBLE * self.standard_error(rms, points);
            let small = self.motion(&models, &step) <= ROUNDING.max(self.tolerance()).max(negligible);
            return ControlFlow::Break(if small { Status::Converged } else { Status::Stalled });
        };
        self.judge_newton(&models, &trial);
        let ratio = if self.last_motion.is_finite() { trial.motion / self.last_motion } else { 1.0 };
        self.last_motion = trial.motion;
        self.view = trial.view;
        let (rms, points) = self.view.rms(&self.base, &self.weighting);
        let angle = models.freedom.velocity(&trial.step).angle();
        let record = StepRecord {
            angle,
            factor: trial.factor,
            damping: self.damping,
            ..self.record(name, trial.motion, (rms, points), evaluations)
        };
        history.push(record);
        if !self.view.pose.is_finite() || !trial.cost.is_finite() {
            return ControlFlow::Break(Status::Diverged);
        }
        if (self.problem.progress)(&record).is_break() {
            return ControlFlow::Break(Status::Cancelled);
        }
        // What is left, if the motions go on shrinking at this rate. A damped step says nothing about that.
        let left = if ratio < 1.0 { trial.motion * ratio / (1.0 - ratio) } else { trial.motion };
        let full = self.damping == 0.0 && trial.factor == 1.0;
        let ends = if full {
            let meaningless =
                if self.stage.is_long { MEANINGLESS * self.standard_error(rms, points) } else { 0.0 };
            let enough = self.tolerance().max(meaningless);
            left <= enough || trial.motion <= enough
        } else {
            // Where the cost has steps, as that of points which change their neighbours, a full step may raise it a little. That
            // does not matter where the whole of it would have been too short to make.
            let whole = models.scaled.step(&models.linear, 0.0);
            let gain = -models.vector.dot(&whole);
            let variance = models.system.cost / points.max(1) as f64;
            let is_idle = self.stage.method == Method::Adaptive && gain <= INSIGNIFICANT * variance;
            self.motion(&models, &whole) <= self.tolerance() || is_idle
        };
        if ends {
            return ControlFlow::Break(Status::Converged);
        }
        let (gain, shrinking, most) = CREEPING;
        let creeps = models.system.cost - trial.cost < gain * models.system.cost && ratio > shrinking;
        self.creeping = if creeps { self.creeping + 1 } else { 0 };
        let (short, no_gain, enough) = IDLE;
        // A stage that only has to come near ends where nothing is gained at the scale of its tolerance.
        let short = short.max(self.stage.tolerance).max(NEGLIGIBLE * self.standard_error(rms, points));
        let idles = trial.motion < short && models.system.cost - trial.cost < no_gain * models.system.cost;
        self.idle = if idles { self.idle + 1 } else { 0 };
        // A method that is asked for by name goes on, as slowly as it does.
        if self.stage.method == Method::Adaptive && (self.creeping >= most || self.idle >= enough) {
            return ControlFlow::Break(Status::Converged);
        }
        ControlFlow::Continue(())
    }

    /// Ends a long stage with a step that is too short for feet or distances to change by it.
    fn last_step(&mut self, models: &Models<D>, history: &mut History) -> Option<Status> {
        if !self.stage.is_long || self.stage.method != Method::Adaptive || self.damping > 0.0 {
            return None;
        }
        let newton = models.newton.as_ref().filter(|_| self.newton_is_next(models));
        let step = models.scaled.step(newton.map_or(&models.linear, |n| &n.1), 0.0);
        let motion = self.motion(models, &step);
        let (rms, points) = self.view.rms(&self.base, &self.weighting);
        let error = self.standard_error(rms, points);
        let is_short = motion <= LAST.0 * error && motion <= LAST.1 * self.last_motion;
        // What coarse points led to is off by their standard error, which a step nearly takes away.
        let is_enough =
            || self.last_motion.is_infinite() && motion * shrinking(history, motion) <= AT_ONCE * error;
        if !is_short && !is_enough() {
            return None;
        }
        let pose = self.problem.chart.advance(&self.view.pose, &models.freedom, &step);
        if is_short {
            self.view.pose = pose;
        } else {
            self.view.slide(self.stage.cloud, pose);
        }
        let (rms, points) = self.view.rms(&self.base, &self.weighting);
        let name = if newton.is_some() { "newton" } else { self.stage.method.term().name() };
        let angle = models.freedom.velocity(&step).angle();
        let record = StepRecord { angle, ..self.record(name, motion, (rms, points), self.evaluations) };
        history.push(record);
        let is_cancelled = (self.problem.progress)(&record).is_break();
        Some(if is_cancelled { Status::Cancelled } else { Status::Converged })
    }

    /// What is told of a whole step to the view, which fits so well, since some number of evaluations.
    fn record(
        &self,
        name: &'static str,
        motion: f64,
        (rms, points): (f64, usize),
        evaluations: usize,
    ) -> StepRecord {
        let unit = self.view.unit();
        StepRecord {
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

    /// The standard error of a mean distance as a share of the size of the cloud: about what the noise lets a pose mean.
    fn standard_error(&self, rms: f64, points: usize) -> f64 {
        rms / (self.view.size(self.stage.cloud) * (points.max(1) as f64).sqrt())
    }

    /// The tolerance, or what rounding of the coordinates leaves of it.
    fn tolerance(&self) -> f64 {
        let size = self.stage.cloud.diagonal * self.view.pose.scale;
        let far = self.view.pose.target_origin.norm() / size;
        self.stage.tolerance.max(16.0 * f64::EPSILON * (1.0 + far))
    }

    /// How far the points move (root mean square, nearly) as a share of the size of the cloud.
    fn motion(&self, models: &Models<D>, step: &DVector<f64>) -> f64 {
        let velocity = models.freedom.velocity(step);
        let size = self.stage.cloud.diagonal * self.view.pose.scale;
        let turn = (velocity.rotation.norm_squared() + velocity.growth * velocity.growth) * 0.1;
        (velocity.translation.norm_squared() / (size * size) + turn).sqrt()
    }

    fn newton_is_next(&self, models: &Models<D>) -> bool {
        let Some((_, spectrum)) = &models.newton else { return false };
        match self.stage.method {
            Method::Newton => true,
            Method::Adaptive => self.trusted && spectrum.smallest() > 1e-9 * spectrum.largest(),
            _ => false,
        }
    }

    /// Whether Newton's model foretold the change of the cost, whatever step was taken.
    fn judge_newton(&mut self, models: &Models<D>, trial: &Trial<D>) {
        let Some((matrix, _)) = &models.newton else { return };
        if self.stage.method != Method::Adaptive || trial.motion < ROUNDING {
            return;
        }
        let foretold = models.vector.dot(&trial.step) + 0.5 * trial.step.dot(&(matrix * &trial.step));
        let change = 0.5 * (trial.cost - models.system.cost);
        self.trusted = (change - foretold).abs() <= TRUST * change.abs();
    }
}
