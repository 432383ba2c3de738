//! The lowest of many minima: starts that the points suggest, random ones, and how likely a lower one was missed.

use super::descend::{Trial, descend};
use super::minimise::{Minimum, minimise};
use super::model::Model;
use super::random::Random;
use super::start::{mean, thinned};
use super::sums::Worth;
use super::{Elements, PrimitiveStatus};
use crate::parallel;
use nalgebra::SVector;

/// Points on which starts are tried.
const SAMPLE: usize = 200;

/// Points on which the best of them are compared before all points are used.
const MIDDLE: usize = 2000;

/// Batches where all shapes through as many points as there are unknowns are looked for.
const EXACT_BATCHES: usize = 4;

/// Share by which two sums of squares on the sample may differ at the same minimum, and distances that count as none there.
const REACHED: f64 = 1e-3;
const NEAR_ZERO: f64 = 1e-7;

/// Steps from each start.
const STEPS: usize = 80;

/// Random starts at once, and batches.
const BATCH: usize = 24;
const BATCHES: usize = 12;

/// Random starts go on until a lower minimum is as unlikely as this.
const UNLIKELY: f64 = 0.01;

/// Minima that are refined on more points, and those among them with which all points are tried.
const REFINED: usize = 8;
const FINAL: usize = 3;

/// Two sums of squares that differ by less than this share are the same.
pub(super) const EQUAL: f64 = 1e-6;

/// The lowest minimum that was found.
pub(super) struct Lowest<M> {
    pub(super) minimum: Minimum<M>,
    /// Different shapes that are as good.
    pub(super) solutions: usize,
    /// Starts that were tried.
    pub(super) starts: usize,
    pub(super) miss: f64,
    /// Whether a shape that is not of the kind is better.
    pub(super) beyond: bool,
}

/// Minima from starts that the points suggest and from batches of random ones, the lowest first, their number, and the chance
/// of a miss; `exact` asks for all minima where the least sum is 0.
pub(super) fn minima<const D: usize, M: Model<D>>(
    points: &[SVector<f64, D>],
    sample: &[SVector<f64, D>],
    batches: usize,
    exact: bool,
) -> (Vec<Trial<M>>, usize, f64) {
    let suggested = M::starts(points);
    let run = |model: M| descend(model, sample, Worth::Square, 1e-7, STEPS, false);
    let mut trials = parallel::tasks(suggested.len(), |k| run(suggested[k].clone()));
    trials.retain(|t| t.cost.is_finite());
    let few = M::UNKNOWNS.div_ceil(M::ROWS);
    let mut miss = 0.0;
    let batches = if M::SEVERAL { batches } else { 1 };
    for batch in 0..batches {
        if batch > 0 && miss <= UNLIKELY && !(exact && batch < EXACT_BATCHES) {
            break;
        }
        let size = if M::SEVERAL { BATCH } else { M::RANDOM_STARTS };
        let found = parallel::tasks(size, |k| {
            let mut random = Random::new((batch * BATCH + k) as u64);
            let subset = random.subset(sample, few);
            M::from_few(&subset, &mut random, 1).into_iter().map(run).collect::<Vec<_>>()
        });
        trials.extend(found.into_iter().flatten().filter(|t| t.cost.is_finite()));
        trials.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        miss = if M::RANDOM_STARTS == 0 && !M::SEVERAL { 0.0 } else { missed(&trials, sample.len()) };
    }
    let starts = trials.len();
    (trials, starts, miss)
}

/// The probability `(1 − h/n)ⁿ` that all of `n` starts miss a minimum that is reached as easily as the lowest one, which was
/// reached by `h` of them.
fn missed<M>(trials: &[Trial<M>], points: usize) -> f64 {
    let Some(least) = trials.first() else { return 1.0 };
    let bound = least.cost * (1.0 + REACHED) + points as f64 * NEAR_ZERO * NEAR_ZERO;
    let reached = trials.iter().filter(|t| t.cost <= bound).count() as f64;
    let starts = trials.len() as f64;
    (1.0 - reached / starts).powf(starts)
}

/// Whether two shapes are the same up to what separates minima.
fn same<const D: usize>(a: &Elements<D>, b: &Elements<D>) -> bool {
    let size = |e: &Elements<D>| {
        1.0 + e.location.norm() + e.radius.unwrap_or(0.0).abs() + e.minor_radius.unwrap_or(0.0).abs()
    };
    let near = 1e-5 * size(a).min(size(b));
    let direction = match (&a.direction, &b.direction) {
        (Some(a), Some(b)) => (a - b).norm().min((a + b).norm()),
        _ => 0.0,
    };
    let number = |a: Option<f64>, b: Option<f64>| a.zip(b).map_or(0.0, |(a, b)| (a - b).abs());
    (a.location - b.location).norm() <= near
        && direction <= 1e-5
        && number(a.radius, b.radius) <= near
        && number(a.minor_radius, b.minor_radius) <= near
        && number(a.half_angle, b.half_angle) <= 1e-5
}

