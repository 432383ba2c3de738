//! Command-line arguments.

use crate::commands::{
    align, contour, convert, demo, field, fit_curve, fit_ruled, fit_subdivision, fit_surface, geodesic, info,
    inspect, merge, morphology, parameterize, project, register, register_views, segment, selftest,
};
use crate::common::{Common, with_negative_numbers};
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use std::path::{Path, PathBuf};

/// From scans to CAD: deviations from NURBS models and meshes, with a proof that no other point is nearer.
#[derive(Debug, Parser)]
#[command(version, propagate_version = true, max_term_width = 110, after_help = AFTER_HELP)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
    #[command(flatten)]
    pub(crate) common: Common,
}

const AFTER_HELP: &str = "\
Exit status, the same for every command:
  0    done, and what was asked for holds
  1    done, but the answer is \"no\", or it is not proven, or an iteration did not converge; files are written nevertheless
  2    bad input or usage; nothing is written but the report
  130  interrupted (SIGINT, SIGTERM, SIGHUP); nothing half-written stays, and the report (--json) says \"cancelled\"

An output called `-` is standard output; then nothing else is printed there. An input called `-` is standard input.
Units are those of the files. Formats are recognised by content first, by extension second.

Examples:
  indgeo demo
  indgeo project model.json scan.ply -o deviations.csv
  indgeo inspect model.json scan.ply --tolerance 0.05 --report report.html
  indgeo merge partials/*.json --report report.html
  indgeo align datums.json scan.ply -o aligned.ply
  indgeo register part.stl scan.ply -o moved.ply --transform pose.json
  indgeo register-views scan1.ply scan2.ply scan3.ply -o aligned
  indgeo fit-curve section.xyz -o section.json --tolerance 0.05
  indgeo parameterize scan.ply -o base.json --params uv.csv
  indgeo fit-surface scan.ply -o surface.json --tolerance 0.05
  indgeo fit-ruled vase.xyz -o layers.json --control-points 25x7 --level
  indgeo fit-subdivision scan.ply -o control.obj --vertices 300
  indgeo contour coins.png -o coins.json --picture coins.svg
  indgeo field part.stl -o distance.vti --signed
  indgeo geodesic part.stl --from 0 -o distance.csv
  indgeo segment scan.ply -o labels.ply
  indgeo info scan.ply";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Project(project::Args),
    Inspect(inspect::Args),
    Merge(merge::Args),
    Align(align::Args),
    Register(register::Args),
    RegisterViews(register_views::Args),
    FitCurve(fit_curve::Args),
    Parameterize(parameterize::Args),
    FitSurface(fit_surface::Args),
    FitRuled(fit_ruled::Args),
    FitSubdivision(fit_subdivision::Args),
    Contour(contour::Args),
    Field(field::Args),
    Geodesic(geodesic::Args),
    Morphology(morphology::Args),
    Segment(segment::Args),
    Convert(convert::Args),
    Info(info::Args),
    Demo(demo::Args),
    Selftest(selftest::Args),
}

impl Cli {
    /// What was typed; ends the program with a message, or with the help.
    pub(crate) fn of_command_line() -> Self {
        let matches = Self::typed().get_matches();
        Self::from_arg_matches(&matches).unwrap_or_else(|error| error.exit())
    }

    /// What these arguments say, without the name of the program.
    pub(crate) fn of_arguments(arguments: &[String]) -> Result<Self, clap::Error> {
        let all = std::iter::once("indgeo").chain(arguments.iter().map(String::as_str));
        Self::from_arg_matches(&Self::typed().try_get_matches_from(all)?)
    }

    /// The parser of the command line, in which `-0.1` after an option is its value: what is wrong with it is then said.
    fn typed() -> clap::Command {
        Self::command().mut_subcommands(with_negative_numbers)
    }
}

impl Command {
    /// The files that the command line says are read, and those it says are written.
    pub(crate) fn files(&self) -> (Vec<&Path>, Vec<PathBuf>) {
        match self {
            Self::Project(args) => (vec![&args.model, &args.points], vec![args.out.clone()]),
            Self::Inspect(args) => args.files(),
            Self::Merge(args) => args.files(),
            Self::Align(args) => args.files(),
            Self::Register(args) => args.files(),
            Self::RegisterViews(args) => args.files(),
            Self::FitCurve(args) => args.files(),
            Self::Parameterize(args) => args.files(),
            Self::FitSurface(args) => args.files(),
            Self::FitRuled(args) => args.files(),
            Self::FitSubdivision(args) => args.files(),
            Self::Contour(args) => args.files(),
            Self::Field(args) => args.files(),
            Self::Geodesic(args) => args.files(),
            Self::Morphology(args) => args.files(),
            Self::Segment(args) => args.files(),
            Self::Convert(args) => (vec![&args.input], vec![args.output.clone()]),
            Self::Info(args) => (args.files.iter().map(PathBuf::as_path).collect(), Vec::new()),
            Self::Demo(args) => (Vec::new(), args.results()),
            Self::Selftest(_) => (Vec::new(), Vec::new()),
        }
    }

    /// The name that was typed, as the report repeats it.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Self::Project(_) => "project",
            Self::Inspect(_) => "inspect",
            Self::Merge(_) => "merge",
            Self::Align(_) => "align",
            Self::Register(_) => "register",
            Self::RegisterViews(_) => "register-views",
            Self::FitCurve(_) => "fit-curve",
            Self::Parameterize(_) => "parameterize",
            Self::FitSurface(_) => "fit-surface",
            Self::FitRuled(_) => "fit-ruled",
            Self::FitSubdivision(_) => "fit-subdivision",
            Self::Contour(_) => "contour",
            Self::Field(_) => "field",
            Self::Geodesic(_) => "geodesic",
            Self::Morphology(_) => "morphology",
            Self::Segment(_) => "segment",
            Self::Convert(_) => "convert",
            Self::Info(_) => "info",
            Self::Demo(_) => "demo",
            Self::Selftest(_) => "selftest",
        }
    }
}
