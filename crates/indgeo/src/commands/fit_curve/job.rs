//! The fit of a curve: read, fit, write.

use super::joins::Joins;
use super::results::CurveResults;
use super::start::{Start, start};
use super::tables::{feet, history};
use super::{evolution, page};
use crate::error::Error;
use crate::files;
use crate::fits::input::{check_paths, put_model, warn_dropped};
use crate::fits::numbers::{FitVerdict, told};
use crate::input::cad_shapes;
use crate::output::cad::CadArgs;
use crate::report::wording::counted;
use crate::report::{Input, Output, Report, Timings};
use crate::runtime::progress::Progress;
use industrial_geometry::distance_field::{CurveField, ErrorTerm};
use industrial_geometry::fit::curve::{
    CurveFit, CurveOptions, CurvePart, CurveReport, fit_curve_to_model_with_progress,
    fit_curve_with_progress, fit_curves_with_progress,
};
use industrial_geometry::fit::{Error as FitError, FitStep, StepControl};
use industrial_geometry::io::{Content, Model, ReadOptions, Shape};
use industrial_geometry::nurbs::nalgebra::{SVector, Vector3};
use industrial_geometry::nurbs::{BsplineCurve, ParametricCurve};
use std::path::{Path, PathBuf};

/// Points along the curves of a model.
const SAMPLES: usize = 2000;

/// What is to be done.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// File of the points, or of the model.
    pub(crate) points: &'a Path,
    /// Sensor points in each span, if it is a model.
    pub(crate) sensors: Option<usize>,
    /// File of the curve to start from.
    pub(crate) init: Option<&'a Path>,
    /// Curves that it continues.
    pub(crate) joins: Joins<'a>,
    /// File of the curve.
    pub(crate) out: Option<&'a Path>,
    /// File of the footpoints.
    pub(crate) feet: Option<&'a Path>,
    /// File of the page.
    pub(crate) page: Option<&'a Path>,
    /// File of the history.
    pub(crate) history: Option<&'a Path>,
    /// File of the drawing.
    pub(crate) evolution: Option<&'a Path>,
    /// Name and unit of the result.
    pub(crate) cad: &'a CadArgs,
    /// Options of the library.
    pub(crate) options: CurveOptions,
    /// Whether nobody wants to watch.
    pub(crate) quiet: bool,
}

/// Does the job and fills in the report; returns whether the curve is what was asked for.
pub(crate) fn run(job: &Job<'_>, report: &mut Report) -> Result<FitVerdict, Error> {
    let neighbours = job.joins.files.iter().map(PathBuf::as_path);
    let inputs: Vec<&Path> = std::iter::once(job.points).chain(job.init).chain(neighbours).collect();
    let outputs: Vec<&Path> =
        [job.out, job.feet, job.page, job.history, job.evolution].into_iter().flatten().collect();
    check_paths(&inputs, &outputs)?;
    if let Some(sensors) = job.sensors {
        let content = cad_shapes::read(job.points, "model", report)?;
        let start = job.init.map(|path| start(path, "init", report)).transpose()?;
        return to_model(job, content, start, sensors, report);
    }
    let loaded =
        Timings::measure(&mut report.timings.read, || files::read(job.points, &ReadOptions::default()))?;
    report.add_input(Input::new("points", job.points, &loaded.report));
    let (points, planar) = positions(&loaded.content, job.points)?;
    let ends = job.joins.read(&points, report)?;
    // Ends in space take the curve there.
    let planar = planar && ends.iter().all(|[place, direction]| place.z == 0.0 && direction.z == 0.0);
    match job.init.map(|path| start(path, "init", report)).transpose()? {
        Some(Start::Space(curve)) => solve(job, &points, (Some(curve), &ends), report),
        Some(Start::Plane(_)) if !planar => {
            let what = "the start lies in the plane, but some points have a z that is not 0";
            Err(Error::content(job.points, what, "give points of two columns, or a start in space"))
        }
        Some(Start::Plane(curve)) => solve(job, &in_plane(&points), (Some(curve), &ends), report),
        None if planar => solve(job, &in_plane(&points), (None, &ends), report),
        None => solve::<3>(job, &points, (None, &ends), report),
    }
}

