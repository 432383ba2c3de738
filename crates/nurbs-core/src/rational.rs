//! From homogeneous derivatives to those of the rational shape: the quotient rule.

use crate::simd::Lanes;
use nalgebra::{SVector, Vector3};

/// One coordinate of the jet of `a / w` of a curve; `inverse` is `1 / w[0]` ([PT97, eq. (4.8)]).
#[inline(always)]
pub(crate) fn curve_quotient<L: Lanes>(l: L, a: &[L::V; 3], w: &[L::V; 3], inverse: L::V) -> [L::V; 3] {
    let point = l.mul(a[0], inverse);
    let d1 = l.mul(l.sub(a[1], l.mul(point, w[1])), inverse);
    let first_order = l.mul(l.add(d1, d1), w[1]);
    let d2 = l.mul(l.sub(l.sub(a[2], first_order), l.mul(point, w[2])), inverse);
    [point, d1, d2]
}

/// Derivatives of `a / w` of every order, in place ([PT97, A4.2]).
pub(crate) fn curve_derivatives<const D: usize>(a: &mut [SVector<f64, D>], w: &[f64]) {
    for k in 0..a.len() {
        let mut v = a[k];
        let mut binomial = 1.0;
        for i in 1..=k {
            binomial = binomial * (k + 1 - i) as f64 / i as f64;
            v -= a[k - i] * (binomial * w[i]);
        }
        a[k] = v / w[0];
    }
}

/// One coordinate of the jet of `a / w`; `a` and `w` hold value, `u`, `v`, `uu`, `uv`, `vv`, and `inverse`
/// is `1 / w[0]` ([PT97, eq. (4.20)]).
#[inline(always)]
pub(crate) fn surface_quotient<L: Lanes>(l: L, a: &[L::V; 6], w: &[L::V; 6], inverse: L::V) -> [L::V; 6] {
    let point = l.mul(a[0], inverse);
    let du = l.mul(l.sub(a[1], l.mul(point, w[1])), inverse);
    let dv = l.mul(l.sub(a[2], l.mul(point, w[2])), inverse);
    let duu = l.sub(l.sub(a[3], l.mul(l.add(du, du), w[1])), l.mul(point, w[3]));
    let duv = l.sub(l.sub(a[4], l.add(l.mul(du, w[2]), l.mul(dv, w[1]))), l.mul(point, w[4]));
    let dvv = l.sub(l.sub(a[5], l.mul(l.add(dv, dv), w[2])), l.mul(point, w[5]));
    [point, du, dv, l.mul(duu, inverse), l.mul(duv, inverse), l.mul(dvv, inverse)]
}

/// Mixed derivatives of `a / w` for all orders `k + l ≤ order`, in place; index `[k][l]` ([PT97, A4.4]).
pub(crate) fn surface_derivatives(a: &mut [Vec<Vector3<f64>>], w: &[Vec<f64>]) {
    let order = a.len() - 1;
    for k in 0..=order {
        for l in 0..=order - k {
            let mut v = a[k][l];
            let mut bk = 1.0;
            for i in 0..=k {
                if i > 0 {
                    bk = bk * (k + 1 - i) as f64 / i as f64;
                }
                let mut bl = 1.0;
                for j in 0..=l {
                    if j > 0 {
                        bl = bl * (l + 1 - j) as f64 / j as f64;
                    }
                    if i + j > 0 {
                        v -= a[k - i][l - j] * (bk * bl * w[i][j]);
                    }
                }
            }
            a[k][l] = v / w[0][0];
        }
    }
}
