//! Offsets of plane curves.

use super::breaks_of_offset;
use crate::{Break, BsplineCurve, CurveJet, Interval, ParametricCurve};
use nalgebra::{SVector, Vector2};

/// A curve that also knows its third derivative.
pub trait ThirdOrderCurve<const D: usize>: ParametricCurve<D> {
    /// `c'''(t)`.
    fn third_derivative(&self, t: f64) -> SVector<f64, D>;
}

impl<const D: usize, C: ThirdOrderCurve<D> + ?Sized> ThirdOrderCurve<D> for &C {
    fn third_derivative(&self, t: f64) -> SVector<f64, D> {
        (**self).third_derivative(t)
    }
}

impl<const D: usize> ThirdOrderCurve<D> for BsplineCurve<D> {
    fn third_derivative(&self, t: f64) -> SVector<f64, D> {
        self.derivatives(t, 3)[3]
    }
}

/// The offset `o(t) = c(t) + d n(t)` of a plane curve, where `n` is the unit tangent turned left by a
/// right angle.
///
/// With the signed curvature `κ` of `c`: `o' = (1 − dκ) c'` and `o'' = (1 − dκ) c'' − d κ' c'`.
/// Jets are NaN where `c' = 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OffsetCurve<C> {
    base: C,
    distance: f64,
}

impl<C: ThirdOrderCurve<2>> OffsetCurve<C> {
    /// The offset of `base` to the left by `distance` (to the right when negative).
    pub fn new(base: C, distance: f64) -> Self {
        Self { base, distance }
    }

    /// The curve that is offset.
    pub fn base(&self) -> &C {
        &self.base
    }

    /// Signed distance.
    pub fn distance(&self) -> f64 {
        self.distance
    }

    /// The jet, or `None` where the base has no normal.
    pub fn try_jet(&self, t: f64) -> Option<CurveJet<2>> {
        let base = self.base.jet(t);
        let tangent = base.unit_tangent()?;
        let curvature = base.signed_curvature()?;
        let speed = base.speed();
        let d3 = self.base.third_derivative(t);
        let change = (tangent.x * d3.y - tangent.y * d3.x) / speed / speed
            - 3.0 * curvature * tangent.dot(&base.d2) / speed;
        let factor = 1.0 - self.distance * curvature;
        Some(CurveJet {
            point: base.point + Vector2::new(-tangent.y, tangent.x) * self.distance,
            d1: base.d1 * factor,
            d2: base.d2 * factor - base.d1 * (self.distance * change),
        })
    }
}

impl<C: ThirdOrderCurve<2>> ParametricCurve<2> for OffsetCurve<C> {
    fn domain(&self) -> Interval {
        self.base.domain()
    }

    fn period(&self) -> Option<f64> {
        self.base.period()
    }

    fn breaks(&self) -> Vec<f64> {
        self.base.breaks()
    }

    fn derivative_breaks(&self) -> Vec<Break> {
        breaks_of_offset(self.base.breaks(), self.base.derivative_breaks())
    }

    fn jet(&self, t: f64) -> CurveJet<2> {
        let nan = Vector2::repeat(f64::NAN);
        self.try_jet(t).unwrap_or(CurveJet { point: nan, d1: nan, d2: nan })
    }
}
