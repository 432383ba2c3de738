//! The main job: read a model and points, project, write, report. `project` and `demo` both run this.

use crate::cad::Choice;
use crate::commands::project::SearchMode;
use crate::error::Error;
use crate::files;
use crate::model::{Loaded, Model};
use crate::output::{self, Format, Layout, NAME, Table};
use crate::points::Points;
use crate::progress::Progress;
use crate::report::{
    Input, ModelSummary, Options, Output, ProjectionResults, Report, Results, ShapeResults, Timings, Worst,
};
use crate::target::{Foot, Target};
use crate::wording::{counted, not_finite};
use industrial_geometry::footpoint::{Multiplicity, ProjectionOptions, Status};
use industrial_geometry::inspection::Statistics;
use std::collections::BTreeMap;
use std::path::Path;

/// Names of the statuses that leave nothing to be wished for; there is no answer for a point that is not finite, or lacks
/// the normal that is to agree.
const GOOD: [&str; 4] = ["converged", "on_boundary", "invalid_point", "no_normal"];

/// Share of the diagonal of a CAD model above which gaps are counted.
const WIDE_GAP: f64 = 1e-7;

/// Name of the status of points with a foot whose proof is not complete.
const UNPROVEN: &str = "uncertified";

/// What is to be done.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// File of the model.
    pub(crate) model: &'a Path,
    /// What is chosen of a CAD model.
    pub(crate) cad: &'a Choice,
    /// File of the points.
    pub(crate) points: &'a Path,
    /// File of the result.
    pub(crate) out: &'a Path,
    /// Its format, if not that of the extension.
    pub(crate) format: Option<Format>,
    /// Options of the library.
    pub(crate) options: ProjectionOptions,
    /// Largest angle, in radians, between the normals of points and feet.
    pub(crate) max_angle: Option<f64>,
    /// The mode, by its name on the command line.
    pub(crate) mode: SearchMode,
    /// Whether points that are not finite are left out.
    pub(crate) drop_non_finite: bool,
    /// The scan that is read of a file of several.
    pub(crate) scan: Option<&'a str>,
    /// Number of threads asked for.
    pub(crate) threads: Option<u16>,
    /// Whether nobody wants to watch.
    pub(crate) quiet: bool,
}

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

/// Does the job and fills in the report.
pub(crate) fn run(job: &Job<'_>, report: &mut Report) -> Result<Projected, Error> {
    let format = Format::of(job.out, job.format)?;
    files::check_inputs(&[job.model, job.points])?;
    files::check_writable(job.out, &[job.model, job.points])?;

    let mut timings = Timings::default();
    let loaded = Timings::measure(&mut timings.read, || Loaded::read(job.model, job.cad))?;
    report.add_input(loaded.input(job.model));
    let mut points =
        Timings::measure(&mut timings.read, || Points::read(job.points, job.drop_non_finite, job.scan))?;
    if job.max_angle.is_none() {
        points.normals = None;
    } else if points.normals.is_none() {
        let advice = "leave out --max-angle, or give a file with normals (nx, ny, nz)";
        return Err(Error::content(job.points, "the points have no normals", advice));
    }
    report.add_input(Input::new("points", job.points, &points.report));
    report.timings = timings;
    warn(report, job, &loaded, &points);

    if let Model::Cad(cad) = &loaded.model {
        report.warn_now(cad.unit_warning(points.diagonal()), job.quiet);
    }
    let shapes = loaded.shapes;
    let target = Timings::measure(&mut timings.build, || Target::build(loaded.model, job.model))?;
    if job.max_angle.is_some() {
        target.check_normals(job.model)?;
    }
    let layout = Layout::of(&target, shapes.len());
    report.model = Some(summarise(&target, shapes.len()));
    report.options = Some(Options {
        mode: job.mode.name(),
        relative_gap: job.options.relative_gap,
        threads: job.threads,
        transform: None,
    });
    let progress = Progress::new("projecting", job.quiet);
    let feet = Timings::measure(&mut timings.compute, || {
        let tell = |done: usize, total: usize| progress.report(done, total);
        target.project(&points, job.points, &job.options, job.max_angle, &tell)
    })?;
    drop(progress);
    report.points_per_second = (timings.compute > 0.0).then(|| feet.len() as f64 / timings.compute);

    report.timings = timings;
    let projected = Projected { points, feet, layout };
    write(job.out, format, &projected, report)?;
    let mut results = results(&projected, job, &shapes);
    if let Target::Cad(cad) = &target {
        let feet = projected.feet.iter().filter(|foot| foot.exists());
        let wide = WIDE_GAP * cad.model.bounds().diagonal();
        results.wide_gaps = Some(feet.clone().filter(|foot| foot.gap() > wide).count());
        results.undecided_sides = Some(feet.filter(|foot| foot.side == "undecided").count());
    }
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
    report.results = Some(Results::Projection(Box::new(results)));
    Ok(projected)
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
    let Some(Results::Projection(results)) = &report.results else { return true };
    results.status.keys().all(|name| GOOD.contains(name))
}

