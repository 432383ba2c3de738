//! The number of control points: as many as a tolerance asks for, or as the noise supports.

use super::crossing::self_crossings;
use super::start::Layout;
use super::work::{CHOICE, COARSE, EXACT, SMOOTHER, State, Work};
use crate::options::Smoothing;
use crate::{Error, Status};
use footpoint::CurveProjector;
use nalgebra::SVector;
use nurbs_core::BsplineCurve;

/// Rounds of knot insertion at most.
const ROUNDS: usize = 24;
/// Growth of the number of control points between two attempts, as a fraction.
const GROWTH: (usize, usize) = (7, 20);
/// Iterations that show what a number of control points can do.
const LOOK: usize = 40;
/// Share of the control points that counts as free where the data choose the energy, which takes up the rest.
const SMOOTHED: f64 = 0.5;
/// Points for each control point below which those beyond count in full: they follow single points, and bulge between them.
const DENSE: f64 = 4.0;
/// Improvement of the root mean square below which more knots do not help, and how often in a row that may be.
const HELP: f64 = 0.02;
const PATIENCE: usize = 3;
/// Numbers of control points in a row without an improvement after which no more are tried, even if all curves leave the points.
const HOPELESS: usize = 5;
/// Share of a curve without points from which on a number of control points is not taken if another one has less.
const BARE: f64 = 0.03;
/// Share of the size below which distances are good enough where nothing else is asked for.
const GOOD: f64 = 1e-6;
/// First `λ` of runs that start from a good curve.
const WARM: f64 = 1e-4;
/// Shares of the tolerance by which a curve may move when knots are removed, one after the other.
const REMOVAL: [f64; 3] = [2.0, 1.0, 0.3];

/// Inserts knots where points are further than the tolerance, then removes those without effect ([YWS04]).
pub(super) fn to_tolerance<const D: usize>(
    work: &mut Work<'_, D>,
    mut state: State<D>,
) -> Result<State<D>, Error> {
    let Some(tolerance) = work.tolerance() else { return Ok(state) };
    let (coarse, fit) = (coarse(work), warm(work));
    let expected = work.expected;
    let crossings = |state: &State<D>| self_crossings(&state.curve).len().saturating_sub(expected);
    let mut idle = 0;
    for _ in 0..ROUNDS {
        if state.report.max <= tolerance || work.cancelled {
            break;
        }
        let Some(curve) = refined(work, &state.curve, tolerance)? else { break };
        let next = work.run(curve, &coarse, "insert")?;
        let helps = next.report.rms < (1.0 - HELP) * state.report.rms
            || next.report.max < (1.0 - HELP) * state.report.max;
        if next.report.rms > state.report.rms && next.report.max > state.report.max {
            break;
        }
        work.keep(&next);
        state = next;
        idle = if helps { 0 } else { idle + 1 };
        if idle >= PATIENCE {
            break;
        }
    }
    if !work.cancelled {
        let next = work.run(state.curve.clone(), &fit, "fit")?;
        let next = work.finished(next)?;
        let nearer = next.report.max <= tolerance || next.report.max < state.report.max;
        if nearer && crossings(&next) <= crossings(&state) {
            work.keep(&next);
            state = next;
        }
    }
    if state.report.max <= tolerance && crossings(&state) > 0 {
        state = smoother(work, state, tolerance)?;
    }
    if state.report.max <= tolerance {
        for share in REMOVAL {
            if work.cancelled {
                break;
            }
            let (curve, _) = state.curve.remove_all_within(share * tolerance)?;
            if curve.knots().distinct_count() >= state.curve.knots().distinct_count() {
                continue;
            }
            let next = work.run(curve, &fit, "remove")?;
            let good = next.report.max <= tolerance && next.report.status != Status::Diverged;
            if good && crossings(&next) <= crossings(&state) {
                work.keep(&next);
                state = next;
            }
        }
    }
    Ok(state)
}

