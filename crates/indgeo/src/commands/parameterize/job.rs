//! The parameterisation of a cloud: read, parameterise, fit, write.

use crate::error::Error;
use crate::files;
use crate::fits::input::warn_incomplete;
use crate::fits::numbers::{FitVerdict, told};
use crate::input::between_vertices::between_vertices;
use crate::input::points::Points;
use crate::output::{self, Format, ParameterTable};
use crate::report::wording::{counted, not_finite};
use crate::report::{Input, Output, Report, Timings};
use crate::runtime::progress::Progress;
use industrial_geometry::cloud_param::{
    self, FinishOutcome, FinishReport, FitOptions, Parameterisation, ParameteriseOptions, ParameteriseReport,
    Stage, SurfaceDefects, SurfaceFit, finish_fit_with_progress, finish_options, fit_parameters,
    parameterise_with_progress,
};
use industrial_geometry::fit::{FitStep, Robust, Status, SurfaceCoverage, SurfaceDistances, measurable};
use industrial_geometry::inspection::{Rounding, percent_of_share};
use industrial_geometry::io::{Content, Model, WriteOptions};
use industrial_geometry::mesh::TriangleMesh;
use industrial_geometry::nurbs::BsplineSurface;
use industrial_geometry::nurbs::nalgebra::Vector3;
use serde::Serialize;
use std::path::Path;

/// What is to be done.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// File of the points.
    pub(crate) points: &'a Path,
    /// File of the base surface.
    pub(crate) base: Option<&'a Path>,
    /// File of the parameters.
    pub(crate) params: Option<&'a Path>,
    /// Its format, if not that of the extension.
    pub(crate) format: Option<Format>,
    /// File of the fitted surface.
    pub(crate) fitted: Option<&'a Path>,
    /// Options of the library.
    pub(crate) options: ParameteriseOptions,
    /// Options of the fit.
    pub(crate) fit: FitOptions,
    /// Whether the fit is finished by squared distance minimisation.
    pub(crate) finish: bool,
    /// Whether nobody wants to watch.
    pub(crate) quiet: bool,
}

/// What a parameterisation found.
#[derive(Debug, Serialize)]
pub(crate) struct ParameterResults {
    /// What the library reports.
    #[serde(flatten)]
    pub(crate) found: ParameteriseReport,
    /// Points on the triangles of a thinned mesh that were taken besides its vertices, the last of all points.
    pub(crate) points_added: usize,
    /// The fitted surface, if one was asked for.
    pub(crate) fit: Option<FitResults>,
}

/// A fitted surface in numbers.
#[derive(Debug, Serialize)]
pub(crate) struct FitResults {
    /// Control points in u (different ones) and v.
    pub(crate) control_points: [usize; 2],
    /// Root mean square orthogonal distance after the fit, after each correction and after the finish.
    pub(crate) history: Vec<f64>,
    /// Root mean square orthogonal distance at the end.
    pub(crate) rms: f64,
    /// Largest orthogonal distance at the end.
    pub(crate) max: f64,
    /// Points that count.
    pub(crate) points_used: usize,
    /// What is wrong with the surface.
    pub(crate) defects: SurfaceDefects,
    /// The least squares surface before the finish.
    pub(crate) least_squares: LeastSquares,
    /// How the finish went, if there was one.
    pub(crate) finish: Option<FinishReport>,
    /// How near the parts of the surface are to the points.
    pub(crate) coverage: SurfaceCoverage,
    /// Points that were left out, and are on no part of the surface.
    pub(crate) points_far: usize,
}

/// A least squares surface in numbers.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct LeastSquares {
    /// Root mean square orthogonal distance.
    pub(crate) rms: f64,
    /// Largest orthogonal distance.
    pub(crate) max: f64,
    /// What is wrong with it.
    pub(crate) defects: SurfaceDefects,
}

impl LeastSquares {
    pub(crate) fn of(fit: &SurfaceFit) -> Self {
        Self { rms: fit.rms, max: fit.max, defects: SurfaceDefects::of(&fit.surface, None) }
    }
}

