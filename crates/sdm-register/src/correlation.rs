//! How far the residuals of neighbouring points depend on each other.
//!
//! A scanner's errors are alike at neighbouring points. Of points denser than that, many count for one: the covariance of a pose
//! grows by the sum of the correlations of a point with all others, `1 + ∫ ρ(h) dN(h)`, with `N(h)` the number of points up to the
//! distance `h`, as long as the rows of the Jacobian hardly change up to where the correlation ends.

use crate::iterate::Outcome;
use crate::source::Prepared;
use nalgebra::SVector;

/// Fewest points of which a correlation is estimated.
const FEWEST: usize = 300;
/// Pairs per lag, about, in the order of the points, in which neighbours follow each other.
const PER_LAG: usize = 3000;
/// Growth of the lags, and of the distances of one class of pairs to the next.
const LAGS: f64 = 1.3;
const CLASSES: f64 = 1.3;
/// Fewest pairs of a class: with fewer, chance would end the sum where it begins.
const PAIRS: usize = 400;
/// Standard errors of a mean of independent products below which the nearest class says nothing, and those below which a later one
/// ends the sum: what is left out makes the covariance too small.
const SIGNIFICANT: f64 = 3.5;
const ENDING: f64 = 1.5;
/// Points whose distances tell how many neighbours one has.
const COUNTED: usize = 600;

/// What correlation does to a mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Correlation {
    /// Number of points that count as one.
    pub(crate) per_independent: f64,
    /// Distance up to which residuals are correlated, in the unit of the model; 0 for none.
    pub(crate) length: f64,
}

impl Correlation {
    /// Of residuals that are independent.
    pub(crate) const NONE: Self = Self { per_independent: 1.0, length: 0.0 };

    /// Of the points that count in an outcome.
    pub(crate) fn of<const D: usize>(outcome: &Outcome<D>, cloud: &Prepared<D>) -> Self {
        let view = &outcome.view;
        let counts = |i: &usize| {
            outcome.base[*i] > 0.0
                && outcome.weighting.evaluate(view.distance(*i)).weight > 0.0
                && view.frames[*i].tangent_dimension == D - 1
        };
        let used: Vec<usize> = (0..cloud.points.len()).filter(counts).collect();
        if used.len() < FEWEST {
            return Self::NONE;
        }
        let points: Vec<SVector<f64, D>> = used.iter().map(|&i| cloud.points[i] * view.pose.scale).collect();
        // As vectors, since the sides of normals may be arbitrary.
        let residuals: Vec<SVector<f64, D>> =
            used.iter().map(|&i| view.frames[i].normal() * view.frames[i].distance).collect();
        Self::of_residuals(&points, &residuals)
    }

    fn of_residuals<const D: usize>(points: &[SVector<f64, D>], residuals: &[SVector<f64, D>]) -> Self {
        let n = points.len();
        let variance = residuals.iter().map(SVector::norm_squared).sum::<f64>() / n as f64;
        let mut pairs: Vec<(f64, f64)> = Vec::new();
        for lag in lags(n / 2) {
            let step = ((n - lag) / PER_LAG).max(1);
            pairs.extend((0..n - lag).step_by(step).map(|i| {
                let product = residuals[i].dot(&residuals[i + lag]);
                ((points[i] - points[i + lag]).norm(), product / variance)
            }));
        }
        pairs.retain(|(distance, product)| *distance > 0.0 && product.is_finite());
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let neighbours = Neighbours::of(points);
        let (mut sum, mut length, mut start) = (1.0, 0.0, 0);
        while start < pairs.len() {
            let first = pairs[start].0;
            let mut end = start + pairs[start..].partition_point(|pair| pair.0 <= first * CLASSES);
            end = end.max((start + PAIRS).min(pairs.len()));
            let class = &pairs[start..end];
            let mean = class.iter().map(|pair| pair.1).sum::<f64>() / class.len() as f64;
            let least = if start == 0 { SIGNIFICANT } else { ENDING };
            if mean * (class.len() as f64).sqrt() < least {
                break;
            }
            // Half-way to the next class: points on a grid have few different distances.
            let last = class[class.len() - 1].0;
            let reach = pairs.get(end).map_or(last, |next| (last * next.0).sqrt());
            sum += mean * (neighbours.up_to(reach) - neighbours.up_to(length)).max(0.0);
            length = reach;
            start = end;
        }
        if length == 0.0 { Self::NONE } else { Self { per_independent: sum.min(n as f64), length } }
    }
}

