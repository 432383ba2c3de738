//! Isoparametric curves.

use super::rows::{ControlRows, knots};
use crate::{BsplineCurve, BsplineSurface, Direction, Error, MAX_DEGREE, basis};

impl BsplineSurface {
    /// The curve in `v` at constant `u`.
    ///
    /// # Errors
    /// [`Error::Parameter`] when `u` lies outside the domain (it is wrapped in a periodic direction).
    pub fn iso_curve_u(&self, u: f64) -> Result<BsplineCurve<3>, Error> {
        self.iso_curve(Direction::U, u)
    }

    /// The curve in `u` at constant `v`.
    ///
    /// # Errors
    /// [`Error::Parameter`] when `v` lies outside the domain (it is wrapped in a periodic direction).
    pub fn iso_curve_v(&self, v: f64) -> Result<BsplineCurve<3>, Error> {
        self.iso_curve(Direction::V, v)
    }

    /// The curve on which the parameter of `held` has the value `t`; the other one runs.
    ///
    /// # Errors
    /// [`Error::Parameter`] when `t` lies outside the domain (it is wrapped in a periodic direction).
    pub fn iso_curve(&self, held: Direction, t: f64) -> Result<BsplineCurve<3>, Error> {
        let rows = ControlRows::from_surface(self, held);
        let (p, domain) = (rows.knots.degree(), rows.knots.domain());
        if !t.is_finite() || !(rows.knots.is_periodic() || domain.contains(t)) {
            return Err(Error::Parameter { value: t, start: domain.start(), end: domain.end() });
        }
        let t = rows.knots.normalize(t);
        let span = rows.knots.span(t);
        let mut weights = [0.0; MAX_DEGREE + 1];
        basis::values(&rows.knots, span, t, &mut weights);
        let mut data = vec![0.0; rows.width];
        for (j, weight) in weights[..=p].iter().enumerate() {
            for (sum, value) in data.iter_mut().zip(rows.row(span - p + j)) {
                *sum += weight * value;
            }
        }
        let knots = knots(self, held.other()).clone();
        ControlRows { knots, data, width: rows.point, point: rows.point, rational: rows.rational }
            .into_curve()
    }
}
