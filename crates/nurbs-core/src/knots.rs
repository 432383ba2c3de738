//! Validated knot vectors.

use crate::span_table::SpanTable;
use crate::{Break, Error, Interval};

/// Highest degree that the kernel evaluates; basis functions live in arrays of this size on the stack.
pub const MAX_DEGREE: usize = 25;

/// Relative slack (of the period) when the knots of a periodic vector are compared.
const PERIOD_TOLERANCE: f64 = 1e-9;

/// A non-decreasing knot vector `t_0 ≤ … ≤ t_{n+p}` together with the degree `p`.
///
/// It carries `n = len − p − 1` basis functions on the domain `[t_p, t_n]`. The ends may be clamped
/// (multiplicity `p + 1`), floating, or periodic: then `t_{i+n−p} = t_i + T` with the period
/// `T = t_n − t_p`, and the last `p` control points of a shape repeat the first ones.
/// Inner knots, and all knots of a periodic vector, have multiplicity at most `p`, so that every shape is
/// continuous.
///
/// A vector is never repaired: what does not fit is an error.
#[derive(Clone, Debug, PartialEq)]
pub struct KnotVector {
    degree: usize,
    knots: Vec<f64>,
    periodic: bool,
    table: SpanTable,
}

impl KnotVector {
    /// A clamped or floating knot vector of the given degree.
    ///
    /// # Errors
    /// Says which knot breaks which rule: degree outside `1..=`[`MAX_DEGREE`], too few knots, values
    /// that are not finite or decrease, multiplicities above `p` inside or `p + 1` at the ends,
    /// an empty domain.
    pub fn new(degree: usize, knots: Vec<f64>) -> Result<Self, Error> {
        validate(degree, &knots)?;
        Ok(Self::assemble(degree, knots, false))
    }

    /// A periodic knot vector: all `n + p + 1` knots, those outside the domain included.
    ///
    /// # Errors
    /// As [`new`](Self::new), and [`Error::NotPeriodic`] where the knots do not repeat. The seam is an inner
    /// knot of the periodic shape: a multiplicity of `p + 1`, which would tear the shape open there, is
    /// [`Error::KnotMultiplicity`].
    pub fn periodic(degree: usize, knots: Vec<f64>) -> Result<Self, Error> {
        validate(degree, &knots)?;
        let n = knots.len() - degree - 1;
        if n < 2 * degree {
            // Fewer than p distinct control points: the repeated ones would overlap.
            return Err(Error::TooFewKnots { found: knots.len(), degree, needed: 3 * degree + 1 });
        }
        let period = knots[n] - knots[degree];
        for i in 0..=2 * degree {
            let expected = knots[i] + period;
            let value = knots[i + n - degree];
            if (value - expected).abs() > PERIOD_TOLERANCE * period {
                return Err(Error::NotPeriodic { index: i + n - degree, value, expected, period });
            }
        }
        check_multiplicities(&knots, |_| degree)?;
        Ok(Self::assemble(degree, knots, true))
    }

    /// From parts that are known to be valid.
    fn assemble(degree: usize, knots: Vec<f64>, periodic: bool) -> Self {
        let table = SpanTable::new(degree, &knots);
        Self { degree, knots, periodic, table }
    }

    /// Spans and reciprocals worked out in advance.
    pub(crate) fn table(&self) -> &SpanTable {
        &self.table
    }

    /// The clamped vector with `n` basis functions and equally spaced inner knots on `[0, 1]`.
    ///
    /// # Errors
    /// When the degree is not supported or `n < degree + 1`.
    pub fn uniform_clamped(degree: usize, n: usize) -> Result<Self, Error> {
        if n < degree + 1 {
            return Err(Error::TooFewKnots { found: n + degree + 1, degree, needed: 2 * (degree + 1) });
        }
        let spans = n - degree;
        let inner = (1..spans).map(|i| i as f64 / spans as f64);
        let ends = degree + 1;
        let knots =
            std::iter::repeat_n(0.0, ends).chain(inner).chain(std::iter::repeat_n(1.0, ends)).collect();
        Self::new(degree, knots)
    }

    /// The periodic vector on `[0, 1]` with `distinct` equal spans, for `distinct` control points
    /// that are followed by a repetition of the first `degree`.
    ///
    /// # Errors
    /// When the degree is not supported or `distinct < degree`.
    pub fn uniform_periodic(degree: usize, distinct: usize) -> Result<Self, Error> {
        let m = distinct as f64;
        let knots = (0..=distinct + 2 * degree).map(|i| (i as f64 - degree as f64) / m).collect();
        Self::periodic(degree, knots)
    }

