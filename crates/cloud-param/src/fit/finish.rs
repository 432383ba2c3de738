//! A fitted surface finished by squared distance minimisation.

use super::SurfaceFit;
use super::ease::eased;
use crate::{Error, SurfaceDefects};
use footpoint::SurfaceProjector;
use nalgebra::Vector3;
use nurbs_core::BsplineSurface;
use sdm_fit::{
    FitStep, Folds, Progress, Smoothing, Status, SurfaceCost, SurfaceOptions, SurfaceReport,
    fit_surface_with_progress, no_progress, residual_disagreement, surface_costs, surface_frames,
};

/// Factor of the energy with which a finish begins: the surface is near the points, and more would draw it away from them.
const SMOOTHING: f64 = 1e-6;
/// Iterations at most: what many points are left with, what few are given, and about how many footpoints decide.
const ITERATIONS: [usize; 2] = [15, 25];
const FOOTPOINTS: usize = 600_000;
/// Damping of motions, most of them within the tangent planes, where nothing folds.
const DAMPING: f64 = 1e-2;
/// Iterations after which it is seen whether the surface folds.
const STAGE: usize = 5;
/// A stage that lowers the distance by less than this share is the last.
const SLOW: f64 = 0.005;
/// How much farther from the points a smoother surface may be whose residuals are not noise, and the disagreement of residuals, 1 for noise,
/// below which neighbours share them.
const FARTHER: f64 = 1.5;
const ALIKE: f64 = 0.5;
/// Iterations after which the smoothing that the data ask for stays.
const SETTLED: usize = 15;
/// Where it folds, and control points have to be moved back by more than this share, what the damping is raised to, and the factor of the fairing.
const MUCH: f64 = 0.05;
const CAREFUL: f64 = 0.1;
const LESS: f64 = 0.1;

/// Options of squared distance minimisation for a surface that is near its points already: those of [`SurfaceOptions`], but
/// motions are damped, the smoothing begins with little, 1e-6, and is then what the data ask for, and
/// folds are left to [`finish_fit`], which knows a surface without them. There are at most 25 iterations for up to 24,000 points,
/// which last gain by them, and fewer for more, down to 15 from 40,000 on.
#[must_use]
pub fn finish_options(points: usize) -> SurfaceOptions {
    let defaults = SurfaceOptions::default();
    let smoothing = Smoothing::Automatic { start: SMOOTHING, factor: 0.5 };
    let fit = defaults.fit.with_smoothing(smoothing).with_damping(DAMPING);
    let iterations = (FOOTPOINTS / points.max(1)).clamp(ITERATIONS[0], ITERATIONS[1]);
    defaults
        .with_unfoldings(0)
        .with_exact(false)
        .with_coverage(false)
        .with_fit(fit.with_max_iterations(iterations))
}

/// A surface that squared distance minimisation made, its folds smoothed away.
struct Minimised {
    surface: BsplineSurface,
    report: SurfaceReport,
    /// What was wrong with it before.
    raw: SurfaceDefects,
    /// Share of the way that control points were moved back, on average, most in one stage.
    moved_back: f64,
    /// What the start and the result cost, by the same measure: the same weights of the points, and the same energy.
    costs: [SurfaceCost; 2],
    /// Whether it folds, since easing failed.
    is_folded: bool,
}

