//! From points to a curve: start, control points, tolerance, weights.

use super::adapt;
use super::attempt::from_cloud;
use super::conclude::{Cloud, Origin};
use super::front;
use super::options::CurveOptions;
use super::places::{centre, count_distinct, without_astray};
use super::rational;
use super::report::{Closure, CurveFit, CurveStart};
use super::work::{State, Work};
use crate::Error;
use crate::iterate::{Progress, no_progress};
use nalgebra::SVector;
use nurbs_core::BsplineCurve;

/// Contours of a search that are kept.
const STAGES: usize = 8;

/// Fits a curve to points of which nothing else is known, or from a given start.
///
/// Order, closure, the first curve, the smoothing and the number of control points are found where they are not given;
/// points that are not finite are left out and counted. The result is a local minimum of the orthogonal distances from
/// the start, and whether it stays with the points, in both directions, is told by [`covered`](super::CurveReport::covered). Points on several curves are
/// an error; [`fit_curves`](super::fit_curves()) fits them all.
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
    if !options.search {
        return fitted(points, start, options, progress);
    }
    // A search takes the place of the fit from where it would start anyway only if it is better.
    let found = fitted(points, start, options, progress)?;
    if found.report.status == crate::Status::Cancelled {
        return Ok(found);
    }
    match fitted(points, start, &options.with_search(false), progress) {
        Ok(plain) if plain.report.is_better_than(&found.report) => Ok(plain),
        _ => Ok(found),
    }
}

fn fitted<const D: usize>(
    points: &[SVector<f64, D>],
    start: Option<&BsplineCurve<D>>,
    options: &CurveOptions,
    progress: Progress<'_>,
) -> Result<CurveFit<D>, Error> {
    let finite = (0..points.len()).filter(|&i| points[i].iter().all(|c| c.is_finite())).collect();
    let (kept, astray) = without_astray(points, finite);
    let distinct = count_distinct(points, &kept);
    let needed = options.controls.unwrap_or(options.fewest()).max(2);
    let needed = start.map_or(needed, |curve| curve.knots().distinct_count());
    if distinct < needed {
        return Err(Error::TooFewPoints { total: points.len(), finite: distinct, needed });
    }
    let centre = centre(points, &kept);
    let local: Vec<SVector<f64, D>> = kept.iter().map(|&i| points[i] - centre).collect();
    let cloud = Cloud { points, kept: &kept, astray: &astray, local: &local, centre };
    let Some(curve) = start else { return from_cloud(&cloud, distinct, options, progress) };
    let mut work = Work::new(&local, options, progress);
    work.given = true;
    let moved = curve.translated(&-centre)?;
    let closed = moved.knots().is_periodic();
    let moved = if options.search { work.grown(&moved)? } else { moved };
    let state = work.after_start(moved)?;
    let mut state = work.polished(state)?;
    if options.rational {
        state = rational::with_weights(&mut work, state, None)?;
    }
    let state = if closed { state } else { work.with_ends(state, &centre)? };
    let state = work.settled(state);
    let kind = if options.search { CurveStart::Contour } else { CurveStart::Given };
    work.conclude(state, &cloud, Origin { closed, closure: Closure::Start, start: kind, lost: false })
}

impl<const D: usize> Work<'_, D> {
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
        let crossed = self.crossings(&curve) > 0;
        let fit = self.loop_options().with_smoothing(self.gentle(&curve)?);
        let state = self.run(curve.clone(), &fit, "fit")?;
        let state = self.uncrossed(state, &curve, crossed)?;
        let state = self.finished(state)?;
        self.keep(&state);
        if self.options.abs_tolerance.is_some() { adapt::to_tolerance(self, state) } else { Ok(state) }
    }
}
