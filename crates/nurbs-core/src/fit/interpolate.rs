//! Curves through given points.

use super::collocation::{Condition, solve};
use super::parameters::{ParameterMethod, closed_parameters, parameters};
use super::placement::check_degree;
use crate::{BsplineCurve, Error, KnotVector};
use nalgebra::SVector;

impl<const D: usize> BsplineCurve<D> {
    /// The curve of the given degree through all points in order, on `[0, 1]` with averaged knots
    /// ([PT97, A9.1]).
    ///
    /// # Errors
    /// See [`parameters`]; also when there are fewer than `degree + 1` points.
    ///
    /// ```
    /// # use nurbs_core::{BsplineCurve, ParameterMethod, ParametricCurve};
    /// # use nalgebra::Vector2;
    /// let points = [[0., 0.], [1., 2.], [3., 3.], [4., 1.], [6., 0.]].map(Vector2::from);
    /// let curve = BsplineCurve::interpolate(&points, 3, ParameterMethod::Centripetal)?;
    /// assert!((curve.point(1.0) - points[4]).norm() < 1e-14);
    /// # Ok::<(), nurbs_core::Error>(())
    /// ```
    pub fn interpolate(
        points: &[SVector<f64, D>],
        degree: usize,
        method: ParameterMethod,
    ) -> Result<Self, Error> {
        Self::interpolate_with_derivatives(points, degree, method, None, None)
    }

    /// As [`interpolate`](Self::interpolate), with the first derivative at the start, the end, or both
    /// ([PT97, sec. 9.2.2]).
    ///
    /// Derivatives are with respect to the parameter, which runs from 0 to 1: for chord length
    /// parameters the unit tangent times the length of the polygon of the data is a natural choice.
    ///
    /// # Errors
    /// As [`interpolate`](Self::interpolate); a derivative counts as one more point.
    pub fn interpolate_with_derivatives(
        points: &[SVector<f64, D>],
        degree: usize,
        method: ParameterMethod,
        start: Option<SVector<f64, D>>,
        end: Option<SVector<f64, D>>,
    ) -> Result<Self, Error> {
        let params = parameters(points, method)?;
        let count = points.len() + usize::from(start.is_some()) + usize::from(end.is_some());
        check_count(count, degree)?;
        let knots = KnotVector::averaged_with_derivatives(degree, &params, start.is_some(), end.is_some())?;
        let mut conditions: Vec<Condition> = params.iter().map(|&at| Condition { at, order: 0 }).collect();
        let mut values = points.to_vec();
        for (derivative, at) in [(start, 0.0), (end, 1.0)] {
            if let Some(derivative) = derivative {
                conditions.push(Condition { at, order: 1 });
                values.push(derivative);
            }
        }
        Self::from_conditions(knots, &conditions, &values)
    }

    /// The periodic curve of the given degree, `C^{degree−1}` everywhere, through all points in order
    /// and back to the first, which is not repeated.
    ///
    /// The period is 1 and the parameter 0 belongs to the first point (see
    /// [`KnotVector::averaged_periodic`] for where the domain starts).
    ///
    /// # Errors
    /// See [`closed_parameters`]; with fewer than `degree + 1` points; [`Error::Singular`] in the rare
    /// case that an even number of very unevenly spaced points has no unique interpolant.
    pub fn interpolate_closed(
        points: &[SVector<f64, D>],
        degree: usize,
        method: ParameterMethod,
    ) -> Result<Self, Error> {
        let params = closed_parameters(points, method)?;
        let knots = KnotVector::averaged_periodic(degree, &params, 1.0)?;
        Self::interpolate_at(knots, &params, points)
    }

    /// The curve on the given knots with `points[k]` at `params[k]`.
    ///
    /// There must be as many points as control points that are not repetitions.
    ///
    /// # Errors
    /// When the counts do not fit, a parameter lies outside the domain, or the system is singular:
    /// each basis function needs a parameter of its own inside its support.
    pub fn interpolate_at(
        knots: KnotVector,
        params: &[f64],
        points: &[SVector<f64, D>],
    ) -> Result<Self, Error> {
        if params.len() != points.len() {
            return Err(Error::argument(format!(
                "{} parameters were given for {} data points",
                params.len(),
                points.len()
            )));
        }
        let conditions: Vec<Condition> = params.iter().map(|&at| Condition { at, order: 0 }).collect();
        Self::from_conditions(knots, &conditions, points)
    }

    fn from_conditions(
        knots: KnotVector,
        conditions: &[Condition],
        values: &[SVector<f64, D>],
    ) -> Result<Self, Error> {
        let data: Vec<f64> = values.iter().flat_map(|p| p.iter().copied()).collect();
        let solved = solve(&knots, conditions, &data, D)?;
        Self::new(knots, solved.chunks_exact(D).map(SVector::from_column_slice).collect(), None)
    }
}

pub(super) fn check_count(count: usize, degree: usize) -> Result<(), Error> {
    check_degree(degree)?;
    if count < degree + 1 {
        return Err(Error::argument(format!(
            "interpolation of degree {degree} needs at least {} conditions, there are {count}; \
             lower the degree",
            degree + 1
        )));
    }
    Ok(())
}
