//! `indgeo register-views`: many scans of one object, all at once.

pub(crate) mod job;
pub(crate) mod results;
pub(crate) mod scan_views;
pub(crate) mod summary;

use self::job::{Job, POSES};
use super::numbers;
use crate::commands::register::request::Start;
use crate::common::Common;
use crate::error::Error;
use crate::report::{Outcome, Report};
use clap::ValueEnum;
use industrial_geometry::register::views::ViewsOptions;
use std::path::{Path, PathBuf};

/// Move many scans of one object to where they fit each other best
///
/// All overlapping pairs are taken into account at once, so that errors do not add up along a chain of scans and loops
/// close. The first view stays where it is. The result is every moved view, and a file with the poses.
#[derive(Debug, clap::Args)]
#[command(after_long_help = AFTER_HELP)]
pub(crate) struct Args {
    /// The scans, at least two: clouds, or meshes whose vertices are the scanned points. The scans of a file of several (E57, PTX) are
    /// views of their own, which begin where the poses of the file place them
    #[arg(required = true, num_args = 1.., value_name = "VIEW")]
    views: Vec<PathBuf>,
    /// Folder for the moved views, which keep their names and formats, and for poses.json; made if it does not exist
    #[arg(long, short, value_name = "DIR")]
    out: PathBuf,
    /// Start from the poses in FILE, one per view (JSON, 4 x 4 row by row); poses.json of an earlier run serves as well
    #[arg(long, value_name = "FILE", conflicts_with = "start")]
    init: Option<PathBuf>,
    /// Where to start when there is no --init
    #[arg(long, value_enum, default_value_t = StartChoice::Auto)]
    start: StartChoice,
    /// Points of each view that are matched with the other views
    #[arg(long, value_name = "N", default_value_t = ViewsOptions::default().points_per_view, value_parser = numbers::count)]
    points_per_view: usize,
    /// Neighbours to which the surface around a point is fitted; more are better on noisy scans
    #[arg(long, value_name = "N", default_value_t = ViewsOptions::default().neighbours, value_parser = numbers::count)]
    neighbours: usize,
    /// Largest distance of matched points at the start, as a share of the diagonal of a view
    #[arg(long, value_name = "SHARE", default_value_t = ViewsOptions::default().max_distance, value_parser = numbers::positive)]
    max_distance: f64,
    /// Largest angle between the normals of matched points, degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 45.0, value_parser = numbers::positive)]
    max_angle: f64,
    /// Share of a view that another one must cover for the two to be linked
    #[arg(long, value_name = "SHARE", default_value_t = ViewsOptions::default().min_overlap, value_parser = numbers::share_or_none)]
    min_overlap: f64,
    /// The normals of all views point to the same side of the surface: their signs count
    #[arg(long)]
    oriented: bool,
    /// Most steps; a registration that they end is not converged (exit status 1)
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u16).range(1..))]
    max_iterations: u16,
}

/// Where to start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum StartChoice {
    /// From where the views are; if they do not come to fit, and have no poses in their files, a search over all positions as well
    Auto,
    /// From where the views are
    Given,
    /// Search over all positions
    Global,
}

const AFTER_HELP: &str = "\
poses.json: {\"status\": ..., \"rms\": ..., \"views\": [{\"path\": ..., \"matrix\": 4 x 4 row by row (common frame = matrix * view),
\"rotation\": {\"quaternion\": [w,x,y,z], \"axis\": [x,y,z], \"angle\": radians}, \"translation\": [x,y,z], \"covariance\": {...} or
null}, ...], \"pairs\": [{\"views\": [i, j], \"overlap\": [share of i, share of j], \"count\": matched points, \"rms_before\": ...,
\"rms_after\": ..., \"doubtful\": whether that is more than noise, \"ambiguous\": whether the two may lie on each other elsewhere as well}, ...], \"components\": [[views that hang together], ...], ...}. Views are numbered from 0.

Scans of one file are written as NAME-0.e57, NAME-1.e57, ... (of PTX as PLY); \"scan\" is their number, and \"matrix\" takes the points as
the poses of the file place them.

Files appear in DIR all together at the end, or not at all.
Exit status 0: converged; 1: not converged, doubtful or ambiguous pairs, views that overlap with no other, or views that can slide along
each other (\"underdetermined\"; files are written nevertheless); 2: bad input or usage; 130: interrupted.

Examples:
  indgeo register-views scan1.ply scan2.ply scan3.ply -o aligned
  indgeo register-views scans.e57 -o aligned
  indgeo register-views scans/*.ply -o aligned --start global --json report.json
  indgeo register-views scans/*.ply -o aligned --init turntable.json --neighbours 40";

impl Args {
    /// The files that are read, and those that are written.
    pub(crate) fn files(&self) -> (Vec<&Path>, Vec<PathBuf>) {
        let read = self.views.iter().chain(&self.init).map(PathBuf::as_path).collect();
        // What the scans of a file of several are called is known when it has been read.
        let names = self.views.iter().filter_map(|view| view.file_name());
        (read, names.map(|name| self.out.join(name)).chain([self.out.join(POSES)]).collect())
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args, common: &Common, report: &mut Report) -> Result<Outcome, Error> {
    let start = match (&args.init, args.start) {
        (Some(file), _) => Start::Poses(file),
        (None, StartChoice::Given) => Start::Given,
        (None, StartChoice::Auto) => Start::Auto,
        (None, StartChoice::Global) => Start::Global,
    };
    let options = ViewsOptions::default()
        .with_points_per_view(args.points_per_view)
        .with_neighbours(args.neighbours)
        .with_max_distance(args.max_distance)
        .with_max_angle(args.max_angle.to_radians())
        .with_min_overlap(args.min_overlap)
        .with_oriented(args.oriented)
        .with_max_iterations(usize::from(args.max_iterations));
    let views = scan_views::of(&args.views)?;
    let job = Job { views: &views, out: &args.out, start, options, quiet: common.quiet };
    let converged = job::run(&job, report)?;
    Ok(Outcome::new(report.summary(), converged))
}
