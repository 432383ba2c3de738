//! The machine-readable report of a command (`--json`).

mod outcome;
pub(crate) mod summary;
pub(crate) mod wording;
pub(crate) mod write;

pub(crate) use outcome::Outcome;

use crate::error::Error;
use industrial_geometry::io::ReadReport;
use serde::Serialize;
use std::any::Any;
use std::fmt::Debug;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
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
    pub(crate) results: Option<Box<dyn Results>>,
    /// What the user should know.
    pub(crate) warnings: Vec<String>,
    /// Whether nothing is said of the time it took.
    #[serde(skip)]
    pub(crate) no_timings: bool,
    /// Those of them that were printed already.
    #[serde(skip)]
    pub(crate) told: Vec<String>,
}

/// Called with the report when files were read or written.
static OBSERVER: OnceLock<fn(&Report)> = OnceLock::new();

/// From now on `observer` is called with a report whenever files were read or written; the first one stays.
pub(crate) fn observe(observer: fn(&Report)) {
    let _ = OBSERVER.set(observer);
}

fn notify(report: &Report) {
    if let Some(observer) = OBSERVER.get() {
        observer(report);
    }
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

    /// The results, if they are of this type.
    pub(crate) fn found<T: Results>(&self) -> Option<&T> {
        let results: &dyn Any = self.results.as_deref()?;
        results.downcast_ref()
    }

    /// The same, to be changed.
    pub(crate) fn found_mut<T: Results>(&mut self) -> Option<&mut T> {
        let results: &mut dyn Any = self.results.as_deref_mut()?;
        results.downcast_mut()
    }

    /// Takes the results out of the report, if they are of this type.
    pub(crate) fn take_results<T: Results>(self) -> Option<Box<T>> {
        let results: Box<dyn Any> = self.results?;
        results.downcast().ok()
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
        notify(self);
    }

    /// Adds a file that was written.
    pub(crate) fn add_output(&mut self, output: Output) {
        self.outputs.push(output);
        notify(self);
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

/// The results of a command.
pub(crate) trait Results: erased_serde::Serialize + Debug + Send + Any {
    /// Writes a few lines about the results for a person; nothing by default.
    ///
    /// # Errors
    /// Those of the writer.
    fn summarise(&self, _text: &mut String, _report: &Report) -> std::fmt::Result {
        Ok(())
    }
}

erased_serde::serialize_trait_object!(Results);
