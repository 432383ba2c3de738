//! Loop subdivision surfaces fitted to points and models.

use super::ActiveLoop;
use crate::iterate::{Progress, fit_with_progress, no_progress};
use crate::{Constraints, Error, FitOptions, FitReport, Smoothing, Target};
use distance_field::PrincipalFrame;
use mesh_core::{LoopSurface, TriangleMesh};
use nalgebra::Vector3;

/// A subdivision surface and how it came about.
#[derive(Clone, Debug)]
pub struct SubdivisionFit {
    /// The control mesh.
    pub mesh: TriangleMesh,
    /// Its limit surface.
    pub surface: LoopSurface,
    /// How it came about.
    pub report: FitReport,
    /// The frames of the samples, see [`Fitted`](crate::Fitted); parameters are those of [`ActiveLoop`].
    pub frames: Vec<PrincipalFrame<3>>,
}

/// Options of the loop for subdivision surfaces: second derivatives as energy whose factor falls from 0.01 to a trifle, parameter
/// lines faired.
#[must_use]
pub fn subdivision_options() -> FitOptions {
    FitOptions::default()
        .with_energy([0.0, 1.0, 0.0])
        .with_smoothing(Smoothing::Continuation { start: 1e-2, factor: 0.5, floor: 1e-8 })
        .with_fairing(1e-5)
        .with_cost_tolerance(1e-4)
}

/// Fits the limit surface of Loop's scheme to points or a model, from a control mesh (\[P05, sec. 4.2\], Fig. 5).
///
/// The mesh, given by the user or coarsened from a fine one ([`coarsened`](super::coarsened)), keeps its connectivity. Its limit
/// lies inside convex meshes: a few iterations of the loop make up for that.
///
/// ```
/// use mesh_core::{TriangleMesh, nalgebra::Point3};
/// use nalgebra::Vector3;
/// use sdm_fit::{Target, subdivision::{fit_subdivision, subdivision_options}};
///
/// // An octahedron becomes a ball.
/// let corners = [[1., 0., 0.], [0., 1., 0.], [-1., 0., 0.], [0., -1., 0.], [0., 0., 1.], [0., 0., -1.]];
/// let triangles = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [1, 0, 5], [2, 1, 5], [3, 2, 5], [0, 3, 5]];
/// let mesh = TriangleMesh::new(corners.map(Point3::from).to_vec(), triangles.to_vec())?;
/// let at = |k: i32| (f64::from(k) * 2.399_963, f64::from(2 * k + 1) / 400.0 - 1.0);
/// let ball = |(a, z): (f64, f64)| Vector3::new((1.0 - z * z).sqrt() * a.cos(), (1.0 - z * z).sqrt() * a.sin(), z);
/// let points: Vec<_> = (0..400).map(at).map(ball).collect();
/// let target = Target::Points { points: &points, weights: None };
/// let found = fit_subdivision(target, &mesh, &subdivision_options())?;
/// assert!(found.report.rms < 0.02 && found.report.initial_rms > 0.2, "{}", found.report);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As for [`fit`](crate::fit()); [`Error::Field`] for a control mesh that is not an oriented manifold.
pub fn fit_subdivision(
    target: Target<'_, 3>,
    control: &TriangleMesh,
    options: &FitOptions,
) -> Result<SubdivisionFit, Error> {
    fit_subdivision_with_progress(target, control, options, &no_progress)
}

/// [`fit_subdivision`] with a callback after each iteration, which may cancel.
///
/// # Errors
/// As [`fit_subdivision`].
pub fn fit_subdivision_with_progress(
    target: Target<'_, 3>,
    control: &TriangleMesh,
    options: &FitOptions,
    progress: Progress<'_>,
) -> Result<SubdivisionFit, Error> {
    // Points are moved to the middle of the mesh, so that large coordinates lose nothing; the field of a model stays.
    let corners = control.vertices();
    let middle = match target {
        Target::Points { .. } => {
            corners.iter().map(|p| p.coords).sum::<Vector3<f64>>() / corners.len().max(1) as f64
        }
        Target::Model { .. } => Vector3::zeros(),
    };
    let shape = ActiveLoop::new(&moved(control, &-middle)?)?;
    let free = Constraints::none();
    let mut fitted = match target {
        Target::Points { points, weights } => {
            let local: Vec<Vector3<f64>> = points.iter().map(|p| p - middle).collect();
            fit_with_progress(shape, Target::Points { points: &local, weights }, &free, options, progress)?
        }
        Target::Model { .. } => fit_with_progress(shape, target, &free, options, progress)?,
    };
    fitted.frames.iter_mut().for_each(|frame| frame.foot += middle);
    let mesh = moved(&fitted.shape.mesh()?, &middle)?;
    let surface = LoopSurface::new(&mesh)?;
    Ok(SubdivisionFit { mesh, surface, report: fitted.report, frames: fitted.frames })
}

fn moved(mesh: &TriangleMesh, by: &Vector3<f64>) -> Result<TriangleMesh, Error> {
    let corners = mesh.vertices().iter().map(|p| p + by).collect();
    Ok(TriangleMesh::new(corners, mesh.triangles().to_vec())?)
}
