//! The machine-readable report of a command (`--json`).

use crate::aligning::AlignmentResults;
use crate::commands::Outcome;
use crate::commands::convert::ConvertResults;
use crate::contour::ContourResults;
use crate::error::Error;
use crate::field::FieldResults;
use crate::fitting_curve::CurveResults;
use crate::fitting_ruled::RuledResults;
use crate::fitting_subdivision::SubdivisionResults;
use crate::fitting_surface::SurfaceResults;
use crate::inspecting::InspectionResults;
use crate::interrupt;
use crate::on_surface::geodesic::GeodesicResults;
use crate::on_surface::morphology::MorphologyResults;
use crate::on_surface::parameters::PatchResults;
use crate::parameterizing::ParameterResults;
use crate::registration_report::RegistrationResults;
use crate::registration_step::Step;
use crate::segmenting::SegmentationResults;
use crate::selftest::Check;
use crate::views_report::ViewsResults;
use industrial_geometry::inspection::Statistics;
use industrial_geometry::io::ReadReport;
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What a command was given, did and found.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Report {
    /// Name of the command.
    pub(crate) command: &'static str,
    /// Version of the program.
    pub(crate) version: &'static str,
    /// `done` (exit status 0); `out_of_tolerance`, `not_converged`, `not_proven`, `underdetermined`, `defective` or `failed` (1); `error` (2);
    /// `cancelled` (130).
    pub(crate) status: &'static str,
    /// Exit status of the process.
    pub(crate) exit_code: u8,
    /// The message, on errors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) error: Option<String>,
    /// Files that were read.
    pub(crate) inputs: Vec<Input>,
    /// The model that was projected onto.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) model: Option<ModelSummary>,
    /// Options with their values, the defaults included.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) options: Option<Options>,
    /// Files that were written.
    pub(crate) outputs: Vec<Output>,
    /// Seconds per stage, without the start of the program.
    pub(crate) timings: Timings,
    /// Points projected per second of computation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) points_per_second: Option<f64>,
    /// What the command found; `null` where it did not come to an end.
    pub(crate) results: Option<Results>,
    /// What the user should know.
    pub(crate) warnings: Vec<String>,
    /// Whether nothing is said of the time it took.
    #[serde(skip)]
    pub(crate) no_timings: bool,
    /// Those of them that were printed already.
    #[serde(skip)]
    pub(crate) told: Vec<String>,
}

/// Writes a path as text; what is not UTF-8 in it is replaced, since a report without it would be worse.
pub(crate) fn lossy<S: serde::Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&path.to_string_lossy())
}

impl Report {
    /// The report of a command that begins.
    pub(crate) fn of_command(command: &'static str) -> Self {
        Self { command, version: env!("CARGO_PKG_VERSION"), ..Self::default() }
    }

    /// Says how the command ended.
    pub(crate) fn end(&mut self, ended: &Result<Outcome, Error>) {
        (self.status, self.exit_code) = match ended {
            Ok(Outcome { converged: true, .. }) => ("done", 0),
            Ok(Outcome { otherwise, .. }) => (*otherwise, 1),
            Err(_) => ("error", 2),
        };
        self.error = ended.as_ref().err().map(ToString::to_string);
        if self.no_timings {
            (self.timings, self.points_per_second) = (Timings::default(), None);
        }
    }

    /// Adds a warning that whoever waits for the result wants to see before: it is printed now, and not once more at the end.
    pub(crate) fn warn_now(&mut self, warning: Option<String>, quiet: bool) {
        let Some(warning) = warning else { return };
        if quiet {
            self.warnings.push(warning);
            return;
        }
        let _ = writeln!(std::io::stderr(), "warning: {warning}");
        self.told.push(warning.clone());
        self.warnings.push(warning);
    }

    /// Warnings that were not printed yet.
    pub(crate) fn untold(&self) -> Vec<String> {
        self.warnings.iter().filter(|warning| !self.told.contains(warning)).cloned().collect()
    }

    /// Adds a file that was read.
    pub(crate) fn add_input(&mut self, input: Input) {
        self.inputs.push(input);
        interrupt::note(self);
    }

    /// Adds a file that was written.
    pub(crate) fn add_output(&mut self, output: Output) {
        self.outputs.push(output);
        interrupt::note(self);
    }

    /// Says how many points of the inputs with this role were dropped, and how many count for the result.
    pub(crate) fn count_points(&mut self, role: &str, dropped: usize, used: usize) {
        for input in self.inputs.iter_mut().filter(|input| input.role == role) {
            input.count(dropped, used);
        }
    }

