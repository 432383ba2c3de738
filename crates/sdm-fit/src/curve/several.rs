//! Clouds that consist of several curves.

use super::fit::fit_curve_with_progress;
use super::options::CurveOptions;
use super::places::{centre, without_astray};
use super::report::CurveFit;
use super::start::{members, paths};
use crate::Error;
use crate::iterate::{Progress, no_progress};
use nalgebra::SVector;

/// One of the curves on which points lie.
#[derive(Clone, Debug)]
pub struct CurvePart<const D: usize> {
    /// Indices of its points.
    pub points: Vec<usize>,
    /// The curve, its report and the feet of its points.
    pub fit: CurveFit<D>,
}

/// Fits as many curves to points as these lie on, each with [`fit_curve`](super::fit_curve()).
///
/// Points belong to several curves where they are much further apart than neighbours are elsewhere. A point belongs to the curve whose path is
/// nearest; points that are not finite belong to none, points far away from all others to the first.
///
/// ```
/// use nalgebra::Vector2;
/// use sdm_fit::curve::{CurveOptions, fit_curves};
///
/// let at = |i: usize, n: usize| std::f64::consts::TAU * (i * 37 % n) as f64 / n as f64;
/// let ring = |n: usize, r: f64| (0..n).map(move |i| Vector2::new(r * at(i, n).cos(), r * at(i, n).sin()));
/// let points: Vec<_> = ring(90, 5.0).chain(ring(40, 2.0)).collect();
/// let curves = fit_curves(&points, &CurveOptions::default())?;
/// assert_eq!(curves.len(), 2);
/// assert!(curves.iter().all(|c| c.fit.report.closed && c.fit.report.covered));
/// # Ok::<(), sdm_fit::Error>(())
/// ```
///
/// # Errors
/// As for [`fit_curve`](super::fit_curve()).
pub fn fit_curves<const D: usize>(
    points: &[SVector<f64, D>],
    options: &CurveOptions,
) -> Result<Vec<CurvePart<D>>, Error> {
    fit_curves_with_progress(points, options, &no_progress)
}

/// [`fit_curves`] with a callback after each iteration, which may cancel.
///
/// # Errors
/// As for [`fit_curves`].
pub fn fit_curves_with_progress<const D: usize>(
    points: &[SVector<f64, D>],
    options: &CurveOptions,
    progress: Progress<'_>,
) -> Result<Vec<CurvePart<D>>, Error> {
    let finite: Vec<usize> = (0..points.len()).filter(|&i| points[i].iter().all(|c| c.is_finite())).collect();
    match fit_curve_with_progress(points, None, options, progress) {
        Err(Error::SeveralParts { .. }) => {}
        whole => return whole.map(|fit| vec![CurvePart { points: finite, fit }]),
    }
    let (kept, astray) = without_astray(points, finite);
    let centre = centre(points, &kept);
    let local: Vec<SVector<f64, D>> = kept.iter().map(|&i| points[i] - centre).collect();
    let paths = paths(&local, options);
    let of_points = |set: Vec<usize>| set.into_iter().map(|k| kept[k]).collect();
    let mut sets: Vec<Vec<usize>> = members(&local, &paths).into_iter().map(of_points).collect();
    if let Some(first) = sets.first_mut() {
        first.extend(astray);
        first.sort_unstable();
    }
    let fitted = sets.into_iter().map(|set| {
        let own: Vec<SVector<f64, D>> = set.iter().map(|&i| points[i]).collect();
        fit_curve_with_progress(&own, None, options, progress).map(|fit| CurvePart { points: set, fit })
    });
    fitted.collect()
}
