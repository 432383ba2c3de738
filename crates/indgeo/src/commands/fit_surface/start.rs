//! Surfaces from clouds of which nothing is known: base surface, parameters, least squares, squared distances.

use crate::commands::fit_surface::conclusion::{concluded, diagonal, in_crowds};
use crate::commands::fit_surface::finish::{HARMLESS, extended, finished};
use crate::commands::fit_surface::judgement::{Judgement, WILD};
use crate::report::Report;
use crate::report::wording::counted;
use industrial_geometry::cloud_param::{
    Error as ParameterError, FinishOutcome, FitOptions, Parameterisation, ParameteriseOptions,
    ParameteriseReport, Shape, consistent, finish_options, fit_parameters, parameterise,
};
use industrial_geometry::fit::{
    BaseShape, Error, Folds, Progress, Robust, Smoothing, Status, SurfaceCoverage, SurfaceDistances,
    SurfaceOptions, SurfaceReport, fit_cloud_with_progress, fit_surface_with_progress,
};
use industrial_geometry::nurbs::BsplineSurface;
use industrial_geometry::nurbs::nalgebra::Vector3;
use serde::Serialize;
use std::path::Path;

/// How much residuals of neighbours differ, 1 where they have nothing to do with each other, from which on more control points have nothing
/// to follow.
pub(crate) const NOISE: f64 = 0.8;
/// Root mean square distance, as a share of the diagonal, that needs no more control points: points of a file without noise leave it; share of it that more of them must leave at
/// most; most control points that are chosen, and fewest points for each.
const SMALL: f64 = 1e-4;
const LESS: f64 = 0.85;
const MOST_CHOSEN: usize = 4000;
const PER_CONTROL: usize = 4;
/// Share of the points far away that more of them must leave at most otherwise.
const FEWER_FAR: f64 = 0.5;
/// Share of the distance before that a surface on which the points lie exactly leaves at most.
const EXACT: f64 = 0.05;
/// Control points up to which the data are asked for the smoothing, and those of which it is taken for more.
const ASKED: usize = 2500;
const FEWER: usize = 1600;
/// First factor of an energy that vanishes, from a surface that is near, and its factor in each iteration.
const VANISHING: [f64; 2] = [1e-6, 0.1];
/// Distance from a base surface, in spacings, by which an outlier does not draw it far to itself.
const ROUGH: f64 = 1.0;
/// How often outliers are told anew by the surface without them.
const ROUNDS: usize = 3;

/// A fitted surface, how it went, and where it began.
pub(crate) type Found = (BsplineSurface, SurfaceReport, Start);

/// Where a fit began.
#[derive(Debug, Serialize)]
pub(crate) struct Start {
    /// Why this kind of surface; or why there was no base surface, and a simple shape gave the parameters.
    pub(crate) why: String,
    /// Root mean square distance from the base surface, if there was one.
    pub(crate) base_rms: Option<f64>,
    /// Root mean square distance from the least squares surface, if there was one.
    pub(crate) least_squares_rms: Option<f64>,
    /// What became of it.
    pub(crate) outcome: Option<FinishOutcome>,
    /// Distance of the points from each other, if there was a base surface.
    pub(crate) spacing: Option<f64>,
    /// Whether the points are of no kind for which the first parameters are known to be right.
    pub(crate) doubtful: bool,
    /// Points that do not count: apart from the others.
    pub(crate) strays: usize,
    /// Points that do not count: beyond the ends of the base surface.
    pub(crate) beyond_ends: usize,
    /// Points that are on no part of the surface, whether they were used or not; the largest distance of one of them.
    pub(crate) far: usize,
    pub(crate) far_max: f64,
    /// Whether the points are farther from the surface than from each other, and neighbours alike: it does not follow them.
    pub(crate) unresolved: bool,
    /// Points that were left out as outliers but lie together.
    pub(crate) missed: usize,
}

impl Start {
    fn simple(why: String) -> Self {
        Self {
            why,
            base_rms: None,
            least_squares_rms: None,
            outcome: None,
            spacing: None,
            doubtful: false,
            strays: 0,
            beyond_ends: 0,
            far: 0,
            far_max: 0.0,
            unresolved: false,
            missed: 0,
        }
    }