/// Does the job and fills in the report; returns whether the surfaces are as they should be.
pub(crate) fn run(job: &Job<'_>, report: &mut Report) -> Result<FitVerdict, Error> {
    for path in [job.base, job.params, job.fitted].into_iter().flatten() {
        files::check_writable(path, &[job.points])?;
    }
    for path in [job.base, job.fitted].into_iter().flatten() {
        if !files::is_stream(path) && files::extension(path) != "json" {
            return Err(Error::content(
                path,
                "surfaces are written as NURBS JSON",
                "choose the extension .json",
            ));
        }
    }
    let format =
        job.params.map(|path| Format::of(path, job.format).map(|format| (path, format))).transpose()?;
    let mut timings = Timings::default();
    let points = Timings::measure(&mut timings.read, || Points::read(job.points, false, None))?;
    report.add_input(Input::new("points", job.points, &points.report));
    let warnings = points.report.warnings.iter().map(|w| format!("{}: {w}", job.points.display()));
    report.warnings.extend(warnings);
    let mut cloud = points.in_space(job.points)?;
    let mesh = TriangleMesh::new(points.positions.clone(), points.triangles.clone());
    let samples = mesh.map_or_else(|_| Vec::new(), |mesh| between_vertices(&mesh, job.points, report));
    cloud.extend(&samples);

    let progress = Progress::steps("parameterising", job.quiet);
    let tell = |stage: Stage| progress.report(stage as usize, Stage::Parameters as usize + 1);
    let failed = |error: cloud_param::Error| match error {
        cloud_param::Error::Option { name, value, allowed } => Error::option(name, value, allowed, HELP),
        other => Error::content(job.points, other.to_string(), ADVICE),
    };
    let found =
        Timings::measure(&mut timings.compute, || parameterise_with_progress(&cloud, &job.options, &tell))
            .map_err(failed)?;
    drop(progress);
    let fitted = match job.fitted {
        Some(_) => Some(Timings::measure(&mut timings.compute, || fit(job, &cloud, &found)).map_err(failed)?),
        None => None,
    };
    warn(job, &found.report, report);

    let mut seconds = 0.0;
    Timings::measure(&mut seconds, || -> Result<(), Error> {
        if let Some(path) = job.base {
            surface(path, &found.base, "base surface", report)?;
        }
        if let (Some(path), Some(fit)) = (job.fitted, &fitted) {
            surface(path, &fit.0.surface, "fitted surface", report)?;
        }
        if let Some((path, format)) = format {
            // Not of points that were added.
            let count = points.positions.len();
            let (feet, counts) = (&found.feet[..count], &found.counts[..count]);
            let written = output::write(
                path,
                format,
                &ParameterTable {
                    points: &points.positions,
                    point_names: points.names.as_ref(),
                    feet,
                    counts,
                },
            )?;
            let content = format!("{count} parameter pairs");
            report.warnings.extend(written.warnings);
            report.add_output(Output { path: path.to_path_buf(), bytes: written.bytes, content });
        }
        Ok(())
    })?;
    timings.write = seconds;
    report.timings = timings;
    let follows = found.is_converged();
    let left_out = found.report.strays + found.report.beyond_ends;
    let results = results(&cloud, found, samples.len(), fitted, job.fit).map_err(failed)?;
    if let Some(finish) = results.fit.as_ref().and_then(|fit| fit.finish.as_ref()) {
        kept(finish, report);
    }
    let folded = results.fit.as_ref().map_or(0, |fit| fit.defects.crossovers);
    if folded > 0 {
        report.warnings.push(format!(
            "the fitted surface folds in {}; try other numbers of --control-points, or fewer --corrections",
            counted(folded, "cell")
        ));
    }
    let mut incomplete = false;
    if let Some(fit) = &results.fit {
        incomplete = warn_incomplete(Some(&fit.coverage), report) || fit.points_far > 0;
        if fit.points_far > 0 {
            report.warnings.push(format!(
                "{}: {} are on no part of the fitted surface",
                job.points.display(),
                counted(fit.points_far, "point")
            ));
        }
    }
    // Without a fitted surface the parameters are the result, and every point is to have them.
    let incomplete = incomplete || results.fit.is_none() && left_out > 0;
    let verdict = FitVerdict::Good.without(!follows || folded > 0 || incomplete);
    let found = &results.found;
    report.count_points("points", found.dropped, found.used.saturating_sub(samples.len()));
    report.results = Some(Box::new(results));
    Ok(verdict)
}

const HELP: &str = "see `indgeo parameterize --help`";
const ADVICE: &str = "see `indgeo parameterize --help`, and check the file with `indgeo info`";

/// A fitted surface, what it was before the finish, and how that went.
type Fitted = (SurfaceFit, LeastSquares, Option<FinishReport>);

fn fit(
    job: &Job<'_>,
    cloud: &[Vector3<f64>],
    found: &Parameterisation,
) -> Result<Fitted, cloud_param::Error> {
    let fit = fit_parameters(cloud, &found.base, &found.feet, &found.counts, &job.fit)?;
    let least_squares = LeastSquares::of(&fit);
    if !job.finish {
        return Ok((fit, least_squares, None));
    }
    let progress = Progress::iterations("finishing", job.quiet);
    let options = finish_options(cloud.len());
    let tell = |step: &FitStep| told(&progress, step, options.fit.max_iterations);
    let (fit, finish) = finish_fit_with_progress(cloud, &found.counts, fit, &options, &tell)?;
    Ok((fit, least_squares, Some(finish)))
}

