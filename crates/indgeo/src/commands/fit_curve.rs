//! `indgeo fit-curve`: a B-spline curve through a cloud.

use super::Outcome;
use crate::args::Common;
use crate::error::Error;
use crate::fitting_curve::{self, Job};
use crate::report::Report;
use crate::summary;
use clap::ValueEnum;
use industrial_geometry::distance_field::{ErrorTerm, Kernel};
use industrial_geometry::fit::curve::CurveOptions;
use industrial_geometry::fit::{FitOptions, Robust, Smoothing, StepControl};
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
    points: PathBuf,
    /// The curve (NURBS JSON)
    #[arg(long, short, value_name = "OUT.json")]
    out: Option<PathBuf>,
    /// Largest distance of a point that is wanted, in the units of the file
    #[arg(long, value_name = "T", conflicts_with = "controls")]
    tolerance: Option<f64>,
    /// Number of control points, repetitions in a closed curve not counted [default: by tolerance or noise]
    #[arg(long, value_name = "N", conflicts_with = "init")]
    controls: Option<usize>,
    /// Most control points
    #[arg(long, value_name = "N", default_value_t = 200)]
    max_controls: usize,
    /// Degree
    #[arg(long, value_name = "P", default_value_t = 3, conflicts_with = "init")]
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
    /// Weights are unknowns, too: circles and other conics become exact
    #[arg(long)]
    rational: bool,
    /// What is minimised in a step
    #[arg(long, alias = "method", value_enum, default_value_t = TermChoice::SquaredDistance)]
    term: TermChoice,
    /// How the length of steps is controlled
    #[arg(long, value_enum, default_value_t = ControlChoice::Armijo)]
    control: ControlChoice,
    /// Factor of the bending energy: auto (asked from the data), continuation (to 0), or the least value (a number)
    #[arg(long, value_name = "LAMBDA", default_value = "auto", value_parser = parse_smoothing)]
    smoothing: Smoothing,
    /// What is assumed about points that do not belong to the curve
    #[arg(long, value_enum, default_value_t = OutlierChoice::None)]
    outliers: OutlierChoice,
    /// Most iterations between changes of the knots
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u16).range(1..))]
    max_iterations: u16,
    /// Write the footpoint of every point (CSV): the point, its foot, distance and parameter
    #[arg(long, value_name = "FILE.csv")]
    points_out: Option<PathBuf>,
    /// Write the history (CSV), one line per iteration: distance, energy factor, step, …
    #[arg(long, value_name = "FILE.csv")]
    report: Option<PathBuf>,
    /// Draw the evolution of the curve (SVG; space curves as seen along z)
    #[arg(long, value_name = "FILE.svg")]
    evolution: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum TermChoice {
    /// Squared distance minimisation
    #[value(alias = "sdm")]
    SquaredDistance,
    /// The same with weights that stay positive on both sides of the curve
    Ratio,
    /// Squared distance to the tangent
    #[value(alias = "tdm")]
    Tangent,
    /// Squared distance to the footpoint: slow
    #[value(alias = "pdm")]
    Point,
    /// Second order Taylor polynomial, which may be indefinite
    Taylor,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ControlChoice {
    /// Steps are shortened until they lower the cost
    Armijo,
    /// Steps are damped until they lower the cost
    LevenbergMarquardt,
    /// Full steps; may diverge
    None,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum OutlierChoice {
    /// There are none: least squares over all points
    None,
    /// Recognised by their distances (Tukey's biweight)
    Automatic,
}

const AFTER_HELP: &str = "\
The report (--json) holds in `results`: status, `closed` and why (`closure`), `start`, `controls`, `degree`, `rms`, `max`,
`max_index`, `share_within` and `reached` (with a tolerance), `crossings` (parameters at which a plane curve crosses itself),
`stages` (the runs of the iteration) and `history` (every iteration of those that were kept).

Exit status 0: done, and the tolerance, if there is one, holds; 1: it does not hold, or the iteration did not converge (files
are written nevertheless); 2: bad input or usage.

Examples:
  indgeo fit-curve section.xyz -o section.json
  indgeo fit-curve section.xyz -o section.json --tolerance 0.05 --points-out deviations.csv
  indgeo fit-curve cloud.xyz -o curve.json --controls 24 --open --evolution evolution.svg
  indgeo fit-curve cloud.xyz --init start.json --term tangent --control none --report history.csv";

/// `auto`, `continuation`, or a number.
fn parse_smoothing(text: &str) -> Result<Smoothing, String> {
    match text {
        "auto" => Ok(Smoothing::default()),
        "continuation" => Ok(Smoothing::CONTINUATION),
        _ => match text.parse::<f64>() {
            Ok(floor) if floor >= 0.0 && floor.is_finite() => {
                Ok(Smoothing::Continuation { start: floor.max(1e-2), factor: 0.5, floor })
            }
            _ => Err("give auto, continuation, or a number of at least 0".to_owned()),
        },
    }
}

impl Args {
    /// The files that are read, and those that are written.
    pub(crate) fn files(&self) -> (Vec<&Path>, Vec<PathBuf>) {
        let read = std::iter::once(self.points.as_path()).chain(self.init.as_deref());
        let written = [&self.out, &self.points_out, &self.report, &self.evolution];
        (read.collect(), written.into_iter().flatten().cloned().collect())
    }

    fn options(&self) -> CurveOptions {
        let term = match self.term {
            TermChoice::SquaredDistance => ErrorTerm::SquaredDistance,
            TermChoice::Ratio => ErrorTerm::SquaredDistanceRatio,
            TermChoice::Tangent => ErrorTerm::Tangent,
            TermChoice::Point => ErrorTerm::Point,
            TermChoice::Taylor => ErrorTerm::Taylor,
        };
        let control = match self.control {
            ControlChoice::Armijo => StepControl::Armijo,
            ControlChoice::LevenbergMarquardt => StepControl::LevenbergMarquardt,
            ControlChoice::None => StepControl::None,
        };
        let robust = match self.outliers {
            OutlierChoice::None => Robust::None,
            OutlierChoice::Automatic => Robust::Kernel { kernel: Kernel::Tukey, abs_scale: None },
        };
        let fit = FitOptions::default()
            .with_term(term)
            .with_control(control)
            .with_robust(robust)
            .with_smoothing(self.smoothing)
            .with_max_iterations(usize::from(self.max_iterations))
            .with_evolution(self.evolution.is_some());
        CurveOptions::default()
            .with_degree(self.degree)
            .with_closed((self.closed || self.open).then_some(self.closed))
            .with_controls(self.controls)
            .with_abs_tolerance(self.tolerance)
            .with_max_controls(self.max_controls)
            .with_rational(self.rational)
            .with_fit(fit)
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args, common: &Common, report: &mut Report) -> Result<Outcome, Error> {
    let (_, written) = args.files();
    if written.is_empty() && common.json.is_none() {
        return Err(Error::usage("nothing would be written", "add -o OUT.json or --json FILE"));
    }
    let job = Job {
        points: &args.points,
        init: args.init.as_deref(),
        out: args.out.as_deref(),
        feet: args.points_out.as_deref(),
        history: args.report.as_deref(),
        evolution: args.evolution.as_deref(),
        options: args.options(),
        quiet: common.quiet,
    };
    let good = fitting_curve::run(&job, report)?;
    let otherwise = if args.tolerance.is_some() { "out_of_tolerance" } else { "not_converged" };
    Ok(Outcome { summary: summary::of(report), converged: good, otherwise })
}
