//! Registration of a cloud to a shape.

use crate::constraint::Chart;
use crate::evidence::Nearness;
use crate::iterate::{Job, Outcome, Progress};
use crate::plan::Plan;
use crate::scale_start;
use crate::source::Prepared;
use crate::support::Doubt;
use crate::{Error, Pose, RegisterOptions, RegisterReport, RegisterStep, Source, Status};
use distance_field::DistanceField;
use std::ops::ControlFlow;

/// Share of the points, and their root mean square distance as a share of their size, that leave no doubt about a scale.
const SURE_SHARE: f64 = 0.9;
const SURE_RMS: f64 = 1e-3;
/// Points by which sizes are compared, at least: of points that fit at none, each size takes long.
const SCALING: usize = 400;
/// Most points whose distances in the starting pose are computed: far from the shape each takes long, and no decision depends on them.
const ELSEWHERE: usize = 1000;

/// A progress callback that does nothing.
///
/// # Errors
/// Never breaks.
pub fn no_progress(_: &RegisterStep) -> ControlFlow<()> {
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
    let cloud = prepared(source, start, options)?;
    let task = Task { start, begin: start, before: &[], is_part: false, points: source.points.len() };
    run(field, cloud, &task, options, progress)
}

/// [`register_with_progress`] of all points after [`register_some`]: the iteration goes on at the end of that, and its steps count.
///
/// # Errors
/// As for [`register`].
pub fn register_rest<const D: usize>(
    field: &dyn DistanceField<D>,
    source: &Source<'_, D>,
    start: &Pose<D>,
    some: &RegisterReport<D>,
    options: &RegisterOptions<D>,
    progress: Progress<'_>,
) -> Result<RegisterReport<D>, Error> {
    // What came to no end may have gone astray.
    if !some.status.is_converged() || !some.pose.is_finite() {
        return register_with_progress(field, source, start, options, progress);
    }
    let cloud = prepared(source, start, options)?;
    let points = source.points.len();
    let task = Task { start, begin: &some.pose, before: &some.history, is_part: false, points };
    let rest = run(field, cloud, &task, options, progress)?;
    Ok(RegisterReport { evaluations: some.evaluations + rest.evaluations, ..rest })
}

/// [`register_with_progress`] with some of the points alone, evenly picked: those with which the registration of all begins. `None`
/// where these are all.
///
/// Where one of many starts leads, and how well it fits there, takes a fraction of the time to find out with them.
///
/// # Errors
/// As for [`register`].
pub fn register_some<const D: usize>(
    field: &dyn DistanceField<D>,
    source: &Source<'_, D>,
    start: &Pose<D>,
    options: &RegisterOptions<D>,
    progress: Progress<'_>,
) -> Result<Option<RegisterReport<D>>, Error> {
    let cloud = prepared(source, start, options)?;
    let Some(some) = cloud.coarse(options.coarse_points) else { return Ok(None) };
    let task = Task { start, begin: start, before: &[], is_part: true, points: some.points.len() };
    run(field, some, &task, options, progress).map(Some)
}

/// The points that take part, of valid input.
fn prepared<const D: usize>(
    source: &Source<'_, D>,
    start: &Pose<D>,
    options: &RegisterOptions<D>,
) -> Result<Prepared<D>, Error> {
    options.check()?;
    let cloud = Prepared::new(source, options.non_finite)?;
    if start.is_finite() { Ok(cloud) } else { Err(Error::NotAMotion { deviation: f64::NAN }) }
}

/// From where a registration goes on.
struct Task<'a, const D: usize> {
    start: &'a Pose<D>,
    /// Where the iteration begins: the start, or where some of the points led from there.
    begin: &'a Pose<D>,
    /// The steps of those.
    before: &'a [RegisterStep],
    /// Whether the points are those some.
    is_part: bool,
    /// Number of points that were given.
    points: usize,
}

