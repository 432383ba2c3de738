//! B-spline and NURBS surfaces.

use crate::curve::{extent, nearest_index};
use crate::magnitude::{check_points, check_weights};
use crate::{Break, Error, Interval, KnotVector, MAX_DEGREE, ParametricSurface, SurfaceJet, basis, rational};
use nalgebra::Vector3;

/// A tensor product B-spline surface `s(u, v) = Σ N_i(u) N_j(v) p_ij` in `R³`, rational (NURBS) when it
/// has weights.
///
/// Control points are stored row by row: `p_ij` at index `i · n_v + j`, `i` running in `u`.
#[derive(Clone, Debug, PartialEq)]
pub struct BsplineSurface {
    knots_u: KnotVector,
    knots_v: KnotVector,
    control_points: Vec<Vector3<f64>>,
    weights: Option<Vec<f64>>,
    /// The weights to be computed with, where they differ by a power of two from the given ones.
    scaled: Option<Vec<f64>>,
}

impl BsplineSurface {
    /// A surface from its knots, control points (row-major, `u` outer) and, if rational, weights.
    ///
    /// # Errors
    /// When the counts do not fit, a coordinate is not finite or beyond
    /// [`MAX_COORDINATE`](crate::MAX_COORDINATE), a weight is not positive or smaller than another by more than
    /// [`MAX_WEIGHT_RATIO`](crate::MAX_WEIGHT_RATIO), or the net of a periodic direction does not repeat its first `p`
    /// rows at the end.
    pub fn new(
        knots_u: KnotVector,
        knots_v: KnotVector,
        control_points: Vec<Vector3<f64>>,
        weights: Option<Vec<f64>>,
    ) -> Result<Self, Error> {
        let (n_u, n_v) = (knots_u.basis_count(), knots_v.basis_count());
        let needed = n_u * n_v;
        if control_points.len() != needed {
            return Err(Error::Argument {
                what: format!(
                    "{} control points do not fit: the knots of degrees {} and {} need {n_u} x {n_v} = {needed}",
                    control_points.len(),
                    knots_u.degree(),
                    knots_v.degree()
                ),
            });
        }
        check_points(&control_points)?;
        let scaled = check_weights(weights.as_deref(), needed)?;
        let surface = Self { knots_u, knots_v, control_points, weights, scaled };
        surface.check_periodic()?;
        Ok(surface)
    }

    fn check_periodic(&self) -> Result<(), Error> {
        let size = extent(&self.control_points);
        let (n_u, n_v) = (self.n_u(), self.n_v());
        let same = |index: usize, first: usize| {
            let gap = (self.control_points[index] - self.control_points[first]).amax();
            let weight_gap = self.factors().map_or(0.0, |w| (w[index] / w[first] - 1.0).abs());
            if gap > 1e-9 * size || weight_gap > 1e-9 {
                Err(Error::PeriodicControlPoint { index, first })
            } else {
                Ok(())
            }
        };
        if self.knots_u.is_periodic() {
            let distinct = self.knots_u.distinct_count();
            for i in 0..self.degree_u() {
                (0..n_v).try_for_each(|j| same((distinct + i) * n_v + j, i * n_v + j))?;
            }
        }
        if self.knots_v.is_periodic() {
            let distinct = self.knots_v.distinct_count();
            for j in 0..self.degree_v() {
                (0..n_u).try_for_each(|i| same(i * n_v + distinct + j, i * n_v + j))?;
            }
        }
        Ok(())
    }

    /// Degree in `u`.
    #[must_use]
    pub fn degree_u(&self) -> usize {
        self.knots_u.degree()
    }

    /// Degree in `v`.
    #[must_use]
    pub fn degree_v(&self) -> usize {
        self.knots_v.degree()
    }

    /// Knot vector in `u`.
    #[must_use]
    pub fn knots_u(&self) -> &KnotVector {
        &self.knots_u
    }

    /// Knot vector in `v`.
    #[must_use]
    pub fn knots_v(&self) -> &KnotVector {
        &self.knots_v
    }

    /// Number of rows of the control net (control points in `u`).
    #[must_use]
    pub fn n_u(&self) -> usize {
        self.knots_u.basis_count()
    }

    /// Number of columns of the control net (control points in `v`).
    #[must_use]
    pub fn n_v(&self) -> usize {
        self.knots_v.basis_count()
    }

    /// All control points, row-major.
    #[must_use]
    pub fn control_points(&self) -> &[Vector3<f64>] {
        &self.control_points
    }

