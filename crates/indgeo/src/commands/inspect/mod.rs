//! `indgeo inspect`: deviations of a scan from its model, and whether they are within tolerance.

pub(crate) mod job;
pub(crate) mod summary;

use self::job::{Job, Motion};
use super::numbers;
use super::project::search::Search;
use crate::common::Common;
use crate::error::Error;
use crate::input::cad::Choice;
use crate::input::scan_files;
use crate::output::Format;
use crate::report::{Outcome, Report};
use industrial_geometry::inspection::{Along, Inspection, InspectionOptions, Tolerance};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Measure the deviations of POINTS from MODEL and judge them by a tolerance
///
/// Signed distances from the exact surfaces (never from triangles in their place), statistics per surface and in total,
/// the worst points, and a page to look at.
#[derive(Debug, clap::Args)]
#[command(after_long_help = AFTER_HELP)]
pub(crate) struct Args {
    /// NURBS surfaces or curves (JSON, or free-form OBJ), a CAD model (STEP, IGES), or a triangle mesh (STL, PLY, OBJ, OFF)
    model: PathBuf,
    #[command(flatten)]
    cad: Choice,
    /// Points: PLY, XYZ, CSV, PTS, PTX, PCD, LAS, LAZ, E57, OBJ, STL or OFF; of a mesh its vertices. Several files, or a folder of
    /// them, are one cloud, in the order of their paths
    #[arg(required = true, value_name = "POINTS")]
    points: Vec<PathBuf>,
    /// Allowed deviation to both sides; --lower and --upper replace one limit each
    #[arg(long, short, value_name = "T", value_parser = numbers::length, required_unless_present_all = ["lower", "upper"])]
    tolerance: Option<f64>,
    /// Smallest allowed deviation, with its sign [default: -T]
    #[arg(long, value_name = "L", value_parser = numbers::signed)]
    lower: Option<f64>,
    /// Largest allowed deviation, with its sign [default: T]
    #[arg(long, value_name = "U", value_parser = numbers::signed)]
    upper: Option<f64>,
    /// Share of the points that must be within tolerance to pass, 0 to 1
    #[arg(long, value_name = "SHARE", default_value_t = 1.0, value_parser = numbers::share_or_none)]
    min_share: f64,
    /// Line along which a point is projected: `shortest`, `normal` (the point's own), or a direction X,Y,Z
    #[arg(long, value_name = "LINE", default_value = "shortest", allow_hyphen_values = true, value_parser = parse_along)]
    along: Along,
    /// The same as --along X,Y,Z
    #[arg(long, value_name = "X,Y,Z", conflicts_with = "along", allow_hyphen_values = true, value_parser = parse_direction)]
    direction: Option<[f64; 3]>,
    /// Largest angle between the normal of a point and that of the model where it is measured, up to 180 (no limit)
    ///
    /// A thin wall is then measured on the face that was scanned. Needs points with normals that point out of the material.
    /// With --along normal the default is 90, otherwise there is no limit.
    #[arg(long, value_name = "DEG", value_parser = super::numbers::angle)]
    max_angle: Option<f64>,
    /// Count points farther from the model than this, but do not use them
    #[arg(long, value_name = "D", default_value_t = f64::INFINITY, value_parser = numbers::limit)]
    max_distance: f64,
    /// Count points beyond the boundary of the model, but do not use them
    #[arg(long)]
    drop_beyond_boundary: bool,
    /// How many of the worst points are listed
    #[arg(long, value_name = "K", default_value_t = 10)]
    worst: u16,
    /// Move the points first: JSON with the `matrix` (4 × 4, row by row) of a rigid motion, as `register` writes it
    #[arg(long, value_name = "FILE")]
    transform: Option<PathBuf>,
    /// Write a page (HTML) that works offline: map of the deviations, histogram, tables
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Write the deviation of every point; its format follows from the extension: .csv, .ply, .json, .las, .laz, .e57 or .glb; `-` is standard output (CSV)
    #[arg(long, short, value_name = "OUT")]
    out: Option<PathBuf>,
    /// Leave behind what `indgeo merge` makes a report of, for one of many files (tiles) or with --points; nothing else is written
    #[arg(long, value_name = "FILE", conflicts_with_all = ["out", "report"])]
    partial: Option<PathBuf>,
    /// Measure the points A up to but not B of one file only, counted from 0
    #[arg(long = "points", value_name = "A..B", value_parser = job::parse_range)]
    range: Option<Range<u64>>,
    /// Most points in the picture of the page; of more, that many are chosen evenly
    #[arg(long, value_name = "N", default_value_t = job::MOST_POINTS, value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    picture: u32,
    /// Format of OUT, whatever its extension
    #[arg(long, value_enum, requires = "out")]
    format: Option<Format>,
    #[command(flatten)]
    search: Search,
}

