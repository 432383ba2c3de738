//! The registration of a cloud: read, start, register, choose, write.

use crate::cad::Choice;
use crate::error::Error;
use crate::files;
use crate::moving::moved;
use crate::planar_start;
use crate::poses;
use crate::progress::Progress;
use crate::registration_field::{RegistrationField, locks_fit_the_plane};
use crate::registration_model::RegistrationModel;
use crate::registration_report::{self as found, RegistrationResults, StartResult};
use crate::registration_verdict as verdict;
use crate::report::{Input, ModelSummary, Output, Report, Results, Timings};
use crate::wording::{counted, not_finite};
use industrial_geometry::io::{self, Content, Format, ReadOptions, WriteOptions};
use industrial_geometry::mesh::nalgebra::Vector3;
use industrial_geometry::register::start::{OrientedPoints, StartOptions, coarse_start};
use industrial_geometry::register::{
    Error as RegisterError, Pose, RegisterOptions, RegisterReport, Rejection, Source, StepRecord,
};
use std::path::Path;
use std::time::Instant;

/// Share of the points near the model above which the given start is good enough.
const GOOD_SHARE: f64 = 0.9;
/// Candidates of a search over all positions from which the registration is run.
const CANDIDATES: usize = 3;

/// Where the registration of a scan, or of many views, starts.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Start<'a> {
    /// Where the points are.
    Given,
    /// Where the points are, and a search over all positions if that is not good.
    Auto,
    /// The best of a search over all positions.
    Global,
    /// The poses of a file: starts to be tried, or one per view.
    Poses(&'a Path),
}

/// What is to be done.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// File of the model.
    pub(crate) model: &'a Path,
    /// What is chosen of a CAD model.
    pub(crate) cad: &'a Choice,
    /// File of the points.
    pub(crate) points: &'a Path,
    /// File of the moved points.
    pub(crate) out: Option<&'a Path>,
    /// Their format, if not that of the extension.
    pub(crate) format: Option<Format>,
    /// File of the motion.
    pub(crate) transform: Option<&'a Path>,
    /// Where to start.
    pub(crate) start: Start<'a>,
    /// Options of the library.
    pub(crate) options: RegisterOptions<3>,
    /// Largest angle, in radians, between the normals of points and feet that count.
    pub(crate) max_angle: Option<f64>,
    /// Whether the method makes no sense without normals of the points.
    pub(crate) needs_normals: bool,
    /// Whether nobody wants to watch.
    pub(crate) quiet: bool,
}

/// Where the points came to lie.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Registered {
    pub(crate) pose: Pose<3>,
    pub(crate) converged: bool,
}

/// The points as they are registered.
struct Cloud<'a> {
    positions: Vec<Vector3<f64>>,
    normals: Option<&'a [Vector3<f64>]>,
    /// 0 for points that do not count because they have no normal; `None` where all count.
    weights: Option<Vec<f64>>,
}

