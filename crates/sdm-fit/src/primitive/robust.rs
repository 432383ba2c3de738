//! Fits among outliers: random subsets, some of which are free of them ([FB81]), and a few steps towards the nearest points
//! ([RD06]).

use super::descend::{Trial, descend};
use super::minimise::{Minimum, minimise};
use super::model::Model;
use super::random::Random;
use super::search::{distinct, minima};
use super::start::{mean, thinned};
use super::sums::Worth;
use crate::parallel;
use nalgebra::SVector;

/// Points that judge the starts, and those on which the best are improved.
const JUDGES: usize = 200;
const SAMPLE: usize = 500;

/// Chance that no subset is free of outliers up to which subsets are drawn, and most of them.
const UNLIKELY: f64 = 0.01;
const MOST: usize = 2000;

/// Starts for the shapes through a subset, of which there may be several.
const ANSWERS: usize = 6;

/// Starts that take a few steps, those that go on to a minimum, and those that see all points.
const TRIED: usize = 60;
const IMPROVED: usize = 16;
const FINAL: usize = 3;

/// Most rounds in which outliers are told apart again.
const ROUNDS: usize = 60;

/// `σ` of normally distributed values over the median of their absolute values.
const PER_MEDIAN: f64 = 1.482_602_218_505_602;

/// Where Tukey's biweight ends, in `σ`.
pub(super) const TUKEY: f64 = 4.685;

/// The least scale, in units of the cloud and of the rounding of its coordinates: well above what is left of points on a shape.
const LEAST: f64 = 1e-12;
const ROUNDED: f64 = 1e3;

/// Multiple of the least scale up to which the points that count are fitted by least squares.
const NARROW: f64 = 10.0;

/// What is assumed about outliers, in the frame of the cloud.
#[derive(Clone, Copy, Debug)]
pub(super) enum Rule {
    Tukey(Option<f64>),
    Trimmed(f64),
}

impl Rule {
    /// Share of points that a start should be near to.
    fn share(self) -> f64 {
        match self {
            Self::Tukey(_) => 0.5,
            Self::Trimmed(share) => share,
        }
    }
}

/// A robust fit.
pub(super) struct Robust<M> {
    pub(super) minimum: Minimum<M>,
    pub(super) worth: Worth,
    /// Indices of the points that count.
    pub(super) used: Vec<usize>,
    pub(super) subsets: usize,
    pub(super) miss: f64,
}

/// How many of `count` are the given share, at least 1.
fn kept(count: usize, share: f64) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of the count")]
    let kept = (count as f64 * share).round() as usize;
    kept.clamp(1, count)
}

/// Squared distances in ascending order.
fn squares<const D: usize, M: Model<D>>(model: &M, points: &[SVector<f64, D>]) -> Vec<f64> {
    let mut squares: Vec<f64> = points.iter().map(|x| model.distance_sq(x)).collect();
    squares.sort_by(f64::total_cmp);
    squares
}

/// How far the share of points is from a model: the quantile for Tukey's biweight, the mean square of the nearest for trimming.
fn score<const D: usize, M: Model<D>>(model: &M, points: &[SVector<f64, D>], rule: Rule) -> f64 {
    let squares = squares(model, points);
    let count = kept(squares.len(), rule.share());
    match rule {
        Rule::Tukey(None) => squares[count - 1],
        Rule::Tukey(Some(scale)) => squares.iter().map(|d| Worth::Tukey(scale).of(*d).0).sum(),
        Rule::Trimmed(_) => squares[..count].iter().sum::<f64>() / count as f64,
    }
}

/// The probability that none of `subsets` of `size` points is free of outliers.
fn none_clean(inliers: f64, size: usize, subsets: usize) -> f64 {
    let exponent = i32::try_from(size).unwrap_or(i32::MAX);
    (subsets as f64 * (-inliers.powi(exponent)).ln_1p()).exp()
}

