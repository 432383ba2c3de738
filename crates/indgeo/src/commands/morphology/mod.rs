//! `indgeo morphology`: regions on a mesh, made larger and smaller by geodesic balls.

pub(crate) mod job;
pub(crate) mod summary;

use self::job::{Job, OperationChoice};
use super::numbers;
use crate::common::Common;
use crate::error::Error;
use crate::on_surface::MetricChoice;
use crate::report::{Outcome, Report};
use std::path::{Path, PathBuf};

/// Grow, shrink, open or close regions of a mesh by geodesic balls
///
/// In the feature sensitive metric a ball hardly crosses edges and fillets, and so do not the regions.
#[derive(Debug, clap::Args)]
#[command(after_long_help = AFTER_HELP)]
pub(crate) struct Args {
    /// A triangle mesh (STL, PLY, OBJ, OFF); `-` is standard input
    mesh: PathBuf,
    /// The regions: name of a scalar of the mesh (PLY), or a file with a label per vertex; 0 is no region
    #[arg(long, value_name = "LABELS")]
    regions: PathBuf,
    /// What is done to every region
    #[arg(long, value_enum)]
    operation: OperationChoice,
    /// Radius of the balls, a length in the metric
    #[arg(long, value_name = "R", value_parser = numbers::length)]
    radius: f64,
    /// How lengths are measured
    #[arg(long, value_enum, default_value_t = MetricChoice::Euclidean)]
    metric: MetricChoice,
    /// Width of the feature sensitive metric, a length: fillets with a smaller radius count as features
    #[arg(long, value_name = "W")]
    w: Option<f64>,
    /// The mesh with its new labels (.ply, scalar `label`), or a table of them (.csv); `-` is standard output (CSV)
    #[arg(long, short, value_name = "OUT")]
    out: Option<PathBuf>,
    /// Draw the mesh with its new regions (SVG or PNG)
    #[arg(long, value_name = "P.svg|P.png")]
    picture: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
Every label but 0 is a region of its own. Regions grow into vertices without a region only: where several reach a vertex, the nearest
takes it. Eroded vertices get 0. Open: erode, then dilate; close: dilate, then erode. CSV: vertex,x,y,z,label.

Distances are those of `indgeo geodesic --method fast`, with straight wave fronts along the borders of the regions.

Exit status 0: done; 2: bad input or usage; 130: interrupted.

Examples:
  indgeo morphology part.ply --regions label --operation dilate --radius 2 --metric feature --w 0.5 -o grown.ply
  indgeo morphology part.stl --regions labels.txt --operation open --radius 0.5 -o opened.ply --picture opened.svg";

impl Args {
    /// The files that are read, and those that are written. Labels may be those of the mesh, and then no file.
    pub(crate) fn files(&self) -> (Vec<&Path>, Vec<PathBuf>) {
        let read = [Some(&self.mesh), Some(&self.regions).filter(|path| path.is_file())];
        let written = [&self.out, &self.picture];
        (
            read.into_iter().flatten().map(PathBuf::as_path).collect(),
            written.into_iter().flatten().cloned().collect(),
        )
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args, common: &Common, report: &mut Report) -> Result<Outcome, Error> {
    common.something_written(args.out.is_some() || args.picture.is_some(), "-o OUT")?;
    let job = Job {
        mesh: &args.mesh,
        regions: &args.regions,
        operation: args.operation,
        radius: args.radius,
        choice: args.metric,
        metric: args.metric.metric(args.w)?,
        out: args.out.as_deref(),
        picture: args.picture.as_deref(),
    };
    job::run(&job, report)?;
    Ok(Outcome::new(report.summary(), true))
}
