//! Degree elevation.

use super::knot_map::KnotMap;
use super::rows::{ControlRows, along};
use crate::{BsplineCurve, BsplineSurface, Direction, Error, MAX_DEGREE};

pub(super) fn elevate(rows: &ControlRows, by: usize) -> Result<ControlRows, Error> {
    let degree = rows.knots.degree().saturating_add(by);
    if degree > MAX_DEGREE {
        return Err(Error::Degree { degree });
    }
    let mut rows = rows.clone();
    for _ in 0..by {
        rows = KnotMap::elevating(&rows.knots)?.apply(&rows);
    }
    Ok(rows)
}

impl<const D: usize> BsplineCurve<D> {
    /// The same curve written with the degree `degree + by` ([PT97, sec. 5.5], by blossoming).
    ///
    /// Its continuity stays: all multiplicities are raised by `by`.
    ///
    /// # Errors
    /// [`Error::Degree`] above [`MAX_DEGREE`].
    pub fn elevated(&self, by: usize) -> Result<Self, Error> {
        elevate(&ControlRows::from_curve(self), by)?.into_curve()
    }
}

impl BsplineSurface {
    /// The same surface with a higher degree in a direction ([PT97, A5.10], by blossoming).
    ///
    /// # Errors
    /// [`Error::Degree`] above [`MAX_DEGREE`].
    pub fn elevated(&self, direction: Direction, by: usize) -> Result<Self, Error> {
        along(self, direction, |rows| elevate(&rows, by))
    }
}