/// Minimises squared distances from a surface on, a few iterations at a time. Where the surface folds after these, since the net does not
/// resolve what the data show, control points are moved back towards the surface before; if that is no nearer to the points, the
/// iterations are made again, their motions more strongly damped, and if that does not help either it ends with the surface
/// before.
fn minimised(
    data: &[Vector3<f64>],
    start: &SurfaceFit,
    options: &SurfaceOptions,
    progress: Progress<'_>,
) -> Result<Minimised, Error> {
    let defects = |surface: &BsplineSurface| SurfaceDefects::of(surface, None);
    let first = surface_frames(&start.surface, data)?;
    // With knots inserted, or with weights, a part of the way is no way, and there is none back.
    if options.abs_tolerance.is_some() || options.rational {
        let made = fit_surface_with_progress(data, start.surface.clone(), options, progress)?;
        let (raw, before) = (defects(&made.surface), defects(&start.surface));
        let is_folded = raw.crossovers > before.crossovers;
        let pair = [(&start.surface, &first[..]), (&made.surface, &made.frames[..])];
        let costs = surface_costs(data, pair, &options.fit, 0.0)?;
        let (surface, report) = (made.surface, made.report);
        return Ok(Minimised { surface, report, raw, moved_back: 0.0, costs, is_folded });
    }
    let allowed = Folds::of(&start.surface).count();
    let (mut fit, mut surface, mut frames) = (options.fit, start.surface.clone(), first.clone());
    let (mut history, mut moved_back, mut raw) = (Vec::new(), 0.0f64, None);
    let (mut first_rms, mut lambda) = (None, 0.0);
    loop {
        let steps = STAGE.min(options.fit.max_iterations - history.len());
        let stage = options.with_fit(fit.with_max_iterations(steps));
        let before = history.len();
        let numbered = |step: &FitStep| progress(&FitStep { iteration: before + step.iteration, ..*step });
        let made = fit_surface_with_progress(data, surface.clone(), &stage, &numbered)?;
        let mut report = made.report;
        let first_rms = *first_rms.get_or_insert(report.fit.initial_rms);
        history.extend_from_slice(&report.fit.history);
        let status = report.fit.status;
        let mut next = Some((made.surface, made.frames, 0.0));
        if let Some((folded, ..)) = next.take_if(|(made, ..)| Folds::of(made).count() > allowed) {
            raw = Some(defects(&folded));
            next = match eased(&surface, &folded, allowed)? {
                Some((eased, back)) => Some((eased.clone(), surface_frames(&eased, data)?, back)),
                None => None,
            };
        }
        // Like with like: the weights of the new one, and its energy.
        let costs = match &next {
            Some((made, places, _)) => {
                let pair = [(&surface, &frames[..]), (made, &places[..])];
                Some(surface_costs(data, pair, &fit, report.fit.lambda)?)
            }
            None => None,
        };
        // A smoothing that leaves residuals which neighbours share has gone too far: there was no noise to be smoothed.
        let too_smooth = match (&next, costs) {
            (Some((_, places, _)), Some([before, after])) => {
                let is_automatic = matches!(options.fit.smoothing, Smoothing::Automatic { .. });
                let is_farther = is_automatic && after.rms > FARTHER * before.rms;
                is_farther && residual_disagreement(data, places)? < ALIKE
            }
            _ => false,
        };
        let is_cheaper = costs.is_some_and(|[before, after]| after.cost < before.cost);
        let is_better = next.filter(|_| is_cheaper && !too_smooth);
        let failed = is_better.is_none();
        // Steps that lower what they minimise come to no better surface: this one is a minimum.
        let at_minimum = failed && costs.is_some();
        let back_much = is_better.as_ref().is_some_and(|(.., back)| *back > MUCH) && fit.damping < CAREFUL;
        let slow = (1.0 - SLOW) * (1.0 - SLOW);
        let is_slow = !failed && costs.is_some_and(|[before, after]| after.cost > slow * before.cost);
        if let Some((made, places, back)) = is_better {
            (surface, frames, moved_back) = (made, places, moved_back.max(back));
            lambda = report.fit.lambda;
        }
        let is_careful = fit.damping >= CAREFUL;
        let ends = status != Status::MaxIterations || history.len() >= options.fit.max_iterations;
        if ends || is_slow || failed && is_careful {
            (1..).zip(&mut history).for_each(|(number, step)| step.iteration = number);
            let pair = [(&start.surface, &first[..]), (&surface, &frames[..])];
            let costs = surface_costs(data, pair, &options.fit, lambda)?;
            let raw = raw.unwrap_or_else(|| defects(&surface));
            report.fit.initial_rms = first_rms;
            report.fit.rms = costs[1].rms;
            report.fit.lambda = lambda;
            report.folds = Folds::of(&surface);
            // What was cancelled, or went wrong, stays so; the limit of a stage is not that of all.
            let at_limit = history.len() >= options.fit.max_iterations;
            report.fit.status = match status {
                Status::MaxIterations | Status::Stalled if is_slow || at_minimum => Status::Converged,
                Status::MaxIterations if !at_limit => Status::Stalled,
                status => status,
            };
            report.fit.history = history;
            return Ok(Minimised { surface, report, raw, moved_back, costs, is_folded: false });
        }
        if failed || back_much {
            fit = fit.with_damping(CAREFUL).with_fairing(fit.fairing * LESS);
        }
        if !failed {
            fit = fit.with_smoothing(gone_on(fit.smoothing, lambda, history.len() >= SETTLED));
        }
    }
}

