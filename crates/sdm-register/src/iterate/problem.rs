//! A stage of a registration as a problem of the common loop.

use super::{Models, NEGLIGIBLE, ROUNDING, Run};
use crate::report::RegisterStep;
use crate::view::{View, WARM_START_MOTION};
use crate::weights::Weighting;
use crate::{Method, Pose};
use nalgebra::DVector;
use sdm_core::{Exhausted, Problem, Status, StepControl, StepDirection, StepTaken, Stop, Trial};
use std::convert::Infallible;

/// Largest growth of a step: the models of the distances know little of shapes of another size.
const LARGEST_GROWTH: f64 = 0.5;
/// Least eigenvalue of Newton's matrix as a share of its largest: away from a minimum it may be indefinite, and is lifted to this.
const LEAST_EIGENVALUE: f64 = 1e-6;

/// The models of one iteration, and which of them the step is taken from.
pub(super) struct Linear<const D: usize> {
    pub(super) models: Models<D>,
    /// Newton's model, or that of the error term.
    newton: bool,
    /// Evaluations before this iteration.
    evaluations: usize,
}

/// The cloud in a pose that a step leads to.
pub(super) struct Moved<const D: usize> {
    pub(super) view: View<D>,
    pub(super) cost: f64,
    pub(super) step: DVector<f64>,
    pub(super) motion: f64,
}

impl<const D: usize> Trial for Moved<D> {
    fn cost(&self) -> f64 {
        self.cost
    }

    fn is_rounding(&self) -> bool {
        self.motion < ROUNDING && self.cost.is_finite()
    }
}

impl<const D: usize> Problem for Run<'_, D> {
    type Linear = Linear<D>;
    type Step = DVector<f64>;
    type Trial = Moved<D>;
    type Error = Infallible;

    fn linearise(&mut self) -> Result<Linear<D>, Stop<Infallible>> {
        self.refresh_weights();
        let models = self.job.models(self.stage, &self.view, &self.base, &self.weighting);
        if models.system.count < super::fewest(D) {
            return Err(Stop::Ended(Status::NoOverlap));
        }
        if !models.system.cost.is_finite() {
            return Err(Stop::Ended(Status::Diverged));
        }
        if let Some(status) = self.last_step(&models) {
            return Err(Stop::Ended(status));
        }
        if self.damping > 0.0
            && self.may_settle(&models)
            && let Some(status) = self.settle(models.system.cost)
        {
            return Err(Stop::Ended(status));
        }
        let newton = self.newton_is_next(&models);
        Ok(Linear { models, newton, evaluations: self.evaluations })
    }

    fn cost(&self, linear: &Linear<D>) -> f64 {
        linear.models.system.cost
    }

    fn direction(
        &mut self,
        linear: &Linear<D>,
        damping: f64,
    ) -> Result<StepDirection<DVector<f64>>, Stop<Infallible>> {
        let models = &linear.models;
        let newton = models.newton.as_ref().filter(|_| linear.newton);
        let spectrum = newton.map_or(&models.linear, |newton| &newton.1);
        let largest = spectrum.largest();
        let is_lifted = newton.is_some() && self.job.options.control != StepControl::None;
        let lift = if is_lifted { (LEAST_EIGENVALUE * largest - spectrum.smallest()).max(0.0) } else { 0.0 };
        let step = models.scaled.step(spectrum, lift + damping * largest);
        let slope = 2.0 * models.vector.dot(&step);
        Ok(StepDirection::along(step, slope))
    }

    fn advance(
        &mut self,
        linear: &Linear<D>,
        step: &DVector<f64>,
        factor: f64,
    ) -> Result<Option<Moved<D>>, Stop<Infallible>> {
        Ok(Some(self.attempt(&linear.models, step * factor)))
    }

    fn extrapolate(&mut self, linear: &Linear<D>) -> Result<Option<Moved<D>>, Stop<Infallible>> {
        Ok(if self.anderson.is_some() { Some(self.accelerated(&linear.models)) } else { None })
    }

    /// Where not even the whole step would be worth making, no shorter one is looked for; nor a damped one of Newton's model where
    /// that of the error term is at hand.
    fn gives_up(&self, linear: &Linear<D>, trial: &Moved<D>, damping: f64) -> bool {
        let is_short = damping == 0.0 && trial.motion <= self.tolerance();
        is_short || linear.newton && self.stage.method == Method::Adaptive
    }

    fn accept(
        &mut self,
        linear: Linear<D>,
        trial: Moved<D>,
        taken: StepTaken,
    ) -> Result<(), Stop<Infallible>> {
        let models = &linear.models;
        self.damping = taken.damping;
        self.compare_newton(models, &trial);
        let ratio = if self.last_motion.is_finite() { trial.motion / self.last_motion } else { 1.0 };
        self.last_motion = trial.motion;
        self.view = trial.view;
        let (rms, points) = self.view.rms(&self.base, &self.weighting);
        let record = RegisterStep {
            angle: models.freedom.velocity(&trial.step).angle(),
            factor: taken.factor,
            damping: taken.damping,
            ..self.record(self.name(linear.newton), trial.motion, (rms, points), linear.evaluations)
        };
        self.history.push(record);
        if !self.view.pose.is_finite() || !trial.cost.is_finite() {
            return Err(Stop::Ended(Status::Diverged));
        }
        if (self.job.progress)(&record).is_break() {
            return Err(Stop::Ended(Status::Cancelled));
        }
        let ends = if taken.is_full() {
            self.is_at_rest(trial.motion, ratio, (rms, points))
        } else {
            self.is_insignificant(models, points)
        };
        if ends || self.makes_no_difference(models.system.cost, trial.cost, ratio, (rms, points)) {
            return Err(Stop::Ended(Status::Converged));
        }
        Ok(())
    }

    fn exhausted(
        &mut self,
        linear: Linear<D>,
        _: Exhausted<DVector<f64>>,
    ) -> Result<Option<Linear<D>>, Stop<Infallible>> {
        if linear.newton && self.stage.method == Method::Adaptive {
            self.damping = 0.0;
            return Ok(Some(Linear { newton: false, ..linear }));
        }
        let models = &linear.models;
        if self.may_settle(models)
            && let Some(status) = self.settle(models.system.cost)
        {
            return Err(Stop::Ended(status));
        }
        // Nothing lowers the cost: at a minimum its slope is rounding only.
        let spectrum = models.newton.as_ref().map_or(&models.linear, |n| &n.1);
        let step = models.scaled.step(spectrum, 0.0);
        let (rms, points) = self.view.rms(&self.base, &self.weighting);
        let negligible = NEGLIGIBLE * self.standard_error(rms, points);
        let small = self.motion(models, &step) <= ROUNDING.max(self.tolerance()).max(negligible);
        Err(Stop::Ended(if small { Status::Converged } else { Status::Stalled }))
    }
}

