//! The fit of a ruled surface: read, move, fit, write.

use crate::commands::fit_surface::judgement::Judgement;
use crate::error::Error;
use crate::fits::input::{
    Scan, check_paths, put_model, start_surface, warn_dropped, warn_incomplete, warn_undetermined,
};
use crate::fits::numbers::{FitNumbers, FitVerdict, Within, told};
use crate::fits::page::{
    FitPage, IsoCurves, SurfaceSections, coverage_facts, number_facts, surface_sections,
};
use crate::output::cad::CadArgs;
use crate::report::wording::counted;
use crate::report::{Report, Timings};
use crate::runtime::progress::Progress;
use industrial_geometry::fit::ruled::{
    Developability, RuledCloudOptions, fit_ruled_cloud_with_progress, offset_points,
};
use industrial_geometry::fit::{
    BaseShape, Error as FitError, FitStep, Folds, SurfaceCoverage, SurfaceDistances,
};
use industrial_geometry::nurbs::BsplineSurface;
use industrial_geometry::nurbs::nalgebra::Vector3;
use serde::Serialize;
use std::path::Path;

/// What is to be done.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// File of the points or shapes.
    pub(crate) points: &'a Path,
    /// File of the surface to start from.
    pub(crate) init: Option<&'a Path>,
    /// File of the surface.
    pub(crate) out: Option<&'a Path>,
    /// File of the page.
    pub(crate) page: Option<&'a Path>,
    /// Distance of the offset that is fitted.
    pub(crate) offset: Option<f64>,
    /// Name and unit of the result.
    pub(crate) cad: &'a CadArgs,
    /// Options of the library.
    pub(crate) options: RuledCloudOptions,
    /// Whether nobody wants to watch.
    pub(crate) quiet: bool,
}

/// What a fit of a ruled surface found.
#[derive(Debug, Serialize)]
pub(crate) struct RuledResults {
    /// The fit.
    #[serde(flatten)]
    pub(crate) fit: FitNumbers,
    /// What the first parameters were taken from.
    pub(crate) base: Option<BaseShape>,
    /// Control points along a section that are not repetitions, and sections.
    pub(crate) control_points: [usize; 2],
    /// Surfaces that were fitted.
    pub(crate) runs: usize,
    /// How far the surface is from being developable.
    pub(crate) developability: Developability,
    /// Cells in which the surface folds.
    pub(crate) folds: Folds,
    /// How near the parts of the surface are to the points.
    pub(crate) coverage: Option<SurfaceCoverage>,
    /// Points of the offset that a cutter cannot reach.
    pub(crate) gouging: usize,
}

/// Does the job and fills in the report; returns whether the surface is what was asked for.
pub(crate) fn run(job: &Job<'_>, report: &mut Report) -> Result<FitVerdict, Error> {
    let inputs: Vec<&Path> = std::iter::once(job.points).chain(job.init).collect();
    let outputs: Vec<&Path> = [job.out, job.page].into_iter().flatten().collect();
    check_paths(&inputs, &outputs)?;
    let scan = Scan::read(job.points, true, u32::MAX, report)?;
    let start = job.init.map(|path| start_surface(path, report)).transpose()?;
    let count = scan.points.len();
    let (points, gouging) = match job.offset {
        Some(distance) => offset(job, &scan, distance, report)?,
        None => (scan.points, 0),
    };
    let progress = Progress::iterations("fitting", job.quiet);
    let most = job.options.ruled.fit.max_iterations;
    let tell = |step: &FitStep| told(&progress, step, most);
    let found = Timings::measure(&mut report.timings.compute, || {
        fit_ruled_cloud_with_progress(&points, start, &job.options, &tell)
    });
    drop(progress);
    let found = found.map_err(|error| refused(job, &error))?;
    warn_dropped(job.points, found.dropped, count, report);
    let distances = Timings::measure(&mut report.timings.compute, || {
        SurfaceDistances::of(&found.fit.surface, &points, job.options.ruled.fit.robust)
    });
    let distances = distances.map_err(|error| refused(job, &error))?;
    let folds = found.fit.report.folds.clone();
    if folds.count() > 0 {
        report.warnings.push(format!(
            "the surface folds back on itself, or has an edge sharper than a right angle, in {} of {}",
            folds.count(),
            counted(folds.cells, "cell")
        ));
    }
    let fitted = found.fit.report;
    warn_undetermined(job.points, points.len() - found.dropped, fitted.controls, report);
    if let Some(path) = job.out {
        let [along, sections] = fitted.controls;
        let content = format!("ruled B-spline surface, {sections} sections of {along} control points");
        put_model(path, found.fit.surface.clone(), job.cad, content, report)?;
    }
    let within = Within {
        tolerance: job.options.abs_tolerance,
        share: found.share_within,
        holds: found.within_tolerance,
    };
    let fit = FitNumbers::new(fitted.fit, found.dropped, 0, within);
    report.count_points("points", fit.points_dropped, fit.points_used);
    let incomplete = warn_incomplete(fitted.coverage.as_ref(), report);
    let (tolerance, robust) = (job.options.abs_tolerance, job.options.ruled.fit.robust);
    let judged = |coverage: &SurfaceCoverage| Judgement::of(&points, &distances, coverage, tolerance, robust);
    let judgement = fitted.coverage.as_ref().map(judged).unwrap_or_default();
    let unmet = judgement.warn(job.points, fit.rms, report);
    let verdict = fit.verdict().without(unmet || incomplete || folds.count() > 0);
    let results = RuledResults {
        fit,
        base: found.base,
        control_points: fitted.controls,
        runs: found.runs,
        developability: fitted.developability,
        folds,
        coverage: fitted.coverage,
        gouging,
    };
    if let Some(path) = job.page {
        put_page(job, path, (&points, &found.fit.surface), &results, verdict, report)?;
    }
    report.results = Some(Box::new(results));
    Ok(verdict)
}

