//! Points and jets of patches: by powers for low degrees, in Bernstein form for the others.

use crate::global::arithmetic::bernstein::basis_jet;
use crate::global::arithmetic::homogeneous::Homogeneous;
use crate::global::arithmetic::power;
use crate::global::arithmetic::power::Quad;
use crate::global::arithmetic::simd::vectorized;
use crate::global::surface::geometry::{Geometry, Patch};
use nalgebra::Vector3;
use nurbs_core::{MAX_DEGREE, SurfaceJet};

impl Geometry {
    /// The jet at the local `(s, t)` with derivatives by local parameters; points relative to the centre.
    #[inline(always)]
    pub(crate) fn jet(&self, patch: &Patch, s: f64, t: f64) -> SurfaceJet {
        match (patch.order(), patch.rational) {
            (4, false) => self.power_jet::<4, 3>(patch, s, t),
            (4, true) => self.power_jet::<4, 4>(patch, s, t),
            (3, false) => self.power_jet::<3, 3>(patch, s, t),
            (3, true) => self.power_jet::<3, 4>(patch, s, t),
            _ => self.bernstein_jet(patch, s, t),
        }
    }

    #[inline(always)]
    fn power_jet<const N: usize, const C: usize>(&self, patch: &Patch, s: f64, t: f64) -> SurfaceJet {
        let [o, p] = patch.origin();
        power::surface_jet(&power::jet::<N, Quad<C>>(self.powers::<N, C>(patch), s - o, t - p))
    }

    /// Value, u, v, uu, uv, vv of `w (p − centre)` and `w`.
    pub(in crate::global) fn homogeneous_jet(&self, patch: &Patch, s: f64, t: f64) -> [Homogeneous; 6] {
        let [p, q] = patch.degrees();
        let net = self.net(patch);
        vectorized(
            #[inline(always)]
            || general_jet(net, p, q, s, t),
        )
    }

    fn bernstein_jet(&self, patch: &Patch, s: f64, t: f64) -> SurfaceJet {
        let a = self.homogeneous_jet(patch, s, t);
        let v = |k: usize| Vector3::new(a[k][0], a[k][1], a[k][2]);
        if !patch.rational {
            return SurfaceJet { point: v(0), du: v(1), dv: v(2), duu: v(3), duv: v(4), dvv: v(5) };
        }
        let w = |k: usize| a[k][3];
        let inverse = 1.0 / w(0);
        let point = v(0) * inverse;
        let du = (v(1) - point * w(1)) * inverse;
        let dv = (v(2) - point * w(2)) * inverse;
        SurfaceJet {
            point,
            du,
            dv,
            duu: (v(3) - du * (2.0 * w(1)) - point * w(3)) * inverse,
            duv: (v(4) - du * w(2) - dv * w(1) - point * w(4)) * inverse,
            dvv: (v(5) - dv * (2.0 * w(2)) - point * w(5)) * inverse,
        }
    }

    /// The point alone, relative to the centre.
    #[inline(always)]
    pub(crate) fn point(&self, patch: &Patch, s: f64, t: f64) -> Vector3<f64> {
        match (patch.order(), patch.rational) {
            (4, false) => self.power_point::<4, 3>(patch, s, t),
            (4, true) => self.power_point::<4, 4>(patch, s, t),
            (3, false) => self.power_point::<3, 3>(patch, s, t),
            (3, true) => self.power_point::<3, 4>(patch, s, t),
            _ => self.bernstein_point(patch, s, t),
        }
    }

    #[inline(always)]
    fn power_point<const N: usize, const C: usize>(&self, patch: &Patch, s: f64, t: f64) -> Vector3<f64> {
        let [o, p] = patch.origin();
        let a = power::value::<N, Quad<C>>(self.powers::<N, C>(patch), s - o, t - p).0;
        let point = Vector3::new(a[0], a[1], a[2]);
        // As in the jet, where the inverse is needed more than once.
        if C == 4 { point * (1.0 / a[3]) } else { point }
    }

    fn bernstein_point(&self, patch: &Patch, s: f64, t: f64) -> Vector3<f64> {
        let [p, q] = patch.degrees();
        let net = self.net(patch);
        let a = vectorized(
            #[inline(always)]
            || general_point(net, p, q, s, t),
        );
        let point = Vector3::new(a[0], a[1], a[2]);
        if patch.rational { point / a[3] } else { point }
    }
}

#[inline(always)]
fn axpy(to: &mut [f64; 4], from: &[f64; 4], factor: f64) {
    for c in 0..4 {
        to[c] += from[c] * factor;
    }
}

#[inline(always)]
fn accumulate(a: &mut [[f64; 4]; 6], r: &[[f64; 4]; 3], b: &[f64; 3]) {
    axpy(&mut a[0], &r[0], b[0]);
    axpy(&mut a[1], &r[0], b[1]);
    axpy(&mut a[2], &r[1], b[0]);
    axpy(&mut a[3], &r[0], b[2]);
    axpy(&mut a[4], &r[1], b[1]);
    axpy(&mut a[5], &r[2], b[0]);
}

/// The value of a net of any degrees.
#[inline(always)]
fn general_point(net: &[Homogeneous], p: usize, q: usize, s: f64, t: f64) -> [f64; 4] {
    let mut bu = [[0.0; 3]; MAX_DEGREE + 1];
    let mut bv = [[0.0; 3]; MAX_DEGREE + 1];
    basis_jet(p, s, &mut bu[..=p]);
    basis_jet(q, t, &mut bv[..=q]);
    let mut a = [0.0; 4];
    for i in 0..=p {
        let mut r = [0.0; 4];
        for j in 0..=q {
            axpy(&mut r, &net[i * (q + 1) + j], bv[j][0]);
        }
        axpy(&mut a, &r, bu[i][0]);
    }
    a
}

/// Value, u, v, uu, uv, vv of a net of any degrees.
#[inline(always)]
fn general_jet(net: &[Homogeneous], p: usize, q: usize, s: f64, t: f64) -> [[f64; 4]; 6] {
    let mut bu = [[0.0; 3]; MAX_DEGREE + 1];
    let mut bv = [[0.0; 3]; MAX_DEGREE + 1];
    basis_jet(p, s, &mut bu[..=p]);
    basis_jet(q, t, &mut bv[..=q]);
    let mut a = [[0.0; 4]; 6];
    for i in 0..=p {
        let mut r = [[0.0; 4]; 3];
        for j in 0..=q {
            for d in 0..3 {
                axpy(&mut r[d], &net[i * (q + 1) + j], bv[j][d]);
            }
        }
        accumulate(&mut a, &r, &bu[i]);
    }
    a
}
