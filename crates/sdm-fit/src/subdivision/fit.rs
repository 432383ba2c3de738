//! Loop subdivision surfaces fitted to points and models.

use super::folded::check_neighbours;
use super::{ActiveLoop, FoldedEdges};
use crate::coverage_surface::noise_of;
use crate::iterate::{Progress, fit_with_progress, no_progress};
use crate::{Constraints, Error, FitOptions, FitReport, Fitted, Smoothing, Status, SurfaceCoverage, Target};
use distance_field::PrincipalFrame;
use mesh_core::{LoopSurface, TriangleMesh};
use nalgebra::Vector3;

/// How often a fit whose mesh folds is made again, and by how much more smoothing and fairing.
const AGAIN: usize = 4;
const STIFFER: f64 = 10.0;
/// Least factor of the energy that is raised.
const LEAST: f64 = 1e-8;

/// A subdivision surface and how it came about.
#[derive(Clone, Debug)]
pub struct SubdivisionFit {
    /// The control mesh.
    pub mesh: TriangleMesh,
    /// Its limit surface.
    pub surface: LoopSurface,
    /// How it came about.
    pub report: FitReport,
    /// Edges at which the result folds back on itself, and those of the mesh that it began with.
    pub folded: FoldedEdges,
    /// See [`folded`](Self::folded).
    pub folded_at_start: FoldedEdges,
    /// How near the parts of the surface are to the points; `None` for a model.
    pub coverage: Option<SurfaceCoverage>,
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
/// lies inside convex meshes: a few iterations of the loop make up for that. Where the result has more folded edges than the mesh that
/// it began with, it is fitted again with more smoothing, a few times.
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
    check_neighbours(control)?;
    let start = moved(control, &-middle)?;
    let folded_at_start = FoldedEdges::of(&start)?;
    let local: Vec<Vector3<f64>> = match target {
        Target::Points { points, .. } => points.iter().map(|p| p - middle).collect(),
        Target::Model { .. } => Vec::new(),
    };
    let target = match target {
        Target::Points { weights, .. } => Target::Points { points: &local, weights },
        model @ Target::Model { .. } => model,
    };
    let (mut best, mut options) = (None, *options);
    for _ in 0..=AGAIN {
        let fitted =
            fit_with_progress(ActiveLoop::new(&start)?, target, &Constraints::none(), &options, progress)?;
        let folded = FoldedEdges::of(&fitted.shape.mesh()?)?;
        let is_cancelled = fitted.report.status == Status::Cancelled;
        let fewer = |best: &Option<(Fitted<ActiveLoop, 3>, FoldedEdges)>| {
            best.as_ref().is_none_or(|(_, least)| folded.limit < least.limit)
        };
        if fewer(&best) {
            best = Some((fitted, folded));
        }
        let good = folded.limit <= folded_at_start.limit && folded.control <= folded_at_start.control;
        if good || is_cancelled {
            break;
        }
        options = stiffer(&options);
    }
    let Some((mut fitted, folded)) = best else {
        return Err(Error::Field { reason: "no surface could be made".to_owned() });
    };
    let coverage = match target {
        Target::Points { points, .. } => {
            let distances = fitted.frames.iter().map(|f| f.distance.abs()).collect();
            Some(SurfaceCoverage::of_subdivision(fitted.shape.surface(), points, noise_of(distances), None)?)
        }
        Target::Model { .. } => None,
    };
    fitted.frames.iter_mut().for_each(|frame| frame.foot += middle);
    let mesh = moved(&fitted.shape.mesh()?, &middle)?;
    let surface = LoopSurface::new(&mesh)?;
    let (report, frames) = (fitted.report, fitted.frames);
    Ok(SubdivisionFit { mesh, surface, report, folded, folded_at_start, coverage, frames })
}

/// The options with more smoothing and fairing.
fn stiffer(options: &FitOptions) -> FitOptions {
    let more = |lambda: f64| STIFFER * lambda.max(LEAST);
    let smoothing = match options.smoothing {
        Smoothing::Fixed { lambda } => Smoothing::Fixed { lambda: more(lambda) },
        Smoothing::Continuation { start, factor, floor } => {
            Smoothing::Continuation { start: start.max(more(floor)), factor, floor: more(floor) }
        }
        Smoothing::Automatic { start, factor } => Smoothing::Continuation { start, factor, floor: more(0.0) },
    };
    options.with_smoothing(smoothing).with_fairing(STIFFER * options.fairing)
}

fn moved(mesh: &TriangleMesh, by: &Vector3<f64>) -> Result<TriangleMesh, Error> {
    let corners = mesh.vertices().iter().map(|p| p + by).collect();
    Ok(TriangleMesh::new(corners, mesh.triangles().to_vec())?)
}