    /// Control point `p_ij`.
    #[must_use]
    pub fn control_point(&self, i: usize, j: usize) -> Vector3<f64> {
        self.control_points[i * self.n_v() + j]
    }

    /// Weights, row-major, if the surface is rational.
    #[must_use]
    pub fn weights(&self) -> Option<&[f64]> {
        self.weights.as_deref()
    }

    /// The weights to be computed with: the given ones, but for a common factor.
    #[inline]
    pub(crate) fn factors(&self) -> Option<&[f64]> {
        self.scaled.as_deref().or(self.weights.as_deref())
    }

    /// The weight of `p_ij` (1 for a polynomial surface).
    #[must_use]
    pub fn weight(&self, i: usize, j: usize) -> f64 {
        self.weights.as_ref().map_or(1.0, |w| w[i * self.n_v() + j])
    }

    /// Knots, control points and weights, for building another surface from them.
    #[must_use]
    pub fn into_parts(self) -> (KnotVector, KnotVector, Vec<Vector3<f64>>, Option<Vec<f64>>) {
        (self.knots_u, self.knots_v, self.control_points, self.weights)
    }

    /// Partial derivatives `∂^{k+l} s / ∂u^k ∂v^l` for `k + l ≤ order`, at index `[k][l]`
    /// ([PT97, A3.6, A4.4]); entries above the order are zero.
    #[must_use]
    pub fn derivatives(&self, u: f64, v: f64, order: usize) -> Vec<Vec<Vector3<f64>>> {
        let (u, v) = self.wrap(u, v);
        let (p, q) = (self.degree_u(), self.degree_v());
        let (span_u, span_v) = (self.knots_u.span(u), self.knots_v.span(v));
        let mut bu = vec![[0.0; MAX_DEGREE + 1]; order + 1];
        let mut bv = bu.clone();
        basis::derivatives(&self.knots_u, span_u, u, order, &mut bu);
        basis::derivatives(&self.knots_v, span_v, v, order, &mut bv);
        let mut a = vec![vec![Vector3::zeros(); order + 1]; order + 1];
        let mut w = vec![vec![0.0; order + 1]; order + 1];
        for k in 0..=order {
            for l in 0..=order - k {
                for i in 0..=p {
                    for j in 0..=q {
                        let (row, column) = (span_u - p + i, span_v - q + j);
                        let b = bu[k][i]
                            * bv[l][j]
                            * self.factors().map_or(1.0, |w| w[row * self.n_v() + column]);
                        a[k][l] += self.control_point(row, column) * b;
                        w[k][l] += b;
                    }
                }
            }
        }
        if self.weights.is_some() {
            rational::surface_derivatives(&mut a, &w);
        }
        a
    }

    #[inline]
    pub(crate) fn wrap(&self, u: f64, v: f64) -> (f64, f64) {
        let wrap = |knots: &KnotVector, t: f64| if knots.is_periodic() { knots.normalize(t) } else { t };
        (wrap(&self.knots_u, u), wrap(&self.knots_v, v))
    }
}

impl ParametricSurface for BsplineSurface {
    fn domain(&self) -> [Interval; 2] {
        [self.knots_u.domain(), self.knots_v.domain()]
    }

    fn period(&self) -> [Option<f64>; 2] {
        [self.knots_u.period(), self.knots_v.period()]
    }

    fn breaks(&self) -> [Vec<f64>; 2] {
        [self.knots_u.breaks(), self.knots_v.breaks()]
    }

    fn jet(&self, u: f64, v: f64) -> SurfaceJet {
        let (u, v) = self.wrap(u, v);
        self.jet_in_span(self.knots_u.span(u), self.knots_v.span(v), u, v)
    }

    fn point(&self, u: f64, v: f64) -> Vector3<f64> {
        let (u, v) = self.wrap(u, v);
        let (span_u, span_v) = (self.knots_u.span(u), self.knots_v.span(v));
        self.point_in_span(span_u, span_v, u, v)
    }

    fn derivative_breaks(&self) -> [Vec<Break>; 2] {
        [self.knots_u.derivative_breaks(), self.knots_v.derivative_breaks()]
    }

    fn nearest_control_parameter(&self, x: &Vector3<f64>) -> Option<[f64; 2]> {
        let index = nearest_index(&self.control_points, x)?;
        let (i, j) = (index / self.n_v(), index % self.n_v());
        let at = |knots: &KnotVector, k| knots.normalize(knots.greville_at(k));
        Some([at(&self.knots_u, i), at(&self.knots_v, j)])
    }
}