/// The points, and whether they lie in the plane `z = 0`.
fn positions(content: &Content, path: &Path) -> Result<(Vec<Vector3<f64>>, bool), Error> {
    let cloud = match content {
        Content::Cloud(cloud) => cloud,
        Content::Mesh(mesh) => mesh.cloud(),
        Content::Nurbs(_) => {
            let what = "points are needed, but this file holds NURBS shapes";
            return Err(Error::content(path, what, "give a cloud"));
        }
    };
    let points: Vec<Vector3<f64>> = cloud.positions().iter().map(|point| point.coords).collect();
    let planar = cloud.dimension() == 2 || points.iter().all(|p| p.z == 0.0 || !p.z.is_finite());
    Ok((points, planar))
}

fn in_plane(points: &[Vector3<f64>]) -> Vec<SVector<f64, 2>> {
    // A point whose height is no number is no point.
    points.iter().map(|p| if p.z.is_finite() { p.xy() } else { SVector::repeat(f64::NAN) }).collect()
}

fn solve<const D: usize>(
    job: &Job<'_>,
    points: &[SVector<f64, D>],
    (start, ends): (Option<BsplineCurve<D>>, &[[Vector3<f64>; 2]]),
    report: &mut Report,
) -> Result<FitVerdict, Error>
where
    BsplineCurve<D>: Into<Shape>,
{
    let options = match ends {
        [] => job.options,
        ends => job.options.with_ends(job.joins.given(ends)),
    };
    let progress = Progress::iterations("fitting", job.quiet);
    let most = job.options.fit.max_iterations;
    let tell = |step: &FitStep| told(&progress, step, most);
    let found = Timings::measure(&mut report.timings.compute, || match start {
        None if ends.is_empty() => fit_curves_with_progress(points, &options, &tell),
        // Ends are those of one curve.
        start => fit_curve_with_progress(points, start.as_ref(), &options, &tell)
            .map(|fit| vec![CurvePart { points: (0..points.len()).collect(), fit }]),
    });
    drop(progress);
    finished(job, points, ends, found, report)
}

/// The fit to the curves of a model.
fn to_model(
    job: &Job<'_>,
    content: Content,
    start: Option<Start>,
    sensors: usize,
    report: &mut Report,
) -> Result<FitVerdict, Error> {
    let Content::Nurbs(model) = content else {
        let what = "a model of curves is needed";
        return Err(Error::content(
            job.points,
            what,
            "give B-spline curves (JSON, STEP, IGES), or leave out --model",
        ));
    };
    let (mut plane, mut space) = (Vec::new(), Vec::new());
    for shape in model.into_shapes() {
        match shape {
            Shape::Curve2(curve) => plane.push(curve),
            Shape::Curve3(curve) => space.push(curve),
            Shape::Surface(_) => {}
        }
    }
    match (plane.is_empty(), space.is_empty(), start) {
        (false, true, Some(Start::Plane(start))) => modelled(job, &plane, Some(&start), sensors, report),
        (false, true, None) => modelled(job, &plane, None, sensors, report),
        (true, false, Some(Start::Space(start))) => modelled(job, &space, Some(&start), sensors, report),
        (true, false, None) => modelled(job, &space, None, sensors, report),
        (true, true, _) => {
            let what = "the model has no curves";
            Err(Error::content(job.points, what, "give curves, or take `indgeo fit-surface --model`"))
        }
        _ => {
            let what = "the curves of the model and the start lie in the plane and in space";
            Err(Error::content(job.points, what, "give both in the plane, or both in space"))
        }
    }
}

