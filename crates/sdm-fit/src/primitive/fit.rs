//! From points to a shape: frame, search, report.

use super::apart::is_apart;
use super::elements::{Elements, PrimitiveFit};
use super::minimise::{Minimum, covariance};
use super::model::Model;
use super::robust::{Rule, robust};
use super::search::least_squares;
use super::start::{mean, rank};
use super::sums::Worth;
use super::{PrimitiveOptions, PrimitiveOutliers, PrimitiveStatus};
use crate::Error;
use nalgebra::SVector;

/// Chance of a miss above which a minimum is doubtful.
const DOUBTFUL: f64 = 0.05;

/// The points in a frame about their middle, in units of about their size (a power of 2, so that scaling is exact).
pub(super) struct Cloud<const D: usize> {
    pub(super) points: Vec<SVector<f64, D>>,
    pub(super) centre: SVector<f64, D>,
    pub(super) scale: f64,
    /// Index of each point in the input.
    indices: Vec<usize>,
}

impl<const D: usize> Cloud<D> {
    fn new(points: &[SVector<f64, D>], needed: usize) -> Result<Self, Error> {
        let (indices, finite): (Vec<_>, Vec<_>) =
            points.iter().copied().enumerate().filter(|(_, p)| p.iter().all(|c| c.is_finite())).unzip();
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
        Ok(Self { points, centre, scale, indices })
    }

    /// Number of different points among some.
    fn different(&self, used: &[usize]) -> usize {
        let mut bits: Vec<[u64; D]> =
            used.iter().map(|&i| std::array::from_fn(|k| (self.points[i][k] + 0.0).to_bits())).collect();
        bits.sort_unstable();
        bits.dedup();
        bits.len()
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
}

/// What a search found.
struct Outcome<M> {
    minimum: Minimum<M>,
    worth: Worth,
    /// Indices of the points that count.
    used: Vec<usize>,
    solutions: usize,
    starts: usize,
    miss: f64,
}

/// Fits a model, given how many dimensions the points must span.
pub(super) fn fit<const D: usize, M: Model<D>>(
    points: &[SVector<f64, D>],
    options: &PrimitiveOptions,
    shape: &'static str,
    dimensions: usize,
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
    let floor = cloud.points.len() as f64 * rounding * rounding;
    let everything: Vec<usize> = (0..cloud.points.len()).collect();
    let rule = match options.outliers {
        PrimitiveOutliers::None => None,
        PrimitiveOutliers::Trimmed { outliers } => Some(Rule::Trimmed(1.0 - outliers)),
        PrimitiveOutliers::Tukey { abs_scale } => Some(Rule::Tukey(abs_scale.map(|s| s / scale))),
    };
    let redundancy = |used: &[usize]| (cloud.different(used) * M::ROWS).saturating_sub(M::UNKNOWNS);
    let limit = options.max_iterations;
    let mut outcome = if let Some(rule) = rule {
        let found = robust::<D, M>(&cloud.points, rule, rounding, limit).ok_or_else(|| degenerate.clone())?;
        let (mut minimum, used) = (found.minimum, found.used);
        if minimum.status == PrimitiveStatus::Converged
            && !is_apart(&minimum.model, &cloud.points, &used, rule)
        {
            minimum.status = PrimitiveStatus::Doubtful;
        }
        let (worth, starts, miss) = (found.worth, found.subsets, found.miss);
        Outcome { minimum, worth, used, solutions: 1, starts, miss }
    } else {
        let exact = redundancy(&everything) == 0;
        let found =
            least_squares::<D, M>(&cloud.points, floor, exact, limit).ok_or_else(|| degenerate.clone())?;
        let mut minimum = found.minimum;
        if found.beyond {
            minimum.status = PrimitiveStatus::OnBoundary;
        }
        let (solutions, starts, miss) = (found.solutions, found.starts, found.miss);
        Outcome { minimum, worth: Worth::Square, used: everything, solutions, starts, miss }
    };
    let redundancy = redundancy(&outcome.used);
    let status = &mut outcome.minimum.status;
    if !outcome.minimum.model.is_proper() {
        outcome.minimum.model = outcome.minimum.model.clone().made_proper().ok_or(degenerate)?;
        *status = PrimitiveStatus::OnBoundary;
    } else if *status == PrimitiveStatus::Converged {
        if outcome.solutions > 1 || (M::SEVERAL && redundancy == 0) {
            *status = PrimitiveStatus::Ambiguous;
        } else if outcome.miss > DOUBTFUL {
            *status = PrimitiveStatus::Doubtful;
        }
    }
    let used = outcome.used.iter().map(|&i| cloud.points[i]).collect::<Vec<_>>();
    let fit = report(&outcome, &cloud, &used, redundancy, points.len(), options);
    Ok(Found { model: outcome.minimum.model, cloud, used, fit })
}

fn report<const D: usize, M: Model<D>>(
    outcome: &Outcome<M>,
    cloud: &Cloud<D>,
    used: &[SVector<f64, D>],
    redundancy: usize,
    total: usize,
    options: &PrimitiveOptions,
) -> PrimitiveFit<(), D> {
    let minimum = &outcome.minimum;
    let model = &minimum.model;
    let centre = mean(used);
    let elements: Elements<D> = model.elements(&centre);
    let mut rows = Vec::new();
    if options.covariance && minimum.status != PrimitiveStatus::Undetermined {
        let matrix = covariance(minimum, used, outcome.worth, &centre);
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
    // Distances in the frame of the cloud, positive outside.
    let signed = |x: &SVector<f64, D>| {
        let [a, b] = model.residuals(x);
        if M::ROWS == 1 { a * model.outside() } else { a.hypot(b) }
    };
    let mut residuals = vec![f64::NAN; total];
    for (x, &index) in cloud.points.iter().zip(&cloud.indices) {
        residuals[index] = signed(x) * cloud.scale;
    }
    let mut worst: Vec<usize> = outcome.used.iter().map(|&i| cloud.indices[i]).collect();
    let counted = worst.iter().map(|&i| residuals[i]);
    let [low, high] = counted.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], r| [a.min(r), b.max(r)]);
    worst.sort_by(|&a, &b| residuals[b].abs().total_cmp(&residuals[a].abs()).then(a.cmp(&b)));
    worst.truncate(options.worst);
    let sum: f64 = used.iter().map(|x| model.distance_sq(x)).sum();
    PrimitiveFit {
        shape: (),
        elements: elements.placed(&cloud.centre, cloud.scale),
        status: minimum.status,
        rms: (sum / used.len().max(1) as f64).sqrt() * cloud.scale,
        max: low.abs().max(high.abs()),
        iterations: minimum.iterations,
        points: total,
        dropped: total - cloud.points.len(),
        used: used.len(),
        residuals,
        form_error: if M::ROWS == 1 { high - low } else { 2.0 * high },
        worst,
        redundancy,
        solutions: outcome.solutions,
        starts: outcome.starts,
        miss_probability: outcome.miss,
        conditioning: minimum.conditioning,
        covariance: rows,
    }
}
