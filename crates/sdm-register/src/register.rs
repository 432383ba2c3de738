//! Registration of a cloud to a shape.

use crate::constraint::Chart;
use crate::iterate::{Problem, Progress};
use crate::plan::Plan;
use crate::source::Prepared;
use crate::weights::Weighting;
use crate::{Error, Pose, RegisterOptions, RegisterReport, Source, StepRecord};
use distance_field::DistanceField;
use std::ops::ControlFlow;

/// A progress callback that does nothing.
///
/// # Errors
/// Never breaks.
pub fn no_progress(_: &StepRecord) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Moves a cloud from a starting pose to where it fits a shape best.
///
/// # Errors
/// Input from which no motion can be computed: see [`Error`]. Not converging is a status of the report.
pub fn register<const D: usize>(
    field: &dyn DistanceField<D>,
    source: &Source<'_, D>,
    start: &Pose<D>,
    options: &RegisterOptions<D>,
) -> Result<RegisterReport<D>, Error> {
    register_with_progress(field, source, start, options, &no_progress)
}

/// [`register`] with a callback after each step, which may cancel.
///
/// # Errors
/// As for [`register`].
pub fn register_with_progress<const D: usize>(
    field: &dyn DistanceField<D>,
    source: &Source<'_, D>,
    start: &Pose<D>,
    options: &RegisterOptions<D>,
    progress: Progress<'_>,
) -> Result<RegisterReport<D>, Error> {
    options.check()?;
    let cloud = Prepared::new(source, options.non_finite)?;
    if !start.is_finite() {
        return Err(Error::NotAMotion { deviation: f64::NAN });
    }
    let start = start.with_source_origin(cloud.centre);
    let (dropped, taking_part) = (cloud.dropped, cloud.points.len());
    let chart = Chart::new(options.locks, options.scale, start);
    let problem = Problem { field, chart: &chart, options, progress };
    let mut plan = Plan::new(&problem, cloud);
    let view = plan.first_view(start);
    if view.frames.iter().all(|frame| !frame.is_finite()) {
        return Err(Error::EmptyModel { points: taking_part });
    }
    let base = view.base_weights(plan.coarse(), &options.rejection);
    let initial_rms = view.rms(&base, &Weighting::SQUARES).0;
    let outcome = plan.run(view);
    let (rms, used) = outcome.view.rms(&outcome.base, &outcome.weighting);
    let (covariance, free_motions) = problem.analyse(&outcome, plan.seen_by(&outcome.view), rms);
    Ok(RegisterReport {
        covariance,
        free_motions,
        pose: outcome.view.pose,
        status: outcome.status,
        rms,
        initial_rms,
        iterations: plan.history.len(),
        evaluations: plan.evaluations,
        points: source.points.len(),
        dropped,
        used,
        limit: outcome.weighting.scale(),
        history: plan.history,
    })
}
