//! Surfaces by type in clouds and meshes: read, segment, write.

mod output;
pub(crate) mod summary;

use crate::error::Error;
use crate::files;
use crate::input::points::Points;
use crate::on_surface::picture::{self, Shown};
use crate::report::wording::counted;
use crate::report::{Input, Output, Report, Timings};
use industrial_geometry::mesh::TriangleMesh;
use industrial_geometry::mesh::nalgebra::{Point3, Vector3};
use industrial_geometry::segmentation::{
    Error as SegmentationError, RegionReport, SegmentationOptions, Shape, segment,
};
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::path::Path;

const HELP: &str = "see `indgeo segment --help`";

/// What is to be done.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// File of the cloud or mesh.
    pub(crate) points: &'a Path,
    pub(crate) options: SegmentationOptions,
    /// File of the labels.
    pub(crate) out: Option<&'a Path>,
    /// File of the picture.
    pub(crate) picture: Option<&'a Path>,
}

/// What was found.
#[derive(Debug, Serialize)]
pub(crate) struct SegmentationResults {
    pub(crate) points: usize,
    /// Points without a region.
    pub(crate) unlabelled: usize,
    /// Standard deviation of the noise.
    pub(crate) sigma: f64,
    /// Median spacing of the points.
    pub(crate) spacing: f64,
    /// Number of regions of each type, as text for a person.
    #[serde(skip)]
    pub(crate) types: Vec<(&'static str, usize)>,
    /// The regions, the largest first.
    pub(crate) primitives: Vec<Value>,
}

/// Does the job and fills in the report; returns whether every point has a region.
pub(crate) fn run(job: &Job<'_>, report: &mut Report) -> Result<bool, Error> {
    for path in [job.out, job.picture].into_iter().flatten() {
        files::check_writable(path, &[job.points])?;
    }
    if let Some(path) = job.out
        && !matches!(files::extension(path).as_str(), "csv" | "ply")
        && !files::is_stream(path)
    {
        return Err(Error::content(path, "labels are PLY or CSV", "choose .ply or .csv"));
    }
    if let Some(path) = job.picture {
        picture::check(path)?;
    }
    let mut timings = Timings::default();
    let points = Timings::measure(&mut timings.read, || Points::read(job.points, false, None))?;
    report.add_input(Input::new("points", job.points, &points.report));
    let warnings = &points.report.warnings;
    report.warnings.extend(warnings.iter().map(|warning| format!("{}: {warning}", job.points.display())));
    points.check_space(job.points)?;
    let failed =
        |error: industrial_geometry::mesh::Error| Error::content(job.points, error.to_string(), HELP);
    let mesh = match job.picture {
        Some(path) if points.triangles.is_empty() => {
            return Err(Error::content(
                path,
                "a picture needs triangles",
                "leave out --picture, or give a mesh",
            ));
        }
        Some(path) => {
            let mesh =
                TriangleMesh::new(points.positions.clone(), points.triangles.clone()).map_err(failed)?;
            Some((path, mesh))
        }
        None => None,
    };
    let normals = match &points.normals {
        Some(normals) => Some(normals.clone()),
        None => vertex_normals(&points.positions, &points.triangles),
    };
    let found = Timings::measure(&mut timings.compute, || {
        segment(&points.positions, normals.as_deref(), &job.options)
    })
    .map_err(|error| refused(job.points, &error))?;
    let labels: Vec<i64> = found.labels.iter().map(|label| label.map_or(-1, i64::from)).collect();
    let mut seconds = timings.write;
    Timings::measure(&mut seconds, || -> Result<(), Error> {
        if let Some((path, mesh)) = &mesh {
            picture::write(path, mesh, &Shown::Labels(&labels), &[], "picture: regions", report)?;
        }
        let Some(path) = job.out else { return Ok(()) };
        let bytes = if files::extension(path) == "ply" {
            files::write(path, |out| output::write_ply(out, &points.positions, &points.triangles, &labels))?
        } else {
            files::write(path, |out| output::write_csv(out, &points.positions, &labels))?
        };
        let content = format!("{} with labels", counted(labels.len(), "point"));
        report.add_output(Output { path: path.to_path_buf(), bytes, content });
        Ok(())
    })?;
    timings.write = seconds;
    report.timings = timings;
    let unlabelled = found.unlabelled();
    if unlabelled > 0 {
        report.warnings.push(format!(
            "{} of {} on no surface that was found: label -1",
            counted(unlabelled, "point"),
            labels.len()
        ));
    }
    let mut types: Vec<(&'static str, usize)> = Vec::new();
    for region in &found.regions {
        match types.iter_mut().find(|(name, _)| *name == region.shape.name()) {
            Some((_, count)) => *count += 1,
            None => types.push((region.shape.name(), 1)),
        }
    }
    report.results = Some(Box::new(SegmentationResults {
        points: labels.len(),
        unlabelled,
        sigma: found.sigma,
        spacing: found.spacing,
        types,
        primitives: found.regions.iter().map(primitive).collect(),
    }));
    Ok(unlabelled == 0)
}

/// Normals of the vertices, weighted by the areas of the triangles; `None` for a cloud.
fn vertex_normals(points: &[Point3<f64>], triangles: &[[u32; 3]]) -> Option<Vec<Vector3<f64>>> {
    if triangles.is_empty() {
        return None;
    }
    let mut normals = vec![Vector3::zeros(); points.len()];
    for corners in triangles {
        let [a, b, c] = corners.map(|k| points[k as usize]);
        let normal = (b - a).cross(&(c - a));
        for k in corners {
            normals[*k as usize] += normal;
        }
    }
    normals.iter().all(|n: &Vector3<f64>| n.iter().all(|c| c.is_finite())).then_some(normals)
}

/// The error of the library, with the file that it is about.
fn refused(path: &Path, error: &SegmentationError) -> Error {
    match error {
        SegmentationError::Option { name, value, allowed } => {
            let option = name.replace('_', "-");
            Error::usage(format!("--{option} is {value}, but must be {allowed}"), HELP)
        }
        other => Error::content(path, other.to_string(), HELP),
    }
}

/// A region as an object: its parameters both as members and in `parameters`.
fn primitive(region: &RegionReport) -> Value {
    let parameters = parameters(&region.shape);
    let mut object = Map::new();
    object.insert("label".to_owned(), json!(region.label));
    object.insert("type".to_owned(), json!(region.shape.name()));
    object.extend(parameters.clone());
    object.insert("parameters".to_owned(), Value::Object(parameters));
    object.insert("covariance".to_owned(), json!(region.covariance));
    object.insert("rms".to_owned(), json!(region.rms));
    object.insert("support".to_owned(), json!(region.support));
    object.insert("chi2".to_owned(), json!(region.chi2));
    let other = region.runner_up.map(|other| json!({"type": other.name, "chi2": other.chi2}));
    object.insert("runner_up".to_owned(), json!(other));
    Value::Object(object)
}

fn parameters(shape: &Shape) -> Map<String, Value> {
    let mut map = Map::new();
    let mut put = |name: &str, value: Value| map.insert(name.to_owned(), value);
    let place = |p: &Point3<f64>| json!([p.x, p.y, p.z]);
    let direction = |v: &Vector3<f64>| json!([v.x, v.y, v.z]);
    match shape {
        Shape::Plane { point, normal } => {
            put("point", place(point));
            put("normal", direction(normal));
        }
        Shape::Cylinder { point, axis, radius } => {
            put("point", place(point));
            put("axis", direction(axis));
            put("radius", json!(radius));
        }
        Shape::Cone { point, axis, half_angle } => {
            put("point", place(point));
            put("axis", direction(axis));
            put("half_angle", json!(half_angle));
        }
        Shape::Sphere { point, radius } => {
            put("point", place(point));
            put("radius", json!(radius));
        }
        Shape::Torus { point, axis, radius, minor_radius } => {
            put("point", place(point));
            put("axis", direction(axis));
            put("radius", json!(radius));
            put("minor_radius", json!(minor_radius));
        }
        Shape::Extrusion { axis } => {
            put("axis", direction(axis));
        }
        Shape::Revolution { point, axis } => {
            put("point", place(point));
            put("axis", direction(axis));
        }
        Shape::Helix { point, axis, pitch } => {
            put("point", place(point));
            put("axis", direction(axis));
            put("pitch", json!(pitch));
        }
        _ => {}
    }
    map
}
