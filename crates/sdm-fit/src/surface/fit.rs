//! Surfaces fitted to clouds.

use super::apart::{kept, with_apart};
use super::base_shape::BaseShape;
use super::conic_starts::conic_starts;
use super::folds::Folds;
use super::initial::initial_surface;
use super::judge::surface_frames;
use super::options::SurfaceOptions;
use super::rational::{EXACT, improved};
use super::report::{SurfaceFit, SurfaceReport};
use super::runs::{Outcome, Runs, share_within};
use super::tolerance::fit_to_tolerance;
use super::{ActiveSurface, InitialSurface};
use super::{given, held};
use crate::cloud_kind::{CloudKind, cloud_kind, measurable};
use crate::coverage_surface::{PieceWithData, SurfaceCoverage, noise_of};
use crate::iterate::{Progress, no_progress};
use crate::polish::may_vanish;
use crate::report::status_within;
use crate::{Error, FitReport, Status, Target};
use distance_field::PrincipalFrame;
use nalgebra::Vector3;
use nurbs_core::BsplineSurface;
use sdm_core::Robust;

/// Fits a surface to a cloud of which nothing is known (\[P05, sec. 4.2 and 4.4\]).
///
/// Points that are not finite are left out and counted.
///
/// ```
/// use nalgebra::Vector3;
/// use sdm_fit::{BaseShape, SurfaceOptions, fit_cloud};
///
/// // A tube that widens upwards.
/// let at = |i: usize| (i as f64 * 2.399_963, i as f64 / 1500.0);
/// let point = |(a, h): (f64, f64)| Vector3::new((1.0 + h * h) * a.cos(), (1.0 + h * h) * a.sin(), 3.0 * h);
/// let points: Vec<_> = (0..1500).map(at).map(point).collect();
/// let fit = fit_cloud(&points, &SurfaceOptions::default())?;
/// assert_eq!(fit.report.base, Some(BaseShape::Cylinder));
/// assert!(fit.surface.knots_u().is_periodic() && fit.report.fit.rms < 1e-3, "{}", fit.report);
/// # Ok::<(), sdm_fit::Error>(())
/// ```
///
/// # Errors
/// See [`initial_surface`] and [`fit`](crate::fit()).
pub fn fit_cloud(points: &[Vector3<f64>], options: &SurfaceOptions) -> Result<SurfaceFit, Error> {
    fit_cloud_with_progress(points, options, &no_progress)
}

/// [`fit_cloud`] with a callback after each iteration, which may cancel.
///
/// # Errors
/// As [`fit_cloud`].
pub fn fit_cloud_with_progress(
    points: &[Vector3<f64>],
    options: &SurfaceOptions,
    progress: Progress<'_>,
) -> Result<SurfaceFit, Error> {
    options.check()?;
    let belongs = measurable(points)?;
    let used = kept(points, &belongs);
    let what = match cloud_kind(&used)? {
        CloudKind::Curve => Some("along a curve"),
        CloudKind::Volume => Some("all through a volume"),
        CloudKind::Surface => None,
    };
    if let Some(what) = what {
        return Err(Error::Degenerate { shape: "a surface", what });
    }
    let InitialSurface { surface, base, .. } = initial_surface(&used, options.base, options.size)?;
    let conic = if options.rational { conic(&used, base, options, progress)? } else { None };
    let (base, mut found) = match conic {
        Some(found) => found,
        None => (base, fit_surface_with_progress(&used, surface, options, progress)?),
    };
    found = with_apart(points, &belongs, found, options);
    found.report.base = Some(base);
    found.report.dropped = points.iter().filter(|p| !p.iter().all(|c| c.is_finite())).count();
    Ok(found)
}

/// A surface of conic arcs, if one is exact: over the base that describes the points, or, if nobody chose it, over another one.
fn conic(
    points: &[Vector3<f64>],
    base: BaseShape,
    options: &SurfaceOptions,
    progress: Progress<'_>,
) -> Result<Option<(BaseShape, SurfaceFit)>, Error> {
    let mut bases = vec![base];
    if options.base == BaseShape::Auto {
        let others = [BaseShape::Cylinder, BaseShape::Plane, BaseShape::Sphere, BaseShape::Torus];
        bases.extend(others.into_iter().filter(|other| *other != base));
    }
    for (rank, base) in bases.into_iter().enumerate() {
        // One that is not the best need not exist.
        let starts = match conic_starts(points, base) {
            Ok(starts) => starts,
            Err(error) if rank == 0 => return Err(error),
            Err(_) => continue,
        };
        for start in starts {
            if start.control_points().len() > points.len() {
                continue;
            }
            let found =
                fit_surface_with_progress(points, start, &options.with_abs_tolerance(None), progress)?;
            let net = found.surface.control_points();
            let size = net.iter().map(|p| (p - net[0]).amax()).fold(0.0, f64::max);
            if found.report.fit.rms <= EXACT * size || found.report.fit.status == Status::Cancelled {
                return Ok(Some((base, within(found, options))));
            }
        }
    }
    Ok(None)
}

/// A fit that was made without a tolerance, judged by one.
fn within(mut found: SurfaceFit, options: &SurfaceOptions) -> SurfaceFit {
    if let Some(tolerance) = options.abs_tolerance {
        let share = share_within(&found.frames, tolerance);
        found.report.share_within = Some(share);
        found.report.within_tolerance = share >= options.share;
    }
    found
}

/// Fits a surface to points from where it is; `base` and `size` of the options are not looked at.
///
/// # Errors
/// As for [`fit`](crate::fit()); [`Error::Rational`] for a surface with weights, unless these are unknowns
/// ([`SurfaceOptions::rational`]).
pub fn fit_surface(
    points: &[Vector3<f64>],
    initial: BsplineSurface,
    options: &SurfaceOptions,
) -> Result<SurfaceFit, Error> {
    fit_surface_with_progress(points, initial, options, &no_progress)
}