/// The schedule of the next stage: from where the one before ended.
fn gone_on(smoothing: Smoothing, lambda: f64, settled: bool) -> Smoothing {
    match smoothing {
        Smoothing::Automatic { .. } if settled => Smoothing::Fixed { lambda },
        Smoothing::Automatic { factor, .. } => Smoothing::Automatic { start: lambda, factor },
        Smoothing::Continuation { factor, floor, .. } => {
            Smoothing::Continuation { start: lambda.max(floor), factor, floor }
        }
        fixed @ Smoothing::Fixed { .. } => fixed,
    }
}

/// Which surface a finish leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum FinishOutcome {
    /// The one that squared distance minimisation made: nearer to the points, and without folds.
    Finished,
    /// The same with control points moved back, in part, to where they were some iterations before, around places where it folded.
    Eased,
    /// The one that it began with, since what it made folds in many places.
    KeptSinceFolded,
    /// The one that it began with, since what it made costs no less: with the same weights of the points, and the same energy.
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
    /// Root mean square orthogonal distances of the points, before and after, with the weights that they have after; also if that was
    /// not taken.
    pub rms: [f64; 2],
    /// What was compared: mean squared distances with these weights, plus the smoothing energy with its factor at the end.
    pub cost: [f64; 2],
    /// What is wrong with the surface before and after, and with what the minimisation made.
    pub defects: [SurfaceDefects; 3],
    /// Share of the way of some iterations that control points were moved back, on average over all; the largest one.
    pub moved_back: f64,
    /// What the minimisation reports.
    pub minimisation: SurfaceReport,
}

/// Moves the control points of a fitted surface to where the orthogonal distances of the points that count are least, by squared
/// distance minimisation ([`sdm_fit::fit_surface`]), which needs no parameters but begins with good ones. See [`finish_options`].
///
/// Every five iterations it is seen whether the surface folds. If so, control points are moved back around these places, towards the
/// surface of five iterations before, until it does not, and the minimisation goes on from there. It also ends, as converged, when
/// five iterations lower the distance by less than half a per cent. The result never costs more than `fitted`, which is returned as it is
/// if nothing better is found; the report says so. What is compared are the squared distances with the same weights, where outliers are
/// expected, and with the energy of both: a surface that was smoothed is not nearer to noisy points than one that follows their noise.
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
    let made = minimised(&data, &fitted, options, progress)?;
    let cancelled = made.report.fit.status == Status::Cancelled;
    let Minimised { surface, moved_back, raw, is_folded, costs, .. } = made;
    let defects = |surface: &BsplineSurface| SurfaceDefects::of(surface, None);
    let outcome = match () {
        () if cancelled => FinishOutcome::Cancelled,
        () if is_folded => FinishOutcome::KeptSinceFolded,
        () if costs[1].cost >= costs[0].cost => FinishOutcome::KeptSinceNoNearer,
        () if moved_back > 0.0 => FinishOutcome::Eased,
        () => FinishOutcome::Finished,
    };
    let report = FinishReport {
        outcome,
        rms: costs.map(|c| c.rms),
        cost: costs.map(|c| c.cost),
        defects: [defects(&fitted.surface), defects(&surface), raw],
        moved_back,
        minimisation: made.report,
    };
    if !outcome.is_new() {
        return Ok((fitted, report));
    }
    let feet = SurfaceProjector::new(&surface).project_all(points);
    let max = used.iter().map(|&i| feet[i].distance).fold(0.0, f64::max);
    let distance = super::rms(&used, &feet);
    let mut history = fitted.history;
    history.push(distance);
    Ok((SurfaceFit { surface, history, feet, rms: distance, max, used: used.len() }, report))
}
