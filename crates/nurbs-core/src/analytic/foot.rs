//! Closest points on analytic shapes.

use nalgebra::{SVector, Vector3};

/// The point of an analytic curve that is closest to a given point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveFoot<const D: usize> {
    /// Its parameter, inside the domain.
    pub parameter: f64,
    /// The point.
    pub point: SVector<f64, D>,
    /// Its distance from the given point.
    pub distance: f64,
}

/// The point of an analytic surface that is closest to a given point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceFoot {
    /// Its parameters `(u, v)`, inside the domain.
    pub parameters: [f64; 2],
    /// The point.
    pub point: Vector3<f64>,
    /// Its distance from the given point.
    pub distance: f64,
}
