//! The fit of a surface: read, fit, write.

use crate::commands::fit_surface::edges::{EdgeResults, Edges};
use crate::commands::fit_surface::judgement::Judgement;
use crate::commands::fit_surface::start::{Refusal, Start, from_cloud};
use crate::error::Error;
use crate::fits::boundary::Boundary;
use crate::fits::input::{
    Scan, check_paths, put_model, start_surface, warn_dropped, warn_incomplete, warn_undetermined,
};
use crate::fits::numbers::{FitNumbers, FitVerdict, Within, told};
use crate::fits::page::{
    FitPage, IsoCurves, SurfaceSections, coverage_facts, number_facts, surface_sections,
};
use crate::input::between_vertices::between_vertices;
use crate::output::cad::CadArgs;
use crate::report::wording::counted;
use crate::report::{Report, Timings};
use crate::runtime::progress::Progress;
use industrial_geometry::cloud_param::Error as ParameterError;
use industrial_geometry::fit::{
    BaseShape, Error as FitError, FitStep, Folds, SurfaceCoverage, SurfaceDistances, SurfaceOptions,
    SurfaceReport, fit_surface_with_progress, with_controls,
};
use industrial_geometry::io::Model;
use industrial_geometry::nurbs::nalgebra::Vector3;
use industrial_geometry::nurbs::{BsplineSurface, Direction, TrimLoops};
use serde::Serialize;
use std::path::Path;

/// What is to be done.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// File of the points, or of the model.
    pub(crate) points: &'a Path,
    /// Most points that are used.
    pub(crate) sample: u32,
    /// File of the surface to start from.
    pub(crate) init: Option<&'a Path>,
    /// Boundary curves and neighbours.
    pub(crate) edges: Edges<'a>,
    /// Control points that the surface shall have, if that was chosen.
    pub(crate) controls: Option<[usize; 2]>,
    /// File of the surface.
    pub(crate) out: Option<&'a Path>,
    /// File of the page.
    pub(crate) page: Option<&'a Path>,
    /// Name and unit of the result.
    pub(crate) cad: &'a CadArgs,
    /// Options of the library.
    pub(crate) options: SurfaceOptions,
    /// Whether nobody wants to watch.
    pub(crate) quiet: bool,
}

/// What a fit of a surface found.
#[derive(Debug, Serialize)]
pub(crate) struct SurfaceResults {
    /// The fit.
    #[serde(flatten)]
    pub(crate) fit: FitNumbers,
    /// What gave the first parameters.
    pub(crate) base: Option<BaseShape>,
    /// Where it began, if no surface was given.
    pub(crate) start: Option<Start>,
    /// Control points in u and v that are not repetitions.
    pub(crate) control_points: [usize; 2],
    /// Surfaces that were fitted: one to begin with, and one for each change of the knots.
    pub(crate) runs: usize,
    /// How the boundary curves and neighbours are met, if there are some.
    pub(crate) edges: Option<EdgeResults>,
    /// Cells in which the surface folds back on itself.
    pub(crate) folds: Folds,
    /// How near the parts of the surface, as far as the data go, are to the points.
    pub(crate) coverage: Option<SurfaceCoverage>,
    /// Loops that bound the surface where the data end; 0 where it is whole.
    pub(crate) trim_loops: usize,
}

