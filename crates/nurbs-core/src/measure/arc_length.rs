//! Arc length of curves and its inverse.

use super::{Measure, attainable, noise, rule};
use crate::{Error, ParametricCurve};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Most pieces that a curve is cut into.
const MAX_PIECES: usize = 100_000;

/// The length of a curve over its whole domain, to a relative tolerance such as
/// [`MEASURE_TOLERANCE`](crate::MEASURE_TOLERANCE).
///
/// Cusps and knots cost some more evaluations but no accuracy. NaN when the curve is not finite.
///
/// ```
/// # use nurbs_core::{arc_length, BsplineCurve};
/// # use nalgebra::Vector2;
/// let points = vec![Vector2::new(0.0, 0.0), Vector2::new(3.0, 4.0)];
/// let line = BsplineCurve::bezier(points, None)?;
/// assert!((arc_length(&line, 1e-12).value - 5.0).abs() < 1e-14);
/// # Ok::<(), nurbs_core::Error>(())
/// ```
pub fn arc_length<const D: usize, C: ParametricCurve<D> + ?Sized>(
    curve: &C,
    relative_tolerance: f64,
) -> Measure {
    ArcLength::new(curve, relative_tolerance).total()
}

/// A piece of the parameter interval on which the quadrature rule is accurate.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    start: f64,
    end: f64,
    length: f64,
    error: f64,
}

impl Piece {
    fn new<const D: usize, C: ParametricCurve<D> + ?Sized>(curve: &C, start: f64, end: f64) -> Self {
        let (length, error) = rule::integrate(|t| curve.jet(t).speed(), start, end);
        Self { start, end, length, error }
    }
}

impl Eq for Piece {}

impl PartialOrd for Piece {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// By error, for the heap.
impl Ord for Piece {
    fn cmp(&self, other: &Self) -> Ordering {
        self.error.total_cmp(&other.error).then(other.start.total_cmp(&self.start))
    }
}

/// Arc length of a curve as a function of the parameter, and the inverse.
///
/// Built once for a curve; then lengths and parameters come from a search and a few evaluations.
#[derive(Clone, Debug)]
pub struct ArcLength<'a, const D: usize, C: ParametricCurve<D> + ?Sized> {
    curve: &'a C,
    pieces: Vec<Piece>,
    /// Length from the start of the curve to the start of each piece, and the whole length.
    cumulative: Vec<f64>,
    error: f64,
}

impl<'a, const D: usize, C: ParametricCurve<D> + ?Sized> ArcLength<'a, D, C> {
    /// Measures the curve to a relative tolerance of its whole length.
    pub fn new(curve: &'a C, relative_tolerance: f64) -> Self {
        let tolerance = attainable(relative_tolerance);
        let domain = curve.domain();
        let mut ends = vec![domain.start()];
        ends.extend(curve.breaks());
        ends.push(domain.end());
        let mut heap: BinaryHeap<Piece> = ends.windows(2).map(|w| Piece::new(curve, w[0], w[1])).collect();
        let mut total: f64 = heap.iter().map(|p| p.length).sum();
        let mut error: f64 = heap.iter().map(|p| p.error).sum();
        let mut done = Vec::new();
        let floor = noise(ends.iter().map(|&t| curve.point(t).amax()));
        while error > (tolerance * total).max(floor) && heap.len() + done.len() < MAX_PIECES {
            let Some(worst) = heap.pop() else { break };
            let middle = 0.5 * (worst.start + worst.end);
            let width = worst.end - worst.start;
            // At a cusp pieces shrink until the parameter itself can no longer be halved.
            if width <= 4.0 * f64::EPSILON * worst.start.abs().max(worst.end.abs()) {
                error -= worst.error;
                done.push(worst);
                continue;
            }
            let halves = [Piece::new(curve, worst.start, middle), Piece::new(curve, middle, worst.end)];
            total += halves[0].length + halves[1].length - worst.length;
            error += halves[0].error + halves[1].error - worst.error;
            heap.extend(halves);
        }
        let mut pieces = heap.into_vec();
        pieces.append(&mut done);
        pieces.sort_by(|a, b| a.start.total_cmp(&b.start));
        let mut cumulative = Vec::with_capacity(pieces.len() + 1);
        let mut sum = 0.0;
        cumulative.push(0.0);
        for piece in &pieces {
            sum += piece.length;
            cumulative.push(sum);
        }
        let error = pieces.iter().map(|p| p.error).sum();
        Self { curve, pieces, cumulative, error }
    }

