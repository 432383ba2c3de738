//! The search over all positions, and single registrations with all of the points or some.

use crate::commands::register::field::{Extent, RegistrationField};
use crate::commands::register::model::RegistrationModel;
use crate::commands::register::request::{Cloud, Job};
use crate::error::Error;
use crate::report::wording::counted;
use crate::runtime::progress::Progress;
use industrial_geometry::mesh::nalgebra::Vector3;
use industrial_geometry::register::start::{CoarseStart, OrientedPoints, StartCandidate, StartOptions};
use industrial_geometry::register::{
    Error as RegisterError, Pose, RegisterReport, RegisterStep, Rejection, Source,
};

/// Candidates of a search over all positions from which the registration is run.
const CANDIDATES: usize = 3;
/// Share of a cloud near the other one in the best position below which they have little in common; the tolerance, as a share of the
/// size of the model, by which is judged what fits exactly.
const LITTLE: f64 = 0.8;
const EXACT: f64 = 0.004;

/// The best of all positions in space.
pub(crate) fn search_space(
    job: &Job<'_>,
    model: &RegistrationModel,
    field: &RegistrationField,
    cloud: &Cloud<'_>,
    progress: &Progress,
) -> Result<Vec<Pose<3>>, Error> {
    // The search knows one scale: where it is unknown, that by the sizes.
    let growth = if job.options.scale { field.relative_size(&cloud.positions) } else { 1.0 };
    let grown: Vec<Vector3<f64>> = cloud.positions.iter().map(|x| x * growth).collect();
    let failed =
        |error: RegisterError| Error::content(job.points, error.to_string(), "check it with `indgeo info`");
    let oriented = match cloud.normals {
        Some(normals) => OrientedPoints::new(&grown, normals),
        None => OrientedPoints::without_normals(&grown),
    };
    let oriented = oriented.map_err(failed)?;
    let tell = |done: usize, total: usize| progress.part("searching all positions", done, total);
    let samples = model.samples(job.model)?;
    let options = StartOptions::default();
    let start = CoarseStart::new(&samples, &options).map_err(failed)?;
    let search = start.look(&oriented, &tell).map_err(failed)?;
    let found = search.report(options.tolerance).map_err(failed)?;
    let mut poses: Vec<Pose<3>> =
        found.candidates.iter().take(CANDIDATES).map(|candidate| candidate.pose).collect();
    // Clouds with little in common fit roughly in many ways: what fits exactly comes first.
    let is_little = found.best().is_none_or(|best| best.share < LITTLE);
    if matches!(model, RegistrationModel::Cloud(_)) && is_little {
        let mut found = search.report(EXACT).map_err(failed)?;
        let excess = |candidate: &StartCandidate| candidate.excess(found.tolerance);
        found.candidates.sort_by(|a, b| excess(b).total_cmp(&excess(a)));
        poses.splice(0..0, found.candidates.iter().take(CANDIDATES).map(|candidate| candidate.pose));
    }
    let back = |pose: Pose<3>| Pose {
        scale: pose.scale * growth,
        source_origin: pose.source_origin / growth,
        ..pose
    };
    Ok(poses.into_iter().map(back).collect())
}

pub(crate) fn register_all(
    job: &Job<'_>,
    field: &RegistrationField,
    cloud: &Cloud<'_>,
    start: &Pose<3>,
    progress: &Progress,
) -> Result<RegisterReport<3>, Error> {
    register_whole(job, field, cloud, start, Extent::All, progress)
}

pub(crate) fn register_whole(
    job: &Job<'_>,
    field: &RegistrationField,
    cloud: &Cloud<'_>,
    start: &Pose<3>,
    extent: Extent<'_>,
    progress: &Progress,
) -> Result<RegisterReport<3>, Error> {
    let found = register(job, field, cloud, start, extent, progress)?;
    found.ok_or_else(|| Error::content(job.points, "there are no points", "check it with `indgeo info`"))
}

/// The registration of as many points as tell whether a position is worth while.
pub(crate) fn register_few(
    job: &Job<'_>,
    field: &RegistrationField,
    cloud: &Cloud<'_>,
    start: &Pose<3>,
    progress: &Progress,
) -> Result<RegisterReport<3>, Error> {
    match register(job, field, cloud, start, Extent::Few, progress)? {
        Some(report) => Ok(report),
        None => register_all(job, field, cloud, start, progress),
    }
}

pub(crate) fn register(
    job: &Job<'_>,
    field: &RegistrationField,
    cloud: &Cloud<'_>,
    start: &Pose<3>,
    extent: Extent<'_>,
    progress: &Progress,
) -> Result<Option<RegisterReport<3>>, Error> {
    progress.begin();
    let most = job.options.max_iterations;
    let tell = |step: &RegisterStep| {
        progress.next_iteration(most, &format!("{}, rms {:.3e}", counted(step.points, "point"), step.rms))
    };
    let mut options = job.options;
    if let Some(angle) = job.max_angle {
        options.rejection =
            Rejection { oriented_normals: true, ..options.rejection.with_normal_angle(angle) };
    }
    let source =
        Source { points: &cloud.positions, normals: cloud.normals, weights: cloud.weights.as_deref() };
    field.register(&source, start, &options, extent, &tell).map_err(|error| match error {
        RegisterError::Option { name, value, allowed } => {
            Error::option(name, value, allowed, "see `indgeo register --help`")
        }
        other => Error::content(job.points, other.to_string(), "check it with `indgeo info`"),
    })
}
