//! Points and jets of a surface in lanes, which share their spans.

use crate::simd::{Lanes, MAX_LANES};
use crate::span_table::MAX_FIXED_DEGREE;
use crate::surface_eval::add_orders;
use crate::{BsplineSurface, SurfaceJet, basis_fixed, rational};
use nalgebra::Vector3;

/// Basis rows of one direction, function by function: value, first, second derivative.
type Columns<V> = [[V; 3]; MAX_FIXED_DEGREE + 1];

/// What is evaluated at each parameter.
pub(super) trait Evaluation: Sized {
    /// Evaluates in one pair of spans; `order` says where the results of the lanes go.
    fn in_lanes<L: Lanes, const M: usize, const RATIONAL: bool>(
        l: L,
        surface: &BsplineSurface,
        spans: (usize, usize),
        parameters: [L::V; 2],
        order: &[u32],
        out: &mut [Self],
    );
}

impl Evaluation for SurfaceJet {
    #[inline(always)]
    fn in_lanes<L: Lanes, const M: usize, const RATIONAL: bool>(
        l: L,
        surface: &BsplineSurface,
        spans: (usize, usize),
        parameters: [L::V; 2],
        order: &[u32],
        out: &mut [Self],
    ) {
        let [x, y, z] = jet_lanes::<L, M, RATIONAL>(l, surface, spans, parameters);
        // The numbers of a jet in their order, four by four, and two that remain.
        let mut quadruples = [[[0.0; 4]; MAX_LANES]; 4];
        let mut rest = [[0.0; MAX_LANES]; 2];
        l.store_quadruples([x[0], y[0], z[0], x[1]], &mut quadruples[0]);
        l.store_quadruples([y[1], z[1], x[2], y[2]], &mut quadruples[1]);
        l.store_quadruples([z[2], x[3], y[3], z[3]], &mut quadruples[2]);
        l.store_quadruples([x[4], y[4], z[4], x[5]], &mut quadruples[3]);
        l.store(y[5], &mut rest[0]);
        l.store(z[5], &mut rest[1]);
        for (lane, &index) in (0..MAX_LANES).zip(order) {
            let [a, b, c, d] =
                [quadruples[0][lane], quadruples[1][lane], quadruples[2][lane], quadruples[3][lane]];
            out[index as usize] = Self {
                point: Vector3::new(a[0], a[1], a[2]),
                du: Vector3::new(a[3], b[0], b[1]),
                dv: Vector3::new(b[2], b[3], c[0]),
                duu: Vector3::new(c[1], c[2], c[3]),
                duv: Vector3::new(d[0], d[1], d[2]),
                dvv: Vector3::new(d[3], rest[0][lane], rest[1][lane]),
            };
        }
    }
}

/// x, y and z of value, u, v, uu, uv, vv: the sums of the single jet, in the same order.
#[inline(always)]
fn jet_lanes<L: Lanes, const M: usize, const RATIONAL: bool>(
    l: L,
    surface: &BsplineSurface,
    (span_u, span_v): (usize, usize),
    [u, v]: [L::V; 2],
) -> [[L::V; 6]; 3] {
    let bu = surface.columns_of_degree(l, span_u, u);
    let bv = basis_fixed::jet::<L, M>(l, surface.knots_v(), span_v, v);
    let x = sums::<L, M, RATIONAL, 0>(l, surface, span_u, span_v, &bu, &bv);
    let y = sums::<L, M, RATIONAL, 1>(l, surface, span_u, span_v, &bu, &bv);
    let z = sums::<L, M, RATIONAL, 2>(l, surface, span_u, span_v, &bu, &bv);
    if !RATIONAL {
        return [x, y, z];
    }
    let w = sums::<L, M, RATIONAL, 3>(l, surface, span_u, span_v, &bu, &bv);
    let inverse = l.div(l.splat(1.0), w[0]);
    [
        rational::surface_quotient(l, &x, &w, inverse),
        rational::surface_quotient(l, &y, &w, inverse),
        rational::surface_quotient(l, &z, &w, inverse),
    ]
}

/// Value, u, v, uu, uv, vv of homogeneous coordinate `C`. One coordinate after the other: its sums stay in
/// registers.
#[inline(always)]
fn sums<L: Lanes, const M: usize, const RATIONAL: bool, const C: usize>(
    l: L,
    surface: &BsplineSurface,
    span_u: usize,
    span_v: usize,
    bu: &Columns<L::V>,
    bv: &[[L::V; M]; 3],
) -> [L::V; 6] {
    let zero = l.splat(0.0);
    let mut sum = [zero; 6];
    for (i, b) in bu.iter().take(surface.degree_u() + 1).enumerate() {
        let row = surface.homogeneous_row::<M, RATIONAL, C>(span_u, span_v, i);
        let x = l.splat(row[0]);
        let mut r = [l.mul(x, bv[0][0]), l.mul(x, bv[1][0]), l.mul(x, bv[2][0])];
        for j in 1..M {
            let x = l.splat(row[j]);
            r[0] = l.add(r[0], l.mul(x, bv[0][j]));
            r[1] = l.add(r[1], l.mul(x, bv[1][j]));
            r[2] = l.add(r[2], l.mul(x, bv[2][j]));
        }
        add_orders(l, &mut sum, &r, b);
    }
    sum
}

