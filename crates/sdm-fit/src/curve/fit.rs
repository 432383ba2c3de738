//! From points to a curve: start, control points, tolerance, weights.

use super::active::ActiveCurve;
use super::adapt;
use super::crossing::self_crossings;
use super::front;
use super::options::CurveOptions;
use super::places::{centre, count_distinct};
use super::rational;
use super::report::{Closure, CurveFit, CurveReport, CurveStart, PointFoot, StageRecord};
use super::start::Layout;
use crate::iterate::{Progress, fit_with_progress, no_progress};
use crate::options::{FitOptions, FootpointPolicy, Smoothing};
use crate::{Constraints, Error, FitReport, Status, StepRecord, Target};
use footpoint::CurveProjector;
use nalgebra::SVector;
use nurbs_core::BsplineCurve;

/// Points on which the number of control points is chosen at most.
pub(super) const CHOICE: usize = 20_000;
/// Share of the size below which distances are rounding.
pub(super) const EXACT: f64 = 1e-9;
/// Contours of a search that are kept.
const STAGES: usize = 8;
/// Distance from the path, in units of the tolerance, of the curve from which points are followed, and least damping of steps then: without
/// it the curve slides along itself and makes loops where there are no points.
const FOLLOWED_FROM: f64 = 3.0;
const FOLLOWED: f64 = 0.1;
/// Change of the cost that ends such runs: damped steps creep.
const STILL: f64 = 1e-3;
/// Factors of `λ` tried when a curve crosses itself.
pub(super) const SMOOTHER: [f64; 4] = [4.0, 16.0, 64.0, 256.0];

/// Fits a curve to points of which nothing else is known, or from a given start.
///
/// Order, closure, the first curve, the smoothing and the number of control points are found where they are not given;
/// points that are not finite are left out and counted. The result is a local minimum of the orthogonal distances from
/// the start.
///
/// ```
/// use nalgebra::Vector2;
/// use sdm_fit::curve::{CurveOptions, fit_curve};
///
/// let at = |i: usize| std::f64::consts::TAU * (i * 37 % 100) as f64 / 100.0;
/// let shuffled: Vec<_> = (0..100).map(|i| Vector2::new(2.0 * at(i).cos(), at(i).sin())).collect();
/// let options = CurveOptions::default().with_abs_tolerance(Some(1e-4));
/// let fitted = fit_curve(&shuffled, None, &options)?;
/// assert!(fitted.report.closed && fitted.report.max <= 1e-4);
/// # Ok::<(), sdm_fit::Error>(())
/// ```
///
/// # Errors
/// Input from which no curve can be computed: see [`Error`]. Not converging and tolerances that are not reached are
/// told by the report.
pub fn fit_curve<const D: usize>(
    points: &[SVector<f64, D>],
    start: Option<&BsplineCurve<D>>,
    options: &CurveOptions,
) -> Result<CurveFit<D>, Error> {
    fit_curve_with_progress(points, start, options, &no_progress)
}

/// [`fit_curve`] with a callback after each iteration, which may cancel.
///
/// # Errors
/// As for [`fit_curve`].
pub fn fit_curve_with_progress<const D: usize>(
    points: &[SVector<f64, D>],
    start: Option<&BsplineCurve<D>>,
    options: &CurveOptions,
    progress: Progress<'_>,
) -> Result<CurveFit<D>, Error> {
    options.check()?;
    let kept: Vec<usize> = (0..points.len()).filter(|&i| points[i].iter().all(|c| c.is_finite())).collect();
    let distinct = count_distinct(points, &kept);
    let needed = options.controls.unwrap_or(options.fewest()).max(2);
    let needed = start.map_or(needed, |curve| curve.knots().distinct_count());
    if distinct < needed {
        return Err(Error::TooFewPoints { total: points.len(), finite: distinct, needed });
    }
    let centre = centre(points, &kept);
    let local: Vec<SVector<f64, D>> = kept.iter().map(|&i| points[i] - centre).collect();
    let mut work = Work::new(&local, options, progress);
    let (state, layout, (closed, closure, kind)) = match start {
        Some(curve) => {
            let moved = curve.translated(&-centre)?;
            let closed = moved.knots().is_periodic();
            let moved = if options.search { work.grown(&moved)? } else { moved };
            let state = work.after_start(moved)?;
            let kind = if options.search { CurveStart::Contour } else { CurveStart::Given };
            (state, None, (closed, Closure::Start, kind))
        }
        None => {
            let layout = Layout::new(&local, options)?;
            let state = work.after_layout(&layout, distinct)?;
            let origin = (layout.closed, layout.closure, layout.kind);
            (state, Some(layout), origin)
        }
    };
    let mut state = work.polished(state)?;
    if options.rational {
        state = rational::with_weights(&mut work, state, layout.as_ref())?;
    }
    work.conclude(state, points, &kept, &centre, (closed, closure, kind))
}

