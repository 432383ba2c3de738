//! When a stage has converged: nothing moves, or what moves makes no difference.

use super::problem::Moved;
use super::shrinking::shrinking;
use super::{Models, NEGLIGIBLE, ROUNDING, Run};
use crate::Method;
use nalgebra::DVector;

/// How well Newton's model has to predict the change of the cost to be taken for the next step.
const LARGEST_MODEL_ERROR: f64 = 0.3;
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

impl<const D: usize> Run<'_, D> {
    /// Whether what is left after a full step is below the tolerance, if the motions go on shrinking at this rate. A damped step says
    /// nothing about that.
    pub(super) fn is_at_rest(&self, motion: f64, ratio: f64, (rms, points): (f64, usize)) -> bool {
        let left = if ratio < 1.0 { motion * ratio / (1.0 - ratio) } else { motion };
        let meaningless =
            if self.stage.is_long { MEANINGLESS * self.standard_error(rms, points) } else { 0.0 };
        let enough = self.tolerance().max(meaningless);
        left <= enough || motion <= enough
    }

    /// Whether the whole of a damped step would have been too short to make.
    ///
    /// Where the cost has steps, as that of points which change their neighbours, a full step may raise it a little.
    pub(super) fn is_insignificant(&self, models: &Models<D>, points: usize) -> bool {
        let whole = models.scaled.step(&models.linear, 0.0);
        let gain = -models.vector.dot(&whole);
        let variance = models.system.cost / points.max(1) as f64;
        let is_idle = self.stage.method == Method::Adaptive && gain <= INSIGNIFICANT * variance;
        self.motion(models, &whole) <= self.tolerance() || is_idle
    }

    /// Whether the cost has hardly changed in several steps one after the other, see [`CREEPING`] and [`IDLE`]. A method that is asked
    /// for by name goes on, as slowly as it does.
    pub(super) fn makes_no_difference(
        &mut self,
        before: f64,
        after: f64,
        ratio: f64,
        (rms, points): (f64, usize),
    ) -> bool {
        let (gain, shrinking, most) = CREEPING;
        let creeps = before - after < gain * before && ratio > shrinking;
        self.creeping = if creeps { self.creeping + 1 } else { 0 };
        let (short, no_gain, enough) = IDLE;
        // A stage that only has to come near ends where nothing is gained at the scale of its tolerance.
        let short = short.max(self.stage.tolerance).max(NEGLIGIBLE * self.standard_error(rms, points));
        let idles = self.last_motion < short && before - after < no_gain * before;
        self.idle = if idles { self.idle + 1 } else { 0 };
        self.stage.method == Method::Adaptive && (self.creeping >= most || self.idle >= enough)
    }

    /// Whether a step of a long stage is so short that neither feet nor distances change by it.
    pub(super) fn is_last(&self, motion: f64, (rms, points): (f64, usize)) -> bool {
        motion <= LAST.0 * self.standard_error(rms, points) && motion <= LAST.1 * self.last_motion
    }

    /// Whether the first step of a long stage is enough: what coarse points led to is off by their standard error, which a step nearly
    /// takes away.
    pub(super) fn is_enough(&self, motion: f64, (rms, points): (f64, usize)) -> bool {
        self.last_motion.is_infinite()
            && motion * shrinking(self.history, motion) <= AT_ONCE * self.standard_error(rms, points)
    }

    /// The standard error of a mean distance as a share of the size of the cloud: about what the noise lets a pose mean.
    pub(super) fn standard_error(&self, rms: f64, points: usize) -> f64 {
        rms / (self.view.size(self.stage.cloud) * (points.max(1) as f64).sqrt())
    }

    /// The tolerance, or what rounding of the coordinates leaves of it.
    pub(super) fn tolerance(&self) -> f64 {
        let size = self.stage.cloud.diagonal * self.view.pose.scale;
        let far = self.view.pose.target_origin.norm() / size;
        self.stage.tolerance.max(16.0 * f64::EPSILON * (1.0 + far))
    }

    /// How far the points move (root mean square, nearly) as a share of the size of the cloud.
    pub(super) fn motion(&self, models: &Models<D>, step: &DVector<f64>) -> f64 {
        let velocity = models.freedom.velocity(step);
        let size = self.stage.cloud.diagonal * self.view.pose.scale;
        let turn = (velocity.rotation.norm_squared() + velocity.growth * velocity.growth) * 0.1;
        (velocity.translation.norm_squared() / (size * size) + turn).sqrt()
    }

    /// Notes whether Newton's model predicted the change of the cost, whatever step was taken.
    pub(super) fn compare_newton(&mut self, models: &Models<D>, trial: &Moved<D>) {
        let Some((matrix, _)) = &models.newton else { return };
        if self.stage.method != Method::Adaptive || trial.motion < ROUNDING {
            return;
        }
        let predicted = models.vector.dot(&trial.step) + 0.5 * trial.step.dot(&(matrix * &trial.step));
        let change = 0.5 * (trial.cost - models.system.cost);
        self.trusted = (change - predicted).abs() <= LARGEST_MODEL_ERROR * change.abs();
    }
}
