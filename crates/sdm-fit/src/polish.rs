//! The last digits of shapes on which the points lie exactly.

use crate::iterate::{Progress, fit_with_progress};
use crate::shape::ActiveShape;
use crate::{Constraints, Error, FitOptions, FitStep, Fitted, Smoothing, Status, Target};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

/// Root mean square distances as shares of the size up to which points may lie on the shape exactly: where neighbours are off alike, so that
/// it may be the energy that keeps the shape from them, and otherwise. That which is rounding.
const NEARLY: [f64; 2] = [1e-2, 1e-4];
/// Disagreement of the residuals of neighbours, 1 for noise, below which they are off alike.
const ALIKE: f64 = 0.3;
const ROUNDING: f64 = 1e-14;
/// Iterations at most, and those after which the distance must have fallen to this share.
const ITERATIONS: usize = 40;
const TRIED: usize = 8;
const FALLEN: f64 = 0.5;
/// Share of the distance before that the result must reach: a shape that is not exact only comes a little nearer without its energy, and
/// loses what that is for.
const EXACT: f64 = 0.05;
/// Damping of the steps: what no point holds stays where it is.
const DAMPING: f64 = 1e-9;
/// Largest share of the squared distances that the fairing is: it vanishes with them.
const CAP: f64 = 0.01;

/// Whether the smoothing that was asked for may vanish.
pub(crate) fn may_vanish(smoothing: Smoothing) -> bool {
    match smoothing {
        Smoothing::Fixed { lambda } => lambda == 0.0,
        Smoothing::Continuation { floor, .. } => floor == 0.0,
        Smoothing::Automatic { .. } => true,
    }
}

/// The share of the size up to which points may lie on a shape exactly, by how much the residuals of neighbours disagree.
pub(crate) fn nearly_exact(disagreement: f64) -> f64 {
    if disagreement < ALIKE { NEARLY[0] } else { NEARLY[1] }
}

/// Goes on from a fit without smoothing, and with fairing that vanishes, which draw a shape off the points, if hardly any distance is left; `None` where that
/// does not lead to a shape on which the points lie exactly. The history is that of both.
pub(crate) fn polished<const D: usize, S: ActiveShape<D>>(
    before: &Fitted<S, D>,
    target: Target<'_, D>,
    constraints: &Constraints<D>,
    options: &FitOptions,
    (size, nearly): (f64, f64),
    progress: Progress<'_>,
) -> Result<Option<Fitted<S, D>>, Error> {
    let first = before.report.rms;
    if !(ROUNDING * size..=nearly * size).contains(&first) || before.report.status == Status::Cancelled {
        return Ok(None);
    }
    let count = before.report.history.len();
    let is_cancelled = AtomicBool::new(false);
    let tell = |step: &FitStep| {
        if progress(&FitStep { iteration: count + step.iteration, ..*step }).is_break() {
            is_cancelled.store(true, Ordering::Relaxed);
            return ControlFlow::Break(());
        }
        if step.iteration >= TRIED && step.rms > FALLEN * first {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    let exact = options
        .with_smoothing(Smoothing::NONE)
        .with_fairing_cap(Some(CAP))
        .with_damping(DAMPING)
        .with_cost_tolerance(0.01)
        .with_tolerance(1e-14)
        .with_abs_goal(Some(ROUNDING * size))
        .with_max_iterations(ITERATIONS);
    let mut after = fit_with_progress(before.shape.clone(), target, constraints, &exact, &tell)?;
    if is_cancelled.into_inner() {
        let mut cancelled = before.clone();
        cancelled.report.status = Status::Cancelled;
        return Ok(Some(cancelled));
    }
    if after.report.rms.is_nan()
        || after.report.rms > EXACT * first
        || after.report.status == Status::Diverged
    {
        return Ok(None);
    }
    // A singular system, or no step that lowers it, means that nothing is left to be gained.
    after.report.status = Status::Converged;
    after.report.initial_rms = before.report.initial_rms;
    let mut history = before.report.history.clone();
    history.append(&mut after.report.history);
    (1..).zip(&mut history).for_each(|(number, step)| step.iteration = number);
    after.report.history = history;
    let mut evolution = before.evolution.clone();
    evolution.extend(after.evolution.drain(..).skip(1));
    after.evolution = evolution;
    Ok(Some(after))
}