    /// The whole length.
    #[must_use]
    pub fn total(&self) -> Measure {
        Measure { value: self.cumulative.last().copied().unwrap_or(0.0), error: self.error }
    }

    /// Length from the start of the curve to `t`; parameters outside the domain are clamped.
    #[must_use]
    pub fn at(&self, t: f64) -> f64 {
        let t = self.curve.domain().clamp(t);
        let index = self.pieces.partition_point(|p| p.start <= t).saturating_sub(1);
        let piece = &self.pieces[index];
        if t >= piece.end {
            return self.cumulative[index + 1];
        }
        self.cumulative[index] + self.within(piece.start, t)
    }

    /// Length between two parameters, negative when `to < from`.
    #[must_use]
    pub fn between(&self, from: f64, to: f64) -> f64 {
        self.at(to) - self.at(from)
    }

    fn within(&self, from: f64, to: f64) -> f64 {
        rule::integrate(|t| self.curve.jet(t).speed(), from, to).0
    }

    /// The parameter at which the length from the start is `length`.
    ///
    /// Where the curve stands still (an interval of equal points) one of the parameters is given.
    ///
    /// # Errors
    /// [`Error::Argument`] when `length` is NaN, negative or longer than the curve (by more than
    /// rounding), or the curve's own length is not finite.
    pub fn parameter_at(&self, length: f64) -> Result<f64, Error> {
        let total = self.total().value;
        let slack = 1e-12 * total;
        if !(length >= -slack && length <= total + slack && total.is_finite()) {
            return Err(Error::argument(format!(
                "length {length} is not on the curve, which is {total} long; give a length from 0 to {total}"
            )));
        }
        let domain = self.curve.domain();
        if length <= 0.0 {
            return Ok(domain.start());
        }
        if length >= total {
            return Ok(domain.end());
        }
        let index = self.cumulative.partition_point(|&l| l <= length).saturating_sub(1);
        let index = index.min(self.pieces.len() - 1);
        let piece = &self.pieces[index];
        let wanted = length - self.cumulative[index];
        Ok(self.invert(piece, wanted))
    }

    /// Newton's method on one piece, held inside a shrinking bracket.
    fn invert(&self, piece: &Piece, wanted: f64) -> f64 {
        let (mut low, mut high) = (piece.start, piece.end);
        let mut t = low + (high - low) * (wanted / piece.length).clamp(0.0, 1.0);
        for _ in 0..80 {
            let excess = self.within(piece.start, t) - wanted;
            if excess > 0.0 {
                high = t;
            } else {
                low = t;
            }
            let newton = t - excess / self.curve.jet(t).speed();
            let next = if (low..=high).contains(&newton) { newton } else { 0.5 * (low + high) };
            let step = (next - t).abs();
            t = next;
            if excess == 0.0 || step <= 2.0 * f64::EPSILON * t.abs().max(piece.end - piece.start) {
                break;
            }
        }
        t
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BsplineCurve, CurveFn, CurveJet, Interval};
    use nalgebra::Vector2;

    #[test]
    fn cusp_and_circle() {
        // (t², t³) on [−1, 1]: a cusp at 0, length 2 (13√13 − 8) / 27.
        let cusp = CurveFn::new(Interval::new(-1.0, 0.7).unwrap(), |t: f64| CurveJet {
            point: Vector2::new(t * t, t * t * t),
            d1: Vector2::new(2.0 * t, 3.0 * t * t),
            d2: Vector2::new(2.0, 6.0 * t),
        });
        let part = |t: f64| ((4.0 + 9.0 * t * t).powf(1.5) - 8.0) / 27.0;
        let exact = part(1.0) + part(0.7);
        let found = arc_length(&cusp, 1e-12);
        assert!((found.value - exact).abs() < 1e-12 * exact, "{found:?} {exact}");
        let table = ArcLength::new(&cusp, 1e-12);
        for i in 0..=40 {
            let s = exact * f64::from(i) / 40.0;
            let t = table.parameter_at(s).unwrap();
            assert!((table.at(t) - s).abs() < 1e-14, "{s}");
        }
        assert!(table.parameter_at(exact + 1e-3).is_err() && table.parameter_at(f64::NAN).is_err());
    }

    #[test]
    fn a_point_has_no_length() {
        let point = BsplineCurve::bezier(vec![Vector2::new(1.0, 2.0); 3], None).unwrap();
        let table = ArcLength::new(&point, 1e-10);
        assert!(table.total().value < 1e-15 && table.pieces.len() == 1);
        assert!(table.parameter_at(0.0).is_ok());
    }
}
