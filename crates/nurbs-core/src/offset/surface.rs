//! Offsets of surfaces.

use super::breaks_of_offset;
use crate::{Break, BsplineSurface, Interval, ParametricSurface, SurfaceJet};
use nalgebra::Vector3;

/// Partial derivatives of the third order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceThird {
    /// `∂³s/∂u³`.
    pub duuu: Vector3<f64>,
    /// `∂³s/∂u²∂v`.
    pub duuv: Vector3<f64>,
    /// `∂³s/∂u∂v²`.
    pub duvv: Vector3<f64>,
    /// `∂³s/∂v³`.
    pub dvvv: Vector3<f64>,
}

/// A surface that also knows its third derivatives.
pub trait ThirdOrderSurface: ParametricSurface {
    /// All partial derivatives of the third order.
    fn third_derivatives(&self, u: f64, v: f64) -> SurfaceThird;
}

impl<S: ThirdOrderSurface + ?Sized> ThirdOrderSurface for &S {
    fn third_derivatives(&self, u: f64, v: f64) -> SurfaceThird {
        (**self).third_derivatives(u, v)
    }
}

impl ThirdOrderSurface for BsplineSurface {
    fn third_derivatives(&self, u: f64, v: f64) -> SurfaceThird {
        let d = self.derivatives(u, v, 3);
        SurfaceThird { duuu: d[3][0], duuv: d[2][1], duvv: d[1][2], dvvv: d[0][3] }
    }
}

/// The offset `o(u, v) = s(u, v) + d n(u, v)` of a surface along its unit normal
/// `n = s_u × s_v / |s_u × s_v|`. Jets are NaN where the base is not regular.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OffsetSurface<S> {
    base: S,
    distance: f64,
}

/// A vector field on the parameter plane with its first derivatives and the second ones `uu, uv, vv`.
struct Field {
    value: Vector3<f64>,
    first: [Vector3<f64>; 2],
    second: [Vector3<f64>; 3],
}

/// `s_u × s_v` by the product rule.
fn cross_field(s: &SurfaceJet, t: &SurfaceThird) -> Field {
    Field {
        value: s.du.cross(&s.dv),
        first: [s.duu.cross(&s.dv) + s.du.cross(&s.duv), s.duv.cross(&s.dv) + s.du.cross(&s.dvv)],
        second: [
            t.duuu.cross(&s.dv) + s.duu.cross(&s.duv) * 2.0 + s.du.cross(&t.duuv),
            t.duuv.cross(&s.dv) + s.duu.cross(&s.dvv) + s.du.cross(&t.duvv),
            t.duvv.cross(&s.dv) + s.duv.cross(&s.dvv) * 2.0 + s.du.cross(&t.dvvv),
        ],
    }
}

/// The unit vectors of a field `N`: from `N = ℓ n`, differentiated twice and solved for the derivatives of `n`.
fn normalized(field: &Field, n: Vector3<f64>) -> Field {
    let length = field.value.norm();
    let slope = field.first.map(|d| n.dot(&d));
    let first = [0, 1].map(|k: usize| (field.first[k] - n * slope[k]) / length);
    let second = [(0, 0), (0, 1), (1, 1)].map(|(a, b): (usize, usize)| {
        let d = field.second[a + b];
        let bend = n.dot(&d) + first[b].dot(&field.first[a]);
        (d - n * bend - first[b] * slope[a] - first[a] * slope[b]) / length
    });
    Field { value: n, first, second }
}

impl<S: ThirdOrderSurface> OffsetSurface<S> {
    /// The offset of `base` along its normal by the signed `distance`.
    pub fn new(base: S, distance: f64) -> Self {
        Self { base, distance }
    }

    /// The surface that is offset.
    pub fn base(&self) -> &S {
        &self.base
    }

    /// Signed distance.
    pub fn distance(&self) -> f64 {
        self.distance
    }

    /// The jet, or `None` where the base is not regular.
    pub fn try_jet(&self, u: f64, v: f64) -> Option<SurfaceJet> {
        let s = self.base.jet(u, v);
        let normal = s.unit_normal()?;
        let n = normalized(&cross_field(&s, &self.base.third_derivatives(u, v)), normal);
        let d = self.distance;
        Some(SurfaceJet {
            point: s.point + n.value * d,
            du: s.du + n.first[0] * d,
            dv: s.dv + n.first[1] * d,
            duu: s.duu + n.second[0] * d,
            duv: s.duv + n.second[1] * d,
            dvv: s.dvv + n.second[2] * d,
        })
    }
}

impl<S: ThirdOrderSurface> ParametricSurface for OffsetSurface<S> {
    fn domain(&self) -> [Interval; 2] {
        self.base.domain()
    }

    fn period(&self) -> [Option<f64>; 2] {
        self.base.period()
    }

    fn breaks(&self) -> [Vec<f64>; 2] {
        self.base.breaks()
    }

    fn derivative_breaks(&self) -> [Vec<Break>; 2] {
        let ([knots_u, knots_v], [base_u, base_v]) = (self.base.breaks(), self.base.derivative_breaks());
        [breaks_of_offset(knots_u, base_u), breaks_of_offset(knots_v, base_v)]
    }

    fn jet(&self, u: f64, v: f64) -> SurfaceJet {
        let nan = Vector3::repeat(f64::NAN);
        let jet = SurfaceJet { point: nan, du: nan, dv: nan, duu: nan, duv: nan, dvv: nan };
        self.try_jet(u, v).unwrap_or(jet)
    }
}