/// One of each kind, the lowest first.
pub(super) fn distinct<const D: usize, M: Model<D>>(
    trials: Vec<Trial<M>>,
    centre: &SVector<f64, D>,
    count: usize,
) -> Vec<Trial<M>> {
    let mut kept: Vec<(Elements<D>, Trial<M>)> = Vec::new();
    for trial in trials {
        if kept.len() == count {
            break;
        }
        let elements = trial.model.elements(centre);
        if !kept.iter().any(|(other, _)| same(other, &elements)) {
            kept.push((elements, trial));
        }
    }
    kept.into_iter().map(|(_, trial)| trial).collect()
}

/// The least sum of squares over all points; `floor` is the sum that rounding leaves of points on a shape, `exact` tells that
/// there are no more points than the unknowns need.
pub(super) fn least_squares<const D: usize, M: Model<D>>(
    points: &[SVector<f64, D>],
    floor: f64,
    exact: bool,
    limit: usize,
) -> Option<Lowest<M>> {
    let sample = thinned(points, SAMPLE);
    let centre = mean(points);
    let (trials, starts, mut miss) = minima::<D, M>(points, &sample, BATCHES, exact);
    // Descents on the sample end before the last digits.
    let worst = 4.0 * trials.first()?.cost + sample.len() as f64 * NEAR_ZERO;
    // Proper shapes first among equals would hide better ones: of both kinds the lowest are refined.
    let (proper, other): (Vec<_>, Vec<_>) = trials.into_iter().partition(|t| t.model.is_proper());
    let count = if exact { 3 * REFINED } else { REFINED };
    let mut few = distinct(proper, &centre, count);
    few.extend(distinct(other, &centre, REFINED));
    few.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    if points.len() > MIDDLE {
        let middle = thinned(points, MIDDLE);
        let near: Vec<_> = few.iter().enumerate().filter(|(k, t)| *k == 0 || t.cost <= worst).collect();
        let mut better = parallel::tasks(near.len(), |k| {
            descend(near[k].1.model.clone(), &middle, Worth::Square, 1e-7, STEPS, false)
        });
        better.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        better = distinct(better, &centre, FINAL);
        if !better.iter().any(|t| t.model.is_proper()) {
            better.extend(few.into_iter().find(|t| t.model.is_proper()));
        }
        few = better;
    } else {
        // The best proper one in any case.
        let first = few.iter().position(|t| t.model.is_proper()).unwrap_or(0);
        let keeps = |(k, t): (usize, Trial<M>)| (k == 0 || k == first || t.cost <= worst).then_some(t);
        few = few.into_iter().enumerate().filter_map(keeps).collect();
    }
    let mut ends =
        parallel::tasks(few.len(), |k| minimise(few[k].model.clone(), points, Worth::Square, limit));
    ends.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let bound = |cost: f64, share: f64| cost * (1.0 + share) + floor;
    let lowest = ends.first()?.cost;
    if lowest <= 4.0 * floor && !exact {
        // Nothing is below 0.
        miss = 0.0;
    }
    // One that left the proper shapes on its way is brought back.
    let proper: Vec<_> = ends.iter().filter(|m| m.model.is_proper()).collect();
    let Some(least) = proper.first() else {
        let minimum =
            at_the_boundary(ends.iter().map(|m| &m.model).chain(few.iter().map(|t| &t.model)), points)?;
        return Some(Lowest { minimum, solutions: 1, starts, miss, beyond: true });
    };
    // Among equals one that converged.
    let equal = |m: &&&Minimum<M>| m.cost <= bound(least.cost, 1e-9);
    let chosen =
        proper.iter().filter(equal).find(|m| m.status == PrimitiveStatus::Converged).unwrap_or(least);
    let mut shapes: Vec<Elements<D>> = Vec::new();
    for other in proper.iter().filter(|m| m.cost <= bound(least.cost, EQUAL)) {
        let elements = other.model.elements(&centre);
        if other.status == PrimitiveStatus::Converged && !shapes.iter().any(|s| same(s, &elements)) {
            shapes.push(elements);
        }
    }
    let beyond = bound(lowest, 1e-9) < chosen.cost;
    Some(Lowest { minimum: (*chosen).clone(), solutions: shapes.len().max(1), starts, miss, beyond })
}

/// The best proper shape near ones that are not.
fn at_the_boundary<'a, const D: usize, M: Model<D> + 'a>(
    models: impl Iterator<Item = &'a M>,
    points: &[SVector<f64, D>],
) -> Option<Minimum<M>> {
    let near = models.filter_map(|model| model.clone().made_proper());
    let trials = near.map(|model| descend(model, points, Worth::Square, 1e-9, STEPS, true));
    let best = trials.filter(|t| t.cost.is_finite()).min_by(|a, b| a.cost.total_cmp(&b.cost))?;
    Some(Minimum {
        model: best.model,
        cost: best.cost,
        status: PrimitiveStatus::OnBoundary,
        iterations: STEPS,
        conditioning: 0.0,
    })
}
