//! Distances, curves and regions on surfaces, in the Euclidean or the feature sensitive metric.

pub(crate) mod labels;
pub(crate) mod picture;

use crate::error::Error;
use crate::files;
use crate::report::{Input, Report, Timings};
use industrial_geometry::feature_metric::{Error as MetricError, Metric};
use industrial_geometry::io::{Content, ReadOptions};
use industrial_geometry::mesh::TriangleMesh;
use std::path::Path;

/// The metric, by its name on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum MetricChoice {
    /// Lengths in space
    Euclidean,
    /// Lengths on the image (x, w n): curves across features are long
    Feature,
}

impl MetricChoice {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Euclidean => "euclidean",
            Self::Feature => "feature",
        }
    }

    /// The metric with a width.
    pub(crate) fn metric(self, width: Option<f64>) -> Result<Metric, Error> {
        match (self, width) {
            (Self::Euclidean, None) => Ok(Metric::Euclidean),
            (Self::Feature, Some(width)) => Ok(Metric::Feature { width }),
            (Self::Euclidean, Some(_)) => {
                Err(Error::usage("--w has no effect in the Euclidean metric", "add --metric feature"))
            }
            (Self::Feature, None) => Err(Error::usage(
                "--metric feature needs the radius below which a fillet counts as a feature",
                "add --w LENGTH",
            )),
        }
    }
}

/// Reads a file and notes it in the report.
pub(crate) fn read(path: &Path, report: &mut Report, timings: &mut Timings) -> Result<Content, Error> {
    let loaded = Timings::measure(&mut timings.read, || files::read(path, &ReadOptions::default()))?;
    report.add_input(Input::new("model", path, &loaded.report));
    report
        .warnings
        .extend(loaded.report.warnings.iter().map(|warning| format!("{}: {warning}", path.display())));
    Ok(loaded.content)
}

/// The mesh of a file that was read.
pub(crate) fn mesh_of(content: Content, path: &Path) -> Result<TriangleMesh, Error> {
    match content {
        Content::Mesh(mesh) => Ok(mesh),
        Content::Cloud(_) => Err(Error::content(
            path,
            "the file holds points without triangles, but a surface is needed",
            "give a triangle mesh",
        )),
        Content::Nurbs(_) => Err(Error::content(
            path,
            "the file holds NURBS shapes, but a triangle mesh is needed",
            "write one with `indgeo convert surface.json mesh.ply --chord LENGTH`",
        )),
    }
}

/// The error of the library, with the file that it is about.
pub(crate) fn refused(path: &Path, error: &MetricError, help: &'static str) -> Error {
    match error {
        MetricError::Option { name, value, allowed } => {
            Error::option(if *name == "width" { "w" } else { name }, *value, allowed, help)
        }
        MetricError::Vertex { .. } | MetricError::Parameters { .. } | MetricError::Corners { .. } => {
            Error::content(path, error.to_string(), help)
        }
        MetricError::NotADisc { .. } => {
            let what = "cut it open, close its holes, or give one part: `indgeo info` lists parts and holes";
            Error::content(path, error.to_string(), what)
        }
        _ => Error::content(path, error.to_string(), "check it with `indgeo info`"),
    }
}

/// Says where a mesh is cut because it is no manifold.
pub(crate) fn warn_of_cuts(is_manifold: bool, path: &Path, report: &mut Report) {
    if !is_manifold {
        report.warnings.push(format!(
            "{}: edges of more than two triangles, or with triangles of opposite sides, count as boundaries",
            path.display()
        ));
    }
}
