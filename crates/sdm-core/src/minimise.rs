//! The loop: linearise, find a step that lowers the cost, take it, again.

use crate::{Controller, Status, StepTaken};

/// A nonlinear least squares problem with its present state, as the loop sees it.
pub trait Problem {
    /// The problem linearised at the present state: normal equations of the quadratic models.
    type Linear;
    /// A step in the unknowns.
    type Step;
    /// The state that a step leads to.
    type Trial: Trial;
    /// Why an iteration can fail.
    type Error;

    /// Linearises at the present state.
    ///
    /// # Errors
    /// [`Stop`]: the iteration ends here, or fails.
    fn linearise(&mut self) -> Result<Self::Linear, Stop<Self::Error>>;

    /// What is minimised, at the present state.
    fn cost(&self, linear: &Self::Linear) -> f64;

    /// The step of the linearised problem under a damping, which is a share of a scale that the problem chooses, as the largest
    /// eigenvalue or the mean of the diagonal.
    ///
    /// # Errors
    /// [`Stop`]: the iteration ends here, or fails.
    fn direction(
        &mut self,
        linear: &Self::Linear,
        damping: f64,
    ) -> Result<StepDirection<Self::Step>, Stop<Self::Error>>;

    /// The state after `factor` times a step; `None` if it is none that the shape can take.
    ///
    /// # Errors
    /// [`Stop`]: the iteration ends here, or fails.
    fn advance(
        &mut self,
        linear: &Self::Linear,
        step: &Self::Step,
        factor: f64,
    ) -> Result<Option<Self::Trial>, Stop<Self::Error>>;

    /// A state that is taken without control of the step, as an extrapolation of earlier ones; by default none.
    ///
    /// # Errors
    /// [`Stop`]: the iteration ends here, or fails.
    fn extrapolate(&mut self, _linear: &Self::Linear) -> Result<Option<Self::Trial>, Stop<Self::Error>> {
        Ok(None)
    }

    /// Whether a step that did not lower the cost is the last one tried; by default not.
    fn gives_up(&self, _linear: &Self::Linear, _trial: &Self::Trial, _damping: f64) -> bool {
        false
    }

    /// Makes a trial the present state, and records it.
    ///
    /// # Errors
    /// [`Stop::Ended`] if this was the last iteration.
    fn accept(
        &mut self,
        linear: Self::Linear,
        trial: Self::Trial,
        taken: StepTaken,
    ) -> Result<(), Stop<Self::Error>>;

    /// No step lowers the cost. Returns another linearisation to search from, or `None` for the next iteration if the problem has
    /// changed something; by default the iteration ends as stalled.
    ///
    /// # Errors
    /// [`Stop::Ended`] if this was the last iteration.
    fn exhausted(
        &mut self,
        _linear: Self::Linear,
        _last: Exhausted<Self::Step>,
    ) -> Result<Option<Self::Linear>, Stop<Self::Error>> {
        Err(Stop::Ended(Status::Stalled))
    }
}

/// A state that a step leads to.
pub trait Trial {
    /// What is minimised, at this state.
    fn cost(&self) -> f64;

    /// Whether the step is so short that the change of the cost is rounding, so that nothing is concluded from it; by default not.
    fn is_rounding(&self) -> bool {
        false
    }
}

/// The step of a linearised problem.
#[derive(Clone, Debug)]
pub enum StepDirection<S> {
    /// The step, and the derivative of the cost along the whole of it (negative where the cost falls).
    Along {
        /// In the unknowns.
        step: S,
        /// Derivative of the cost by the factor of the step, at 0.
        slope: f64,
    },
    /// The matrix is not positive definite under this damping; more of it may help.
    Singular,
}

impl<S> StepDirection<S> {
    /// A step with the derivative of the cost along it.
    pub fn along(step: S, slope: f64) -> Self {
        Self::Along { step, slope }
    }
}

/// What was tried last where no step lowers the cost.
#[derive(Clone, Debug)]
pub struct Exhausted<S> {
    /// The last step, undivided; `None` if the matrix was never positive definite.
    pub step: Option<S>,
    /// Derivative of the cost along it.
    pub slope: f64,
}

/// Why an iteration does not go on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Stop<E> {
    /// It has ended.
    Ended(Status),
    /// It has failed.
    Failed(E),
}

impl<E> From<E> for Stop<E> {
    fn from(error: E) -> Self {
        Self::Failed(error)
    }
}

/// Iterates until the problem ends, or [`Status::MaxIterations`].
///
/// # Errors
/// Those of the problem.
pub fn minimise<P: Problem>(
    problem: &mut P,
    control: &mut Controller,
    max_iterations: usize,
) -> Result<Status, P::Error> {
    for _ in 0..max_iterations {
        match iterate(problem, control) {
            Ok(()) => {}
            Err(Stop::Ended(status)) => return Ok(status),
            Err(Stop::Failed(error)) => return Err(error),
        }
    }
    Ok(Status::MaxIterations)
}

fn iterate<P: Problem>(problem: &mut P, control: &mut Controller) -> Result<(), Stop<P::Error>> {
    let mut linear = problem.linearise()?;
    if let Some(trial) = problem.extrapolate(&linear)? {
        return problem.accept(linear, trial, StepTaken::FULL);
    }
    loop {
        match control.search(problem, &linear)? {
            Ok((trial, taken)) => return problem.accept(linear, trial, taken),
            Err(last) => match problem.exhausted(linear, last)? {
                Some(other) => linear = other,
                None => return Ok(()),
            },
        }
        control.reset();
    }
}
