//! `indgeo fit-curve`: a B-spline curve through a cloud.

pub(crate) mod evolution;
pub(crate) mod job;
pub(crate) mod joins;
pub(crate) mod page;
pub(crate) mod results;
pub(crate) mod start;
pub(crate) mod summary;
pub(crate) mod tables;

use self::job::Job;
use self::joins::Joins;
use super::numbers;
use crate::common::Common;
use crate::error::Error;
use crate::fits::arguments::LoopArgs;
use crate::fits::boundary::ContinuityChoice;
use crate::fits::page::is_page;
use crate::output::cad::CadArgs;
use crate::report::{Outcome, Report};
use industrial_geometry::fit::FitOptions;
use industrial_geometry::fit::curve::CurveOptions;
use std::path::{Path, PathBuf};

/// Fit a B-spline curve to POINTS
///
/// Nothing but the points is needed, in any order, in the plane or in space: whether the curve is closed, where it starts,
/// how much it is smoothed and how many control points it has is found from them. With --tolerance knots are inserted where
/// the error is, until it holds.
#[derive(Debug, clap::Args)]
#[command(after_long_help = AFTER_HELP)]
pub(crate) struct Args {
    /// The points: any cloud of two or three columns; a third column of zeros counts as none; `-` is standard input
    #[arg(required_unless_present = "model")]
    points: Option<PathBuf>,
    /// Fit to the curves in FILE (NURBS JSON) instead of points; distances are those of sensor points of the curve, orthogonal to the model
    #[arg(long, value_name = "FILE", conflicts_with_all = ["points", "tolerance", "search", "rational"])]
    model: Option<PathBuf>,
    /// Sensor points in each span of the curve, for --model
    #[arg(long, value_name = "N", default_value_t = 6, requires = "model", value_parser = numbers::count)]
    sensors: usize,
    /// The curve: STEP (.step, .stp), IGES (.igs, .iges), else NURBS JSON; `-` is standard output (JSON)
    #[arg(long, short, value_name = "OUT")]
    out: Option<PathBuf>,
    /// Largest distance of a point that is wanted, in the units of the file
    #[arg(long, value_name = "T", conflicts_with = "controls", value_parser = numbers::length)]
    tolerance: Option<f64>,
    /// Number of control points, repetitions in a closed curve not counted [default: by tolerance or noise]
    #[arg(long = "control-points", visible_alias = "controls", value_name = "N", conflicts_with = "init", value_parser = numbers::count)]
    controls: Option<usize>,
    /// Most control points
    #[arg(
        long = "max-control-points",
        visible_alias = "max-controls",
        value_name = "N",
        default_value_t = 200,
        value_parser = numbers::count
    )]
    max_controls: usize,
    /// Degree
    #[arg(long, value_name = "P", default_value_t = 3, conflicts_with = "init", value_parser = numbers::degree)]
    degree: usize,
    /// The curve is closed [default: as the points show]
    #[arg(long, conflicts_with_all = ["open", "init"])]
    closed: bool,
    /// The curve is open [default: as the points show]
    #[arg(long, conflicts_with = "init")]
    open: bool,
    /// Start from the curve in FILE (NURBS JSON); its degree and knots stay
    #[arg(long, value_name = "CURVE.json")]
    init: Option<PathBuf>,
    /// Search the whole plane for the outline first: the start, or a place inside the points, grows as a contour until it meets them; for
    /// closed curves in the plane whose start is far away, or that wind
    #[arg(long, conflicts_with = "open")]
    search: bool,
    /// Continue the curve in FILE from its end that is nearest to the points; may be given twice
    #[arg(long, value_name = "CURVE", conflicts_with_all = ["closed", "search", "rational", "model"])]
    join: Vec<PathBuf>,
    /// How curves are continued
    #[arg(long, value_enum, requires = "join", default_value_t = ContinuityChoice::G1)]
    continuity: ContinuityChoice,
    /// Length without points that belongs to the curve nevertheless, in the units of the file; where points are further apart there are several
    /// curves, or a part without data [default: as the other distances of neighbours show]
    #[arg(long, value_name = "LENGTH", value_parser = numbers::length)]
    max_gap: Option<f64>,
    /// Weights are unknowns, too: conics become exact, as arcs of degree 2, if there are as many control points as these
    /// need: 6 for a closed curve, 3 to 9 for an open one
    #[arg(long)]
    rational: bool,
    /// Write the footpoint of every point (CSV): the point, its foot, distance and parameter
    #[arg(long, value_name = "FILE.csv")]
    points_out: Option<PathBuf>,
    /// A page (.html): the curve, the points by their distance, a curvature comb, the history; or the history alone (.csv), one line per
    /// iteration: distance, energy factor, step, …
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// The evolution of the curve: drawn (SVG; space curves as seen along z), or all curves on the way as NURBS (JSON)
    #[arg(long, value_name = "FILE")]
    evolution: Option<PathBuf>,
    #[command(flatten)]
    cad: CadArgs,
    #[command(flatten)]
    iteration: LoopArgs,
}

