//! The registration of many views: read, start, register, write.

use crate::commands::register::request::Start;
use crate::commands::register_views::results::ViewsResults;
use crate::commands::register_views::scan_views::ViewFile;
use crate::error::Error;
use crate::files;
use crate::input::moving::moved;
use crate::input::poses;
use crate::output::staging::Staging;
use crate::report::summary::plain;
use crate::report::wording::{counted, not_finite};
use crate::report::{Input, Output, Report, Timings};
use crate::runtime::progress::Progress;
use industrial_geometry::io::{self, Content, Format, ReadOptions, WriteOptions};
use industrial_geometry::register::Pose;
use industrial_geometry::register::views::{
    PairSearch, View, ViewsOptions, ViewsReport, ViewsStatus, have_much_in_common, register_views,
};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Name of the file with all poses.
pub(crate) const POSES: &str = "poses.json";
/// Root mean square distance, as a share of the size of a view, above which the given poses are not believed.
const GOOD_RMS: f64 = 0.002;
/// Distance, as a share of the size of a view, within which matched points speak for a result.
const NEAR: f64 = 0.012;

/// What is to be done.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// The views.
    pub(crate) views: &'a [ViewFile],
    /// Folder for the moved views.
    pub(crate) out: &'a Path,
    /// Where to start.
    pub(crate) start: Start<'a>,
    /// Options of the library.
    pub(crate) options: ViewsOptions,
    /// Whether nobody wants to watch.
    pub(crate) quiet: bool,
}

/// A view as read.
struct Loaded {
    content: Content,
    format: Format,
    points: usize,
    view: View,
}

/// The files that are written: the moved views under their own names, and the poses.
fn outputs(views: &[ViewFile], out: &Path) -> Vec<PathBuf> {
    let names = views.iter().map(|view| &view.name);
    names.map(|name| out.join(name)).chain([out.join(POSES)]).collect()
}

/// Does the job and fills in the report; returns whether all views found their places.
pub(crate) fn run(job: &Job<'_>, report: &mut Report) -> Result<bool, Error> {
    let init = if let Start::Poses(file) = job.start { Some(file) } else { None };
    let inputs: Vec<&Path> = job.views.iter().map(|view| view.path.as_path()).chain(init).collect();
    check(job, &inputs)?;
    let mut timings = Timings::default();
    let given = init.map(|file| poses_of(file, job.views.len())).transpose()?;
    let mut loaded = Vec::with_capacity(job.views.len());
    for view in job.views {
        loaded.push(Timings::measure(&mut timings.read, || read(view, report))?);
    }
    let views: Vec<View> = loaded.iter().map(|one| one.view.clone()).collect();

    let progress = Progress::steps("registering views", job.quiet);
    let began = Instant::now();
    let (found, start) = solve(job, &views, given, &progress)?;
    timings.compute = began.elapsed().as_secs_f64();
    drop(progress);

    for pair in found.pairs.iter().filter(|pair| pair.is_doubtful) {
        let [one, other] = pair.views.map(|view| job.views[view].path.display());
        report.warnings.push(format!(
            "{one} and {other} are {} apart where they overlap (rms), much more than the noise of either: they lie on each other wrongly, \
             or do not show the same part; give other poses (--init), or choose --start global",
            plain(pair.rms_after)
        ));
    }
    for pair in found.pairs.iter().filter(|pair| pair.is_ambiguous) {
        let [one, other] = pair.views.map(|view| job.views[view].path.display());
        report.warnings.push(format!(
            "{one} and {other} lie on each other about as well in another place, or fit best there: what they have in common does not tell \
             ({:.0} % of one and {:.0} % of the other); add views between them, or look at the result and give poses near it (--init)",
            100.0 * pair.overlap[0],
            100.0 * pair.overlap[1]
        ));
    }
    let outputs = outputs(job.views, job.out);
    let triples = job.views.iter().zip(&outputs).zip(&loaded);
    let triples = triples.map(|((view, moved), one)| (view.clone(), moved.clone(), one.points));
    let results = ViewsResults::new(&found, start, triples);
    for (input, view) in report.inputs.iter_mut().zip(&results.views) {
        input.count(view.points_dropped, view.points.saturating_sub(view.points_dropped));
    }
    let mut seconds = 0.0;
    Timings::measure(&mut seconds, || write(job, loaded, &found, &results, report))?;
    timings.write = seconds;
    report.timings = timings;
    report.results = Some(Box::new(results));
    Ok(found.status.is_converged())
}

