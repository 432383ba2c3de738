//! Statistics of deviations.

use crate::{Distribution, ExactSum};

/// Shares of the points below the quantiles that are reported. The outermost two enclose as much as ±3 standard deviations
/// of a normal distribution.
pub(crate) const SHARES: [f64; 11] = [0.00135, 0.01, 0.05, 0.1, 0.25, 0.5, 0.75, 0.9, 0.95, 0.99, 0.99865];

/// A value that a share of all values does not exceed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Quantile {
    /// The share, between 0 and 1.
    pub share: f64,
    /// The value, interpolated linearly between neighbours in order.
    pub value: f64,
}

/// The distribution of signed distances, in their unit.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Statistics {
    /// Number of values.
    pub count: u64,
    /// Smallest value (most negative, where distances have a sign).
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Arithmetic mean.
    pub mean: f64,
    /// Mean of the absolute values.
    pub mean_abs: f64,
    /// Mean of the values above 0; `None` (JSON: `null`) if there is none.
    pub mean_positive: Option<f64>,
    /// Mean of the values below 0; `None` if there is none.
    pub mean_negative: Option<f64>,
    /// Root of the mean square.
    pub rms: f64,
    /// Variance about the mean (n − 1); 0 for a single value.
    pub variance: f64,
    /// Standard deviation about the mean (n − 1).
    pub standard_deviation: f64,
    /// Quantiles, by ascending share.
    pub quantiles: Vec<Quantile>,
    /// Whether the quantiles come from the values themselves; otherwise they are within a relative `1.3e-4`.
    pub quantiles_exact: bool,
}

impl Statistics {
    /// Statistics of the finite values, `None` if there is none.
    #[must_use]
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut moments = Moments::new(usize::MAX);
        moments.extend(values);
        moments.statistics()
    }

    /// The quantile of one of the reported shares.
    #[must_use]
    pub fn quantile(&self, share: f64) -> Option<f64> {
        self.quantiles.iter().find(|quantile| quantile.share == share).map(|quantile| quantile.value)
    }
}

/// Sums and distribution from which [`Statistics`] are made; the same for any order of values and any parts.
///
/// ```
/// use inspection::Moments;
///
/// let (mut all, mut rest) = (Moments::new(1000), Moments::new(1000));
/// all.extend([1.0, 2.0]);
/// rest.extend([6.0]);
/// all.merge(&rest)?;
/// assert_eq!(all.statistics().map(|s| (s.count, s.mean)), Some((3, 3.0)));
/// # Ok::<(), inspection::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Moments {
    positive: u64,
    negative: u64,
    sum_positive: ExactSum,
    sum_negative: ExactSum,
    sum_squares: ExactSum,
    pub(crate) distribution: Distribution,
    /// Smallest and largest value as bits of a double, so that files keep each of them.
    extremes: Option<[u64; 2]>,
}

impl Moments {
    /// No values yet; up to `exact_limit` of them are kept, so that quantiles are exact.
    #[must_use]
    pub fn new(exact_limit: usize) -> Self {
        Self {
            positive: 0,
            negative: 0,
            sum_positive: ExactSum::default(),
            sum_negative: ExactSum::default(),
            sum_squares: ExactSum::default(),
            distribution: Distribution::new(exact_limit),
            extremes: None,
        }
    }

    /// Adds values. NaN and infinities are ignored.
    pub fn extend(&mut self, values: impl IntoIterator<Item = f64>) {
        // A zero has no sign.
        let values: Vec<f64> = values.into_iter().filter(|v| v.is_finite()).map(|v| v + 0.0).collect();
        for &value in &values {
            if value > 0.0 {
                self.positive += 1;
                self.sum_positive.add(value);
            } else if value < 0.0 {
                self.negative += 1;
                self.sum_negative.add(value);
            }
            self.sum_squares.add_square(value);
            self.widen(value, value);
        }
        self.distribution.extend(values);
    }

    /// Adds the values of other sums.
    ///
    /// # Errors
    /// [`Error::DifferentOptions`](crate::Error::DifferentOptions) if the limits differ.
    pub fn merge(&mut self, other: &Self) -> Result<(), crate::Error> {
        self.positive += other.positive;
        self.negative += other.negative;
        self.sum_positive.merge(&other.sum_positive);
        self.sum_negative.merge(&other.sum_negative);
        self.sum_squares.merge(&other.sum_squares);
        if let Some([min, max]) = other.extremes {
            self.widen(f64::from_bits(min), f64::from_bits(max));
        }
        self.distribution.merge(&other.distribution)
    }

