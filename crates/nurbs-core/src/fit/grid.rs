//! Surfaces through a grid of points.

use super::collocation::{Condition, solve};
use super::interpolate::check_count;
use super::parameters::{ParameterMethod, grid_parameters};
use crate::modify::rows::transpose;
use crate::{BsplineSurface, Error, KnotVector};
use nalgebra::Vector3;

/// Options of [`BsplineSurface::interpolate_grid`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridOptions {
    /// Degrees in `u` and `v`.
    pub degrees: [usize; 2],
    /// Which directions close up (periodic; the first row or column is not repeated).
    pub closed: [bool; 2],
    /// Spacing of the parameters.
    pub method: ParameterMethod,
}

impl Default for GridOptions {
    /// Bicubic, open, chord length.
    fn default() -> Self {
        Self { degrees: [3, 3], closed: [false, false], method: ParameterMethod::ChordLength }
    }
}

impl GridOptions {
    /// Sets the degrees in `u` and `v`.
    #[must_use]
    pub fn with_degrees(self, u: usize, v: usize) -> Self {
        Self { degrees: [u, v], ..self }
    }

    /// Sets which directions close up.
    #[must_use]
    pub fn with_closed(self, u: bool, v: bool) -> Self {
        Self { closed: [u, v], ..self }
    }

    /// Sets the spacing of the parameters.
    #[must_use]
    pub fn with_method(self, method: ParameterMethod) -> Self {
        Self { method, ..self }
    }
}

impl BsplineSurface {
    /// The surface through a grid of `size[0] × size[1]` points (row-major, `u` outer), with averaged
    /// knots; each open direction runs over `[0, 1]`, each closed one has period 1 ([PT97, A9.4]).
    ///
    /// # Errors
    /// See [`grid_parameters`] and [`BsplineCurve::interpolate`](crate::BsplineCurve::interpolate).
    pub fn interpolate_grid(
        points: &[Vector3<f64>],
        size: [usize; 2],
        options: &GridOptions,
    ) -> Result<Self, Error> {
        let params = grid_parameters(points, size, options.closed, options.method)?;
        let knots = |d: usize| {
            check_count(size[d], options.degrees[d])?;
            if options.closed[d] {
                KnotVector::averaged_periodic(options.degrees[d], &params[d], 1.0)
            } else {
                KnotVector::averaged(options.degrees[d], &params[d])
            }
        };
        Self::interpolate_grid_at([knots(0)?, knots(1)?], [&params[0], &params[1]], points)
    }

    /// The surface on the given knots through the grid point `(i, j)` at the parameters
    /// `(params[0][i], params[1][j])`.
    ///
    /// # Errors
    /// See [`BsplineCurve::interpolate_at`](crate::BsplineCurve::interpolate_at).
    pub fn interpolate_grid_at(
        knots: [KnotVector; 2],
        params: [&[f64]; 2],
        points: &[Vector3<f64>],
    ) -> Result<Self, Error> {
        let [n_u, n_v] = params.map(<[f64]>::len);
        if n_u * n_v != points.len() {
            return Err(Error::argument(format!(
                "{} points do not form a grid of {n_u} x {n_v}",
                points.len()
            )));
        }
        let conditions =
            |d: usize| -> Vec<Condition> { params[d].iter().map(|&at| Condition { at, order: 0 }).collect() };
        let data: Vec<f64> = points.iter().flat_map(|p| p.iter().copied()).collect();
        let [u, v] = knots;
        // All columns at once, then all rows.
        let half = solve(&u, &conditions(0), &data, n_v * 3)?;
        let half = transpose(&half, u.basis_count(), n_v, 3);
        let net = solve(&v, &conditions(1), &half, u.basis_count() * 3)?;
        let net = transpose(&net, v.basis_count(), u.basis_count(), 3);
        Self::new(u, v, net.chunks_exact(3).map(Vector3::from_column_slice).collect(), None)
    }
}
