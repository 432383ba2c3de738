//! Knots where a fit needs them.

use crate::Error;
use nurbs_core::{Interval, KnotVector};

/// Errors of splines of degree 3 fall with about this power of the length of a span.
const ORDER: f64 = 6.0;
/// Largest ratio of the shares of neighbouring spans after one redistribution.
const GRADING: f64 = 1.6;

/// The spans of a knot vector, by their ends.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Spans {
    pub(super) ends: Vec<f64>,
    closed: bool,
}

impl Spans {
    /// Equal spans.
    pub(super) fn uniform(domain: Interval, count: usize, closed: bool) -> Self {
        Self { ends: (0..=count).map(|i| domain.lerp(i as f64 / count as f64)).collect(), closed }
    }

    pub(super) fn count(&self) -> usize {
        self.ends.len() - 1
    }

    /// The span that a parameter lies in.
    pub(super) fn of(&self, t: f64) -> usize {
        self.ends.partition_point(|&end| end <= t).clamp(1, self.count()) - 1
    }

    /// The knots: periodic, or clamped at the ends.
    pub(super) fn knots(&self, degree: usize) -> Result<KnotVector, Error> {
        let n = self.count();
        let period = self.ends[n] - self.ends[0];
        if self.closed {
            // Copies of the inner knots on both sides.
            let at = |i: usize| {
                let turns = (i / n) as f64 - 1.0;
                self.ends[i % n] + turns * period
            };
            return Ok(KnotVector::periodic(degree, (n - degree..=2 * n + degree).map(at).collect())?);
        }
        let mut knots = vec![self.ends[0]; degree];
        knots.extend_from_slice(&self.ends);
        knots.extend(std::iter::repeat_n(self.ends[n], degree));
        Ok(KnotVector::new(degree, knots)?)
    }

    /// Spans such that the errors are more alike: `errors` are mean squares over the spans. What all spans have in common is
    /// taken for noise, which no knot would help.
    pub(super) fn redistributed(&self, errors: &[f64]) -> Self {
        let n = self.count();
        let mut sorted = errors.to_vec();
        sorted.sort_by(f64::total_cmp);
        let noise = sorted[n / 10];
        let floor = (0.05 * sorted[n / 2]).max(f64::MIN_POSITIVE);
        let raw: Vec<f64> =
            errors.iter().map(|e| (e - noise).max(0.0) + floor).map(|e| e.powf(0.5 / ORDER)).collect();
        let beside = |i: usize, step: isize| {
            let k = i as isize + step;
            let k = if self.closed { k.rem_euclid(n as isize) } else { k.clamp(0, n as isize - 1) };
            raw[k.unsigned_abs()]
        };
        // The share of each span, alike in neighbours.
        let mut shares: Vec<f64> =
            (0..n).map(|i| beside(i, -1) / 4.0 + raw[i] / 2.0 + beside(i, 1) / 4.0).collect();
        let mean = shares.iter().sum::<f64>() / n as f64;
        for share in &mut shares {
            *share = (*share / mean).clamp(1.0 / GRADING, GRADING);
        }
        let total: f64 = shares.iter().sum();
        let (mut ends, mut span, mut before) = (vec![self.ends[0]], 0, 0.0);
        for i in 1..n {
            let wanted = total * i as f64 / n as f64;
            while span + 1 < n && before + shares[span] < wanted {
                before += shares[span];
                span += 1;
            }
            let within = (wanted - before) / shares[span];
            ends.push(self.ends[span] + within * (self.ends[span + 1] - self.ends[span]));
        }
        ends.push(self.ends[n]);
        Self { ends, closed: self.closed }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_go_where_errors_are() {
        let unit = Interval::new(0.0, 1.0).unwrap();
        for closed in [false, true] {
            let spans = Spans::uniform(unit, 10, closed);
            let mut errors = vec![1.0; 10];
            errors[4] = 100.0;
            let after = spans.redistributed(&errors);
            let around = after.of(0.45);
            assert!(after.ends[around + 1] - after.ends[around] < 0.08, "{:?}", after.ends);
            assert!(after.ends.windows(2).all(|w| w[0] < w[1]));
            let knots = after.knots(3).unwrap();
            assert_eq!((knots.domain(), knots.is_periodic()), (unit, closed));
            assert_eq!(knots.distinct_count(), if closed { 10 } else { 13 });
            let same = spans.redistributed(&[1.0; 10]);
            assert!(same.ends.iter().zip(&spans.ends).all(|(a, b)| (a - b).abs() < 1e-12));
        }
    }
}
