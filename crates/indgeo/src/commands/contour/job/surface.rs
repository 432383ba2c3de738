//! The level set of a volume as one B-spline surface (\[P05, sec. 4.6\]): a patch, a tube, or closed all around.

use super::Job;
use crate::commands::fit_surface::start::{Refusal, from_cloud};
use crate::error::Error;
use crate::files;
use crate::fits::input::put_model;
use crate::output::cad::CadFormat;
use crate::report::{Report, Timings};
use crate::runtime::progress::Progress;
use industrial_geometry::distance_field::{DistanceField, LevelSetField, Search};
use industrial_geometry::fit::{BaseShape, FitStep, NetSize, SurfaceOptions, SurfaceReport};
use industrial_geometry::footpoint::{ProjectionOptions, SurfaceProjector, no_progress};
use industrial_geometry::io::Model;
use industrial_geometry::mesh::TriangleMesh;
use industrial_geometry::mesh::nalgebra::Vector3;
use industrial_geometry::nurbs::{BsplineSurface, ParametricSurface};
use serde::Serialize;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;

/// Control points in u and v to begin with.
const CONTROLS: [usize; 2] = [12, 12];
/// Most points of the level set that are fitted.
const POINTS: usize = 40_000;
/// Samples of the surface along each side of its cells.
const PER_CELL: usize = 5;
/// Share of the tolerance that points may take: between them the surface may be farther.
const INNER: f64 = 0.5;

/// The surface of a volume.
#[derive(Debug, Serialize)]
pub(crate) struct SurfaceResult {
    /// `plane` (a patch), `cylinder` (a tube), `sphere` or `torus`: what the level set is like.
    pub(crate) kind: BaseShape,
    /// Control points in u and v that are not repetitions.
    pub(crate) control_points: [usize; 2],
    /// Largest distance of the surface from the level set.
    pub(crate) max_of_surface: f64,
    /// Largest distance of the level set from the surface.
    pub(crate) max_of_level_set: f64,
    /// Cells in which the surface folds back on itself.
    pub(crate) folds: usize,
    /// Loops that bound the surface where the grid ends; 0 where it is whole.
    pub(crate) trim_loops: usize,
}

/// Whether a file holds surfaces.
pub(super) fn is_surface(path: &Path) -> bool {
    CadFormat::of(path).is_some() || files::extension(path) == "json"
}

/// Fits one surface to a level set, which its mesh describes, and writes it.
pub(super) fn run(
    job: &Job<'_>,
    path: &Path,
    field: &LevelSetField<3>,
    mesh: &TriangleMesh,
    tolerance: f64,
    report: &mut Report,
) -> Result<SurfaceResult, Error> {
    let kind = kind(mesh).map_err(|what| {
        let advice = "write it as a mesh (.stl, .ply, .obj, .off), or cut the grid so that one part is left";
        Error::content(job.input, what, advice)
    })?;
    let points = on_level_set(field, mesh);
    let step = points.len().div_ceil(POINTS).max(1);
    let some: Vec<Vector3<f64>> = points.iter().copied().step_by(step).collect();
    let options = SurfaceOptions::default()
        .with_base(kind)
        .with_size(NetSize { degrees: [3, 3], controls: job.controls.map_or(CONTROLS, |count| [count; 2]) })
        .with_abs_tolerance(job.controls.is_none().then_some(INNER * tolerance));
    let progress = Progress::iterations("fitting", job.quiet);
    let most = options.fit.max_iterations;
    let tell = |step: &FitStep| -> ControlFlow<()> { crate::fits::numbers::told(&progress, step, most) };
    let mut timings = report.timings;
    let (surface, fitted, start) =
        Timings::measure(&mut timings.compute, || from_cloud(&some, &options, job.controls.is_some(), &tell))
            .map_err(|refusal| refused(job, refusal))?;
    drop(progress);
    if start.doubtful {
        report.warnings.push(format!(
            "{}: the level set is of no kind for which a surface is known to follow it",
            job.input.display()
        ));
    }
    let (forth, back) = Timings::measure(&mut timings.compute, || gap(field, &surface, &fitted, &points))
        .map_err(|what| {
            Error::content(job.input, what, "write the level set as a mesh (.stl, .ply, .obj, .off)")
        })?;
    report.timings = timings;
    let folds = fitted.folds.count();
    if folds > 0 {
        report.warnings.push(format!("the surface folds back on itself in {folds} cells"));
    }
    let result = SurfaceResult {
        kind,
        control_points: fitted.controls,
        max_of_surface: forth,
        max_of_level_set: back,
        folds,
        trim_loops: fitted.trim.as_ref().map_or(0, |trim| trim.loops().len()),
    };
    let content = format!("B-spline surface, {} × {}", fitted.controls[0], fitted.controls[1]);
    let mut model = Model::default();
    model.push_trimmed(surface, fitted.trim, None);
    put_model(path, model, job.cad, content, report)?;
    Ok(result)
}

