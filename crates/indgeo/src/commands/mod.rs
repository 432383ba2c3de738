//! The commands, one folder each.

pub(crate) mod align;
pub(crate) mod contour;
pub(crate) mod convert;
pub(crate) mod demo;
pub(crate) mod field;
pub(crate) mod fit_curve;
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

use crate::args::Command;
use crate::common::Common;
use crate::error::Error;
use crate::paths;
use crate::report::{Outcome, Report};

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
