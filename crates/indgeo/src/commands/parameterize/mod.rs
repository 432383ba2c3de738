//! `indgeo parameterize`: parameters and a base surface for a cloud of which nothing is known.

pub(crate) mod job;
pub(crate) mod patch;
pub(crate) mod summary;
pub(crate) mod within;

use self::job::Job;
use self::patch::DomainChoice;
use super::fit_surface::parse_pair;
use crate::common::Common;
use crate::error::Error;
use crate::fits::numbers::FitVerdict;
use crate::on_surface::MetricChoice;

use crate::output::Format;
use crate::report::{Outcome, Report};
use clap::ValueEnum;
use industrial_geometry::cloud_param::{
    DirectedWeight, FitOptions, ParameteriseOptions, RefineOptions, Shape,
};
use std::path::{Path, PathBuf};

/// Find a base surface and parameters for POINTS, or parameters of a patch of a mesh
///
/// No boundary curves, no order and no first guess are needed. A scan all around an axis is looked at from several sides as on a
/// turntable; closed curves in layers across the axis give a surface that follows the points, and the closest points on it give
/// the parameters. Scans of one side and of bodies closed all around get surfaces of their own.
///
/// With --metric the triangles of a mesh with one boundary are laid over a square or a disc, so that none folds; in the feature sensitive
/// metric parameter lines crowd at edges and fillets.
#[derive(Debug, clap::Args)]
#[command(after_long_help = AFTER_HELP)]
pub(crate) struct Args {
    /// The points: any cloud, or the vertices of a mesh, and points on its triangles where it was thinned out; `-` is standard input
    points: PathBuf,
    /// The base surface (NURBS JSON), periodic in u where it is closed; `-` is standard output
    #[arg(long, short, value_name = "BASE.json")]
    out: Option<PathBuf>,
    /// The parameters: x, y, z, u, v, distance, used, status, one row per point; .csv, .ply, .json, .las, .laz, .e57 or .glb
    #[arg(long, value_name = "UV.csv")]
    params: Option<PathBuf>,
    /// Format of UV, whatever its extension; on standard output (`-`) CSV
    #[arg(long, value_enum, requires = "params")]
    format: Option<Format>,
    /// A surface fitted with these parameters (NURBS JSON): least squares, finished by squared distance minimisation
    #[arg(long, value_name = "FITTED.json")]
    fit: Option<PathBuf>,
    /// Control points of the fitted surface around and along [default: 30x30]
    #[arg(long, value_name = "NxM", value_parser = parse_net, requires = "fit")]
    control_points: Option<[usize; 2]>,
    /// How many times the parameters of the fit are corrected by projection onto the fitted surface [default: 2]
    #[arg(long, value_name = "N", requires = "fit")]
    corrections: Option<u8>,
    /// Leave the least squares surface as it is, without the finish
    #[arg(long, requires = "fit")]
    no_finish: bool,
    /// What kind of surface the points are on
    #[arg(long, value_enum, default_value_t = ShapeChoice::Auto)]
    shape: ShapeChoice,
    /// Direction of the axis [default: found from the points]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = parse_direction)]
    axis: Option<[f64; 3]>,
    /// Number of views around the axis [default: as many as show all of the points, at least 4]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(3..=60))]
    views: Option<u8>,
    /// Samples of the base surface around and along the axis [default: as dense as the points allow]
    #[arg(long, value_name = "NxM", value_parser = parse_net)]
    grid: Option<[usize; 2]>,
    /// Which points count when samples are drawn to the points
    #[arg(long, value_enum, default_value_t = WeightChoice::NearAxis)]
    weight: WeightChoice,
    /// Within the four curves in FILE (NURBS JSON, STEP or IGES; any order and direction): the dynamic base surface from their Coons patch, whose
    /// boundary is exactly these curves
    #[arg(long, value_name = "CURVES", conflicts_with_all = ["fit", "axis", "views", "shape", "metric"])]
    boundary: Option<PathBuf>,
    /// Lay the triangles of a mesh with one boundary over a domain, with lengths measured so
    #[arg(long, value_enum, conflicts_with_all = OF_CLOUDS)]
    metric: Option<MetricChoice>,
    /// Width of the feature sensitive metric, a length: fillets with a smaller radius count as features
    #[arg(long, value_name = "W", requires = "metric")]
    w: Option<f64>,
    /// Where the boundary of the patch goes
    #[arg(long, value_enum, requires = "metric", default_value_t = DomainChoice::Square)]
    domain: DomainChoice,
    /// Vertices (from 0) of the boundary that become the corners of the square, the first (0, 0) [default: the sharpest]
    #[arg(long, value_name = "A,B,C,D", requires = "metric", value_parser = parse_corners)]
    corners: Option<[usize; 4]>,
    /// Draw the patch with its parameter lines, and the mesh over the domain (SVG or PNG)
    #[arg(long, value_name = "P.svg|P.png", requires = "metric")]
    picture: Option<PathBuf>,
}

