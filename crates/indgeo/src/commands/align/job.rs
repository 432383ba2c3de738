//! The alignment by datum targets: read, solve, judge, write.

use crate::commands::align::datum_file::{self, Datum, called};
use crate::commands::register::results::Rotation;
use crate::error::Error;
use crate::files;
use crate::fits::numbers::FitVerdict;
use crate::input::moving::moved;
use crate::report::wording::{counted, not_finite};
use crate::report::{Input, Output, ReadSummary, Report, Timings};
use industrial_geometry::io::{Content, Format, ReadOptions, WriteOptions};
use industrial_geometry::nurbs::Aabb;
use industrial_geometry::register::{
    DatumReport, DatumTarget, Error as RegisterError, Status, align_datum_from_anywhere,
};
use serde::Serialize;
use std::path::Path;

/// Root mean square residual, as a share of the size of the nominal places, above which the targets do not belong together.
const MISMATCH: f64 = 0.05;

/// What is to be done.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// File of the targets.
    pub(crate) targets: &'a Path,
    /// File of points to be moved, and where they go.
    pub(crate) points: Option<(&'a Path, &'a Path)>,
    /// Format of the moved points, if not that of the extension.
    pub(crate) format: Option<Format>,
    /// File of the motion.
    pub(crate) transform: Option<&'a Path>,
    /// Largest residual that is allowed.
    pub(crate) tolerance: Option<f64>,
}

/// What an alignment found.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct AlignmentResults {
    /// `x ↦ R x + t` in homogeneous coordinates, by rows.
    pub(crate) matrix: [[f64; 4]; 4],
    /// The rotation in two more forms.
    pub(crate) rotation: Rotation,
    /// `t`.
    pub(crate) translation: [f64; 3],
    /// Always 1.
    pub(crate) scale: f64,
    /// How the iteration ended.
    pub(crate) status: &'static str,
    /// Number of steps.
    pub(crate) iterations: usize,
    /// Root mean square residual, with the weights.
    pub(crate) rms: f64,
    /// Largest residual, without sign.
    pub(crate) max: f64,
    /// The target that has it, from 0.
    pub(crate) max_index: usize,
    /// Number of directions along which targets are held.
    pub(crate) conditions: usize,
    /// Degrees of freedom of the motion.
    pub(crate) unknowns: usize,
    /// Largest residual that is allowed.
    pub(crate) tolerance: Option<f64>,
    /// Whether all residuals are within it.
    pub(crate) within_tolerance: Option<bool>,
    /// Every target.
    pub(crate) targets: Vec<TargetResult>,
}

/// One target after the alignment.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct TargetResult {
    /// Its name, if it has one.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub(crate) name: String,
    /// Where the measured point is after the motion.
    pub(crate) moved: [f64; 3],
    /// Where it belongs.
    pub(crate) nominal: [f64; 3],
    /// Unit vectors along which it is held.
    pub(crate) directions: Vec<[f64; 3]>,
    /// Distance of the moved point from its nominal place along each of them, with sign.
    pub(crate) residuals: Vec<f64>,
    /// Weight.
    pub(crate) weight: f64,
}

/// Does the job and fills in the report.
pub(crate) fn run(job: &Job<'_>, report: &mut Report) -> Result<FitVerdict, Error> {
    let inputs: Vec<&Path> = [job.targets].into_iter().chain(job.points.map(|(read, _)| read)).collect();
    files::check_inputs(&inputs)?;
    for path in [job.points.map(|(_, written)| written), job.transform].into_iter().flatten() {
        files::check_writable(path, &inputs)?;
    }
    let mut timings = Timings::default();
    let file = Timings::measure(&mut timings.read, || datum_file::read(job.targets))?;
    report.add_input(Input {
        role: "targets",
        path: job.targets.to_path_buf(),
        read: ReadSummary {
            format: file.format,
            points_read: file.targets.len(),
            points_dropped: 0,
            points_used: file.targets.iter().filter(|target| target.weight > 0.0).count(),
            non_finite: 0,
            triangles: 0,
            shapes: 0,
        },
    });
    report
        .warnings
        .extend(file.warnings.iter().map(|warning| format!("{}: {warning}", job.targets.display())));
    let points = match job.points {
        Some((path, _)) => Some(read_points(path, &mut timings, report)?),
        None => None,
    };
    let targets = file.targets;
    let conditions: Vec<DatumTarget<3>> = (targets.iter())
        .flat_map(|t| t.directions.iter().map(move |e| (t, e)))
        .map(|(t, e)| DatumTarget { weight: t.weight, ..DatumTarget::new(t.measured, t.nominal, *e) })
        .collect();
    let found = Timings::measure(&mut timings.compute, || align_datum_from_anywhere(&conditions))
        .map_err(|error| failed(job.targets, &targets, &conditions, &error))?;
    report.timings = timings;
    if let (Some((path, out)), Some(content)) = (job.points, points) {
        let options = WriteOptions { format: job.format, ..WriteOptions::default() };
        let content = moved(content, &found.pose, path)?;
        let written =
            Timings::measure(&mut report.timings.write, || files::write_content(out, &content, &options))?;
        report
            .warnings
            .extend(written.warnings.iter().map(|warning| format!("{}: {warning}", out.display())));
        let content = counted(written.points, "moved point");
        report.add_output(Output { path: out.to_path_buf(), bytes: written.bytes, content });
    }
    let mut results = results(&targets, &found, job.tolerance);
    let mismatch = mismatch(&targets, &found).filter(|_| job.tolerance.is_none());
    if let Some(share) = mismatch {
        results.status = Status::Doubtful.name();
        report.warnings.push(format!(
            "{}: the residuals are {:.1} % of the size of the nominal places: the measured points have another shape; check the order of the \
             targets, the unit, and that both sides are right-handed, or allow the residuals by --tolerance",
            job.targets.display(),
            100.0 * share
        ));
    }
    if let Some(path) = job.transform {
        let bytes = Timings::measure(&mut report.timings.write, || {
            files::write(path, |out| {
                serde_json::to_writer_pretty(&mut *out, &results)?;
                out.write_all(b"\n")
            })
        })?;
        report.add_output(Output { path: path.to_path_buf(), bytes, content: "motion".to_owned() });
    }
    let verdict = match results.within_tolerance {
        _ if !found.status.is_converged() || mismatch.is_some() => FitVerdict::NotConverged,
        Some(false) => FitVerdict::OutOfTolerance,
        _ => FitVerdict::Good,
    };
    report.results = Some(Box::new(results));
    Ok(verdict)
}

