//! `indgeo segment`: surfaces by type in clouds and meshes.

pub(crate) mod job;

use self::job::Job;
use crate::common::Common;
use crate::error::Error;
use crate::report::{Outcome, Report};
use industrial_geometry::segmentation::SegmentationOptions;
use std::path::{Path, PathBuf};

/// Surfaces by type: planes, cylinders, cones, spheres, tori, extrusions, revolutions, helices, free form
///
/// Every point of a cloud, or vertex of a mesh, gets the label of the surface that carries it; the report has type, parameters and
/// covariance of each surface, and the type that came second. All limits are multiples of the noise, which is found from the points.
#[derive(Debug, clap::Args)]
#[command(after_long_help = AFTER_HELP)]
pub(crate) struct Args {
    /// A cloud or a triangle mesh (XYZ, CSV, PLY, PCD, STL, OBJ, OFF); `-` is standard input
    points: PathBuf,
    /// The points with their labels (.ply, .csv); `-` is standard output
    #[arg(long, short, value_name = "LABELS")]
    out: Option<PathBuf>,
    /// Standard deviation of the noise, a length; found from the points by default
    #[arg(long, value_name = "S")]
    sigma: Option<f64>,
    /// Fewest points of a region
    #[arg(long, value_name = "N", default_value_t = SegmentationOptions::default().min_points)]
    min_points: usize,
    /// Draw a mesh with its regions (SVG or PNG)
    #[arg(long, value_name = "P.svg|P.png")]
    picture: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
CSV: x,y,z,label. PLY: the points with a colour per region and the whole number `label`, and the triangles of a mesh. Points stay in the
order of the file; label -1 is no region. Regions are numbered by size, the largest is 0.

The report (results.primitives) has one entry per region: label, type, the parameters (point, axis, radius, minor_radius, half_angle, normal,
pitch, as far as the type has them; again in `parameters`), covariance, rms, support, chi2, runner_up. `point` is the apex of a cone and the
centre of a sphere or torus; pitch is the advance per turn; angles are in radians; chi2 is per degree of freedom.

Normals of the file, or of the triangles of a mesh, only tell the sides of thin walls apart: give them where walls are thinner than a few
spacings. The type is decided by distances. A face should have 3 points across; vertices of meshes made by CAD programs are too few.

Exit status 0: every point has a region; 1: points without a region are left (label -1, counted in the report); 2: bad input or usage;
130: interrupted.

Examples:
  indgeo segment scan.ply -o labels.ply --json report.json
  indgeo segment scan.xyz -o labels.csv --sigma 0.01
  indgeo segment part.stl -o labels.ply --picture regions.svg";

impl Args {
    /// The files that are read, and those that are written.
    pub(crate) fn files(&self) -> (Vec<&Path>, Vec<PathBuf>) {
        (vec![&self.points], [&self.out, &self.picture].into_iter().flatten().cloned().collect())
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args, common: &Common, report: &mut Report) -> Result<Outcome, Error> {
    common.something_written(args.out.is_some() || args.picture.is_some(), "-o LABELS")?;
    let job = Job {
        points: &args.points,
        options: SegmentationOptions::default().with_sigma(args.sigma).with_min_points(args.min_points),
        out: args.out.as_deref(),
        picture: args.picture.as_deref(),
    };
    let complete = job::run(&job, report)?;
    Ok(Outcome { summary: report.summary(), converged: complete, otherwise: "unexplained_points" })
}