    /// The clamped vector of a single Bézier segment on `interval`.
    ///
    /// # Errors
    /// When the degree is not supported.
    pub fn bezier(degree: usize, interval: Interval) -> Result<Self, Error> {
        let knots = std::iter::repeat_n(interval.start(), degree + 1)
            .chain(std::iter::repeat_n(interval.end(), degree + 1))
            .collect();
        Self::new(degree, knots)
    }

    /// Degree `p`.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// All knots, in order.
    #[must_use]
    pub fn as_slice(&self) -> &[f64] {
        &self.knots
    }

    /// Number of basis functions `n`, which is the number of control points.
    #[must_use]
    pub fn basis_count(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    /// Number of control points that are not repetitions: `n`, or `n − p` when periodic.
    #[must_use]
    pub fn distinct_count(&self) -> usize {
        if self.periodic { self.basis_count() - self.degree } else { self.basis_count() }
    }

    /// Whether the vector is periodic.
    #[must_use]
    pub fn is_periodic(&self) -> bool {
        self.periodic
    }

    /// Whether both ends have multiplicity `p + 1`, so that the shape starts and ends at control points.
    #[must_use]
    pub fn is_clamped(&self) -> bool {
        let (p, n) = (self.degree, self.basis_count());
        self.knots[0] == self.knots[p] && self.knots[n] == self.knots[n + p]
    }

    /// The domain `[t_p, t_n]`.
    #[must_use]
    pub fn domain(&self) -> Interval {
        Interval::from_ordered(self.knots[self.degree], self.knots[self.basis_count()])
    }

    /// The period, when periodic.
    #[must_use]
    pub fn period(&self) -> Option<f64> {
        self.periodic.then(|| self.domain().length())
    }

    /// `t` brought into the domain: wrapped when periodic, clamped otherwise.
    #[must_use]
    pub fn normalize(&self, t: f64) -> f64 {
        if self.periodic { self.domain().wrap(t) } else { self.domain().clamp(t) }
    }

    /// Index `i` of the span with `t_i ≤ t < t_{i+1}` (the last non-empty one at the end of the domain).
    ///
    /// Parameters outside the domain get the first or last span of the domain ([PT97, A2.1]).
    #[must_use]
    #[inline]
    pub fn span(&self, t: f64) -> usize {
        self.table.span(&self.knots, t)
    }

    /// [`span`](Self::span) where no search is needed for it.
    #[inline(always)]
    pub(crate) fn span_without_search(&self, t: f64) -> Option<usize> {
        self.table.span_without_search(t)
    }

    /// [`span`](Self::span) with a guess: when `t` lies in span `hint` no search is made.
    #[must_use]
    pub fn span_from(&self, t: f64, hint: usize) -> usize {
        let valid = hint >= self.degree && hint < self.basis_count();
        if valid && self.knots[hint] <= t && t < self.knots[hint + 1] { hint } else { self.span(t) }
    }

    /// Indices of all non-empty spans of the domain, in order.
    pub fn spans(&self) -> impl Iterator<Item = usize> + '_ {
        (self.degree..self.basis_count()).filter(|&i| self.knots[i + 1] > self.knots[i])
    }

    /// The parameter interval of a non-empty span.
    #[must_use]
    pub fn span_interval(&self, span: usize) -> Interval {
        Interval::from_ordered(self.knots[span], self.knots[span + 1])
    }

    /// How often `t` occurs among all knots (exact comparison).
    #[must_use]
    pub fn multiplicity(&self, t: f64) -> usize {
        self.knots.iter().filter(|&&k| k == t).count()
    }

    /// The distinct knots of the closed domain with their multiplicities.
    #[must_use]
    pub fn distinct_knots(&self) -> Vec<(f64, usize)> {
        let domain = self.domain();
        let mut out: Vec<(f64, usize)> = Vec::new();
        for &t in self.knots.iter().filter(|&&t| domain.contains(t)) {
            match out.last_mut() {
                Some((value, count)) if *value == t => *count += 1,
                _ => out.push((t, 1)),
            }
        }
        out
    }

    /// The distinct knots in the interior of the domain.
    #[must_use]
    pub fn breaks(&self) -> Vec<f64> {
        let domain = self.domain();
        let mut inner: Vec<f64> =
            self.knots.iter().copied().filter(|&t| domain.start() < t && t < domain.end()).collect();
        inner.dedup();
        inner
    }