/// A curve with what is known about it.
#[derive(Clone, Debug)]
pub(super) struct State<const D: usize> {
    pub(super) curve: BsplineCurve<D>,
    pub(super) report: FitReport,
    evolution: Vec<BsplineCurve<D>>,
}

/// The points and the runs of the loop on them.
pub(super) struct Work<'a, const D: usize> {
    pub(super) points: &'a [SVector<f64, D>],
    pub(super) options: &'a CurveOptions,
    pub(super) size: f64,
    progress: Progress<'a>,
    stages: Vec<StageRecord>,
    history: Vec<StepRecord>,
    evolution: Vec<BsplineCurve<D>>,
    pub(super) cancelled: bool,
    /// Whether each point keeps to the part of the curve that its foot is on, instead of looking for the nearest one: a curve that begins
    /// near to the path then stays on it.
    pub(super) follows: bool,
}

impl<'a, const D: usize> Work<'a, D> {
    fn new(points: &'a [SVector<f64, D>], options: &'a CurveOptions, progress: Progress<'a>) -> Self {
        let size = points.iter().map(|p| p.amax()).fold(0.0, f64::max);
        let (stages, history, evolution) = (Vec::new(), Vec::new(), Vec::new());
        Self { points, options, size, progress, stages, history, evolution, cancelled: false, follows: false }
    }