impl Evaluation for Vector3<f64> {
    #[inline(always)]
    fn in_lanes<L: Lanes, const M: usize, const RATIONAL: bool>(
        l: L,
        surface: &BsplineSurface,
        spans: (usize, usize),
        parameters: [L::V; 2],
        order: &[u32],
        out: &mut [Self],
    ) {
        let [x, y, z] = point_lanes::<L, M, RATIONAL>(l, surface, spans, parameters);
        let mut lanes = [[0.0; MAX_LANES]; 3];
        l.store(x, &mut lanes[0]);
        l.store(y, &mut lanes[1]);
        l.store(z, &mut lanes[2]);
        for (lane, &index) in (0..MAX_LANES).zip(order) {
            out[index as usize] = Self::new(lanes[0][lane], lanes[1][lane], lanes[2][lane]);
        }
    }
}

#[inline(always)]
fn point_lanes<L: Lanes, const M: usize, const RATIONAL: bool>(
    l: L,
    surface: &BsplineSurface,
    (span_u, span_v): (usize, usize),
    [u, v]: [L::V; 2],
) -> [L::V; 3] {
    let bu = surface.values_of_degree(l, span_u, u);
    let bv = basis_fixed::values::<L, M>(l, surface.knots_v(), span_v, v);
    let x = sum::<L, M, RATIONAL, 0>(l, surface, span_u, span_v, &bu, &bv);
    let y = sum::<L, M, RATIONAL, 1>(l, surface, span_u, span_v, &bu, &bv);
    let z = sum::<L, M, RATIONAL, 2>(l, surface, span_u, span_v, &bu, &bv);
    if !RATIONAL {
        return [x, y, z];
    }
    let w = sum::<L, M, RATIONAL, 3>(l, surface, span_u, span_v, &bu, &bv);
    let inverse = l.div(l.splat(1.0), w);
    [l.mul(x, inverse), l.mul(y, inverse), l.mul(z, inverse)]
}

/// The value of homogeneous coordinate `C`.
#[inline(always)]
fn sum<L: Lanes, const M: usize, const RATIONAL: bool, const C: usize>(
    l: L,
    surface: &BsplineSurface,
    span_u: usize,
    span_v: usize,
    bu: &[L::V; MAX_FIXED_DEGREE + 1],
    bv: &[L::V; M],
) -> L::V {
    let mut sum = l.splat(0.0);
    for (i, b) in bu.iter().take(surface.degree_u() + 1).enumerate() {
        let row = surface.homogeneous_row::<M, RATIONAL, C>(span_u, span_v, i);
        let mut r = l.mul(l.splat(row[0]), bv[0]);
        for j in 1..M {
            let x = l.splat(row[j]);
            r = l.add(r, l.mul(x, bv[j]));
        }
        sum = l.add(sum, l.mul(r, *b));
    }
    sum
}

impl BsplineSurface {
    #[inline(always)]
    fn columns<L: Lanes, const N: usize>(&self, l: L, span: usize, u: L::V) -> Columns<L::V> {
        let rows = basis_fixed::jet::<L, N>(l, self.knots_u(), span, u);
        let mut columns = [[u; 3]; MAX_FIXED_DEGREE + 1];
        for i in 0..N {
            columns[i] = [rows[0][i], rows[1][i], rows[2][i]];
        }
        columns
    }

    #[inline(always)]
    fn columns_of_degree<L: Lanes>(&self, l: L, span: usize, u: L::V) -> Columns<L::V> {
        match self.degree_u() {
            1 => self.columns::<L, 2>(l, span, u),
            2 => self.columns::<L, 3>(l, span, u),
            3 => self.columns::<L, 4>(l, span, u),
            4 => self.columns::<L, 5>(l, span, u),
            _ => self.columns::<L, 6>(l, span, u),
        }
    }

    #[inline(always)]
    fn values_of_degree<L: Lanes>(&self, l: L, span: usize, u: L::V) -> [L::V; MAX_FIXED_DEGREE + 1] {
        #[inline(always)]
        fn padded<L: Lanes, const N: usize>(s: &BsplineSurface, l: L, span: usize, u: L::V) -> [L::V; 6] {
            let mut out = [u; MAX_FIXED_DEGREE + 1];
            out[..N].copy_from_slice(&basis_fixed::values::<L, N>(l, s.knots_u(), span, u));
            out
        }
        match self.degree_u() {
            1 => padded::<L, 2>(self, l, span, u),
            2 => padded::<L, 3>(self, l, span, u),
            3 => padded::<L, 4>(self, l, span, u),
            4 => padded::<L, 5>(self, l, span, u),
            _ => padded::<L, 6>(self, l, span, u),
        }
    }

    /// Coordinate `C` of the `M` control points of row `i` that act on a pair of spans, times their weights; the
    /// weights themselves for `C = 3`.
    #[inline(always)]
    fn homogeneous_row<const M: usize, const RATIONAL: bool, const C: usize>(
        &self,
        span_u: usize,
        span_v: usize,
        i: usize,
    ) -> [f64; M] {
        let start = self.row_start(span_u, span_v, i);
        let points = &self.control_points()[start..][..M];
        let weights = if RATIONAL { self.factors().map(|w| &w[start..][..M]) } else { None };
        let mut row = [1.0; M];
        for j in 0..M {
            if C < 3 {
                row[j] = points[j][C];
            }
            if let Some(weights) = weights {
                row[j] *= weights[j];
            }
        }
        row
    }
}