/// What the report calls a projection that is not done.
pub(crate) fn otherwise(report: &Report) -> &'static str {
    let Some(Results::Projection(results)) = &report.results else { return "not_converged" };
    let mut failed = results.status.keys().filter(|name| !GOOD.contains(name));
    if failed.all(|name| *name == UNPROVEN) { "not_proven" } else { "not_converged" }
}

fn warn(report: &mut Report, job: &Job<'_>, loaded: &Loaded, points: &Points) {
    for (path, read) in [(job.model, &loaded.report), (job.points, &points.report)] {
        let warnings = read.warnings.iter().map(|warning| format!("{}: {warning}", path.display()));
        report.warnings.extend(warnings);
    }
    let read = &points.report;
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
    };
    let (unit, points_unit) = match target {
        Target::Cad(cad) => (Some(cad.unit().to_owned()), Some(cad.points_unit())),
        _ => (None, None),
    };
    ModelSummary { kind, unit, points_unit, dimension, shapes, patches: target.piece_count(), signed }
}

fn results(
    projected: &Projected,
    job: &Job<'_>,
    shapes: &[(&'static str, Option<String>)],
) -> ProjectionResults {
    let Projected { points, feet, .. } = projected;
    let mut status = BTreeMap::new();
    let mut location = BTreeMap::new();
    let mut multiplicity = BTreeMap::new();
    let mut worst: Option<Worst> = None;
    let mut largest_gap: Option<f64> = None;
    for (index, foot) in feet.iter().enumerate() {
        *status.entry(foot.status.name()).or_default() += 1;
        if !foot.exists() {
            continue;
        }
        *location.entry(foot.location).or_default() += 1;
        *multiplicity.entry(multiplicity_name(foot.multiplicity).to_owned()).or_default() += 1;
        largest_gap = Some(largest_gap.map_or(foot.gap(), |gap| gap.max(foot.gap())));
        if worst.as_ref().is_none_or(|worst| foot.distance.abs() > worst.distance.abs()) {
            let point = points.positions[index].into();
            let name = points.name(index).map(str::to_owned);
            worst = Some(Worst { index, point, distance: foot.distance, name });
        }
    }
    let dropped = feet.iter().filter(|foot| foot.status == Status::InvalidPoint).count();
    let distance = Statistics::of(feet.iter().map(|foot| foot.distance));
    ProjectionResults {
        points: feet.len(),
        points_dropped: points.report.non_finite,
        points_used: feet.len() - dropped,
        rms: distance.as_ref().map(|distance| distance.rms),
        max: worst.as_ref().map(|worst| worst.distance.abs()),
        max_index: worst.as_ref().map(|worst| worst.index),
        columns: columns(projected),
        status,
        location,
        multiplicity,
        distance,
        worst,
        largest_gap: largest_gap.filter(|_| job.mode == SearchMode::Certified),
        wide_gaps: None,
        undecided_sides: None,
        shapes: shape_results(feet, shapes),
    }
}

fn multiplicity_name(multiplicity: Multiplicity) -> &'static str {
    match multiplicity {
        Multiplicity::Unknown => "unknown",
        Multiplicity::Unique => "unique",
        Multiplicity::Tied => "tied",
        Multiplicity::Continuum => "continuum",
    }
}

/// Distances per shape, for those that are nearest to a point.
fn shape_results(feet: &[Foot], shapes: &[(&'static str, Option<String>)]) -> Vec<ShapeResults> {
    let mut by_shape: BTreeMap<u32, (usize, Vec<f64>)> = BTreeMap::new();
    for foot in feet.iter().filter(|foot| foot.exists()) {
        let (on_boundary, distances) = by_shape.entry(foot.shape).or_default();
        *on_boundary += usize::from(foot.status == Status::OnBoundary);
        distances.push(foot.distance);
    }
    let results = by_shape.into_iter().filter_map(|(index, (on_boundary, distances))| {
        let (kind, name) = shapes.get(index as usize)?.clone();
        let distance = Statistics::of(distances)?;
        Some(ShapeResults { index, kind, name, on_boundary, distance })
    });
    results.collect()
}
