//! The end of an iteration on a cost with steps.
//!
//! Points that change their neighbours on a cloud, or cross a kink, make the cost jump. Steps that have to lower it then become
//! shorter and shorter far from where its slope vanishes. Whole steps, whatever they do to the cost, go on to where the models of the
//! distances balance each other, as those of the usual iteration from a cloud to tangent planes do.

use super::{Models, NEGLIGIBLE, Run};
use crate::report::RegisterStep;
use crate::{Method, Status, StepControl};

/// Most whole steps, and the share of the cost of one attempt from which another one is made.
const WHOLE: usize = 30;
const AGAIN: f64 = 0.98;
/// By what share of the cost whole steps may raise it, and the most that the first one may promise: the place is the same but for
/// what the steps of the cost make of it.
const PROMISE: f64 = 0.05;
const RISE: f64 = 0.1;
/// Length of a step, in lengths of the first one, at which they lead elsewhere.
const AWAY: f64 = 4.0;

impl<const D: usize> Run<'_, D> {
    /// Whether whole steps may be tried: not again from about the same place, and only where not much is to be gained.
    pub(super) fn may_settle(&self, models: &Models<D>) -> bool {
        let is_ours = self.job.options.method == Method::Adaptive
            && self.job.options.control == StepControl::LevenbergMarquardt;
        let cost = models.system.cost;
        let whole = models.scaled.step(&models.linear, 0.0);
        is_ours && cost < AGAIN * self.settled_cost && -models.vector.dot(&whole) <= PROMISE * cost
    }

    /// Whole steps to where they vanish; `None`, and everything as before, if they lead elsewhere, or to a higher cost.
    pub(super) fn settle(&mut self, cost: f64) -> Option<Status> {
        self.settled_cost = cost;
        let before = (self.view.clone(), self.base.clone(), self.weighting, self.history.len());
        let status = self.whole_steps();
        if status.is_none() {
            self.history.truncate(before.3);
            (self.view, self.base, self.weighting) = (before.0, before.1, before.2);
        }
        status
    }

    fn whole_steps(&mut self) -> Option<Status> {
        let (mut first, mut limit) = (f64::INFINITY, f64::INFINITY);
        for whole in 0..WHOLE {
            let evaluations = self.evaluations;
            let models = self.job.models(self.stage, &self.view, &self.base, &self.weighting);
            limit = limit.min(models.system.cost * (1.0 + RISE));
            let step = models.scaled.step(&models.linear, 0.0);
            let trial = self.attempt(&models, step);
            if whole == 0 {
                first = trial.motion;
            }
            if !(trial.cost <= limit && trial.motion <= AWAY * first && trial.view.pose.is_finite()) {
                return None;
            }
            self.view = trial.view;
            self.last_motion = trial.motion;
            let (rms, points) = self.view.rms(&self.base, &self.weighting);
            let angle = models.freedom.velocity(&trial.step).angle();
            let record =
                RegisterStep { angle, ..self.record("whole", trial.motion, (rms, points), evaluations) };
            self.history.push(record);
            if (self.job.progress)(&record).is_break() {
                return Some(Status::Cancelled);
            }
            let enough = self.tolerance().max(NEGLIGIBLE * self.standard_error(rms, points));
            if trial.motion <= enough {
                return Some(Status::Converged);
            }
            self.refresh_weights();
        }
        None
    }
}
