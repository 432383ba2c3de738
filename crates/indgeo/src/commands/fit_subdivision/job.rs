//! The fit of a subdivision surface: read, coarsen, fit, write.

use crate::error::Error;
use crate::files;
use crate::fits::input::{Scan, check_paths, warn_dropped, warn_incomplete};
use crate::fits::numbers::{FitNumbers, FitVerdict, Within, told};
use crate::fits::page::{FitPage, SurfaceSections, coverage_facts, mesh_sections, number_facts};
use crate::input::field_model;
use crate::report::wording::counted;
use crate::report::{Input, Output, Report, Timings};
use crate::runtime::progress::Progress;
use industrial_geometry::fit::subdivision::{
    FoldedEdges, coarsened, fit_subdivision_with_progress, folded_edges,
};
use industrial_geometry::fit::{Error as FitError, FitOptions, FitStep, SurfaceCoverage, Target, measurable};
use industrial_geometry::io::{Content, Format, ReadOptions, WriteOptions};
use industrial_geometry::mesh::{Error as MeshError, HalfEdgeMesh, LoopScheme, TriangleMesh};
use industrial_geometry::nurbs::nalgebra::Vector3;
use serde::Serialize;
use std::path::Path;

/// Vertices of a control mesh that nobody chose: a share of those of the mesh, and limits.
const SHARE: usize = 10;
const LIMITS: [usize; 2] = [12, 1000];
/// Subdivisions of the surface that is drawn.
const DRAWN: u8 = 3;

/// What is to be done.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// File of the points.
    pub(crate) points: &'a Path,
    /// File of the control mesh to start from.
    pub(crate) init: Option<&'a Path>,
    /// File of the control mesh.
    pub(crate) out: Option<&'a Path>,
    /// File of the page.
    pub(crate) page: Option<&'a Path>,
    /// Format of both, if not that of the extension.
    pub(crate) format: Option<Format>,
    /// File of the limit surface, and how often it is subdivided.
    pub(crate) limit: Option<(&'a Path, u8)>,
    /// Vertices of the control mesh.
    pub(crate) vertices: Option<usize>,
    /// Largest distance that is wanted.
    pub(crate) tolerance: Option<f64>,
    /// Options of the library.
    pub(crate) options: FitOptions,
    /// Whether nobody wants to watch.
    pub(crate) quiet: bool,
}

/// What a fit of a subdivision surface found.
#[derive(Debug, Serialize)]
pub(crate) struct SubdivisionResults {
    /// The fit.
    #[serde(flatten)]
    pub(crate) fit: FitNumbers,
    /// Vertices of the control mesh.
    pub(crate) vertices: usize,
    /// Triangles of the control mesh.
    pub(crate) triangles: usize,
    /// Inner vertices of the control mesh whose neighbours are not six.
    pub(crate) irregular: usize,
    /// `coarsened` or `given`.
    pub(crate) start: &'static str,
    /// Edges at which the result folds back on itself: of the control mesh and of that of the limit surface.
    pub(crate) folded_edges: FoldedEdges,
    /// The same of the mesh of the input, if it is one.
    pub(crate) folded_edges_of_input: Option<usize>,
    /// How near the parts of the surface are to the points.
    pub(crate) coverage: Option<SurfaceCoverage>,
}

