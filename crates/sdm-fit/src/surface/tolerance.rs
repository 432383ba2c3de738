//! Surfaces with as many knots as a tolerance needs.

use super::refine::{coarser, refined};
use super::runs::{Outcome, Runs};
use crate::{Error, parallel};
use distance_field::PrincipalFrame;
use mesh_core::CloudIndex;
use nalgebra::{Point3, Vector3};
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
    let (mut unfoldings, mut is_noise) = (0, false);
    while !outcome.is_cancelled() {
        let good = outcome.is_good(options);
        if good && (outcome.folds.count() == 0 || unfoldings >= UNFOLDINGS) {
            break;
        }
        // Within the tolerance, but with cells that fold: they are too large for what is in them.
        let folded: &[[usize; 2]] = if good { &outcome.folds.folded } else { &[] };
        let (shape, frames) = (outcome.fitted.shape.surface(), &outcome.fitted.frames);
        let followed = without_noise(runs.points(), frames, tolerance)?;
        is_noise = followed.iter().all(|f| f.distance.abs() <= tolerance);
        let Some(finer) = refined(shape, &followed, (tolerance, folded), options.max_controls)? else {
            break;
        };
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
    // They were in rows; some carry nothing. Where sides are held they stay: to remove one moves the sides, too.
    if knots_were_inserted && !options.holds_some() && outcome.is_good(options) {
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
    let few_steps = knots_were_inserted && !is_noise;
    let last = if few_steps { runs.last(last)? } else { runs.run(last)? };
    // Where only noise is beyond the tolerance, what it asks for counts, not the distance.
    if is_noise && !outcome.is_good(options) && last.folds.count() <= outcome.folds.count() {
        return Ok(last);
    }
    Ok(better(outcome, last, runs))
}

/// Neighbours of a point that is beyond the tolerance, and share of its residual that their median must have for the surface to follow them.
const NEIGHBOURS: usize = 6;
const ALIKE: f64 = 0.3;

/// The frames without those of points that are beyond the tolerance by themselves, their neighbours on both sides of the surface: more knots
/// would follow noise.
fn without_noise(
    points: &[Vector3<f64>],
    frames: &[PrincipalFrame<3>],
    tolerance: f64,
) -> Result<Vec<PrincipalFrame<3>>, Error> {
    let places: Vec<Point3<f64>> = frames.iter().map(|f| f.foot.into()).collect();
    let index = CloudIndex::new(&places)?;
    let keeps = |i: usize| {
        let frame = &frames[i];
        if !frame.is_finite() || frame.distance.abs() <= tolerance {
            return true;
        }
        let here = points[i] - frame.foot;
        let near = index.nearest_n(&places[i], NEIGHBOURS + 1);
        let others = near.iter().filter(|n| n.index != i);
        let mut along: Vec<f64> = others
            .map(|n| (points[n.index] - frames[n.index].foot).dot(&here) / here.norm_squared())
            .collect();
        along.sort_unstable_by(f64::total_cmp);
        along.get(along.len() / 2).is_none_or(|median| *median >= ALIKE)
    };
    let kept = parallel::map(frames.len(), keeps);
    Ok(frames.iter().zip(kept).filter(|(_, kept)| *kept).map(|(frame, _)| *frame).collect())
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
