//! Joining curves end to end.

use super::degree::elevate;
use super::rows::{ControlRows, check_tolerance};
use super::split::clamp;
use crate::{BsplineCurve, Error, Interval, KnotVector};

impl<const D: usize> BsplineCurve<D> {
    /// This curve followed by `next`, which must start within `tolerance` (a length) of this one's end.
    ///
    /// Degrees are matched by elevation, ends clamped, the parameters of `next` moved to follow. The
    /// joint is a knot of multiplicity `p` whose control point is the mean of the two ends.
    ///
    /// # Errors
    /// [`Error::Incompatible`] when the gap exceeds the tolerance or a curve is periodic.
    pub fn join(&self, next: &Self, tolerance: f64) -> Result<Self, Error> {
        check_tolerance(tolerance)?;
        if self.knots().is_periodic() || next.knots().is_periodic() {
            return Err(Error::Incompatible {
                what: "a periodic curve has no ends to join; open it first (`opened_at`)".into(),
            });
        }
        let degree = self.degree().max(next.degree());
        let prepare = |curve: &Self, rational: bool| {
            let mut rows = clamp(&ControlRows::from_curve(curve))?;
            if rational && !rows.rational {
                rows = with_unit_weights(&rows);
            }
            elevate(&rows, degree - curve.degree())
        };
        let rational = self.weights().is_some() || next.weights().is_some();
        let (a, mut b) = (prepare(self, rational)?, prepare(next, rational)?);
        if rational {
            // A common factor of all weights changes nothing; here it makes them meet.
            let factor = a.data[a.data.len() - 1] / b.data[D];
            b.data.iter_mut().for_each(|value| *value *= factor);
        }
        let (end, start) = (a.count() - 1, 0);
        let weight = if rational { a.row(end)[D] } else { 1.0 };
        let gap = (0..D).map(|c| (a.row(end)[c] - b.row(start)[c]).powi(2)).sum::<f64>().sqrt() / weight;
        if gap.is_nan() || gap > tolerance {
            return Err(Error::Incompatible {
                what: format!(
                    "the curves are {gap:e} apart where they should meet; the tolerance is {tolerance:e}"
                ),
            });
        }
        let at = a.knots.domain().end();
        let follows = Interval::new(at, at + b.knots.domain().length())?;
        let moved = b.knots.reparameterized(follows);
        let (first, second) = (a.knots.as_slice(), moved.as_slice());
        let mut knots = first[..first.len() - 1].to_vec();
        knots.extend_from_slice(&second[degree + 1..]);
        let mut data = a.data.clone();
        let joint = end * a.width;
        for (x, y) in data[joint..].iter_mut().zip(b.row(start)) {
            *x = 0.5 * (*x + y);
        }
        data.extend_from_slice(&b.data[b.width..]);
        a.with(KnotVector::new(degree, knots)?, data).into_curve()
    }
}

fn with_unit_weights(rows: &ControlRows) -> ControlRows {
    let mut data = Vec::with_capacity(rows.data.len() / rows.point * (rows.point + 1));
    for point in rows.data.chunks_exact(rows.point) {
        data.extend_from_slice(point);
        data.push(1.0);
    }
    let point = rows.point + 1;
    let width = rows.width / rows.point * point;
    ControlRows { knots: rows.knots.clone(), data, width, point, rational: true }
}