/// With as much energy as the tolerance leaves room for, until the curve does not cross itself any more: loops at corners do not carry
/// anything.
fn smoother<const D: usize>(
    work: &mut Work<'_, D>,
    mut state: State<D>,
    tolerance: f64,
) -> Result<State<D>, Error> {
    if !matches!(work.options.fit.smoothing, Smoothing::Automatic { .. }) {
        return Ok(state);
    }
    let from = state.report.lambda.max(COARSE / 100.0);
    for more in SMOOTHER {
        let fit = work.loop_options().with_smoothing(Smoothing::Fixed { lambda: from * more });
        let next = work.run(state.curve.clone(), &fit, "uncross")?;
        let fewer = work.crossings(&next.curve) < work.crossings(&state.curve);
        if work.cancelled || next.report.max > tolerance {
            break;
        }
        if fewer {
            work.keep(&next);
            state = next;
        }
        if work.crossings(&state.curve) == 0 {
            break;
        }
    }
    Ok(state)
}

/// Options of runs that only have to show where knots are missing: little energy, but not none, since a shape that
/// cannot fit yet would be distorted.
pub(super) fn coarse<const D: usize>(work: &Work<'_, D>) -> crate::FitOptions {
    let fit = work.loop_options();
    let fit = fit.with_max_iterations(fit.max_iterations.min(LOOK));
    match fit.smoothing {
        Smoothing::Automatic { factor, .. } => {
            fit.with_smoothing(Smoothing::Continuation { start: WARM, factor, floor: COARSE })
        }
        _ => fit,
    }
}

pub(super) fn warm<const D: usize>(work: &Work<'_, D>) -> crate::FitOptions {
    let fit = work.loop_options();
    match fit.smoothing {
        Smoothing::Automatic { start, factor } => {
            fit.with_smoothing(Smoothing::Automatic { start: start.min(WARM), factor })
        }
        Smoothing::Continuation { start, factor, floor } => {
            fit.with_smoothing(Smoothing::Continuation { start: start.min(WARM).max(floor), factor, floor })
        }
        Smoothing::Fixed { .. } => fit,
    }
}

/// The same curve with a knot more in every span that has points beyond the tolerance, at the middle of their squares;
/// `None` where no more are allowed.
fn refined<const D: usize>(
    work: &Work<'_, D>,
    curve: &BsplineCurve<D>,
    tolerance: f64,
) -> Result<Option<BsplineCurve<D>>, Error> {
    let knots = curve.knots();
    let projector = CurveProjector::new(curve);
    let feet = projector.project_all(work.points);
    // For each span: points, sum of squares, sum of squares times parameter, largest distance.
    let mut sums = vec![(0usize, 0.0, 0.0, 0.0f64); knots.basis_count()];
    for foot in &feet {
        let sum = &mut sums[knots.span(knots.normalize(foot.parameter))];
        let square = foot.distance * foot.distance;
        sum.0 += 1;
        sum.1 += square;
        sum.2 += square * foot.parameter;
        sum.3 = sum.3.max(foot.distance);
    }
    let mut wanted: Vec<(f64, f64)> = Vec::new();
    for span in knots.spans() {
        let (count, squares, moment, largest) = sums[span];
        let interval = knots.span_interval(span);
        if largest > tolerance && count > 1 && interval.length() > 1e-6 * knots.domain().length() {
            let share = interval.fraction(moment / squares).clamp(0.25, 0.75);
            wanted.push((largest, interval.lerp(share)));
        }
    }
    wanted.sort_by(|a, b| b.0.total_cmp(&a.0));
    let room = work.options.max_controls.min(work.points.len()).saturating_sub(knots.distinct_count());
    wanted.truncate(room);
    if wanted.is_empty() {
        return Ok(None);
    }
    let mut values: Vec<f64> = wanted.into_iter().map(|w| w.1).collect();
    values.sort_by(f64::total_cmp);
    Ok(Some(curve.refine(&values)?))
}

