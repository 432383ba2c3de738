//! `indgeo project`: the closest point of a model for every point of a scan.

pub(crate) mod job;
pub(crate) mod pieces;
pub(crate) mod request;
pub(crate) mod results;
pub(crate) mod search;
pub(crate) mod summary;

use self::request::Job;
use self::search::Search;
use crate::common::Common;
use crate::error::Error;
use crate::input::cad::Choice;
use crate::output::Format;
use crate::report::{Outcome, Report};
use std::path::PathBuf;

/// Find the closest point of MODEL for every point of POINTS
///
/// The answer is certified: no other point of the model is nearer, but for a gap that is reported; a point for which the
/// proof stays open is `uncertified`, and the exit status 1.
#[derive(Debug, clap::Args)]
#[command(after_long_help = AFTER_HELP)]
pub(crate) struct Args {
    /// NURBS curves or surfaces (JSON, or free-form OBJ), a CAD model (STEP, IGES), a triangle mesh (STL, PLY, OBJ, OFF), or
    /// signed distances on a grid (.vti of `indgeo field`, with --mode fast); `-` is standard input, which cannot be STEP
    pub(crate) model: PathBuf,
    #[command(flatten)]
    cad: Choice,
    /// Points: PLY, XYZ, CSV, PTS, PTX, PCD, LAS, LAZ, E57, OBJ, STL or OFF; of a mesh its vertices; `-` is standard input
    pub(crate) points: PathBuf,
    /// The result; its format follows from the extension: .csv, .ply, .json, .las, .laz, .e57 or .glb; `-` is standard output (CSV)
    #[arg(long, short, value_name = "OUT")]
    pub(crate) out: PathBuf,
    /// Largest angle between the normals of a point and of the model at its foot, up to 180 (no limit)
    ///
    /// Of a thin wall the face that was scanned is then found. Needs points with normals that point out of the material.
    #[arg(long, value_name = "DEG", value_parser = super::numbers::angle)]
    max_angle: Option<f64>,
    /// Format of the result, whatever its extension
    #[arg(long, value_enum)]
    format: Option<Format>,
    #[command(flatten)]
    search: Search,
}

const AFTER_HELP: &str = "\
Columns of OUT, one row per point, in the order of POINTS:
  surfaces            x,y,z,foot_x,foot_y,foot_z,distance,shape,u,v,status,lower_bound
  curves in space     x,y,z,foot_x,foot_y,foot_z,distance,shape,t,status,lower_bound
  both                as for surfaces; on a curve u is t and v is empty
  mesh                x,y,z,foot_x,foot_y,foot_z,distance,shape,triangle,status,lower_bound  (shape is 0)
  CAD models          x,y,z,foot_x,foot_y,foot_z,distance,shape,u,v,status,lower_bound,on,side,entity
  field (.vti)        x,y[,z],foot_x,foot_y[,foot_z],distance,status,lower_bound
  one plane curve     x,y,foot_x,foot_y,distance,t,status,lower_bound
  several of them     x,y,foot_x,foot_y,distance,shape,t,status,lower_bound
Plane curves (\"dim\": 2) take points of two columns, or with z = 0.

distance  in the unit of the files. Onto surfaces it is positive on the side to which the normal (du x dv) points, onto
          closed meshes positive outside; onto curves and open meshes it has no sign. Fields give it their own.
shape     index of the curve or surface in the model, triangle: index in the mesh; both count from 0.
status    converged, on_boundary (the closest point lies on the boundary of the model), uncertified (a foot, but the proof
          that none is nearer stayed open), stalled, max_iterations, diverged, cancelled, invalid_point; with --max-angle
          no_matching_foot (no foot has a normal within DEG of the point's: the feet that count are local minima of the
          distance on surfaces, the nearest points of the triangles that agree on a mesh, and on an edge any face there will
          do), no_normal (that of the point is zero). In PLY a number, named in the header.
lower_bound  no point of the model, with --max-angle no foot that counts, is nearer than this; empty where nothing was proven
          (--mode fast and local, and on fields, whose feet are uncertified without these).
on, side, entity  of CAD models: face, edge or vertex that holds the foot; outside, inside or undecided (then the distance
          has no sign); number of the face or edge in the file (#entity), shape being the index of a face that holds the foot.
Numbers read back to the same bits. .csv: a missing value is empty. .ply: binary, doubles, NaN and -1 where there is no
value; triangles of POINTS are kept. .las, .laz: extra bytes, doubles, coordinates rounded to a grid (told); .e57: an extension,
doubles; .glb: only points and triangles. .json: {\"points\": N, \"columns\": [...], \"x\": [...], ...}, null where there is
no value.

Exit status 0: every finite point has its closest point, with its proof in certified mode; 1: one did not converge, stayed
uncertified or has no matching foot (the result is written nevertheless); 2: bad input or usage; 130: interrupted. Points that
are not finite, or lack the normal that --max-angle asks for, cause a warning, not a failure.

Examples:
  indgeo project model.json scan.ply -o deviations.csv
  gzip -dc scan.xyz.gz | indgeo project model.json - -o deviations.csv
  indgeo project part.stl scan.xyz -o deviations.ply --json report.json
  indgeo project distance.vti scan.xyz -o deviations.csv --mode fast
  indgeo project section.json profile.csv -o feet.csv --json - --quiet";

/// Runs the command.
pub(crate) fn run(args: &Args, common: &Common, report: &mut Report) -> Result<Outcome, Error> {
    let job = Job {
        model: &args.model,
        cad: &args.cad,
        points: &args.points,
        out: &args.out,
        format: args.format,
        options: args.search.options()?,
        max_angle: args.max_angle.filter(|angle| *angle < 180.0).map(f64::to_radians),
        mode: args.search.mode,
        drop_non_finite: args.search.drop_non_finite,
        scan: Some(&args.search.scan),
        threads: common.threads,
        quiet: common.quiet,
    };
    job::run_in_pieces(&job, report)?;
    let (converged, otherwise) = (job::all_converged(report), job::otherwise(report));
    Ok(Outcome { summary: report.summary(), converged, otherwise })
}
