//! Regions on meshes, made larger and smaller: read, compute, write.

use crate::error::Error;
use crate::files;
use crate::on_surface::picture::{self, Shown};
use crate::on_surface::{MetricChoice, labels, mesh_of, read, refused, warn_of_cuts};
use crate::report::wording::counted;
use crate::report::{Output, Report, Timings};
use industrial_geometry::feature_metric::{Error as MetricError, Metric, MetricMesh, Operation};
use industrial_geometry::io::{Content, WriteOptions};
use serde::Serialize;
use std::collections::BTreeSet;
use std::io::Write;
use std::path::Path;

const HELP: &str = "see `indgeo morphology --help`";

/// What is done to every region.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum OperationChoice {
    /// Grow by the radius, into vertices without a region
    Dilate,
    /// Shrink by the radius
    Erode,
    /// Erode, then dilate: thin parts go
    Open,
    /// Dilate, then erode: narrow gaps go
    Close,
}

impl OperationChoice {
    fn name(self) -> &'static str {
        match self {
            Self::Dilate => "dilate",
            Self::Erode => "erode",
            Self::Open => "open",
            Self::Close => "close",
        }
    }

    fn operation(self) -> Operation {
        match self {
            Self::Dilate => Operation::Dilate,
            Self::Erode => Operation::Erode,
            Self::Open => Operation::Open,
            Self::Close => Operation::Close,
        }
    }
}

/// What is to be done.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// File of the mesh.
    pub(crate) mesh: &'a Path,
    /// Name of a scalar of it, or file of labels.
    pub(crate) regions: &'a Path,
    pub(crate) operation: OperationChoice,
    pub(crate) radius: f64,
    pub(crate) choice: MetricChoice,
    pub(crate) metric: Metric,
    /// File of the mesh with its new labels, or of the labels.
    pub(crate) out: Option<&'a Path>,
    /// File of the picture.
    pub(crate) picture: Option<&'a Path>,
}

/// Vertices of a region.
#[derive(Debug, Serialize)]
pub(crate) struct RegionResult {
    pub(crate) label: i64,
    pub(crate) vertices_before: usize,
    pub(crate) vertices_after: usize,
}

/// What was found.
#[derive(Debug, Serialize)]
pub(crate) struct MorphologyResults {
    pub(crate) operation: &'static str,
    pub(crate) radius: f64,
    pub(crate) metric: &'static str,
    /// The width `w`, 0 in the Euclidean metric.
    pub(crate) w: f64,
    pub(crate) vertices: usize,
    /// Every region, by its label.
    pub(crate) regions: Vec<RegionResult>,
}

/// Does the job and fills in the report.
pub(crate) fn run(job: &Job<'_>, report: &mut Report) -> Result<(), Error> {
    for path in [job.out, job.picture].into_iter().flatten() {
        files::check_writable(path, &[job.mesh, job.regions])?;
    }
    if let Some(path) = job.out
        && !matches!(files::extension(path).as_str(), "csv" | "ply")
        && !files::is_stream(path)
    {
        return Err(Error::content(path, "regions are PLY or CSV", "choose .ply or .csv"));
    }
    if let Some(path) = job.picture {
        picture::check(path)?;
    }
    let mut timings = Timings::default();
    let mesh = mesh_of(read(job.mesh, report, &mut timings)?, job.mesh)?;
    let before = labels::read(job.regions, &mesh, job.mesh)?;
    let failed = |error| refused(job.mesh, &error, HELP);
    let metric_mesh =
        Timings::measure(&mut timings.build, || MetricMesh::new(&mesh, job.metric)).map_err(failed)?;
    warn_of_cuts(metric_mesh.is_manifold(), job.mesh, report);
    let after =
        Timings::measure(&mut timings.compute, || moved(job, &metric_mesh, &before)).map_err(failed)?;
    let names: BTreeSet<i64> = before.iter().copied().filter(|label| *label != 0).collect();
    let count = |labels: &[i64], label: i64| labels.iter().filter(|other| **other == label).count();
    let regions = names.iter().map(|&label| RegionResult {
        label,
        vertices_before: count(&before, label),
        vertices_after: count(&after, label),
    });
    let results = MorphologyResults {
        operation: job.operation.name(),
        radius: job.radius,
        metric: job.choice.name(),
        w: job.metric.width(),
        vertices: before.len(),
        regions: regions.collect(),
    };
    let mut seconds = timings.write;
    let values: Vec<f64> = after.iter().map(|&label| label as f64).collect();
    if let Some(path) = job.picture {
        // Vertices without a region are grey.
        let shown: Vec<i64> = after.iter().map(|&label| if label == 0 { -1 } else { label }).collect();
        picture::write(path, &mesh, &Shown::Labels(&shown), &[], "picture: regions", report)?;
    }
    Timings::measure(&mut seconds, || -> Result<(), Error> {
        let Some(path) = job.out else { return Ok(()) };
        let bytes = if files::extension(path) == "ply" {
            let mut attributes = mesh.attributes().clone();
            let failed =
                |error: industrial_geometry::mesh::Error| Error::content(path, error.to_string(), HELP);
            attributes.remove_scalar("label");
            attributes.push_scalar("label", values).map_err(failed)?;
            let labelled = mesh.with_attributes(attributes).map_err(failed)?;
            files::write_content(path, &Content::Mesh(labelled), &WriteOptions::default())?.bytes
        } else {
            files::write(path, |out| {
                let mut out = std::io::BufWriter::new(out);
                writeln!(out, "vertex,x,y,z,label")?;
                for (vertex, (point, label)) in mesh.vertices().iter().zip(&after).enumerate() {
                    writeln!(out, "{vertex},{},{},{},{label}", point.x, point.y, point.z)?;
                }
                out.flush()
            })?
        };
        let content = format!("{} with labels", counted(after.len(), "vertex"));
        report.add_output(Output { path: path.to_path_buf(), bytes, content });
        Ok(())
    })?;
    timings.write = seconds;
    report.timings = timings;
    report.results = Some(Box::new(results));
    Ok(())
}

/// The labels after the operation. Regions do not grow over each other: where several reach a vertex without a region, it goes to
/// the one with the smallest label of those that are nearest.
fn moved(job: &Job<'_>, mesh: &MetricMesh, before: &[i64]) -> Result<Vec<i64>, MetricError> {
    let names: BTreeSet<i64> = before.iter().copied().filter(|label| *label != 0).collect();
    let mut after: Vec<i64> = before.to_vec();
    let mut nearest = vec![f64::INFINITY; before.len()];
    for label in names {
        let region: Vec<bool> = before.iter().map(|other| *other == label).collect();
        let grown = mesh.morphology(&region, job.operation.operation(), job.radius)?;
        let sources: Vec<usize> = (0..region.len()).filter(|&vertex| region[vertex]).collect();
        let adds = grown.iter().zip(&region).any(|(after, before)| *after && !before);
        let distances = if adds { mesh.distances_from_region(&sources)?.values } else { Vec::new() };
        for vertex in 0..before.len() {
            if region[vertex] && !grown[vertex] {
                after[vertex] = 0;
            } else if grown[vertex] && before[vertex] == 0 && distances[vertex] < nearest[vertex] {
                (after[vertex], nearest[vertex]) = (label, distances[vertex]);
            }
        }
    }
    Ok(after)
}
