//! Histograms whose bars end at the limits of the tolerance.

use crate::{Distribution, Tolerance};

/// About this many bars.
const BARS: f64 = 60.0;
/// At most this many.
const MOST_BARS: usize = 200;

/// How many values lie in each of many intervals of the same width.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Histogram {
    /// Where the first interval begins.
    pub start: f64,
    /// Width of each interval. An interval includes its lower end; the last one includes both.
    pub width: f64,
    /// Values per interval.
    pub counts: Vec<u64>,
    /// Values below the first interval.
    pub below: u64,
    /// Values above the last one.
    pub above: u64,
}

impl Histogram {
    /// The bars that show the bulk of the values: the tails beyond a thousandth on either side, when they are far away,
    /// are counted as `below` and `above`. Limits of the tolerance fall on ends of intervals, unless the values spread
    /// over more than fifteen times its width. `None` without values.
    pub(crate) fn of(values: &Distribution, tolerance: &Tolerance) -> Option<Self> {
        let bulk = values.quantiles(&[0.0, 0.001, 0.999, 1.0]);
        let [min, low, high, max] = bulk.try_into().ok()?;
        let reach = 0.25 * (high - low);
        let (low, high) = (min.max(low - reach), max.min(high + reach));
        let (origin, width) = grid(low, high, tolerance);
        let first = ((low - origin) / width).floor();
        let last = ((high - origin) / width).ceil().max(first + 1.0);
        let start = origin + first * width;
        if !(start.is_finite() && width > 0.0 && start + width > start) {
            // Values so close together, or so large, that no interval fits between them.
            return Some(Self {
                start: min,
                width: max - min,
                counts: vec![values.count()],
                below: 0,
                above: 0,
            });
        }
        let mut counts = vec![0; bar(last - first).clamp(1, MOST_BARS)];
        let (mut below, mut above) = (0, 0);
        let end = origin + last * width;
        for (value, weight) in values.weighted() {
            let place = ((value - origin) / width).floor() - first;
            if place < 0.0 {
                below += weight;
            } else if let Some(count) = counts.get_mut(bar(place)) {
                *count += weight;
            } else if value <= end
                && let Some(count) = counts.last_mut()
            {
                *count += weight;
            } else {
                above += weight;
            }
        }
        Some(Self { start, width, counts, below, above })
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturates, which is what is wanted"
)]
fn bar(place: f64) -> usize {
    place as usize
}

/// An end of an interval, and the width of intervals, for values between `low` and `high`.
fn grid(low: f64, high: f64, tolerance: &Tolerance) -> (f64, f64) {
    let spread = (high - low).max(f64::MIN_POSITIVE);
    let band = tolerance.upper - tolerance.lower;
    let wished = spread / BARS;
    let parts = band / wished;
    // Even numbers, so that zero is an end too where the tolerance is symmetric.
    let even = [2.0, 4.0, 8.0, 10.0, 16.0, 20.0, 40.0, 50.0, 80.0, 100.0, 160.0, 200.0, 400.0, 1000.0];
    let divisor = even.into_iter().find(|&n| n >= parts).filter(|_| parts >= 0.25 * BARS / 15.0);
    match divisor {
        Some(divisor) if band.is_finite() => (tolerance.lower, band / divisor),
        _ => (tolerance.target().clamp(-f64::MAX, f64::MAX), round_up(wished)),
    }
}

/// The next number of the form 1, 2 or 5 times a power of ten.
fn round_up(width: f64) -> f64 {
    let power = 10f64.powf(width.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|step| step * power).find(|&step| step >= width).unwrap_or(width)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn histogram(values: &[f64], half: f64) -> Histogram {
        let mut distribution = Distribution::new(100_000);
        distribution.extend(values.iter().copied());
        Histogram::of(&distribution, &Tolerance::symmetric(half).unwrap()).unwrap()
    }

    #[test]
    fn limits_of_the_tolerance_are_ends_of_intervals() {
        let values: Vec<f64> = (0..10_000).map(|i| (f64::from(i) * 0.1).sin()).collect();
        for half in [0.05, 0.1, 0.5, 3.0, 10.0] {
            let histogram = histogram(&values, half);
            assert_eq!(histogram.counts.iter().sum::<u64>() + histogram.below + histogram.above, 10_000);
            let place = (half - histogram.start) / histogram.width;
            assert!((place - place.round()).abs() < 1e-9, "{half} {place}");
            assert!((15..=MOST_BARS).contains(&histogram.counts.len()), "{half} {}", histogram.counts.len());
        }
    }

    #[test]
    fn odd_distributions() {
        let same = histogram(&[0.3; 5], 0.1);
        assert_eq!(same.counts.iter().sum::<u64>(), 5);
        let far = histogram(
            &[vec![0.0; 5000], (0..5000).map(|i| f64::from(i) * 1e-6).collect(), vec![1e6, -1e6]].concat(),
            0.1,
        );
        assert_eq!((far.below, far.above), (1, 1));
        let wide = histogram(&[-1e9, 0.0, 1e9], 1e-9);
        assert_eq!(wide.counts.iter().sum::<u64>(), 3);
        assert!(wide.counts.len() <= MOST_BARS);
        assert!(Histogram::of(&Distribution::new(5), &Tolerance::symmetric(1.0).unwrap()).is_none());
        let huge = histogram(&[-f64::MAX, f64::MAX], 1.0);
        assert_eq!(huge.counts.iter().sum::<u64>() + huge.above + huge.below, 2);
    }
}