/// Makes sure that every view has a name of its own and no input is overwritten.
fn check(job: &Job<'_>, inputs: &[&Path]) -> Result<(), Error> {
    files::check_folder(job.out)?;
    if job.views.len() < 2 {
        let what = "there is one view only";
        return Err(Error::usage(what, "give two or more, or a file of several scans (E57, PTX)"));
    }
    let mut names: Vec<_> = job.views.iter().map(|view| &view.name).collect();
    if let Some(view) = job.views.iter().find(|view| view.name.is_empty()) {
        return Err(Error::content(&view.path, "this is not the name of a file", "name a file"));
    }
    names.sort();
    if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
        let name = pair[0].to_string_lossy();
        let what = format!("two views are called {name}, and would overwrite each other in the output");
        return Err(Error::usage(what, "rename one of them"));
    }
    if job.views.iter().any(|view| files::is_stream(&view.path)) {
        return Err(Error::usage("a view cannot come from standard input (`-`)", "put it into a file"));
    }
    if fs::metadata(job.out).is_ok_and(|metadata| !metadata.is_dir()) {
        return Err(Error::content(job.out, "this is not a folder", "choose another name for the output"));
    }
    let outputs = outputs(job.views, job.out);
    let clash = outputs.iter().find(|output| inputs.iter().any(|input| files::is_same(output, input)));
    clash.map_or(Ok(()), |path| {
        Err(Error::content(path, "this would overwrite an input", "choose another folder"))
    })
}

fn poses_of(file: &Path, views: usize) -> Result<Vec<Pose<3>>, Error> {
    let poses = poses::read(file)?;
    if poses.len() != views {
        let what = format!("{} for {}", counted(poses.len(), "pose"), counted(views, "view"));
        return Err(Error::content(file, what, "give one pose per view, in their order"));
    }
    match poses.iter().position(|pose| pose.scale != 1.0) {
        Some(at) => {
            let what = format!("entry {at} (from 0) has the scale {}", poses[at].scale);
            Err(Error::content(file, what, "views are moved, not scaled: give rotations and translations"))
        }
        None => Ok(poses),
    }
}

fn read(view: &ViewFile, report: &mut Report) -> Result<Loaded, Error> {
    let path = view.path.as_path();
    let scan = view.scan.map(|number| number.to_string());
    let loaded = files::read(path, &ReadOptions::default().with_scan(scan))?;
    report.add_input(Input::new("view", path, &loaded.report));
    report.warnings.extend(loaded.report.warnings.iter().map(|w| format!("{}: {w}", path.display())));
    if loaded.report.non_finite > 0 {
        report.warnings.push(not_finite(
            path,
            loaded.report.non_finite,
            loaded.report.points,
            "moved, not used",
        ));
    }
    let failed = |error: industrial_geometry::register::Error| {
        Error::content(path, error.to_string(), "check it with `indgeo info`")
    };
    let cloud = match &loaded.content {
        Content::Cloud(cloud) => cloud,
        Content::Mesh(mesh) => mesh.cloud(),
        Content::Nurbs(_) => {
            let what = "a scan is needed, but this file holds NURBS shapes";
            return Err(Error::content(path, what, "register scans to a model with `indgeo register`"));
        }
    };
    if cloud.dimension() == 2 {
        let what = "the points have two columns only";
        return Err(Error::content(path, what, "give points of three columns, x, y and z"));
    }
    let view = match &loaded.content {
        Content::Mesh(mesh) if cloud.attributes().normals().is_none() => View::from_mesh(mesh),
        _ => View::from_cloud(cloud).map_err(failed)?,
    };
    Ok(Loaded { format: loaded.report.format, points: loaded.report.points, content: loaded.content, view })
}

