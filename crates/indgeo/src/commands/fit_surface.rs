//! `indgeo fit-surface`: a B-spline surface through a scan.

use super::Outcome;
use crate::args::Common;
use crate::error::Error;
use crate::fitting_surface::{self, Job};
use crate::report::Report;
use crate::summary;
use clap::ValueEnum;
use industrial_geometry::distance_field::{ErrorTerm, Kernel};
use industrial_geometry::fit::{BaseShape, NetSize, Robust, Smoothing, SurfaceOptions};
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
    points: PathBuf,
    /// The surface (NURBS JSON)
    #[arg(long, short, value_name = "OUT.json")]
    out: Option<PathBuf>,
    /// Largest distance of a point that is wanted, in the units of the file
    #[arg(long, value_name = "T")]
    tolerance: Option<f64>,
    /// Share of the points that must lie within the tolerance, 0 to 1
    #[arg(long, value_name = "SHARE", default_value_t = 1.0, requires = "tolerance")]
    share: f64,
    /// Control points in u and v (to begin with, where there is a tolerance); 12x12, or those of --init, which gets more knots for
    /// more
    #[arg(long, value_name = "NxM", value_parser = parse_pair)]
    controls: Option<[usize; 2]>,
    /// Most control points, for --tolerance
    #[arg(long, value_name = "N", default_value_t = 10_000)]
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
    /// Let weights be unknowns, too: cylinders, spheres and other quadrics are exact (no boundary is kept then)
    #[arg(long, conflicts_with = "fixed_boundary")]
    rational: bool,
    /// What is minimised in a step
    #[arg(long, value_enum, default_value_t = MethodChoice::SquaredDistance)]
    method: MethodChoice,
    /// Factor of the thin plate energy; by default the data are asked (cross validation)
    #[arg(long, value_name = "LAMBDA")]
    smoothing: Option<f64>,
    /// What is assumed about points that do not belong to the surface
    #[arg(long, value_enum, default_value_t = OutlierChoice::None)]
    outliers: OutlierChoice,
    /// Most iterations between insertions of knots
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = clap::value_parser!(u16).range(1..))]
    max_iterations: u16,
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

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MethodChoice {
    /// Squared distance minimisation (SDM)
    SquaredDistance,
    /// Squared distance to the tangent plane (TDM)
    Tangent,
    /// Squared distance to the footpoint (PDM): slow
    Point,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum OutlierChoice {
    /// There are none: least squares over all points
    None,
    /// Recognised by their distances (Tukey's biweight)
    Automatic,
}

const AFTER_HELP: &str = "\
The report (--json) holds in `results`: `fit` (status, rms, max, lambda, history of all iterations), `base` (plane, cylinder,
sphere or torus: what the first parameters were taken from), `start` (why, and how near the base surface and the least squares
surface were, before the distances were minimised), `controls`, `share_within`, `within_tolerance`, `folds` (cells
in which the surface folds back on itself), `dropped` (points that are not finite).

Exit status 0: done, and the tolerance, if there is one, holds; 1: the tolerance does not hold, or the iteration failed (the
surface is written nevertheless); 2: bad input or usage.

Examples:
  indgeo fit-surface scan.ply -o surface.json --tolerance 0.05
  indgeo fit-surface tube.xyz -o tube.json --controls 30x30 --shape cylinder
  indgeo fit-surface scan.ply -o better.json --init rough.json --outliers automatic
  indgeo inspect surface.json scan.ply --tolerance 0.05 --report report.html";

/// Two counts: `30x20`, or one for both.
fn parse_pair(text: &str) -> Result<[usize; 2], String> {
    let parts: Vec<&str> = text.split(['x', 'X', '×']).collect();
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
        let read = std::iter::once(self.points.as_path()).chain(self.init.as_deref());
        (read.collect(), self.out.iter().cloned().collect())
    }

    fn options(&self) -> SurfaceOptions {
        let base = match self.shape {
            ShapeChoice::Auto => BaseShape::Auto,
            ShapeChoice::Plane => BaseShape::Plane,
            ShapeChoice::Cylinder => BaseShape::Cylinder,
            ShapeChoice::Sphere => BaseShape::Sphere,
            ShapeChoice::Torus => BaseShape::Torus,
        };
        let term = match self.method {
            MethodChoice::SquaredDistance => ErrorTerm::SquaredDistance,
            MethodChoice::Tangent => ErrorTerm::Tangent,
            MethodChoice::Point => ErrorTerm::Point,
        };
        let robust = match self.outliers {
            OutlierChoice::None => Robust::None,
            OutlierChoice::Automatic => Robust::Kernel { kernel: Kernel::Tukey, abs_scale: None },
        };
        let defaults = SurfaceOptions::default();
        let mut fit = defaults.fit.with_term(term).with_robust(robust);
        fit = fit.with_max_iterations(usize::from(self.max_iterations));
        if let Some(lambda) = self.smoothing {
            fit = fit.with_smoothing(Smoothing::Continuation { start: 1e-2, factor: 0.5, floor: lambda });
        }
        defaults
            .with_base(base)
            .with_size(NetSize { degrees: self.degrees, controls: self.controls.unwrap_or([12, 12]) })
            .with_abs_tolerance(self.tolerance)
            .with_share(self.share)
            .with_max_controls(self.max_controls)
            .with_fixed_boundary(self.fixed_boundary)
            .with_rational(self.rational)
            .with_fit(fit)
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args, common: &Common, report: &mut Report) -> Result<Outcome, Error> {
    if args.out.is_none() && common.json.is_none() {
        return Err(Error::usage("nothing would be written", "add -o OUT.json or --json FILE"));
    }
    let job = Job {
        points: &args.points,
        init: args.init.as_deref(),
        controls: args.controls,
        out: args.out.as_deref(),
        options: args.options(),
        quiet: common.quiet,
    };
    let good = fitting_surface::run(&job, report)?;
    let otherwise = if args.tolerance.is_some() { "out_of_tolerance" } else { "not_converged" };
    Ok(Outcome { summary: summary::of(report), converged: good, otherwise })
}
