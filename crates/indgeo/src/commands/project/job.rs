//! The main job: read a model and points, project, write, report. `project` and `demo` both run this.

use super::request::Job;
use crate::commands::project::pieces;
use crate::commands::project::results::{ProjectionResults, ResultsSum};
use crate::error::Error;
use crate::files;
use crate::input::cad::CadModel;
use crate::input::model::{Loaded, Model};
use crate::input::points::Points;
use crate::input::target::{Foot, Target};
use crate::output::{self, Format, Layout, NAME, Table};
use crate::report::wording::{counted, not_finite};
use crate::report::{Input, ModelSummary, Options, Output, Report, Timings};
use crate::runtime::progress::Progress;
use industrial_geometry::footpoint::{Mode, Status};
use industrial_geometry::io::ReadReport;
use std::path::Path;

/// Names of the statuses that leave nothing to be wished for; there is no answer for a point that is not finite, or lacks
/// the normal that is to agree.
const GOOD: [&str; 4] = ["converged", "on_boundary", "invalid_point", "no_normal"];

/// Name of the status of points with a foot whose proof is not complete.
const UNPROVEN: &str = "uncertified";

/// Points and their footpoints, after everything has been written.
#[derive(Debug)]
pub(crate) struct Projected {
    /// The points.
    pub(crate) points: Points,
    /// One footpoint per point.
    pub(crate) feet: Vec<Foot>,
    /// The columns of the result.
    pub(crate) layout: Layout,
}

/// Does the job and fills in the report; the points are read, projected and written piece by piece where their format and that of the
/// result allow it, with the same bytes.
pub(crate) fn run_in_pieces(job: &Job<'_>, report: &mut Report) -> Result<(), Error> {
    let format = Format::of(job.out, job.format)?;
    let is_kept = files::is_stream(job.points) || crate::runtime::memory::is_memory(job.points);
    if is_kept || !output::is_written_in_pieces(format) {
        return run(job, report).map(|_| ());
    }
    let prepared = Prepared::new(job, report)?;
    match pieces::survey(job, &prepared)? {
        Some(survey) => pieces::run(job, prepared, &survey, format, report),
        None => finish(job, prepared, format, report).map(|_| ()),
    }
}

/// Does the job in memory and fills in the report.
pub(crate) fn run(job: &Job<'_>, report: &mut Report) -> Result<Projected, Error> {
    let format = Format::of(job.out, job.format)?;
    finish(job, Prepared::new(job, report)?, format, report)
}

/// A model that is ready for projections.
pub(crate) struct Prepared {
    pub(crate) target: Target,
    pub(crate) layout: Layout,
    /// Kind and name of each shape.
    pub(crate) shapes: Vec<(&'static str, Option<String>)>,
    warnings: Vec<String>,
    /// Of a CAD model, which knows about units.
    cad: Option<CadModel>,
    pub(crate) timings: Timings,
}

impl Prepared {
    fn new(job: &Job<'_>, report: &mut Report) -> Result<Self, Error> {
        files::check_inputs(&[job.model, job.points])?;
        files::check_writable(job.out, &[job.model, job.points])?;
        let mut timings = Timings::default();
        let loaded = Timings::measure(&mut timings.read, || Loaded::read(job.model, job.cad))?;
        report.add_input(loaded.input(job.model));
        let (shapes, warnings) = (loaded.shapes, loaded.report.warnings);
        let cad = match &loaded.model {
            Model::Cad(cad) => Some(cad.clone()),
            _ => None,
        };
        let target = Timings::measure(&mut timings.build, || Target::build(loaded.model, job.model))?;
        if job.max_angle.is_some() {
            target.check_normals(job.model)?;
        }
        let layout = Layout::of(&target, shapes.len());
        Ok(Self { target, layout, shapes, warnings, cad, timings })
    }

