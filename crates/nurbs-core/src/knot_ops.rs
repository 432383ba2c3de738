//! Knot vectors made from knot vectors: more knots, a higher degree, a common refinement, a clamped part.

use crate::modify::periodic::{Cycle, multiplicities};
use crate::{Error, Interval, KnotVector, MAX_DEGREE};

impl KnotVector {
    /// The vector with further knots (repetitions count).
    ///
    /// A periodic vector stays periodic: a value stands for all its copies, the end of the domain for
    /// the start. In a floating vector the knots must lie inside the domain.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a knot outside the domain, [`Error::KnotMultiplicity`] where a knot
    /// would occur more than `degree` times (`degree + 1` at a clamped end), [`Error::Argument`] for
    /// the end of a floating domain.
    pub fn inserted(&self, values: &[f64]) -> Result<Self, Error> {
        let domain = self.domain();
        let (start, end) = (domain.start(), domain.end());
        if let Some(&value) = values.iter().find(|&&t| !domain.contains(t)) {
            return Err(Error::Parameter { value, start, end });
        }
        if self.is_periodic() {
            let wrapped: Vec<f64> = values.iter().map(|&t| if t == end { start } else { t }).collect();
            let cycle = Cycle::of(self).with(&wrapped);
            let max = self.degree();
            if let Some((value, multiplicity)) = cycle.multiplicities().into_iter().find(|m| m.1 > max) {
                let index = self.as_slice().iter().position(|&t| t >= value).unwrap_or_default();
                return Err(Error::KnotMultiplicity { index, value, multiplicity, max });
            }
            return cycle.vector(self.degree());
        }
        let all = self.as_slice();
        let (first, last) = (all[0], all[all.len() - 1]);
        if let Some(t) = values.iter().find(|&&t| (t == start && first < start) || (t == end && last > end)) {
            return Err(Error::argument(format!(
                "cannot insert a knot at {t}, the end of a floating domain; clamp the shape first (`clamped`)"
            )));
        }
        let mut knots = all.to_vec();
        knots.extend_from_slice(values);
        knots.sort_by(f64::total_cmp);
        Self::new(self.degree(), knots)
    }

    /// The vector of degree `p + by` on which the same functions live with the same continuity: every
    /// multiplicity is raised by `by`.
    ///
    /// The knots of a floating vector outside its domain are raised too, and cut to the number needed.
    ///
    /// # Errors
    /// [`Error::Degree`] above [`MAX_DEGREE`].
    pub fn elevated(&self, by: usize) -> Result<Self, Error> {
        let (p, domain) = (self.degree(), self.domain());
        let q = p.saturating_add(by);
        if q > MAX_DEGREE {
            return Err(Error::Degree { degree: q });
        }
        if by == 0 {
            return Ok(self.clone());
        }
        if self.is_periodic() {
            let cycle = Cycle::of(self);
            let added: Vec<f64> =
                cycle.multiplicities().iter().flat_map(|m| std::iter::repeat_n(m.0, by)).collect();
            return cycle.with(&added).vector(q);
        }
        let all: Vec<f64> = multiplicities(self.as_slice())
            .into_iter()
            .flat_map(|(t, m)| std::iter::repeat_n(t, m + by))
            .collect();
        // Knot q is the last copy of the start, knot n the first one of the end.
        let first = all.partition_point(|&t| t <= domain.start()) - (q + 1);
        let last = all.partition_point(|&t| t < domain.end()) + q;
        Self::new(q, all[first..=last].to_vec())
    }

    /// The coarsest vector that refines both: each knot with the greater of its two multiplicities.
    ///
    /// Knots are compared exactly. Both vectors must be clamped, or both periodic, with the same degree
    /// and domain; see [`elevated`](Self::elevated), [`reparameterized`](Self::reparameterized).
    ///
    /// # Errors
    /// [`Error::Incompatible`] when degree, domain or kind differ.
    pub fn merged(&self, other: &Self) -> Result<Self, Error> {
        if self.degree() != other.degree() || self.domain() != other.domain() {
            return Err(Error::Incompatible {
                what: format!(
                    "knot vectors of degrees {} and {} on [{}, {}] and [{}, {}] cannot be merged; \
                     bring them to the same degree and domain first",
                    self.degree(),
                    other.degree(),
                    self.domain().start(),
                    self.domain().end(),
                    other.domain().start(),
                    other.domain().end()
                ),
            });
        }
        let same_kind = if self.is_periodic() {
            other.is_periodic()
        } else {
            self.is_clamped() && other.is_clamped() && !other.is_periodic()
        };
        if !same_kind {
            return Err(Error::Incompatible {
                what: "knot vectors can be merged when both are clamped or both are periodic; \
                       use `clamped` on the shapes first"
                    .into(),
            });
        }
        self.inserted(&self.missing(other))
    }