    fn base(found: &ParameteriseReport) -> Self {
        Self {
            why: found.shape.why.clone(),
            base_rms: Some(found.rms),
            spacing: Some(found.spacing),
            strays: found.strays,
            beyond_ends: found.beyond_ends,
            ..Self::simple(String::new())
        }
    }

    /// What is wrong with the distances of the points.
    pub(crate) fn judgement(&self) -> Judgement {
        Judgement { far: self.far, far_max: self.far_max, unresolved: self.unresolved, missed: self.missed }
    }

    /// Says which points do not count, and what was kept.
    pub(crate) fn warn(&self, path: &Path, report: &mut Report) {
        let name = path.display();
        for (count, what) in [
            (self.strays, "apart from the others"),
            (self.beyond_ends, "beyond the ends of the base surface"),
        ] {
            if count > 0 {
                report.warnings.push(format!("{name}: {} {what}: not used", counted(count, "point")));
            }
        }
        if self.doubtful {
            report
                .warnings
                .push(format!("{name}: whether the surface is right must be looked at; {}", self.why));
        }
        if matches!(self.outcome, Some(FinishOutcome::KeptSinceFolded | FinishOutcome::KeptSinceNoNearer)) {
            report.warnings.push(
                "minimising the distances made the least squares surface fold, or no better; it was kept as it is"
                    .to_owned(),
            );
        }
    }
}

/// Why there is no surface.
#[derive(Debug)]
pub(crate) enum Refusal {
    /// The fit failed.
    Fit(Error),
    /// The points are not of the kind that was asked for, or not one surface.
    Points(ParameterError),
}

impl From<Error> for Refusal {
    fn from(error: Error) -> Self {
        Self::Fit(error)
    }
}

/// Fits a surface: over a base surface that follows the points where there is one, otherwise over a simple shape. Without `chosen` numbers of
/// control points there are as many as the points ask for.
pub(crate) fn from_cloud(
    points: &[Vector3<f64>],
    options: &SurfaceOptions,
    chosen: bool,
    progress: Progress<'_>,
) -> Result<Found, Refusal> {
    let used = match options.fit.robust {
        Robust::None => points.to_vec(),
        _ => in_crowds(points).map_err(Refusal::Points)?,
    };
    let (surface, report, start) = begun(&used, options, chosen, progress)?;
    concluded(points, surface, report, start, options)
}

fn begun(
    points: &[Vector3<f64>],
    options: &SurfaceOptions,
    chosen: bool,
    progress: Progress<'_>,
) -> Result<Found, Refusal> {
    let simple = |why: &str| -> Result<Found, Refusal> {
        let found = fit_cloud_with_progress(points, &options.with_coverage(false), progress)?;
        Ok((found.surface, found.report, Start::simple(why.to_owned())))
    };
    if options.rational {
        return simple("weights are for simple shapes, which give the first parameters");
    }
    let shape = match options.base {
        BaseShape::Auto => Shape::Auto,
        BaseShape::Plane => Shape::Plane,
        BaseShape::Cylinder => Shape::Cylinder,
        BaseShape::Sphere => Shape::Sphere,
        BaseShape::Torus => return simple("it was asked for"),
    };
    match over_base_surface(points, shape, options, chosen, progress) {
        Ok(found) => Ok(found),
        Err(ParameterError::Fit(error)) => Err(error.into()),
        // The simple shapes ask for less.
        Err(error @ ParameterError::TooFewPoints { .. }) => {
            simple(&format!("a simple shape gave the first parameters: {error}"))
        }
        // Of no kind that is known, but one surface: the nearest of the simple shapes, which need not be right.
        Err(error @ ParameterError::Shape { .. }) if shape == Shape::Auto && !is_none(&error) => {
            let (surface, report, mut start) =
                simple(&format!("a simple shape gave the first parameters: {error}"))?;
            start.doubtful = true;
            Ok((surface, report, start))
        }
        Err(error) => Err(Refusal::Points(error)),
    }
}

/// Whether the points are not those of one surface.
fn is_none(error: &ParameterError) -> bool {
    matches!(error, ParameterError::Shape { wanted: "one surface" | "a surface", .. })
}

