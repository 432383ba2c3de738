//! A fitted surface finished by squared distance minimisation.

use super::{SurfaceFit, rms};
use crate::Error;
use footpoint::{ProjectionOptions, SurfaceProjector, no_progress};
use nalgebra::Vector3;
use sdm_fit::{SurfaceOptions, SurfaceReport, fit_surface};

/// Moves the control points of a fitted surface to where the orthogonal distances of the points that count are least, by squared
/// distance minimisation ([`sdm_fit::fit_surface`]), which needs no parameters but begins with good ones.
///
/// Returns the finished surface, its history being that of the fit with the result at its end, and what the minimisation reports.
///
/// # Errors
/// [`Error::Fit`].
pub fn finish_fit(
    points: &[Vector3<f64>],
    counts: &[bool],
    fitted: SurfaceFit,
    options: &SurfaceOptions,
) -> Result<(SurfaceFit, SurfaceReport), Error> {
    if counts.len() != points.len() {
        return Err(Error::Option {
            name: "counts",
            value: counts.len() as f64,
            allowed: "one for each point",
        });
    }
    let used: Vec<usize> = (0..points.len()).filter(|&i| counts[i]).collect();
    let data: Vec<Vector3<f64>> = used.iter().map(|&i| points[i]).collect();
    let finished = fit_surface(&data, fitted.surface, options)?;
    let projector = SurfaceProjector::new(&finished.surface);
    let feet = projector.project_many(points, &ProjectionOptions::default(), &no_progress);
    let max = used.iter().map(|&i| feet[i].distance).fold(0.0, f64::max);
    let rms = rms(&used, &feet);
    let mut history = fitted.history;
    history.push(rms);
    Ok((SurfaceFit { surface: finished.surface, history, feet, rms, max, used: used.len() }, finished.report))
}