/// Does the job and fills in the report; returns whether the surface is what was asked for.
pub(crate) fn run(job: &Job<'_>, report: &mut Report) -> Result<FitVerdict, Error> {
    let inputs: Vec<&Path> = std::iter::once(job.points).chain(job.init).collect();
    let limit_path = job.limit.map(|(path, _)| path);
    let outputs: Vec<&Path> = [job.out, limit_path, job.page].into_iter().flatten().collect();
    check_paths(&inputs, &outputs)?;
    let scan = Scan::read(job.points, false, u32::MAX, report)?;
    let points: Vec<Vector3<f64>> =
        scan.points.iter().filter(|p| p.iter().all(|c| c.is_finite())).copied().collect();
    let dropped = scan.points.len() - points.len();
    let belongs = measurable(&points).map_err(|error| refused(job, &error))?;
    let finite = points.len();
    let points: Vec<Vector3<f64>> =
        points.into_iter().zip(belongs).filter(|(_, b)| *b).map(|(p, _)| p).collect();
    let apart = finite - points.len();
    if apart > 0 {
        report.warnings.push(format!(
            "{}: {} so far away that they cannot belong to the surface: not used",
            job.points.display(),
            counted(apart, "point")
        ));
    }
    warn_dropped(job.points, dropped, scan.points.len(), report);
    let folded_edges_of_input = scan.mesh.as_ref().map(folded_edges);
    let mesh = match scan.mesh {
        // The points of a field are its crossings with the grid; its triangles make the control mesh.
        None if job.init.is_none() && field_model::is_grid(job.points) => {
            Some(Timings::measure(&mut report.timings.build, || field_model::mesh(job.points))?)
        }
        mesh => mesh,
    };
    let given = job.init.map(|path| control(path, report)).transpose()?;
    let start = if given.is_some() { "given" } else { "coarsened" };
    let progress = Progress::iterations("fitting", job.quiet);
    let most = job.options.max_iterations;
    let tell = |step: &FitStep| told(&progress, step, most);
    let found = Timings::measure(&mut report.timings.compute, || {
        let control = match (given, mesh) {
            (Some(control), _) => control,
            (None, Some(mesh)) => coarse(job, mesh)?,
            (None, None) => {
                let what = "a cloud has no triangles from which a control mesh could be made";
                return Err(Error::content(job.points, what, "give a control mesh (--init), or a mesh"));
            }
        };
        let target = Target::Points { points: &points, weights: None };
        let found = fit_subdivision_with_progress(target, &control, &job.options, &tell);
        found.map_err(|error| refused(job, &error))
    });
    drop(progress);
    let found = found?;
    let within = |t: f64| found.frames.iter().filter(|f| f.distance.abs() <= t).count();
    let share_within = job.tolerance.map(|t| within(t) as f64 / finite.max(1) as f64);
    let within = Within {
        tolerance: job.tolerance,
        share: share_within,
        holds: share_within.is_none_or(|share| share >= 1.0),
    };
    let connectivity = HalfEdgeMesh::new(&found.mesh);
    let irregular = |v: &u32| !connectivity.is_boundary(*v) && connectivity.valence(*v) != 6;
    let vertices = found.mesh.vertices().len();
    if let Some(path) = job.out {
        let content = format!("control mesh of {}", counted(vertices, "vertex"));
        put_mesh(path, found.mesh.clone(), job.format, content, report)?;
    }
    if let Some((path, levels)) = job.limit {
        let limit = limit(&found.mesh, levels).map_err(|source| broken(job.points, source))?;
        let content = format!("limit surface after {}", counted(levels, "subdivision"));
        put_mesh(path, limit, job.format, content, report)?;
    }
    let fit = FitNumbers::new(found.report, dropped, 0, within);
    report.count_points("points", fit.points_dropped, fit.points_used);
    let distances: Vec<f64> = found.frames.iter().map(|f| f.distance).collect();
    let noise = SurfaceCoverage::noise_of(&distances);
    let coverage = SurfaceCoverage::of_subdivision(&found.surface, &points, noise, job.tolerance);
    let coverage = Some(coverage.map_err(|error| refused(job, &error))?);
    let incomplete = warn_incomplete(coverage.as_ref(), report);
    let folded = found.folded.limit > folded_edges_of_input.unwrap_or(0);
    if folded {
        report.warnings.push(format!(
            "the limit surface folds back on itself at {}; take more --vertices, or a larger --smoothing",
            counted(found.folded.limit, "edge")
        ));
    }
    let verdict = fit.verdict().without(folded || incomplete || apart > 0);
    let results = SubdivisionResults {
        triangles: found.mesh.triangles().len(),
        irregular: (0u32..).take(vertices).filter(irregular).count(),
        vertices,
        start,
        folded_edges: found.folded,
        folded_edges_of_input,
        coverage,
        fit,
    };
    if let Some(path) = job.page {
        let mesh = limit(&found.mesh, DRAWN).map_err(|source| broken(job.points, source))?;
        let scene = SurfaceSections { points: &points, tolerance: job.tolerance, max: results.fit.max };
        let pictures = mesh_sections(&scene, &mesh, &distances);
        put_page(job, path, pictures, &results, verdict, report)?;
    }
    report.results = Some(Box::new(results));
    Ok(verdict)
}