/// More control points as long as they lower the Bayesian information criterion.
pub(super) fn by_noise<const D: usize>(
    work: &mut Work<'_, D>,
    layout: &Layout<D>,
    distinct: usize,
) -> Result<State<D>, Error> {
    let stride = work.points.len().div_ceil(CHOICE).max(1);
    let sample: Vec<SVector<f64, D>> = work.points.iter().step_by(stride).copied().collect();
    let most = work.options.max_controls.min(distinct.min(sample.len()) / 2).max(work.options.degree + 1);
    let steps = work.options.fit.max_iterations.min(LOOK);
    let mut fit = work.loop_options().with_max_iterations(steps);
    let count = sample.len() as f64;
    let degree = work.options.degree;
    // With fewer the curve takes short cuts, and what it does says nothing.
    let faithful = layout
        .faithful(degree, most, layout.nearness(work.points))?
        .map_or(0, |c| c.knots().distinct_count());
    let mut controls = (degree + 1 + usize::from(layout.closed) * 2).min(most);
    let mut best: Option<Choice> = None;
    let mut worse = 0;
    // From the first curve on that crosses itself, where the path says better than noise where to go.
    let through = layout.scatter(work.points) == 0.0;
    let mut bent = false;
    loop {
        let mut state = work.run_on(&sample, first(layout, degree, controls, bent)?, &fit, "choose")?;
        if !bent
            && through
            && work.crossings(&state.curve) > 0
            && let Some(curve) = layout.bent(degree, controls)?
        {
            (bent, work.follows) = (true, true);
            fit = work.loop_options().with_max_iterations(steps);
            state = work.run_on(&sample, curve, &fit, "choose")?;
        }
        let rms = state.report.rms.max(EXACT * work.size);
        let faulty = work.crossings(&state.curve) > 0
            || work.coverage_on(&sample, &state.curve).share_without_data() > BARE;
        // Both by direction across the curve: along it neither points nor control points tell anything.
        let few = (controls as f64 - count / DENSE).max(0.0);
        let free = if bent { controls as f64 } else { SMOOTHED * controls as f64 + (1.0 - SMOOTHED) * few };
        let criterion = count * 2.0 * rms.ln() + free * count.ln();
        let better = best.is_none_or(|b| (faulty, criterion) < (b.faulty, b.criterion));
        if better {
            best = Some(Choice { criterion, faulty, controls, bent });
            worse = 0;
        } else {
            worse += 1;
        }
        let next = controls + (controls * GROWTH.0 / GROWTH.1).max(1);
        let sound = best.is_none_or(|b| !b.faulty);
        if worse >= 2 && controls >= faithful && (sound || worse >= HOPELESS)
            || next > most
            || rms <= GOOD * work.size
            || work.cancelled
        {
            break;
        }
        controls = next;
    }
    let (controls, bent) = best.map_or((controls, bent), |b| (b.controls, b.bent));
    work.follows = bent;
    let fit = work.loop_options();
    let state = work.fitted_from(layout, first(layout, degree, controls, bent)?, &fit)?;
    work.keep(&state);
    Ok(state)
}

/// A number of control points that was tried.
#[derive(Clone, Copy)]
struct Choice {
    criterion: f64,
    /// Whether the curve crosses itself where the path does not, or leaves the points.
    faulty: bool,
    controls: usize,
    /// Whether knots were where the path bends, and points followed.
    bent: bool,
}

/// The first curve, with equal spans or with knots where the path bends.
fn first<const D: usize>(
    layout: &Layout<D>,
    degree: usize,
    controls: usize,
    bent: bool,
) -> Result<BsplineCurve<D>, Error> {
    let bent = if bent { layout.bent(degree, controls)? } else { None };
    bent.map_or_else(|| layout.curve(degree, controls), Ok)
}
