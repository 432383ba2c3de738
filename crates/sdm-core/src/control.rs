//! Control of a step: how far it goes, so that the cost falls.

use crate::minimise::{Exhausted, Problem, StepDirection, Stop, Trial};

/// How the length of steps is controlled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum StepControl {
    /// Full steps, whatever they do.
    None,
    /// A step is halved until it lowers the cost by a share of what its slope promises (Armijo's rule).
    #[default]
    Armijo,
    /// Damping of the unknowns grows until the cost falls, and shrinks again (Levenberg and Marquardt; Tikhonov's regularisation of
    /// the step).
    LevenbergMarquardt,
}

/// The constants of the control of a step.
///
/// The damping of Levenberg and Marquardt changes by factors of 10 between `first` and `last`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepLimits {
    /// Armijo's constant `c₁`: the share of the decrease promised by the slope that a step has to bring. Default 1e-4.
    pub decrease: f64,
    /// Armijo's rule gives up where the factor of the step is not above this. Default 1e-6.
    pub shortest: f64,
    /// First damping. Default 1e-3.
    pub first: f64,
    /// Least damping, of full steps as well. Default 0.
    pub least: f64,
    /// Levenberg and Marquardt give up above this damping. Default 1e8.
    pub last: f64,
    /// Whether a damping of not more than `first` falls to `least` at once, where the iteration also begins; otherwise it begins with
    /// `first` and falls by a factor of 10 with each step. Default yes.
    pub drops: bool,
    /// Share of the cost that counts as rounding: so much higher may a state be. With 0 the cost has to fall. Default 1e-13.
    pub slack: f64,
}

impl Default for StepLimits {
    fn default() -> Self {
        Self { decrease: 1e-4, shortest: 1e-6, first: 1e-3, least: 0.0, last: 1e8, drops: true, slack: 1e-13 }
    }
}

/// How a step was taken.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct StepTaken {
    /// Factor of the step by Armijo's rule, otherwise 1.
    pub factor: f64,
    /// Damping beyond the least one with which the next step begins; 0 after a full step.
    pub damping: f64,
}

impl StepTaken {
    /// A full step.
    pub const FULL: Self = Self { factor: 1.0, damping: 0.0 };

    /// Whether the step was neither shortened nor more than slightly damped.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.factor == 1.0 && self.damping == 0.0
    }
}

/// The control of the steps of one iteration, with the damping that it has reached.
#[derive(Clone, Debug)]
pub struct Controller {
    control: StepControl,
    limits: StepLimits,
    damping: f64,
}

/// A trial with how it was reached, or what was tried last.
type Searched<P> = Result<(<P as Problem>::Trial, StepTaken), Exhausted<<P as Problem>::Step>>;

impl Controller {
    /// The control of an iteration that begins.
    #[must_use]
    pub fn new(control: StepControl, limits: StepLimits) -> Self {
        let damping = if limits.drops { 0.0 } else { limits.first };
        Self { control, limits, damping }
    }

    /// Forgets the damping that was reached.
    pub fn reset(&mut self) {
        self.damping = if self.limits.drops { 0.0 } else { self.limits.first };
    }

    /// A step from a linearised problem that lowers the cost.
    ///
    /// # Errors
    /// Those of the problem.
    pub(crate) fn search<P: Problem>(
        &mut self,
        problem: &mut P,
        linear: &P::Linear,
    ) -> Result<Searched<P>, Stop<P::Error>> {
        match self.control {
            StepControl::None => self.whole(problem, linear),
            StepControl::Armijo => self.shortened(problem, linear),
            StepControl::LevenbergMarquardt => self.damped(problem, linear),
        }
    }

    /// The full step, whatever it does.
    fn whole<P: Problem>(&self, problem: &mut P, linear: &P::Linear) -> Result<Searched<P>, Stop<P::Error>> {
        let StepDirection::Along { step, slope } = problem.direction(linear, self.limits.least)? else {
            return Ok(Err(Exhausted { step: None, slope: 0.0 }));
        };
        Ok(match problem.advance(linear, &step, 1.0)? {
            Some(trial) => Ok((trial, StepTaken::FULL)),
            None => Err(Exhausted { step: Some(step), slope }),
        })
    }

    /// Armijo's rule.
    fn shortened<P: Problem>(
        &self,
        problem: &mut P,
        linear: &P::Linear,
    ) -> Result<Searched<P>, Stop<P::Error>> {
        let StepDirection::Along { step, slope } = problem.direction(linear, self.limits.least)? else {
            return Ok(Err(Exhausted { step: None, slope: 0.0 }));
        };
        let cost = problem.cost(linear);
        let slack = self.limits.slack * cost;
        let mut factor = 1.0;
        while factor > self.limits.shortest {
            if let Some(trial) = problem.advance(linear, &step, factor)? {
                let promised = cost + self.limits.decrease * factor * slope;
                if trial.cost() <= promised + slack || trial.is_rounding() {
                    return Ok(Ok((trial, StepTaken { factor, damping: 0.0 })));
                }
            }
            factor *= 0.5;
        }
        Ok(Err(Exhausted { step: Some(step), slope }))
    }

