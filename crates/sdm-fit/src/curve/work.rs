//! The points of a curve fit, and the runs of the loop on them.

use super::active::ActiveCurve;
use super::crossing::self_crossings;
use super::options::CurveOptions;
use super::report::StageRecord;
use super::start::Layout;
use crate::iterate::{Progress, fit_with_progress};
use crate::options::{FitOptions, Smoothing};
use crate::{Constraints, Error, FitReport, FitStep, Status, Target};
use nalgebra::SVector;
use nurbs_core::BsplineCurve;
use sdm_core::{FootpointPolicy, Robust};

/// Points on which the number of control points is chosen at most.
pub(super) const CHOICE: usize = 20_000;
/// Least `λ` while knots are missing.
pub(super) const COARSE: f64 = 1e-6;
/// Least damping of steps while points are followed: without it the curve slides along itself and makes loops where there are no points.
const FOLLOWED: f64 = 0.1;
/// Change of the cost that ends such runs: damped steps creep.
const STILL: f64 = 1e-3;

/// Share of the size below which distances are rounding.
pub(super) const EXACT: f64 = 1e-9;
/// Factors of `λ` tried when a curve crosses itself.
pub(super) const SMOOTHER: [f64; 4] = [4.0, 16.0, 64.0, 256.0];

/// Which runs were kept.
#[derive(Clone)]
pub(super) struct Kept<const D: usize> {
    history: Vec<FitStep>,
    evolution: Vec<BsplineCurve<D>>,
    stages: Vec<bool>,
    follows: bool,
}

/// A curve with what is known about it.
#[derive(Clone, Debug)]
pub(super) struct State<const D: usize> {
    pub(super) curve: BsplineCurve<D>,
    pub(super) report: FitReport,
    pub(super) evolution: Vec<BsplineCurve<D>>,
}

/// The points and the runs of the loop on them.
pub(super) struct Work<'a, const D: usize> {
    pub(super) points: &'a [SVector<f64, D>],
    pub(super) options: &'a CurveOptions,
    pub(super) size: f64,
    progress: Progress<'a>,
    pub(super) stages: Vec<StageRecord>,
    pub(super) history: Vec<FitStep>,
    pub(super) evolution: Vec<BsplineCurve<D>>,
    pub(super) cancelled: bool,
    /// Whether each point keeps to the part of the curve that its foot is on, instead of looking for the nearest one: a curve that begins
    /// near to the path then stays on it.
    pub(super) follows: bool,
    /// How often the path crosses itself; that often the curve may do so, too.
    pub(super) expected: usize,
    /// Whether points that lie off the path are not among these, so that distances tell no outliers before there is a good curve.
    pub(super) sorted_out: bool,
    /// Whether the curve was given, and its number of control points with it.
    pub(super) given: bool,
    /// A tolerance that the points call for where none is asked for.
    pub(super) goal: Option<f64>,
}

impl<'a, const D: usize> Work<'a, D> {
    pub(super) fn new(
        points: &'a [SVector<f64, D>],
        options: &'a CurveOptions,
        progress: Progress<'a>,
    ) -> Self {
        Self {
            points,
            options,
            size: points.iter().map(|p| p.amax()).fold(0.0, f64::max),
            progress,
            stages: Vec::new(),
            history: Vec::new(),
            evolution: Vec::new(),
            cancelled: false,
            follows: false,
            expected: 0,
            given: false,
            sorted_out: false,
            goal: None,
        }
    }

    /// The distance that no point shall exceed, if there is one.
    pub(super) fn tolerance(&self) -> Option<f64> {
        self.options.abs_tolerance.or(self.goal)
    }

    /// How often a curve crosses itself beyond what the path does.
    pub(super) fn crossings(&self, curve: &BsplineCurve<D>) -> usize {
        self_crossings(curve).len().saturating_sub(self.expected)
    }

    /// Which runs were kept so far; from here on none are.
    pub(super) fn kept(&mut self) -> Kept<D> {
        Kept {
            history: std::mem::take(&mut self.history),
            evolution: std::mem::take(&mut self.evolution),
            stages: self.stages.iter_mut().map(|s| std::mem::take(&mut s.kept)).collect(),
            follows: self.follows,
        }
    }

    /// Keeps the runs that were kept before, and no later ones.
    pub(super) fn restore(&mut self, kept: Kept<D>) {
        (self.history, self.evolution, self.follows) = (kept.history, kept.evolution, kept.follows);
        let flags = kept.stages.into_iter().chain(std::iter::repeat(false));
        self.stages.iter_mut().zip(flags).for_each(|(stage, kept)| stage.kept = kept);
    }

