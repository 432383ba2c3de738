//! The second half of the demonstration: the scan is put out of place, registered, and inspected.

use super::{Bolt, Data, placement};
use crate::commands::inspect::job;
use crate::commands::register::job as registering;
use crate::commands::register::request::{Job as RegisterJob, Start};
use crate::commands::register::results::RegistrationResults;
use crate::common::Common;
use crate::error::Error;
use crate::files;
use crate::input::cad::Choice;
use crate::input::moving::moved;
use crate::report::{Output, Report, Timings};
use industrial_geometry::footpoint::ProjectionOptions;
use industrial_geometry::inspection::{Inspection, InspectionOptions, Rounding, Tolerance, percent};
use industrial_geometry::io::{self, AtomicFile, Content, ReadOptions, WriteOptions};
use industrial_geometry::mesh::nalgebra::{Rotation3, Vector3};
use industrial_geometry::register::{Pose, RegisterOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// How far the scan is turned, in degrees, and shifted, in mm.
const TURN: f64 = 6.0;
const SHIFT: f64 = 1.0;
/// Allowed deviation in mm.
const TOLERANCE: f64 = 0.1;
/// Names of the files, in the order of [`Files`].
const NAMES: [&str; 7] = [
    "displaced.ply",
    "registered.ply",
    "pose.json",
    "registration.json",
    "registration.svg",
    "report.html",
    "inspection.json",
];

/// The files that are written.
#[derive(Debug)]
pub(crate) struct Files {
    displaced: PathBuf,
    registered: PathBuf,
    pose: PathBuf,
    registration: PathBuf,
    picture: PathBuf,
    page: PathBuf,
    inspection: PathBuf,
}

impl Files {
    /// In a folder.
    pub(crate) fn in_folder(folder: &Path) -> Self {
        let [displaced, registered, pose, registration, picture, page, inspection] =
            NAMES.map(|name| folder.join(name));
        Self { displaced, registered, pose, registration, picture, page, inspection }
    }

    /// All of them.
    pub(crate) fn all(folder: &Path) -> Vec<PathBuf> {
        let all = NAMES.iter();
        #[cfg(feature = "step")]
        let all = all.chain(&super::cad_part::NAMES);
        all.map(|name| folder.join(name)).collect()
    }
}

/// Puts the scan out of place, registers and inspects it, and adds the files to the report. Returns a text for a person, and
/// whether the registration converged.
pub(crate) fn run(
    data: &Data,
    bolt: &Bolt,
    folder: &Path,
    options: &ProjectionOptions,
    common: &Common,
    report: &mut Report,
) -> Result<(String, bool), Error> {
    let files = Files::in_folder(folder);
    let scan = files::read(&data.scan, &ReadOptions::default())?.content;
    let away = displacement(&scan);
    let content = moved(scan, &away, &data.scan)?;
    let written = io::write(&files.displaced, &content, &WriteOptions::default())?;
    let text = format!("the scan, turned by {TURN}° and shifted by {SHIFT} mm");
    report.add_output(Output { path: files.displaced.clone(), bytes: written.bytes, content: text });

    let mut found = Report { command: "register", version: report.version, ..Report::default() };
    let job = RegisterJob {
        model: &data.model,
        cad: &Choice::default(),
        points: &files.displaced,
        sample: crate::input::sampling::MOST,
        out: Some(&files.registered),
        format: None,
        transform: Some(&files.pose),
        page: None,
        start: Start::Given,
        options: RegisterOptions::default(),
        feature_weight: None,
        max_angle: None,
        needs_normals: false,
        quiet: common.quiet,
    };
    let converged = registering::run(&job, &mut found)?.converged;
    finish(&mut found, if converged { ("done", 0) } else { ("not_converged", 1) });
    let Some(results) = found.found::<RegistrationResults>() else {
        return Err(Error::content(
            &files.displaced,
            "there is no result",
            "take the file from the repository",
        ));
    };
    let pose = Pose::<3>::from_row_major(&results.transform.matrix).map_err(|error| {
        Error::content(&files.pose, error.to_string(), "take the data from the repository")
    })?;

    let mut judged = Report { command: "inspect", version: report.version, ..Report::default() };
    let inspection = inspect(data, &files, options, common, &mut judged)?;
    let verdict = if inspection.verdict.pass { ("done", 0) } else { ("out_of_tolerance", 1) };
    finish(&mut judged, verdict);

    let points = positions(&content);
    let picture = placement::draw(bolt, &data.model, &points, &pose, &results.transform.history)?;
    let mut timings = report.timings;
    Timings::measure(&mut timings.write, || -> Result<(), Error> {
        for (path, text, content) in [
            (&files.registration, json(&found, &files.registration)?, "report of the registration"),
            (&files.inspection, json(&judged, &files.inspection)?, "report of the inspection"),
            (&files.picture, picture, "picture: before and after the registration, and its steps"),
        ] {
            let bytes = write_text(path, &text)?;
            report.add_output(Output { path: path.clone(), bytes, content: content.to_owned() });
        }
        Ok(())
    })?;
    let rms = rms_apart(&points, |x| pose.apply(&away.apply(x)), &away.inverse());
    let text = explain(&files, &found, &inspection, rms, data);
    for part in [found, judged] {
        report.outputs.extend(part.outputs);
        timings.read += part.timings.read;
        timings.build += part.timings.build;
        timings.compute += part.timings.compute;
        timings.write += part.timings.write;
    }
    report.timings = timings;
    Ok((text, converged))
}

/// A turn about the centre of the scan, and a shift.
fn displacement(scan: &Content) -> Pose<3> {
    let points = positions(scan);
    let centre = points.iter().sum::<Vector3<f64>>() / points.len().max(1) as f64;
    let turn = Rotation3::from_scaled_axis(Vector3::new(0.6, -0.64, 0.48) * TURN.to_radians());
    let target_origin = centre + Vector3::new(0.36, 0.48, -0.8) * SHIFT;
    Pose { scale: 1.0, rotation: turn.into_inner(), source_origin: centre, target_origin }
}

fn positions(content: &Content) -> Vec<Vector3<f64>> {
    let cloud = match content {
        Content::Cloud(cloud) => cloud,
        Content::Mesh(mesh) => mesh.cloud(),
        Content::Nurbs(_) => return Vec::new(),
    };
    let finite = cloud.positions().iter().filter(|x| x.iter().all(|c| c.is_finite()));
    finite.map(|x| x.coords).collect()
}

/// Root mean square of the distance between where `whole` takes the original of a displaced point, and that original.
fn rms_apart(
    displaced: &[Vector3<f64>],
    whole: impl Fn(&Vector3<f64>) -> Vector3<f64>,
    back: &Pose<3>,
) -> f64 {
    let one = |x: &Vector3<f64>| {
        let original = back.apply(x);
        (whole(&original) - original).norm_squared()
    };
    (displaced.iter().map(one).sum::<f64>() / displaced.len().max(1) as f64).sqrt()
}

fn inspect(
    data: &Data,
    files: &Files,
    options: &ProjectionOptions,
    common: &Common,
    report: &mut Report,
) -> Result<Inspection, Error> {
    let tolerance = Tolerance::symmetric(TOLERANCE)
        .map_err(|error| Error::usage(error.to_string(), "see `indgeo inspect --help`"))?;
    let job = job::Job {
        model: &data.model,
        cad: &Choice::default(),
        points: std::slice::from_ref(&files.displaced),
        range: None,
        picture: job::MOST_POINTS,
        motion: job::Motion::File(&files.pose),
        page: Some(&files.page),
        out: None,
        format: None,
        options: InspectionOptions::new(tolerance).with_drop_beyond_boundary(true).with_projection(*options),
        mode: "certified",
        drop_non_finite: false,
        scan: None,
        threads: common.threads,
        quiet: common.quiet,
    };
    job::run(&job, report)
}

pub(super) fn finish(report: &mut Report, (status, exit_code): (&'static str, u8)) {
    (report.status, report.exit_code) = (status, exit_code);
}

pub(super) fn json(report: &Report, path: &Path) -> Result<String, Error> {
    let text = serde_json::to_string_pretty(report).map_err(|error| Error::write(path, error.into()))?;
    Ok(text + "\n")
}

/// Writes a file that appears whole or not at all.
pub(crate) fn write_text(path: &Path, text: &str) -> Result<u64, Error> {
    let mut file = AtomicFile::create(path)?;
    file.write_all(text.as_bytes()).map_err(|source| Error::write(path, source))?;
    Ok(file.commit()?)
}

fn explain(files: &Files, found: &Report, inspection: &Inspection, apart: f64, data: &Data) -> String {
    let Some(results) = found.found::<RegistrationResults>() else { return String::new() };
    let motion = &results.transform;
    let free: String =
        motion.free_motions.iter().map(|free| format!("  The thread does not fix: {free}.\n")).collect();
    let verdict = &inspection.verdict;
    format!(
        "Then the scan was turned by {TURN}° and shifted by {SHIFT} mm, and registered to the model again:\n  \
         {} after {} steps; {} of {} points count (the others lie beyond the model), rms {:.4} mm.\n{free}  \
         It lies {apart:.3} mm (rms) from where it was: the position along that motion is that of the start.\n\
         Inspected there: {} of {} points within ±{TOLERANCE} mm. Open {} in a browser; it works offline.\n\n\
         The same by hand:\n  \
         indgeo register {} {} -o registered.ply --transform pose.json\n  \
         indgeo inspect {} {} --transform pose.json --tolerance {TOLERANCE} --drop-beyond-boundary --report report.html\n",
        motion.status,
        motion.iterations,
        motion.points_used,
        motion.points,
        motion.rms,
        percent(verdict.within, verdict.judged, Rounding::Down),
        verdict.judged,
        files.page.display(),
        data.model.display(),
        files.displaced.display(),
        data.model.display(),
        files.displaced.display(),
    )
}
