//! B-spline and NURBS curves.

use crate::magnitude::{check_points, check_weights};
use crate::{Break, CurveJet, Error, Interval, KnotVector, MAX_DEGREE, ParametricCurve, basis, rational};
use nalgebra::SVector;

/// A B-spline curve `c(t) = Σ N_i(t) p_i` in `R^D`, or with weights the rational one
/// `c(t) = Σ N_i(t) w_i p_i / Σ N_i(t) w_i` (NURBS).
///
/// Control points are stored as points of `R^D`, weights apart from them.
#[derive(Clone, Debug, PartialEq)]
pub struct BsplineCurve<const D: usize> {
    knots: KnotVector,
    control_points: Vec<SVector<f64, D>>,
    weights: Option<Vec<f64>>,
    /// The weights to be computed with, where they differ by a power of two from the given ones.
    scaled: Option<Vec<f64>>,
}

impl<const D: usize> BsplineCurve<D> {
    /// A curve from knots, control points and, if rational, weights.
    ///
    /// A periodic knot vector needs its last `p` control points (and weights) equal to the first `p`.
    ///
    /// # Errors
    /// When the counts do not fit, a coordinate is not finite or beyond
    /// [`MAX_COORDINATE`](crate::MAX_COORDINATE), a weight is not positive or smaller than another by more than
    /// [`MAX_WEIGHT_RATIO`](crate::MAX_WEIGHT_RATIO), or the control points of a periodic curve do not repeat.
    pub fn new(
        knots: KnotVector,
        control_points: Vec<SVector<f64, D>>,
        weights: Option<Vec<f64>>,
    ) -> Result<Self, Error> {
        let needed = knots.basis_count();
        if control_points.len() != needed {
            return Err(Error::ControlPointCount {
                found: control_points.len(),
                needed,
                knots: knots.as_slice().len(),
                degree: knots.degree(),
            });
        }
        check_points(&control_points)?;
        let scaled = check_weights(weights.as_deref(), needed)?;
        if knots.is_periodic() {
            let distinct = knots.distinct_count();
            let size = extent(&control_points);
            for first in 0..knots.degree() {
                let index = distinct + first;
                let gap = (control_points[index] - control_points[first]).amax();
                let weight_gap =
                    scaled.as_ref().or(weights.as_ref()).map_or(0.0, |w| (w[index] / w[first] - 1.0).abs());
                if gap > 1e-9 * size || weight_gap > 1e-9 {
                    return Err(Error::PeriodicControlPoint { index, first });
                }
            }
        }
        Ok(Self { knots, control_points, weights, scaled })
    }

    /// The Bézier curve of the given control points on `[0, 1]`.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn bezier(control_points: Vec<SVector<f64, D>>, weights: Option<Vec<f64>>) -> Result<Self, Error> {
        let degree = control_points.len().saturating_sub(1);
        Self::new(KnotVector::bezier(degree, Interval::UNIT)?, control_points, weights)
    }

    /// Degree.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.knots.degree()
    }

    /// Knot vector.
    #[must_use]
    pub fn knots(&self) -> &KnotVector {
        &self.knots
    }

    /// Control points.
    #[must_use]
    pub fn control_points(&self) -> &[SVector<f64, D>] {
        &self.control_points
    }

    /// Weights, if the curve is rational.
    #[must_use]
    pub fn weights(&self) -> Option<&[f64]> {
        self.weights.as_deref()
    }

    /// The weights to be computed with: the given ones, but for a common factor.
    #[inline]
    pub(crate) fn factors(&self) -> Option<&[f64]> {
        self.scaled.as_deref().or(self.weights.as_deref())
    }

    /// The weight of control point `i` (1 for a polynomial curve).
    #[must_use]
    pub fn weight(&self, i: usize) -> f64 {
        self.weights.as_ref().map_or(1.0, |w| w[i])
    }

    /// Knots, control points and weights, for building another curve from them.
    #[must_use]
    pub fn into_parts(self) -> (KnotVector, Vec<SVector<f64, D>>, Option<Vec<f64>>) {
        (self.knots, self.control_points, self.weights)
    }

    /// Derivatives of order `0..=order` at `t`; element `k` is the `k`-th derivative ([PT97, A3.2, A4.2]).
    #[must_use]
    pub fn derivatives(&self, t: f64, order: usize) -> Vec<SVector<f64, D>> {
        let t = self.wrap(t);
        let (p, span) = (self.degree(), self.knots.span(t));
        let mut rows = vec![[0.0; MAX_DEGREE + 1]; order + 1];
        basis::derivatives(&self.knots, span, t, order, &mut rows);
        let mut a = vec![SVector::zeros(); order + 1];
        let mut w = vec![0.0; order + 1];
        for (d, row) in rows.iter().enumerate() {
            for j in 0..=p {
                let i = span - p + j;
                let b = row[j] * self.factors().map_or(1.0, |w| w[i]);
                a[d] += self.control_points[i] * b;
                w[d] += b;
            }
        }
        if self.weights.is_some() {
            rational::curve_derivatives(&mut a, &w);
        }
        a
    }

    #[inline]
    pub(crate) fn wrap(&self, t: f64) -> f64 {
        if self.knots.is_periodic() { self.knots.normalize(t) } else { t }
    }
}

impl<const D: usize> ParametricCurve<D> for BsplineCurve<D> {
    fn domain(&self) -> Interval {
        self.knots.domain()
    }

    fn period(&self) -> Option<f64> {
        self.knots.period()
    }

    fn breaks(&self) -> Vec<f64> {
        self.knots.breaks()
    }

    fn jet(&self, t: f64) -> CurveJet<D> {
        let t = self.wrap(t);
        self.jet_in_span(self.knots.span(t), t)
    }

    fn point(&self, t: f64) -> SVector<f64, D> {
        let t = self.wrap(t);
        self.point_in_span(self.knots.span(t), t)
    }

    fn derivative_breaks(&self) -> Vec<Break> {
        self.knots.derivative_breaks()
    }

    fn nearest_control_parameter(&self, x: &SVector<f64, D>) -> Option<f64> {
        let i = nearest_index(&self.control_points, x)?;
        Some(self.knots.normalize(self.knots.greville_at(i)))
    }
}

/// Index of the point nearest to `x`, the first of several; `None` when no distance is comparable.
pub(crate) fn nearest_index<const D: usize>(
    points: &[SVector<f64, D>],
    x: &SVector<f64, D>,
) -> Option<usize> {
    let distances = points.iter().map(|p| (p - x).norm_squared()).enumerate();
    distances.filter(|(_, d)| !d.is_nan()).min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
}

/// Largest side of the bounding box, for relative tolerances.
pub(crate) fn extent<const D: usize>(points: &[SVector<f64, D>]) -> f64 {
    let mut low = SVector::<f64, D>::repeat(f64::INFINITY);
    let mut high = -low;
    for p in points {
        low = low.inf(p);
        high = high.sup(p);
    }
    (high - low).max()
}
