//! Statistics of distances.

use serde::Serialize;

/// Shares of the points below the quantiles that are reported.
const SHARES: [f64; 9] = [0.01, 0.05, 0.1, 0.25, 0.5, 0.75, 0.9, 0.95, 0.99];

/// A value that a share of all values does not exceed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Quantile {
    /// The share, between 0 and 1.
    pub(crate) share: f64,
    /// The value, interpolated linearly between neighbours in order.
    pub(crate) value: f64,
}

/// The distribution of distances, in the unit of the file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Statistics {
    /// Number of values.
    pub(crate) count: usize,
    /// Smallest value (most negative, where distances have a sign).
    pub(crate) min: f64,
    /// Largest value.
    pub(crate) max: f64,
    /// Arithmetic mean.
    pub(crate) mean: f64,
    /// Mean of the absolute values.
    pub(crate) mean_abs: f64,
    /// Root of the mean square.
    pub(crate) rms: f64,
    /// Standard deviation about the mean (n − 1).
    pub(crate) standard_deviation: f64,
    /// Quantiles.
    pub(crate) quantiles: Vec<Quantile>,
}

impl Statistics {
    /// Statistics of the finite values, `None` if there is none.
    pub(crate) fn of(values: impl Iterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.filter(|value| value.is_finite()).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let (&min, &max) = (sorted.first()?, sorted.last()?);
        let count = sorted.len();
        let n = count as f64;
        // Relative to the largest value, so that squares neither overflow nor vanish.
        let scale = min.abs().max(max.abs());
        let scale = if scale > 0.0 { scale } else { 1.0 };
        let mean_of = |f: &dyn Fn(f64) -> f64| sorted.iter().map(|value| f(value / scale)).sum::<f64>() / n;
        let mean = mean_of(&|x| x);
        let variance = mean_of(&|x| (x - mean) * (x - mean)) * n / (n - 1.0).max(1.0);
        Some(Self {
            count,
            min,
            max,
            mean: mean * scale,
            mean_abs: mean_of(&f64::abs) * scale,
            rms: mean_of(&|x| x * x).sqrt() * scale,
            standard_deviation: variance.sqrt() * scale,
            quantiles: SHARES.map(|share| Quantile { share, value: quantile(&sorted, share) }).to_vec(),
        })
    }

    /// The quantile of one of the reported shares.
    pub(crate) fn quantile(&self, share: f64) -> Option<f64> {
        self.quantiles.iter().find(|quantile| quantile.share == share).map(|quantile| quantile.value)
    }
}

/// The quantile of sorted values, interpolated linearly at `share · (n − 1)`.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 ≤ place ≤ n − 1")]
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = share * (sorted.len() - 1) as f64;
    let below = place.floor() as usize;
    let above = (below + 1).min(sorted.len() - 1);
    let part = place - place.floor();
    sorted[below] * (1.0 - part) + sorted[above] * part
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_closed_forms() {
        let s = Statistics::of((-50..=50).map(f64::from).chain([f64::NAN])).unwrap();
        assert_eq!((s.count, s.min, s.max), (101, -50.0, 50.0));
        assert!(s.mean.abs() < 1e-14);
        assert!((s.rms - 850f64.sqrt()).abs() < 1e-12);
        assert!((s.standard_deviation - 858.5f64.sqrt()).abs() < 1e-12);
        assert!((s.mean_abs - 2550.0 / 101.0).abs() < 1e-12);
        assert_eq!(s.quantile(0.5), Some(0.0));
        assert_eq!(s.quantile(0.99), Some(49.0));
    }

    #[test]
    fn extreme_and_missing_values() {
        let s = Statistics::of([3e200, -4e200].into_iter()).unwrap();
        assert!((s.rms / 12.5f64.sqrt() / 1e200 - 1.0).abs() < 1e-15);
        assert_eq!(Statistics::of([0.0].into_iter()).unwrap().standard_deviation, 0.0);
        assert_eq!(Statistics::of([f64::NAN].into_iter()), None);
    }
}
