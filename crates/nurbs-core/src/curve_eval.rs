//! Points and jets of curves at one parameter.

use crate::simd::One;
use crate::{BsplineCurve, CurveJet, MAX_DEGREE, basis, basis_fixed, rational};
use nalgebra::SVector;

impl<const D: usize> BsplineCurve<D> {
    /// The jet at `t`, when `t` is known to lie in (or is to be continued from) the given span.
    ///
    /// Degrees up to 5 run in loops of constant length, without divisions on a polynomial curve.
    #[must_use]
    #[inline]
    pub fn jet_in_span(&self, span: usize, t: f64) -> CurveJet<D> {
        match self.degree() {
            1 => self.jet_fixed::<2>(span, t),
            2 => self.jet_fixed::<3>(span, t),
            3 => self.jet_fixed::<4>(span, t),
            4 => self.jet_fixed::<5>(span, t),
            5 => self.jet_fixed::<6>(span, t),
            p => {
                let mut rows = [[0.0; MAX_DEGREE + 1]; 3];
                basis::jet(self.knots(), span, t, &mut rows);
                self.combine_jet(span, [&rows[0][..=p], &rows[1][..=p], &rows[2][..=p]])
            }
        }
    }

    /// The point at `t`, when `t` is known to lie in (or is to be continued from) the given span.
    #[must_use]
    #[inline]
    pub fn point_in_span(&self, span: usize, t: f64) -> SVector<f64, D> {
        match self.degree() {
            1 => self.combine(span, &basis_fixed::values::<One, 2>(One, self.knots(), span, t)),
            2 => self.combine(span, &basis_fixed::values::<One, 3>(One, self.knots(), span, t)),
            3 => self.combine(span, &basis_fixed::values::<One, 4>(One, self.knots(), span, t)),
            4 => self.combine(span, &basis_fixed::values::<One, 5>(One, self.knots(), span, t)),
            5 => self.combine(span, &basis_fixed::values::<One, 6>(One, self.knots(), span, t)),
            p => {
                let mut row = [0.0; MAX_DEGREE + 1];
                basis::values(self.knots(), span, t, &mut row);
                self.combine(span, &row[..=p])
            }
        }
    }

    #[inline]
    fn jet_fixed<const N: usize>(&self, span: usize, t: f64) -> CurveJet<D> {
        let [values, first, second] = basis_fixed::jet::<One, N>(One, self.knots(), span, t);
        self.combine_jet(span, [&values, &first, &second])
    }

    #[inline(always)]
    fn combine_jet(&self, span: usize, rows: [&[f64]; 3]) -> CurveJet<D> {
        let count = rows[0].len();
        let start = span + 1 - count;
        let points = &self.control_points()[start..][..count];
        let mut a = [SVector::<f64, D>::zeros(); 3];
        let Some(weights) = self.factors() else {
            for j in 0..count {
                for d in 0..3 {
                    let term = points[j] * rows[d][j];
                    a[d] = if j == 0 { term } else { a[d] + term };
                }
            }
            return CurveJet { point: a[0], d1: a[1], d2: a[2] };
        };
        let weights = &weights[start..][..count];
        let mut w = [0.0; 3];
        for j in 0..count {
            let p = points[j] * weights[j];
            for d in 0..3 {
                let (term, weight) = (p * rows[d][j], weights[j] * rows[d][j]);
                (a[d], w[d]) = if j == 0 { (term, weight) } else { (a[d] + term, w[d] + weight) };
            }
        }
        let inverse = 1.0 / w[0];
        for c in 0..D {
            let of_coordinate = [a[0][c], a[1][c], a[2][c]];
            [a[0][c], a[1][c], a[2][c]] = rational::curve_quotient(One, &of_coordinate, &w, inverse);
        }
        CurveJet { point: a[0], d1: a[1], d2: a[2] }
    }

    #[inline(always)]
    fn combine(&self, span: usize, row: &[f64]) -> SVector<f64, D> {
        let count = row.len();
        let start = span + 1 - count;
        let points = &self.control_points()[start..][..count];
        let mut a = SVector::<f64, D>::zeros();
        let Some(weights) = self.factors() else {
            for j in 0..count {
                let term = points[j] * row[j];
                a = if j == 0 { term } else { a + term };
            }
            return a;
        };
        let weights = &weights[start..][..count];
        let mut w = 0.0;
        for j in 0..count {
            let (term, weight) = (points[j] * weights[j] * row[j], weights[j] * row[j]);
            (a, w) = if j == 0 { (term, weight) } else { (a + term, w + weight) };
        }
        a * (1.0 / w)
    }
}
