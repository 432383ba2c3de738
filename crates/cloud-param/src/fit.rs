//! Least squares surfaces from the parameters of a base surface.

use crate::Error;
use footpoint::{ProjectionOptions, SurfaceFootpoint, SurfaceProjector, no_progress};
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, KnotVector, ParametricSurface, SurfaceFitOptions};

/// How a surface is fitted to points with parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct FitOptions {
    /// Number of control points in `u` (different ones, where `u` is closed) and `v`; default 30 and 30.
    pub control_points: [usize; 2],
    /// Degree in both directions; default 3.
    pub degree: usize,
    /// Factor of the thin plate energy, of which a little bridges holes; default 1e-9 times the squared size of the cloud
    /// is not needed here, since the energy is measured in the same unit: 1e-10.
    pub regularisation: f64,
    /// How many times parameters are corrected by projecting the points onto the fitted surface, each followed by another
    /// fit; default 0.
    pub corrections: usize,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { control_points: [30, 30], degree: 3, regularisation: 1e-10, corrections: 0 }
    }
}

/// A fitted surface.
#[derive(Clone, Debug)]
pub struct SurfaceFit {
    /// The surface, with the domain of the base surface; periodic in `u` if that was closed.
    pub surface: BsplineSurface,
    /// Root mean square of the orthogonal distances of all points that count, after each fit.
    pub history: Vec<f64>,
    /// Footpoints of the points on the surface, those that do not count included.
    pub feet: Vec<SurfaceFootpoint>,
    /// Root mean square of the orthogonal distances at the end.
    pub rms: f64,
    /// Largest orthogonal distance at the end.
    pub max: f64,
    /// Number of points that count.
    pub used: usize,
}

/// The least squares B-spline surface of points with parameters, closed in `u` if the base surface is, open at the other
/// ends ([MPK, sec. 4]).
///
/// `feet` are the footpoints on the base surface; `counts` says which points take part.
///
/// # Errors
/// [`Error::Option`], [`Error::Nurbs`] where data leave control points undetermined.
pub fn fit_parameters(
    points: &[Vector3<f64>],
    base: &BsplineSurface,
    feet: &[SurfaceFootpoint],
    counts: &[bool],
    options: &FitOptions,
) -> Result<SurfaceFit, Error> {
    let [n_u, n_v] = options.control_points;
    let closed = base.knots_u().is_periodic();
    let [u, v] = base.domain();
    let knots_u = if closed {
        KnotVector::uniform_periodic(options.degree, n_u)?
    } else {
        KnotVector::uniform_clamped(options.degree, n_u)?
    };
    let knots =
        [knots_u.reparameterized(u), KnotVector::uniform_clamped(options.degree, n_v)?.reparameterized(v)];
    let used: Vec<usize> = (0..points.len()).filter(|&i| counts[i]).collect();
    let data: Vec<Vector3<f64>> = used.iter().map(|&i| points[i]).collect();
    let mut parameters: Vec<[f64; 2]> = used.iter().map(|&i| feet[i].parameter).collect();
    // The energy has the unit of the squared distances.
    let fit = SurfaceFitOptions::default().with_regularization(options.regularisation);
    let mut history = Vec::new();
    loop {
        let surface = BsplineSurface::approximate(knots.clone(), &parameters, &data, &fit)?.shape;
        let projector = SurfaceProjector::new(&surface);
        let all = projector.project_many(points, &ProjectionOptions::default(), &no_progress);
        let squares = used.iter().map(|&i| all[i].distance * all[i].distance);
        let rms = (squares.sum::<f64>() / used.len().max(1) as f64).sqrt();
        history.push(rms);
        if history.len() > options.corrections {
            let max = used.iter().map(|&i| all[i].distance).fold(0.0, f64::max);
            return Ok(SurfaceFit { surface, history, feet: all, rms, max, used: used.len() });
        }
        parameters = used.iter().map(|&i| all[i].parameter).collect();
    }
}
