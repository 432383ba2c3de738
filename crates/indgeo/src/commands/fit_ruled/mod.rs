//! `indgeo fit-ruled`: a ruled surface, or layers of them, through a scan.

pub(crate) mod job;
pub(crate) mod summary;

use self::job::Job;
use super::fit_surface::parse_pair;
use super::numbers;
use crate::common::Common;
use crate::error::Error;
use crate::fits::arguments::LoopArgs;
use crate::fits::page;
use crate::output::cad::CadArgs;
use crate::report::{Outcome, Report};
use clap::ValueEnum;
use industrial_geometry::fit::BaseShape;
use industrial_geometry::fit::ruled::{RuledCloudOptions, RuledOptions};
use std::path::{Path, PathBuf};

/// Fit a ruled surface, or layers of ruled surfaces, to a scan or a shape
///
/// Rulings run in v from section to section: two sections are one ruled surface (for milling with the side of a cutter, or cutting by
/// wire), more are layers. With --tolerance sections and control points are added until it holds; --level keeps the sections in
/// parallel planes; --offset gives the surface along which the axis of a cutter runs.
#[derive(Debug, clap::Args)]
#[command(after_long_help = AFTER_HELP)]
pub(crate) struct Args {
    /// A cloud, a mesh, whose vertices are taken, or NURBS surfaces (JSON), on which points are sampled; `-` is standard input
    points: PathBuf,
    /// The surface, of degree 1 in v (NURBS JSON); `-` is standard output
    #[arg(long, short, value_name = "OUT")]
    out: Option<PathBuf>,
    /// Largest distance of a point that is wanted, in the units of the file
    #[arg(long, value_name = "T", value_parser = numbers::length)]
    tolerance: Option<f64>,
    /// Share of the points that must lie within the tolerance, 0 to 1
    #[arg(long, value_name = "SHARE", default_value_t = 1.0, requires = "tolerance", value_parser = numbers::share)]
    share: f64,
    /// Control points on a section, and sections (to begin with, where there is a tolerance)
    #[arg(
        long = "control-points",
        visible_alias = "controls",
        value_name = "NxS",
        value_parser = parse_pair,
        default_value = "16x2",
        conflicts_with = "init"
    )]
    controls: [usize; 2],
    /// Most control points of all sections, for --tolerance
    #[arg(
        long = "max-control-points",
        visible_alias = "max-controls",
        value_name = "N",
        default_value_t = 2000,
        value_parser = numbers::count
    )]
    max_controls: usize,
    /// Degree along the sections
    #[arg(long, value_name = "P", default_value_t = 3, conflicts_with = "init", value_parser = numbers::degree)]
    degree: usize,
    /// Whether sections are open or closed
    #[arg(long, value_enum, default_value_t = ShapeChoice::Auto, conflicts_with = "init")]
    shape: ShapeChoice,
    /// Start from the surface in FILE (NURBS JSON, degree 1 in v); its knots and closed directions stay
    #[arg(long, value_name = "S.json")]
    init: Option<PathBuf>,
    /// Keep sections in parallel planes, across the mean ruling or with the normal that is given (--level=X,Y,Z)
    #[arg(long, value_name = "X,Y,Z", num_args = 0..=1, require_equals = true, default_missing_value = "auto",
          value_parser = parse_level)]
    level: Option<Level>,
    /// Keep the first and the last ruling of an open surface where they are at the start
    #[arg(long)]
    fixed_ends: bool,
    /// Fit the offset at distance R on the side of the normals, negative for the other side; needs normals (a mesh, a cloud with
    /// normals, or NURBS)
    #[arg(long, value_name = "R", value_parser = numbers::signed)]
    offset: Option<f64>,
    /// Penalise twisted rulings: LENGTH counts like an angle of one radian between the normals at the ends of a ruling; begin small
    #[arg(long, value_name = "LENGTH", default_value_t = 0.0, value_parser = numbers::not_negative)]
    developable: f64,
    /// A page (.html): the surface with its rulings, the points by their distance, zebra stripes, the history
    #[arg(long, value_name = "PAGE.html")]
    report: Option<PathBuf>,
    #[command(flatten)]
    cad: CadArgs,
    #[command(flatten)]
    iteration: LoopArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ShapeChoice {
    /// Decided by the points
    Auto,
    /// Open sections
    Plane,
    /// Sections closed around an axis, along which the rulings begin
    Cylinder,
}

