//! Geodesic distances and curves: read, compute, write.

use crate::error::Error;
use crate::files;
use crate::on_surface::picture::{self, Shown};
use crate::on_surface::{MetricChoice, mesh_of, read, refused, warn_of_cuts};
use crate::report::wording::counted;
use crate::report::{Output, Report, Timings};
use industrial_geometry::feature_metric::{
    GeodesicOptions, GeodesicPath, Method, Metric, MetricMesh, insert_point, surface_geodesic,
};
use industrial_geometry::io::{Content, Shape, WriteOptions};
use industrial_geometry::mesh::nalgebra::{Point3, Vector3};
use industrial_geometry::mesh::{Attributes, TriangleMesh};
use serde::Serialize;
use std::io::Write;
use std::path::Path;

const HELP: &str = "see `indgeo geodesic --help`";

/// Distance of a given point from the mesh, as a share of its diagonal, above which this is said.
const FAR: f64 = 1e-3;

/// How distances on meshes are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum MethodChoice {
    /// From triangle to triangle; the error goes with their size
    Fast,
    /// Exact on the triangles
    Exact,
}

/// A place on a surface, as typed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Place {
    /// A vertex, from 0.
    Vertex(usize),
    /// A point of the parameter plane.
    Parameters([f64; 2]),
    /// A point in space.
    Point([f64; 3]),
}

/// What is to be done.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// File of the mesh or surface.
    pub(crate) shape: &'a Path,
    /// Sources.
    pub(crate) from: &'a [Place],
    /// Targets of curves.
    pub(crate) to: &'a [Place],
    pub(crate) choice: MetricChoice,
    pub(crate) metric: Metric,
    pub(crate) method: MethodChoice,
    /// File of the distances, or of the curve on a surface.
    pub(crate) out: Option<&'a Path>,
    /// File of the picture.
    pub(crate) picture: Option<&'a Path>,
}

/// A curve that was found.
#[derive(Debug, Serialize)]
pub(crate) struct CurveResult {
    /// Length in the metric; `null` where no way leads.
    pub(crate) length: Option<f64>,
    /// Length in space.
    pub(crate) length_in_space: Option<f64>,
    /// Whether the curve is locally shortest.
    pub(crate) is_geodesic: bool,
    /// Difference of the last two extrapolations of the length, on NURBS surfaces.
    pub(crate) length_error: Option<f64>,
    /// Its points, from the source to the target.
    pub(crate) points: Vec<[f64; 3]>,
}

/// What was found.
#[derive(Debug, Serialize)]
pub(crate) struct GeodesicResults {
    pub(crate) metric: &'static str,
    /// The width `w`, 0 in the Euclidean metric.
    pub(crate) w: f64,
    /// `fast`, `exact`, or `newton` on NURBS surfaces.
    pub(crate) method: &'static str,
    /// Vertices with a distance, and those to which no way leads; `null` on NURBS surfaces.
    pub(crate) vertices: Option<usize>,
    pub(crate) unreachable: Option<usize>,
    /// Largest distance.
    pub(crate) max: Option<f64>,
    /// One per target.
    pub(crate) paths: Vec<CurveResult>,
}

/// Does the job and fills in the report; returns whether everything that was asked for was found.
pub(crate) fn run(job: &Job<'_>, report: &mut Report) -> Result<bool, Error> {
    for path in [job.out, job.picture].into_iter().flatten() {
        files::check_writable(path, &[job.shape])?;
    }
    let mut timings = Timings::default();
    let content = read(job.shape, report, &mut timings)?;
    let found = match content {
        Content::Nurbs(model) => on_surface(job, model.into_shapes(), report, &mut timings),
        content => on_mesh(job, mesh_of(content, job.shape)?, report, &mut timings),
    }?;
    report.timings = timings;
    let complete = found.unreachable.unwrap_or(0) == 0 && found.paths.iter().all(|path| path.is_geodesic);
    report.results = Some(Box::new(found));
    Ok(complete)
}

