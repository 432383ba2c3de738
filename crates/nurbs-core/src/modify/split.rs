//! Parts of a shape: trimming, splitting, clamping, opening; and another parameter interval.

use super::refine::on_knots;
use super::rows::{ControlRows, along, knots};
use crate::{BsplineCurve, BsplineSurface, Direction, Error, Interval, KnotVector};

fn trim(rows: &ControlRows, interval: Interval) -> Result<ControlRows, Error> {
    let part = on_knots(rows, rows.knots.trimmed_in_place(interval)?)?;
    let knots = part.knots.reparameterized(interval);
    Ok(ControlRows { knots, ..part })
}

pub(super) fn clamp(rows: &ControlRows) -> Result<ControlRows, Error> {
    if rows.knots.is_clamped() && !rows.knots.is_periodic() {
        return Ok(rows.clone());
    }
    trim(rows, rows.knots.domain())
}

/// The two intervals on both sides of `t`.
fn sides(knots: &KnotVector, t: f64) -> Result<[Interval; 2], Error> {
    let domain = knots.domain();
    let (start, end) = (domain.start(), domain.end());
    if !domain.contains(t) {
        return Err(Error::Parameter { value: t, start, end });
    }
    if t == start || t == end {
        return Err(Error::argument(format!(
            "cannot split at {t}, an end of the domain [{start}, {end}]: one part would be empty"
        )));
    }
    Ok([Interval::new(start, t)?, Interval::new(t, end)?])
}

fn one_turn(knots: &KnotVector, t: f64) -> Result<Interval, Error> {
    match knots.period() {
        Some(period) => Interval::new(t, t + period),
        None => Err(Error::argument("only a periodic shape can be opened; use `split` or `trimmed`")),
    }
}

fn reversed(rows: &ControlRows) -> ControlRows {
    let data = rows.data.chunks_exact(rows.width).rev().flatten().copied().collect();
    rows.with(rows.knots.reversed(), data)
}

/// Whether the first and the last row of the clamped form have the same points.
fn closed(rows: &ControlRows, tolerance: f64) -> Result<bool, Error> {
    super::rows::check_tolerance(tolerance)?;
    let rows = clamp(rows)?;
    let d = rows.dimension();
    let (first, last) = (rows.row(0), rows.row(rows.count() - 1));
    // Weights may differ by a common factor.
    let scale = if rows.rational { last[d] / first[d] } else { 1.0 };
    Ok(first.chunks_exact(rows.point).zip(last.chunks_exact(rows.point)).all(|(a, b)| {
        let (wa, wb) = if rows.rational { (a[d], b[d]) } else { (1.0, 1.0) };
        let gap = a[..d].iter().zip(&b[..d]).map(|(x, y)| (x / wa - y / wb).powi(2)).sum::<f64>().sqrt();
        gap <= tolerance && (wb / (wa * scale) - 1.0).abs() <= 1e-9
    }))
}

impl<const D: usize> BsplineCurve<D> {
    /// The part of the curve on `interval`, clamped, with its parameters kept.
    ///
    /// Of a periodic curve the interval may start anywhere and cross the seam.
    ///
    /// # Errors
    /// [`Error::Parameter`] when an end of the interval lies outside the domain, [`Error::Argument`]
    /// when it is longer than the period.
    pub fn trimmed(&self, interval: Interval) -> Result<Self, Error> {
        trim(&ControlRows::from_curve(self), interval)?.into_curve()
    }

    /// The parts before and after `t`, both clamped.
    ///
    /// # Errors
    /// When `t` does not lie inside the domain.
    pub fn split(&self, t: f64) -> Result<(Self, Self), Error> {
        let [left, right] = sides(self.knots(), t)?;
        Ok((self.trimmed(left)?, self.trimmed(right)?))
    }

    /// The same curve with clamped ends; a periodic one is opened at its seam.
    ///
    /// # Errors
    /// None for a valid curve, up to overflow of its coordinates.
    pub fn clamped(&self) -> Result<Self, Error> {
        clamp(&ControlRows::from_curve(self))?.into_curve()
    }

    /// A periodic curve opened at `t`: a clamped curve on `[t, t + period]`.
    ///
    /// # Errors
    /// [`Error::Argument`] when the curve is not periodic.
    pub fn opened_at(&self, t: f64) -> Result<Self, Error> {
        self.trimmed(one_turn(self.knots(), t)?)
    }