    /// The report of a command that has not ended.
    pub(crate) fn so_far(&self) -> Self {
        Self {
            command: self.command,
            version: self.version,
            status: self.status,
            exit_code: self.exit_code,
            error: self.error.clone(),
            inputs: self.inputs.clone(),
            model: self.model.clone(),
            options: self.options.clone(),
            outputs: self.outputs.clone(),
            timings: self.timings,
            points_per_second: self.points_per_second,
            results: None,
            warnings: self.warnings.clone(),
            no_timings: self.no_timings,
            told: Vec::new(),
        }
    }
}

/// A file that was read.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Input {
    /// `model`, `points`, `init`, `view`, `targets` or `file`.
    pub(crate) role: &'static str,
    /// The path as given.
    #[serde(serialize_with = "lossy")]
    pub(crate) path: PathBuf,
    /// What was read, dropped and left.
    #[serde(flatten)]
    pub(crate) read: ReadSummary,
}

/// Counts of a file that was read.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct ReadSummary {
    /// Format, recognised by content.
    pub(crate) format: String,
    /// Points in the file.
    pub(crate) points_read: usize,
    /// Points that do not count because they are not finite.
    pub(crate) points_dropped: usize,
    /// Points that count for the result: neither dropped nor outliers.
    pub(crate) points_used: usize,
    /// Points with a coordinate that is NaN or infinite, dropped or not.
    pub(crate) non_finite: usize,
    /// Triangles in the file.
    pub(crate) triangles: usize,
    /// Curves and surfaces in the file.
    pub(crate) shapes: usize,
}

impl Input {
    /// How many points were dropped, and how many count for the result: of the file, which has none where they were taken from
    /// its shapes.
    pub(crate) fn count(&mut self, dropped: usize, used: usize) {
        let read = &mut self.read;
        read.points_dropped = dropped.min(read.points_read);
        read.points_used = used.min(read.points_read - read.points_dropped);
    }

    /// The input at `path` that holds only shapes.
    pub(crate) fn of_shapes(role: &'static str, path: &Path, format: &str, shapes: usize) -> Self {
        let read = ReadSummary {
            format: format.to_owned(),
            points_read: 0,
            points_dropped: 0,
            points_used: 0,
            non_finite: 0,
            triangles: 0,
            shapes,
        };
        Self { role, path: path.to_path_buf(), read }
    }

    /// The input at `path`, read with this report.
    pub(crate) fn new(role: &'static str, path: &Path, report: &ReadReport) -> Self {
        let read = ReadSummary {
            format: report.format.extension().to_owned(),
            points_read: report.points,
            points_dropped: report.non_finite,
            points_used: report.points.saturating_sub(report.non_finite),
            non_finite: report.non_finite,
            triangles: report.triangles,
            shapes: report.shapes,
        };
        Self { role, path: path.to_path_buf(), read }
    }
}

/// A file that was written.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Output {
    /// The path as given.
    #[serde(serialize_with = "lossy")]
    pub(crate) path: PathBuf,
    /// Its size.
    pub(crate) bytes: u64,
    /// What it holds.
    pub(crate) content: String,
}

/// What was projected onto.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ModelSummary {
    /// `nurbs`, `mesh` or `cad`.
    pub(crate) kind: &'static str,
    /// Unit of length that a CAD file states.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) unit: Option<String>,
    /// Unit in which the points are taken beside a CAD model: their files state none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) points_unit: Option<String>,
    /// Dimension of the space it lies in.
    pub(crate) dimension: usize,
    /// Number of curves, surfaces and faces (1 for a mesh).
    pub(crate) shapes: usize,
    /// Number of Bézier patches and pieces, of faces or of triangles, that are searched.
    pub(crate) patches: usize,
    /// Whether distances have a sign.
    pub(crate) signed: bool,
}

/// Options of a projection.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Options {
    /// `certified`, `fast` or `local`.
    pub(crate) mode: &'static str,
    /// Allowed gap relative to the distance.
    pub(crate) relative_gap: f64,
    /// Number of threads asked for; `null` for one per core.
    pub(crate) threads: Option<u16>,
    /// The matrix by rows that was applied to the points before anything else.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) transform: Option<[[f64; 4]; 4]>,
}

/// Seconds per stage.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(crate) struct Timings {
    /// Reading and parsing files.
    pub(crate) read: f64,
    /// Preparing the model.
    pub(crate) build: f64,
    /// Computing, sums and statistics included.
    pub(crate) compute: f64,
    /// Formatting and writing files.
    pub(crate) write: f64,
}