fn on_mesh(
    job: &Job<'_>,
    given: TriangleMesh,
    report: &mut Report,
    timings: &mut Timings,
) -> Result<GeodesicResults, Error> {
    if let Some(path) = job.out
        && !matches!(files::extension(path).as_str(), "csv" | "ply")
        && !files::is_stream(path)
    {
        return Err(Error::content(path, "distances are CSV or PLY", "choose .csv or .ply"));
    }
    if let Some(path) = job.picture {
        picture::check(path)?;
    }
    let count = given.vertices().len();
    let failed = |error| refused(job.shape, &error, HELP);
    let mut mesh = given;
    let mut places = Vec::new();
    for place in job.from.iter().chain(job.to) {
        places.push(match place {
            Place::Vertex(vertex) if *vertex < count => *vertex,
            Place::Vertex(vertex) => {
                let what = format!("vertex {vertex} is none of the {count} vertices (from 0)");
                return Err(Error::content(job.shape, what, HELP));
            }
            Place::Point(point) => {
                let inserted = insert_point(&mesh, &Point3::from(*point)).map_err(failed)?;
                let size = mesh.bounding_box().map_or(0.0, |bounds| bounds.diagonal());
                if inserted.distance > FAR * size {
                    let [x, y, z] = point;
                    report.warnings.push(format!(
                        "the point ({x}, {y}, {z}) lies {:.6} from the mesh; its nearest point there is taken",
                        inserted.distance
                    ));
                }
                mesh = inserted.mesh;
                inserted.vertex
            }
            Place::Parameters(_) => {
                let what = "two numbers are parameters of a surface, but this is a mesh";
                return Err(Error::content(job.shape, what, "give a vertex, or three coordinates"));
            }
        });
    }
    let metric_mesh =
        Timings::measure(&mut timings.build, || MetricMesh::new(&mesh, job.metric)).map_err(failed)?;
    warn_of_cuts(metric_mesh.is_manifold(), job.shape, report);
    let method = if job.method == MethodChoice::Fast { Method::Fast } else { Method::Exact };
    let (sources, targets) = places.split_at(job.from.len());
    let mut paths = Vec::new();
    let distances = Timings::measure(&mut timings.compute, || {
        let distances = metric_mesh.distances(sources, method)?;
        for &target in targets {
            paths.push(of_path(metric_mesh.path(&distances, target)?));
        }
        Ok(distances)
    })
    .map_err(failed)?;
    // Vertices that were put in for points are no vertices of the file.
    let values = &distances.values[..count];
    let reached = values.iter().copied().filter(|value| value.is_finite());
    let max = reached.clone().reduce(f64::max);
    let unreachable = count - reached.clone().count();
    if unreachable > 0 {
        report.warnings.push(format!(
            "{}: no way leads to {unreachable} of {}, which are infinite",
            job.shape.display(),
            counted(count, "vertex")
        ));
    }
    let mut seconds = timings.write;
    Timings::measure(&mut seconds, || write_distances(job, &mesh, values, report))?;
    if let Some(path) = job.picture {
        let lines: Vec<&[[f64; 3]]> = paths.iter().map(|path: &CurveResult| path.points.as_slice()).collect();
        let content = "picture: distances, isolines and curves";
        picture::write(path, &mesh, &Shown::Values(&distances.values), &lines, content, report)?;
    }
    timings.write = seconds;
    Ok(GeodesicResults {
        metric: job.choice.name(),
        w: job.metric.width(),
        method: if method == Method::Fast { "fast" } else { "exact" },
        vertices: Some(count),
        unreachable: Some(unreachable),
        max,
        paths,
    })
}

fn of_path(path: Option<GeodesicPath>) -> CurveResult {
    let Some(path) = path else {
        let points = Vec::new();
        return CurveResult {
            length: None,
            length_in_space: None,
            is_geodesic: false,
            length_error: None,
            points,
        };
    };
    let in_space = path.points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    CurveResult {
        length: Some(path.length),
        length_in_space: Some(in_space),
        is_geodesic: path.is_geodesic,
        length_error: None,
        points: path.points.into_iter().map(|point| point.coords.into()).collect(),
    }
}

