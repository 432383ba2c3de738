//! `indgeo register`: where a scan fits its model best.

pub(crate) mod approach;
pub(crate) mod beside;
pub(crate) mod elsewhere;
pub(crate) mod field;
pub(crate) mod job;
pub(crate) mod model;
pub(crate) mod near;
pub(crate) mod page;
pub(crate) mod planar_start;
pub(crate) mod request;
pub(crate) mod results;
pub(crate) mod runs;
pub(crate) mod sight;
pub(crate) mod starts;
pub(crate) mod step;
pub(crate) mod summary;
pub(crate) mod verdict;

use self::request::{Job, Start};
use self::results::RegistrationResults;
use super::numbers;
use crate::commands::inspect::job::{self as inspecting, InspectionResults, Motion};
use crate::common::Common;
use crate::error::Error;
use crate::files;
use crate::input::cad::Choice;
use crate::input::sampling;
use crate::input::transform::Transform;
use crate::report::{Outcome, Report};
use clap::ValueEnum;
use industrial_geometry::distance_field::ErrorTerm;
use industrial_geometry::inspection::{InspectionOptions, Tolerance};
use industrial_geometry::io::Format;
use industrial_geometry::register::{Locks, Method, Outliers, Pose, RegisterOptions};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Move POINTS to where they fit MODEL best
///
/// Least squares of the distances to the exact shape, with quadratic convergence; points that do not belong to the model
/// are recognised and left out. The result is the moved points, and the motion with its covariance.
#[derive(Debug, clap::Args)]
#[command(after_long_help = AFTER_HELP)]
pub(crate) struct Args {
    /// The fixed shape: NURBS (JSON; curves in the plane take points of two columns), a CAD model (STEP, IGES), a triangle mesh (STL, PLY, OBJ, OFF), or
    /// a dense cloud; `-` is standard input
    model: PathBuf,
    #[command(flatten)]
    cad: Choice,
    /// The points to be moved: any cloud, or a mesh with its triangles; `-` is standard input
    points: PathBuf,
    /// The moved points, with everything else that came with them; the format follows from the extension; `-` is standard output (CSV, OBJ
    /// for triangles)
    #[arg(long, short, value_name = "MOVED")]
    out: Option<PathBuf>,
    /// Format of MOVED, whatever its extension: ply, xyz, csv, pts, obj, stl, off, pcd, las, laz, e57 or glb
    #[arg(long, value_name = "FORMAT", requires = "out", value_parser = crate::files::parse_format)]
    format: Option<Format>,
    /// Write the motion (JSON): matrix, quaternion, axis and angle, covariance, history; `-` is standard output
    #[arg(long, value_name = "T.json")]
    transform: Option<PathBuf>,
    /// Start from the pose in FILE, or from each of a list of poses (JSON, 4 x 4 row by row); the best result counts
    #[arg(long, value_name = "FILE", conflicts_with = "start")]
    init: Option<PathBuf>,
    /// Where to start when there is no --init
    #[arg(long, value_enum, default_value_t = StartChoice::Auto)]
    start: StartChoice,
    /// What is minimised in a step
    #[arg(long, value_enum, default_value_t = MethodChoice::Adaptive)]
    method: MethodChoice,
    /// Approach the model from each start by points matched with position and normal, the normal times this length (0: position alone)
    ///
    /// Finds the pose of parts with thin walls more often from starts far off, that of others hardly or not (docs/measurements.md); a tenth to a
    /// third of the size of the model is a good length, more than it costs. Points without normals get
    /// those of planes through neighbours, whose side does not count.
    #[arg(long, value_name = "W", value_parser = numbers::not_negative, conflicts_with_all = ["lock", "partial"])]
    feature_weight: Option<f64>,
    /// What is assumed about points that do not belong to the model
    #[arg(long, value_enum, default_value_t = OutlierChoice::Automatic)]
    outliers: OutlierChoice,
    /// Share of the points that belong to the model, 0 to 1, for --outliers trimmed
    #[arg(long, value_name = "SHARE", value_parser = numbers::share, required_if_eq("outliers", "trimmed"))]
    overlap: Option<f64>,
    /// Largest angle between the normals of a point and of the model at its foot, up to 180 (no limit)
    ///
    /// Points whose nearest place of the model faces another way do not count in a step, so that a scan of one face of a thin
    /// wall is not drawn to the other. Needs points with normals that point out of the material.
    #[arg(long, value_name = "DEG", value_parser = super::numbers::angle)]
    max_angle: Option<f64>,
    /// Degrees of freedom that are held fast: any of tx, ty, tz, rx, ry, rz, separated by commas; x, y or z holds the plane across that
    /// axis: z is tz, rx, ry
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_enum)]
    lock: Vec<Lock>,
    /// Point about which locked rotations are meant [default: the origin]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = parse_point)]
    lock_origin: Option<[f64; 3]>,
    /// Estimate the scale of the points, too
    #[arg(long)]
    scale: bool,
    /// Without -o, use an even sample of N points of a file that holds more (binary PLY, LAS, LAZ, E57, PTX, plain tables)
    #[arg(long, value_name = "N", default_value_t = sampling::MOST, value_parser = clap::value_parser!(u32).range(100..))]
    sample: u32,
    /// Leave behind the exact sums of one step for one of many files (tiles) or with --points, of which `indgeo merge` makes the
    /// step; nothing else is written
    #[arg(long, value_name = "FILE", conflicts_with_all = PARTIAL_CONFLICTS)]
    partial: Option<PathBuf>,
    /// Use the points A up to but not B of POINTS only, counted from 0, for --partial
    #[arg(long = "points", value_name = "A..B", value_parser = inspecting::parse_range)]
    range: Option<Range<u64>>,
    /// Points farther from the model than this do not count, for --partial
    #[arg(long, value_name = "D", value_parser = numbers::limit)]
    max_distance: Option<f64>,
    /// Most steps of one stage; a registration that they end is not converged (exit status 1)
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u16).range(1..))]
    max_iterations: u16,
    /// Judge the moved points as `inspect` does, by the tolerance of -t; the model is then NURBS or a mesh
    #[arg(long, requires = "tolerance")]
    inspect: bool,
    /// Allowed deviation to both sides, for --inspect
    #[arg(long, short, value_name = "T", value_parser = numbers::length, requires = "inspect")]
    tolerance: Option<f64>,
    /// Write a page (HTML): before and after, residuals, overlap and the uncertainty of the pose; with --inspect that of the inspection
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
}

