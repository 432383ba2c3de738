//! The fit of a surface to a model: read, fit, write.

use crate::commands::fit_surface::job::{Job, SurfaceResults, put_page, put_surface, refused};
use crate::commands::fit_surface::judgement::Judgement;
use crate::commands::fit_surface::start::{Refusal, from_cloud};
use crate::commands::register::field::RegistrationField;
use crate::commands::register::model::RegistrationModel;
use crate::error::Error;
use crate::fits::input::{check_paths, start_surface, warn_incomplete};
use crate::fits::numbers::{FitNumbers, FitVerdict, Within, told};
use crate::input::cad::Choice;
use crate::report::{Input, Report, Timings};
use crate::runtime::progress::Progress;
use industrial_geometry::fit::{
    Error as FitError, FitStep, SurfaceDistances, fit_surface_to_model_with_progress, with_controls,
};
use industrial_geometry::mesh::nalgebra::Vector3;
use std::path::Path;

/// Does the job and fills in the report; returns whether surface and model are near to each other.
pub(crate) fn run(job: &Job<'_>, sensors: usize, report: &mut Report) -> Result<FitVerdict, Error> {
    let inputs: Vec<&Path> = std::iter::once(job.points).chain(job.init).collect();
    check_paths(&inputs, &job.outputs())?;
    let mut warnings = Vec::new();
    let read = Timings::measure(&mut report.timings.read, || {
        RegistrationModel::read(job.points, &Choice::default(), &mut warnings)
    });
    let (model, read) = read?;
    report.warnings.append(&mut warnings);
    report.add_input(Input::new("model", job.points, &read));
    let start = job.init.map(|path| start_surface(path, report)).transpose()?;
    let RegistrationField::Space(field) = model.field(job.points)? else {
        let what = "the model lies in the plane, a surface needs one in space";
        return Err(Error::content(job.points, what, "give a mesh or surfaces"));
    };
    let samples: Vec<Vector3<f64>> = model.samples(job.points)?.points().to_vec();
    let progress = Progress::iterations("fitting", job.quiet);
    let most = job.options.fit.max_iterations;
    let tell = |step: &FitStep| told(&progress, step, most);
    let failed = |error: FitError| refused(job, &error);
    let found = Timings::measure(&mut report.timings.compute, || -> Result<_, Error> {
        // Without a start the surface through the samples is one, which reaches to the ends of the model.
        let (start, through) = match (start, job.controls) {
            (Some(start), Some(controls)) => (with_controls(start, controls).map_err(failed)?, None),
            (Some(start), None) => (start, None),
            (None, _) => {
                let found = from_cloud(&samples, &job.options, job.controls.is_some(), &tell);
                let (surface, fitted, _) = found.map_err(|refusal| match refusal {
                    Refusal::Fit(error) => failed(error),
                    Refusal::Points(error) => {
                        Error::content(job.points, error.to_string(), "give a start (--init)")
                    }
                })?;
                (surface.clone(), Some((surface, fitted)))
            }
        };
        let start = Some(start);
        let found =
            fit_surface_to_model_with_progress(field.as_ref(), &samples, start, sensors, &job.options, &tell)
                .map_err(failed)?;
        let is_nearer = found.report.fit.rms < found.report.fit.initial_rms;
        // What is no nearer to the model than the start is not kept.
        Ok(through.filter(|_| !is_nearer).unwrap_or((found.surface, found.report)))
    });
    drop(progress);
    let (surface, fitted) = found?;
    put_surface(job, &surface, &fitted, report)?;
    // The other direction: what of the model the surface does not reach.
    let back = SurfaceDistances::of(&surface, &samples, job.options.fit.robust).map_err(failed)?;
    let judged = |coverage| Judgement::of(&samples, &back, coverage, None, job.options.fit.robust);
    let judgement = fitted.coverage.as_ref().map(judged).unwrap_or_default();
    let unmet = judgement.warn(job.points, back.rms, report);
    let incomplete = warn_incomplete(fitted.coverage.as_ref(), report);
    let fit = FitNumbers::new(fitted.fit, 0, 0, Within::default());
    let verdict = fit.verdict().without(unmet || incomplete || fitted.folds.count() > 0);
    let results = SurfaceResults {
        fit,
        base: fitted.base,
        start: None,
        control_points: fitted.controls,
        runs: fitted.runs,
        edges: None,
        folds: fitted.folds,
        coverage: fitted.coverage,
        trim_loops: fitted.trim.as_ref().map_or(0, |trim| trim.loops().len()),
    };
    put_page(job, &samples, (&surface, fitted.trim.as_ref()), &results, verdict, report)?;
    report.results = Some(Box::new(results));
    Ok(verdict)
}