    /// One run of the loop on some of the points.
    pub(super) fn run_on(
        &mut self,
        points: &[SVector<f64, D>],
        curve: BsplineCurve<D>,
        fit: &FitOptions,
        stage: &'static str,
    ) -> Result<State<D>, Error> {
        self.run_within(points, curve, &Constraints::none(), fit, stage)
    }

    /// The same under side conditions.
    pub(super) fn run_within(
        &mut self,
        points: &[SVector<f64, D>],
        curve: BsplineCurve<D>,
        constraints: &Constraints<D>,
        fit: &FitOptions,
        stage: &'static str,
    ) -> Result<State<D>, Error> {
        let active = ActiveCurve::new(curve)?;
        let target = Target::Points { points, weights: None };
        let fitted = fit_with_progress(active.clone(), target, constraints, fit, self.progress)?;
        self.cancelled |= fitted.report.status == Status::Cancelled;
        let evolution = fitted.evolution.iter().map(|coefficients| {
            let mut shape = active.clone();
            crate::ActiveShape::set_coefficients(&mut shape, coefficients).map(|()| shape.into_curve())
        });
        let evolution = evolution.collect::<Result<_, _>>()?;
        let state = State { curve: fitted.shape.into_curve(), report: fitted.report, evolution };
        self.note(&state, stage);
        Ok(state)
    }

    pub(super) fn run(
        &mut self,
        curve: BsplineCurve<D>,
        fit: &FitOptions,
        stage: &'static str,
    ) -> Result<State<D>, Error> {
        self.run_on(self.points, curve, fit, stage)
    }

    pub(super) fn note(&mut self, state: &State<D>, stage: &'static str) {
        self.stages.push(StageRecord {
            stage,
            controls: state.curve.knots().distinct_count(),
            rms: state.report.rms,
            max: state.report.max,
            lambda: state.report.lambda,
            iterations: state.report.history.len(),
            status: state.report.status,
            kept: false,
        });
    }

    /// Takes the curve of the last run for what follows.
    pub(super) fn keep(&mut self, state: &State<D>) {
        if let Some(stage) = self.stages.last_mut() {
            stage.kept = true;
        }
        self.history.extend_from_slice(&state.report.history);
        self.evolution.extend_from_slice(&state.evolution);
    }

    /// Options of the loop for a curve: footpoints are cheap, so all are found each time, unless they are followed.
    pub(super) fn loop_options(&self) -> FitOptions {
        let fit = self.options.fit;
        let fit = if self.sorted_out { fit.with_robust(Robust::None) } else { fit };
        if self.follows {
            // Knots are where the curve bends, and the number of control points is what noise limits: energy only bridges gaps.
            let smoothing = match fit.smoothing {
                Smoothing::Automatic { .. } => Smoothing::Fixed { lambda: COARSE },
                smoothing => smoothing,
            };
            return fit
                .with_smoothing(smoothing)
                .with_footpoints(FootpointPolicy::Local)
                .with_damping(fit.damping.max(FOLLOWED))
                .with_cost_tolerance(fit.cost_tolerance.max(STILL));
        }
        if fit.footpoints == FootpointPolicy::Adaptive && self.points.len() <= CHOICE {
            fit.with_footpoints(FootpointPolicy::Global)
        } else {
            fit
        }
    }

    /// The fit with a number of control points, from the path or, where that leads nowhere, from an ellipse.
    pub(super) fn with_controls(
        &mut self,
        layout: &Layout<D>,
        controls: usize,
        fit: &FitOptions,
    ) -> Result<State<D>, Error> {
        self.fitted_from(layout, layout.curve(self.options.degree, controls)?, fit)
    }

    pub(super) fn fitted_from(
        &mut self,
        layout: &Layout<D>,
        curve: BsplineCurve<D>,
        fit: &FitOptions,
    ) -> Result<State<D>, Error> {
        let controls = curve.knots().distinct_count();
        let crossed = self.crossings(&curve) > 0;
        let state = self.run(curve.clone(), fit, "fit")?;
        let state = self.uncrossed(state, &curve, crossed)?;
        let lost = state.report.status == Status::Diverged || self.crossings(&state.curve) > 0 && !crossed;
        if !(lost && layout.closed) || self.cancelled {
            return self.finished(state);
        }
        let curve = layout.as_ellipse().curve(self.options.degree, controls)?;
        let other = self.run(curve.clone(), fit, "fit")?;
        let other = self.uncrossed(other, &curve, false)?;
        let better = self.crossings(&other.curve) == 0 && other.report.status != Status::Diverged;
        self.finished(if better { other } else { state })
    }
}
