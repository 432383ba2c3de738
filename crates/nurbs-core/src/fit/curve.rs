//! Least squares approximation of curves.

use super::constraints::{check_factor, fix_ends};
use super::energy::bending;
use super::normal::solve;
use super::observations::{Observations, Space};
use super::report::Fitted;
use crate::{BsplineCurve, Error, KnotVector};
use nalgebra::SVector;
use std::collections::BTreeMap;

/// Options of [`BsplineCurve::approximate`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurveFitOptions<const D: usize> {
    /// Weight of each data point; `None` for equal ones.
    pub weights: Option<Vec<f64>>,
    /// Factor of the bending energy, see [`BsplineCurve::approximate`]; 0 for none.
    pub regularization: f64,
    /// Point, first derivative, second … that the curve must have at its start (clamped knots).
    pub start: Vec<SVector<f64, D>>,
    /// The same at its end.
    pub end: Vec<SVector<f64, D>>,
    /// Control points that must have given places.
    pub fixed: Vec<(usize, SVector<f64, D>)>,
}

impl<const D: usize> CurveFitOptions<D> {
    /// Sets the weights of the data points.
    #[must_use]
    pub fn with_weights(self, weights: Vec<f64>) -> Self {
        Self { weights: Some(weights), ..self }
    }

    /// Sets the factor of the bending energy.
    #[must_use]
    pub fn with_regularization(self, regularization: f64) -> Self {
        Self { regularization, ..self }
    }

    /// Fixes the end points.
    #[must_use]
    pub fn with_end_points(self, start: SVector<f64, D>, end: SVector<f64, D>) -> Self {
        Self { start: vec![start], end: vec![end], ..self }
    }

    /// Fixes point and derivatives at the start.
    #[must_use]
    pub fn with_start(self, start: Vec<SVector<f64, D>>) -> Self {
        Self { start, ..self }
    }

    /// Fixes point and derivatives at the end.
    #[must_use]
    pub fn with_end(self, end: Vec<SVector<f64, D>>) -> Self {
        Self { end, ..self }
    }

    /// Fixes a control point.
    #[must_use]
    pub fn with_fixed(mut self, index: usize, point: SVector<f64, D>) -> Self {
        self.fixed.push((index, point));
        self
    }
}

impl<const D: usize> BsplineCurve<D> {
    /// The polynomial curve on the given knots that is nearest to `points[k]` at `params[k]` in the
    /// least squares sense ([PT97, sec. 9.4.1]).
    ///
    /// It minimises `Σ w_k |c(t_k) − x_k|² / Σ w_k + λ ∫ |c''|²`, where `λ` is the regularization and the
    /// integral is taken with the domain scaled to length 1. With `λ > 0` spans without data are
    /// bridged smoothly (from degree 2 on: a polygon does not bend).
    ///
    /// Parameters may come in any order; of a periodic vector in any period.
    ///
    /// # Errors
    /// When counts do not fit, data are not finite, parameters lie outside the domain, or
    /// [`Error::Singular`], which names control points that the data do not determine.
    pub fn approximate(
        knots: KnotVector,
        params: &[f64],
        points: &[SVector<f64, D>],
        options: &CurveFitOptions<D>,
    ) -> Result<Fitted<Self>, Error> {
        check_factor(options.regularization)?;
        let space = Space { u: knots, v: None };
        let mut fixed = BTreeMap::new();
        for (index, point) in &options.fixed {
            if *index >= space.u.basis_count() || point.iter().any(|x| !x.is_finite()) {
                return Err(Error::argument(format!(
                    "fixed control point {index} has no finite place among the {} of the curve",
                    space.u.basis_count()
                )));
            }
            fixed.insert(space.index(*index, 0), point.iter().copied().collect());
        }
        fix_ends(&space.u, &options.start, &options.end, &mut fixed)?;
        let at: Vec<[f64; 2]> = params.iter().map(|&t| [t, 0.0]).collect();
        let values: Vec<f64> = points.iter().flat_map(|p| p.iter().copied()).collect();
        let data = Observations::new(&space, &at, &values, D, options.weights.as_deref())?;
        let energy = bending(&space, options.regularization);
        let coefficients = solve(&space, &data, &energy, &fixed)?;
        let net = space.expand(&coefficients, D);
        let net = net.chunks_exact(D).map(SVector::from_column_slice).collect();
        Ok(Fitted::new(Self::new(space.u, net, None)?, &data, &coefficients))
    }
}
