//! `indgeo geodesic`: distances and shortest curves on a surface.

pub(crate) mod job;
pub(crate) mod summary;

use self::job::{Job, MethodChoice, Place};
use crate::common::Common;
use crate::error::Error;
use crate::on_surface::MetricChoice;
use crate::report::{Outcome, Report};
use std::path::{Path, PathBuf};

/// Distances on a surface from one or several places, and geodesic curves
///
/// On a triangle mesh the distance of every vertex, exact by default; on a NURBS surface the geodesic from one point to another. In the
/// feature sensitive metric the turning of the normal counts as length, so that distances grow across edges and fillets.
#[derive(Debug, clap::Args)]
#[command(after_long_help = AFTER_HELP)]
pub(crate) struct Args {
    /// A triangle mesh (STL, PLY, OBJ, OFF), or one NURBS surface (JSON); `-` is standard input
    shape: PathBuf,
    /// Where distances begin: a vertex V (from 0), a point x,y,z, or u,v on a NURBS surface; repeat it for several
    #[arg(long, value_name = "V|x,y,z|u,v", required = true, allow_hyphen_values = true, value_parser = parse_place)]
    from: Vec<Place>,
    /// Find the geodesic from the nearest source to a place; repeat it for several
    #[arg(long, value_name = "V|x,y,z|u,v", allow_hyphen_values = true, value_parser = parse_place)]
    to: Vec<Place>,
    /// How lengths are measured
    #[arg(long, value_enum, default_value_t = MetricChoice::Euclidean)]
    metric: MetricChoice,
    /// Width of the feature sensitive metric, a length: fillets with a smaller radius count as features
    #[arg(long, value_name = "W")]
    w: Option<f64>,
    /// How distances on a mesh are found
    #[arg(long, value_enum, default_value_t = MethodChoice::Exact)]
    method: MethodChoice,
    /// The distances (.csv, .ply), or the curve on a NURBS surface (.csv); `-` is standard output
    #[arg(long, short, value_name = "OUT")]
    out: Option<PathBuf>,
    /// Draw the mesh with distances, isolines and curves (SVG or PNG)
    #[arg(long, value_name = "P.svg|P.png")]
    picture: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
CSV of a mesh: vertex,x,y,z,distance, vertices from 0 in the order of the file, `inf` where no way leads. PLY: the mesh with the scalar
`distance`. CSV on a NURBS surface: u,v,x,y,z along the curve. Curves to --to are in the report (results.paths): length, points.

A point x,y,z is taken to the nearest point of the mesh, which becomes a vertex for the computation.
exact  windows of straight lines over the unfolded triangles; exact but for rounding
fast   from triangle to triangle, error of the order of a triangle's size; for millions of triangles
Curves on NURBS surfaces are polylines of least energy, their length is extrapolated; they are locally shortest.

The feature sensitive metric measures on (x, w n), n the unit normal: a 90 degree fillet of radius r costs pi/2 sqrt(r^2 + w^2) across
and as in space along it. Normals are those of the file, otherwise means over triangles between edges of 40 degrees and more.

Exit status 0: done; 1: a vertex cannot be reached, or a curve is no geodesic; 2: bad input or usage; 130: interrupted.

Examples:
  indgeo geodesic part.stl --from 0 -o distance.csv
  indgeo geodesic part.stl --from 1.5,0,2 --to 8,3,0 --metric feature --w 0.5 -o distance.ply --picture distance.svg --json -
  indgeo geodesic surface.json --from 0.1,0.2 --to 0.9,0.7 -o curve.csv";

fn parse_place(text: &str) -> Result<Place, String> {
    let help = "a place is a vertex (from 0), a point x,y,z, or parameters u,v";
    if let Ok(vertex) = text.trim().parse() {
        return Ok(Place::Vertex(vertex));
    }
    let parts: Option<Vec<f64>> = text
        .split(',')
        .map(|part| part.trim().parse().ok().filter(|number: &f64| number.is_finite()))
        .collect();
    match parts.as_deref() {
        Some(&[u, v]) => Ok(Place::Parameters([u, v])),
        Some(&[x, y, z]) => Ok(Place::Point([x, y, z])),
        _ => Err(help.to_owned()),
    }
}

impl Args {
    /// The files that are read, and those that are written.
    pub(crate) fn files(&self) -> (Vec<&Path>, Vec<PathBuf>) {
        (vec![&self.shape], [&self.out, &self.picture].into_iter().flatten().cloned().collect())
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args, common: &Common, report: &mut Report) -> Result<Outcome, Error> {
    common
        .something_written(args.out.is_some() || args.picture.is_some() || !args.to.is_empty(), "-o OUT")?;
    let job = Job {
        shape: &args.shape,
        from: &args.from,
        to: &args.to,
        choice: args.metric,
        metric: args.metric.metric(args.w)?,
        method: args.method,
        out: args.out.as_deref(),
        picture: args.picture.as_deref(),
    };
    let complete = job::run(&job, report)?;
    Ok(Outcome::new(report.summary(), complete))
}
