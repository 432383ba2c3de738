//! From homogeneous derivatives to those of the rational shape: the quotient rule.

use crate::{CurveJet, SurfaceJet};
use nalgebra::{SVector, Vector3};

/// Jet of `a / w` from the derivatives of `a` and `w` ([PT97, eq. (4.8)]).
#[inline]
pub(crate) fn curve_jet<const D: usize>(a: &[SVector<f64, D>; 3], w: &[f64; 3]) -> CurveJet<D> {
    let inverse = 1.0 / w[0];
    let point = a[0] * inverse;
    let d1 = (a[1] - point * w[1]) * inverse;
    let d2 = (a[2] - d1 * (2.0 * w[1]) - point * w[2]) * inverse;
    CurveJet { point, d1, d2 }
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

/// Jet of `a / w`; `a` and `w` hold value, `u`, `v`, `uu`, `uv`, `vv` ([PT97, eq. (4.20)]).
#[inline]
pub(crate) fn surface_jet(a: &[Vector3<f64>; 6], w: &[f64; 6]) -> SurfaceJet {
    let inverse = 1.0 / w[0];
    let point = a[0] * inverse;
    let du = (a[1] - point * w[1]) * inverse;
    let dv = (a[2] - point * w[2]) * inverse;
    SurfaceJet {
        point,
        du,
        dv,
        duu: (a[3] - du * (2.0 * w[1]) - point * w[3]) * inverse,
        duv: (a[4] - du * w[2] - dv * w[1] - point * w[4]) * inverse,
        dvv: (a[5] - dv * (2.0 * w[2]) - point * w[5]) * inverse,
    }
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