/// Does the job and fills in the report.
pub(crate) fn run(job: &Job<'_>, report: &mut Report) -> Result<Registered, Error> {
    let init = if let Start::Poses(file) = job.start { Some(file) } else { None };
    let inputs: Vec<&Path> = [job.model, job.points].into_iter().chain(init).collect();
    files::check_inputs(&inputs)?;
    for path in [job.out, job.transform].into_iter().flatten() {
        files::check_writable(path, &inputs)?;
    }
    let mut timings = Timings::default();
    let (model, read) = Timings::measure(&mut timings.read, || {
        RegistrationModel::read(job.model, job.cad, &mut report.warnings)
    })?;
    let mut input = Input::new("model", job.model, &read);
    if let RegistrationModel::Cad(cad) = &model {
        input.read.format = cad.format.to_owned();
    }
    if model.kind() == "level_set" {
        "grid".clone_into(&mut input.read.format);
    }
    report.add_input(input);
    let given = init.map(poses::read).transpose()?;
    let loaded = Timings::measure(&mut timings.read, || files::read(job.points, &ReadOptions::default()))?;
    report.add_input(Input::new("points", job.points, &loaded.report));
    let content = loaded.content;
    warn(job, &loaded.report, report);
    let is_planar = model.is_planar();
    if is_planar && !locks_fit_the_plane(&job.options) {
        return Err(Error::usage("a lock of tz, rx or ry has no effect in the plane", "lock tx, ty or rz"));
    }
    let cloud = cloud(&content, job, is_planar)?;
    if job.max_angle.is_some() {
        model.check_normals(job.model)?;
        let ignored = cloud.weights.iter().flatten().filter(|weight| **weight == 0.0).count();
        if ignored > 0 {
            report.warnings.push(format!(
                "{}: {ignored} points have a normal that is zero or not finite; they are moved, but do not count",
                job.points.display()
            ));
        }
    }
    if let RegistrationModel::Cad(cad) = &model {
        let scan = industrial_geometry::mesh::BoundingBox::of(
            &cloud
                .positions
                .iter()
                .map(|p| industrial_geometry::mesh::nalgebra::Point3::from(*p))
                .collect::<Vec<_>>(),
        );
        report.warnings.extend(scan.and_then(|scan| cad.unit_warning(scan.diagonal())));
    }
    let field = Timings::measure(&mut timings.build, || model.field(job.model))?;
    report.model = Some(ModelSummary {
        kind: model.kind(),
        unit: model.unit(),
        dimension: if is_planar { 2 } else { 3 },
        shapes: 1.max(if matches!(model.kind(), "nurbs" | "cad") { model.count() } else { 1 }),
        patches: model.count(),
        signed: matches!(
            model,
            RegistrationModel::Surfaces(_) | RegistrationModel::Plane(_) | RegistrationModel::Cad(_)
        ),
    });

    let progress = Progress::iterations("registering", job.quiet);
    let began = Instant::now();
    let solution = solve(job, &model, &field, &cloud, given, &progress)?;
    timings.compute = began.elapsed().as_secs_f64();
    drop(progress);
    report.timings = timings;
    let Solution { starts, best, result, equivalent } = solution;
    report.warnings.extend(verdict::warning(&result, job));
    if equivalent.len() > 1 {
        report.warnings.push(format!(
            "the model has {} positions that its shape does not tell apart; this is the one nearest to the start, all are in \
             `equivalent_poses`",
            equivalent.len()
        ));
    }
    let motion = found::transform(&result, &equivalent);
    write(job, content, &result.pose, &motion, report)?;
    report.count_points("points", result.dropped, result.used);
    report.results = Some(Results::Registration(Box::new(RegistrationResults::new(motion, starts, best))));
    Ok(Registered { pose: result.pose, converged: result.is_converged() })
}

fn warn(job: &Job<'_>, read: &io::ReadReport, report: &mut Report) {
    report
        .warnings
        .extend(read.warnings.iter().map(|warning| format!("{}: {warning}", job.points.display())));
    if read.non_finite > 0 {
        report.warnings.push(not_finite(job.points, read.non_finite, read.points, "moved, not used"));
    }
}