/// Registers, and says where the result that counts began.
fn solve(
    job: &Job<'_>,
    views: &[View],
    given: Option<Vec<Pose<3>>>,
    progress: &Progress,
) -> Result<(ViewsReport, &'static str), Error> {
    let failed = |error: industrial_geometry::register::Error| name_view(&error, job);
    let tell = |done: usize, total: usize| progress.report(done, total);
    let from = |poses: &[Pose<3>]| register_views(views, poses, &job.options, &tell).map_err(failed);
    let search = || PairSearch::new(views, &job.options, &tell).map_err(failed);
    if matches!(job.start, Start::Global) {
        let search = search()?;
        return Ok((search.judged(views, from(&search.poses())?), "search"));
    }
    let (near, origin) = match &given {
        Some(poses) => (from(poses)?, "init"),
        None => (from(&vec![Pose::identity(); views.len()])?, "given"),
    };
    let is_converged = near.status == ViewsStatus::Converged;
    // Views with little in common lie on each other in many places: whether they do elsewhere as well is looked for.
    let is_sure = is_converged && have_much_in_common(&near);
    let is_asked = given.is_some() || matches!(job.start, Start::Given);
    // Poses of the files are not searched for.
    if is_asked && !is_converged || job.views.iter().all(|view| view.is_posed) {
        return Ok((near, origin));
    }
    let size = size(views);
    if is_sure && (is_asked || near.rms <= GOOD_RMS * size) {
        return Ok((near, origin));
    }
    let search = search()?;
    let near = search.judged(views, near);
    if is_asked || near.status == ViewsStatus::Converged && near.rms <= GOOD_RMS * size {
        return Ok((near, origin));
    }
    let found = from(&search.poses())?;
    let (best, origin) =
        if worth(&found, size) > worth(&near, size) { (found, "search") } else { (near, "given") };
    Ok((search.judged(views, best), origin))
}

/// The error of the library with the file of the view it speaks of (`view 3: …`).
fn name_view(error: &industrial_geometry::register::Error, job: &Job<'_>) -> Error {
    if let industrial_geometry::register::Error::Option { name, value, allowed } = error {
        return Error::option(name, *value, &format!("in {allowed}"), "see `indgeo register-views --help`");
    }
    let text = error.to_string();
    let rest = text.strip_prefix("view ").and_then(|rest| rest.split_once(": "));
    let named =
        rest.and_then(|(index, what)| Some((&job.views.get(index.parse::<usize>().ok()?)?.path, what)));
    match named {
        Some((path, what)) => Error::content(path, what, "check it with `indgeo info`"),
        None => Error::usage(text, "see `indgeo register-views --help`"),
    }
}

/// The size of a view: the median of the diagonals.
fn size(views: &[View]) -> f64 {
    let mut diagonals: Vec<f64> =
        views.iter().filter_map(View::bounding_box).map(|bounds| bounds.diagonal()).collect();
    diagonals.sort_by(f64::total_cmp);
    diagonals.get(diagonals.len() / 2).copied().unwrap_or(0.0)
}

/// How many matched points speak for a result: distances that chance explains, spread evenly up to a limit, count nothing.
fn worth(found: &ViewsReport, size: f64) -> f64 {
    let one = |count: usize, rms: f64| count as f64 * (1.0 - 3.0 * (rms / (NEAR * size)).powi(2)).max(0.0);
    found.pairs.iter().map(|pair| one(pair.count, pair.rms_after)).sum()
}

/// Writes all files, or none.
fn write(
    job: &Job<'_>,
    loaded: Vec<Loaded>,
    found: &ViewsReport,
    results: &ViewsResults,
    report: &mut Report,
) -> Result<(), Error> {
    let mut staging = Staging::new(job.out)?;
    for ((file, one), view) in job.views.iter().zip(loaded).zip(&found.views) {
        let target = job.out.join(&file.name);
        let options = match file.scan {
            Some(_) => WriteOptions::default(),
            None => WriteOptions::default().with_format(one.format),
        };
        let content = moved(one.content, &view.pose, &file.path)?;
        let written = io::write(staging.path(&target), &content, &options)?;
        report.warnings.extend(written.warnings.iter().map(|w| format!("{}: {w}", target.display())));
        let content = counted(written.points, "moved point");
        report.add_output(Output { path: target, bytes: written.bytes, content });
    }
    let target = job.out.join(POSES);
    let failed = |source: std::io::Error| Error::write(&target, source);
    let mut text = serde_json::to_string_pretty(results).map_err(|error| failed(error.into()))?;
    text.push('\n');
    fs::write(staging.path(&target), &text).map_err(failed)?;
    staging.commit()?;
    let content = "poses of the views, distances of the pairs".to_owned();
    report.add_output(Output { path: target, bytes: text.len() as u64, content });
    Ok(())
}
