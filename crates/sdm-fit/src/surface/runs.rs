//! The runs of the loop of which the fit of a surface consists.

use super::ActiveSurface;
use super::fit::SurfaceOptions;
use super::folds::Folds;
use crate::iterate::{Progress, fit_with_progress};
use crate::shape::ActiveShape;
use crate::{Constraints, Error, FitOptions, Fitted, Smoothing, Status, StepRecord, Target};
use distance_field::PrincipalFrame;
use nurbs_core::BsplineSurface;

/// Coefficients up to which the data are asked for the smoothing, and the factor of the energy above.
const ASKED: usize = 2500;
const TRIFLE: f64 = 1e-6;
/// Steps with more fairing around folds, and how much more.
const UNFOLDING_STEPS: usize = 6;
const STIFFER: f64 = 10.0;

/// What all runs on the same points share, and what they leave behind.
pub(super) struct Runs<'a> {
    target: Target<'a, 3>,
    options: &'a SurfaceOptions,
    progress: Progress<'a>,
    pub(super) history: Vec<StepRecord>,
    pub(super) count: usize,
}

/// What a run came to.
pub(super) struct Outcome {
    pub(super) fitted: Fitted<ActiveSurface, 3>,
    pub(super) folds: Folds,
}

impl Outcome {
    /// Share of the points within a distance; those without a foot are not within.
    pub(super) fn share_within(&self, tolerance: f64) -> f64 {
        share_within(&self.fitted.frames, tolerance)
    }
}

impl<'a> Runs<'a> {
    pub(super) fn new(target: Target<'a, 3>, options: &'a SurfaceOptions, progress: Progress<'a>) -> Self {
        Self { target, options, progress, history: Vec::new(), count: 0 }
    }

    /// Fits from a surface, and unfolds it.
    pub(super) fn run(&mut self, surface: BsplineSurface) -> Result<Outcome, Error> {
        let shape = ActiveSurface::new(surface)?;
        let mut constraints = Constraints::none();
        if self.options.fixed_boundary {
            for k in shape.boundary() {
                constraints = constraints.with_held(k, shape.coefficients()[k]);
            }
        }
        let fit = for_size(&self.options.fit, shape.coefficients().len());
        let mut fitted = fit_with_progress(shape, self.target, &constraints, &fit, self.progress)?;
        self.count += 1;
        self.history.append(&mut fitted.report.history);
        let folds = self.unfold(&mut fitted, &constraints, &fit)?;
        Ok(Outcome { fitted, folds })
    }

    /// Goes on with more fairing around folded cells, a few times; the folds that stay.
    fn unfold(
        &mut self,
        fitted: &mut Fitted<ActiveSurface, 3>,
        constraints: &Constraints<3>,
        options: &FitOptions,
    ) -> Result<Folds, Error> {
        let mut folds = Folds::of(fitted.shape.surface());
        for _ in 0..self.options.unfoldings {
            if folds.count() == 0 || options.fairing <= 0.0 || fitted.report.status == Status::Cancelled {
                break;
            }
            fitted.shape.stiffen(&folds.folded, STIFFER);
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
pub(crate) fn share_within(frames: &[PrincipalFrame<3>], tolerance: f64) -> f64 {
    let inside = frames.iter().filter(|f| f.distance.abs() <= tolerance).count();
    inside as f64 / frames.len().max(1) as f64
}