fn refused(job: &Job<'_>, refusal: Refusal) -> Error {
    let what = match refusal {
        Refusal::Fit(error) => error.to_string(),
        Refusal::Points(error) => error.to_string(),
    };
    Error::content(job.input, what, "write it as a mesh (.stl, .ply, .obj, .off)")
}

/// What the surface of a mesh is like; an error says why one surface cannot hold it.
fn kind(mesh: &TriangleMesh) -> Result<BaseShape, String> {
    let mut parts = Sets::new(mesh.vertices().len());
    let mut edges: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    for triangle in mesh.triangles() {
        for k in 0..3 {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            parts.join(a, b);
            *edges.entry((a.min(b), a.max(b))).or_default() += 1;
        }
    }
    let mut used = vec![false; mesh.vertices().len()];
    for &k in mesh.triangles().iter().flatten() {
        used[k as usize] = true;
    }
    let vertices = used.iter().filter(|used| **used).count();
    let count = |sets: &mut Sets, members: &[u32]| {
        let roots: std::collections::BTreeSet<u32> = members.iter().map(|&k| sets.root(k)).collect();
        roots.len()
    };
    let all: Vec<u32> = mesh.triangles().iter().flatten().copied().collect();
    let n_parts = count(&mut parts, &all);
    if n_parts != 1 {
        return Err(format!("the level set has {n_parts} parts, and one surface holds one"));
    }
    let border: Vec<(u32, u32)> = edges.iter().filter(|(_, n)| **n == 1).map(|(edge, _)| *edge).collect();
    let mut rings = Sets::new(mesh.vertices().len());
    for &(a, b) in &border {
        rings.join(a, b);
    }
    let ends: Vec<u32> = border.iter().map(|edge| edge.0).collect();
    let borders = count(&mut rings, &ends);
    // Euler's number with the holes filled: 2 less 2 for each handle.
    let faces = mesh.triangles().len() + borders;
    let handles = (edges.len() + 2).saturating_sub(vertices + faces) / 2;
    match (borders, handles) {
        (0, 0) => Ok(BaseShape::Sphere),
        (0, 1) => Ok(BaseShape::Torus),
        (1, 0) => Ok(BaseShape::Plane),
        (2, 0) => Ok(BaseShape::Cylinder),
        _ => Err(format!(
            "the level set has {borders} borders at the ends of the grid and {handles} handles; \
             one surface holds a patch (1 border), a tube (2), a closed surface without handle, or a ring (1 handle)"
        )),
    }
}

/// Disjoint sets of vertices.
struct Sets(Vec<u32>);

impl Sets {
    fn new(count: usize) -> Self {
        Self((0..u32::try_from(count).unwrap_or(u32::MAX)).collect())
    }

