//! The fit of a surface: read, fit, write.

use crate::between_vertices::between_vertices;
use crate::error::Error;
use crate::files;
use crate::progress::Progress;
use crate::report::{Input, Output, Report, Results, Timings};
use crate::surface_start::{Start, from_cloud};
use industrial_geometry::fit::{
    Error as FitError, Status, StepRecord, SurfaceOptions, SurfaceReport, fit_surface_with_progress,
    with_controls,
};
use industrial_geometry::io::{self, Content, Model, ReadOptions, Shape, WriteOptions};
use industrial_geometry::nurbs::BsplineSurface;
use industrial_geometry::nurbs::nalgebra::Vector3;
use serde::Serialize;
use std::path::Path;

/// What is to be done.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// File of the points.
    pub(crate) points: &'a Path,
    /// File of the surface to start from.
    pub(crate) init: Option<&'a Path>,
    /// Control points that the surface to start from shall have.
    pub(crate) controls: Option<[usize; 2]>,
    /// File of the surface.
    pub(crate) out: Option<&'a Path>,
    /// Options of the library.
    pub(crate) options: SurfaceOptions,
    /// Whether nobody wants to watch.
    pub(crate) quiet: bool,
}

/// What a fit of a surface found.
#[derive(Debug, Serialize)]
pub(crate) struct SurfaceResults {
    /// What the library reports.
    #[serde(flatten)]
    pub(crate) fitted: SurfaceReport,
    /// Where it began, if no surface was given.
    pub(crate) start: Option<Start>,
    /// Points on the triangles of a thinned mesh that were taken besides its vertices.
    pub(crate) added: usize,
}

/// Does the job and fills in the report; returns whether the surface is what was asked for.
pub(crate) fn run(job: &Job<'_>, report: &mut Report) -> Result<bool, Error> {
    let inputs: Vec<&Path> = std::iter::once(job.points).chain(job.init).collect();
    files::check_inputs(&inputs)?;
    if let Some(path) = job.out {
        files::check_writable(path, &inputs)?;
    }
    let mut timings = Timings::default();
    let loaded = Timings::measure(&mut timings.read, || files::read(job.points, &ReadOptions::default()))?;
    report.inputs.push(Input::new("points", job.points, &loaded.report));
    let (mut points, triangles) = positions(&loaded.content, job.points)?;
    let vertices: Vec<_> = points.iter().map(|&p| p.into()).collect();
    let samples = between_vertices(&vertices, triangles, job.points, report);
    points.extend(&samples);
    let start = match job.init {
        Some(path) => Some(Timings::measure(&mut timings.read, || surface(path, report))?),
        None => None,
    };
    let progress = Progress::new("fitting", job.quiet);
    let tell = |_: &StepRecord| progress.tick();
    let mut from = None;
    let found = Timings::measure(&mut timings.compute, || match start {
        Some(start) => {
            let finite: Vec<_> = points.iter().filter(|p| p.iter().all(|c| c.is_finite())).copied().collect();
            let start = match job.controls {
                Some(controls) => with_controls(start, controls),
                None => Ok(start),
            };
            start.and_then(|start| fit_surface_with_progress(&finite, start, &job.options, &tell)).map(
                |mut found| {
                    found.report.dropped = points.len() - finite.len();
                    (found.surface, found.report)
                },
            )
        }
        None => from_cloud(&points, &job.options, &tell).map(|(surface, fitted, start)| {
            from = Some(start);
            (surface, fitted)
        }),
    });
    drop(progress);
    let (surface, fitted) = found.map_err(|error| refused(job, &error))?;
    if fitted.dropped > 0 {
        report.warnings.push(format!(
            "{}: {} of {} points have a coordinate that is NaN or infinite; they are left out",
            job.points.display(),
            fitted.dropped,
            points.len()
        ));
    }
    if let Some(start) = &from {
        start.warn(job.points, report);
    }
    if fitted.folds.count() > 0 {
        report.warnings.push(format!(
            "the surface folds back on itself in {} of {} cells; take fewer control points or a larger --smoothing",
            fitted.folds.count(),
            fitted.folds.cells
        ));
    }
    if let Some(path) = job.out {
        let written = Timings::measure(&mut timings.write, || {
            io::write_model(path, &Model::from(surface), &WriteOptions::default())
        })?;
        let content = format!("B-spline surface, {} × {}", fitted.controls[0], fitted.controls[1]);
        report.outputs.push(Output { path: path.to_path_buf(), bytes: written.bytes, content });
    }
    report.timings = timings;
    let failed = matches!(fitted.fit.status, Status::Diverged | Status::Singular);
    let good = fitted.within_tolerance && !failed;
    report.results =
        Some(Results::Surface(Box::new(SurfaceResults { fitted, start: from, added: samples.len() })));
    Ok(good)
}

/// The points of a file and the triangles over them, if there are any.
fn positions<'a>(content: &'a Content, path: &Path) -> Result<(Vec<Vector3<f64>>, &'a [[u32; 3]]), Error> {
    let (cloud, triangles): (_, &[_]) = match content {
        Content::Cloud(cloud) => (cloud, &[]),
        Content::Mesh(mesh) => (mesh.cloud(), mesh.triangles()),
        Content::Nurbs(_) => {
            let what = "points are needed, but this file holds NURBS shapes";
            return Err(Error::content(path, what, "give a cloud or a mesh"));
        }
    };
    if cloud.dimension() == 2 {
        let what = "the points have two columns only";
        return Err(Error::content(path, what, "give points of three columns, x, y and z"));
    }
    Ok((cloud.positions().iter().map(|point| point.coords).collect(), triangles))
}

/// The first surface of a NURBS file.
fn surface(path: &Path, report: &mut Report) -> Result<BsplineSurface, Error> {
    let loaded = files::read(path, &ReadOptions::default())?;
    report.inputs.push(Input::new("init", path, &loaded.report));
    let Content::Nurbs(model) = loaded.content else {
        let what = "a surface is needed, but this file holds none";
        return Err(Error::content(path, what, "give a NURBS surface (JSON)"));
    };
    let surfaces = model.into_shapes().into_iter().filter_map(|shape| match shape {
        Shape::Surface(surface) => Some(surface),
        _ => None,
    });
    surfaces.into_iter().next().ok_or_else(|| {
        Error::content(path, "a surface is needed, but this file holds none", "give a NURBS surface (JSON)")
    })
}

/// The error of the library, with the file that it is about.
fn refused(job: &Job<'_>, error: &FitError) -> Error {
    match error {
        FitError::Rational => {
            Error::content(job.init.unwrap_or(job.points), error.to_string(), "give a start without weights")
        }
        FitError::Option { .. } | FitError::Shape(_) => {
            Error::usage(error.to_string(), "see `indgeo fit-surface --help`")
        }
        _ => Error::content(job.points, error.to_string(), "check it with `indgeo info`"),
    }
}
