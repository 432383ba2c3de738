//! `indgeo fit-surface`: a B-spline surface through a scan.

pub(crate) mod conclusion;
pub(crate) mod edges;
pub(crate) mod finish;
pub(crate) mod job;
pub(crate) mod judgement;
pub(crate) mod start;
pub(crate) mod summary;
pub(crate) mod to_model;

use self::edges::Edges;
use self::job::Job;
use super::numbers;
use crate::common::Common;
use crate::error::Error;
use crate::fits::arguments::LoopArgs;
use crate::fits::boundary::ContinuityChoice;
use crate::fits::page;
use crate::input::sampling;
use crate::output::cad::CadArgs;
use crate::report::{Outcome, Report};
use clap::ValueEnum;
use industrial_geometry::fit::{BaseShape, NetSize, SurfaceOptions};
use std::path::{Path, PathBuf};

/// Fit a B-spline surface to POINTS
///
/// Nothing but the points is needed: no parameters, no boundary curves, no start. Closed parts get a surface that is closed
/// smoothly. With --tolerance knots are inserted where the error is, until it holds.
#[derive(Debug, clap::Args)]
#[command(after_long_help = AFTER_HELP)]
pub(crate) struct Args {
    /// The points: any cloud, or a mesh, whose vertices are taken, and points on its triangles where it was thinned out; `-` is
    /// standard input
    #[arg(required_unless_present = "model")]
    points: Option<PathBuf>,
    /// Fit to the model in FILE instead of points: a mesh, NURBS JSON, STEP or IGES; distances are those of sensor points of the surface, orthogonal to the
    /// model
    #[arg(long, value_name = "FILE", conflicts_with_all = ["points", "tolerance", "rational"])]
    model: Option<PathBuf>,
    /// Sensor points in each direction of each cell of the surface, for --model
    #[arg(long, value_name = "N", default_value_t = 4, requires = "model", value_parser = numbers::count)]
    sensors: usize,
    /// The surface: STEP (.step, .stp), IGES (.igs, .iges), else NURBS JSON; `-` is standard output (JSON)
    #[arg(long, short, value_name = "OUT")]
    out: Option<PathBuf>,
    /// Use an even sample of N points of a file that holds more (binary PLY, LAS, LAZ, E57, PTX, plain tables)
    #[arg(long, value_name = "N", default_value_t = sampling::MOST, value_parser = clap::value_parser!(u32).range(100..))]
    sample: u32,
    /// Largest distance of a point that is wanted, in the units of the file
    #[arg(long, value_name = "T", value_parser = numbers::length)]
    tolerance: Option<f64>,
    /// Share of the points that must lie within the tolerance, 0 to 1
    #[arg(long, value_name = "SHARE", default_value_t = 1.0, requires = "tolerance", value_parser = numbers::share)]
    share: f64,
    /// Control points in u and v (to begin with, where there is a tolerance); those of --init, which gets more knots for more; otherwise
    /// 12x12, and without a tolerance more as long as the points, and not their noise, ask for them
    #[arg(long = "control-points", visible_alias = "controls", value_name = "NxM", value_parser = parse_pair)]
    controls: Option<[usize; 2]>,
    /// Most control points, for --tolerance
    #[arg(
        long = "max-control-points",
        visible_alias = "max-controls",
        value_name = "N",
        default_value_t = 10_000,
        value_parser = numbers::count
    )]
    max_controls: usize,
    /// Degrees in u and v
    #[arg(long, value_name = "PxQ", default_value = "3x3", value_parser = parse_pair, conflicts_with = "init")]
    degrees: [usize; 2],
    /// What kind of surface the points are on, and so in which directions it is closed
    #[arg(long, value_enum, default_value_t = ShapeChoice::Auto, conflicts_with = "init")]
    shape: ShapeChoice,
    /// Start from the surface in FILE (NURBS JSON); its knots and closed directions stay
    #[arg(long, value_name = "S.json")]
    init: Option<PathBuf>,
    /// Keep the control points on the open edges of the start
    #[arg(long)]
    fixed_boundary: bool,
    /// Fit within the four curves in FILE (NURBS JSON, STEP or IGES; any order and direction): their Coons patch is the start, and the surface has
    /// exactly this boundary
    #[arg(long, value_name = "CURVES", conflicts_with_all = ["init", "model", "rational", "shape"])]
    boundary: Option<PathBuf>,
    /// Continue the surfaces in FILE across their nearest edges; may be given several times
    #[arg(long, value_name = "SURFACE", conflicts_with_all = ["model", "rational"])]
    join: Vec<PathBuf>,
    /// How surfaces are continued
    #[arg(long, value_enum, requires = "join", default_value_t = ContinuityChoice::G1)]
    continuity: ContinuityChoice,
    /// Let weights be unknowns, too: cylinders, spheres and other quadrics are exact (no boundary is kept then)
    #[arg(long, conflicts_with = "fixed_boundary")]
    rational: bool,
    /// A page (.html): the surface with iso-curves, the points by their distance, zebra stripes, the history
    #[arg(long, value_name = "PAGE.html")]
    report: Option<PathBuf>,
    #[command(flatten)]
    cad: CadArgs,
    #[command(flatten)]
    iteration: LoopArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ShapeChoice {
    /// Decided by the points; the report says why
    Auto,
    /// A height field: open
    Plane,
    /// Closed around an axis (u), open at both ends
    Cylinder,
    /// Closed all around: in u, with a pole at each end of v
    Sphere,
    /// A ring: closed in u and v
    Torus,
}

