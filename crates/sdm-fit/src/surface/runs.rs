//! The runs of the loop of which the fit of a surface consists.

use super::ActiveSurface;
use super::folds::Folds;
use super::judge::residual_disagreement;
use super::options::SurfaceOptions;
use crate::iterate::{Progress, fit_with_progress};
use crate::polish::{nearly_exact, polished};
use crate::shape::ActiveShape;
use crate::{Constraints, Error, FitOptions, FitStep, Fitted, Smoothing, Status, Target};
use distance_field::PrincipalFrame;
use nalgebra::Vector3;
use nurbs_core::BsplineSurface;

/// Coefficients up to which the data are asked for the smoothing, and the factor of the energy above.
const ASKED: usize = 2500;
const TRIFLE: f64 = 1e-6;
/// Steps with more fairing around folds.
const UNFOLDING_STEPS: usize = 6;
/// On the way to a tolerance: most steps between two insertions of knots, and at the end; change of the cost that ends these. Knots are
/// what is missing on the way, not steps.
const STAGE_STEPS: usize = 6;
const LAST_STEPS: usize = 10;
const LAST_CHANGE: f64 = 0.01;
/// Least damping of steps on that way: surfaces with many knots slide along themselves where there are few points, and fold.
const DAMPING: f64 = 0.3;
/// Largest energy that a surface begins with which is already near: more would take it away from the points again.
const AGAIN: f64 = 1e-5;

/// What all runs on the same points share, and what they leave behind.
pub(super) struct Runs<'a> {
    target: Target<'a, 3>,
    pub(super) options: &'a SurfaceOptions,
    progress: Progress<'a>,
    pub(super) history: Vec<FitStep>,
    pub(super) count: usize,
    /// Root mean square distance of the start of the first.
    pub(super) initial_rms: f64,
}

/// What a run came to.
#[derive(Clone)]
pub(super) struct Outcome {
    pub(super) fitted: Fitted<ActiveSurface, 3>,
    pub(super) folds: Folds,
}

impl Outcome {
    /// Whether enough points are within the tolerance, if there is one.
    pub(super) fn is_good(&self, options: &SurfaceOptions) -> bool {
        let share = |tolerance| share_within(&self.fitted.frames, tolerance);
        options.abs_tolerance.is_none_or(|tolerance| share(tolerance) >= options.share)
    }

    pub(super) fn is_cancelled(&self) -> bool {
        self.fitted.report.status == Status::Cancelled
    }
}

impl<'a> Runs<'a> {
    pub(super) fn new(target: Target<'a, 3>, options: &'a SurfaceOptions, progress: Progress<'a>) -> Self {
        Self { target, options, progress, history: Vec::new(), count: 0, initial_rms: 0.0 }
    }