fn over_base_surface(
    points: &[Vector3<f64>],
    shape: Shape,
    options: &SurfaceOptions,
    chosen: bool,
    progress: Progress<'_>,
) -> Result<Found, ParameterError> {
    let choice = ParameteriseOptions::default().with_shape(shape);
    let mut found = parameterise(points, &choice)?;
    if options.fit.robust != Robust::None {
        // Outliers draw the base surface to themselves, and make its domain wider.
        let agree = consistent(points, &found.feet, &found.counts, ROUGH)?;
        if agree != found.counts {
            let nowhere = Vector3::repeat(f64::NAN);
            let kept: Vec<Vector3<f64>> =
                points.iter().zip(&agree).map(|(p, agree)| if *agree { *p } else { nowhere }).collect();
            let (dropped, strays) = (found.report.dropped, found.report.strays);
            found = parameterise(&kept, &choice)?;
            (found.report.dropped, found.report.strays) = (dropped, strays);
        }
    }
    let mut size = options.size;
    let mut best = fitted_over(points, &found, &options.with_size(size), progress)?;
    if chosen || options.abs_tolerance.is_some() {
        return Ok(best);
    }
    // More control points, as long as what is left of the distances is not noise, in the mean and everywhere, and they make it much less.
    let diagonal = diagonal(points);
    let mut leaves = what_is_left(points, &best.0, options.fit.robust)?;
    loop {
        let left = best.1.fit.rms;
        size.controls = size.controls.map(|n| n + n.div_ceil(2));
        let unknowns = size.controls[0] * size.controls[1];
        if left <= SMALL * diagonal
            || unknowns > MOST_CHOSEN
            || PER_CONTROL * unknowns > points.len()
            || best.1.fit.status == Status::Cancelled
            || leaves.is_noise && leaves.far == 0
        {
            return Ok(best);
        }
        let next = fitted_over(points, &found, &options.with_size(size), progress)?;
        let is_good = next.1.folds.count() <= best.1.folds.count() && next.1.fit.status != Status::Cancelled;
        let then = what_is_left(points, &next.0, options.fit.robust)?;
        let is_less = next.1.fit.rms <= LESS * left || (then.far as f64) < FEWER_FAR * leaves.far as f64;
        if !is_good || !is_less {
            return Ok(best);
        }
        (best, leaves) = (next, then);
    }
}

/// What a surface leaves of the distances of points.
struct Left {
    /// Whether neighbours have nothing in common.
    is_noise: bool,
    /// Points that count and are farther away than noise would leave one of them: a detail that the surface does not resolve.
    far: usize,
}

fn what_is_left(points: &[Vector3<f64>], surface: &BsplineSurface, robust: Robust) -> Result<Left, Error> {
    let found = SurfaceDistances::of(surface, points, robust)?;
    let limit = WILD * SurfaceCoverage::noise_of(&found.distances);
    let far = found.distances.iter().zip(&found.weights).filter(|(d, w)| **w > 0.0 && **d > limit).count();
    Ok(Left { is_noise: found.disagreement >= NOISE, far })
}