impl<const D: usize> Run<'_, D> {
    /// The cloud after a step.
    pub(super) fn attempt(&mut self, models: &Models<D>, mut step: DVector<f64>) -> Moved<D> {
        let growth = models.freedom.velocity(&step).growth.abs();
        if growth > LARGEST_GROWTH {
            step *= LARGEST_GROWTH / growth;
        }
        let pose = self.job.chart.advance(&self.view.pose, &models.freedom, &step);
        self.attempt_pose(models, pose, step)
    }

    fn attempt_pose(&mut self, models: &Models<D>, pose: Pose<D>, step: DVector<f64>) -> Moved<D> {
        let motion = self.motion(models, &step);
        let search = self.job.options.footpoints.search(motion <= WARM_START_MOTION);
        let (field, cloud) = (self.job.field, self.stage.cloud);
        let view = match self.weighting {
            // Which points are rejected does not change, and beyond the limit all count the same.
            Weighting::Cut { limit } if self.stage.holds_rejection => {
                self.view
                    .moved(field, cloud, pose, search, &|i, distance| self.base[i] == 0.0 || distance > limit)
            }
            _ => View::new(field, cloud, pose, search, Some(&self.view), self.job.options.scale),
        };
        self.evaluations += 1;
        let cost = view.cost(&self.base, &self.weighting);
        Moved { view, cost, step, motion }
    }

    /// The accelerated step, or the plain one if that raises the cost.
    fn accelerated(&mut self, models: &Models<D>) -> Moved<D> {
        let step = models.scaled.step(&models.linear, 0.0);
        let plain = self.job.chart.advance(&self.view.pose, &models.freedom, &step);
        let pose = self.anderson.as_mut().map_or(plain, |a| a.accelerated(&self.view.pose, &plain));
        let trial = self.attempt_pose(models, pose, step);
        if trial.cost <= models.system.cost || trial.motion < ROUNDING {
            return trial;
        }
        if let Some(anderson) = &mut self.anderson {
            anderson.reset();
        }
        self.attempt_pose(models, plain, trial.step)
    }

    /// The name of a step in the history.
    pub(super) fn name(&self, newton: bool) -> &'static str {
        match self.stage.method {
            Method::Adaptive if newton => "newton",
            Method::Adaptive => self.stage.method.term().name(),
            method => method.name(),
        }
    }

    fn newton_is_next(&self, models: &Models<D>) -> bool {
        let Some((_, spectrum)) = &models.newton else { return false };
        match self.stage.method {
            Method::Newton => true,
            Method::Adaptive => self.trusted && spectrum.smallest() > 1e-9 * spectrum.largest(),
            _ => false,
        }
    }

    /// Ends a long stage with a step that is too short for feet or distances to change by it.
    fn last_step(&mut self, models: &Models<D>) -> Option<Status> {
        if !self.stage.is_long || self.stage.method != Method::Adaptive || self.damping > 0.0 {
            return None;
        }
        let newton = models.newton.as_ref().filter(|_| self.newton_is_next(models));
        let step = models.scaled.step(newton.map_or(&models.linear, |n| &n.1), 0.0);
        let motion = self.motion(models, &step);
        let (rms, points) = self.view.rms(&self.base, &self.weighting);
        let is_short = self.is_last(motion, (rms, points));
        if !is_short && !self.is_enough(motion, (rms, points)) {
            return None;
        }
        let pose = self.job.chart.advance(&self.view.pose, &models.freedom, &step);
        if is_short {
            self.view.pose = pose;
        } else {
            self.view.slide(self.stage.cloud, pose);
        }
        let (rms, points) = self.view.rms(&self.base, &self.weighting);
        let angle = models.freedom.velocity(&step).angle();
        let name = self.name(newton.is_some());
        let record = RegisterStep { angle, ..self.record(name, motion, (rms, points), self.evaluations) };
        self.history.push(record);
        let is_cancelled = (self.job.progress)(&record).is_break();
        Some(if is_cancelled { Status::Cancelled } else { Status::Converged })
    }
}