/// What makes a surface of a cloud, and means nothing for the triangles of a patch.
const OF_CLOUDS: [&str; 11] = [
    "out",
    "format",
    "fit",
    "control_points",
    "corrections",
    "no_finish",
    "axis",
    "views",
    "grid",
    "shape",
    "weight",
];

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ShapeChoice {
    /// Decided by the points; the report says why
    Auto,
    /// Closed around an axis, open at both ends
    Cylinder,
    /// A height field
    Plane,
    /// Closed all around
    Sphere,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum WeightChoice {
    /// Near ones
    Near,
    /// Those near the line of projection
    Axis,
    /// Both
    NearAxis,
}

const AFTER_HELP: &str = "\
The report (--json) says what kind of surface was found and why, the axis, the number of views, the distances at every step, self-loops
and crossovers, the share of the points with one closest point only, and the time of each stage; of a fitted surface the distances and
folds after least squares and after the finish. A finish that would fold, or come no nearer to the points, is not taken, and the
report says so.

With --metric the parameters of every vertex go to UV.csv (vertex,x,y,z,u,v; vertices from 0 in the order of the file; in the feature sensitive
metric a vertex of a sharp edge has a row for each side of it) or UV.ply (the mesh with the scalars u and v). They are in [0, 1], the boundary
runs around the domain with the surface on its left. Exit status 1: triangles without positive area over the domain.

Exit status 0: the surfaces follow the points and have no folds; 1: one folds, the base surface lies over large holes, points are left
out that the fitted surface (without one, the base surface) does not meet, or parts of the fitted surface are without data (files are
written nevertheless); 2: bad input or usage, as points that do not go around the axis; 130: interrupted. The
finish is a limited number of iterations; a warning says when it would go on.

Examples:
  indgeo parameterize scan.ply -o base.json --params uv.csv
  indgeo parameterize scan.ply -o base.json --shape cylinder --axis 0,0,1 --json report.json
  indgeo parameterize scan.ply --fit surface.json --control-points 55x55
  indgeo parameterize scan.ply --boundary curves.json -o base.json --params uv.csv
  indgeo parameterize patch.ply --metric feature --w 0.5 --params uv.csv --picture lines.svg";

fn parse_corners(text: &str) -> Result<[usize; 4], String> {
    let numbers: Option<Vec<usize>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    numbers
        .and_then(|numbers| <[usize; 4]>::try_from(numbers).ok())
        .ok_or_else(|| "corners are four vertices (from 0): A,B,C,D".to_owned())
}

fn parse_direction(text: &str) -> Result<[f64; 3], String> {
    super::numbers::triple(text)
        .filter(|d| d.iter().any(|c| *c != 0.0))
        .ok_or_else(|| "a direction is three numbers, not all zero: X,Y,Z".to_owned())
}

/// The numbers of rows and columns of a net.
fn parse_net(text: &str) -> Result<[usize; 2], String> {
    parse_pair(text)
        .ok()
        .filter(|pair| pair.iter().all(|n| (4..=2000).contains(n)))
        .ok_or_else(|| "give two counts from 4 to 2000, as 30x20".to_owned())
}

impl Args {
    /// The files that are read, and those that are written.
    pub(crate) fn files(&self) -> (Vec<&Path>, Vec<PathBuf>) {
        let written = [&self.out, &self.params, &self.fit, &self.picture];
        let read = std::iter::once(self.points.as_path()).chain(self.boundary.as_deref());
        (read.collect(), written.into_iter().flatten().cloned().collect())
    }

    fn options(&self) -> ParameteriseOptions {
        let mut options = ParameteriseOptions::default()
            .with_shape(match self.shape {
                ShapeChoice::Auto => Shape::Auto,
                ShapeChoice::Cylinder => Shape::Cylinder,
                ShapeChoice::Plane => Shape::Plane,
                ShapeChoice::Sphere => Shape::Sphere,
            })
            .with_weight(match self.weight {
                WeightChoice::Near => DirectedWeight::Near,
                WeightChoice::Axis => DirectedWeight::Axis,
                WeightChoice::NearAxis => DirectedWeight::NearAxis,
            });
        if let Some(axis) = self.axis {
            options = options.with_axis(axis.into());
        }
        if let Some(views) = self.views {
            options = options.with_views(usize::from(views));
        }
        if let Some([around, along]) = self.grid {
            options = options.with_grid(around, along);
        }
        options
    }
}

/// Lays the triangles of a patch over a domain.
fn of_patch(
    args: &Args,
    choice: MetricChoice,
    common: &Common,
    report: &mut Report,
) -> Result<Outcome, Error> {
    common.something_written(args.params.is_some() || args.picture.is_some(), "--params UV.csv")?;
    if args.domain == DomainChoice::Disc && args.corners.is_some() {
        return Err(Error::usage("a disc has no corners", "leave out --corners or --domain disc"));
    }
    let job = patch::Job {
        mesh: &args.points,
        choice,
        metric: choice.metric(args.w)?,
        domain: args.domain,
        corners: args.corners,
        out: args.params.as_deref(),
        picture: args.picture.as_deref(),
    };
    let is_valid = patch::run(&job, report)?;
    let verdict = if is_valid { FitVerdict::Good } else { FitVerdict::Defective };
    Ok(verdict.outcome(report.summary()))
}

/// Runs the command.
pub(crate) fn run(args: &Args, common: &Common, report: &mut Report) -> Result<Outcome, Error> {
    if let Some(choice) = args.metric {
        return of_patch(args, choice, common, report);
    }
    let (_, written) = args.files();
    if written.is_empty() && common.json.is_none() {
        return Err(Error::usage(
            "nothing would be written",
            "add -o BASE.json, --params UV.csv, --fit FITTED.json or --json FILE",
        ));
    }
    if let Some(boundary) = &args.boundary {
        let options = args.options();
        let job = within::Job {
            points: &args.points,
            boundary,
            base: args.out.as_deref(),
            params: args.params.as_deref(),
            format: args.format,
            grid: args.grid,
            options: RefineOptions { directed: options.refine.directed, ..RefineOptions::default() },
        };
        let verdict = within::run(&job, report)?;
        return Ok(verdict.outcome(report.summary()));
    }
    let mut fit = FitOptions::default();
    fit.control_points = args.control_points.unwrap_or(fit.control_points);
    fit.corrections = args.corrections.map_or(fit.corrections, usize::from);
    let job = Job {
        points: &args.points,
        base: args.out.as_deref(),
        params: args.params.as_deref(),
        format: args.format,
        fitted: args.fit.as_deref(),
        options: args.options(),
        fit,
        finish: !args.no_finish,
        quiet: common.quiet,
    };
    let verdict = job::run(&job, report)?;
    Ok(verdict.outcome(report.summary()))
}
