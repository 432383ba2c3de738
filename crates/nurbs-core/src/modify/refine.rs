//! Knot insertion and refinement.

use super::knot_map::KnotMap;
use super::rows::{ControlRows, along};
use crate::{BsplineCurve, BsplineSurface, Direction, Error, KnotVector, MAX_DEGREE};

/// The same spline on a finer vector of the same degree.
pub(crate) fn on_knots(rows: &ControlRows, knots: KnotVector) -> Result<ControlRows, Error> {
    if knots == rows.knots {
        return Ok(rows.clone());
    }
    Ok(KnotMap::refining(&rows.knots, knots)?.apply(rows))
}

fn refine(rows: &ControlRows, values: &[f64]) -> Result<ControlRows, Error> {
    if values.is_empty() {
        return Ok(rows.clone());
    }
    on_knots(rows, rows.knots.inserted(values)?)
}

/// `times` copies, or as many as make the error about the multiplicity certain.
fn repeated(t: f64, times: usize) -> Vec<f64> {
    vec![t; times.min(MAX_DEGREE + 2)]
}

impl<const D: usize> BsplineCurve<D> {
    /// The same curve with the knot `t` inserted `times` times ([PT97, A5.1]).
    ///
    /// A periodic curve stays periodic.
    ///
    /// # Errors
    /// See [`KnotVector::inserted`].
    ///
    /// ```
    /// # use nurbs_core::{BsplineCurve, ParametricCurve};
    /// # use nalgebra::Vector2;
    /// let arc = BsplineCurve::bezier(vec![Vector2::new(0., 0.), Vector2::new(1., 2.), Vector2::new(2., 0.)], None)?;
    /// let finer = arc.insert_knot(0.5, 1)?;
    /// assert_eq!(finer.control_points()[1], Vector2::new(0.5, 1.0));
    /// assert!((finer.point(0.3) - arc.point(0.3)).norm() < 1e-15);
    /// # Ok::<(), nurbs_core::Error>(())
    /// ```
    pub fn insert_knot(&self, t: f64, times: usize) -> Result<Self, Error> {
        self.refine(&repeated(t, times))
    }

    /// The same curve with all `values` inserted into its knots, in any order ([PT97, A5.4]).
    ///
    /// # Errors
    /// See [`KnotVector::inserted`].
    pub fn refine(&self, values: &[f64]) -> Result<Self, Error> {
        refine(&ControlRows::from_curve(self), values)?.into_curve()
    }
}

impl BsplineSurface {
    /// The same surface with the knot `t` inserted `times` times in a direction ([PT97, A5.3]).
    ///
    /// # Errors
    /// See [`KnotVector::inserted`].
    pub fn insert_knot(&self, direction: Direction, t: f64, times: usize) -> Result<Self, Error> {
        self.refine(direction, &repeated(t, times))
    }

    /// The same surface with all `values` inserted into the knots of a direction ([PT97, A5.5]).
    ///
    /// # Errors
    /// See [`KnotVector::inserted`].
    pub fn refine(&self, direction: Direction, values: &[f64]) -> Result<Self, Error> {
        along(self, direction, |rows| refine(&rows, values))
    }
}