    /// Describes the job in the report, when the points are known.
    pub(crate) fn describe(&self, job: &Job<'_>, read: &ReadReport, diagonal: f64, report: &mut Report) {
        report.add_input(Input::new("points", job.points, read));
        warn(report, job, &self.warnings, read);
        report.warn_now(self.cad.as_ref().and_then(|cad| cad.unit_warning(diagonal)), job.quiet);
        if matches!(self.target, Target::LevelSet(_)) && job.options.mode == Mode::Certified {
            report.warnings.push(format!(
                "{}: there is no proof for the nearest point of a level set; --mode fast asks for none",
                job.model.display()
            ));
        }
        report.model = Some(summarise(&self.target, self.shapes.len()));
        report.options = Some(Options {
            mode: job.mode.name(),
            relative_gap: job.options.relative_gap,
            threads: job.threads,
            transform: None,
        });
    }
}

/// Says that a cloud has no normals, where they are needed.
pub(crate) fn no_normals(path: &Path) -> Error {
    let advice = "leave out --max-angle, or give a file with normals (nx, ny, nz)";
    Error::content(path, "the points have no normals", advice)
}

fn finish(
    job: &Job<'_>,
    prepared: Prepared,
    format: Format,
    report: &mut Report,
) -> Result<Projected, Error> {
    let mut timings = prepared.timings;
    let mut points =
        Timings::measure(&mut timings.read, || Points::read(job.points, job.drop_non_finite, job.scan))?;
    if job.max_angle.is_none() {
        points.normals = None;
    } else if points.normals.is_none() {
        return Err(no_normals(job.points));
    }
    prepared.describe(job, &points.report, points.diagonal(), report);
    let progress = Progress::new("projecting", job.quiet);
    let feet = Timings::measure(&mut timings.compute, || {
        let tell = |done: usize, total: usize| progress.report(done, total);
        prepared.target.project(&points, job.points, &job.options, job.max_angle, &tell)
    })?;
    drop(progress);
    report.points_per_second = (timings.compute > 0.0).then(|| feet.len() as f64 / timings.compute);
    let mut sum = ResultsSum::of(&prepared.target);
    Timings::measure(&mut timings.compute, || sum.add(&points, &feet));
    report.timings = timings;
    let projected = Projected { points, feet, layout: prepared.layout };
    write(job.out, format, &projected, report)?;
    let columns = columns(&projected);
    let results = Timings::measure(&mut report.timings.compute, || {
        sum.finish(job, &projected.points.report, columns, &prepared.shapes)
    });
    conclude(job, results, report);
    Ok(projected)
}

/// Says what is wrong with the results, and puts them into the report.
pub(crate) fn conclude(job: &Job<'_>, results: ProjectionResults, report: &mut Report) {
    if let Some(count) = results.undecided_sides.filter(|count| *count > 0) {
        report.warnings.push(format!(
            "{count} of {} have distances without a sign: on which side of the model they lie is not known (column side)",
            counted(results.points, "point")
        ));
    }
    let open = results.status.get(Status::Uncertified.name()).copied().unwrap_or(0);
    if open > 0 {
        report.warnings.push(format!(
            "{open} of {} are uncertified: another point of the model may be nearer, down to lower_bound in their rows \
             (exit status 1)",
            counted(results.points, "point")
        ));
    }
    let bad: usize = results.status.iter().filter(|(name, _)| !GOOD.contains(name)).map(|(_, n)| n).sum();
    let failed = bad - open;
    if failed > 0 {
        report.warnings.push(format!(
            "{failed} of {} did not converge; the column status says how (exit status 1)",
            counted(results.points, "point")
        ));
    }
    if let Some(&count) = results.status.get("no_normal") {
        report.warnings.push(format!(
            "{}: {count} of {} have a normal that is zero or not finite (no_normal); they are not projected",
            job.points.display(),
            counted(results.points, "point")
        ));
    }
    report.count_points("points", results.points_dropped, results.points_used);
    report.results = Some(Box::new(results));
}

/// Writes the result once more, in the format of another extension.
pub(crate) fn write_also(path: &Path, projected: &Projected, report: &mut Report) -> Result<(), Error> {
    write(path, Format::of(path, None)?, projected, report)
}

fn write(path: &Path, format: Format, projected: &Projected, report: &mut Report) -> Result<(), Error> {
    let Projected { points, feet, layout } = projected;
    let table = Table {
        layout,
        points: &points.positions,
        point_names: points.names.as_ref(),
        feet,
        triangles: &points.triangles,
    };
    let written = Timings::measure(&mut report.timings.write, || output::write(path, format, &table))?;
    let content = format!("{}: {}", counted(feet.len(), "row"), columns(projected).join(","));
    report.warnings.extend(written.warnings);
    report.add_output(Output { path: path.to_path_buf(), bytes: written.bytes, content });
    Ok(())
}

/// The columns of the result.
fn columns(projected: &Projected) -> Vec<&'static str> {
    let name = projected.points.names.as_ref().map(|_| NAME);
    projected.layout.names().into_iter().chain(name).collect()
}

/// Whether every finite point of the projection in the report converged and has the certificate that was asked for.
pub(crate) fn all_converged(report: &Report) -> bool {
    let Some(results) = report.found::<ProjectionResults>() else { return true };
    results.status.keys().all(|name| GOOD.contains(name))
}

/// What the report calls a projection that is not done.
pub(crate) fn otherwise(report: &Report) -> &'static str {
    let Some(results) = report.found::<ProjectionResults>() else { return "not_converged" };
    let mut failed = results.status.keys().filter(|name| !GOOD.contains(name));
    if failed.all(|name| *name == UNPROVEN) { "not_proven" } else { "not_converged" }
}

fn warn(report: &mut Report, job: &Job<'_>, of_model: &[String], read: &ReadReport) {
    for (path, warnings) in [(job.model, of_model), (job.points, &read.warnings)] {
        let warnings = warnings.iter().map(|warning| format!("{}: {warning}", path.display()));
        report.warnings.extend(warnings);
    }
    if read.non_finite > 0 {
        let fate = if read.dropped > 0 {
            "left out, so that rows of the result are numbered anew"
        } else {
            "kept as rows with the status invalid_point and no values (--drop-non-finite leaves them out)"
        };
        report.warnings.push(not_finite(job.points, read.non_finite, read.points, fate));
    }
}

fn summarise(target: &Target, shapes: usize) -> ModelSummary {
    let (kind, dimension, signed) = match target {
        Target::Plane(_) => ("nurbs", 2, false),
        Target::Space { surfaces, .. } => ("nurbs", 3, surfaces.is_some()),
        Target::Mesh(mesh) => ("mesh", 3, mesh.is_solid()),
        Target::Cad(_) => ("cad", 3, true),
        Target::LevelSet(_) => ("level_set", if target.is_planar() { 2 } else { 3 }, true),
    };
    let (unit, points_unit) = match target {
        Target::Cad(cad) => (Some(cad.unit().to_owned()), Some(cad.points_unit())),
        _ => (None, None),
    };
    ModelSummary { kind, unit, points_unit, dimension, shapes, patches: target.piece_count(), signed }
}
