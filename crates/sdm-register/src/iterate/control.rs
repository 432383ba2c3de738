//! The control of a step: how far it goes, so that the cost falls.

use super::{Models, ROUNDING, Run, Trial};
use crate::solve::Spectrum;
use crate::view::{NEAR, View};
use crate::weights::Weighting;
use crate::{FootpointPolicy, Method, Pose, StepControl};
use distance_field::Search;
use nalgebra::DVector;

/// First damping, as a share of the largest eigenvalue, and the last.
const DAMPING: [f64; 2] = [1e-3, 1e8];
/// Largest growth of a step: the models of the distances know little of shapes of another size.
const GROWTH: f64 = 0.5;

impl<const D: usize> Run<'_, D> {
    pub(super) fn attempt(&mut self, models: &Models<D>, mut step: DVector<f64>, factor: f64) -> Trial<D> {
        let growth = models.freedom.velocity(&step).growth.abs();
        if growth > GROWTH {
            step *= GROWTH / growth;
        }
        let pose = self.problem.chart.advance(&self.view.pose, &models.freedom, &step);
        self.attempt_pose(models, pose, step, factor)
    }

    fn attempt_pose(
        &mut self,
        models: &Models<D>,
        pose: Pose<D>,
        step: DVector<f64>,
        factor: f64,
    ) -> Trial<D> {
        let motion = self.motion(models, &step);
        let search = match self.problem.options.footpoints {
            FootpointPolicy::Full => Search::Global,
            FootpointPolicy::WarmStart => Search::Local,
            FootpointPolicy::OneStep => Search::OneStep,
            FootpointPolicy::Adaptive if motion > NEAR => Search::Global,
            FootpointPolicy::Adaptive => Search::Local,
        };
        let (field, cloud) = (self.problem.field, self.stage.cloud);
        let view = match self.weighting {
            // Which points are rejected does not change, and beyond the limit all count the same.
            Weighting::Cut { limit } if self.stage.holds_rejection => {
                self.view
                    .moved(field, cloud, pose, search, &|i, distance| self.base[i] == 0.0 || distance > limit)
            }
            _ => View::new(field, cloud, pose, search, Some(&self.view), self.problem.options.scale),
        };
        self.evaluations += 1;
        let cost = view.cost(&self.base, &self.weighting);
        Trial { view, cost, step, motion, factor }
    }

    /// The accelerated step, or the plain one if that raises the cost.
    pub(super) fn accelerated(&mut self, models: &Models<D>) -> Option<Trial<D>> {
        let step = models.scaled.step(&models.linear, 0.0);
        let plain = self.problem.chart.advance(&self.view.pose, &models.freedom, &step);
        let pose = self.anderson.as_mut().map_or(plain, |a| a.accelerated(&self.view.pose, &plain));
        let trial = self.attempt_pose(models, pose, step, 1.0);
        if trial.cost <= models.system.cost || trial.motion < ROUNDING {
            return Some(trial);
        }
        if let Some(anderson) = &mut self.anderson {
            anderson.reset();
        }
        Some(self.attempt_pose(models, plain, trial.step, 1.0))
    }

    /// The step of Newton's spectrum, or of the linear one, under control; `None` if no step lowers the cost.
    pub(super) fn search(&mut self, models: &Models<D>, newton: Option<&Spectrum>) -> Option<Trial<D>> {
        let spectrum = newton.unwrap_or(&models.linear);
        let largest = spectrum.largest();
        // Away from a minimum the matrix of Newton's method may be indefinite: lift it.
        let lift = (1e-6 * largest - spectrum.smallest()).max(0.0);
        let lift = if newton.is_some() { lift } else { 0.0 };
        let slack = 1e-12 * models.system.cost;
        match self.problem.options.control {
            StepControl::None => {
                let step = models.scaled.step(spectrum, 0.0);
                Some(self.attempt(models, step, 1.0))
            }
            StepControl::Armijo => {
                let full = models.scaled.step(spectrum, lift);
                let slope = models.vector.dot(&full);
                let mut factor = 1.0;
                while factor > 1e-10 {
                    let trial = self.attempt(models, &full * factor, factor);
                    let promised = models.system.cost + 2.0 * 1e-4 * factor * slope;
                    if trial.cost <= promised + slack || trial.motion < ROUNDING {
                        return Some(trial);
                    }
                    factor *= 0.5;
                }
                None
            }
            StepControl::LevenbergMarquardt => {
                loop {
                    let step = models.scaled.step(spectrum, lift + self.damping * largest);
                    let trial = self.attempt(models, step, 1.0);
                    let fell = trial.cost <= models.system.cost + slack;
                    if fell || trial.motion < ROUNDING && trial.cost.is_finite() {
                        // The record shows the damping of this step; the next one starts with less.
                        self.damping = if self.damping > DAMPING[0] { self.damping * 0.1 } else { 0.0 };
                        return Some(trial);
                    }
                    // Where not even the whole step would be worth making, no shorter one is looked for.
                    let is_short = self.damping == 0.0 && trial.motion <= self.tolerance();
                    self.damping = (self.damping * 10.0).max(DAMPING[0]);
                    if is_short
                        || self.damping > DAMPING[1]
                        || newton.is_some() && self.stage.method == Method::Adaptive
                    {
                        return None;
                    }
                }
            }
        }
    }
}
