//! From points to a shape: frame, start, minimum, report.

use super::elements::{Elements, PrimitiveFit};
use super::minimise::{Minimum, approach, covariance, minimise};
use super::model::Model;
use super::start::{mean, rank, thinned};
use super::sums::{Worth, cost};
use super::{PrimitiveOptions, PrimitiveOutliers, PrimitiveStatus};
use crate::Error;
use nalgebra::SVector;

/// Points that choose among the starts.
const CHOOSERS: usize = 500;

/// Steps from each start before the choice.
const CHOICE_STEPS: usize = 25;

/// Random subsets that give starts when there are outliers.
const SUBSETS: u64 = 40;

/// Most rounds in which outliers are told apart again.
const ROUNDS: usize = 60;

/// `σ` of normally distributed values over the median of their absolute values.
const PER_MEDIAN: f64 = 1.482_602_218_505_602;

/// The points in a frame about their middle, in units of about their size (a power of 2, so that scaling is exact).
pub(super) struct Cloud<const D: usize> {
    pub(super) points: Vec<SVector<f64, D>>,
    pub(super) centre: SVector<f64, D>,
    pub(super) scale: f64,
}

impl<const D: usize> Cloud<D> {
    fn new(points: &[SVector<f64, D>], needed: usize) -> Result<Self, Error> {
        let finite: Vec<_> = points.iter().filter(|p| p.iter().all(|c| c.is_finite())).copied().collect();
        let too_few = Error::TooFewPoints { total: points.len(), finite: finite.len(), needed };
        let Some(first) = finite.first() else { return Err(too_few) };
        if finite.len() < needed {
            return Err(too_few);
        }
        let (low, high) = finite.iter().fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
        // Halves first: the difference of the largest doubles is not one.
        let half = high / 2.0 - low / 2.0;
        let size = half.amax();
        if size.is_nan() || size <= f64::MIN_POSITIVE * 1e20 {
            return Err(Error::Degenerate { shape: "any shape", what: "in one place" });
        }
        let scale = size.log2().ceil().exp2();
        let centre = low + half;
        let points = finite.iter().map(|p| (p - centre) / scale).collect();
        Ok(Self { points, centre, scale })
    }
}

/// A shape in the frame of the cloud, and what is said about it.
pub(super) struct Found<M, const D: usize> {
    pub(super) model: M,
    pub(super) cloud: Cloud<D>,
    /// The points that count, in the frame of the cloud.
    pub(super) used: Vec<SVector<f64, D>>,
    /// The report, without the shape.
    pub(super) fit: PrimitiveFit<(), D>,
}

impl<M, const D: usize> Found<M, D> {
    /// A point in the coordinates of the input.
    pub(super) fn place(&self, x: &SVector<f64, D>) -> SVector<f64, D> {
        self.cloud.centre + x * self.cloud.scale
    }

    /// Interval of a function over the points that count.
    pub(super) fn extent(&self, f: impl Fn(&SVector<f64, D>) -> f64) -> [f64; 2] {
        self.used.iter().map(f).fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)])
    }

    /// The report with a shape.
    pub(super) fn with_shape<S>(self, shape: S) -> PrimitiveFit<S, D> {
        let fit = self.fit;
        PrimitiveFit {
            shape,
            elements: fit.elements,
            status: fit.status,
            rms: fit.rms,
            max: fit.max,
            iterations: fit.iterations,
            points: fit.points,
            dropped: fit.dropped,
            used: fit.used,
            conditioning: fit.conditioning,
            covariance: fit.covariance,
        }
    }
}

