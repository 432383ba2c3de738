//! Exact decomposition into Bézier pieces.

use crate::knots::MAX_DEGREE;
use crate::{BsplineCurve, BsplineSurface, Interval, KnotVector, basis};
use nalgebra::{SVector, Vector3};

/// One polynomial or rational piece of a curve, on one span of its knot vector.
#[derive(Clone, Debug, PartialEq)]
pub struct BezierCurve<const D: usize> {
    /// The span in the parameter of the whole curve.
    pub interval: Interval,
    /// `degree + 1` Bézier points.
    pub control_points: Vec<SVector<f64, D>>,
    /// Their weights, if rational.
    pub weights: Option<Vec<f64>>,
}

/// One polynomial or rational patch of a surface, on one pair of spans.
#[derive(Clone, Debug, PartialEq)]
pub struct BezierPatch {
    /// The span in `u` and `v` of the whole surface.
    pub intervals: [Interval; 2],
    /// Degrees in `u` and `v`.
    pub degrees: [usize; 2],
    /// `(degree_u + 1)(degree_v + 1)` Bézier points, row-major, `u` outer.
    pub control_points: Vec<Vector3<f64>>,
    /// Their weights, if rational.
    pub weights: Option<Vec<f64>>,
}

/// Row `j` holds the weights of the span's control points in its Bézier point `j`.
fn extraction(knots: &KnotVector, span: usize) -> Vec<basis::BasisRow> {
    let p = knots.degree();
    let interval = knots.span_interval(span);
    let mut arguments = vec![interval.start(); p];
    let mut rows = vec![[0.0; MAX_DEGREE + 1]; p + 1];
    for (j, row) in rows.iter_mut().enumerate() {
        if j > 0 {
            arguments[j - 1] = interval.end();
        }
        basis::polar_weights(knots, span, &arguments, row);
    }
    rows
}

impl<const D: usize> BsplineCurve<D> {
    /// The Bézier pieces, one for each non-empty span, in order.
    #[must_use]
    pub fn bezier_curves(&self) -> Vec<BezierCurve<D>> {
        let p = self.degree();
        let piece = |span: usize| {
            let rows = extraction(self.knots(), span);
            let first = span - p;
            let mut control_points = Vec::with_capacity(p + 1);
            let mut weights = Vec::with_capacity(p + 1);
            for row in &rows {
                let mut a = SVector::zeros();
                let mut w = 0.0;
                for j in 0..=p {
                    let b = row[j] * self.factors().map_or(1.0, |w| w[first + j]);
                    a += self.control_points()[first + j] * b;
                    w += b;
                }
                control_points.push(if self.weights().is_some() { a / w } else { a });
                weights.push(w);
            }
            BezierCurve {
                interval: self.knots().span_interval(span),
                control_points,
                weights: self.weights().is_some().then_some(weights),
            }
        };
        self.knots().spans().map(piece).collect()
    }
}

impl BsplineSurface {
    /// The Bézier patches, row by row: `v` runs fastest.
    #[must_use]
    pub fn bezier_patches(&self) -> Vec<BezierPatch> {
        let rows_v: Vec<_> = self.knots_v().spans().map(|s| (s, extraction(self.knots_v(), s))).collect();
        let mut patches = Vec::new();
        for span_u in self.knots_u().spans() {
            let rows_u = extraction(self.knots_u(), span_u);
            for (span_v, rows_v) in &rows_v {
                patches.push(self.bezier_patch(span_u, &rows_u, *span_v, rows_v));
            }
        }
        patches
    }

    fn bezier_patch(
        &self,
        span_u: usize,
        rows_u: &[basis::BasisRow],
        span_v: usize,
        rows_v: &[basis::BasisRow],
    ) -> BezierPatch {
        let (p, q) = (self.degree_u(), self.degree_v());
        let (first_u, first_v) = (span_u - p, span_v - q);
        // First along v for every row of the net, then along u.
        let mut half = vec![(Vector3::zeros(), 0.0); (p + 1) * (q + 1)];
        for i in 0..=p {
            for (j, row) in rows_v.iter().enumerate() {
                let slot = &mut half[i * (q + 1) + j];
                for l in 0..=q {
                    let b =
                        row[l] * self.factors().map_or(1.0, |w| w[(first_u + i) * self.n_v() + first_v + l]);
                    slot.0 += self.control_point(first_u + i, first_v + l) * b;
                    slot.1 += b;
                }
            }
        }
        let mut control_points = Vec::with_capacity(half.len());
        let mut weights = Vec::with_capacity(half.len());
        for row in rows_u {
            for j in 0..=q {
                let mut a = Vector3::zeros();
                let mut w = 0.0;
                for k in 0..=p {
                    let (point, weight) = half[k * (q + 1) + j];
                    a += point * row[k];
                    w += weight * row[k];
                }
                control_points.push(if self.weights().is_some() { a / w } else { a });
                weights.push(w);
            }
        }
        BezierPatch {
            intervals: [self.knots_u().span_interval(span_u), self.knots_v().span_interval(span_v)],
            degrees: [p, q],
            control_points,
            weights: self.weights().is_some().then_some(weights),
        }
    }
}
