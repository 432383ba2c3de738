//! The registration of a cloud: read, start, register, choose, write.

use super::request::{Cloud, Job, Start};
use crate::commands::register::beside::Beside;
use crate::commands::register::field::{Extent, RegistrationField, locks_fit_the_plane};
use crate::commands::register::model::RegistrationModel;
use crate::commands::register::near::{self as near_symmetry, Others};
use crate::commands::register::page::{self as registration_page, Page};
use crate::commands::register::results::{self as found, Checks, RegistrationResults, StartResult};
use crate::commands::register::runs::register_all;
use crate::commands::register::sight::Sights;
use crate::commands::register::starts::{Tries, Try};
use crate::commands::register::verdict;
use crate::error::Error;
use crate::files;
use crate::input::moving::moved;
use crate::input::{poses, sampling};
use crate::report::wording::{counted, not_finite};
use crate::report::{Input, ModelSummary, Output, Report, Timings};
use crate::runtime::progress::Progress;
use industrial_geometry::io::{self, Content, ReadOptions, WriteOptions};
use industrial_geometry::mesh::nalgebra::Vector3;
use industrial_geometry::register::{Pose, RegisterReport};
use std::io::BufWriter;
use std::path::Path;
use std::time::Instant;

/// Places of the model on the page.
const SHOWN: usize = 4000;

/// Where the points came to lie.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Registered {
    pub(crate) pose: Pose<3>,
    pub(crate) converged: bool,
}