/// The surface of a size with the parameters of a base surface.
fn fitted_over(
    points: &[Vector3<f64>],
    found: &Parameterisation,
    options: &SurfaceOptions,
    progress: Progress<'_>,
) -> Result<Found, ParameterError> {
    let mut start = Start::base(&found.report);
    let fit = FitOptions {
        control_points: options.size.controls,
        degrees: options.size.degrees,
        ..FitOptions::default()
    };
    let mut counts = found.counts.clone();
    let mut least_squares = fit_parameters(points, &found.base, &found.feet, &counts, &fit)?;
    if options.fit.robust != Robust::None {
        // Outliers have drawn the base surface to themselves, and may have hidden others.
        for _ in 0..ROUNDS {
            let again = least_squares.consistent(points, &found.counts, HARMLESS)?;
            if again == counts {
                break;
            }
            counts = again;
            least_squares = fit_parameters(points, &found.base, &found.feet, &counts, &fit)?;
        }
    }
    start.least_squares_rms = Some(least_squares.rms);
    let like_finish = finish_options(points.len());
    let near = options.with_coverage(false).with_fit(match options.fit.smoothing {
        Smoothing::Automatic { .. } => match smoothing_of_fewer(points, found, options, progress)? {
            Some(lambda) => options.fit.with_smoothing(Smoothing::Fixed { lambda }),
            None => options.fit.with_smoothing(like_finish.fit.smoothing),
        },
        // The least squares surface is near: there is no need to come down from a large energy.
        Smoothing::Continuation { floor, .. } if floor > 0.0 => {
            options.fit.with_smoothing(Smoothing::Fixed { lambda: floor })
        }
        Smoothing::Continuation { .. } => options.fit.with_smoothing(Smoothing::Continuation {
            start: VANISHING[0],
            factor: VANISHING[1],
            floor: 0.0,
        }),
        Smoothing::Fixed { .. } => options.fit,
    });
    let base = match found.report.shape.shape {
        Shape::Plane => BaseShape::Plane,
        Shape::Sphere => BaseShape::Sphere,
        _ => BaseShape::Cylinder,
    };
    let (surface, mut report) = if options.abs_tolerance.is_some() {
        let used = points.iter().zip(&counts).filter(|(_, counts)| **counts);
        let data: Vec<Vector3<f64>> = used.map(|(p, _)| *p).collect();
        let fitted = fit_surface_with_progress(&data, least_squares.surface, &near, progress)?;
        (fitted.surface, fitted.report)
    } else {
        let near = near
            .with_unfoldings(like_finish.unfoldings)
            .with_exact(like_finish.exact)
            .with_fit(near.fit.with_damping(like_finish.fit.damping));
        let (done, finish) = finished(points, (found, &mut counts), least_squares, &near, progress)?;
        let (mut done, finish) = if found.report.beyond_ends > 0 && finish.outcome != FinishOutcome::Cancelled
        {
            extended(points, &mut counts, (done, finish), &near, progress)?
        } else {
            (done, finish)
        };
        start.outcome = Some(finish.outcome);
        let mut report = finish.minimisation;
        if finish.rms[1] <= SMALL * diagonal(points) && report.fit.status != Status::Cancelled {
            // Hardly any distance is left: without the energy the surface may be exact.
            let data: Vec<Vector3<f64>> =
                points.iter().zip(&counts).filter(|(_, c)| **c).map(|(p, _)| *p).collect();
            let exact = near
                .with_exact(true)
                .with_fit(near.fit.with_smoothing(Smoothing::NONE).with_max_iterations(1));
            let made = fit_surface_with_progress(&data, done.surface.clone(), &exact, progress)?;
            if made.report.fit.rms <= EXACT * finish.rms[1]
                && made.report.folds.count() <= Folds::of(&done.surface).count()
            {
                done.surface = made.surface;
                report.fit.lambda = 0.0;
                report.fit.status = Status::Converged;
                report.fit.history.extend(made.report.fit.history);
                (1..).zip(&mut report.fit.history).for_each(|(number, step)| step.iteration = number);
            }
        }
        if finish.outcome.is_new() {
            report.fit.rms = finish.rms[1];
        } else {
            // The surface that is left is not that of the minimisation, whose steps and smoothing have no part in it.
            report.fit.rms = finish.rms[0];
            report.fit.lambda = 0.0;
            report.fit.history = Vec::new();
            report.runs = 0;
        }
        (done.surface, report)
    };
    report.controls = [surface.knots_u().distinct_count(), surface.knots_v().distinct_count()];
    report.folds = Folds::of(&surface);
    report.base = Some(base);
    report.dropped = found.report.dropped;
    Ok((surface, report, start))
}

/// The smoothing of a net of so many control points that the data are not asked for it, from a net of fewer: the energy is that of spans of
/// length 1, so that its factor grows with the fourth power of their number. `None` for nets of few, and with a tolerance.
fn smoothing_of_fewer(
    points: &[Vector3<f64>],
    found: &Parameterisation,
    options: &SurfaceOptions,
    progress: Progress<'_>,
) -> Result<Option<f64>, ParameterError> {
    let unknowns = options.size.controls[0] * options.size.controls[1];
    if unknowns <= ASKED || options.abs_tolerance.is_some() {
        return Ok(None);
    }
    let share = (FEWER as f64 / unknowns as f64).sqrt();
    let mut size = options.size;
    for (controls, degree) in size.controls.iter_mut().zip(size.degrees) {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "less than a count")]
        let fewer = (*controls as f64 * share).round() as usize;
        *controls = fewer.clamp(degree + 1, *controls);
    }
    let fewer = (size.controls[0] * size.controls[1]) as f64;
    if fewer > ASKED as f64 {
        return Ok(None);
    }
    let (_, report, _) = fitted_over(points, found, &options.with_size(size), progress)?;
    Ok(Some(report.fit.lambda * (unknowns as f64 / fewer).powi(2)))
}