fn cloud<'a>(content: &'a Content, job: &Job<'_>, is_planar: bool) -> Result<Cloud<'a>, Error> {
    let cloud = match content {
        Content::Cloud(cloud) => cloud,
        Content::Mesh(mesh) => mesh.cloud(),
        Content::Nurbs(_) => {
            let what = "points are needed, but this file holds NURBS shapes";
            return Err(Error::content(job.points, what, "the order is MODEL POINTS"));
        }
    };
    if cloud.dimension() == 2 && !is_planar {
        let what = "the points have two columns only";
        return Err(Error::content(job.points, what, "give points of three columns, x, y and z"));
    }
    if let Some(index) = cloud.positions().iter().position(|point| point.z != 0.0).filter(|_| is_planar) {
        let what = format!(
            "the model lies in the plane, but point {index} (from 0) has z = {}",
            cloud.positions()[index].z
        );
        return Err(Error::content(job.points, what, "give points of two columns, x and y, or with z = 0"));
    }
    let normals = cloud.attributes().normals();
    if job.needs_normals && normals.is_none() {
        let what = "the points have no normals, which --method symmetric needs";
        return Err(Error::content(job.points, what, "choose another method, or a file with normals"));
    }
    if job.max_angle.is_some() && normals.is_none() {
        let what = "the points have no normals, which --max-angle needs";
        return Err(Error::content(
            job.points,
            what,
            "leave it out, or give a file with normals (nx, ny, nz)",
        ));
    }
    let is_usable = |normal: &Vector3<f64>| normal.iter().all(|c| c.is_finite()) && normal.amax() > 0.0;
    let weights = normals.filter(|normals| job.max_angle.is_some() && !normals.iter().all(is_usable));
    let weights = weights.map(|normals| normals.iter().map(|n| f64::from(u8::from(is_usable(n)))).collect());
    let positions = cloud.positions().iter().map(|point| point.coords).collect();
    Ok(Cloud { positions, normals, weights })
}

/// Registers from every start.
fn solve(
    job: &Job<'_>,
    model: &RegistrationModel,
    field: &RegistrationField,
    cloud: &Cloud<'_>,
    given: Option<Vec<Pose<3>>>,
    progress: &Progress,
) -> Result<Solution, Error> {
    let (mut starts, mut results) = (Vec::new(), Vec::new());
    let mut begun = Vec::new();
    let is_good = |(share, ended_well): (f64, bool)| ended_well && share >= GOOD_SHARE;
    let mut from = |origin: &'static str, pose: &Pose<3>| -> Result<(f64, bool), Error> {
        let began = Instant::now();
        let result = verdict::flat(model, &cloud.positions, register(job, field, cloud, pose, progress)?);
        let (score, share) = field.compare(&cloud.positions, &result.pose, job.options.scale);
        starts.push(StartResult::new(origin, pose, &result, score, share, began.elapsed().as_secs_f64()));
        let ended_well = result.is_converged();
        results.push(result);
        begun.push(*pose);
        Ok((share, ended_well))
    };
    let mut search = matches!(job.start, Start::Global);
    match &given {
        Some(poses) => {
            for pose in poses {
                from("init", pose)?;
            }
        }
        None if !search => {
            let share = from("given", &Pose::identity())?;
            search = matches!(job.start, Start::Auto)
                && !is_good(share)
                && !matches!(model, RegistrationModel::Curves(_));
        }
        None => {}
    }
    if search {
        let found = if model.is_planar() {
            planar_start::poses(field, &cloud.positions, job.options.scale)
        } else {
            search_space(job, model, field, cloud, progress)?
        };
        for pose in &found {
            if is_good(from("search", pose)?) {
                break;
            }
        }
    }
    if starts.is_empty() {
        let what = "no position was found in which the points lie on the model";
        return Err(Error::content(job.points, what, "give a starting pose (--init)"));
    }
    let best = best(&starts);
    let (mut result, mut equivalent) = (results.swap_remove(best), Vec::new());
    if verdict::may_be_symmetric(model, &result, &job.options) {
        let tolerance = result.covariance.as_ref().map_or(0.0, |covariance| covariance.sigma);
        let from = if starts[best].origin == "search" { Pose::identity() } else { begun[best] };
        let again = |pose: &Pose<3>| register(job, field, cloud, pose, progress);
        let group = field.symmetries(&model.samples(job.model)?, tolerance);
        (result, equivalent) = verdict::nearest(&group, result, &from, &cloud.positions, again)?;
    }
    Ok(Solution { starts, best, result, equivalent })
}

