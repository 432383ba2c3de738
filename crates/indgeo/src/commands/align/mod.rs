//! `indgeo align`: a motion from datum targets or pairs of points.

pub(crate) mod datum_file;
pub(crate) mod job;
pub(crate) mod summary;

use self::job::Job;
use crate::common::Common;
use crate::error::Error;
use crate::report::{Outcome, Report};
use industrial_geometry::io::Format;
use std::path::{Path, PathBuf};

/// Align by datum targets (3-2-1, RPS) or by pairs of points
///
/// Every target is a point that was measured, its nominal place in the model, and the directions along which it shall come to lie
/// there. As many directions as there are degrees of freedom (six) give an exact alignment, more of them one of least squares.
#[derive(Debug, clap::Args)]
#[command(after_long_help = AFTER_HELP)]
pub(crate) struct Args {
    /// The targets, as JSON or as a table with named columns; `-` is standard input
    targets: PathBuf,
    /// Points to be moved by the motion that is found: any cloud, or a mesh with its triangles; `-` is standard input
    #[arg(requires = "out")]
    points: Option<PathBuf>,
    /// The moved points; the format follows from the extension; `-` is standard output (CSV, OBJ for triangles)
    #[arg(long, short, value_name = "MOVED", requires = "points")]
    out: Option<PathBuf>,
    /// Format of MOVED, whatever its extension: ply, xyz, csv, pts, obj, stl, off, pcd, las, laz, e57 or glb
    #[arg(long, value_name = "FORMAT", requires = "out", value_parser = crate::files::parse_format)]
    format: Option<Format>,
    /// Write the motion and the residuals (JSON), as `inspect --transform` and `register --init` take it; `-` is standard output
    #[arg(long, value_name = "T.json")]
    transform: Option<PathBuf>,
    /// Largest residual that is allowed, without sign; with a larger one the exit status is 1
    #[arg(long, short, value_name = "T", value_parser = super::numbers::length)]
    tolerance: Option<f64>,
}

const AFTER_HELP: &str = "\
TARGETS as JSON: {\"targets\": [{\"name\": \"A1\", \"measured\": [x, y, z], \"nominal\": [x, y, z], \"direction\": [0, 0, 1],
\"weight\": 1}, ...]}. Instead of a direction, \"fix\": \"xz\" names axes of the model; without either all three are held, which is a
pair of points. Three targets with the normal of the primary datum plane, two with that of the secondary and one with that of
the tertiary are a 3-2-1 alignment.

TARGETS as a table (CSV, blanks or tabs; decimal commas as elsewhere): columns x, y, z of the measured points, nominal_x, nominal_y, nominal_z, and,
where they are needed, direction_x, direction_y, direction_z or fix, weight and name.

A residual is the distance of a moved point from its nominal place along one direction. No start is needed. Where exact targets
have several solutions, the one that brings the points nearest to their nominal places is taken.
Exit status 0: aligned, and within --tolerance if there is one; 1: not; 2: bad input or usage, such as targets that leave a degree
of freedom open; 130: interrupted.

Examples:
  indgeo align datums.json --transform pose.json
  indgeo align pairs.csv scan.ply -o aligned.ply --tolerance 0.05
  indgeo align datums.json --transform start.json && indgeo register part.stl scan.ply --init start.json -o moved.ply";

impl Args {
    /// The files that are read, and those that are written.
    pub(crate) fn files(&self) -> (Vec<&Path>, Vec<PathBuf>) {
        let read = [Some(&self.targets), self.points.as_ref()];
        let written = [&self.out, &self.transform];
        (
            read.into_iter().flatten().map(PathBuf::as_path).collect(),
            written.into_iter().flatten().cloned().collect(),
        )
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args, common: &Common, report: &mut Report) -> Result<Outcome, Error> {
    let any_file = args.out.is_some() || args.transform.is_some();
    common.something_written(any_file, "--transform T.json or POINTS -o MOVED")?;
    let job = Job {
        targets: &args.targets,
        points: args.points.as_deref().zip(args.out.as_deref()),
        format: args.format,
        transform: args.transform.as_deref(),
        tolerance: args.tolerance,
    };
    let verdict = job::run(&job, report)?;
    Ok(verdict.outcome(report.summary()))
}
