//! A fitted surface finished by squared distance minimisation.

use super::ease::eased;
use super::{SurfaceFit, rms};
use crate::{Error, SurfaceDefects};
use footpoint::{ProjectionOptions, SurfaceProjector};
use nalgebra::Vector3;
use nurbs_core::BsplineSurface;
use sdm_fit::{
    Folds, Progress, Smoothing, Status, SurfaceOptions, SurfaceReport, fit_surface_with_progress, no_progress,
};

/// Factor of the energy with which a finish begins: the surface is near the points, and more would draw it away from them.
const SMOOTHING: f64 = 1e-6;
const ITERATIONS: usize = 30;
/// Damping of motions, most of them within the tangent planes, where nothing folds.
const DAMPING: f64 = 1e-2;
/// Iterations after which it is seen whether the surface folds; if so, what the damping is raised to, and the factor of the fairing.
const TRIAL: usize = 5;
const CAREFUL: f64 = 0.1;
const LESS: f64 = 0.1;

/// Options of squared distance minimisation for a surface that is near its points already: those of [`SurfaceOptions`], but
/// motions are damped, the smoothing begins with little, 1e-6, and is then what the data ask for, and folds are left to [`finish_fit`],
/// which knows a surface without them.
#[must_use]
pub fn finish_options() -> SurfaceOptions {
    let defaults = SurfaceOptions::default();
    let smoothing = Smoothing::Automatic { start: SMOOTHING, factor: 0.5 };
    let fit = defaults.fit.with_smoothing(smoothing).with_damping(DAMPING);
    defaults.with_unfoldings(0).with_fit(fit.with_max_iterations(ITERATIONS))
}

/// Minimises squared distances from a surface on. Where it folds after a few iterations, since the net does not resolve what the data
/// show, it begins again, its motions more strongly damped.
fn minimised(
    data: &[Vector3<f64>],
    start: &BsplineSurface,
    options: &SurfaceOptions,
    progress: Progress<'_>,
) -> Result<sdm_fit::SurfaceFit, Error> {
    let steps = options.fit.max_iterations;
    // With knots inserted, or with weights, a part of the way is no way.
    if options.abs_tolerance.is_some() || options.rational || steps <= TRIAL {
        return Ok(fit_surface_with_progress(data, start.clone(), options, progress)?);
    }
    let trial = options.with_fit(options.fit.with_max_iterations(TRIAL));
    let first = fit_surface_with_progress(data, start.clone(), &trial, progress)?;
    if first.report.fit.status != Status::MaxIterations {
        return Ok(first);
    }
    let fit = options.fit.with_max_iterations(steps - TRIAL);
    let (from, fit) = if Folds::of(&first.surface).count() <= Folds::of(start).count() {
        (first.surface, fit)
    } else {
        (start.clone(), fit.with_damping(fit.damping.max(CAREFUL)).with_fairing(fit.fairing * LESS))
    };
    let mut made = fit_surface_with_progress(data, from, &options.with_fit(fit), progress)?;
    made.report.fit.initial_rms = first.report.fit.initial_rms;
    let mut history = first.report.fit.history;
    history.append(&mut made.report.fit.history);
    (1..).zip(&mut history).for_each(|(number, step)| step.iteration = number);
    made.report.fit.history = history;
    Ok(made)
}

/// Which surface a finish leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum FinishOutcome {
    /// The one that squared distance minimisation made: nearer to the points, and without folds.
    Finished,
    /// The same with control points moved back to where they began, in part, around places where it folded.
    Eased,
    /// The one that it began with, since what it made folds in many places.
    KeptSinceFolded,
    /// The one that it began with, since what it made is no nearer to the points.
    KeptSinceNoNearer,
    /// The one that it began with: it was cancelled.
    Cancelled,
}

impl FinishOutcome {
    /// Whether the surface is another one than before.
    #[must_use]
    pub fn is_new(self) -> bool {
        matches!(self, Self::Finished | Self::Eased)
    }

    /// The name used in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Finished => "finished",
            Self::Eased => "eased",
            Self::KeptSinceFolded => "kept_since_folded",
            Self::KeptSinceNoNearer => "kept_since_no_nearer",
            Self::Cancelled => "cancelled",
        }
    }
}

