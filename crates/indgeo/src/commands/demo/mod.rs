//! `indgeo demo`: the main job on real data that ship with the repository.

pub(crate) mod job;

use self::job::{Bolt, Data, Files, Zones};
use super::project::search::Search;
use crate::commands::project::job as projection;
use crate::commands::project::request::Job;
use crate::common::Common;
use crate::error::Error;
use crate::files;
use crate::input::cad::Choice;
use crate::output::staging::create_error;
use crate::report::{Outcome, Output, Report, Timings};
use std::fs;
use std::path::{Path, PathBuf};

/// Compare a scanned stud bolt with its nominal thread, register it, inspect a CAD part: results, reports and pictures in a folder
///
/// Projects a structured-light scan (8565 points) onto the nominal M12 × 1.75 thread and shank, given as NURBS surfaces,
/// as `indgeo project` does, and draws the deviations. Then it puts the scan out of place, finds the place again as `indgeo
/// register` does, and judges it there by a tolerance as `indgeo inspect` does. Last, it inspects a scan of a CAD part (STEP) with
/// a bump and a wrong hole that are known, and shows that they are what is found. Needs no network; the data are in fixtures/ of the repository.
#[derive(Debug, clap::Args)]
#[command(after_long_help = "\
Files in the folder:
  deviations.csv   one row per scanned point: footpoint, signed distance, surface, parameters, status
  deviations.ply   the scan with the same values, for CloudCompare or MeshLab (colour by `distance`)
  deviations.svg   the picture: side view, unrolled map, thread profile, histogram and statistics
  displaced.ply    the scan out of place; registered.ply, pose.json: where `indgeo register` takes it, and the motion
  registration.svg the picture: before and after, and the steps; registration.json: report of the registration
  report.html      the inspection of the registered scan, to be opened in a browser; inspection.json: its report
  cad-report.html  the inspection of a scan of a CAD part, whose errors are known (cad-scan.ply); cad-inspection.json: its report

Exit status 0: every point was projected, the registration converged, and the known errors were found; 1: not so; 2: no data, or the folder cannot be written; 130: interrupted.

Example:
  indgeo demo --out my-demo")]
pub(crate) struct Args {
    /// Folder for the results; made if it does not exist
    #[arg(long, short, value_name = "FOLDER", default_value = "indgeo-demo")]
    pub(crate) out: PathBuf,
    /// Folder `fixtures` of the repository, if it is not to be looked for
    #[arg(long, value_name = "FOLDER")]
    data: Option<PathBuf>,
    #[command(flatten)]
    search: Search,
}

impl Args {
    /// The files that are written first: table, cloud and picture of the deviations.
    fn deviations(&self) -> [PathBuf; 3] {
        ["csv", "ply", "svg"].map(|extension| self.out.join("deviations").with_extension(extension))
    }

    /// All files that are written.
    pub(crate) fn results(&self) -> Vec<PathBuf> {
        self.deviations().into_iter().chain(Files::all(&self.out)).collect()
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args, common: &Common, report: &mut Report) -> Result<Outcome, Error> {
    files::check_folder(&args.out)?;
    let data = Data::find(args.data.as_deref())?;
    let bolt = Bolt::read(&data.placement)?;
    fs::create_dir_all(&args.out).map_err(|source| create_error(&args.out, source))?;
    let [csv, ply, svg] = args.deviations();

    let job = Job {
        model: &data.model,
        cad: &Choice::default(),
        points: &data.scan,
        out: &csv,
        format: None,
        options: args.search.options()?,
        max_angle: None,
        mode: args.search.mode,
        drop_non_finite: args.search.drop_non_finite,
        scan: Some(&args.search.scan),
        threads: common.threads,
        quiet: common.quiet,
    };
    let projected = projection::run(&job, report)?;
    projection::write_also(&ply, &projected, report)?;
    let zones = bolt.zones(&projected).ok_or_else(|| {
        Error::content(&data.scan, "the scan does not cover the thread", "take the file from the repository")
    })?;
    let mut timings = report.timings;
    let bytes = Timings::measure(&mut timings.write, || {
        job::write_text(&svg, &job::draw(&bolt, &projected, &zones))
    })?;
    report.timings = timings;
    let content = "picture: side view, unrolled map, thread profile, histogram, statistics".to_owned();
    report.add_output(Output { path: svg.clone(), bytes, content });

    let (text, registered) = job::align(&data, &bolt, &args.out, &job.options, common, report)?;
    let mut summary = format!("{}\n{}\n{text}", report.summary(), explain(&zones, &job, &svg));
    #[cfg(feature = "step")]
    let is_found = {
        let (text, is_found) = job::inspect_part(&data, &args.out, &job.options, common, report)?;
        summary.push('\n');
        summary.push_str(&text);
        is_found
    };
    #[cfg(not(feature = "step"))]
    let is_found = true;
    Ok(Outcome::new(summary, registered && is_found && projection::all_converged(report)))
}

/// What was found, and how to get the same without the demonstration.
fn explain(zones: &Zones, job: &Job<'_>, svg: &Path) -> String {
    let inside = &zones.inside;
    format!(
        "Of the scan, {} points lie over the nominal thread and shank, {} beyond them (run-outs, necks, point).\n\
         Signed distance to the nominal surface, mm:\n  \
         crests {:+.3} ± {:.3}   flanks {:+.3} ± {:.3}   roots {:+.3} ± {:.3}   (mean ± standard deviation)\n\
         Look at {}: blue crests lie inside the nominal profile; red roots are filled in, in strips along\n\
         the axis where the scanner did not see to their bottom.\n\n\
         The same by hand:\n  indgeo project {} {} -o deviations.csv\n",
        inside.count,
        zones.beyond,
        zones.crests.mean,
        zones.crests.standard_deviation,
        zones.flanks.mean,
        zones.flanks.standard_deviation,
        zones.roots.mean,
        zones.roots.standard_deviation,
        svg.display(),
        job.model.display(),
        job.points.display(),
    )
}
