//! Points and jets of surfaces at one parameter.

use crate::simd::{Lanes, One};
use crate::span_table::MAX_FIXED_DEGREE;
use crate::{BsplineSurface, MAX_DEGREE, SurfaceJet, basis, basis_fixed, rational};
use nalgebra::{Vector2, Vector3};

/// Basis rows of degrees up to [`MAX_FIXED_DEGREE`], function by function: value, first, second derivative.
type Columns = [[f64; 3]; MAX_FIXED_DEGREE + 1];

impl BsplineSurface {
    /// The jet at `(u, v)`, when these are known to lie in (or are to be continued from) the given spans.
    ///
    /// Degrees up to 5 run in loops of constant length, without divisions on a polynomial surface.
    #[must_use]
    pub fn jet_in_span(&self, span_u: usize, span_v: usize, u: f64, v: f64) -> SurfaceJet {
        match self.degree_v() {
            1 => self.jet_fixed::<2>(span_u, span_v, u, v),
            2 => self.jet_fixed::<3>(span_u, span_v, u, v),
            3 => self.jet_fixed::<4>(span_u, span_v, u, v),
            4 => self.jet_fixed::<5>(span_u, span_v, u, v),
            5 => self.jet_fixed::<6>(span_u, span_v, u, v),
            _ => self.jet_general(span_u, span_v, u, v),
        }
    }

    /// The point at `(u, v)`, when these are known to lie in (or are to be continued from) the given spans.
    #[must_use]
    pub fn point_in_span(&self, span_u: usize, span_v: usize, u: f64, v: f64) -> Vector3<f64> {
        match self.degree_v() {
            1 => self.point_fixed::<2>(span_u, span_v, u, v),
            2 => self.point_fixed::<3>(span_u, span_v, u, v),
            3 => self.point_fixed::<4>(span_u, span_v, u, v),
            4 => self.point_fixed::<5>(span_u, span_v, u, v),
            5 => self.point_fixed::<6>(span_u, span_v, u, v),
            _ => self.point_general(span_u, span_v, u, v),
        }
    }

    /// Where the columns that act on a pair of spans start in row `i` of these.
    #[inline(always)]
    pub(crate) fn row_start(&self, span_u: usize, span_v: usize, i: usize) -> usize {
        (span_u - self.degree_u() + i) * self.n_v() + span_v - self.degree_v()
    }

    // A function for each degree in v, or the stack frame of the largest is paid for by all.
    #[inline(never)]
    fn jet_fixed<const M: usize>(&self, span_u: usize, span_v: usize, u: f64, v: f64) -> SurfaceJet {
        let bu = match self.degree_u() {
            1 => self.columns_u::<2>(span_u, u),
            2 => self.columns_u::<3>(span_u, u),
            3 => self.columns_u::<4>(span_u, u),
            4 => self.columns_u::<5>(span_u, u),
            5 => self.columns_u::<6>(span_u, u),
            _ => return self.jet_general(span_u, span_v, u, v),
        };
        let bv = basis_fixed::jet::<One, M>(One, self.knots_v(), span_v, v);
        if let Some(weights) = self.factors() {
            return self.jet_rational(weights, span_u, span_v, &bu, &bv);
        }
        // x and y fill a vector register of every x86-64 machine, z goes beside them.
        let mut xy = [Vector2::zeros(); 6];
        let mut z = [0.0; 6];
        for (i, b) in bu.iter().take(self.degree_u() + 1).enumerate() {
            let points = &self.control_points()[self.row_start(span_u, span_v, i)..][..M];
            // The first terms are the sums so far: nothing is added to zero.
            let (p, q) = (points[0].xy(), points[0].z);
            let mut rxy = [p * bv[0][0], p * bv[1][0], p * bv[2][0]];
            let mut rz = [q * bv[0][0], q * bv[1][0], q * bv[2][0]];
            for j in 1..M {
                let (p, q) = (points[j].xy(), points[j].z);
                for k in 0..3 {
                    rxy[k] += p * bv[k][j];
                    rz[k] += q * bv[k][j];
                }
            }
            xy[0] += rxy[0] * b[0];
            xy[1] += rxy[0] * b[1];
            xy[2] += rxy[1] * b[0];
            xy[3] += rxy[0] * b[2];
            xy[4] += rxy[1] * b[1];
            xy[5] += rxy[2] * b[0];
            add_orders(One, &mut z, &rz, b);
        }
        let [point, du, dv, duu, duv, dvv] =
            std::array::from_fn(|slot| Vector3::new(xy[slot].x, xy[slot].y, z[slot]));
        SurfaceJet { point, du, dv, duu, duv, dvv }
    }