/// The best of all positions in space.
fn search_space(
    job: &Job<'_>,
    model: &RegistrationModel,
    field: &RegistrationField,
    cloud: &Cloud<'_>,
    progress: &Progress,
) -> Result<Vec<Pose<3>>, Error> {
    // The search knows one scale: where it is unknown, that by the sizes.
    let growth = if job.options.scale { field.relative_size(&cloud.positions) } else { 1.0 };
    let grown: Vec<Vector3<f64>> = cloud.positions.iter().map(|x| x * growth).collect();
    let oriented = match cloud.normals {
        Some(normals) => OrientedPoints::new(&grown, normals),
        None => OrientedPoints::without_normals(&grown),
    };
    let tell = |done: usize, total: usize| progress.part("searching all positions", done, total);
    let samples = model.samples(job.model)?;
    let found = oriented.and_then(|points| coarse_start(&samples, &points, &StartOptions::default(), &tell));
    let found = found
        .map_err(|error| Error::content(job.points, error.to_string(), "check it with `indgeo info`"))?;
    let pose = |pose: &Pose<3>| Pose {
        scale: pose.scale * growth,
        source_origin: pose.source_origin / growth,
        ..*pose
    };
    Ok(found.candidates.iter().take(CANDIDATES).map(|candidate| pose(&candidate.pose)).collect())
}

fn register(
    job: &Job<'_>,
    field: &RegistrationField,
    cloud: &Cloud<'_>,
    start: &Pose<3>,
    progress: &Progress,
) -> Result<RegisterReport<3>, Error> {
    progress.begin();
    let most = job.options.max_iterations;
    let tell = |step: &StepRecord| {
        progress.next_iteration(most, &format!("{}, rms {:.3e}", counted(step.points, "point"), step.rms))
    };
    let mut options = job.options;
    if let Some(angle) = job.max_angle {
        options.rejection =
            Rejection { oriented_normals: true, ..options.rejection.with_normal_angle(angle) };
    }
    let source =
        Source { points: &cloud.positions, normals: cloud.normals, weights: cloud.weights.as_deref() };
    field.register(&source, start, &options, &tell).map_err(|error| match error {
        RegisterError::Option { name, value, allowed } => {
            Error::option(name, value, allowed, "see `indgeo register --help`")
        }
        other => Error::content(job.points, other.to_string(), "check it with `indgeo info`"),
    })
}

/// The start whose result fits best, of those that converged if any did; the first of equals.
fn best(starts: &[StartResult]) -> usize {
    let rank = |i: usize| (starts[i].status != "converged", starts[i].score);
    (1..starts.len()).fold(0, |best, i| if rank(i) < rank(best) { i } else { best })
}

/// What came of all starts.
struct Solution {
    starts: Vec<StartResult>,
    /// The start that counts.
    best: usize,
    result: RegisterReport<3>,
    /// Poses that the model does not tell apart from the result, which is the first of them; none where they were not looked for.
    equivalent: Vec<Pose<3>>,
}

fn write(
    job: &Job<'_>,
    content: Content,
    pose: &Pose<3>,
    motion: &found::TransformFile,
    report: &mut Report,
) -> Result<(), Error> {
    let mut seconds = report.timings.write;
    Timings::measure(&mut seconds, || -> Result<(), Error> {
        if let Some(path) = job.out {
            let options = WriteOptions { format: job.format, ..WriteOptions::default() };
            let written = files::write_content(path, &moved(content, pose, job.points)?, &options)?;
            report
                .warnings
                .extend(written.warnings.iter().map(|warning| format!("{}: {warning}", path.display())));
            let content = counted(written.points, "moved point");
            report.add_output(Output { path: path.to_path_buf(), bytes: written.bytes, content });
        }
        if let Some(path) = job.transform {
            let bytes = files::write(path, |out| {
                serde_json::to_writer_pretty(&mut *out, motion)?;
                out.write_all(b"\n")
            })?;
            report.add_output(Output { path: path.to_path_buf(), bytes, content: "motion".to_owned() });
        }
        Ok(())
    })?;
    report.timings.write = seconds;
    Ok(())
}