/// `1, 2, 3, …`, later further apart, up to `most`.
fn lags(most: usize) -> Vec<usize> {
    let mut lags = Vec::new();
    let mut next = 1.0f64;
    while next <= most as f64 {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 1 and `most`")]
        lags.push(next as usize);
        next = (next * LAGS).max(next + 1.0);
    }
    lags
}

/// The mean number of other points up to a distance.
struct Neighbours {
    /// All distances of some of the points, in order.
    distances: Vec<f64>,
    /// Points for one of these distances.
    per_distance: f64,
    /// The distance below which there are too few of these, and the power with which the number grows up to there.
    close: f64,
    power: i32,
}

impl Neighbours {
    fn of<const D: usize>(points: &[SVector<f64, D>]) -> Self {
        let step = points.len().div_ceil(COUNTED).max(1);
        let some: Vec<&SVector<f64, D>> = points.iter().step_by(step).collect();
        let m = some.len();
        let mut distances: Vec<f64> = (0..m)
            .flat_map(|i| (0..i).map(move |j| (i, j)))
            .map(|(i, j)| (some[i] - some[j]).norm())
            .collect();
        distances.sort_by(f64::total_cmp);
        let per_distance = 2.0 / m as f64 * (points.len() - 1) as f64 / (m - 1).max(1) as f64;
        let close = distances.get(4 * m).or(distances.last()).copied().unwrap_or(0.0);
        Self { distances, per_distance, close, power: if D == 2 { 1 } else { 2 } }
    }

    fn up_to(&self, distance: f64) -> f64 {
        let counted =
            |distance: f64| self.distances.partition_point(|d| *d <= distance) as f64 * self.per_distance;
        if distance >= self.close || self.close <= 0.0 {
            counted(distance)
        } else {
            counted(self.close) * (distance / self.close).powi(self.power)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::start::random::Random;
    use nalgebra::Vector3;

    /// A square of `side × side` points; each residual is the sum of the `width × width` independent numbers around it.
    fn square(side: usize, width: usize, seed: u64) -> Correlation {
        let mut random = Random::new(seed);
        let all = side + width;
        let noise: Vec<f64> = (0..all * all).map(|_| random.unit() - 0.5).collect();
        let (mut points, mut residuals) = (Vec::new(), Vec::new());
        for i in 0..side {
            for j in 0..side {
                let sum: f64 = (0..width * width).map(|k| noise[(i + k / width) * all + j + k % width]).sum();
                points.push(Vector3::new(i as f64, j as f64, 0.0));
                residuals.push(Vector3::z() * sum);
            }
        }
        let at: Vec<nalgebra::Point3<f64>> = points.iter().copied().map(Into::into).collect();
        let order = mesh_core::spatial_order(&at).unwrap();
        let pick = |all: &[Vector3<f64>]| order.iter().map(|&k| all[k as usize]).collect::<Vec<_>>();
        Correlation::of_residuals(&pick(&points), &pick(&residuals))
    }

    #[test]
    fn independent_residuals_stay_so() {
        let found: Vec<f64> = (0..20).map(|seed| square(60, 1, seed).per_independent).collect();
        assert!(found.iter().filter(|f| **f != 1.0).count() <= 1, "{found:?}");
    }

    #[test]
    fn sums_of_neighbours_count_as_many_as_they_have() {
        // The sum of the correlations of a moving sum is the number of its terms.
        for width in [3, 6, 10] {
            let found: Vec<f64> = (0..6).map(|seed| square(150, width, seed).per_independent).collect();
            let mean = found.iter().sum::<f64>() / found.len() as f64;
            let expected = (width * width) as f64;
            assert!(mean > 0.7 * expected && mean < 1.4 * expected, "{width}: {mean} {found:?}");
        }
    }
}