fn modelled<const D: usize>(
    job: &Job<'_>,
    model: &[BsplineCurve<D>],
    start: Option<&BsplineCurve<D>>,
    sensors: usize,
    report: &mut Report,
) -> Result<FitVerdict, Error>
where
    BsplineCurve<D>: Into<Shape>,
{
    let field = CurveField::for_model(model)
        .map_err(|error| Error::content(job.points, error.to_string(), "check it with `indgeo info`"))?;
    let each = (SAMPLES / model.len()).max(2);
    let along = |curve: &BsplineCurve<D>| -> Vec<SVector<f64, D>> {
        let domain = curve.domain();
        (0..each).map(|k| curve.point(domain.lerp(k as f64 / (each - 1) as f64))).collect()
    };
    let samples: Vec<SVector<f64, D>> = model.iter().flat_map(along).collect();
    let progress = Progress::iterations("fitting", job.quiet);
    let most = job.options.fit.max_iterations;
    let tell = |step: &FitStep| told(&progress, step, most);
    let found = Timings::measure(&mut report.timings.compute, || {
        fit_curve_to_model_with_progress(&field, &samples, start, sensors, &job.options, &tell)
    });
    drop(progress);
    let found = found.map(|fit| vec![CurvePart { points: (0..samples.len()).collect(), fit }]);
    finished(job, &samples, &[], found, report)
}

/// Writes what was found, and says how it went.
fn finished<const D: usize>(
    job: &Job<'_>,
    points: &[SVector<f64, D>],
    ends: &[[Vector3<f64>; 2]],
    found: Result<Vec<CurvePart<D>>, FitError>,
    report: &mut Report,
) -> Result<FitVerdict, Error>
where
    BsplineCurve<D>: Into<Shape>,
{
    let found = found.map_err(|error| refused(job, &error))?;
    let reports: Vec<CurveReport> = found.iter().map(|part| part.fit.report.clone()).collect();
    let fitted = CurveReport::together(&reports);
    warn(job, &fitted, &reports, report);
    write(job, points, &found, &fitted, report)?;
    report.count_points("points", fitted.dropped, fitted.used);
    let (joins, unmet) = match &found[..] {
        [part] => job.joins.measured(ends, &part.fit.curve, fitted.coverage.length, report),
        _ => (Vec::new(), false),
    };
    let verdict = FitVerdict::of(fitted.status, fitted.reached).without(!fitted.covered || unmet);
    let parts = if reports.len() > 1 { reports } else { Vec::new() };
    let results = CurveResults { fitted, parts, joins };
    if let Some(path) = job.page {
        page::put(job.points, path, (points, &found), &results, verdict, report)?;
    }
    report.results = Some(Box::new(results));
    Ok(verdict)
}

fn warn(job: &Job<'_>, fitted: &CurveReport, reports: &[CurveReport], report: &mut Report) {
    warn_dropped(job.points, fitted.dropped, fitted.points, report);
    let literal = job.options.fit.term == ErrorTerm::Taylor && job.options.fit.control == StepControl::None;
    if literal && fitted.steps_lifted > 0 {
        report.warnings.push(format!(
            "the system of {} was not positive definite and was lifted: these are no literal Newton steps; start nearer to the points \
             (--init), or take another --term or --step-control",
            counted(fitted.steps_lifted, "step")
        ));
    }
    for (k, one) in reports.iter().enumerate() {
        let which = if reports.len() > 1 { format!("curve {k} (from 0): ") } else { String::new() };
        if let Some(fault) = one.fault() {
            report.warnings.push(format!("{which}{fault}; {}", advice(one)));
        }
        if !one.crossings.is_empty() {
            report.warnings.push(format!(
                "{which}the curve crosses itself {}; if the points do not, take fewer control points or a larger --smoothing",
                counted(one.crossings.len(), "time")
            ));
        }
    }
}