/// Does the job and fills in the report; returns whether the surface is what was asked for.
pub(crate) fn run(job: &Job<'_>, report: &mut Report) -> Result<FitVerdict, Error> {
    let inputs: Vec<&Path> = std::iter::once(job.points).chain(job.init).chain(job.edges.inputs()).collect();
    check_paths(&inputs, &job.outputs())?;
    let Scan { mut points, mesh, .. } = Scan::read(job.points, false, job.sample, report)?;
    let samples = mesh.map_or_else(Vec::new, |mesh| between_vertices(&mesh, job.points, report));
    points.extend(&samples);
    let start = job.init.map(|path| start_surface(path, report)).transpose()?;
    let given = job.edges.read(report)?;
    let start = match &given.boundary {
        Some(boundary) => Some(within(job, boundary)?),
        None => start,
    };
    let progress = Progress::iterations("fitting", job.quiet);
    let most = job.options.fit.max_iterations;
    let tell = |step: &FitStep| told(&progress, step, most);
    let mut from = None;
    let all = &points;
    let fit_from = |start: BsplineSurface, options: &SurfaceOptions| {
        let finite: Vec<_> = all.iter().filter(|p| p.iter().all(|c| c.is_finite())).copied().collect();
        let mut found = fit_surface_with_progress(&finite, start, options, &tell).map_err(Refusal::Fit)?;
        found.report.dropped = all.len() - finite.len();
        Ok((found.surface, found.report))
    };
    let of_cloud = || from_cloud(all, &job.options, job.controls.is_some(), &tell);
    let mut imposed = None;
    let found = if given.is_empty() {
        Timings::measure(&mut report.timings.compute, || match start {
            Some(start) => with_asked(job, start).and_then(|start| fit_from(start, &job.options)),
            None => of_cloud().map(|(surface, fitted, start)| {
                from = Some(start);
                (surface, fitted)
            }),
        })
    } else {
        let start = match start {
            Some(start) => with_asked(job, start),
            // The surface through the points is near enough to find its neighbours.
            None => Timings::measure(&mut report.timings.compute, of_cloud).map(|(surface, ..)| surface),
        };
        let start = start.map_err(|refusal| told_refusal(job, refusal))?;
        let made = job.edges.imposed(&given, start, report)?;
        let options = job.options.with_held(made.held);
        let start = made.surface.clone();
        imposed = Some(made);
        Timings::measure(&mut report.timings.compute, || fit_from(start, &options))
    };
    drop(progress);
    let (surface, fitted) = found.map_err(|refusal| told_refusal(job, refusal))?;
    warn_dropped(job.points, fitted.dropped, points.len(), report);
    warn_undetermined(job.points, points.len() - fitted.dropped, fitted.controls, report);
    if let Some(start) = &from {
        start.warn(job.points, report);
    }
    put_surface(job, &surface, &fitted, report)?;
    let judgement = match &from {
        Some(start) => start.judgement(),
        None => {
            let all = SurfaceDistances::of(&surface, &points, job.options.fit.robust);
            let all = all.map_err(|error| refused(job, &error))?;
            let judged = |coverage: &SurfaceCoverage| {
                Judgement::of(&points, &all, coverage, job.options.abs_tolerance, job.options.fit.robust)
            };
            fitted.coverage.as_ref().map(judged).unwrap_or_default()
        }
    };
    let unmet = judgement.warn(job.points, fitted.fit.rms, report);
    let incomplete = warn_incomplete(fitted.coverage.as_ref(), report);
    let edges = imposed.map(|imposed| job.edges.measured(&given, &imposed, &surface, report));
    let (edges, open) = edges.map_or((None, false), |(results, open)| (Some(results), open));
    let doubtful = from.as_ref().is_some_and(|start| start.doubtful);
    let faults = unmet || doubtful || incomplete || open || fitted.folds.count() > 0;
    let within = Within {
        tolerance: job.options.abs_tolerance,
        share: fitted.share_within,
        holds: fitted.within_tolerance,
    };
    let fit = FitNumbers::new(fitted.fit, fitted.dropped, samples.len(), within);
    report.count_points("points", fit.points_dropped, fit.points_used.saturating_sub(samples.len()));
    let verdict = fit.verdict().without(faults);
    let results = SurfaceResults {
        fit,
        base: fitted.base,
        start: from,
        control_points: fitted.controls,
        runs: fitted.runs,
        edges,
        folds: fitted.folds,
        coverage: fitted.coverage,
        trim_loops: fitted.trim.as_ref().map_or(0, |trim| trim.loops().len()),
    };
    put_page(job, &points, (&surface, fitted.trim.as_ref()), &results, verdict, report)?;
    report.results = Some(Box::new(results));
    Ok(verdict)
}

/// Fewest control points in each direction of a surface within boundary curves, if none were chosen.
const WITHIN: usize = 12;