/// The normal of the planes of sections.
#[derive(Clone, Copy, Debug)]
struct Level(Option<[f64; 3]>);

fn parse_level(text: &str) -> Result<Level, String> {
    if text == "auto" {
        return Ok(Level(None));
    }
    let normal = numbers::triple(text).filter(|n| n.iter().any(|c| *c != 0.0));
    normal.map(|normal| Level(Some(normal))).ok_or_else(|| "give a direction, as 0,0,1".to_owned())
}

const AFTER_HELP: &str = "\
The report (--json) holds in `results`: `status`, `rms`, `max`, `max_index`, `lambda`, `history` of all iterations, `base` (plane or
cylinder: what the first parameters were taken from), `control_points` (on a section, sections), `developability` (angles in radians
between the normals at the two ends of rulings; 0 for surfaces that unroll into the plane), `folds`, `coverage` (how near every part
of the surface is to the points), `share_within` and
`within_tolerance` (with a tolerance), `runs`, `points_dropped`, and of an offset `gouging` (points at which the cutter would cut into
the shape elsewhere; they are not used).

Exit status 0: the tolerance holds, or, without one, the iteration converged, and every part of the surface is near points; 1: it does not
hold, the iteration did not converge, or the surface folds, does not follow the points, or has parts without data (it is written
nevertheless); 2: bad input or usage; 130: interrupted.

Examples:
  indgeo fit-ruled blade.ply -o flank.json --control-points 20x2
  indgeo fit-ruled vase.xyz -o layers.json --control-points 25x7 --level
  indgeo fit-ruled blade.ply -o flank.json --report flank.html
  indgeo fit-ruled vase.xyz -o layers.step --tolerance 0.1 --level=0,0,1 --unit mm
  indgeo fit-ruled surface.json -o axis.json --control-points 25x7 --offset 5
  indgeo inspect layers.json vase.xyz --tolerance 0.1 --report report.html";

impl Args {
    /// The files that are read, and those that are written.
    pub(crate) fn files(&self) -> (Vec<&Path>, Vec<PathBuf>) {
        let read = std::iter::once(self.points.as_path()).chain(self.init.as_deref());
        (read.collect(), self.out.iter().chain(&self.report).cloned().collect())
    }

    fn options(&self) -> RuledCloudOptions {
        let ruled = RuledOptions::default();
        let ruled = ruled
            .with_section_normal(self.level.and_then(|level| level.0))
            .with_fixed_ends(self.fixed_ends)
            .with_abs_twist(self.developable)
            .with_fit(self.iteration.applied_to(ruled.fit));
        RuledCloudOptions {
            base: match self.shape {
                ShapeChoice::Auto => BaseShape::Auto,
                ShapeChoice::Plane => BaseShape::Plane,
                ShapeChoice::Cylinder => BaseShape::Cylinder,
            },
            degree: self.degree,
            controls: self.controls,
            abs_tolerance: self.tolerance,
            share: self.share,
            max_controls: self.max_controls,
            level: self.level.is_some(),
            ruled,
        }
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args, common: &Common, report: &mut Report) -> Result<Outcome, Error> {
    let job = Job {
        points: &args.points,
        init: args.init.as_deref(),
        out: args.out.as_deref(),
        page: args.report.as_deref(),
        cad: &args.cad,
        offset: args.offset,
        options: args.options(),
        quiet: common.quiet,
    };
    common.something_written(!args.files().1.is_empty(), "-o OUT")?;
    page::check(args.report.as_deref())?;
    args.cad.check(args.out.as_deref())?;
    let verdict = job::run(&job, report)?;
    Ok(verdict.outcome(report.summary()))
}
