//! `indgeo contour`: the contours of images and volumes as B-splines and meshes.

pub(crate) mod job;
pub(crate) mod summary;

use self::job::{Job, Method, Region, Topology};
use super::numbers;
use crate::common::Common;
use crate::error::Error;
use crate::output::cad::CadArgs;
use crate::report::{Outcome, Report};
use std::path::{Path, PathBuf};

/// Contours of an image as B-spline curves, or of a volume as a mesh or a B-spline surface
///
/// INPUT is an image (PNG, PGM) or a grid (NPY, VTI as `indgeo field` writes them) of two or three axes. Each contour becomes one
/// curve, with holes and components in one model; each is measured against the level set in both directions.
#[derive(Debug, clap::Args)]
#[command(after_long_help = AFTER_HELP)]
pub(crate) struct Args {
    /// Image or grid; `-` is standard input
    input: PathBuf,
    /// The curves: .json (NURBS), .svg, .dxf, .step or .igs; of a volume the mesh: .stl, .ply, .obj or .off, or one surface: .json, .step or .igs; `-` is standard output
    #[arg(long, short, value_name = "OUT")]
    out: Option<PathBuf>,
    /// How the contour is found
    #[arg(long, value_enum, default_value_t = Method::Threshold)]
    method: Method,
    /// Value on the contour [default: of images by Otsu's method, of grids 0]
    #[arg(long, value_name = "L", allow_negative_numbers = true, value_parser = numbers::signed)]
    level: Option<f64>,
    /// Which side of the level is inside; auto: in images the one that is rarer along the border, in grids the low one
    #[arg(long, value_enum, default_value_t = Region::Auto)]
    inside: Region,
    /// Standard deviation of the Gaussian with which an image is smoothed, in pixels; what it does to bent edges is undone
    /// [default: 1; 1.5 for images of two values and for edges]
    #[arg(long, value_name = "PX", value_parser = numbers::not_negative)]
    smooth: Option<f64>,
    /// Largest distance between curves and level set, both ways [default: 0.1 pixel, of grids a tenth of a cell]
    #[arg(long, value_name = "T", value_parser = numbers::length)]
    tolerance: Option<f64>,
    /// Number of control points of every curve [default: as many as the tolerance asks for]
    #[arg(long, value_name = "N")]
    control_points: Option<usize>,
    /// Leave out contours around less than this area, and open ones shorter than the circle around it [default: 10 square pixels, of
    /// grids 0]
    #[arg(long, value_name = "A", value_parser = numbers::not_negative)]
    min_area: Option<f64>,
    /// Whether parts may join, split and vanish while a contour evolves
    #[arg(long, value_enum, default_value_t = Topology::Free)]
    topology: Topology,
    /// Where an evolving contour starts: a circle, in the coordinates of the result; may be repeated [default: for chan-vese the
    /// threshold, for edges the border of the image]
    #[arg(long, value_name = "x,y,r", value_parser = parse_circle)]
    start: Vec<[f64; 3]>,
    /// Weight of the length of the contour (chan-vese) or of its curvature (edges), in pixels [default: 0.3, 0.5]
    #[arg(long, value_name = "PX", value_parser = numbers::not_negative)]
    length_weight: Option<f64>,
    /// Speed where there is no edge (edges): negative shrinks, positive grows [default: -1, with --start 1]
    #[arg(long, value_name = "V", allow_negative_numbers = true, value_parser = numbers::signed)]
    balloon: Option<f64>,
    /// First and last node of an NPY file, which does not say where it lies [default: whole numbers from 0]
    #[arg(long = "box", value_name = "x0,y0[,z0],x1,y1[,z1]", allow_hyphen_values = true, value_parser = super::field::parse_box)]
    bounds: Option<super::field::Bounds>,
    /// Draw the image with the contours (SVG or PNG): outer ones red, holes blue
    #[arg(long, value_name = "P.svg|P.png")]
    picture: Option<PathBuf>,
    #[command(flatten)]
    cad: CadArgs,
}

const AFTER_HELP: &str = "\
Coordinates of images are pixels: x to the right, y upwards, the image covers [0, width] x [0, height], and the centre of the lower left
pixel is (0.5, 0.5). So are those in JSON, DXF, STEP and IGES; in SVG, whose y axis points down, y is height - y, so that the drawing
lies on the image. Grids keep their coordinates. The inside is on the left of each curve: outer contours run counter-clockwise, holes
clockwise. Contours that leave the image end at the centres of its border pixels and stay open.

threshold  the level set of the values
chan-vese  a region evolves from the threshold (or --start) until inside and outside are as even as they can be, its border short
edges      a contour shrinks from the border (or grows from --start) until it rests on edges (geodesic active contour)
chan-vese and edges are for images.

DXF holds polylines within a tenth of the tolerance of the curves; SVG and the others hold the curves as they are.
A volume becomes a mesh by dual contouring, which is open where the level set leaves the grid. Written as .json, .step or .igs it becomes
one B-spline surface: a patch or a tube that ends where the grid does, or a surface that is closed all around or a ring; a level set of
several parts, with more borders or more handles is refused. Thin parts and sharp edges ask for many control points: see the verdict.
--control-points N then gives N x N of them.

Exit status 0: every contour is within the tolerance of the level set, from both sides, and does not cross itself; 1: one is not
(out_of_tolerance), or the evolution did not come to rest (not_converged); 2: bad input or usage; 130: interrupted.

Examples:
  indgeo contour coins.png -o coins.json --picture coins-contours.png
  indgeo contour cell.pgm -o cell.svg --method chan-vese --topology fixed --start 120,80,30
  indgeo contour distance.npy --box 0,0,1,1 -o outline.dxf --tolerance 1e-4
  indgeo contour distance.vti -o part.stl --json report.json
  indgeo contour distance.vti -o blob.step --tolerance 0.01 --unit mm";

fn parse_circle(text: &str) -> Result<[f64; 3], String> {
    numbers::triple(text)
        .filter(|[_, _, radius]| *radius > 0.0)
        .ok_or_else(|| "a circle is three numbers, x,y,r, with r above 0".to_owned())
}

impl Args {
    /// The files that are read, and those that are written.
    pub(crate) fn files(&self) -> (Vec<&Path>, Vec<PathBuf>) {
        let written = [&self.out, &self.picture];
        (vec![&self.input], written.into_iter().flatten().cloned().collect())
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args, common: &Common, report: &mut Report) -> Result<Outcome, Error> {
    common.something_written(args.out.is_some() || args.picture.is_some(), "-o OUT or --picture P.svg")?;
    let job = Job {
        input: &args.input,
        out: args.out.as_deref(),
        method: args.method,
        level: args.level,
        inside: args.inside,
        smooth: args.smooth,
        tolerance: args.tolerance,
        controls: args.control_points,
        min_area: args.min_area,
        is_held: args.topology == Topology::Fixed,
        start: &args.start,
        length_weight: args.length_weight,
        balloon: args.balloon,
        bounds: args.bounds.as_ref().map(|bounds| bounds.0.as_slice()),
        picture: args.picture.as_deref(),
        cad: &args.cad,
        quiet: common.quiet,
    };
    let verdict = job::run(&job, report)?;
    Ok(Outcome {
        summary: report.summary(),
        converged: verdict.is_none(),
        otherwise: verdict.unwrap_or("done"),
    })
}