/// How a finish went.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct FinishReport {
    /// Which surface is left.
    pub outcome: FinishOutcome,
    /// Root mean square orthogonal distances of the points that count, before and after; the latter also if it was not taken.
    pub rms: [f64; 2],
    /// What is wrong with the surface before and after, and with what the minimisation made.
    pub defects: [SurfaceDefects; 3],
    /// Share of the way that control points were moved back, on average over all.
    pub moved_back: f64,
    /// What the minimisation reports.
    pub minimisation: SurfaceReport,
}

/// Moves the control points of a fitted surface to where the orthogonal distances of the points that count are least, by squared
/// distance minimisation ([`sdm_fit::fit_surface`]), which needs no parameters but begins with good ones. See [`finish_options`].
///
/// The result is never worse than `fitted`: around places where the new surface folds, control points are moved back until it
/// does not; if that fails, or the surface is no nearer to the points, `fitted` is returned as it is, and the report says so.
/// The history of the result is that of `fitted` with the new distance at its end.
///
/// # Errors
/// [`Error::Fit`], [`Error::Option`].
pub fn finish_fit(
    points: &[Vector3<f64>],
    counts: &[bool],
    fitted: SurfaceFit,
    options: &SurfaceOptions,
) -> Result<(SurfaceFit, FinishReport), Error> {
    finish_fit_with_progress(points, counts, fitted, options, &no_progress)
}

/// [`finish_fit`] with a callback after each iteration, which may cancel.
///
/// # Errors
/// As [`finish_fit`].
pub fn finish_fit_with_progress(
    points: &[Vector3<f64>],
    counts: &[bool],
    fitted: SurfaceFit,
    options: &SurfaceOptions,
    progress: Progress<'_>,
) -> Result<(SurfaceFit, FinishReport), Error> {
    if counts.len() != points.len() {
        return Err(Error::Option {
            name: "counts",
            value: counts.len() as f64,
            allowed: "one for each point",
        });
    }
    let used: Vec<usize> = (0..points.len()).filter(|&i| counts[i]).collect();
    let data: Vec<Vector3<f64>> = used.iter().map(|&i| points[i]).collect();
    let made = minimised(&data, &fitted.surface, options, progress)?;
    let cancelled = made.report.fit.status == Status::Cancelled;
    // With knots inserted, or with weights, there is no way back to the beginning.
    let same_knots = made.surface.weights().is_none()
        && made.surface.knots_u() == fitted.surface.knots_u()
        && made.surface.knots_v() == fitted.surface.knots_v();
    let defects = |surface: &BsplineSurface| SurfaceDefects::of(surface, None);
    let (before, raw) = (defects(&fitted.surface), defects(&made.surface));
    let eased = if !same_knots || raw.crossovers <= before.crossovers {
        None
    } else {
        eased(&fitted.surface, &made.surface)?
    };
    let folds = raw.crossovers > before.crossovers && eased.is_none();
    let (surface, moved_back) = eased.unwrap_or((made.surface, 0.0));
    let projector = SurfaceProjector::new(&surface);
    let feet = projector.project_many(points, &ProjectionOptions::default(), &footpoint::no_progress);
    let distance = rms(&used, &feet);
    let outcome = match () {
        () if cancelled => FinishOutcome::Cancelled,
        () if folds => FinishOutcome::KeptSinceFolded,
        () if distance >= fitted.rms => FinishOutcome::KeptSinceNoNearer,
        () if moved_back > 0.0 => FinishOutcome::Eased,
        () => FinishOutcome::Finished,
    };
    let report = FinishReport {
        outcome,
        rms: [fitted.rms, distance],
        defects: [before, defects(&surface), raw],
        moved_back,
        minimisation: made.report,
    };
    if !outcome.is_new() {
        return Ok((fitted, report));
    }
    let max = used.iter().map(|&i| feet[i].distance).fold(0.0, f64::max);
    let mut history = fitted.history;
    history.push(distance);
    Ok((SurfaceFit { surface, history, feet, rms: distance, max, used: used.len() }, report))
}