/// [`fit_surface`] with a callback after each iteration, which may cancel.
///
/// # Errors
/// As [`fit_surface`].
pub fn fit_surface_with_progress(
    points: &[Vector3<f64>],
    initial: BsplineSurface,
    options: &SurfaceOptions,
    progress: Progress<'_>,
) -> Result<SurfaceFit, Error> {
    options.check()?;
    let finite = points.iter().all(|p| p.iter().all(|c| c.is_finite()));
    if finite {
        let belongs = measurable(points)?;
        if belongs.iter().any(|b| !b) {
            let found = fit_belonging(&kept(points, &belongs), initial, options, progress)?;
            return Ok(with_apart(points, &belongs, found, options));
        }
    }
    fit_belonging(points, initial, options, progress)
}

/// The fit to points that all belong to one shape.
fn fit_belonging(
    points: &[Vector3<f64>],
    initial: BsplineSurface,
    options: &SurfaceOptions,
    progress: Progress<'_>,
) -> Result<SurfaceFit, Error> {
    // Coordinates about the middle of the start, so that large ones lose nothing.
    let net = initial.control_points();
    let middle = net.iter().sum::<Vector3<f64>>() / net.len().max(1) as f64;
    let local: Vec<Vector3<f64>> = points.iter().map(|p| p - middle).collect();
    let target = Target::Points { points: &local, weights: None };
    let surface = initial.translated(&-middle)?;
    if options.rational && surface.weights().is_some() {
        let (found, status, steps) = improved(&local, surface, progress)?;
        let report = found.report(None, status, steps);
        let folds = Folds::of(&found.surface);
        return concluded(
            found.surface,
            found.frames,
            report,
            Run { runs: 1, folds },
            options,
            (&middle, &local),
        );
    }
    if surface.weights().is_none()
        && let Some((frames, report)) = given::exact(&local, &surface, &options.fit)?
    {
        let folds = Folds::of(&surface);
        return concluded(surface, frames, report, Run { runs: 0, folds }, options, (&middle, &local));
    }
    let mut begun = *options;
    begun.fit.smoothing = given::begun_at(&local, &ActiveSurface::new(surface.clone())?, &options.fit)?;
    let mut runs = Runs::new(target, &begun, progress);
    let mut outcome = match options.abs_tolerance {
        None => runs.run(surface)?,
        Some(tolerance) => fit_to_tolerance(&mut runs, surface, tolerance)?,
    };
    if options.exact && options.abs_tolerance.is_none() && may_vanish(options.fit.smoothing) {
        outcome = runs.polished(outcome, given::size_of(&local))?;
    }
    let Outcome { fitted, mut folds } = outcome;
    (1..).zip(&mut runs.history).for_each(|(number, step)| step.iteration = number);
    let mut report = FitReport { history: runs.history, initial_rms: runs.initial_rms, ..fitted.report };
    let (mut surface, mut frames) = (fitted.shape.into_surface(), fitted.frames);
    if options.rational && report.status != Status::Cancelled {
        let (found, status, steps) = improved(&local, surface.clone(), progress)?;
        if found.rms() < report.rms {
            report = found.report(Some(report), status, steps);
            (surface, frames) = (found.surface, found.frames);
            folds = Folds::of(&surface);
        }
    }
    concluded(surface, frames, report, Run { runs: runs.count, folds }, options, (&middle, &local))
}

/// What is known of a fit besides its last run.
pub(super) struct Run {
    pub(super) runs: usize,
    pub(super) folds: Folds,
}

/// The result in the coordinates of the points.
pub(super) fn concluded(
    mut surface: BsplineSurface,
    mut frames: Vec<PrincipalFrame<3>>,
    fit: FitReport,
    run: Run,
    options: &SurfaceOptions,
    (middle, local): (&Vector3<f64>, &[Vector3<f64>]),
) -> Result<SurfaceFit, Error> {
    let (coverage, trim) = if options.coverage && !local.is_empty() {
        let noise = noise_of(frames.iter().map(|f| f.distance.abs()).collect());
        let outliers = options.fit.robust != Robust::None;
        let found = if options.holds_some() {
            // Sides that are given are there without points.
            let data = held::with_sides(local, &surface, options.held)?;
            let coverage = SurfaceCoverage::of_surface(&surface, &data, noise, options.abs_tolerance)?;
            PieceWithData { coverage, trim: None, opened: None }
        } else {
            SurfaceCoverage::up_to_data(&surface, local, noise, options.abs_tolerance, outliers)?
        };
        if let Some(opened) = found.opened {
            // Feet keep their places; their parameters are those of the surface that is left.
            surface = opened;
            frames = surface_frames(&surface, local)?;
        }
        (Some(found.coverage), found.trim)
    } else {
        (None, None)
    };
    let share_within = options.abs_tolerance.map(|tolerance| share_within(&frames, tolerance));
    let within_tolerance = share_within.is_none_or(|share| share >= options.share);
    let status = status_within(fit.status, share_within.is_some() && within_tolerance);
    let report = SurfaceReport {
        fit: FitReport { status, ..fit },
        base: None,
        controls: [surface.knots_u().distinct_count(), surface.knots_v().distinct_count()],
        runs: run.runs,
        share_within,
        within_tolerance,
        folds: run.folds,
        coverage,
        trim,
        dropped: 0,
    };
    frames.iter_mut().for_each(|frame| frame.foot += middle);
    Ok(SurfaceFit { surface: surface.translated(middle)?, report, frames })
}