/// What a single step does not know: it starts at --init, without a search, and all points up to --max-distance count.
const PARTIAL_CONFLICTS: [&str; 12] = [
    "out",
    "format",
    "transform",
    "start",
    "method",
    "outliers",
    "overlap",
    "lock",
    "lock_origin",
    "scale",
    "inspect",
    "report",
];

/// Where to start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum StartChoice {
    /// From where the points are; if that leaves points off the model, a search over all positions as well
    Auto,
    /// From where the points are
    Given,
    /// Search over all positions
    Global,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MethodChoice {
    /// Tangent planes while far, Newton's method near the end
    Adaptive,
    /// Squared distance to the closest point (ICP)
    Point,
    /// Squared distance to the tangent plane (Chen and Medioni)
    Tangent,
    /// Squared distance minimisation with nonnegative models
    SquaredDistance,
    /// Newton's method throughout
    Newton,
    /// Symmetric objective; needs normals of the points
    Symmetric,
    /// ICP with Anderson acceleration
    Anderson,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum OutlierChoice {
    /// Recognised by their distances, if there are any
    Automatic,
    /// There are none: least squares over all points
    None,
    /// The share of --overlap that is nearest counts
    Trimmed,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Lock {
    Tx,
    Ty,
    Tz,
    Rx,
    Ry,
    Rz,
    /// The plane across x: tx, ry, rz
    X,
    /// The plane across y: ty, rx, rz
    Y,
    /// The plane across z: tz, rx, ry
    Z,
}

impl Lock {
    /// Whether the translations along the axes, and the turns about them, are held.
    fn held(self) -> ([bool; 3], [bool; 3]) {
        let along = |axis: usize| [0, 1, 2].map(|other| other == axis);
        match self {
            Self::Tx => (along(0), [false; 3]),
            Self::Ty => (along(1), [false; 3]),
            Self::Tz => (along(2), [false; 3]),
            Self::Rx => ([false; 3], along(0)),
            Self::Ry => ([false; 3], along(1)),
            Self::Rz => ([false; 3], along(2)),
            Self::X => (along(0), along(0).map(|axis| !axis)),
            Self::Y => (along(1), along(1).map(|axis| !axis)),
            Self::Z => (along(2), along(2).map(|axis| !axis)),
        }
    }
}

const AFTER_HELP: &str = "\
T.json: {\"matrix\": 4 x 4 row by row (MODEL = matrix * POINTS), \"rotation\": {\"quaternion\": [w,x,y,z], \"axis\": [x,y,z],
\"angle\": radians}, \"translation\": [x,y,z], \"scale\": s, \"status\": ..., \"rms\": ..., \"covariance\": {...} or null, ...}.
The covariance is that of (displacement of `origin`, rotation vector about it). `free_motions` names the motions that the
shape does not fix, as that of a cylinder along and about its axis; the points are not moved along these.

In the plane the matrix is that of a turn about z, and the covariance has three rows (x, y, angle).

With --max-angle a point without a normal (zero, not finite) does not count. Curves and clouds without normals of their own
have nothing to compare with, and refuse it.

--inspect reads the files again, measures the moved points (results.inspection, docs/schema/inspect.schema.json) and ends with 1 if a
point is out of tolerance. For other limits and options run `indgeo inspect` with --transform T.json.

--partial is for clouds on many machines: one step of Gauss and Newton with the distances from tangent planes, from --init (or where
the points are), in which all points up to --max-distance from the model count, and none whose foot is on the boundary of an open
model. `indgeo merge` of the sums of all tiles writes the pose that follows, which is the --init of the next step.

With several starts each is reported (`starts`); the one that leaves the least distance counts.
Status: converged; doubtful (the iteration converged, but the points do not speak for the pose: `support` has the numbers and the
reason); no_overlap (hardly any points lie on the model); underdetermined (points and model are clouds in a plane each, or
the points cover too little of the model to fix its far corners, or leave free what the model fixes);
max_iterations, stalled, diverged. docs/when-not-to-trust-a-registration.md explains them. Of poses that a symmetric model does not
tell apart the one nearest to the start is taken, and all are listed (`equivalent_poses`). Poses that the model tells apart, but not
the points, are doubtful (`rival_poses`).
Exit status 0: converged; 1: any other status (files are written nevertheless); 2: bad input or usage; 130: interrupted.

Examples:
  indgeo register part.stl scan.ply -o moved.ply --transform pose.json
  indgeo register part.json scan.ply -o moved.ply --init start.json --lock z
  indgeo register part.json scan.ply --transform pose.json --outliers trimmed --overlap 0.6
  indgeo register part.json scan.ply --report registration.html
  indgeo register part.json scan.ply --inspect --tolerance 0.05 --report report.html
  indgeo inspect part.json scan.ply --transform pose.json --lower -0.1 --upper 0.3
  indgeo register part.step tiles/7.laz --init pose.json --partial sums-7.json    (then `indgeo merge sums-*.json --transform`)";

fn parse_point(text: &str) -> Result<[f64; 3], String> {
    numbers::triple(text).ok_or_else(|| "a point is three numbers: X,Y,Z".to_owned())
}

impl Args {
    /// The files that are read, and those that are written.
    pub(crate) fn files(&self) -> (Vec<&Path>, Vec<PathBuf>) {
        let read = [Some(&self.model), Some(&self.points), self.init.as_ref()];
        let written = [&self.out, &self.transform, &self.report, &self.partial];
        (
            read.into_iter().flatten().map(PathBuf::as_path).collect(),
            written.into_iter().flatten().cloned().collect(),
        )
    }

    /// The options of the sums of a step, as they are typed.
    fn step_arguments(&self) -> Vec<String> {
        let distance = self.max_distance.filter(|distance| distance.is_finite());
        let distance = distance.map(|distance| format!("--max-distance={distance}"));
        let angle = self.max_angle.map(|angle| format!("--max-angle={angle}"));
        distance.into_iter().chain(angle).chain(self.cad.arguments()).collect()
    }

    /// The measurement behind the sums of a step.
    pub(super) fn step_job<'a>(
        &'a self,
        points: &'a [PathBuf],
        common: &Common,
    ) -> Result<inspecting::Job<'a>, Error> {
        // Nothing is judged here.
        let tolerance = Tolerance::symmetric(f64::INFINITY).map_err(|error| inspecting::usage(&error))?;
        let angle = self.max_angle.filter(|angle| *angle < 180.0).map(f64::to_radians);
        let options = InspectionOptions::new(tolerance)
            .with_max_distance(self.max_distance.unwrap_or(f64::INFINITY))
            .with_drop_beyond_boundary(true)
            .with_worst(0)
            .with_exact_limit(0);
        Ok(inspecting::Job {
            model: &self.model,
            cad: &self.cad,
            points,
            range: self.range.clone(),
            motion: self.init.as_deref().map_or(Motion::None, Motion::File),
            page: None,
            picture: 1,
            out: None,
            format: None,
            options: InspectionOptions { max_angle: angle, ..options },
            mode: "certified",
            drop_non_finite: false,
            scan: None,
            threads: common.threads,
            quiet: common.quiet,
        })
    }

    fn options(&self) -> Result<RegisterOptions<3>, Error> {
        let outliers = match (self.outliers, self.overlap) {
            (OutlierChoice::Trimmed, Some(overlap)) => Outliers::Trimmed { outliers: 1.0 - overlap },
            (OutlierChoice::Trimmed, None) => {
                return Err(Error::usage("--outliers trimmed needs a share", "add --overlap SHARE"));
            }
            (_, Some(_)) => return Err(Error::usage("--overlap has no effect", "add --outliers trimmed")),
            (OutlierChoice::Automatic, None) => Outliers::Automatic,
            (OutlierChoice::None, None) => Outliers::None,
        };
        let method = match self.method {
            MethodChoice::Adaptive => Method::Adaptive,
            MethodChoice::Point => Method::ICP,
            MethodChoice::Tangent => Method::TANGENT,
            MethodChoice::SquaredDistance => Method::Term(ErrorTerm::SquaredDistance),
            MethodChoice::Newton => Method::Newton,
            MethodChoice::Symmetric => Method::Symmetric,
            MethodChoice::Anderson => Method::AndersonPoint,
        };
        let any = |axes: fn(Lock) -> [bool; 3]| {
            [0, 1, 2].map(|axis| self.lock.iter().any(|lock| axes(*lock)[axis]))
        };
        let axes = Locks::<3>::default().axes;
        let locks = Locks::default()
            .with_frame(self.lock_origin.unwrap_or_default().into(), axes)
            .with_translations(any(|lock| lock.held().0))
            .with_rotations(any(|lock| lock.held().1));
        Ok(RegisterOptions::default()
            .with_method(method)
            .with_outliers(outliers)
            .with_locks(locks)
            .with_scale(self.scale)
            .with_max_iterations(usize::from(self.max_iterations)))
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args, common: &Common, report: &mut Report) -> Result<Outcome, Error> {
    if let Some(partial) = &args.partial {
        let job = args.step_job(std::slice::from_ref(&args.points), common)?;
        inspecting::run_partial_step(&job, args.step_arguments(), partial, report)?;
        let mut text = format!("{}: exact sums of one step\n", partial.display());
        // Writing to memory cannot fail.
        let _ = crate::report::summary::write_end(&mut text, report);
        return Ok(Outcome::new(text, true));
    }
    if args.range.is_some() || args.max_distance.is_some() {
        let what = "--points and --max-distance are for the sums of a step";
        return Err(Error::usage(what, "add --partial FILE, or leave them out"));
    }
    let writes = [&args.out, &args.transform, &args.report, &common.json].into_iter().any(Option::is_some);
    if !writes && !args.inspect {
        return Err(Error::usage(
            "nothing would be written",
            "add -o MOVED, --transform T.json, --report FILE, --json FILE or --inspect",
        ));
    }
    if args.inspect && [&args.model, &args.points].into_iter().any(|path| files::is_stream(path)) {
        return Err(Error::usage(
            "--inspect reads the files a second time, which standard input cannot be",
            "give files, or write the motion (--transform) and run `indgeo inspect`",
        ));
    }
    let options = args.options()?;
    let start = match (&args.init, args.start) {
        (Some(file), _) => Start::Poses(file),
        (None, StartChoice::Given) => Start::Given,
        // A search over all positions would not respect what is locked.
        (None, StartChoice::Auto) if options.locks.any() => Start::Given,
        (None, StartChoice::Auto) => Start::Auto,
        (None, StartChoice::Global) => Start::Global,
    };
    let job = Job {
        model: &args.model,
        cad: &args.cad,
        points: &args.points,
        sample: args.sample,
        out: args.out.as_deref(),
        format: args.format,
        transform: args.transform.as_deref(),
        page: args.report.as_deref().filter(|_| !args.inspect),
        start,
        options,
        feature_weight: args.feature_weight,
        max_angle: args.max_angle.filter(|angle| *angle < 180.0).map(f64::to_radians),
        needs_normals: args.method == MethodChoice::Symmetric,
        quiet: common.quiet,
    };
    let found = job::run(&job, report)?;
    let within = match args.tolerance {
        Some(tolerance) => inspect(args, common, tolerance, &found.pose, report)?,
        None => true,
    };
    let otherwise = if found.converged { "out_of_tolerance" } else { "not_converged" };
    Ok(Outcome { summary: report.summary(), converged: found.converged && within, otherwise })
}

/// Measures the moved points; whether they are within tolerance.
fn inspect(
    args: &Args,
    common: &Common,
    tolerance: f64,
    pose: &Pose<3>,
    report: &mut Report,
) -> Result<bool, Error> {
    let tolerance = Tolerance::symmetric(tolerance).map_err(|error| inspecting::usage(&error))?;
    let angle = args.max_angle.filter(|angle| *angle < 180.0).map(f64::to_radians);
    let job = inspecting::Job {
        model: &args.model,
        cad: &args.cad,
        points: std::slice::from_ref(&args.points),
        range: None,
        picture: inspecting::MOST_POINTS,
        motion: Motion::Known(Transform::of_pose(pose)),
        page: args.report.as_deref(),
        out: None,
        format: None,
        options: InspectionOptions { max_angle: angle, ..InspectionOptions::new(tolerance) },
        mode: "certified",
        drop_non_finite: true,
        scan: None,
        threads: common.threads,
        quiet: common.quiet,
    };
    let mut found = Report { command: "inspect", version: report.version, ..Report::default() };
    let inspection = inspecting::run(&job, &mut found)?;
    found.warnings.retain(|warning| !report.warnings.contains(warning));
    report.warnings.append(&mut found.warnings);
    found.outputs.drain(..).for_each(|output| report.add_output(output));
    let (own, more) = (&mut report.timings, &found.timings);
    for (stage, seconds) in [
        (&mut own.read, more.read),
        (&mut own.build, more.build),
        (&mut own.compute, more.compute),
        (&mut own.write, more.write),
    ] {
        *stage += seconds;
    }
    if let Some(results) = report.found_mut::<RegistrationResults>() {
        results.inspection = found.take_results::<InspectionResults>();
    }
    Ok(inspection.verdict.pass)
}
