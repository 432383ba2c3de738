//! Points together with their derivatives.

use nalgebra::{SVector, Vector3};

/// A curve point with its first and second derivative with respect to the parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveJet<const D: usize> {
    /// The point `c(t)`.
    pub point: SVector<f64, D>,
    /// `c'(t)`.
    pub d1: SVector<f64, D>,
    /// `c''(t)`.
    pub d2: SVector<f64, D>,
}

/// A surface point with all partial derivatives up to the second order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceJet {
    /// The point `s(u, v)`.
    pub point: Vector3<f64>,
    /// `∂s/∂u`.
    pub du: Vector3<f64>,
    /// `∂s/∂v`.
    pub dv: Vector3<f64>,
    /// `∂²s/∂u²`.
    pub duu: Vector3<f64>,
    /// `∂²s/∂u∂v`.
    pub duv: Vector3<f64>,
    /// `∂²s/∂v²`.
    pub dvv: Vector3<f64>,
}

impl SurfaceJet {
    /// `∂s/∂u × ∂s/∂v`, not normalized: zero where the surface is not regular.
    #[must_use]
    pub fn normal_direction(&self) -> Vector3<f64> {
        self.du.cross(&self.dv)
    }
}