    /// The knots at which a shape is less than twice continuously differentiable: inside the domain,
    /// and at its start if periodic.
    #[must_use]
    pub fn derivative_breaks(&self) -> Vec<Break> {
        let domain = self.domain();
        self.distinct_knots()
            .into_iter()
            .filter(|&(t, _)| t < domain.end() && (t > domain.start() || self.periodic))
            .map(|(parameter, count)| Break { parameter, continuity: self.degree.saturating_sub(count) })
            .filter(|b| b.continuity < 2)
            .collect()
    }

    /// The Greville abscissa `(t_{i+1} + … + t_{i+p}) / p` of every basis function.
    ///
    /// Of a periodic vector only the first `n − p` are distinct up to the period.
    #[must_use]
    pub fn greville(&self) -> Vec<f64> {
        (0..self.basis_count()).map(|i| self.greville_at(i)).collect()
    }

    /// The Greville abscissa of basis function `i`.
    pub(crate) fn greville_at(&self, i: usize) -> f64 {
        let p = self.degree;
        self.knots[i + 1..=i + p].iter().sum::<f64>() / p as f64
    }

    /// The same basis on another domain: knots mapped by the affine map that takes the domain to `to`.
    #[must_use]
    pub fn reparameterized(&self, to: Interval) -> Self {
        let from = self.domain();
        let scale = to.length() / from.length();
        let map = |t: f64| {
            // The ends of the domain must map exactly, or the clamped ends come apart.
            if t == from.start() {
                to.start()
            } else if t == from.end() {
                to.end()
            } else {
                to.start() + (t - from.start()) * scale
            }
        };
        Self::assemble(self.degree, self.knots.iter().map(|&t| map(t)).collect(), self.periodic)
    }

    /// The knots of the same shape run through backwards: `t ↦ start + end − t`.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let domain = self.domain();
        let sum = domain.start() + domain.end();
        let mirror = |t: f64| {
            if t == domain.start() {
                domain.end()
            } else if t == domain.end() {
                domain.start()
            } else {
                sum - t
            }
        };
        Self::assemble(self.degree, self.knots.iter().rev().map(|&t| mirror(t)).collect(), self.periodic)
    }

    /// Clamped knots for interpolation at the parameters `params` by averaging ([PT97, eq. (9.8)]).
    ///
    /// # Errors
    /// When there are fewer than `degree + 1` parameters or they do not increase strictly.
    pub fn averaged(degree: usize, params: &[f64]) -> Result<Self, Error> {
        let n = params.len();
        if n < degree + 1 || degree == 0 {
            return Err(Error::TooFewKnots { found: n + degree + 1, degree, needed: 2 * (degree + 1) });
        }
        if let Some(index) = params.windows(2).position(|w| w[0].is_nan() || w[1].is_nan() || w[0] >= w[1]) {
            return Err(Error::argument(format!(
                "interpolation parameters must increase strictly, but parameter {} ({}) is not below parameter {} ({})",
                index,
                params[index],
                index + 1,
                params[index + 1]
            )));
        }
        let inner = (1..n - degree).map(|j| params[j..j + degree].iter().sum::<f64>() / degree as f64);
        let ends = degree + 1;
        let knots = std::iter::repeat_n(params[0], ends)
            .chain(inner)
            .chain(std::iter::repeat_n(params[n - 1], ends))
            .collect();
        Self::new(degree, knots)
    }
}

fn validate(degree: usize, knots: &[f64]) -> Result<(), Error> {
    if degree == 0 || degree > MAX_DEGREE {
        return Err(Error::Degree { degree });
    }
    let needed = 2 * (degree + 1);
    if knots.len() < needed {
        return Err(Error::TooFewKnots { found: knots.len(), degree, needed });
    }
    if let Some(index) = knots.iter().position(|k| !k.is_finite()) {
        return Err(Error::NonFiniteKnot { index, value: knots[index] });
    }
    if let Some(i) = knots.windows(2).position(|w| w[1] < w[0]) {
        return Err(Error::DecreasingKnot { index: i + 1, value: knots[i + 1], previous: knots[i] });
    }
    let n = knots.len() - degree - 1;
    if knots[degree] == knots[n] {
        return Err(Error::EmptyDomain { degree, last: n, value: knots[n] });
    }
    let at_an_end = |value: f64| value <= knots[degree] || value >= knots[n];
    check_multiplicities(knots, |value| if at_an_end(value) { degree + 1 } else { degree })
}