impl Timings {
    /// Runs `work` and adds the seconds it took.
    pub(crate) fn measure<T>(stage: &mut f64, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let out = work();
        *stage += start.elapsed().as_secs_f64();
        out
    }
}

/// What a command found.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub(crate) enum Results {
    /// Of a projection.
    Projection(Box<ProjectionResults>),
    /// Of an inspection.
    Inspection(Box<InspectionResults>),
    /// Of a registration.
    Registration(Box<RegistrationResults>),
    /// Of one step of a registration, from sums of parts.
    Step(Box<Step>),
    /// Of an alignment by targets.
    Alignment(Box<AlignmentResults>),
    /// Of a registration of many views.
    Views(Box<ViewsResults>),
    /// Of a fit of a curve.
    Curve(Box<CurveResults>),
    /// Of a parameterisation.
    Parameters(Box<ParameterResults>),
    /// Of a fit of a surface.
    Surface(Box<SurfaceResults>),
    /// Of a fit of a ruled surface.
    Ruled(Box<RuledResults>),
    /// Of a fit of a subdivision surface.
    Subdivision(Box<SubdivisionResults>),
    /// Of contours.
    Contours(Box<ContourResults>),
    /// Of distances on a grid.
    Field(Box<FieldResults>),
    /// Of distances and curves on a surface.
    Geodesic(Box<GeodesicResults>),
    /// Of operations on regions of a mesh.
    Morphology(Box<MorphologyResults>),
    /// Of parameters of a patch of a mesh.
    Patch(Box<PatchResults>),
    /// Of surfaces by type.
    Segmentation(Box<SegmentationResults>),
    /// Of `convert`.
    Converted(ConvertResults),
    /// Of `selftest`.
    Checks(Vec<Check>),
    /// Of `info`.
    Files(Vec<serde_json::Value>),
}

/// Counts and distances of a projection.
#[derive(Debug, Serialize)]
pub(crate) struct ProjectionResults {
    /// Number of rows of the result.
    pub(crate) points: usize,
    /// Points without a footpoint because they are not finite.
    pub(crate) points_dropped: usize,
    /// Points with a footpoint.
    pub(crate) points_used: usize,
    /// Root mean square distance.
    pub(crate) rms: Option<f64>,
    /// Largest distance, without its sign.
    pub(crate) max: Option<f64>,
    /// The point that has it, from 0.
    pub(crate) max_index: Option<usize>,
    /// Columns of the result.
    pub(crate) columns: Vec<&'static str>,
    /// Number of points per status.
    pub(crate) status: BTreeMap<&'static str, usize>,
    /// Number of points per location of the footpoint.
    pub(crate) location: BTreeMap<&'static str, usize>,
    /// Number of points per multiplicity of the footpoint.
    pub(crate) multiplicity: BTreeMap<String, usize>,
    /// Distribution of the distances, as signed as the model gives them.
    pub(crate) distance: Option<Statistics>,
    /// The point with the largest absolute distance.
    pub(crate) worst: Option<Worst>,
    /// Largest certified gap between a distance and its lower bound; `null` in uncertified modes.
    pub(crate) largest_gap: Option<f64>,
    /// Points whose gap is more than 1e-7 of the diagonal of a CAD model: their feet are next to edges that lie beside their faces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) wide_gaps: Option<usize>,
    /// Points of which it is not known on which side of a CAD model they lie; their distances have no sign.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) undecided_sides: Option<usize>,
    /// Curves and surfaces that are nearest to at least one point.
    pub(crate) shapes: Vec<ShapeResults>,
}

/// The point that is farthest from the model.
#[derive(Debug, Serialize)]
pub(crate) struct Worst {
    /// Index of the row, from 0.
    pub(crate) index: usize,
    /// The point.
    pub(crate) point: [f64; 3],
    /// Its distance.
    pub(crate) distance: f64,
    /// Its name, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) name: Option<String>,
}

/// The points whose footpoints lie on one shape.
#[derive(Debug, Serialize)]
pub(crate) struct ShapeResults {
    /// Index of the shape in the model.
    pub(crate) index: u32,
    /// `surface`, `curve` or `mesh`.
    pub(crate) kind: &'static str,
    /// Its name, if it has one.
    pub(crate) name: Option<String>,
    /// Points that lie beyond its boundary: their footpoints are on it.
    pub(crate) on_boundary: usize,
    /// Distances of all points with a footpoint here.
    pub(crate) distance: Statistics,
}
