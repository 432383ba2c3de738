//! Surfaces with as many knots as a tolerance needs.

use super::refine::{coarser, refined};
use super::runs::{Outcome, Runs};
use crate::Error;
use nurbs_core::BsplineSurface;

/// Shares of the tolerance by which the removal of knots may move the surface, tried one after the other.
const REMOVALS: [f64; 3] = [0.5, 0.25, 0.1];
/// Insertions of knots at most where the tolerance holds but cells fold.
const UNFOLDINGS: usize = 4;

/// Fits from a surface: knots inserted where points are too far away, and removed where they carry nothing.
pub(super) fn fit_to_tolerance(
    runs: &mut Runs<'_>,
    surface: BsplineSurface,
    tolerance: f64,
) -> Result<Outcome, Error> {
    let options = runs.options;
    let mut outcome = runs.stage(surface, false)?;
    let mut best: Option<Outcome> = None;
    let mut unfoldings = 0;
    while !outcome.is_cancelled() {
        let good = outcome.is_good(options);
        if good && (outcome.folds.count() == 0 || unfoldings >= UNFOLDINGS) {
            break;
        }
        // Within the tolerance, but with cells that fold: they are too large for what is in them.
        let folded: &[[usize; 2]] = if good { &outcome.folds.folded } else { &[] };
        let (shape, frames) = (outcome.fitted.shape.surface(), &outcome.fitted.frames);
        let Some(finer) = refined(shape, frames, (tolerance, folded), options.max_controls)? else { break };
        let next = runs.stage(finer, true)?;
        if good {
            unfoldings += 1;
            best = Some(best.map_or_else(|| outcome.clone(), |best| better(best, outcome.clone(), runs)));
        }
        outcome = next;
    }
    if let Some(best) = best.filter(|_| !outcome.is_cancelled()) {
        outcome = better(best, outcome, runs);
    }
    let knots_were_inserted = runs.count > 1;
    // They were in rows; some carry nothing.
    if knots_were_inserted && outcome.is_good(options) {
        for share in REMOVALS {
            if outcome.is_cancelled() {
                break;
            }
            let Some(coarser) = coarser(outcome.fitted.shape.surface(), share * tolerance)? else { break };
            outcome = better(outcome, runs.stage(coarser, true)?, runs);
        }
    }
    if outcome.is_cancelled() {
        return Ok(outcome);
    }
    let last = outcome.fitted.shape.surface().clone();
    let last = if knots_were_inserted { runs.last(last)? } else { runs.run(last)? };
    Ok(better(outcome, last, runs))
}

/// The later of two outcomes, unless it leaves the tolerance or folds in more cells.
fn better(before: Outcome, after: Outcome, runs: &Runs<'_>) -> Outcome {
    let nearer = if before.is_good(runs.options) {
        after.is_good(runs.options)
    } else {
        after.fitted.report.rms <= before.fitted.report.rms
    };
    if nearer && after.folds.count() <= before.folds.count() { after } else { before }
}