/// The best robust fit of many starts.
pub(super) fn robust<const D: usize, M: Model<D>>(
    points: &[SVector<f64, D>],
    rule: Rule,
    rounding: f64,
    limit: usize,
) -> Option<Robust<M>> {
    let judges = thinned(points, JUDGES);
    let sample = thinned(points, SAMPLE);
    let centre = mean(points);
    let size = M::UNKNOWNS.div_ceil(M::ROWS);
    // The biweight of a start that is far off counts outliers as well: half the points draw nearer first.
    let nearing = if let Rule::Tukey(None) = rule { Rule::Trimmed(rule.share()) } else { rule };
    // The fewest inliers that the rule can tell from outliers.
    let share = rule.share().clamp(0.05, 0.99);
    let mut subsets = 1;
    while subsets < MOST && none_clean(share, size, subsets) > UNLIKELY {
        subsets += subsets.div_ceil(8);
    }
    let exact =
        |model: M, subset: &[SVector<f64, D>]| descend(model, subset, Worth::Square, 1e-7, 25, false).model;
    let drawn = parallel::tasks(subsets, |k| {
        let mut random = Random::new(k as u64 + 1_000_000);
        let subset = random.subset(points, size);
        let models = M::from_few(&subset, &mut random, ANSWERS).into_iter().map(|m| exact(m, &subset));
        let scored = models.map(|m| (score(&m, &judges, nearing), m));
        scored.filter(|(s, _)| s.is_finite()).min_by(|a, b| a.0.total_cmp(&b.0))
    });
    let mut starts: Vec<(f64, M)> = drawn.into_iter().flatten().collect();
    // Least squares over all points lead near the shape if outliers are few or all around.
    let all = thinned(points, JUDGES);
    let (trials, ..) = minima::<D, M>(&all, &all, 1, false);
    let trials = distinct(trials, &centre, IMPROVED);
    starts.extend(trials.into_iter().map(|t| (score(&t.model, &judges, nearing), t.model)));
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Shapes with one minimum need no more than a start that is free of outliers.
    let (most, better) = if M::SEVERAL { (TRIED, IMPROVED) } else { (TRIED / 4, IMPROVED / 4) };
    starts.truncate(most);
    let closer = |points: &[SVector<f64, D>], model: M, rounds: usize| {
        let model = concentrated(model, points, nearing, rounds);
        Trial { cost: score(&model, points, nearing), model }
    };
    let mut tried = parallel::tasks(starts.len(), |k| closer(&judges, starts[k].1.clone(), 3));
    tried.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let tried = distinct(tried, &centre, better);
    let mut improved = parallel::tasks(tried.len(), |k| closer(&sample, tried[k].model.clone(), 25));
    improved.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    improved.retain(|t| t.cost.is_finite());
    let best = distinct(improved, &centre, FINAL);
    let ends = parallel::tasks(best.len(), |k| match rule {
        Rule::Trimmed(share) => trimmed(best[k].model.clone(), points, share, limit),
        Rule::Tukey(scale) => tukey(best[k].model.clone(), points, scale, rounding, limit),
    });
    let (minimum, worth, used, _) = chosen(ends, points, rule)?;
    let inliers = used.len() as f64 / points.len() as f64;
    Some(Robust { minimum, worth, used, subsets, miss: none_clean(inliers, size, subsets) })
}

/// A minimum, what distances are worth there, the points that count, and the scale.
type End<M> = (Minimum<M>, Worth, Vec<usize>, f64);

/// The best of a few ends: proper ones first; those that differ in their own scale are compared in the smallest one.
fn chosen<const D: usize, M: Model<D>>(
    ends: Vec<End<M>>,
    points: &[SVector<f64, D>],
    rule: Rule,
) -> Option<End<M>> {
    let scale = ends.iter().map(|end| end.3).fold(f64::INFINITY, f64::min);
    let value = |end: &End<M>| match rule {
        Rule::Tukey(None) => {
            points.iter().map(|x| Worth::Tukey(scale).of(end.0.model.distance_sq(x)).0).sum()
        }
        _ => score(&end.0.model, points, rule),
    };
    let mut valued: Vec<(bool, f64, End<M>)> =
        ends.into_iter().map(|end| (!end.0.model.is_proper(), value(&end), end)).collect();
    valued.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    valued.into_iter().map(|(.., end)| end).next()
}

/// A few rounds of telling outliers apart and descending without them.
fn concentrated<const D: usize, M: Model<D>>(
    mut model: M,
    points: &[SVector<f64, D>],
    rule: Rule,
    rounds: usize,
) -> M {
    let mut last = f64::INFINITY;
    for _ in 0..rounds {
        let before = score(&model, points, rule);
        if before.is_nan() || before >= last * (1.0 - 1e-6) {
            break;
        }
        last = before;
        let next = match rule {
            Rule::Tukey(scale) => {
                let scale = scale.unwrap_or_else(|| scale_at(&model, points).max(LEAST));
                descend(model.clone(), points, Worth::Tukey(scale), 1e-9, 8, false)
            }
            Rule::Trimmed(share) => {
                let used: Vec<_> = nearest(&model, points, share).into_iter().map(|i| points[i]).collect();
                descend(model.clone(), &used, Worth::Square, 1e-9, 8, false)
            }
        };
        model = next.model;
    }
    model
}