    #[inline(never)]
    fn jet_rational<const M: usize>(
        &self,
        weights: &[f64],
        span_u: usize,
        span_v: usize,
        bu: &Columns,
        bv: &[[f64; M]; 3],
    ) -> SurfaceJet {
        let mut a = [[0.0; 6]; 4];
        for (i, b) in bu.iter().take(self.degree_u() + 1).enumerate() {
            let start = self.row_start(span_u, span_v, i);
            let (points, weights) = (&self.control_points()[start..][..M], &weights[start..][..M]);
            let mut r = [[0.0; 3]; 4];
            for j in 0..M {
                let w = weights[j];
                let p = points[j] * w;
                for k in 0..3 {
                    let terms = [p.x * bv[k][j], p.y * bv[k][j], p.z * bv[k][j], w * bv[k][j]];
                    for c in 0..4 {
                        r[c][k] = if j == 0 { terms[c] } else { r[c][k] + terms[c] };
                    }
                }
            }
            for c in 0..4 {
                add_orders(One, &mut a[c], &r[c], b);
            }
        }
        rational_jet(&a)
    }

    /// Any degree.
    #[inline(never)]
    fn jet_general(&self, span_u: usize, span_v: usize, u: f64, v: f64) -> SurfaceJet {
        let mut bu = [[0.0; MAX_DEGREE + 1]; 3];
        let mut bv = [[0.0; MAX_DEGREE + 1]; 3];
        basis::jet(self.knots_u(), span_u, u, &mut bu);
        basis::jet(self.knots_v(), span_v, v, &mut bv);
        let mut a = [[0.0; 6]; 4];
        for i in 0..=self.degree_u() {
            let start = self.row_start(span_u, span_v, i);
            let mut r = [[0.0; 3]; 4];
            for j in 0..=self.degree_v() {
                let w = self.factors().map_or(1.0, |w| w[start + j]);
                let p = self.control_points()[start + j] * w;
                for (sum, x) in r.iter_mut().zip([p.x, p.y, p.z, w]) {
                    for k in 0..3 {
                        sum[k] += x * bv[k][j];
                    }
                }
            }
            for c in 0..4 {
                add_orders(One, &mut a[c], &r[c], &[bu[0][i], bu[1][i], bu[2][i]]);
            }
        }
        if self.factors().is_some() { rational_jet(&a) } else { jet_of_coordinates(&a[0], &a[1], &a[2]) }
    }

    #[inline(always)]
    fn columns_u<const N: usize>(&self, span: usize, u: f64) -> Columns {
        let rows = basis_fixed::jet::<One, N>(One, self.knots_u(), span, u);
        let mut columns = [[0.0; 3]; MAX_FIXED_DEGREE + 1];
        for i in 0..N {
            columns[i] = [rows[0][i], rows[1][i], rows[2][i]];
        }
        columns
    }