const AFTER_HELP: &str = "\
A deviation is the distance of a point from the model along the line of projection, positive on the side to which the
normal (du x dv, or that of the triangles) points. Along normals and directions, the nearest crossing in either sense
counts. In the plane deviations are positive on the left of a curve, in space curves give them no sign; both take --along
shortest only, and no --max-angle.

With --max-angle only those feet and crossings count where the normal of the model is within DEG of that of the point: local
minima of the distance on surfaces, the nearest points of the triangles that agree on a mesh; on an edge, kink or seam the
normal of any face there will do. What is proven is proven for these. At 90 a face that stands exactly upright does not
count. Files cannot tell whether normals have a side: where they have none, --along normal takes --max-angle 180.

Verdict: pass if (points within) / (points judged) >= SHARE, and there is one. Judged are the points measured, and as not
within: those that are undecided, have no_matching_foot (no place of the model agrees with their normal), or not_converged
(no footpoint was found). A point is undecided if all that is proven about its distance, an interval from a lower bound to
the distance found, reaches across a limit of the tolerance; it fails the part only if SHARE is then not reached. A point
whose whole interval lies within the tolerance is within, whether its iteration converged or not. A certified distance
counts as it is, up to --relative-gap.
Points beyond D, beyond the boundary (if dropped), whose line misses the model, with a normal that is zero or not finite
where one is needed (no_normal), or not finite themselves are counted, but not judged; the last two cause a warning.
Shares are rounded to the bad side: 100.00 % means all. Exit status 0: pass; 1: fail; 2: bad input or usage; 130:
interrupted.

Memory: binary PLY, LAS, LAZ, E57, PTX and plain tables are read piece by piece, and take the model and some 100 MB however many points
there are; OUT is then written piece by piece as CSV and PLY. Quantiles and histogram come from the values of up to 4194304 measured
points; of more, values count in cells of a relative width of 1/4096. The picture of the page shows up to N points.

With --partial the exit status is 0 when the file was written: the verdict is that of `indgeo merge`.

Columns of OUT, one row per point, in the order of POINTS:
  surfaces  x,y,z,foot_x,foot_y,foot_z,normal_x,normal_y,normal_z,distance,shape,u,v,location,result
  mesh      ... with triangle in place of u,v
  curves    ... with t in place of u,v; in the plane (points of two columns) without z: x,y,foot_x,foot_y,normal_x,...
x,y,z are the coordinates after --transform. result: within, over, under, or why the point is not judged:
beyond_max_distance, beyond_boundary, no_hit, no_normal, not_converged, invalid_point, no_matching_foot, undecided. PLY, LAS,
LAZ, E57 and GLB have red,green,blue too, and GLB no other columns. The form of --json is that of docs/schema/inspect.schema.json.