    /// The points.
    pub(super) fn points(&self) -> &'a [Vector3<f64>] {
        match self.target {
            Target::Points { points, .. } => points,
            Target::Model { .. } => &[],
        }
    }

    /// Fits from a surface, and unfolds it.
    pub(super) fn run(&mut self, surface: BsplineSurface) -> Result<Outcome, Error> {
        self.run_with(surface, &self.options.fit, self.options.unfoldings)
    }

    /// A few steps from a surface, the first or one that is already `near`, before knots are inserted or removed.
    pub(super) fn stage(&mut self, surface: BsplineSurface, near: bool) -> Result<Outcome, Error> {
        let steps = self.options.fit.max_iterations.min(STAGE_STEPS);
        let fit = on_the_way(&self.options.fit, near).with_max_iterations(steps);
        self.run_with(surface, &fit, 0)
    }

    /// The last steps on the way to a tolerance.
    pub(super) fn last(&mut self, surface: BsplineSurface) -> Result<Outcome, Error> {
        let fit = self.options.fit;
        let steps = fit.max_iterations.min(LAST_STEPS);
        let fit = fit
            .with_max_iterations(steps)
            .with_cost_tolerance(fit.cost_tolerance.max(LAST_CHANGE))
            .with_damping(fit.damping.max(DAMPING))
            .with_smoothing(begun_again(fit.smoothing));
        self.run_with(surface, &fit, self.options.unfoldings)
    }

    /// Goes on without any energy where the points lie on the surface nearly exactly, if that makes it exact and leaves no folds.
    pub(super) fn polished(&mut self, outcome: Outcome, size: f64) -> Result<Outcome, Error> {
        let constraints = self.constraints(&outcome.fitted.shape);
        let nearly = nearly_exact(residual_disagreement(self.points(), &outcome.fitted.frames)?);
        let found = polished(
            &outcome.fitted,
            self.target,
            &constraints,
            &self.options.fit,
            (size, nearly),
            self.progress,
        )?;
        let Some(fitted) = found else { return Ok(outcome) };
        let folds = Folds::of(fitted.shape.surface());
        if folds.count() > outcome.folds.count() {
            return Ok(outcome);
        }
        self.history.extend_from_slice(&fitted.report.history);
        self.count += 1;
        Ok(Outcome { fitted, folds })
    }

    /// What the control points must keep to.
    fn constraints(&self, shape: &ActiveSurface) -> Constraints<3> {
        let held = shape.rows_at_sides(self.options.held);
        held.into_iter().fold(Constraints::none(), |all, k| all.with_held(k, shape.coefficients()[k]))
    }

    fn run_with(
        &mut self,
        surface: BsplineSurface,
        options: &FitOptions,
        unfoldings: usize,
    ) -> Result<Outcome, Error> {
        let shape = ActiveSurface::new(surface)?;
        let constraints = self.constraints(&shape);
        let fit = for_size(options, shape.coefficients().len());
        let mut fitted = fit_with_progress(shape, self.target, &constraints, &fit, self.progress)?;
        if self.count == 0 {
            self.initial_rms = fitted.report.initial_rms;
        }
        self.count += 1;
        self.history.append(&mut fitted.report.history);
        let folds = self.unfold(&mut fitted, &constraints, &fit, unfoldings)?;
        Ok(Outcome { fitted, folds })
    }

    /// Goes on with more fairing around folded cells, a few times; the folds that stay.
    fn unfold(
        &mut self,
        fitted: &mut Fitted<ActiveSurface, 3>,
        constraints: &Constraints<3>,
        options: &FitOptions,
        unfoldings: usize,
    ) -> Result<Folds, Error> {
        let mut folds = Folds::of(fitted.shape.surface());
        for _ in 0..unfoldings {
            if folds.count() == 0 || options.fairing <= 0.0 || fitted.report.status == Status::Cancelled {
                break;
            }
            fitted.shape.stiffen(&folds.folded);
            let lambda = fitted.report.lambda;
            let more =
                options.with_smoothing(Smoothing::Fixed { lambda }).with_max_iterations(UNFOLDING_STEPS);
            let status = fitted.report.status;
            let mut next =
                fit_with_progress(fitted.shape.clone(), self.target, constraints, &more, self.progress)?;
            self.history.append(&mut next.report.history);
            let left = Folds::of(next.shape.surface());
            if left.count() > folds.count() && next.report.status != Status::Cancelled {
                continue;
            }
            folds = left;
            *fitted = next;
            if fitted.report.status == Status::MaxIterations {
                fitted.report.status = status;
            }
        }
        Ok(folds)
    }
}

/// The options on the way to a tolerance: damped, and an energy that the data are not asked for, since what is left of the distances is
/// no noise while knots are missing.
fn on_the_way(options: &FitOptions, near: bool) -> FitOptions {
    let smoothing = match if near { begun_again(options.smoothing) } else { options.smoothing } {
        Smoothing::Automatic { start, .. } => Smoothing::Continuation { start, factor: 0.25, floor: TRIFLE },
        smoothing => smoothing,
    };
    options.with_damping(options.damping.max(DAMPING)).with_smoothing(smoothing)
}

/// The schedule of the energy for a surface that is already near.
fn begun_again(smoothing: Smoothing) -> Smoothing {
    match smoothing {
        Smoothing::Fixed { .. } => smoothing,
        Smoothing::Continuation { start, factor, floor } => {
            Smoothing::Continuation { start: start.min(AGAIN.max(floor)), factor, floor }
        }
        Smoothing::Automatic { start, factor } => Smoothing::Automatic { start: start.min(AGAIN), factor },
    }
}

/// The options for a number of coefficients: of large nets the data are not asked for the smoothing, since that takes longer
/// than the fit; their energy falls to a trifle that only bridges gaps.
fn for_size(options: &FitOptions, coefficients: usize) -> FitOptions {
    match options.smoothing {
        Smoothing::Automatic { start, .. } if coefficients > ASKED => {
            options.with_smoothing(Smoothing::Continuation { start, factor: 0.25, floor: TRIFLE })
        }
        _ => *options,
    }
}

/// Share of the points within a distance; those without a foot are not within.
pub(super) fn share_within(frames: &[PrincipalFrame<3>], tolerance: f64) -> f64 {
    let inside = frames.iter().filter(|f| f.distance.abs() <= tolerance).count();
    inside as f64 / frames.len().max(1) as f64
}