    /// Number of finite values.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.distribution.count()
    }

    /// Keeps the values no more, as if there were more than the limit.
    pub fn count_in_cells(&mut self) {
        self.distribution.count_in_cells();
    }

    fn widen(&mut self, min: f64, max: f64) {
        let [low, high] = self.extremes.map_or([min, max], |bits| bits.map(f64::from_bits));
        self.extremes = Some([low.min(min), high.max(max)].map(f64::to_bits));
    }

    /// The statistics; `None` without values.
    #[must_use]
    pub fn statistics(&self) -> Option<Statistics> {
        let [min, max] = self.extremes?.map(f64::from_bits);
        let count = self.distribution.count();
        let n = count as f64;
        let mut sum = self.sum_positive.clone();
        sum.merge(&self.sum_negative);
        let (positive, negative) = (self.sum_positive.value(), self.sum_negative.value());
        let mean = (sum.value() / n).clamp(min, max);
        let about = self.sum_squares.about(&sum, mean, count);
        let standard_deviation = about.root_mean(count.saturating_sub(1));
        let mean_of = |sum: f64, count: u64| (count > 0).then(|| sum / count as f64);
        let quantiles = self.distribution.quantiles(&SHARES);
        let quantiles = SHARES.into_iter().zip(quantiles);
        Some(Statistics {
            count,
            min,
            max,
            mean,
            mean_abs: (positive - negative) / n,
            mean_positive: mean_of(positive, self.positive),
            mean_negative: mean_of(negative, self.negative),
            rms: self.sum_squares.root_mean(count),
            variance: about.value() / count.saturating_sub(1).max(1) as f64,
            standard_deviation,
            quantiles: quantiles
                .map(|(share, value)| Quantile { share, value: value.clamp(min, max) })
                .collect(),
            quantiles_exact: self.distribution.is_exact(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_closed_forms() {
        let s = Statistics::of((-50..=50).map(f64::from).chain([f64::NAN])).unwrap();
        assert_eq!((s.count, s.min, s.max, s.mean), (101, -50.0, 50.0, 0.0));
        assert_eq!((s.mean_positive, s.mean_negative), (Some(25.5), Some(-25.5)));
        assert_eq!((s.variance, s.mean_abs), (858.5, 2550.0 / 101.0));
        assert!((s.rms - 850f64.sqrt()).abs() < 1e-14);
        assert!((s.standard_deviation - 858.5f64.sqrt()).abs() < 1e-14);
        assert_eq!((s.quantile(0.5), s.quantile(0.99)), (Some(0.0), Some(49.0)));
        assert!(s.quantiles_exact);
    }

    #[test]
    fn extreme_and_missing_values() {
        let s = Statistics::of([3e200, -4e200]).unwrap();
        assert!((s.rms / 12.5f64.sqrt() / 1e200 - 1.0).abs() < 1e-15);
        assert!((s.standard_deviation / 24.5f64.sqrt() / 1e200 - 1.0).abs() < 1e-15);
        let s = Statistics::of([-0.0]).unwrap();
        assert_eq!((s.standard_deviation, s.mean_positive, s.mean_negative), (0.0, None, None));
        assert!(s.min.is_sign_positive());
        assert_eq!(Statistics::of([f64::NAN]), None);
        // In cells, too, quantiles lie between the smallest and the largest value.
        let mut moments = Moments::new(2);
        moments.extend([1.0, 1.0, 1.0 + f64::EPSILON, 1.0]);
        let s = moments.statistics().unwrap();
        assert!(
            !s.quantiles_exact && s.quantiles.iter().all(|q| (s.min..=s.max).contains(&q.value)),
            "{s:?}"
        );
        let mut moments = Moments::new(2);
        moments.extend([-1.0; 4]);
        let s = moments.statistics().unwrap();
        assert!(s.quantiles.iter().all(|q| q.value == -1.0), "{s:?}");
        // A small spread far from zero keeps its digits.
        let s = Statistics::of([1e9 + 1.0, 1e9 + 2.0, 1e9 + 3.0]).unwrap();
        assert_eq!((s.mean, s.variance, s.standard_deviation), (1e9 + 2.0, 1.0, 1.0));
    }
}