const AFTER_HELP: &str = "\
The report (--json) holds in `results`: `status`, `closed` and why (`closure`), `start`, `control_points`, `degree`, `rms`, `max`,
`max_index`, `share_within` and `within_tolerance` (with a tolerance), `coverage` and `covered`, `crossings` (parameters at which a plane curve crosses
itself), `joins` (with --join: the gap and the angle at each end), `stages` (the runs of the iteration) and `history` (every iteration of those that were kept).

Points on several curves that are apart from each other become several curves in one file, each with a report of its own (`parts`).

`coverage` tells how near every part of the curve is to the points: distances of the curve from the nearest point (`rms`, `max`), the
parts between feet of neighbours that are without data (`without_data`, `length_without_data`, also in spacings), the length over that of the polygon
through the feet (`length_ratio`), and how many points are further away than spacing, noise or tolerance explain (`points_far`).
`covered` says whether all of this holds.

Exit status 0: the tolerance holds, or, without one, the iteration converged, and every part of the curve is near to points and every point
near to the curve; 1: something of this does not hold, and the message says where (files are written nevertheless); 2: bad input or
usage; 130: interrupted.

Examples:
  indgeo fit-curve section.xyz -o section.step --unit mm
  indgeo fit-curve section.xyz -o section.json --tolerance 0.05 --points-out deviations.csv --report section.html
  indgeo fit-curve cloud.xyz -o curve.json --control-points 24 --open --evolution evolution.svg
  indgeo fit-curve gap.xyz -o blend.step --join left.step --join right.step --unit mm
  indgeo fit-curve outline.xyz --init circle.json --search -o curve.json --evolution growth.json
  indgeo fit-curve cloud.xyz --init start.json --term tangent --step-control none --report history.csv";

impl Args {
    /// The files that are read, and those that are written.
    pub(crate) fn files(&self) -> (Vec<&Path>, Vec<PathBuf>) {
        let read = self.points.iter().chain(&self.model).chain(&self.init).chain(&self.join);
        let read = read.map(PathBuf::as_path);
        let written = [&self.out, &self.points_out, &self.report, &self.evolution];
        (read.collect(), written.into_iter().flatten().cloned().collect())
    }

    fn options(&self) -> CurveOptions {
        let fit = self.iteration.applied_to(FitOptions::default()).with_evolution(self.evolution.is_some());
        CurveOptions::default()
            .with_degree(self.degree)
            .with_closed((self.closed || self.open).then_some(self.closed))
            .with_controls(self.controls)
            .with_abs_tolerance(self.tolerance)
            .with_max_controls(self.max_controls)
            .with_rational(self.rational)
            .with_search(self.search)
            .with_max_gap(self.max_gap)
            .with_fit(fit)
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args, common: &Common, report: &mut Report) -> Result<Outcome, Error> {
    let (_, written) = args.files();
    common.something_written(!written.is_empty(), "-o OUT")?;
    args.cad.check(args.out.as_deref())?;
    // One of them is there: the arguments say so.
    let Some(points) = args.points.as_deref().or(args.model.as_deref()) else {
        return Err(Error::usage("there are no points", "give a file of points, or --model FILE"));
    };
    if args.join.len() > 2 {
        return Err(Error::usage("a curve has two ends", "give --join at most twice"));
    }
    let job = Job {
        points,
        sensors: args.model.as_ref().map(|_| args.sensors),
        init: args.init.as_deref(),
        joins: Joins { files: &args.join, continuity: args.continuity },
        out: args.out.as_deref(),
        cad: &args.cad,
        feet: args.points_out.as_deref(),
        page: args.report.as_deref().filter(|path| is_page(path)),
        history: args.report.as_deref().filter(|path| !is_page(path)),
        evolution: args.evolution.as_deref(),
        options: args.options(),
        quiet: common.quiet,
    };
    let verdict = job::run(&job, report)?;
    Ok(verdict.outcome(report.summary()))
}