    fn root(&mut self, mut k: u32) -> u32 {
        while self.0[k as usize] != k {
            self.0[k as usize] = self.0[self.0[k as usize] as usize];
            k = self.0[k as usize];
        }
        k
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

/// The feet of the vertices and of the middles of the triangles of a mesh next to a level set.
fn on_level_set(field: &LevelSetField<3>, mesh: &TriangleMesh) -> Vec<Vector3<f64>> {
    let corner = |k: u32| mesh.vertices()[k as usize].coords;
    let middles = mesh.triangles().iter().map(|t| (corner(t[0]) + corner(t[1]) + corner(t[2])) / 3.0);
    let queries: Vec<Vector3<f64>> = mesh.vertices().iter().map(|p| p.coords).chain(middles).collect();
    let frames = field.frames(&queries, Search::Global, &[]);
    frames.iter().filter(|frame| frame.status.is_converged()).map(|frame| frame.foot).collect()
}

/// Largest distances of the surface, as far as it is bounded and within the grid, from the level set, and of points of the level set from
/// the surface.
fn gap(
    field: &LevelSetField<3>,
    surface: &BsplineSurface,
    fitted: &SurfaceReport,
    points: &[Vector3<f64>],
) -> Result<(f64, f64), String> {
    let [us, vs] = [surface.knots_u(), surface.knots_v()].map(|knots| {
        let mut all = Vec::new();
        for span in knots.spans() {
            let interval = knots.span_interval(span);
            all.extend((0..=PER_CELL).map(|k| interval.lerp(k as f64 / PER_CELL as f64)));
        }
        all
    });
    let low = *field.grid().origin();
    let high = field.grid().position(field.grid().values().len() - 1);
    let is_inside = |x: &Vector3<f64>| (0..3).all(|k| low[k] <= x[k] && x[k] <= high[k]);
    let counts = |u: f64, v: f64| fitted.trim.as_ref().is_none_or(|trim| trim.contains(u, v));
    let mut samples = Vec::with_capacity(us.len() * vs.len());
    for &u in &us {
        samples.extend(vs.iter().filter(|v| counts(u, **v)).map(|&v| surface.point(u, v)));
    }
    samples.retain(is_inside);
    let frames = field.frames(&samples, Search::Global, &[]);
    let larger = |a: f64, b: f64| if a.is_nan() || b <= a { a } else { b };
    let forth = frames.iter().zip(&samples).map(|(frame, x)| (frame.foot - x).norm()).fold(0.0, larger);
    let projector = SurfaceProjector::new(surface);
    let feet = projector
        .project_many(points, &ProjectionOptions::default(), &no_progress)
        .map_err(|error| error.to_string())?;
    let back = feet.iter().map(|foot| foot.distance).fold(0.0, larger);
    Ok((forth, back))
}

#[cfg(test)]
mod tests {
    use super::*;
    use industrial_geometry::distance_field::Grid;
    use industrial_geometry::level_set::surface::{dual_contour, of_field};

    fn mesh_of(f: impl Fn(&Vector3<f64>) -> f64) -> TriangleMesh {
        let grid = Grid::sample(Vector3::repeat(-1.5), Vector3::repeat(0.15), [21; 3], f).unwrap();
        let field = LevelSetField::<3>::new(&grid).unwrap();
        dual_contour(&grid, of_field(&field)).unwrap()
    }

    #[test]
    fn kinds_are_told_by_borders_and_handles() {
        let ball = |p: &Vector3<f64>, x: f64, r: f64| (p - Vector3::new(x, 0.0, 0.0)).norm() - r;
        let ring = |p: &Vector3<f64>, x: f64, big: f64| ((p.x - x).hypot(p.y) - big).hypot(p.z) - 0.3;
        assert_eq!(kind(&mesh_of(|p| ball(p, 0.0, 1.0))), Ok(BaseShape::Sphere));
        assert_eq!(kind(&mesh_of(|p| ring(p, 0.0, 0.9))), Ok(BaseShape::Torus));
        assert_eq!(kind(&mesh_of(|p| p.z - 0.1 * p.x)), Ok(BaseShape::Plane));
        assert_eq!(kind(&mesh_of(|p| p.xy().norm() - 0.7)), Ok(BaseShape::Cylinder));
        let two = kind(&mesh_of(|p| ball(p, -0.8, 0.5).min(ball(p, 0.8, 0.5)))).unwrap_err();
        assert!(two.contains("2 parts"), "{two}");
        let eight = kind(&mesh_of(|p| ring(p, -0.6, 0.5).min(ring(p, 0.6, 0.5)))).unwrap_err();
        assert!(eight.contains("0 borders") && eight.contains("2 handles"), "{eight}");
    }
}