fn read_points(path: &Path, timings: &mut Timings, report: &mut Report) -> Result<Content, Error> {
    let loaded = Timings::measure(&mut timings.read, || files::read(path, &ReadOptions::default()))?;
    report.add_input(Input::new("points", path, &loaded.report));
    let read = loaded.report;
    report.warnings.extend(read.warnings.iter().map(|warning| format!("{}: {warning}", path.display())));
    if read.non_finite > 0 {
        report.warnings.push(not_finite(path, read.non_finite, read.points, "kept as they are"));
    }
    let what = match &loaded.content {
        Content::Nurbs(_) => "points are needed, but this file holds NURBS shapes",
        Content::Cloud(cloud) if cloud.dimension() == 2 => "the points have two columns only",
        _ => return Ok(loaded.content),
    };
    Err(Error::content(path, what, "give points of three columns, x, y and z, or a mesh"))
}

/// The error of the library, in the words of the file.
fn failed(path: &Path, targets: &[Datum], conditions: &[DatumTarget<3>], error: &RegisterError) -> Error {
    match error {
        RegisterError::OpenDatum { free, unknowns } => {
            let what = format!(
                "the targets leave {free} of {unknowns} degrees of freedom open ({} at {})",
                counted(conditions.len(), "direction"),
                counted(targets.len(), "point")
            );
            Error::content(path, what, "add targets, or directions that are not held yet")
        }
        other => {
            Error::content(path, other.to_string(), "see `indgeo align --help` for the form of the file")
        }
    }
}

/// The root mean square residual as a share of the size of the nominal places, where it is so large that the targets do not belong together.
fn mismatch(targets: &[Datum], found: &DatumReport<3>) -> Option<f64> {
    let places = || targets.iter().filter(|target| target.weight > 0.0).map(|target| &target.nominal);
    let size = Aabb::of_points(places()).map_or(0.0, |bounds| bounds.diagonal());
    (found.rms > MISMATCH * size).then(|| found.rms / size)
}

fn results(targets: &[Datum], found: &DatumReport<3>, tolerance: Option<f64>) -> AlignmentResults {
    let mut residuals = found.residuals.iter().copied();
    let mut of_targets = Vec::with_capacity(targets.len());
    let (mut max, mut max_index) = (0.0f64, 0);
    for (index, target) in targets.iter().enumerate() {
        let residuals: Vec<f64> = residuals.by_ref().take(target.directions.len()).collect();
        let largest = residuals.iter().fold(0.0f64, |most, r| most.max(r.abs()));
        if target.weight > 0.0 && largest > max {
            (max, max_index) = (largest, index);
        }
        of_targets.push(TargetResult {
            name: target.name.clone(),
            moved: found.pose.apply(&target.measured).into(),
            nominal: target.nominal.into(),
            directions: target.directions.iter().map(|e| (*e).into()).collect(),
            residuals,
            weight: target.weight,
        });
    }
    AlignmentResults {
        matrix: found.pose.to_row_major(),
        rotation: Rotation::of(&found.pose),
        translation: found.pose.translation().into(),
        scale: 1.0,
        status: found.status.name(),
        iterations: found.iterations,
        rms: found.rms,
        max,
        max_index,
        conditions: found.residuals.len(),
        unknowns: 6,
        tolerance,
        within_tolerance: tolerance.map(|tolerance| max <= tolerance),
        targets: of_targets,
    }
}

impl AlignmentResults {
    /// The targets by name, with the largest residuals first.
    pub(crate) fn worst_first(&self) -> Vec<(String, &TargetResult)> {
        let largest =
            |target: &TargetResult| target.residuals.iter().fold(0.0f64, |most, r| most.max(r.abs()));
        let name = |(index, target): (usize, &TargetResult)| called(index, &target.name);
        let mut order: Vec<(usize, &TargetResult)> = self.targets.iter().enumerate().collect();
        order.sort_by(|a, b| largest(b.1).total_cmp(&largest(a.1)).then(a.0.cmp(&b.0)));
        order.into_iter().map(|entry| (name(entry), entry.1)).collect()
    }
}