    /// One run of the loop on some of the points.
    pub(super) fn run_on(
        &mut self,
        points: &[SVector<f64, D>],
        curve: BsplineCurve<D>,
        fit: &FitOptions,
        stage: &'static str,
    ) -> Result<State<D>, Error> {
        let active = ActiveCurve::new(curve)?;
        let target = Target::Points { points, weights: None };
        let fitted = fit_with_progress(active.clone(), target, &Constraints::none(), fit, self.progress)?;
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
        if self.follows {
            // Knots are where the curve bends, and the number of control points is what noise limits: energy only bridges gaps.
            let smoothing = match fit.smoothing {
                Smoothing::Automatic { .. } => Smoothing::Fixed { lambda: adapt::COARSE },
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

    /// The start, grown inside the points until it meets them.
    fn grown(&mut self, start: &BsplineCurve<D>) -> Result<BsplineCurve<D>, Error> {
        if !start.knots().is_periodic() {
            return Err(Error::Option { name: "search", value: 1.0, allowed: "false (0) for open curves" });
        }
        let polygons = front::contours(self.points, Some(start), STAGES)?;
        let curves = polygons.iter().map(|nodes| front::through(nodes, start.knots()));
        let curves = curves.collect::<Result<Vec<_>, _>>()?;
        if self.options.fit.evolution {
            self.evolution.push(start.clone());
            self.evolution.extend_from_slice(&curves);
        }
        Ok(curves.last().unwrap_or(start).clone())
    }

    /// The fit from a given curve.
    fn after_start(&mut self, curve: BsplineCurve<D>) -> Result<State<D>, Error> {
        let (knots, net, weights) = curve.into_parts();
        // A rational start is taken for its polygon; weights come back with the option that asks for them.
        if weights.is_some() && !self.options.rational {
            return Err(Error::Rational);
        }
        let curve = BsplineCurve::new(knots, net, None)?;
        let crossed = !self_crossings(&curve).is_empty();
        let fit = self.loop_options();
        let state = self.run(curve.clone(), &fit, "fit")?;
        let state = self.uncrossed(state, &curve, crossed)?;
        let state = self.finished(state)?;
        self.keep(&state);
        if self.options.abs_tolerance.is_some() { adapt::to_tolerance(self, state) } else { Ok(state) }
    }

    /// The fit from the places of the points.
    fn after_layout(&mut self, layout: &Layout<D>, distinct: usize) -> Result<State<D>, Error> {
        let degree = self.options.degree;
        if let Some(controls) = self.options.controls {
            let fit = self.loop_options();
            let state = self.with_controls(layout, controls, &fit)?;
            self.keep(&state);
            return Ok(state);
        }
        if self.options.abs_tolerance.is_some() {
            return self.within_tolerance(layout, distinct.min(self.options.max_controls).max(degree + 1));
        }
        adapt::by_noise(self, layout, distinct)
    }

    /// The fit to the tolerance: from few control points, and where that crosses itself, once more from a curve that is near to the
    /// path already, and stays there.
    fn within_tolerance(&mut self, layout: &Layout<D>, most: usize) -> Result<State<D>, Error> {
        let coarse = adapt::coarse(self);
        let state = self.with_controls(layout, (self.options.degree + 5).min(most), &coarse)?;
        self.keep(&state);
        let state = adapt::to_tolerance(self, state)?;
        let crossings = self_crossings(&state.curve).len();
        if crossings == 0 || self.cancelled {
            return Ok(state);
        }
        let limit = FOLLOWED_FROM * self.options.abs_tolerance.unwrap_or(0.0);
        let limit = limit.max(layout.scatter(self.points));
        let Some(curve) = layout.faithful(self.options.degree, most, limit)? else { return Ok(state) };
        let kept = (std::mem::take(&mut self.history), std::mem::take(&mut self.evolution));
        let first: Vec<bool> = self.stages.iter_mut().map(|s| std::mem::take(&mut s.kept)).collect();
        self.follows = true;
        let other = self.run(curve, &adapt::coarse(self), "path")?;
        self.keep(&other);
        let other = adapt::to_tolerance(self, other)?;
        if self_crossings(&other.curve).len() < crossings {
            return Ok(other);
        }
        self.follows = false;
        (self.history, self.evolution) = kept;
        let first = first.into_iter().chain(std::iter::repeat(false));
        self.stages.iter_mut().zip(first).for_each(|(stage, kept)| stage.kept = kept);
        Ok(state)
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
        let crossed = !self_crossings(&curve).is_empty();
        let state = self.run(curve.clone(), fit, "fit")?;
        let state = self.uncrossed(state, &curve, crossed)?;
        let lost =
            state.report.status == Status::Diverged || !self_crossings(&state.curve).is_empty() && !crossed;
        if !(lost && layout.closed) || self.cancelled {
            return self.finished(state);
        }
        let curve = layout.as_ellipse().curve(self.options.degree, controls)?;
        let other = self.run(curve.clone(), fit, "fit")?;
        let other = self.uncrossed(other, &curve, false)?;
        let better = self_crossings(&other.curve).is_empty() && other.report.status != Status::Diverged;
        self.finished(if better { other } else { state })
    }

    fn conclude(
        self,
        state: State<D>,
        points: &[SVector<f64, D>],
        kept: &[usize],
        centre: &SVector<f64, D>,
        (closed, closure, start): (bool, Closure, CurveStart),
    ) -> Result<CurveFit<D>, Error> {
        let projector = CurveProjector::new(&state.curve);
        let found = projector.project_all(self.points);
        let nothing = PointFoot { parameter: f64::NAN, foot: SVector::repeat(f64::NAN), distance: f64::NAN };
        let mut feet = vec![nothing; points.len()];
        let (mut sum, mut max, mut max_index) = (0.0, 0.0, 0);
        for (&index, foot) in kept.iter().zip(&found) {
            feet[index] =
                PointFoot { parameter: foot.parameter, foot: foot.point + centre, distance: foot.distance };
            sum += foot.distance * foot.distance;
            if foot.distance > max {
                (max, max_index) = (foot.distance, index);
            }
        }
        let tolerance = self.options.abs_tolerance;
        let within = |limit: f64| found.iter().filter(|foot| foot.distance <= limit).count() as f64;
        let reached = tolerance.map(|limit| max <= limit);
        let report = CurveReport {
            status: state.report.status.within(reached == Some(true)),
            closed,
            closure,
            start,
            points: points.len(),
            dropped: points.len() - kept.len(),
            used: state.report.used,
            controls: state.curve.knots().distinct_count(),
            degree: state.curve.degree(),
            rms: (sum / kept.len() as f64).sqrt(),
            max,
            max_index,
            tolerance,
            share_within: tolerance.map(|limit| within(limit) / kept.len() as f64),
            reached,
            lambda: state.report.lambda,
            iterations: self.stages.iter().map(|stage| stage.iterations).sum(),
            crossings: self_crossings(&state.curve),
            stages: self.stages,
            history: self.history,
        };
        let evolution = self.evolution.iter().map(|c| c.translated(centre)).collect::<Result<_, _>>()?;
        Ok(CurveFit { curve: state.curve.translated(centre)?, report, feet, evolution })
    }
}