    /// The knots (with repetitions) that `self` lacks of those of `other` in the domain of `self`.
    #[must_use]
    pub fn missing(&self, other: &Self) -> Vec<f64> {
        let counted = |knots: &Self| {
            if knots.is_periodic() { Cycle::of(knots).multiplicities() } else { knots.distinct_knots() }
        };
        let own = counted(self);
        let (mut out, mut k) = (Vec::new(), 0);
        for (t, wanted) in counted(other).into_iter().filter(|m| self.domain().contains(m.0)) {
            while k < own.len() && own[k].0 < t {
                k += 1;
            }
            let present = if k < own.len() && own[k].0 == t { own[k].1 } else { 0 };
            out.extend(std::iter::repeat_n(t, wanted.saturating_sub(present)));
        }
        out
    }

    /// The clamped vector of the part of the domain in `interval`.
    ///
    /// Of a periodic vector the interval may start anywhere and be up to one period long.
    ///
    /// # Errors
    /// [`Error::Parameter`] when an end lies outside the domain, [`Error::Argument`] when the interval
    /// is longer than the period.
    pub fn trimmed(&self, interval: Interval) -> Result<Self, Error> {
        Ok(self.trimmed_in_place(interval)?.reparameterized(interval))
    }

    /// As [`trimmed`](Self::trimmed), with the knots where they are in the first two periods.
    pub(crate) fn trimmed_in_place(&self, interval: Interval) -> Result<Self, Error> {
        let (p, domain) = (self.degree(), self.domain());
        let (mut a, mut b) = (interval.start(), interval.end());
        let inner: Vec<f64> = if self.is_periodic() {
            let (cycle, period) = (Cycle::of(self), domain.length());
            let slack = 4.0 * f64::EPSILON * (a.abs() + b.abs() + period);
            if interval.length() > period + slack {
                return Err(Error::argument(format!(
                    "the interval [{a}, {b}] is longer than the period {period}"
                )));
            }
            let first = p.cast_signed() - cycle.seam.cast_signed();
            let count = 3 * cycle.values.len().cast_signed();
            let knots: Vec<f64> = (first..first + count).map(|i| cycle.at(p, i)).collect();
            // Moving by periods rounds; what was at a knot must stay there.
            let snap = |t: f64| knots.iter().copied().find(|k| (k - t).abs() <= slack).unwrap_or(t);
            a = snap(domain.wrap(interval.start()));
            b = snap(a + interval.length());
            knots.into_iter().filter(|&t| t > a && t < b).collect()
        } else {
            for value in [a, b] {
                if !domain.contains(value) {
                    return Err(Error::Parameter { value, start: domain.start(), end: domain.end() });
                }
            }
            self.as_slice().iter().copied().filter(|&t| t > a && t < b).collect()
        };
        let ends = |t| std::iter::repeat_n(t, p + 1);
        Self::new(p, ends(a).chain(inner).chain(ends(b)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inserts_and_says_what_does_not_fit() {
        let k = KnotVector::uniform_clamped(2, 4).unwrap();
        assert_eq!(k.inserted(&[0.75, 0.5]).unwrap().as_slice(), [0., 0., 0., 0.5, 0.5, 0.75, 1., 1., 1.]);
        assert!(matches!(k.inserted(&[0.5, 0.5]), Err(Error::KnotMultiplicity { multiplicity: 3, .. })));
        assert!(matches!(k.inserted(&[1.0]), Err(Error::KnotMultiplicity { multiplicity: 4, .. })));
        assert!(matches!(k.inserted(&[1.5]), Err(Error::Parameter { .. })));
        assert!(matches!(k.inserted(&[f64::NAN]), Err(Error::Parameter { .. })));
        let floating = KnotVector::new(2, (0..9).map(f64::from).collect()).unwrap();
        assert!(matches!(floating.inserted(&[2.0]), Err(Error::Argument { .. })));
    }

    #[test]
    fn periodic_vectors_stay_periodic() {
        let k = KnotVector::uniform_periodic(2, 4).unwrap();
        let finer = k.inserted(&[1.0, 0.1]).unwrap();
        assert_eq!((finer.distinct_count(), finer.domain()), (6, k.domain()));
        assert!(matches!(
            k.inserted(&[0.0, 1.0]),
            Err(Error::KnotMultiplicity { multiplicity: 3, max: 2, .. })
        ));
        let higher = k.elevated(2).unwrap();
        assert_eq!((higher.degree(), higher.distinct_count()), (4, 12));
    }

    #[test]
    fn merges_and_trims() {
        let a = KnotVector::new(1, vec![0., 0., 0.3, 1., 1.]).unwrap();
        let b = KnotVector::new(1, vec![0., 0., 0.3, 0.6, 1., 1.]).unwrap();
        assert_eq!(a.merged(&b).unwrap(), b);
        assert_eq!(b.merged(&a).unwrap(), b);
        let part = b.trimmed(Interval::new(0.3, 0.9).unwrap()).unwrap();
        assert_eq!(part.as_slice(), [0.3, 0.3, 0.6, 0.9, 0.9]);
        assert!(a.merged(&KnotVector::uniform_periodic(1, 3).unwrap()).is_err());
    }
}