/// Checks that no knot occurs more often than `max` says of its value.
fn check_multiplicities(knots: &[f64], max: impl Fn(f64) -> usize) -> Result<(), Error> {
    let mut index = 0;
    for run in knots.chunk_by(|a, b| a == b) {
        let (value, multiplicity, max) = (run[0], run.len(), max(run[0]));
        if multiplicity > max {
            return Err(Error::KnotMultiplicity { index, value, multiplicity, max });
        }
        index += multiplicity;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_of_clamped_vector() {
        let k = KnotVector::new(2, vec![0., 0., 0., 1., 1., 3., 4., 4., 4.]).unwrap();
        assert_eq!((k.span(-1.0), k.span(0.0), k.span(1.0), k.span(3.5), k.span(4.0)), (2, 2, 4, 5, 5));
        assert_eq!(k.spans().collect::<Vec<_>>(), [2, 4, 5]);
        assert_eq!(k.greville(), [0.0, 0.5, 1.0, 2.0, 3.5, 4.0]);
        assert_eq!(k.distinct_knots(), [(0.0, 3), (1.0, 2), (3.0, 1), (4.0, 3)]);
        assert_eq!(k.span(f64::NAN), 2);
        let breaks: Vec<_> = k.derivative_breaks().iter().map(|b| (b.parameter, b.continuity)).collect();
        assert_eq!(breaks, [(1.0, 0), (3.0, 1)]);
    }

    #[test]
    fn rejects_with_the_exact_place() {
        let new = |knots: &[f64]| KnotVector::new(2, knots.to_vec());
        assert!(matches!(new(&[0., 0., 0., 1., 1.]), Err(Error::TooFewKnots { needed: 6, .. })));
        assert!(matches!(
            new(&[0., 0., 0., 1., 1., 1., 2., 2., 2.]),
            Err(Error::KnotMultiplicity { index: 3, multiplicity: 3, max: 2, .. })
        ));
        assert!(matches!(new(&[0., 0., 0., f64::NAN, 1., 1.]), Err(Error::NonFiniteKnot { index: 3, .. })));
        assert!(matches!(
            new(&[0., 0., 1., 1., 1., 1.]),
            Err(Error::KnotMultiplicity { .. } | Error::EmptyDomain { .. })
        ));
        assert!(matches!(KnotVector::new(0, vec![0., 1.]), Err(Error::Degree { degree: 0 })));
    }

    #[test]
    fn periodic_wraps() {
        let k = KnotVector::uniform_periodic(3, 5).unwrap();
        assert_eq!((k.basis_count(), k.distinct_count()), (8, 5));
        assert!((k.normalize(1.3) - 0.3).abs() < 1e-15);
        let mut bad = k.as_slice().to_vec();
        bad[0] -= 0.01;
        assert!(matches!(KnotVector::periodic(3, bad), Err(Error::NotPeriodic { .. })));
    }

    #[test]
    fn the_seam_of_a_periodic_vector_is_an_inner_knot() {
        // Multiplicity 2 = p at the seam: a corner, which is continuous.
        let corner = KnotVector::periodic(2, vec![-1., 0., 0., 1., 2., 3., 3., 4., 5.]).unwrap();
        assert_eq!((corner.distinct_count(), corner.domain()), (4, Interval::new(0.0, 3.0).unwrap()));
        // Multiplicity 3 at 0 and 3, wherever the domain begins among the copies.
        for knots in [
            vec![-1., 0., 0., 0., 1., 2., 3., 3., 3., 4.],
            vec![0., 0., 0., 1., 2., 3., 3., 3., 4., 5.],
            vec![-2., -1., 0., 0., 0., 1., 2., 3., 3., 3.],
        ] {
            let error = KnotVector::periodic(2, knots.clone()).unwrap_err();
            let index = knots.iter().position(|&t| t == 0.0).unwrap();
            assert_eq!(error, Error::KnotMultiplicity { index, value: 0.0, multiplicity: 3, max: 2 });
        }
        // A clamped vector is not periodic, and is told so.
        let clamped = vec![0., 0., 0., 1., 2., 3., 3., 3.];
        assert!(matches!(KnotVector::periodic(2, clamped), Err(Error::NotPeriodic { index: 3, .. })));
    }

    #[test]
    fn averages() {
        let k = KnotVector::averaged(3, &[0., 1., 2., 3., 4.]).unwrap();
        assert_eq!(k.as_slice(), [0., 0., 0., 0., 2., 4., 4., 4., 4.]);
    }
}