fn put_page(
    job: &Job<'_>,
    path: &Path,
    pictures: String,
    results: &SubdivisionResults,
    verdict: FitVerdict,
    report: &mut Report,
) -> Result<(), Error> {
    let fit = &results.fit;
    let mut facts = vec![
        ("vertices of the control mesh".to_owned(), results.vertices.to_string()),
        ("of them irregular".to_owned(), results.irregular.to_string()),
        ("triangles".to_owned(), results.triangles.to_string()),
    ];
    facts.extend(number_facts(fit));
    facts.extend(coverage_facts(results.coverage.as_ref(), None));
    facts.push(("folded edges of the limit surface".to_owned(), results.folded_edges.limit.to_string()));
    let page = FitPage {
        source: job.points,
        shape: "Loop subdivision surface".to_owned(),
        verdict,
        rms: fit.rms,
        max: fit.max,
        used: fit.points_used,
        pictures,
        facts,
        history: &fit.history,
    };
    page.write(path, results, report)
}

/// The control mesh of a file.
fn control(path: &Path, report: &mut Report) -> Result<TriangleMesh, Error> {
    let loaded = Timings::measure(&mut report.timings.read, || files::read(path, &ReadOptions::default()))?;
    report.add_input(Input::new("init", path, &loaded.report));
    match loaded.content {
        Content::Mesh(mesh) => Ok(mesh),
        _ => {
            let what = "a control mesh is needed, but this file holds no triangles";
            Err(Error::content(path, what, "give a mesh: OBJ, PLY, OFF or STL"))
        }
    }
}

/// The mesh of the input with few vertices.
fn coarse(job: &Job<'_>, mut mesh: TriangleMesh) -> Result<TriangleMesh, Error> {
    mesh.retain_finite();
    let mesh = welded(mesh).map_err(|source| broken(job.points, source))?;
    let vertices = job.vertices.unwrap_or((mesh.vertices().len() / SHARE).clamp(LIMITS[0], LIMITS[1]));
    coarsened(&mesh, vertices).map_err(|error| refused(job, &error))
}

/// The mesh in which vertices at the same place are one, as in files of triangles without shared vertices.
fn welded(mesh: TriangleMesh) -> Result<TriangleMesh, MeshError> {
    let first = mesh.coincident_vertices();
    let mut place = vec![u32::MAX; first.len()];
    let mut corners = Vec::new();
    for (vertex, &one) in first.iter().enumerate() {
        if one as usize == vertex {
            place[vertex] = u32::try_from(corners.len()).unwrap_or(u32::MAX);
            corners.push(mesh.vertices()[vertex]);
        }
    }
    let of = |vertex: u32| place[first[vertex as usize] as usize];
    let triangles = mesh.triangles().iter().map(|t| t.map(of));
    let triangles = triangles.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    TriangleMesh::new(corners, triangles)
}

/// The mesh subdivided, its vertices on the limit surface.
fn limit(control: &TriangleMesh, levels: u8) -> Result<TriangleMesh, MeshError> {
    let mut mesh = control.clone();
    for _ in 0..levels {
        mesh = LoopScheme::new(&mesh).subdivide()?;
    }
    let corners = LoopScheme::new(&mesh).limits().iter().map(|limit| limit.position).collect();
    TriangleMesh::new(corners, mesh.triangles().to_vec())
}

fn put_mesh(
    path: &Path,
    mesh: TriangleMesh,
    format: Option<Format>,
    content: String,
    report: &mut Report,
) -> Result<(), Error> {
    let options = WriteOptions { format, ..WriteOptions::default() };
    let written = Timings::measure(&mut report.timings.write, || {
        files::write_content(path, &Content::Mesh(mesh), &options)
    })?;
    report.warnings.extend(written.warnings.iter().map(|w| format!("{}: {w}", path.display())));
    report.add_output(Output { path: path.to_path_buf(), bytes: written.bytes, content });
    Ok(())
}

fn broken(path: &Path, source: MeshError) -> Error {
    Error::Mesh { path: path.to_path_buf(), source }
}

/// The error of the library, with the file that it is about.
fn refused(job: &Job<'_>, error: &FitError) -> Error {
    match error {
        FitError::Option { name, value, allowed } => {
            Error::option(name, *value, allowed, "see `indgeo fit-subdivision --help`")
        }
        FitError::Field { .. } => Error::content(
            job.init.unwrap_or(job.points),
            error.to_string(),
            "check the mesh with `indgeo info`; it must be an oriented manifold",
        ),
        _ => Error::content(job.points, error.to_string(), "check it with `indgeo info`"),
    }
}
