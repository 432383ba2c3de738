//! Surfaces fitted to models: distances from sensor points of the surface, orthogonal to the model.

use super::fit::{Run, concluded, fit_surface_with_progress};
use super::initial::initial_surface;
use super::judge::surface_frames;
use super::options::SurfaceOptions;
use super::report::SurfaceFit;
use super::runs::{Outcome, Runs};
use crate::iterate::{Progress, no_progress};
use crate::{Error, FitReport, Smoothing, Target};
use distance_field::DistanceField;
use nalgebra::Vector3;
use nurbs_core::BsplineSurface;

/// Energy with which a surface begins that is near to a model, and the factor by which it becomes less: a model has no noise from which it would follow how
/// smooth the surface has to be.
const FIRST: f64 = 1e-5;
const LESS: f64 = 0.25;
const LEAST: f64 = 1e-9;

/// Fits a surface to a model, given by its distance field (\[P05, sec. 4.1\]).
///
/// Sensor points, so many in each direction of each cell of the surface, have quadratic models of the squared distance from the model; their sum and the
/// energy are minimised in the control points, and again. `samples` are points all over the model: the start is made from them where none is given, and by
/// them is told whether the surface reaches all of the model ([`coverage`](super::SurfaceReport::coverage) and the frames of the result). Distances of the
/// report are those of the sensor points. Energies that are to follow from the data fall to a trifle instead.
///
/// ```
/// use distance_field::SurfaceField;
/// use nalgebra::Vector3;
/// use nurbs_core::{BsplineSurface, KnotVector, ParametricSurface};
/// use sdm_fit::{NetSize, SurfaceOptions, fit_surface_to_model};
///
/// let knots = KnotVector::uniform_clamped(2, 4)?;
/// let place = |k: usize| Vector3::new((k / 4) as f64, (k % 4) as f64, if k % 5 == 0 { 0.4 } else { 0.0 });
/// let model = BsplineSurface::new(knots.clone(), knots, (0..16).map(place).collect(), None)?;
/// let at = |k: usize| [(k / 30) as f64 / 29.0, (k % 30) as f64 / 29.0];
/// let samples: Vec<_> = (0..900).map(at).map(|[u, v]| model.point(u, v)).collect();
/// let size = NetSize { degrees: [3, 3], controls: [6, 6] };
/// let options = SurfaceOptions::default().with_size(size);
/// let found = fit_surface_to_model(&SurfaceField::new(&model)?, &samples, None, 4, &options)?;
/// assert!(found.report.fit.rms < 0.01 && found.report.folds.count() == 0, "{}", found.report);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As for [`fit`](crate::fit()); [`Error::Rational`] for a start with weights.
pub fn fit_surface_to_model(
    field: &dyn DistanceField<3>,
    samples: &[Vector3<f64>],
    initial: Option<BsplineSurface>,
    sensors: usize,
    options: &SurfaceOptions,
) -> Result<SurfaceFit, Error> {
    fit_surface_to_model_with_progress(field, samples, initial, sensors, options, &no_progress)
}

/// [`fit_surface_to_model`] with a callback after each iteration, which may cancel.
///
/// # Errors
/// As [`fit_surface_to_model`].
pub fn fit_surface_to_model_with_progress(
    field: &dyn DistanceField<3>,
    samples: &[Vector3<f64>],
    initial: Option<BsplineSurface>,
    sensors: usize,
    options: &SurfaceOptions,
    progress: Progress<'_>,
) -> Result<SurfaceFit, Error> {
    options.check()?;
    let mut begun_with = None;
    let (surface, base) = match initial {
        Some(surface) => (surface, None),
        None => {
            let start = initial_surface(samples, options.base, options.size)?;
            // The surface through the samples reaches to the ends of the model.
            let mut through = fit_surface_with_progress(samples, start.surface, options, progress)?;
            through.report.base = Some(start.base);
            let surface = through.surface.clone();
            begun_with = Some(through);
            (surface, Some(start.base))
        }
    };
    if surface.weights().is_some() {
        return Err(Error::Rational);
    }
    // The boundary stays: nothing in the distances from a model keeps a surface from becoming a piece of it.
    let mut begun = options.with_fixed_boundary(true);
    if let Smoothing::Automatic { .. } = options.fit.smoothing {
        begun.fit.smoothing = Smoothing::Continuation { start: FIRST, factor: LESS, floor: LEAST };
    }
    let target = Target::Model { field, sensors, boundary: true };
    let mut runs = Runs::new(target, &begun, progress);
    let Outcome { fitted, folds } = runs.run(surface)?;
    (1..).zip(&mut runs.history).for_each(|(number, step)| step.iteration = number);
    let report = FitReport { history: runs.history, initial_rms: runs.initial_rms, ..fitted.report };
    // What is no nearer to the model than it was at the start is not kept.
    if let Some(through) = begun_with.filter(|_| report.rms.is_nan() || report.rms >= report.initial_rms) {
        return Ok(through);
    }
    let surface = fitted.shape.into_surface();
    let frames = surface_frames(&surface, samples)?;
    let run = Run { runs: runs.count, folds };
    let mut found = concluded(surface, frames, report, run, options, (&Vector3::zeros(), samples))?;
    found.report.base = base;
    Ok(found)
}
