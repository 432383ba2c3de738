//! `indgeo merge`: partial results become the result of one run.

use super::{inspect, register};
use crate::commands::inspect::job::{self as inspecting, Motion, Parts};
use crate::common::{Common, parse};
use crate::error::Error;
use crate::input::scan_files;
use crate::input::transform::Transform;
use crate::output::partials::Kind;
use crate::report::summary::{plain, write_end};
use crate::report::wording::counted;
use crate::report::{Outcome, Report};
use std::path::{Path, PathBuf};

/// Add up partial results (`--partial`) of tiles: the same to the byte as one run over all of them
///
/// Partial results of `indgeo inspect` become its report and page, those of `indgeo register` the step and the pose that follow from
/// their sums. The model is read again, to be named and shown.
#[derive(Debug, clap::Args)]
#[command(after_long_help = AFTER_HELP)]
pub(crate) struct Args {
    /// Partial results, in any order
    #[arg(required = true, value_name = "PARTIAL")]
    partials: Vec<PathBuf>,
    /// Files of points, or a folder of them, of which there must be a partial result each
    #[arg(long, value_name = "FILE|FOLDER", num_args = 1..)]
    tiles: Vec<PathBuf>,
    /// The model, if it is elsewhere now; its content must be the same
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Write a page (HTML) that works offline: map of the deviations, histogram, tables
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Write the pose after the step (JSON), of partial results of `indgeo register`; it is the --init of the next step
    #[arg(long, value_name = "T.json")]
    transform: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
Each partial result knows its model, options, motion and points by their hashes (SHA-256). Refused are partial results of different
models, options, motions or versions of the program, of points that are in another one already, of files that changed in between,
and damaged ones; and gaps: each point of a file must be in one of them (--points), and each of --tiles. Without --tiles nothing
says which files there should be.

Tiles count in the order of their paths, for `inspect` and `merge` alike, so that points have the same numbers. Summary, --json and
--report are those of `indgeo inspect MODEL TILE...`; with --no-timings both write the same bytes.

Partial results of `indgeo register` become one step: {\"matrix\": the pose after it, 4 x 4 by rows, \"motion\": how far the points
move, as a share of the size of the model, \"rms\": of the distances before it, \"normal_matrix\" and \"normal_vector\": the sums in
the unknowns (translation, rotation vector) about \"origin\", ...}. Repeat with --init T.json until the motion is small.

Exit status 0: the parts together pass, or there is a step; 1: they do not pass, or there are motions that the points do not
determine; 2: bad input or usage, and partial results that do not belong together; 130: interrupted.

Examples:
  for t in tiles/*.laz; do indgeo inspect part.step $t -t 0.05 --partial parts/$(basename $t).json; done
  indgeo merge parts/*.json --tiles tiles --report report.html --json report.json
  indgeo inspect part.step scan.ply -t 0.05 --points 0..1000000 --partial a.json
  indgeo inspect part.step scan.ply -t 0.05 --points 1000000..1834201 --partial b.json
  indgeo merge a.json b.json
  indgeo merge sums-*.json --transform pose.json";

impl Args {
    /// The files that are read, and those that are written.
    pub(crate) fn files(&self) -> (Vec<&Path>, Vec<PathBuf>) {
        let read = self.partials.iter().chain(&self.model).map(PathBuf::as_path);
        (read.collect(), self.report.iter().chain(&self.transform).cloned().collect())
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args, common: &Common, report: &mut Report) -> Result<Outcome, Error> {
    let parts = Parts::read(&args.partials, &scan_files::expand(&args.tiles)?)?;
    match (parts.kind(), &args.report, &args.transform) {
        (Kind::Inspection, _, Some(out)) => {
            let what = "partial results of inspections have no pose to be written";
            Err(Error::content(out, what, "leave out --transform"))
        }
        (Kind::Registration, Some(page), _) => {
            let what = "the sums of a step have no page";
            Err(Error::content(page, what, "leave out --report"))
        }
        (Kind::Inspection, ..) => merge_inspection(args, &parts, common, report),
        (Kind::Registration, ..) => merge_step(args, &parts, common, report),
    }
}

/// The command that made the partial results, with the model where it is now.
fn typed<A: clap::Args>(args: &Args, parts: &Parts, tiles: &[PathBuf], more: &[&str]) -> Result<A, Error> {
    let model = args.model.as_deref().unwrap_or(parts.model());
    let text = |path: &Path| path.display().to_string();
    let mut words = parts.arguments().to_vec();
    words.extend(more.iter().map(|word| (*word).to_owned()));
    words.extend(["--".to_owned(), text(model)]);
    words.extend(tiles.iter().map(|tile| text(tile)));
    parse(&words).map_err(|_| {
        let path = args.partials.first().map_or(Path::new(""), PathBuf::as_path);
        let what = "the partial result was made with options that are not understood";
        Error::content(path, what, "make it again, by the command with --partial")
    })
}

fn merge_inspection(
    args: &Args,
    parts: &Parts,
    common: &Common,
    report: &mut Report,
) -> Result<Outcome, Error> {
    report.command = "inspect";
    let tiles = parts.tiles();
    let typed: inspect::Args = typed(args, parts, &tiles, &[])?;
    let mut job = typed.job(&tiles, common)?;
    job.page = args.report.as_deref();
    if let Some(rows) = parts.pose() {
        job.motion = Motion::Known(Transform::of_exact_rows(&rows));
    }
    let found = inspecting::merge(&job, parts, report)?;
    Ok(inspect::judged(&found, report))
}

fn merge_step(args: &Args, parts: &Parts, common: &Common, report: &mut Report) -> Result<Outcome, Error> {
    let tiles = parts.tiles();
    let more = ["--partial", "-"];
    let typed: register::Args = typed(args, parts, tiles.get(..1).unwrap_or_default(), &more)?;
    let mut job = typed.step_job(&tiles, common)?;
    if let Some(rows) = parts.pose() {
        job.motion = Motion::Known(Transform::of_exact_rows(&rows));
    }
    let step = inspecting::merge_step(&job, parts, args.transform.as_deref(), report)?;
    let mut text = format!(
        "step of {}: the points move by {:.3e} of the size of the model\n  before    rms {}\n",
        counted(usize::try_from(step.points_used).unwrap_or(usize::MAX), "point"),
        step.motion,
        plain(step.rms)
    );
    if step.free > 0 {
        report
            .warnings
            .push(format!("{} are not determined by the points, and not made", counted(step.free, "motion")));
    }
    // Writing to memory cannot fail.
    let _ = write_end(&mut text, report);
    let is_determined = step.free == 0;
    report.results = Some(Box::new(step));
    Ok(Outcome { summary: text, converged: is_determined, otherwise: "underdetermined" })
}
