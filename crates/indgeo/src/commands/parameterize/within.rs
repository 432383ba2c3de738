//! The dynamic base surface within four boundary curves: read, compute, write.

use crate::error::Error;
use crate::files;
use crate::fits::boundary::Boundary;
use crate::fits::input::check_paths;
use crate::fits::numbers::FitVerdict;
use crate::input::points::Points;
use crate::output::{self, Format, ParameterTable};
use crate::report::summary::{plain, write_end};
use crate::report::wording::{counted, not_finite};
use crate::report::{Input, Output, Report, Results, Timings};
use industrial_geometry::cloud_param::{
    self, Neighbourhood, RefineOptions, RefineStep, SurfaceDefects, dynamic_base_surface,
};
use industrial_geometry::footpoint::SurfaceProjector;
use industrial_geometry::io::{Content, Model, WriteOptions};
use industrial_geometry::nurbs::nalgebra::Vector3;
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;

/// Samples of the base surface in each direction that nobody chose: a share of the root of the number of points, and limits.
const SHARE: f64 = 0.5;
const LIMITS: [usize; 2] = [8, 100];

/// What is to be done.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// File of the points.
    pub(crate) points: &'a Path,
    /// File of the curves.
    pub(crate) boundary: &'a Path,
    /// File of the base surface.
    pub(crate) base: Option<&'a Path>,
    /// File of the parameters.
    pub(crate) params: Option<&'a Path>,
    /// Its format, if not that of the extension.
    pub(crate) format: Option<Format>,
    /// Samples of the base surface.
    pub(crate) grid: Option<[usize; 2]>,
    pub(crate) options: RefineOptions,
}

/// What was found.
#[derive(Debug, Serialize)]
pub(crate) struct WithinResults {
    /// Samples of the base surface.
    pub(crate) grid: [usize; 2],
    pub(crate) points: usize,
    /// Points that are not finite.
    pub(crate) points_dropped: usize,
    /// Distances of the points from the base surface.
    pub(crate) rms: f64,
    pub(crate) max: f64,
    /// Mean distance of neighbouring points.
    pub(crate) spacing: f64,
    /// How the base surface was drawn to the points, and which of these states it is.
    pub(crate) refine_history: Vec<RefineStep>,
    pub(crate) kept: usize,
    /// Share of the samples without a point near them.
    pub(crate) unsupported: f64,
    /// What is wrong with the base surface.
    pub(crate) defects: SurfaceDefects,
}