    #[inline(never)]
    fn point_fixed<const M: usize>(&self, span_u: usize, span_v: usize, u: f64, v: f64) -> Vector3<f64> {
        let bu = match self.degree_u() {
            1 => self.values_u::<2>(span_u, u),
            2 => self.values_u::<3>(span_u, u),
            3 => self.values_u::<4>(span_u, u),
            4 => self.values_u::<5>(span_u, u),
            5 => self.values_u::<6>(span_u, u),
            _ => return self.point_general(span_u, span_v, u, v),
        };
        let bv = basis_fixed::values::<One, M>(One, self.knots_v(), span_v, v);
        let (mut a, mut w) = (Vector3::zeros(), 0.0);
        for (i, b) in bu.iter().take(self.degree_u() + 1).enumerate() {
            let start = self.row_start(span_u, span_v, i);
            let points = &self.control_points()[start..][..M];
            let (mut r, mut rw) = (points[0], 1.0);
            if let Some(weights) = self.factors() {
                let weights = &weights[start..][..M];
                (r, rw) = (r * weights[0] * bv[0], weights[0] * bv[0]);
                for j in 1..M {
                    r += points[j] * weights[j] * bv[j];
                    rw += weights[j] * bv[j];
                }
            } else {
                r *= bv[0];
                for j in 1..M {
                    r += points[j] * bv[j];
                }
            }
            a += r * *b;
            w += rw * b;
        }
        if self.factors().is_some() { a * (1.0 / w) } else { a }
    }

    #[inline(always)]
    fn values_u<const N: usize>(&self, span: usize, u: f64) -> [f64; MAX_FIXED_DEGREE + 1] {
        let mut values = [0.0; MAX_FIXED_DEGREE + 1];
        values[..N].copy_from_slice(&basis_fixed::values::<One, N>(One, self.knots_u(), span, u));
        values
    }

    #[inline(never)]
    fn point_general(&self, span_u: usize, span_v: usize, u: f64, v: f64) -> Vector3<f64> {
        let (mut bu, mut bv) = ([0.0; MAX_DEGREE + 1], [0.0; MAX_DEGREE + 1]);
        basis::values(self.knots_u(), span_u, u, &mut bu);
        basis::values(self.knots_v(), span_v, v, &mut bv);
        let (mut a, mut w) = (Vector3::zeros(), 0.0);
        for i in 0..=self.degree_u() {
            let start = self.row_start(span_u, span_v, i);
            let (mut r, mut rw) = (Vector3::zeros(), 0.0);
            for j in 0..=self.degree_v() {
                let weight = self.factors().map_or(1.0, |w| w[start + j]);
                r += self.control_points()[start + j] * weight * bv[j];
                rw += weight * bv[j];
            }
            a += r * bu[i];
            w += rw * bu[i];
        }
        if self.factors().is_some() { a * (1.0 / w) } else { a }
    }
}

/// Adds row `r` (value, first and second derivative in `v`) times `b` (the same in `u`) to the sums for
/// value, u, v, uu, uv, vv.
#[inline(always)]
pub(crate) fn add_orders<L: Lanes>(l: L, sum: &mut [L::V; 6], r: &[L::V; 3], b: &[L::V; 3]) {
    sum[0] = l.add(sum[0], l.mul(r[0], b[0]));
    sum[1] = l.add(sum[1], l.mul(r[0], b[1]));
    sum[2] = l.add(sum[2], l.mul(r[1], b[0]));
    sum[3] = l.add(sum[3], l.mul(r[0], b[2]));
    sum[4] = l.add(sum[4], l.mul(r[1], b[1]));
    sum[5] = l.add(sum[5], l.mul(r[2], b[0]));
}

#[inline(always)]
pub(crate) fn jet_of_coordinates(x: &[f64; 6], y: &[f64; 6], z: &[f64; 6]) -> SurfaceJet {
    let [point, du, dv, duu, duv, dvv] = std::array::from_fn(|slot| Vector3::new(x[slot], y[slot], z[slot]));
    SurfaceJet { point, du, dv, duu, duv, dvv }
}

/// The jet of `a / w` from the sums of x, y, z and w.
#[inline(always)]
fn rational_jet(a: &[[f64; 6]; 4]) -> SurfaceJet {
    let inverse = 1.0 / a[3][0];
    let x = rational::surface_quotient(One, &a[0], &a[3], inverse);
    let y = rational::surface_quotient(One, &a[1], &a[3], inverse);
    let z = rational::surface_quotient(One, &a[2], &a[3], inverse);
    jet_of_coordinates(&x, &y, &z)
}
