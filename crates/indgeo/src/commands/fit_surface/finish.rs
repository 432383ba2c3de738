//! Least squares surfaces finished by squared distance minimisation: among outliers, and beyond the ends of their base surfaces.

use crate::commands::fit_surface::conclusion::with_scale;
use industrial_geometry::cloud_param::{
    Error as ParameterError, FinishOutcome, FinishReport, Parameterisation, SurfaceFit,
    finish_fit_with_progress, finish_options,
};
use industrial_geometry::fit::{Folds, Progress, Robust, SurfaceDistances, SurfaceOptions, measurable};
use industrial_geometry::nurbs::nalgebra::Vector3;

/// Distance from a least squares surface, in spacings, by which an outlier does not draw it far to itself.
pub(crate) const HARMLESS: f64 = 0.25;
/// Scales of a kernel one after the other at most, the factor by which the harmless distance is less each time, and up to which the scale must be less.
const SCALES: usize = 8;
const FINER: f64 = 0.1;
const RESOLVED: f64 = 0.5;
/// Points per control point, and in all, that say where a surface is before all points do, and how many times as many there are where that is worth it.
const PER_CONTROL: usize = 250;
const FEWEST: usize = 50_000;
const MANY: usize = 3;
/// How often a surface is drawn to the points beyond its ends.
const EXTENSIONS: usize = 3;

/// The surface finished: by a sample first where there are very many points, and then by all of them.
pub(crate) fn finished(
    points: &[Vector3<f64>],
    (found, counts): (&Parameterisation, &mut Vec<bool>),
    least_squares: SurfaceFit,
    options: &SurfaceOptions,
    progress: Progress<'_>,
) -> Result<(SurfaceFit, FinishReport), ParameterError> {
    let size =
        least_squares.surface.knots_u().distinct_count() * least_squares.surface.knots_v().distinct_count();
    let Some(mut some) = sample(counts, (PER_CONTROL * size).max(FEWEST)) else {
        return finished_with(points, (found, counts), least_squares, options, progress);
    };
    let (near, first) = finished_with(points, (found, &mut some), least_squares, options, progress)?;
    if first.outcome == FinishOutcome::Cancelled {
        return Ok((near, first));
    }
    let steps = finish_options(points.len()).fit.max_iterations.min(options.fit.max_iterations);
    let few = options.with_fit(options.fit.with_max_iterations(steps));
    let (done, then) = finished_with(points, (found, counts), near, &few, progress)?;
    Ok((done, followed(first, then)))
}

/// About so many of the points that count, in no order; `None` unless there are many times as many.
fn sample(counts: &[bool], wanted: usize) -> Option<Vec<bool>> {
    let used = counts.iter().filter(|counts| **counts).count();
    if used < MANY * wanted {
        return None;
    }
    let share = wanted as f64 / used as f64;
    let chosen = |i: usize| {
        // The mixing function of splitmix64: scans are in rows, of which every tenth point may be a row.
        let mut x = (i as u64).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 * 2f64.powi(-53) < share
    };
    Some(counts.iter().enumerate().map(|(i, counts)| *counts && chosen(i)).collect())
}