/// The Coons patch of boundary curves.
fn within(job: &Job<'_>, boundary: &Boundary) -> Result<BsplineSurface, Error> {
    let failed = |error: String| {
        Error::content(
            job.edges.boundary.unwrap_or(job.points),
            error,
            "give curves that meet at four corners",
        )
    };
    let coons = boundary.curves.coons(boundary.slack).map_err(|error| failed(error.to_string()))?;
    // At least bicubic, so that the inside can bend.
    let mut surface = coons;
    for (direction, degree) in [(Direction::U, surface.degree_u()), (Direction::V, surface.degree_v())] {
        surface = surface
            .elevated(direction, 3usize.saturating_sub(degree))
            .map_err(|error| failed(error.to_string()))?;
    }
    let has = [surface.knots_u().distinct_count(), surface.knots_v().distinct_count()];
    let wanted = job.controls.unwrap_or([WITHIN; 2]);
    let wanted = [0, 1].map(|k| if job.controls.is_some() { wanted[k] } else { wanted[k].max(has[k]) });
    with_controls(surface, wanted).map_err(|error| failed(error.to_string()))
}

/// The start with as many control points as were asked for; one within boundary curves has them.
fn with_asked(job: &Job<'_>, start: BsplineSurface) -> Result<BsplineSurface, Refusal> {
    match job.controls.filter(|_| job.edges.boundary.is_none()) {
        Some(controls) => with_controls(start, controls).map_err(Refusal::Fit),
        None => Ok(start),
    }
}

fn told_refusal(job: &Job<'_>, refusal: Refusal) -> Error {
    match refusal {
        Refusal::Fit(error) => refused(job, &error),
        Refusal::Points(ParameterError::Option { name, value, allowed }) => {
            Error::option(name, value, allowed, "see `indgeo fit-surface --help`")
        }
        Refusal::Points(error) => Error::content(
            job.points,
            error.to_string(),
            "check it with `indgeo info`, or choose another --shape",
        ),
    }
}

impl<'a> Job<'a> {
    /// The files that are written.
    pub(crate) fn outputs(&self) -> Vec<&'a Path> {
        [self.out, self.page].into_iter().flatten().collect()
    }
}

/// Writes the page, if one was asked for.
pub(crate) fn put_page(
    job: &Job<'_>,
    points: &[Vector3<f64>],
    (surface, trim): (&BsplineSurface, Option<&TrimLoops>),
    results: &SurfaceResults,
    verdict: FitVerdict,
    report: &mut Report,
) -> Result<(), Error> {
    let Some(path) = job.page else { return Ok(()) };
    let fit = &results.fit;
    let scene = SurfaceSections { points, tolerance: fit.tolerance, max: fit.max };
    let [m, n] = results.control_points;
    let mut facts = vec![("control points".to_owned(), format!("{m} × {n}"))];
    facts.extend(number_facts(fit));
    facts.extend(coverage_facts(results.coverage.as_ref(), Some(&results.folds)));
    let page = FitPage {
        source: job.points,
        shape: "B-spline surface".to_owned(),
        verdict,
        rms: fit.rms,
        max: fit.max,
        used: fit.points_used,
        pictures: surface_sections(&scene, surface, trim, IsoCurves::Both),
        facts,
        history: &fit.history,
    };
    page.write(path, results, report)
}

/// The error of the library, with the file that it is about.
pub(crate) fn refused(job: &Job<'_>, error: &FitError) -> Error {
    match error {
        FitError::Rational => {
            Error::content(job.init.unwrap_or(job.points), error.to_string(), "give a start without weights")
        }
        FitError::Option { name, value, allowed } => {
            Error::option(name, *value, allowed, "see `indgeo fit-surface --help`")
        }
        FitError::Shape(_) => Error::usage(error.to_string(), "see `indgeo fit-surface --help`"),
        _ => Error::content(job.points, error.to_string(), "check it with `indgeo info`"),
    }
}

/// Says where the surface folds, and writes it with the outline of its data.
pub(crate) fn put_surface(
    job: &Job<'_>,
    surface: &BsplineSurface,
    fitted: &SurfaceReport,
    report: &mut Report,
) -> Result<(), Error> {
    if fitted.folds.count() > 0 {
        report.warnings.push(format!(
            "the surface folds back on itself in {} of {}; take fewer control points or a larger --smoothing",
            fitted.folds.count(),
            counted(fitted.folds.cells, "cell")
        ));
    }
    if let Some(path) = job.out {
        let content = format!("B-spline surface, {} × {}", fitted.controls[0], fitted.controls[1]);
        let mut model = Model::default();
        model.push_trimmed(surface.clone(), fitted.trim.clone(), None);
        put_model(path, model, job.cad, content, report)?;
    }
    Ok(())
}