fn put_page(
    job: &Job<'_>,
    path: &Path,
    (points, surface): (&[Vector3<f64>], &BsplineSurface),
    results: &RuledResults,
    verdict: FitVerdict,
    report: &mut Report,
) -> Result<(), Error> {
    let fit = &results.fit;
    let scene = SurfaceSections { points, tolerance: fit.tolerance, max: fit.max };
    let [along, sections] = results.control_points;
    let mut facts = vec![("control points".to_owned(), format!("{sections} sections of {along}"))];
    facts.extend(number_facts(fit));
    facts.extend(coverage_facts(results.coverage.as_ref(), Some(&results.folds)));
    facts.push(("angle between normals along rulings".to_owned(), results.developability.to_string()));
    let page = FitPage {
        source: job.points,
        shape: "ruled B-spline surface".to_owned(),
        verdict,
        rms: fit.rms,
        max: fit.max,
        used: fit.points_used,
        pictures: surface_sections(&scene, surface, None, IsoCurves::OfU),
        facts,
        history: &fit.history,
    };
    page.write(path, results, report)
}

/// The points of the offset, and how many are left out because they lie too deep.
fn offset(
    job: &Job<'_>,
    scan: &Scan,
    distance: f64,
    report: &mut Report,
) -> Result<(Vec<Vector3<f64>>, usize), Error> {
    let Some(normals) = &scan.normals else {
        let what = "an offset needs normals, but this cloud has none";
        return Err(Error::content(job.points, what, "give a mesh, or a cloud with normals"));
    };
    let (points, normals): (Vec<_>, Vec<_>) =
        scan.points.iter().zip(normals).filter(|(p, _)| p.iter().all(|c| c.is_finite())).unzip();
    let moved = offset_points(&points, &normals, distance).map_err(|error| refused(job, &error))?;
    for (count, what) in [
        (moved.without_normal, "have no normal"),
        (moved.gouging, "would be cut into by a cutter at another place"),
    ] {
        if count > 0 {
            let of = points.len();
            let name = job.points.display();
            report.warnings.push(format!("{name}: {count} of {} {what}: not used", counted(of, "point")));
        }
    }
    Ok((moved.points, moved.gouging))
}

/// The error of the library, with the file that it is about.
fn refused(job: &Job<'_>, error: &FitError) -> Error {
    match error {
        FitError::Rational | FitError::NotRuled { .. } => {
            Error::content(job.init.unwrap_or(job.points), error.to_string(), "give another start")
        }
        FitError::Option { name, value, allowed } => {
            Error::option(name, *value, allowed, "see `indgeo fit-ruled --help`")
        }
        FitError::Shape(_) => Error::usage(error.to_string(), "see `indgeo fit-ruled --help`"),
        _ => Error::content(job.points, error.to_string(), "check it with `indgeo info`"),
    }
}