fn run<const D: usize>(
    field: &dyn DistanceField<D>,
    cloud: Prepared<D>,
    task: &Task<'_, D>,
    options: &RegisterOptions<D>,
    progress: Progress<'_>,
) -> Result<RegisterReport<D>, Error> {
    let is_begun = task.start != task.begin;
    let [start, begin] = [task.start, task.begin].map(|pose| pose.with_source_origin(cloud.centre));
    let (dropped, taking_part) = (cloud.dropped, cloud.points.len());
    let chart = Chart::new(options.locks, options.scale, start);
    let job = Job { field, chart: &chart, options, progress };
    let from = if options.scale && !is_begun { best_scale(&job, &cloud, &start) } else { begin };
    let mut plan = Plan::new(&job, cloud).after(task.before, task.is_part);
    let view = plan.first_view(from);
    if view.frames.iter().all(|frame| !frame.is_finite()) {
        return Err(Error::EmptyModel { points: taking_part });
    }
    let outcome = plan.run(view);
    let seen = plan.seen_by(&outcome.view);
    let unit = outcome.view.unit();
    let (rms, used) = outcome.view.rms(&outcome.base, &outcome.weighting);
    let (covariance, free_motions) = job.analyse(&outcome, seen, rms);
    let mut support = job.support(&outcome, seen, rms, !free_motions.is_empty());
    if options.scale && support.doubt.is_none() && job.leaves_scale_free(&outcome, seen) {
        support.doubt = Some(Doubt::Unfixed);
    }
    let doubt = support.doubt.filter(|_| outcome.status.is_converged());
    let initial_rms = rms_elsewhere(&job, seen, &outcome, start);
    Ok(RegisterReport {
        covariance,
        free_motions,
        pose: outcome.view.pose,
        status: doubt.map_or(outcome.status, Doubt::status),
        support,
        rms: rms * unit,
        initial_rms,
        iterations: plan.history.len(),
        evaluations: plan.evaluations,
        points: task.points,
        dropped,
        used,
        limit: outcome.weighting.scale().map(|limit| limit * unit),
        history: plan.history,
    })
}

/// The root mean square distance in another pose of the points that count in an outcome, with their weights there; of very many
/// points, of some that are evenly picked.
fn rms_elsewhere<const D: usize>(
    job: &Job<'_, D>,
    cloud: &Prepared<D>,
    outcome: &Outcome<D>,
    pose: Pose<D>,
) -> f64 {
    let weight = |i: usize| {
        if outcome.base[i] > 0.0 {
            outcome.base[i] * outcome.weighting.evaluate(outcome.view.distance(i)).weight
        } else {
            0.0
        }
    };
    let counting: Vec<usize> = (0..cloud.points.len()).filter(|&i| weight(i) > 0.0).collect();
    let step = counting.len().div_ceil(ELSEWHERE).max(1);
    let picked: Vec<usize> = counting.into_iter().step_by(step).collect();
    let view = job.view(&cloud.picked(&picked), pose);
    let sums = picked.iter().zip(&view.frames).filter(|(_, frame)| frame.is_finite()).fold(
        (0.0, 0.0),
        |(squares, weights), (&i, frame)| {
            let weight = weight(i);
            (squares + weight * frame.distance * frame.distance, weights + weight)
        },
    );
    if sums.1 > 0.0 { (sums.0 / sums.1).sqrt() } else { 0.0 }
}

/// Where to start with an unknown scale: the end of the best of quick registrations of few of the points from several sizes.
fn best_scale<const D: usize>(job: &Job<'_, D>, cloud: &Prepared<D>, start: &Pose<D>) -> Pose<D> {
    let few = cloud.coarse(SCALING).unwrap_or_else(|| cloud.clone());
    let mut best: Option<(f64, Pose<D>)> = None;
    for pose in scale_start::poses(&job.field.bounding_box(), cloud, start) {
        let mut plan = Plan::new(job, few.clone()).quick();
        let view = plan.first_view(job.chart.held(&pose));
        let outcome = plan.run(view);
        if outcome.status == Status::Cancelled {
            break;
        }
        let (rms, used) = outcome.view.rms(&outcome.base, &outcome.weighting);
        let support = job.support(&outcome, &few, rms, false);
        let nearness = Nearness::of(&outcome, &few);
        if support.doubt.is_some() || !outcome.view.pose.is_finite() {
            continue;
        }
        if best.as_ref().is_none_or(|(cost, _)| nearness.cost < *cost) {
            best = Some((nearness.cost, outcome.view.pose));
        }
        let is_good = used as f64 >= SURE_SHARE * few.points.len() as f64 && support.relative_rms < SURE_RMS;
        // A plane fits at any scale.
        if is_good && outcome.status.is_converged() && !job.leaves_scale_free(&outcome, &few) {
            break;
        }
    }
    best.map_or(*start, |(_, pose)| pose)
}