/// Does the job and fills in the report; returns whether the base surface follows the points and does not fold.
pub(crate) fn run(job: &Job<'_>, report: &mut Report) -> Result<FitVerdict, Error> {
    let outputs: Vec<&Path> = [job.base, job.params].into_iter().flatten().collect();
    check_paths(&[job.points, job.boundary], &outputs)?;
    let format =
        job.params.map(|path| Format::of(path, job.format).map(|format| (path, format))).transpose()?;
    let mut timings = Timings::default();
    let points = Timings::measure(&mut timings.read, || Points::read(job.points, false, None))?;
    report.add_input(Input::new("points", job.points, &points.report));
    let warnings = points.report.warnings.iter().map(|w| format!("{}: {w}", job.points.display()));
    report.warnings.extend(warnings);
    let cloud = points.in_space(job.points)?;
    let boundary = Boundary::read(job.boundary, report)?;
    let finite: Vec<Vector3<f64>> =
        cloud.iter().filter(|p| p.iter().all(|c| c.is_finite())).copied().collect();
    let failed = |error: cloud_param::Error| match error {
        cloud_param::Error::Option { name, value, allowed } => Error::option(name, value, allowed, HELP),
        other => Error::content(job.points, other.to_string(), HELP),
    };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the root of a count")]
    let usual = ((SHARE * (finite.len() as f64).sqrt()) as usize).clamp(LIMITS[0], LIMITS[1]);
    let grid = job.grid.unwrap_or([usual; 2]);
    let mut compute = 0.0;
    let found = Timings::measure(&mut compute, || -> Result<_, cloud_param::Error> {
        let around = Neighbourhood::new(&finite)?;
        let (base, refinement) =
            dynamic_base_surface(&around, &boundary.curves, boundary.slack, grid, &job.options)?;
        let feet = SurfaceProjector::new(&base).project_all(&cloud);
        Ok((base, refinement, feet, around.pitch()))
    });
    timings.compute = compute;
    let (base, refinement, feet, spacing) = found.map_err(failed)?;
    let distances: Vec<f64> =
        feet.iter().map(|foot| foot.signed_distance.abs()).filter(|d| d.is_finite()).collect();
    let max = distances.iter().copied().fold(0.0, f64::max);
    let rms = (distances.iter().map(|d| d * d).sum::<f64>() / distances.len().max(1) as f64).sqrt();
    let dropped = cloud.len() - finite.len();
    if dropped > 0 {
        report.warnings.push(not_finite(job.points, dropped, cloud.len(), "without parameters"));
    }
    let mut write = 0.0;
    Timings::measure(&mut write, || -> Result<(), Error> {
        if let Some(path) = job.base {
            let mut model = Model::default();
            model.push(base.clone(), Some("base surface".to_owned()));
            let written = files::write_content(path, &Content::Nurbs(model), &WriteOptions::default())?;
            report.add_output(Output {
                path: path.to_path_buf(),
                bytes: written.bytes,
                content: "base surface".to_owned(),
            });
        }
        if let Some((path, format)) = format {
            let counts: Vec<bool> = feet.iter().map(|foot| foot.status.is_converged()).collect();
            let table = ParameterTable {
                points: &points.positions,
                point_names: points.names.as_ref(),
                feet: &feet,
                counts: &counts,
            };
            let written = output::write(path, format, &table)?;
            report.warnings.extend(written.warnings);
            let content = format!("{} parameter pairs", cloud.len());
            report.add_output(Output { path: path.to_path_buf(), bytes: written.bytes, content });
        }
        Ok(())
    })?;
    timings.write = write;
    report.timings = timings;
    let defects = refinement.history[refinement.kept].defects;
    if !defects.is_none() {
        report.warnings.push(format!(
            "the base surface has {} and {}: the Coons patch of the curves is too far from the points; give curves nearer to them, or a \
             coarser --grid",
            counted(defects.self_loops, "self-loop"),
            counted(defects.crossovers, "crossover")
        ));
    }
    let apart = rms > spacing;
    if apart {
        report.warnings.push(format!(
            "{}: the points are {rms:.3e} from the base surface on average, farther than they are from each other ({spacing:.3e}); try a \
             finer --grid",
            job.points.display()
        ));
    }
    report.count_points("points", dropped, finite.len());
    let verdict = FitVerdict::Good.without(apart || !defects.is_none());
    report.results = Some(Box::new(WithinResults {
        grid,
        points: cloud.len(),
        points_dropped: dropped,
        rms,
        max,
        spacing,
        refine_history: refinement.history,
        kept: refinement.kept,
        unsupported: refinement.unsupported,
        defects,
    }));
    Ok(verdict)
}

const HELP: &str = "see `indgeo parameterize --help`";

impl Results for WithinResults {
    fn summarise(&self, text: &mut String, report: &Report) -> std::fmt::Result {
        let [m, n] = self.grid;
        writeln!(text, "base surface of {m} × {n} samples within four boundary curves")?;
        writeln!(text, "  distance  rms {}  max {}", plain(self.rms), plain(self.max))?;
        let steps = self.refine_history.len().saturating_sub(1);
        let defects = self.defects;
        writeln!(
            text,
            "  drawn to the points in {}, {}",
            counted(steps, "step"),
            counted(defects.crossovers, "crossover")
        )?;
        write_end(text, report)
    }
}
