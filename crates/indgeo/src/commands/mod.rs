//! The commands, one file each.

pub(crate) mod align;
pub(crate) mod contour;
pub(crate) mod convert;
pub(crate) mod demo;
pub(crate) mod field;
pub(crate) mod fit_curve;
mod fit_loop;
pub(crate) mod fit_ruled;
pub(crate) mod fit_subdivision;
pub(crate) mod fit_surface;
pub(crate) mod geodesic;
pub(crate) mod info;
pub(crate) mod inspect;
pub(crate) mod merge;
pub(crate) mod morphology;
mod numbers;
pub(crate) mod parameterize;
pub(crate) mod project;
pub(crate) mod register;
pub(crate) mod register_views;
pub(crate) mod segment;
pub(crate) mod selftest;

use crate::args::{Command, Common};
use crate::error::Error;
use crate::fit_numbers::FitVerdict;
use crate::paths;
use crate::report::Report;

/// What a command says when it is done.
#[derive(Debug)]
pub(crate) struct Outcome {
    /// For a person to read.
    pub(crate) summary: String,
    /// Whether everything that was asked for was found.
    pub(crate) converged: bool,
    /// What the report calls it if not.
    pub(crate) otherwise: &'static str,
}

impl Outcome {
    /// The usual outcome: points converged, or not.
    pub(crate) fn new(summary: String, converged: bool) -> Self {
        Self { summary, converged, otherwise: "not_converged" }
    }

    /// The outcome of a fit.
    pub(crate) fn fitted(summary: String, verdict: FitVerdict) -> Self {
        Self { summary, converged: verdict == FitVerdict::Good, otherwise: verdict.name() }
    }
}

/// Three finite numbers separated by commas.
fn parse_triple(text: &str) -> Option<[f64; 3]> {
    let parts: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    let triple: [f64; 3] = parts.ok()?.try_into().ok()?;
    triple.iter().all(|value| value.is_finite()).then_some(triple)
}

/// A largest angle in degrees.
fn parse_angle(text: &str) -> Result<f64, String> {
    let angle: Option<f64> = text.trim().parse().ok();
    angle
        .filter(|angle| *angle > 0.0 && *angle <= 180.0)
        .ok_or_else(|| "an angle is a number of degrees above 0, at most 180".to_owned())
}

/// Makes sure that a fit leaves something behind: a file, or the report.
fn something_written(any_file: bool, common: &Common, output: &str) -> Result<(), Error> {
    if any_file || common.json.is_some() {
        return Ok(());
    }
    Err(Error::usage(format!("nothing would be written without {output}"), "add it, or --json FILE"))
}

/// Runs a command and fills in its report.
pub(crate) fn run(command: &Command, common: &Common, report: &mut Report) -> Result<Outcome, Error> {
    paths::check(command)?;
    match command {
        Command::Project(args) => project::run(args, common, report),
        Command::Inspect(args) => inspect::run(args, common, report),
        Command::Merge(args) => merge::run(args, common, report),
        Command::Align(args) => align::run(args, common, report),
        Command::Register(args) => register::run(args, common, report),
        Command::RegisterViews(args) => register_views::run(args, common, report),
        Command::FitCurve(args) => fit_curve::run(args, common, report),
        Command::Parameterize(args) => parameterize::run(args, common, report),
        Command::FitSurface(args) => fit_surface::run(args, common, report),
        Command::FitRuled(args) => fit_ruled::run(args, common, report),
        Command::FitSubdivision(args) => fit_subdivision::run(args, common, report),
        Command::Contour(args) => contour::run(args, common, report),
        Command::Field(args) => field::run(args, common, report),
        Command::Geodesic(args) => geodesic::run(args, common, report),
        Command::Morphology(args) => morphology::run(args, common, report),
        Command::Segment(args) => segment::run(args, common, report),
        Command::Convert(args) => convert::run(args, report),
        Command::Info(args) => info::run(args, common, report),
        Command::Demo(args) => demo::run(args, common, report),
        Command::Selftest(_) => selftest::run(common, report),
    }
}