    /// The same curve run through backwards, on the same domain.
    ///
    /// # Errors
    /// None for a valid curve.
    pub fn reversed(&self) -> Result<Self, Error> {
        reversed(&ControlRows::from_curve(self)).into_curve()
    }

    /// The same curve on another domain, by an affine change of the parameter.
    ///
    /// # Errors
    /// When rounding makes knots collapse, as on a domain that is tiny compared with its distance from 0.
    pub fn reparameterized(&self, domain: Interval) -> Result<Self, Error> {
        let knots = checked(self.knots().reparameterized(domain))?;
        Self::new(knots, self.control_points().to_vec(), self.weights().map(<[f64]>::to_vec))
    }

    /// Whether the curve ends where it starts, up to `tolerance` (a length).
    ///
    /// # Errors
    /// When the tolerance is negative or NaN.
    pub fn is_closed(&self, tolerance: f64) -> Result<bool, Error> {
        closed(&ControlRows::from_curve(self), tolerance)
    }
}

impl BsplineSurface {
    /// The part of the surface where the parameter of `direction` lies in `interval`.
    ///
    /// # Errors
    /// As [`BsplineCurve::trimmed`].
    pub fn trimmed(&self, direction: Direction, interval: Interval) -> Result<Self, Error> {
        along(self, direction, |rows| trim(&rows, interval))
    }

    /// The parts before and after the parameter `t` of `direction`.
    ///
    /// # Errors
    /// When `t` does not lie inside the domain.
    pub fn split(&self, direction: Direction, t: f64) -> Result<(Self, Self), Error> {
        let [left, right] = sides(knots(self, direction), t)?;
        Ok((self.trimmed(direction, left)?, self.trimmed(direction, right)?))
    }

    /// The same surface with clamped knots in a direction.
    ///
    /// # Errors
    /// None for a valid surface, up to overflow of its coordinates.
    pub fn clamped(&self, direction: Direction) -> Result<Self, Error> {
        along(self, direction, |rows| clamp(&rows))
    }

    /// A surface periodic in `direction`, opened at `t`.
    ///
    /// # Errors
    /// [`Error::Argument`] when the direction is not periodic.
    pub fn opened_at(&self, direction: Direction, t: f64) -> Result<Self, Error> {
        self.trimmed(direction, one_turn(knots(self, direction), t)?)
    }

    /// The same surface with one parameter run through backwards; the normal changes sides.
    ///
    /// # Errors
    /// None for a valid surface.
    pub fn reversed(&self, direction: Direction) -> Result<Self, Error> {
        along(self, direction, |rows| Ok(reversed(&rows)))
    }

    /// The same surface with `u` and `v` swapped; the normal changes sides.
    ///
    /// # Errors
    /// None for a valid surface.
    pub fn transposed(&self) -> Result<Self, Error> {
        let rows = ControlRows::from_surface(self, Direction::V);
        // The columns, read as rows.
        rows.into_surface(self.knots_u().clone(), Direction::U)
    }

    /// The same surface on another domain, by an affine change of each parameter.
    ///
    /// # Errors
    /// As [`BsplineCurve::reparameterized`].
    pub fn reparameterized(&self, domain: [Interval; 2]) -> Result<Self, Error> {
        let knots_u = checked(self.knots_u().reparameterized(domain[0]))?;
        let knots_v = checked(self.knots_v().reparameterized(domain[1]))?;
        Self::new(knots_u, knots_v, self.control_points().to_vec(), self.weights().map(<[f64]>::to_vec))
    }

    /// Whether the first and last iso-curve of a direction agree up to `tolerance` (a length),
    /// compared by their control points.
    ///
    /// # Errors
    /// When the tolerance is negative or NaN.
    pub fn is_closed(&self, direction: Direction, tolerance: f64) -> Result<bool, Error> {
        closed(&ControlRows::from_surface(self, direction), tolerance)
    }
}

/// Validates knots that were moved.
fn checked(knots: KnotVector) -> Result<KnotVector, Error> {
    let (degree, values) = (knots.degree(), knots.as_slice().to_vec());
    if knots.is_periodic() { KnotVector::periodic(degree, values) } else { KnotVector::new(degree, values) }
}