/// Says when a finish would have come nearer with more iterations.
fn unfinished(finish: &FinishReport, report: &mut Report) {
    let fit = &finish.minimisation.fit;
    if fit.status == Status::MaxIterations {
        report.warnings.push(format!(
            "the finish ended at its limit of {}, still coming nearer; `indgeo fit-surface --init FITTED.json` goes on",
            counted(fit.history.len(), "iteration")
        ));
    }
}

/// Says when a finish was not taken.
pub(crate) fn kept(finish: &FinishReport, report: &mut Report) {
    let why = match finish.outcome {
        FinishOutcome::KeptSinceFolded => {
            format!("it would fold in {}", counted(finish.defects[2].crossovers, "cell"))
        }
        FinishOutcome::KeptSinceNoNearer => {
            format!("the rms distance would be {:.6e} instead of {:.6e}", finish.rms[1], finish.rms[0])
        }
        FinishOutcome::Cancelled => "it was interrupted".to_owned(),
        _ => return unfinished(finish, report),
    };
    report.warnings.push(format!(
        "the least squares surface was kept as it is, since the finish made it no better: {why}; more control points may help"
    ));
}

fn results(
    cloud: &[Vector3<f64>],
    found: Parameterisation,
    added: usize,
    fitted: Option<Fitted>,
    options: FitOptions,
) -> Result<ParameterResults, cloud_param::Error> {
    let judged = |(fit, least_squares, finish): Fitted| -> Result<FitResults, cloud_param::Error> {
        let all = SurfaceDistances::of(&fit.surface, cloud, Robust::None)?;
        let belongs = measurable(cloud)?;
        let kept: Vec<Vector3<f64>> =
            cloud.iter().zip(belongs).filter(|(_, b)| *b).map(|(p, _)| *p).collect();
        let noise = SurfaceCoverage::noise_of(&all.distances);
        let coverage = SurfaceCoverage::of_surface(&fit.surface, &kept, noise, None)?;
        let is_far = |i: &usize| !found.counts[*i] && all.distances[*i] > coverage.limit;
        Ok(FitResults {
            control_points: options.control_points,
            defects: SurfaceDefects::of(&fit.surface, None),
            history: fit.history,
            rms: fit.rms,
            max: all.max,
            points_used: fit.used,
            least_squares,
            finish,
            points_far: (0..cloud.len()).filter(is_far).count(),
            coverage,
        })
    };
    let fit = fitted.map(judged).transpose()?;
    Ok(ParameterResults { found: found.report, points_added: added, fit })
}

fn surface(path: &Path, surface: &BsplineSurface, content: &str, report: &mut Report) -> Result<(), Error> {
    let mut model = Model::default();
    model.push(surface.clone(), Some(content.to_owned()));
    let written = files::write_content(path, &Content::Nurbs(model), &WriteOptions::default())?;
    report.add_output(Output { path: path.to_path_buf(), bytes: written.bytes, content: content.to_owned() });
    Ok(())
}

fn warn(job: &Job<'_>, found: &ParameteriseReport, report: &mut Report) {
    let name = job.points.display();
    let mut say = |count: usize, what: &str| {
        if count > 0 {
            report.warnings.push(format!("{name}: {count} of {} {what}", counted(found.points, "point")));
        }
    };
    say(found.strays, "apart from the others: not followed by the base surface, not used");
    say(found.beyond_ends, "beyond the ends of the base surface: not used for a fit");
    if found.dropped > 0 {
        report.warnings.push(not_finite(job.points, found.dropped, found.points, "without parameters"));
    }
    if !found.defects.is_none() {
        report.warnings.push(format!(
            "{name}: the base surface has {} and {}; parameters are wrong there: try a coarser --grid, \
             another --axis or --shape",
            counted(found.defects.self_loops, "self-loop"),
            counted(found.defects.crossovers, "crossover")
        ));
    }
    if found.rms > found.spacing {
        report.warnings.push(format!(
            "{name}: the points are {:.3e} from the base surface on average, farther than they are from each other ({:.3e}): it does \
             not follow what is finer than its {} x {} samples; a fit with enough control points comes nearer, or try another --grid",
            found.rms, found.spacing, found.grid[0], found.grid[1]
        ));
    }
    if found.unsupported > 0.02 {
        report.warnings.push(format!(
            "{name}: {} of the base surface lie over holes in the points",
            percent_of_share(found.unsupported, Rounding::Up)
        ));
    }
}