Examples:
  indgeo inspect part.json scan.ply --tolerance 0.05 --report report.html --json report.json
  indgeo inspect part.stl scan.xyz --lower -0.1 --upper 0.3 --min-share 0.99 -o deviations.ply
  indgeo inspect part.json scan.ply -t 0.05 --along 0,0,1 --max-distance 2
  indgeo inspect sheet.stl scan.ply -t 0.05 --max-angle 60
  indgeo inspect part.step tiles/*.laz -t 0.05 --report report.html
  indgeo inspect part.step tiles/7.laz -t 0.05 --partial partial-7.json    (see `indgeo merge --help`)
  indgeo inspect part.step scan.laz -t 0.05 --points 0..50000000 --partial partial-0.json";

fn parse_direction(text: &str) -> Result<[f64; 3], String> {
    let direction = numbers::triple(text).filter(|d| d.iter().any(|value| *value != 0.0));
    direction.ok_or_else(|| "a direction is three numbers, not all zero: X,Y,Z".to_owned())
}

fn parse_along(text: &str) -> Result<Along, String> {
    match text {
        "shortest" => Ok(Along::Shortest),
        "normal" => Ok(Along::Normal),
        _ => parse_direction(text)
            .map(Along::Direction)
            .map_err(|_| "choose shortest, normal, or a direction X,Y,Z that is not zero".to_owned()),
    }
}

impl Args {
    /// The files that are read, and those that are written.
    pub(crate) fn files(&self) -> (Vec<&Path>, Vec<PathBuf>) {
        let read = [Some(&self.model), self.transform.as_ref()].into_iter().flatten().chain(&self.points);
        let written = [&self.report, &self.out, &self.partial];
        (read.map(PathBuf::as_path).collect(), written.into_iter().flatten().cloned().collect())
    }

    /// The options by which points are measured and judged, as they are typed, with their values.
    fn arguments(&self) -> Vec<String> {
        let half = self.tolerance.unwrap_or(f64::NAN);
        let mut out = vec![
            format!("--lower={}", self.lower.unwrap_or(-half)),
            format!("--upper={}", self.upper.unwrap_or(half)),
            format!("--min-share={}", self.min_share),
            format!("--worst={}", self.worst),
            format!("--picture={}", self.picture),
            format!("--mode={}", self.search.mode.name()),
            format!("--relative-gap={}", self.search.relative_gap),
            format!("--scan={}", self.search.scan),
            match self.direction.map_or(self.along, Along::Direction) {
                Along::Shortest => "--along=shortest".to_owned(),
                Along::Normal => "--along=normal".to_owned(),
                Along::Direction([x, y, z]) => format!("--along={x},{y},{z}"),
            },
        ];
        out.extend(self.max_angle.map(|angle| format!("--max-angle={angle}")));
        if self.max_distance.is_finite() {
            out.push(format!("--max-distance={}", self.max_distance));
        }
        if self.drop_beyond_boundary {
            out.push("--drop-beyond-boundary".to_owned());
        }
        if self.search.drop_non_finite {
            out.push("--drop-non-finite".to_owned());
        }
        out.extend(self.cad.arguments());
        out
    }

    /// The job with these files of points.
    pub(super) fn job<'a>(&'a self, points: &'a [PathBuf], common: &Common) -> Result<Job<'a>, Error> {
        Ok(Job {
            model: &self.model,
            cad: &self.cad,
            points,
            range: self.range.clone(),
            motion: self.transform.as_deref().map_or(Motion::None, Motion::File),
            page: self.report.as_deref(),
            picture: self.picture,
            out: self.out.as_deref(),
            format: self.format,
            options: self.options()?,
            mode: self.search.mode.name(),
            drop_non_finite: self.search.drop_non_finite,
            scan: Some(&self.search.scan),
            threads: common.threads,
            quiet: common.quiet,
        })
    }

    fn options(&self) -> Result<InspectionOptions, Error> {
        let half = self.tolerance.unwrap_or(f64::NAN);
        let tolerance = Tolerance::new(self.lower.unwrap_or(-half), self.upper.unwrap_or(half));
        let options = tolerance.and_then(|tolerance| {
            let options = InspectionOptions::new(tolerance)
                .with_min_share(self.min_share)
                .with_along(self.direction.map_or(self.along, Along::Direction))
                .with_max_distance(self.max_distance)
                .with_drop_beyond_boundary(self.drop_beyond_boundary)
                .with_worst(usize::from(self.worst));
            let options = InspectionOptions { max_angle: self.max_angle.map(f64::to_radians), ..options };
            options.validate().map(|()| options)
        });
        let options = options.map_err(|error| job::usage(&error))?;
        Ok(options.with_projection(self.search.options()?))
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args, common: &Common, report: &mut Report) -> Result<Outcome, Error> {
    let points = scan_files::expand(&args.points)?;
    let job = args.job(&points, common)?;
    if let (Some(range), 2..) = (&args.range, points.len()) {
        let what = format!(
            "--points {}..{} is for one file of points, these are {}",
            range.start,
            range.end,
            points.len()
        );
        return Err(Error::usage(what, "give the points of each file in a run of its own"));
    }
    let Some(partial) = &args.partial else {
        let found = job::run(&job, report)?;
        return Ok(judged(&found, report));
    };
    let _ = job::run_partial(&job, args.arguments(), partial, report)?;
    // The verdict is that of all parts together.
    Ok(Outcome::new(report.summary(), true))
}

/// How an inspection ends.
pub(super) fn judged(found: &Inspection, report: &Report) -> Outcome {
    Outcome { summary: report.summary(), converged: found.verdict.pass, otherwise: "out_of_tolerance" }
}
