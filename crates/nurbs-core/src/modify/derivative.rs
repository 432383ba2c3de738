//! Derivatives of polynomial shapes as shapes of one degree less.

use super::rows::{ControlRows, along};
use crate::{BsplineCurve, BsplineSurface, Direction, Error, KnotVector};

fn derivative(rows: &ControlRows) -> Result<ControlRows, Error> {
    let p = rows.knots.degree();
    if rows.rational {
        return Err(Error::argument(
            "the derivative of a rational shape has twice its degree and other weights, not the same knots; \
             evaluate it with `jet` or `derivatives`, or take Bézier pieces",
        ));
    }
    if p == 1 {
        return Err(Error::argument(
            "the derivative of a shape of degree 1 is piecewise constant, which no spline here can hold; \
             evaluate it with `jet`, or elevate the degree first",
        ));
    }
    let all = rows.knots.as_slice();
    let domain = rows.knots.domain();
    let corner = rows.knots.distinct_knots().into_iter();
    let mut corner = corner.filter(|&(t, m)| m >= p && t > domain.start() && t < domain.end());
    let seam = rows.knots.is_periodic() && all.iter().filter(|&&t| t == domain.start()).count() >= p;
    if let Some(t) = corner.next().map(|m| m.0).or(seam.then(|| domain.start())) {
        return Err(Error::argument(format!(
            "the derivative may jump at the knot {t} of multiplicity {p}; split the shape there first"
        )));
    }
    let inner = all[1..all.len() - 1].to_vec();
    let knots = if rows.knots.is_periodic() {
        KnotVector::periodic(p - 1, inner)?
    } else {
        KnotVector::new(p - 1, inner)?
    };
    let mut data = Vec::with_capacity(rows.data.len());
    for i in 0..rows.count() - 1 {
        let length = all[i + p + 1] - all[i + 1];
        // Only functions that vanish on the whole domain have no support.
        let factor = if length > 0.0 { p as f64 / length } else { 0.0 };
        data.extend(rows.row(i).iter().zip(rows.row(i + 1)).map(|(a, b)| (b - a) * factor));
    }
    Ok(rows.with(knots, data))
}

impl<const D: usize> BsplineCurve<D> {
    /// The curve `c'(t)`, of one degree less ([PT97, eq. (3.4)]).
    ///
    /// # Errors
    /// [`Error::Argument`] for rational curves, degree 1, and knots of multiplicity `p` (where `c'` may
    /// jump); each says what to do instead.
    pub fn derivative_curve(&self) -> Result<Self, Error> {
        derivative(&ControlRows::from_curve(self))?.into_curve()
    }
}

impl BsplineSurface {
    /// The partial derivative in a direction as a surface ([PT97, eq. (3.24)]).
    ///
    /// # Errors
    /// As [`BsplineCurve::derivative_curve`].
    pub fn derivative_surface(&self, direction: Direction) -> Result<Self, Error> {
        along(self, direction, |rows| derivative(&rows))
    }
}