/// Fits a model, given how starts are found and how many dimensions the points must span.
pub(super) fn fit<const D: usize, M: Model<D>>(
    points: &[SVector<f64, D>],
    options: &PrimitiveOptions,
    shape: &'static str,
    dimensions: usize,
    starts: impl Fn(&[SVector<f64, D>]) -> Vec<M> + Sync,
) -> Result<Found<M, D>, Error> {
    options.check()?;
    let cloud = Cloud::new(points, M::UNKNOWNS.div_ceil(M::ROWS))?;
    let scale = cloud.scale;
    let degenerate =
        Error::Degenerate { shape, what: ["in one place", "on a line", "on a plane"][dimensions - 1] };
    // Coordinates far from the origin are rounded there.
    let rounding = 4.0 * f64::EPSILON * (1.0 + cloud.centre.amax() / scale);
    if rank(&cloud.points, rounding) < dimensions {
        return Err(degenerate);
    }
    let limit = options.max_iterations;
    let (minimum, used, worth) = match options.outliers {
        PrimitiveOutliers::None => {
            let start = chosen(starts(&cloud.points), &cloud.points).ok_or(degenerate)?;
            (minimise(start, &cloud.points, Worth::Square, limit), cloud.points.clone(), Worth::Square)
        }
        PrimitiveOutliers::Trimmed { share } => {
            let start = robust_start(&cloud.points, share, &starts).ok_or(degenerate)?;
            let (minimum, used) = trimmed(start, &cloud.points, share, limit);
            (minimum, used, Worth::Square)
        }
        PrimitiveOutliers::Tukey { abs_scale } => {
            let start = robust_start(&cloud.points, 0.5, &starts).ok_or(degenerate)?;
            let (minimum, worth) = tukey(start, &cloud.points, abs_scale.map(|s| s / scale), limit);
            let counts = |x: &&SVector<f64, D>| worth.counts(minimum.model.distance_sq(x));
            let used = cloud.points.iter().filter(counts).copied().collect();
            (minimum, used, worth)
        }
    };
    let fit = report(&minimum, &cloud, &used, worth, points.len(), options.covariance);
    Ok(Found { model: minimum.model, cloud, used, fit })
}

fn report<const D: usize, M: Model<D>>(
    minimum: &Minimum<M>,
    cloud: &Cloud<D>,
    used: &[SVector<f64, D>],
    worth: Worth,
    total: usize,
    with_covariance: bool,
) -> PrimitiveFit<(), D> {
    let centre = mean(used);
    let elements: Elements<D> = minimum.model.elements(&centre);
    let squares = used.iter().map(|x| minimum.model.distance_sq(x));
    let (sum, max) = squares.fold((0.0, 0.0f64), |(sum, max), d| (sum + d, max.max(d)));
    let mut rows = Vec::new();
    if with_covariance && minimum.status != PrimitiveStatus::Undetermined {
        let matrix = covariance(minimum, used, worth, &centre);
        // Lengths come back in the units of the input; directions and angles have none.
        let directions = elements.direction.map_or(0, |_| D);
        let unit = |i: usize| {
            let angle = elements.half_angle.is_some() && i == elements.values().len() - 1;
            if (D..D + directions).contains(&i) || angle { 1.0 } else { cloud.scale }
        };
        if let Some(m) = matrix {
            let row = |i: usize| (0..m.ncols()).map(|j| m[(i, j)] * unit(i) * unit(j)).collect();
            rows = (0..m.nrows()).map(row).collect();
        }
    }
    PrimitiveFit {
        shape: (),
        elements: elements.placed(&cloud.centre, cloud.scale),
        status: minimum.status,
        rms: (sum / used.len().max(1) as f64).sqrt() * cloud.scale,
        max: max.sqrt() * cloud.scale,
        iterations: minimum.iterations,
        points: total,
        dropped: total - cloud.points.len(),
        used: used.len(),
        conditioning: minimum.conditioning,
        covariance: rows,
    }
}

/// The start that leads to the lowest sum of squares in a few steps on some of the points.
fn chosen<const D: usize, M: Model<D>>(starts: Vec<M>, points: &[SVector<f64, D>]) -> Option<M> {
    let sample = thinned(points, CHOOSERS);
    let refined = starts.into_iter().map(|model| {
        let mut found = Minimum {
            cost: cost(&model, &sample, Worth::Square),
            model,
            status: PrimitiveStatus::MaxIterations,
            iterations: 0,
            conditioning: 0.0,
        };
        approach(&mut found, &sample, Worth::Square, 1e-6, CHOICE_STEPS);
        found
    });
    refined
        .filter(|found| found.cost.is_finite())
        .min_by(|a, b| a.cost.total_cmp(&b.cost))
        .map(|found| found.model)
}