    /// Levenberg and Marquardt.
    fn damped<P: Problem>(
        &mut self,
        problem: &mut P,
        linear: &P::Linear,
    ) -> Result<Searched<P>, Stop<P::Error>> {
        let cost = problem.cost(linear);
        let mut damping = self.damping.max(self.limits.least);
        let mut last = Exhausted { step: None, slope: 0.0 };
        while damping <= self.limits.last {
            if let StepDirection::Along { step, slope } = problem.direction(linear, damping)? {
                if let Some(trial) = problem.advance(linear, &step, 1.0)? {
                    if self.is_lower(trial.cost(), cost) || trial.is_rounding() {
                        self.damping = self.lowered(damping);
                        return Ok(Ok((trial, StepTaken { factor: 1.0, damping: self.damping })));
                    }
                    if problem.gives_up(linear, &trial, damping) {
                        return Ok(Err(Exhausted { step: Some(step), slope }));
                    }
                }
                last = Exhausted { step: Some(step), slope };
            }
            damping *= 10.0;
            if self.limits.drops {
                damping = damping.max(self.limits.first);
            }
        }
        Ok(Err(last))
    }

    fn is_lower(&self, trial: f64, cost: f64) -> bool {
        if self.limits.slack > 0.0 { trial <= cost + self.limits.slack * cost } else { trial < cost }
    }

    /// The damping after a step that lowered the cost.
    fn lowered(&self, damping: f64) -> f64 {
        let limits = &self.limits;
        if !limits.drops {
            (damping * 0.1).max(limits.least)
        } else if damping <= limits.first.max(limits.least) {
            0.0
        } else {
            damping * 0.1
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Status, minimise};
    use std::convert::Infallible;

    /// `½ log²(x / 2)` from the right: Newton's step in `x` for `r = log(x / 2)` is far too long where `x` is large.
    struct Logarithm {
        x: f64,
        taken: Vec<StepTaken>,
    }

    struct At(f64);

    impl Trial for At {
        fn cost(&self) -> f64 {
            if self.0 > 0.0 { (self.0 / 2.0).ln().powi(2) } else { f64::NAN }
        }
    }

    impl Problem for Logarithm {
        type Linear = [f64; 2];
        type Step = f64;
        type Trial = At;
        type Error = Infallible;

        fn linearise(&mut self) -> Result<[f64; 2], Stop<Infallible>> {
            Ok([1.0 / (self.x * self.x), (self.x / 2.0).ln() / self.x])
        }

        fn cost(&self, _: &[f64; 2]) -> f64 {
            At(self.x).cost()
        }

        fn direction(
            &mut self,
            linear: &[f64; 2],
            damping: f64,
        ) -> Result<StepDirection<f64>, Stop<Infallible>> {
            let step = -linear[1] / (linear[0] * (1.0 + damping));
            Ok(StepDirection::along(step, 2.0 * linear[1] * step))
        }

        fn advance(&mut self, _: &[f64; 2], step: &f64, factor: f64) -> Result<Option<At>, Stop<Infallible>> {
            Ok(Some(At(self.x + factor * step)))
        }

        fn accept(&mut self, _: [f64; 2], trial: At, taken: StepTaken) -> Result<(), Stop<Infallible>> {
            self.taken.push(taken);
            let still = (trial.0 - self.x).abs() < 1e-12;
            self.x = trial.0;
            if still { Err(Stop::Ended(Status::Converged)) } else { Ok(()) }
        }
    }

    fn run(control: StepControl, limits: StepLimits) -> (Status, Logarithm) {
        let mut problem = Logarithm { x: 100.0, taken: Vec::new() };
        let Ok(status) = minimise(&mut problem, &mut Controller::new(control, limits), 50);
        (status, problem)
    }

    #[test]
    fn controlled_steps_arrive_where_full_ones_do_not() {
        let (status, armijo) = run(StepControl::Armijo, StepLimits::default());
        assert_eq!(status, Status::Converged);
        assert!(
            (armijo.x - 2.0).abs() < 1e-12 && armijo.taken[0].factor < 1.0 && armijo.taken[0].damping == 0.0
        );
        for drops in [true, false] {
            let limits =
                StepLimits { drops, least: if drops { 0.0 } else { 1e-12 }, ..StepLimits::default() };
            let (status, damped) = run(StepControl::LevenbergMarquardt, limits);
            assert_eq!(status, Status::Converged);
            assert!((damped.x - 2.0).abs() < 1e-12, "{}", damped.x);
            assert!(damped.taken[0].damping > 0.1 && damped.taken[0].factor == 1.0);
            assert_eq!(damped.taken.last().map(StepTaken::is_full), Some(drops));
        }
        let (_, full) = run(StepControl::None, StepLimits::default());
        assert!(full.x.is_nan());
    }

    #[test]
    fn what_no_step_lowers_has_stalled() {
        // At the minimum itself nothing is strictly lower.
        let mut problem = Logarithm { x: 2.0, taken: Vec::new() };
        let limits = StepLimits { slack: 0.0, ..StepLimits::default() };
        let mut control = Controller::new(StepControl::LevenbergMarquardt, limits);
        assert_eq!(minimise(&mut problem, &mut control, 50), Ok(Status::Stalled));
        assert!(problem.taken.is_empty());
    }
}