fn write_distances(
    job: &Job<'_>,
    mesh: &TriangleMesh,
    values: &[f64],
    report: &mut Report,
) -> Result<(), Error> {
    let Some(path) = job.out else { return Ok(()) };
    let bytes = if files::extension(path) == "ply" {
        // All vertices of the file, the triangles that do not refer to others.
        let vertices = mesh.vertices()[..values.len()].to_vec();
        let is_old = |triangle: &&[u32; 3]| triangle.iter().all(|&index| (index as usize) < values.len());
        let triangles = mesh.triangles().iter().filter(is_old).copied().collect();
        let mut attributes = Attributes::default();
        let failed = |error: industrial_geometry::mesh::Error| Error::content(path, error.to_string(), HELP);
        attributes.push_scalar("distance", values.to_vec()).map_err(failed)?;
        let coloured = TriangleMesh::new(vertices, triangles)
            .and_then(|mesh| mesh.with_attributes(attributes))
            .map_err(failed)?;
        files::write_content(path, &Content::Mesh(coloured), &WriteOptions::default())?.bytes
    } else {
        files::write(path, |out| {
            let mut out = std::io::BufWriter::new(out);
            writeln!(out, "vertex,x,y,z,distance")?;
            for (vertex, (point, value)) in mesh.vertices().iter().zip(values).enumerate() {
                let number =
                    |value: f64| if value.is_finite() { value.to_string() } else { "inf".to_owned() };
                writeln!(out, "{vertex},{},{},{},{}", point.x, point.y, point.z, number(*value))?;
            }
            out.flush()
        })?
    };
    let content = format!("{}: vertex,x,y,z,distance", counted(values.len(), "row"));
    report.add_output(Output { path: path.to_path_buf(), bytes, content });
    Ok(())
}

fn on_surface(
    job: &Job<'_>,
    shapes: Vec<Shape>,
    report: &mut Report,
    timings: &mut Timings,
) -> Result<GeodesicResults, Error> {
    let mut surfaces = shapes.into_iter().filter_map(|shape| match shape {
        Shape::Surface(surface) => Some(surface),
        _ => None,
    });
    let (Some(surface), None) = (surfaces.next(), surfaces.next()) else {
        let what = "a geodesic in parameters needs exactly one surface";
        return Err(Error::content(job.shape, what, "give a file with one surface, or a mesh of all"));
    };
    let parameters = |place: &Place| match place {
        Place::Parameters(parameters) => Ok(*parameters),
        _ => Err(Error::content(
            job.shape,
            "on a NURBS surface places are parameters",
            "give u,v (or write a mesh with `indgeo convert`)",
        )),
    };
    let ([from], [to]) = (job.from, job.to) else {
        let what = "a curve on a NURBS surface leads from one place to another";
        return Err(Error::usage(what, "give one --from u,v and one --to u,v"));
    };
    if job.picture.is_some() {
        let what = "pictures are drawn of distances on meshes";
        return Err(Error::usage(what, "leave out --picture, or write a mesh with `indgeo convert`"));
    }
    if let Some(path) = job.out
        && files::extension(path) != "csv"
        && !files::is_stream(path)
    {
        return Err(Error::content(path, "curves are CSV", "choose .csv"));
    }
    let (from, to) = (parameters(from)?, parameters(to)?);
    let found = Timings::measure(&mut timings.compute, || {
        surface_geodesic(&surface, from, to, job.metric, &GeodesicOptions::default())
    })
    .map_err(|error| refused(job.shape, &error, HELP))?;
    if let Some(path) = job.out {
        let bytes = files::write(path, |out| {
            let mut out = std::io::BufWriter::new(out);
            writeln!(out, "u,v,x,y,z")?;
            for ([u, v], x) in found.parameters.iter().zip(&found.points) {
                writeln!(out, "{u},{v},{},{},{}", x.x, x.y, x.z)?;
            }
            out.flush()
        })?;
        let content = format!("{}: u,v,x,y,z", counted(found.points.len(), "row"));
        report.add_output(Output { path: path.to_path_buf(), bytes, content });
    }
    let in_space = found.points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    let curve = CurveResult {
        length: Some(found.length),
        length_in_space: Some(in_space),
        is_geodesic: found.is_geodesic,
        length_error: Some(found.error),
        points: found.points.iter().map(|x: &Vector3<f64>| (*x).into()).collect(),
    };
    Ok(GeodesicResults {
        metric: job.choice.name(),
        w: job.metric.width(),
        method: "newton",
        vertices: None,
        unreachable: None,
        max: None,
        paths: vec![curve],
    })
}