/// Does the job and fills in the report.
pub(crate) fn run(job: &Job<'_>, report: &mut Report) -> Result<Registered, Error> {
    let init = if let Start::Poses(file) = job.start { Some(file) } else { None };
    let inputs: Vec<&Path> = [job.model, job.points].into_iter().chain(init).collect();
    files::check_inputs(&inputs)?;
    for path in [job.out, job.transform, job.page].into_iter().flatten() {
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
    let loaded = Timings::measure(&mut timings.read, || match job.out {
        // The moved points are all of them.
        Some(_) => files::read(job.points, &ReadOptions::default()),
        None => sampling::read(job.points, job.sample, report),
    })?;
    report.add_input(Input::new("points", job.points, &loaded.report));
    let content = loaded.content;
    warn(job, &loaded.report, report);
    let sights = match &content {
        Content::Cloud(cloud) => Sights::new(&model, [&read, &loaded.report], cloud),
        Content::Mesh(_) | Content::Nurbs(_) => Sights::default(),
    };
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
        report.warn_now(scan.and_then(|scan| cad.unit_warning(scan.diagonal())), job.quiet);
    }
    let field = Timings::measure(&mut timings.build, || model.field(job.model))?;
    report.model = Some(ModelSummary {
        kind: model.kind(),
        unit: model.unit(),
        points_unit: match &model {
            RegistrationModel::Cad(cad) => Some(cad.points_unit()),
            _ => None,
        },
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
    let solution = solve(job, &model, &field, &cloud, &sights, given, &progress)?;
    timings.compute = began.elapsed().as_secs_f64();
    drop(progress);
    report.timings = timings;
    let Solution { starts, best, start, result, equivalent, others, checks } = solution;
    report.warnings.extend(verdict::warning(&result, &checks, job));
    report.warnings.extend(others.warning());
    if equivalent.len() > 1 {
        report.warnings.push(format!(
            "the model has {} positions that its shape does not tell apart; this is the one nearest to the start, all are in \
             `equivalent_poses`",
            equivalent.len()
        ));
    }
    let began = if starts[best].origin == "search" { Pose::identity() } else { start };
    let motion = found::transform(&result, &equivalent, &checks);
    let results = RegistrationResults::new(motion, starts, best);
    if let Some(path) = job.page {
        let name = |path: &Path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let places = model.few_samples().map_or_else(Vec::new, |samples| thinned(samples.points(), SHOWN));
        let unit = report.model.as_ref().and_then(|model| model.unit.clone());
        let in_unit = |name: String, how: &str| match &unit {
            Some(unit) => format!("{name} ({how}{unit})"),
            None => name,
        };
        let page = Page {
            model_name: &in_unit(name(job.model), "unit: "),
            points_name: &in_unit(name(job.points), "states no unit, taken as "),
            model: &places,
            points: &cloud.positions,
            pose: &result.pose,
            start: &began,
            field: &field,
            results: &results,
        };
        let bytes = files::write(path, |out| registration_page::write(&mut BufWriter::new(out), &page))?;
        let content = "page: before and after, residuals, overlap, uncertainty".to_owned();
        report.add_output(Output { path: path.to_path_buf(), bytes, content });
    }
    write(job, content, &result.pose, &results.transform, report)?;
    report.count_points("points", result.dropped, result.used);
    report.results = Some(Box::new(results));
    Ok(Registered { pose: result.pose, converged: result.is_converged() })
}

/// Some points, evenly picked.
fn thinned(points: &[Vector3<f64>], most: usize) -> Vec<Vector3<f64>> {
    points.iter().step_by(points.len().div_ceil(most).max(1)).copied().collect()
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

/// Registers from every start: those of which there may be many with some of the points first, and the best with all.
fn solve(
    job: &Job<'_>,
    model: &RegistrationModel,
    field: &RegistrationField,
    cloud: &Cloud<'_>,
    sights: &Sights,
    given: Option<Vec<Pose<3>>>,
    progress: &Progress,
) -> Result<Solution, Error> {
    let mut tries = Tries::new(job, model, field, cloud, sights, progress)?;
    match &given {
        Some(poses) => {
            let extent = if poses.len() > 1 { Extent::Some } else { Extent::All };
            for pose in poses {
                tries.add("init", pose, extent)?;
            }
        }
        None if matches!(job.start, Start::Given) => tries.add("given", &Pose::identity(), Extent::All)?,
        None => {
            let has_search = !matches!(model, RegistrationModel::Curves(_));
            if !matches!(job.start, Start::Global) {
                tries.add("given", &Pose::identity(), if has_search { Extent::Some } else { Extent::All })?;
                if tries.last_is_good() {
                    tries.complete()?;
                }
            }
            let is_done = tries.best().is_some_and(|best| best.is_complete && tries.is_good(best));
            if has_search && !is_done || tries.list.is_empty() {
                for pose in &tries.search()? {
                    tries.add_found(pose)?;
                    if tries.last_is_good() {
                        break;
                    }
                }
            }
            tries.complete()?;
            tries.add_beside()?;
        }
    }
    tries.complete()?;
    let Some(best) = tries.best_index() else {
        let what = "no position was found in which the points lie on the model";
        return Err(Error::content(job.points, what, "give a starting pose (--init)"));
    };
    let starts = tries.list.iter().map(Try::summary).collect();
    let Try { origin, start, ref result, .. } = tries.list[best];
    let (mut result, mut equivalent, mut others) = (result.clone(), Vec::new(), Others::default());
    if verdict::may_be_symmetric(model, &result, &job.options) {
        let tolerance = result.covariance.as_ref().map_or(0.0, |covariance| covariance.sigma);
        let from = if origin == "search" { Pose::identity() } else { start };
        let again = |pose: &Pose<3>| register_all(job, field, cloud, pose, progress);
        let samples = model.samples(job.model)?;
        let (group, near) = field.symmetries(&samples, tolerance);
        let beside = Beside { job, field, cloud, progress, samples: &samples, near: &near, tolerance };
        (result, others) = near_symmetry::best(&beside, result)?;
        if result.free_motions.is_empty() {
            (result, equivalent) = verdict::nearest(&group, result, &from, &cloud.positions, again)?;
        }
    }
    let is_given = given.is_some() || matches!(job.start, Start::Given);
    let elsewhere = if is_given { tries.better_than(&result, others.is_taken)? } else { None };
    let mirrored = if elsewhere.is_none() { tries.better_mirrored(&result)? } else { None };
    let has_another_copy = result.is_converged() && tries.has_another_copy(&result.pose);
    let rivals = others.as_good.clone();
    let found = Checks { elsewhere, mirrored, has_another_copy, rivals, ..Checks::default() };
    let (result, checks) = verdict::checked(model, field, result, &cloud.positions, sights, found);
    Ok(Solution { starts, best, start, result, equivalent, others, checks })
}

/// What came of all starts.
struct Solution {
    starts: Vec<StartResult>,
    /// The start that counts.
    best: usize,
    /// Its pose.
    start: Pose<3>,
    result: RegisterReport<3>,
    /// Poses that the model does not tell apart from the result, which is the first of them; none where they were not looked for.
    equivalent: Vec<Pose<3>>,
    /// What came of positions in which most of the model lies on itself.
    others: Others,
    checks: Checks,
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
