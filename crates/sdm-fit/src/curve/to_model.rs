//! Curves fitted to models: distances from sensor points of the curve, orthogonal to the model.

use super::active::ActiveCurve;
use super::conclude::{Cloud, Origin};
use super::fit::fit_curve_with_progress;
use super::options::CurveOptions;
use super::places::{centre, without_astray};
use super::report::{Closure, CurveFit, CurveStart};
use super::work::{State, Work};
use crate::iterate::{Progress, fit_with_progress, no_progress};
use crate::{Constraints, Error, Smoothing, Target};
use distance_field::DistanceField;
use nalgebra::SVector;
use nurbs_core::BsplineCurve;

/// Energy with which a curve begins that is near to a model, the factor by which it becomes less, and where that ends: a model has no noise from which it
/// would follow how smooth the curve has to be.
const FIRST: f64 = 1e-5;
const LESS: f64 = 0.25;
const LEAST: f64 = 1e-9;
/// Length by which the curve may go on beyond the model, or jump from one of its curves to the next, as a share of the size, where none is given.
const BEYOND: f64 = 0.01;

/// Fits a curve to a model, given by its distance field (\[P05, sec. 4.1\]).
///
/// Sensor points, so many in each span of the curve, have quadratic models of the squared distance from the model; their sum and the energy are
/// minimised in the control points, and again. `samples` are points all along the model: without a start the curve begins with the one fitted to them, and
/// distances, coverage and feet of the result are theirs. Energies that are to follow from the data fall to a trifle instead.
///
/// ```
/// use distance_field::CurveField;
/// use nalgebra::Vector2;
/// use nurbs_core::{BsplineCurve, KnotVector, ParametricCurve};
/// use sdm_fit::curve::{CurveOptions, fit_curve_to_model};
///
/// let corners = [[0.0, 0.0], [1.0, 2.0], [3.0, 2.0], [4.0, 0.0], [6.0, 1.0]].map(Vector2::from);
/// let model = BsplineCurve::new(KnotVector::uniform_clamped(2, 5)?, corners.to_vec(), None)?;
/// let samples: Vec<_> = (0..2000).map(|k| model.point(f64::from(k) / 1999.0)).collect();
/// let options = CurveOptions::default().with_controls(Some(9));
/// let found = fit_curve_to_model(&CurveField::new(&model)?, &samples, None, 6, &options)?;
/// assert!(found.report.covered && found.report.max < 0.02, "{}", found.report);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As for [`fit_curve`](super::fit_curve()) and [`fit`](crate::fit()); [`Error::Rational`] for a start with weights.
pub fn fit_curve_to_model<const D: usize>(
    field: &dyn DistanceField<D>,
    samples: &[SVector<f64, D>],
    start: Option<&BsplineCurve<D>>,
    sensors: usize,
    options: &CurveOptions,
) -> Result<CurveFit<D>, Error> {
    fit_curve_to_model_with_progress(field, samples, start, sensors, options, &no_progress)
}

/// [`fit_curve_to_model`] with a callback after each iteration, which may cancel.
///
/// # Errors
/// As for [`fit_curve_to_model`].
pub fn fit_curve_to_model_with_progress<const D: usize>(
    field: &dyn DistanceField<D>,
    samples: &[SVector<f64, D>],
    start: Option<&BsplineCurve<D>>,
    sensors: usize,
    options: &CurveOptions,
    progress: Progress<'_>,
) -> Result<CurveFit<D>, Error> {
    options.check()?;
    let curve = match start {
        Some(curve) => curve.clone(),
        None => fit_curve_with_progress(samples, None, options, progress)?.curve,
    };
    if curve.weights().is_some() {
        return Err(Error::Rational);
    }
    let fit = match options.fit.smoothing {
        Smoothing::Automatic { .. } => {
            options.fit.with_smoothing(Smoothing::Continuation { start: FIRST, factor: LESS, floor: LEAST })
        }
        _ => options.fit,
    };
    let closed = curve.knots().is_periodic();
    let target = Target::Model { field, sensors, boundary: true };
    let held = ends_held(&curve);
    let fitted = fit_with_progress(ActiveCurve::new(curve)?, target, &held, &fit, progress)?;
    let finite = (0..samples.len()).filter(|&i| samples[i].iter().all(|c| c.is_finite())).collect();
    let (kept, astray) = without_astray(samples, finite);
    let centre = centre(samples, &kept);
    let local: Vec<SVector<f64, D>> = kept.iter().map(|&i| samples[i] - centre).collect();
    let cloud = Cloud { points: samples, kept: &kept, astray: &astray, local: &local, centre };
    let size = local.iter().map(|p| p.amax()).fold(0.0, f64::max);
    let options = options.with_max_gap(options.max_gap.or((size > 0.0).then_some(BEYOND * size)));
    let mut work = Work::new(&local, &options, progress);
    work.given = true;
    let curve = fitted.shape.into_curve().translated(&-centre)?;
    let state = State { curve, report: fitted.report, evolution: Vec::new() };
    work.note(&state, "model");
    work.keep(&state);
    work.conclude(
        state,
        &cloud,
        Origin { closed, closure: Closure::Start, start: CurveStart::Given, lost: false },
    )
}

/// The ends of an open curve stay where they are: nothing in the distances from a model keeps a curve from becoming a piece of it.
fn ends_held<const D: usize>(curve: &BsplineCurve<D>) -> Constraints<D> {
    let points = curve.control_points();
    match points {
        [first, .., last] if !curve.knots().is_periodic() => {
            Constraints::none().with_held(0, *first).with_held(points.len() - 1, *last)
        }
        _ => Constraints::none(),
    }
}
