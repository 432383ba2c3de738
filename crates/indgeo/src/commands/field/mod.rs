//! `indgeo field`: the distance of a shape at the nodes of a grid.

pub(crate) mod job;
pub(crate) mod summary;

use self::job::{Job, Method};
use crate::common::Common;
use crate::error::Error;
use crate::report::{Outcome, Report};
use std::path::{Path, PathBuf};

/// Distances from SHAPE at the nodes of a regular grid
///
/// SHAPE is a cloud, curves or surfaces (NURBS), a mesh, an image (PNG, PGM: its contours at the level of Otsu, in pixels, y upwards, as
/// `indgeo contour` finds them), or a scene: a source among polygonal obstacles in the plane, whose distances
/// are the lengths of the shortest ways around them.
#[derive(Debug, clap::Args)]
#[command(after_long_help = AFTER_HELP)]
pub(crate) struct Args {
    /// The shape, or a scene (JSON); `-` is standard input
    shape: PathBuf,
    /// The distances: .npy or .vti; `-` is standard output (NPY)
    #[arg(long, short, value_name = "OUT")]
    out: Option<PathBuf>,
    /// Nodes along each axis, as 257x257 or 129x129x129 [default: 257 along the longer side in the plane, 65 in space]
    #[arg(long, value_name = "NxM[xK]", value_parser = parse_grid)]
    grid: Option<Counts>,
    /// The box of the grid, its ends being nodes: low end, then high end [default: the shape with a tenth of its size around it, or
    /// the domain of the scene]
    #[arg(long = "box", value_name = "x0,y0[,z0],x1,y1[,z1]", allow_hyphen_values = true, value_parser = parse_box)]
    bounds: Option<Bounds>,
    /// How distances are found
    #[arg(long, value_enum, default_value_t = Method::Exact)]
    method: Method,
    /// Distances inside are negative: of closed curves in the plane, of meshes (with holes too), of surfaces behind their normals
    #[arg(long)]
    signed: bool,
    /// Find the shortest ways from the source of a scene to one or several places x,y (with a minus: --path=-1,2)
    #[arg(long, value_name = "x,y", num_args = 1.., value_parser = parse_target)]
    path: Vec<[f64; 2]>,
    /// Draw the field (SVG or PNG): colours, isolines, obstacles and ways; of a field in space its middle section
    #[arg(long, value_name = "P.svg|P.png")]
    picture: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
NPY: doubles of shape (N, M[, K]); [i][j][k] is the node i along x, j along y, k along z. VTI: image data for ParaView and others.

exact   every node for itself: certified for curves and surfaces, exact for points and meshes; in a scene the exact shortest way
zhao    fast sweeping, error of first order in the spacing
tsai    nearest points carried from node to node: exact but for few nodes; not around obstacles
fmm     fast marching, first order; fmm2: second order
All but exact begin with exact distances next to the shape. What tsai carries are points, segments and triangles: chords within a thousandth
of a cell of curves, and within a hundredth of surfaces (`chord` of the report).

With --signed the inside of a mesh does not depend on the side of its triangles: flipped ones are turned as their neighbours are, overlapping
bodies are one, and holes are closed by the generalised winding number, which a warning says. A sheet, or a shell that is more open than
closed, surrounds nothing and is refused.

A scene: {\"domain\": [0, 1], \"source\": [x, y], \"polys\": [[[x, y], ...], ...], \"targets\": [[x, y], ...]}. Nodes inside of an obstacle
get -1 (its boundary is free), nodes that cannot be reached are infinite. Ways lead to the targets and to each --path, exact
whatever the method.

Exit status 0: done; 1: a distance is not proven, or no way leads to a target; 2: bad input or usage; 130: interrupted.

Examples:
  indgeo field part.stl -o distance.vti --grid 129x129x129 --signed
  indgeo field outline.json -o distance.npy --grid 512x512 --box 0,0,1,1 --picture distance.svg
  indgeo field coins.png -o distance.npy --grid 257x257 --signed
  indgeo field scene.json -o distance.npy --grid 257x257 --path 0.9,0.9 --picture scene.svg --json -";

/// Numbers of nodes.
#[derive(Clone, Debug)]
pub(crate) struct Counts(Vec<usize>);

/// The ends of a box.
#[derive(Clone, Debug)]
pub(crate) struct Bounds(pub(crate) Vec<f64>);

fn parse_grid(text: &str) -> Result<Counts, String> {
    let counts: Option<Vec<usize>> =
        text.split(['x', 'X', '×', ',']).map(|part| part.trim().parse().ok().filter(|n| *n >= 2)).collect();
    let counts = counts.filter(|counts| (2..=3).contains(&counts.len()));
    counts.map(Counts).ok_or_else(|| "give two or three counts of at least 2, as 257x257".to_owned())
}

fn numbers(text: &str) -> Option<Vec<f64>> {
    text.split(',').map(|part| part.trim().parse().ok().filter(|number: &f64| number.is_finite())).collect()
}

pub(super) fn parse_box(text: &str) -> Result<Bounds, String> {
    let bounds = numbers(text).filter(|bounds| matches!(bounds.len(), 4 | 6));
    bounds.map(Bounds).ok_or_else(|| "give four or six finite numbers: x0,y0[,z0],x1,y1[,z1]".to_owned())
}

fn parse_target(text: &str) -> Result<[f64; 2], String> {
    numbers(text)
        .and_then(|target| target.try_into().ok())
        .ok_or_else(|| "a target is two numbers: x,y".to_owned())
}

impl Args {
    /// The files that are read, and those that are written.
    pub(crate) fn files(&self) -> (Vec<&Path>, Vec<PathBuf>) {
        let written = [&self.out, &self.picture];
        (vec![&self.shape], written.into_iter().flatten().cloned().collect())
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args, common: &Common, report: &mut Report) -> Result<Outcome, Error> {
    common.something_written(args.out.is_some() || args.picture.is_some(), "-o OUT or --picture P.svg")?;
    let job = Job {
        shape: &args.shape,
        out: args.out.as_deref(),
        grid: args.grid.as_ref().map(|counts| counts.0.as_slice()),
        bounds: args.bounds.as_ref().map(|bounds| bounds.0.as_slice()),
        method: args.method,
        signed: args.signed,
        targets: &args.path,
        picture: args.picture.as_deref(),
        quiet: common.quiet,
    };
    let is_done = job::run(&job, report)?;
    Ok(Outcome { summary: report.summary(), converged: is_done, otherwise: "not_proven" })
}
