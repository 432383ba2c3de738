//! One period of a periodic knot vector, and the vector that it unrolls to.

use crate::{Error, Interval, KnotVector};

/// The knots of one period.
///
/// With `m` knots in a period, knot `k` of the vector is `values[k − p + seam]`, continued to all
/// integers by the period.
#[derive(Clone, Debug)]
pub(crate) struct Cycle {
    /// The knots in `[start, end)`, in order; the first is the start of the domain.
    pub(crate) values: Vec<f64>,
    /// How many copies of the start stand before knot `p` of the vector.
    pub(crate) seam: usize,
    /// The domain.
    pub(crate) domain: Interval,
}

impl Cycle {
    /// The period of a periodic vector.
    pub(crate) fn of(knots: &KnotVector) -> Self {
        let (p, domain) = (knots.degree(), knots.domain());
        let all = knots.as_slice();
        let seam = all[..p].iter().filter(|&&t| t == domain.start()).count();
        // Copies of the start that stand before knot p return at the end of the period.
        let wrap = |t: f64| if t >= domain.end() { domain.start() } else { t };
        let mut values: Vec<f64> = all[p..knots.basis_count()].iter().map(|&t| wrap(t)).collect();
        values.sort_by(f64::total_cmp);
        Self { values, seam, domain }
    }

    /// Knot number `k` counted from the first copy of the start.
    fn knot(&self, k: isize) -> f64 {
        let m = self.values.len().cast_signed();
        let value = self.values[k.rem_euclid(m).cast_unsigned()];
        let turn = k.div_euclid(m);
        if turn == 1 && value == self.domain.start() {
            // Exact, whatever rounding does to start + period.
            self.domain.end()
        } else {
            value + turn as f64 * self.domain.length()
        }
    }

    /// Knot `i` of the vector of degree `p`, for any integer.
    pub(crate) fn at(&self, p: usize, i: isize) -> f64 {
        self.knot(i - p.cast_signed() + self.seam.cast_signed())
    }

    /// The periodic vector of degree `p`.
    pub(crate) fn vector(&self, p: usize) -> Result<KnotVector, Error> {
        let count = (self.values.len() + 2 * p + 1).cast_signed();
        KnotVector::periodic(p, (0..count).map(|i| self.at(p, i)).collect())
    }

    /// The same cycle with further knots of `[start, end)`; those at the seam stand before knot `p`.
    pub(crate) fn with(&self, added: &[f64]) -> Self {
        let mut values = self.values.clone();
        values.extend_from_slice(added);
        values.sort_by(f64::total_cmp);
        let at_seam = added.iter().filter(|&&t| t == self.domain.start()).count();
        Self { values, seam: self.seam + at_seam, domain: self.domain }
    }

    /// Distinct knots of the period with their multiplicities.
    pub(crate) fn multiplicities(&self) -> Vec<(f64, usize)> {
        multiplicities(&self.values)
    }
}

/// Distinct values of a sorted list with their multiplicities.
pub(crate) fn multiplicities(sorted: &[f64]) -> Vec<(f64, usize)> {
    sorted.chunk_by(|a, b| a == b).map(|run| (run[0], run.len())).collect()
}