/// The value below which a share of the squared distances lies.
fn quantile_sq<const D: usize, M: Model<D>>(model: &M, points: &[SVector<f64, D>], share: f64) -> f64 {
    let mut squares: Vec<f64> = points.iter().map(|x| model.distance_sq(x)).collect();
    squares.sort_by(f64::total_cmp);
    squares[kept(squares.len(), share) - 1]
}

/// How many of `count` are the given share, at least 1.
fn kept(count: usize, share: f64) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of the count")]
    let kept = (count as f64 * share).round() as usize;
    kept.clamp(1, count)
}

/// The start with the smallest quantile of the distances, from random subsets of the points: some are free of outliers.
fn robust_start<const D: usize, M: Model<D>>(
    points: &[SVector<f64, D>],
    share: f64,
    starts: &(impl Fn(&[SVector<f64, D>]) -> Vec<M> + Sync),
) -> Option<M> {
    let sample = thinned(points, CHOOSERS);
    let size = M::UNKNOWNS + 3;
    let candidate = |k: u64| -> Option<(f64, M)> {
        let subset: Vec<_> = if k == 0 {
            sample.clone()
        } else {
            // Weyl sequence of the golden ratio: as good as random numbers here, and the same everywhere.
            let mut state = k.wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let mut next = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let index = (state >> 33) as usize % sample.len();
                sample[index]
            };
            (0..size).map(|_| next()).collect()
        };
        let model = chosen(starts(&subset), &subset)?;
        let score = quantile_sq(&model, &sample, share);
        score.is_finite().then_some((score, model))
    };
    #[expect(clippy::cast_possible_truncation, reason = "a small number")]
    let found = crate::parallel::tasks(SUBSETS as usize, |k| candidate(k as u64));
    found.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, model)| model)
}

/// Least squares over the nearest share of the points, until the same ones are nearest again.
fn trimmed<const D: usize, M: Model<D>>(
    start: M,
    points: &[SVector<f64, D>],
    share: f64,
    limit: usize,
) -> (Minimum<M>, Vec<SVector<f64, D>>) {
    let count = kept(points.len(), share).max(M::UNKNOWNS.div_ceil(M::ROWS)).min(points.len());
    let nearest = |model: &M| {
        let mut order: Vec<(f64, usize)> =
            points.iter().enumerate().map(|(i, x)| (model.distance_sq(x), i)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut indices: Vec<usize> = order[..count].iter().map(|(_, i)| *i).collect();
        indices.sort_unstable();
        indices
    };
    let mut indices = nearest(&start);
    let mut used: Vec<_> = indices.iter().map(|&i| points[i]).collect();
    let mut minimum = minimise(start, &used, Worth::Square, limit);
    for _ in 0..ROUNDS {
        let next = nearest(&minimum.model);
        if next == indices {
            break;
        }
        indices = next;
        used = indices.iter().map(|&i| points[i]).collect();
        let before = minimum.iterations;
        minimum = minimise(minimum.model, &used, Worth::Square, limit);
        minimum.iterations += before;
    }
    (minimum, used)
}

/// Tukey's biweight, its scale found together with the shape unless it is given.
fn tukey<const D: usize, M: Model<D>>(
    start: M,
    points: &[SVector<f64, D>],
    scale: Option<f64>,
    limit: usize,
) -> (Minimum<M>, Worth) {
    // Not below what rounding leaves of points on the shape.
    let scale_at = |model: &M| {
        scale.unwrap_or_else(|| (4.685 * PER_MEDIAN * quantile_sq(model, points, 0.5).sqrt()).max(1e-12))
    };
    let mut current = scale_at(&start);
    let mut minimum = minimise(start, points, Worth::Tukey(current), limit);
    for _ in 0..ROUNDS {
        let next = scale_at(&minimum.model);
        if (next - current).abs() <= 1e-3 * current {
            break;
        }
        current = next;
        let before = minimum.iterations;
        minimum = minimise(minimum.model, points, Worth::Tukey(current), limit);
        minimum.iterations += before;
    }
    (minimum, Worth::Tukey(current))
}