/// Where Tukey's biweight ends for a model, by the median of the distances.
fn scale_at<const D: usize, M: Model<D>>(model: &M, points: &[SVector<f64, D>]) -> f64 {
    let squares = squares(model, points);
    TUKEY * PER_MEDIAN * squares[kept(squares.len(), 0.5) - 1].sqrt()
}

/// Indices of the given share of points, the nearest ones, in ascending order.
fn nearest<const D: usize, M: Model<D>>(model: &M, points: &[SVector<f64, D>], share: f64) -> Vec<usize> {
    let mut order: Vec<(f64, usize)> =
        points.iter().enumerate().map(|(i, x)| (model.distance_sq(x), i)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    order.truncate(kept(points.len(), share).max(M::UNKNOWNS.div_ceil(M::ROWS)));
    let mut indices: Vec<usize> = order.into_iter().map(|(_, i)| i).collect();
    indices.sort_unstable();
    indices
}

/// Least squares over the nearest points, the choice of which is repeated until it stays.
fn trimmed<const D: usize, M: Model<D>>(
    start: M,
    points: &[SVector<f64, D>],
    share: f64,
    limit: usize,
) -> End<M> {
    let mut indices = nearest(&start, points, share);
    let fit = |model: M, indices: &[usize]| {
        let used: Vec<_> = indices.iter().map(|&i| points[i]).collect();
        minimise(model, &used, Worth::Square, limit)
    };
    let mut minimum = fit(start, &indices);
    for _ in 0..ROUNDS {
        let next = nearest(&minimum.model, points, share);
        if next == indices {
            break;
        }
        indices = next;
        let before = minimum.iterations;
        minimum = fit(minimum.model, &indices);
        minimum.iterations += before;
    }
    (minimum, Worth::Square, indices, 0.0)
}

/// Tukey's biweight, its scale found together with the shape unless it is given.
fn tukey<const D: usize, M: Model<D>>(
    start: M,
    points: &[SVector<f64, D>],
    scale: Option<f64>,
    rounding: f64,
    limit: usize,
) -> End<M> {
    let least = LEAST.max(ROUNDED * rounding);
    let at = |model: &M| scale.unwrap_or_else(|| scale_at(model, points).max(least));
    let mut current = at(&start);
    let mut minimum = minimise(start, points, Worth::Tukey(current), limit);
    for _ in 0..ROUNDS {
        let next = at(&minimum.model);
        if (next - current).abs() <= 1e-3 * current {
            break;
        }
        current = next;
        let before = minimum.iterations;
        minimum = minimise(minimum.model, points, Worth::Tukey(current), limit);
        minimum.iterations += before;
    }
    let worth = Worth::Tukey(current);
    let counts = |x: &SVector<f64, D>| worth.counts(minimum.model.distance_sq(x));
    let used: Vec<usize> = (0..points.len()).filter(|&i| counts(&points[i])).collect();
    // Points on the shape up to rounding: the biweight is as narrow as that, and no sum to be differentiated.
    if current <= NARROW * least && used.len() >= M::UNKNOWNS.div_ceil(M::ROWS) {
        let places: Vec<_> = used.iter().map(|&i| points[i]).collect();
        let mut finished = minimise(minimum.model, &places, Worth::Square, limit);
        finished.iterations += minimum.iterations;
        return (finished, Worth::Square, used, current);
    }
    (minimum, worth, used, current)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chances_by_hand() {
        // Three pairs, half the points are outliers: none is clean with probability (3/4)³.
        assert!((none_clean(0.5, 2, 3) - 0.421_875).abs() < 1e-15);
        assert!(none_clean(1.0, 7, 1).abs() < 1e-15);
        assert!((none_clean(0.0, 7, 10) - 1.0).abs() < 1e-15);
        assert_eq!((kept(10, 0.25), kept(3, 0.0), kept(3, 1.0)), (3, 1, 3));
    }
}
