//! Least squares approximation of surfaces.

use super::constraints::check_factor;
use super::energy::bending;
use super::normal::solve;
use super::observations::{Observations, Space};
use super::report::Fitted;
use crate::{BsplineSurface, Error, KnotVector};
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// Options of [`BsplineSurface::approximate`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceFitOptions {
    /// Weight of each data point; `None` for equal ones.
    pub weights: Option<Vec<f64>>,
    /// Factor of the thin plate energy, see [`BsplineSurface::approximate`]; 0 for none.
    pub regularization: f64,
    /// Control points `(i, j)` that must have given places.
    pub fixed: Vec<([usize; 2], Vector3<f64>)>,
}

impl SurfaceFitOptions {
    /// Sets the weights of the data points.
    #[must_use]
    pub fn with_weights(self, weights: Vec<f64>) -> Self {
        Self { weights: Some(weights), ..self }
    }

    /// Sets the factor of the thin plate energy.
    #[must_use]
    pub fn with_regularization(self, regularization: f64) -> Self {
        Self { regularization, ..self }
    }

    /// Fixes a control point.
    #[must_use]
    pub fn with_fixed(mut self, i: usize, j: usize, point: Vector3<f64>) -> Self {
        self.fixed.push(([i, j], point));
        self
    }

    /// Fixes the outermost control points of every direction that is not periodic to those of `model`,
    /// which must have the knots of the surface that is fitted: the boundary curves are kept.
    ///
    /// A Coons patch through given boundary curves makes a model.
    #[must_use]
    pub fn with_boundary_of(mut self, model: &BsplineSurface) -> Self {
        let (n_u, n_v) = (model.n_u(), model.n_v());
        for i in 0..n_u {
            for j in 0..n_v {
                let on_u = !model.knots_u().is_periodic() && (i == 0 || i + 1 == n_u);
                let on_v = !model.knots_v().is_periodic() && (j == 0 || j + 1 == n_v);
                if on_u || on_v {
                    self.fixed.push(([i, j], model.control_point(i, j)));
                }
            }
        }
        self
    }
}

impl BsplineSurface {
    /// The polynomial surface on the given knots (`u`, `v`) that is nearest to `points[k]` at the
    /// parameters `params[k]` in the least squares sense.
    ///
    /// It minimises `Σ w_k |s(u_k, v_k) − x_k|² / Σ w_k + λ ∫∫ |s_uu|² + 2 |s_uv|² + |s_vv|²`, where `λ` is the
    /// regularization and the integral is taken with the domain scaled to the unit square. With
    /// `λ > 0` regions without data are bridged smoothly (from degree 2 on).
    ///
    /// # Errors
    /// When counts do not fit, data are not finite, parameters lie outside the domain, or
    /// [`Error::Singular`], which names control points that the data do not determine.
    pub fn approximate(
        knots: [KnotVector; 2],
        params: &[[f64; 2]],
        points: &[Vector3<f64>],
        options: &SurfaceFitOptions,
    ) -> Result<Fitted<Self>, Error> {
        check_factor(options.regularization)?;
        let [u, v] = knots;
        let (n_u, n_v) = (u.basis_count(), v.basis_count());
        let space = Space { u: u.clone(), v: Some(v.clone()) };
        let mut fixed = BTreeMap::new();
        for ([i, j], point) in &options.fixed {
            if *i >= n_u || *j >= n_v || point.iter().any(|x| !x.is_finite()) {
                return Err(Error::argument(format!(
                    "fixed control point ({i}, {j}) has no finite place in the net of {n_u} x {n_v}"
                )));
            }
            fixed.insert(space.index(*i, *j), point.iter().copied().collect());
        }
        let values: Vec<f64> = points.iter().flat_map(|p| p.iter().copied()).collect();
        let data = Observations::new(&space, params, &values, 3, options.weights.as_deref())?;
        let energy = bending(&space, options.regularization);
        let coefficients = solve(&space, &data, &energy, &fixed)?;
        let net = space.expand(&coefficients, 3);
        let net = net.chunks_exact(3).map(Vector3::from_column_slice).collect();
        Ok(Fitted::new(Self::new(u, v, net, None)?, &data, &coefficients))
    }
}
