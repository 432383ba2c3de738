//! The result of a projection.

use crate::{Location, Multiplicity, Status};
use nalgebra::{SVector, Vector3};
use std::fmt;

/// The footpoint of a point on a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveFootpoint<const D: usize> {
    /// Index of the curve in the model (0 for a single curve).
    pub shape: usize,
    /// Parameter `t`, inside the domain.
    pub parameter: f64,
    /// The point `c(t)`.
    pub point: SVector<f64, D>,
    /// Distance of the query from `point`.
    pub distance: f64,
    /// How the computation ended.
    pub status: Status,
    /// Where on the curve the footpoint lies.
    pub location: Location,
    /// Whether other points are as near.
    pub multiplicity: Multiplicity,
    /// No point of the curve is nearer than this (0 when nothing was certified).
    pub lower_bound: f64,
    /// Steps of the local iterations.
    pub iterations: u32,
}

/// The footpoint of a point on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceFootpoint {
    /// Index of the surface in the model (0 for a single surface).
    pub shape: usize,
    /// Parameters `(u, v)`, inside the domain.
    pub parameter: [f64; 2],
    /// The point `s(u, v)`.
    pub point: Vector3<f64>,
    /// Distance of the query from `point`, never negative.
    pub distance: f64,
    /// The distance with a sign: positive on the side to which `s_u × s_v` points.
    pub signed_distance: f64,
    /// How the computation ended.
    pub status: Status,
    /// Where on the surface the footpoint lies.
    pub location: Location,
    /// Whether other points are as near.
    pub multiplicity: Multiplicity,
    /// No point of the surface is nearer than this (0 when nothing was certified).
    pub lower_bound: f64,
    /// Steps of the local iterations.
    pub iterations: u32,
}

impl<const D: usize> CurveFootpoint<D> {
    /// `distance − lower_bound`: how much nearer another point could be at most.
    #[must_use]
    pub fn gap(&self) -> f64 {
        self.distance - self.lower_bound
    }
}

impl SurfaceFootpoint {
    /// `distance − lower_bound`: how much nearer another point could be at most.
    #[must_use]
    pub fn gap(&self) -> f64 {
        self.distance - self.lower_bound
    }
}

impl<const D: usize> fmt::Display for CurveFootpoint<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "t = {}, distance = {}, {} in {} steps",
            self.parameter, self.distance, self.status, self.iterations
        )
    }
}

impl fmt::Display for SurfaceFootpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [u, v] = self.parameter;
        write!(
            f,
            "u = {u}, v = {v}, distance = {}, {} in {} steps",
            self.distance, self.status, self.iterations
        )
    }
}