/// What can be done about a curve that does not stay with its points.
fn advice(report: &CurveReport) -> &'static str {
    let coverage = &report.coverage;
    if coverage.spread_out {
        "take points of a section or an outline"
    } else if coverage.holds() && report.open_ends.is_some() {
        "say with --closed or --open which it is"
    } else if !coverage.is_complete() {
        "add points there, split the file, or say with --max-gap how wide a gap may be"
    } else if coverage.points_far > 0 && coverage.points_far * 10 < report.points {
        "leave out points that do not belong to it (--outliers automatic), or allow more control points"
    } else {
        "allow more control points, give a start (--init), or search for it (--search)"
    }
}

fn write<const D: usize>(
    job: &Job<'_>,
    points: &[SVector<f64, D>],
    found: &[CurvePart<D>],
    fitted: &CurveReport,
    report: &mut Report,
) -> Result<(), Error>
where
    BsplineCurve<D>: Into<Shape>,
{
    if let Some(path) = job.out {
        let count = counted(fitted.controls, "control point");
        if let [part] = found {
            let content = format!("B-spline curve with {count}");
            put_model(path, part.fit.curve.clone(), job.cad, content, report)?;
        } else {
            let mut model = Model::default();
            for (k, part) in found.iter().enumerate() {
                model.push(part.fit.curve.clone(), Some(format!("curve {k}")));
            }
            put_model(path, model, job.cad, format!("{} B-spline curves with {count}", found.len()), report)?;
        }
    }
    if let Some(path) = job.feet {
        put(path, &feet(points, found), "footpoints", report)?;
    }
    if let Some(path) = job.history {
        put(path, &history(&fitted.history), "history", report)?;
    }
    let fits: Vec<&CurveFit<D>> = found.iter().map(|part| &part.fit).collect();
    if let Some(path) = job.evolution.filter(|path| files::extension(path) == "json") {
        let mut model = Model::default();
        let mut steps = 0;
        for fit in &fits {
            for curve in &fit.evolution {
                model.push(curve.clone(), Some(format!("step {steps}")));
                steps += 1;
            }
            model.push(fit.curve.clone(), Some("result".to_owned()));
        }
        put_model(path, model, &CadArgs::default(), counted(steps + fits.len(), "curve"), report)?;
    } else if let Some(path) = job.evolution {
        let steps: Vec<BsplineCurve<D>> = fits.iter().flat_map(|fit| fit.evolution.iter().cloned()).collect();
        let results: Vec<&BsplineCurve<D>> = fits.iter().map(|fit| &fit.curve).collect();
        put(path, &evolution::drawing(points, &steps, &results), "drawing", report)?;
    }
    Ok(())
}

fn put(path: &Path, text: &str, content: &str, report: &mut Report) -> Result<(), Error> {
    let bytes = Timings::measure(&mut report.timings.write, || {
        files::write(path, |out| out.write_all(text.as_bytes()))
    })?;
    report.add_output(Output { path: path.to_path_buf(), bytes, content: content.to_owned() });
    Ok(())
}

/// The error of the library, with the file that it is about.
fn refused(job: &Job<'_>, error: &FitError) -> Error {
    match error {
        FitError::Rational => Error::content(
            job.init.unwrap_or(job.points),
            error.to_string(),
            "give a start without weights, or add --rational",
        ),
        FitError::Option { name, value, allowed } => {
            Error::option(name, *value, allowed, "see `indgeo fit-curve --help`")
        }
        FitError::SeveralParts { .. } => Error::content(
            job.points,
            error.to_string(),
            "split the file, or say with --max-gap, --closed or --open that they are one",
        ),
        FitError::TooFewPoints { .. } => Error::content(
            job.points,
            error.to_string(),
            "give more points, fewer control points (--control-points) or a lower degree",
        ),
        _ => Error::content(job.points, error.to_string(), "check it with `indgeo info`"),
    }
}
