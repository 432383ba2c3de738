//! `indgeo fit-subdivision`: a Loop subdivision surface through a mesh or a scan.

pub(crate) mod job;
pub(crate) mod summary;

use self::job::Job;
use super::numbers;
use crate::common::Common;
use crate::error::Error;
use crate::fits::arguments::LoopArgs;
use crate::fits::page;
use crate::report::{Outcome, Report};
use industrial_geometry::fit::subdivision::subdivision_options;
use industrial_geometry::io::Format;
use std::path::{Path, PathBuf};

/// Fit a Loop subdivision surface to a mesh or a scan
///
/// The control mesh is the input coarsened to --vertices, or a mesh of your own (--init), which a cloud without triangles needs. It
/// keeps its triangles; its vertices move until the limit surface is as near to the points as it can be. Any topology will do,
/// with or without boundaries.
#[derive(Debug, clap::Args)]
#[command(after_long_help = AFTER_HELP)]
pub(crate) struct Args {
    /// A mesh, whose vertices are fitted, the signed distances of a body on a grid (.vti), or a cloud together with --init; `-` is standard
    /// input
    points: PathBuf,
    /// The control mesh: .obj, .ply, .off or .stl; `-` is standard output (OBJ)
    #[arg(long, short, value_name = "OUT")]
    out: Option<PathBuf>,
    /// Format of the meshes that are written, whatever their extension: obj, ply, off or stl
    #[arg(long, value_name = "FORMAT", value_parser = parse_format)]
    format: Option<Format>,
    /// The limit surface as a mesh: the control mesh subdivided --levels times, its vertices moved to their limits
    #[arg(long, value_name = "FILE")]
    limit: Option<PathBuf>,
    /// How many times the mesh of --limit is subdivided
    #[arg(long, value_name = "N", default_value_t = 2, requires = "limit", value_parser = clap::value_parser!(u8).range(0..=6))]
    levels: u8,
    /// Vertices of the control mesh that the input is coarsened to [default: a tenth, at most 1000]
    #[arg(long, value_name = "N", conflicts_with = "init", value_parser = parse_count)]
    vertices: Option<usize>,
    /// Start from the control mesh in FILE
    #[arg(long, value_name = "MESH")]
    init: Option<PathBuf>,
    /// Largest distance of a point that is wanted, in the units of the file
    #[arg(long, value_name = "T", value_parser = numbers::length)]
    tolerance: Option<f64>,
    /// A page (.html): the limit surface, the points by their distance, zebra stripes, the history
    #[arg(long, value_name = "PAGE.html")]
    report: Option<PathBuf>,
    #[command(flatten)]
    iteration: LoopArgs,
}

fn parse_count(text: &str) -> Result<usize, String> {
    let count = text.parse().ok().filter(|count| (4..=1_000_000).contains(count));
    count.ok_or_else(|| "give a number of vertices from 4 to 1000000".to_owned())
}

fn parse_format(text: &str) -> Result<Format, String> {
    let keeps_triangles =
        |format: &Format| matches!(format, Format::Obj | Format::Ply | Format::Off | Format::Stl);
    Format::from_extension(text)
        .filter(keeps_triangles)
        .ok_or_else(|| "choose obj, ply, off or stl".to_owned())
}

const AFTER_HELP: &str = "\
The report (--json) holds in `results`: `status`, `rms`, `max`, `max_index`, `lambda`, `history` of all iterations, `vertices` and
`triangles` of the control mesh, `irregular` (its inner vertices without six neighbours), `start` (`coarsened` or `given`),
`folded_edges` (at which the normals of triangles differ by more than 150 degrees, of the control mesh and the limit surface) and
`folded_edges_of_input`, `coverage` (how near every part of the surface is to the points), `share_within` and `within_tolerance` (with a
tolerance), `points_dropped`.

Exit status 0: the tolerance holds, or, without one, the iteration converged, and every part of the surface is near points; 1: it does not
hold, the iteration did not converge, the limit surface has more folded edges than the input, or parts without data (files are written
nevertheless); 2: bad input or usage; 130: interrupted.

Examples:
  indgeo fit-subdivision scan.ply -o control.obj --vertices 300
  indgeo fit-subdivision scan.ply -o control.obj --limit smooth.ply --levels 3
  indgeo fit-subdivision scan.ply -o control.obj --report control.html
  indgeo fit-subdivision cloud.xyz --init box.obj -o control.obj --tolerance 0.1";

impl Args {
    /// The files that are read, and those that are written.
    pub(crate) fn files(&self) -> (Vec<&Path>, Vec<PathBuf>) {
        let read = std::iter::once(self.points.as_path()).chain(self.init.as_deref());
        (read.collect(), [&self.out, &self.limit, &self.report].into_iter().flatten().cloned().collect())
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args, common: &Common, report: &mut Report) -> Result<Outcome, Error> {
    let job = Job {
        points: &args.points,
        init: args.init.as_deref(),
        out: args.out.as_deref(),
        page: args.report.as_deref(),
        format: args.format,
        limit: args.limit.as_deref().map(|path| (path, args.levels)),
        vertices: args.vertices,
        tolerance: args.tolerance,
        options: args.iteration.applied_to(subdivision_options()),
        quiet: common.quiet,
    };
    common.something_written(!args.files().1.is_empty(), "-o OUT.obj")?;
    page::check(args.report.as_deref())?;
    let verdict = job::run(&job, report)?;
    Ok(verdict.outcome(report.summary()))
}