const AFTER_HELP: &str = "\
The report (--json) holds in `results`: `status`, `rms`, `max`, `max_index`, `lambda`, `history` of all iterations, `base` (plane,
cylinder, sphere or torus: what the first parameters were taken from), `start` (why, and how near the base surface and the least
squares surface were, before the distances were minimised), `control_points`, `share_within` and `within_tolerance` (with a
tolerance), `folds` (cells in which the surface folds back on itself), `coverage` (how near every part of the surface is to the points:
`rms`, `max`, `area_without_data`, in units and in spacings), `trim_loops` (loops in (u, v), in the output, that bound an open surface where the data end, if
their outline is no rectangle), `edges` (with --boundary or --join: how far the surface is from the curves and edges, and the angle between tangent
planes), `points_dropped` (points that are not finite). `max` and `share_within` are
those of all finite points, whether they were used or not.

Exit status 0: the tolerance holds, or, without one, the iteration converged, and every part of the surface is near points; 1: it does not
hold, the iteration did not converge, the boundary curves or neighbours are not met, or the surface folds, does not follow the points, leaves some of them out, has parts farther from
all points than 2.5 times their spacing (3 times noise or tolerance) within its loops, or the points are of no kind that is known (the surface is
written nevertheless); 2: bad input or usage, as points that are not of the kind that was asked for, or not one surface; 130:
interrupted.

Examples:
  indgeo fit-surface scan.ply -o surface.step --tolerance 0.05 --unit mm --name blade-3
  indgeo fit-surface tube.xyz -o tube.json --control-points 30x30 --shape cylinder
  indgeo fit-surface scan.ply -o better.json --init rough.json --outliers automatic
  indgeo fit-surface --model part.stl -o part.json --control-points 5x8
  indgeo fit-surface scan.ply -o surface.json --report surface.html
  indgeo fit-surface scan.ply -o patch.step --boundary curves.step --unit mm
  indgeo fit-surface gap.ply -o blend.step --join left.step --join right.step --continuity g1 --unit mm
  indgeo inspect surface.json scan.ply --tolerance 0.05 --report report.html";

/// Two counts: `30x20` (or `30,20`), or one for both.
pub(super) fn parse_pair(text: &str) -> Result<[usize; 2], String> {
    let parts: Vec<&str> = text.split(['x', 'X', '×', ',']).collect();
    let number = |part: &str| part.trim().parse::<usize>().ok().filter(|n| (1..=10_000).contains(n));
    let pair = match parts[..] {
        [both] => number(both).map(|n| [n, n]),
        [u, v] => number(u).zip(number(v)).map(|(u, v)| [u, v]),
        _ => None,
    };
    pair.ok_or_else(|| "give two counts, as 30x20".to_owned())
}

impl Args {
    /// The files that are read, and those that are written.
    pub(crate) fn files(&self) -> (Vec<&Path>, Vec<PathBuf>) {
        let read = self.points.iter().chain(&self.model).chain(&self.init);
        let read = read.chain(&self.boundary).chain(&self.join).map(PathBuf::as_path);
        (read.collect(), self.out.iter().chain(&self.report).cloned().collect())
    }

    fn options(&self) -> SurfaceOptions {
        let base = match self.shape {
            ShapeChoice::Auto => BaseShape::Auto,
            ShapeChoice::Plane => BaseShape::Plane,
            ShapeChoice::Cylinder => BaseShape::Cylinder,
            ShapeChoice::Sphere => BaseShape::Sphere,
            ShapeChoice::Torus => BaseShape::Torus,
        };
        let defaults = SurfaceOptions::default();
        defaults
            .with_base(base)
            .with_size(NetSize { degrees: self.degrees, controls: self.controls.unwrap_or([12, 12]) })
            .with_abs_tolerance(self.tolerance)
            .with_share(self.share)
            .with_max_controls(self.max_controls)
            .with_fixed_boundary(self.fixed_boundary)
            .with_rational(self.rational)
            .with_fit(self.iteration.applied_to(defaults.fit))
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args, common: &Common, report: &mut Report) -> Result<Outcome, Error> {
    common.something_written(!args.files().1.is_empty(), "-o OUT")?;
    page::check(args.report.as_deref())?;
    args.cad.check(args.out.as_deref())?;
    // One of them is there: the arguments say so.
    let Some(points) = args.points.as_deref().or(args.model.as_deref()) else {
        return Err(Error::usage("there are no points", "give a file of points, or --model FILE"));
    };
    let job = Job {
        points,
        sample: args.sample,
        init: args.init.as_deref(),
        edges: Edges { boundary: args.boundary.as_deref(), join: &args.join, continuity: args.continuity },
        controls: args.controls,
        out: args.out.as_deref(),
        page: args.report.as_deref(),
        cad: &args.cad,
        options: args.options(),
        quiet: common.quiet,
    };
    let verdict = match &args.model {
        Some(_) => to_model::run(&job, args.sensors, report)?,
        None => job::run(&job, report)?,
    };
    Ok(verdict.outcome(report.summary()))
}
