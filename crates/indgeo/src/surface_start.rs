//! Surfaces from clouds of which nothing is known: base surface, parameters, least squares, squared distances.

use crate::report::Report;
use crate::wording::counted;
use industrial_geometry::cloud_param::{
    Error as ParameterError, FinishOutcome, FitOptions, ParameteriseOptions, ParameteriseReport, Shape,
    finish_fit_with_progress, finish_options, fit_parameters, parameterise,
};
use industrial_geometry::fit::{
    BaseShape, Error, Folds, Progress, Smoothing, SurfaceOptions, SurfaceReport, fit_cloud_with_progress,
    fit_surface_with_progress,
};
use industrial_geometry::nurbs::BsplineSurface;
use industrial_geometry::nurbs::nalgebra::Vector3;
use serde::Serialize;
use std::path::Path;

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
        }
    }

    fn base(found: &ParameteriseReport) -> Self {
        Self {
            why: found.shape.why.clone(),
            base_rms: Some(found.rms),
            least_squares_rms: None,
            outcome: None,
            spacing: Some(found.spacing),
            doubtful: false,
            strays: found.strays,
            beyond_ends: found.beyond_ends,
        }
    }

    /// Whether a surface at this distance from the points does not follow them.
    pub(crate) fn is_far(&self, rms: f64) -> bool {
        self.spacing.is_some_and(|spacing| rms > spacing)
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

/// Fits a surface: over a base surface that follows the points where there is one, otherwise over a simple shape.
pub(crate) fn from_cloud(
    points: &[Vector3<f64>],
    options: &SurfaceOptions,
    progress: Progress<'_>,
) -> Result<Found, Refusal> {
    let simple = |why: &str| -> Result<Found, Refusal> {
        let found = fit_cloud_with_progress(points, options, progress)?;
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
    match over_base_surface(points, shape, options, progress) {
        Ok(found) => Ok(found),
        Err(ParameterError::Fit(error)) => Err(error.into()),
        // The simple shapes ask for less.
        Err(error @ ParameterError::TooFewPoints { .. }) => {
            simple(&format!("a simple shape gave the first parameters: {error}"))
        }
        // Of no kind that is known, but one surface: the nearest of the simple shapes, which need not be right.
        Err(error @ ParameterError::Shape { .. }) if shape == Shape::Auto && !in_parts(&error) => {
            let (surface, report, mut start) =
                simple(&format!("a simple shape gave the first parameters: {error}"))?;
            start.doubtful = true;
            Ok((surface, report, start))
        }
        Err(error) => Err(Refusal::Points(error)),
    }
}

fn in_parts(error: &ParameterError) -> bool {
    matches!(error, ParameterError::Shape { wanted: "one surface", .. })
}

fn over_base_surface(
    points: &[Vector3<f64>],
    shape: Shape,
    options: &SurfaceOptions,
    progress: Progress<'_>,
) -> Result<Found, ParameterError> {
    let found = parameterise(points, &ParameteriseOptions::default().with_shape(shape))?;
    let mut start = Start::base(&found.report);
    let fit = FitOptions {
        control_points: options.size.controls,
        degrees: options.size.degrees,
        ..FitOptions::default()
    };
    let least_squares = fit_parameters(points, &found.base, &found.feet, &found.counts, &fit)?;
    start.least_squares_rms = Some(least_squares.rms);
    let like_finish = finish_options(points.len());
    let near = options.with_fit(match options.fit.smoothing {
        Smoothing::Automatic { .. } => options.fit.with_smoothing(like_finish.fit.smoothing),
        _ => options.fit,
    });
    let base = match found.report.shape.shape {
        Shape::Plane => BaseShape::Plane,
        Shape::Sphere => BaseShape::Sphere,
        _ => BaseShape::Cylinder,
    };
    let (surface, mut report) = if options.abs_tolerance.is_some() {
        let used = points.iter().zip(&found.counts).filter(|(_, counts)| **counts);
        let data: Vec<Vector3<f64>> = used.map(|(p, _)| *p).collect();
        let fitted = fit_surface_with_progress(&data, least_squares.surface, &near, progress)?;
        (fitted.surface, fitted.report)
    } else {
        let near = near
            .with_unfoldings(like_finish.unfoldings)
            .with_fit(near.fit.with_damping(like_finish.fit.damping));
        let (done, finish) = finish_fit_with_progress(points, &found.counts, least_squares, &near, progress)?;
        start.outcome = Some(finish.outcome);
        let mut report = finish.minimisation;
        // Of the surface that is left, which need not be the last of the minimisation.
        (report.fit.rms, report.fit.max) = (done.rms, done.max);
        (done.surface, report)
    };
    report.folds = Folds::of(&surface);
    report.base = Some(base);
    report.dropped = found.report.dropped;
    Ok((surface, report, start))
}