/// The surface finished with kernels of smaller and smaller scales: at first what is off by less than a share of the spacing counts, so that what
/// the surface does not resolve yet is not taken for outliers; then what is off by less than the noise, or what it cannot resolve.
fn finished_with(
    points: &[Vector3<f64>],
    (found, counts): (&Parameterisation, &mut Vec<bool>),
    least_squares: SurfaceFit,
    options: &SurfaceOptions,
    progress: Progress<'_>,
) -> Result<(SurfaceFit, FinishReport), ParameterError> {
    if !matches!(options.fit.robust, Robust::Kernel { abs_scale: None, .. }) {
        return finish_fit_with_progress(points, counts, least_squares, options, progress);
    }
    let mut harmless = HARMLESS;
    let scale = |fit: &SurfaceFit, counts: &[bool], harmless: f64| -> Result<(f64, bool), ParameterError> {
        let seen = fit.resolution(points, counts)?;
        let least = harmless * seen.spacing;
        Ok((seen.sigma.max(least), seen.unresolved || seen.sigma < least))
    };
    let scaled =
        |sigma: Option<f64>| options.with_fit(options.fit.with_robust(with_scale(options.fit.robust, sigma)));
    // Noise gives the kernel its scale; without noise that would vanish, and points with it.
    let (first, is_chosen) = scale(&least_squares, counts, harmless)?;
    let mut sigma = is_chosen.then_some(first);
    let (mut done, mut report) =
        finish_fit_with_progress(points, counts, least_squares, &scaled(sigma), progress)?;
    for _ in 1..SCALES {
        let Some(before) = sigma.filter(|_| report.outcome != FinishOutcome::Cancelled) else { break };
        harmless *= FINER;
        let again = done.consistent(points, &found.counts, HARMLESS)?;
        let (now, _) = scale(&done, &again, harmless)?;
        if now > RESOLVED * before && again == *counts {
            break;
        }
        sigma = Some(now);
        *counts = again;
        let (next, then) = finish_fit_with_progress(points, counts, done, &scaled(sigma), progress)?;
        done = next;
        report = followed(report, then);
    }
    Ok((done, report))
}

/// One finish after another in one report.
fn followed(mut first: FinishReport, then: FinishReport) -> FinishReport {
    let mut history = std::mem::take(&mut first.minimisation.fit.history);
    history.extend_from_slice(&then.minimisation.fit.history);
    (1..).zip(&mut history).for_each(|(number, step)| step.iteration = number);
    let outcome = if then.outcome.is_new() { then.outcome } else { first.outcome };
    let left = then.rms[usize::from(then.outcome.is_new())];
    let mut report = FinishReport { outcome, rms: [first.rms[0], left], ..then };
    report.minimisation.fit.history = history;
    report
}

/// The surface drawn to the points that are beyond the ends of the base surface, as far as it comes nearer to all of them and does not fold.
pub(crate) fn extended(
    points: &[Vector3<f64>],
    counts: &mut Vec<bool>,
    (mut done, mut report): (SurfaceFit, FinishReport),
    options: &SurfaceOptions,
    progress: Progress<'_>,
) -> Result<(SurfaceFit, FinishReport), ParameterError> {
    let robust = options.fit.robust;
    let belongs = measurable(points)?;
    let off = |fit: &SurfaceFit| -> Result<f64, ParameterError> {
        let all = SurfaceDistances::of(&fit.surface, points, robust)?;
        Ok(all.distances.iter().zip(&belongs).filter(|(_, b)| **b).map(|(d, _)| d * d).sum())
    };
    let mut before = off(&done)?;
    for _ in 0..EXTENSIONS {
        let all = if robust == Robust::None {
            belongs.clone()
        } else {
            done.consistent(points, &belongs, HARMLESS)?
        };
        if all == *counts {
            break;
        }
        let (next, then) = finish_fit_with_progress(points, &all, done.clone(), options, progress)?;
        let now = off(&next)?;
        let folds = [&done, &next].map(|fit| Folds::of(&fit.surface).count());
        if !then.outcome.is_new() || now >= before || folds[1] > folds[0] {
            break;
        }
        before = now;
        *counts = all;
        done = next;
        report = followed(report, then);
    }
    Ok((done, report))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_spread_over_all_points() {
        let counts: Vec<bool> = (0..100_000).map(|i| i % 2 == 0).collect();
        let some = sample(&counts, 5000).unwrap();
        let chosen: Vec<usize> = (0..counts.len()).filter(|&i| some[i]).collect();
        assert!((4700..5300).contains(&chosen.len()) && chosen.iter().all(|&i| counts[i]));
        // As many in each tenth, and of each row of a hundred points.
        for tenth in 0..10 {
            let own = chosen.iter().filter(|&&i| i / 10_000 == tenth).count();
            let column = chosen.iter().filter(|&&i| i % 100 / 10 == tenth).count();
            assert!((400..600).contains(&own) && (400..600).contains(&column), "{tenth}: {own} {column}");
        }
        assert!(sample(&counts, 20_000).is_none());
    }
}
