//! Tori.

use super::frame::positive;
use super::revolved::{self, check_angles, circle_meridian, is_full_turn, nearest_angle};
use super::{Frame, SurfaceFoot};
use crate::{BsplineSurface, Error, Interval, ParametricSurface, SurfaceJet};
use nalgebra::Vector3;
use std::f64::consts::TAU;

/// A torus or a piece of it.
///
/// `s(u, v) = m + (R + r cos v)(cos u · x + sin u · y) + r sin v · z`: `u` around the axis, `v` around the
/// tube, `v = 0` outside; the normal points outwards. `R > r`, so that the tube does not meet itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Torus {
    frame: Frame,
    major_radius: f64,
    minor_radius: f64,
    u: Interval,
    v: Interval,
}

impl Torus {
    /// The whole torus around the `z` axis of a frame.
    ///
    /// # Errors
    /// [`Error::Argument`] unless `0 < minor_radius < major_radius`.
    pub fn new(frame: Frame, major_radius: f64, minor_radius: f64) -> Result<Self, Error> {
        positive("major radius of the torus", major_radius)?;
        positive("minor radius of the torus", minor_radius)?;
        if minor_radius >= major_radius {
            return Err(Error::argument(format!(
                "the torus meets itself: its minor radius {minor_radius} is not below the major radius {major_radius}"
            )));
        }
        let turn = Interval::from_ordered(0.0, TAU);
        Ok(Self { frame, major_radius, minor_radius, u: turn, v: turn })
    }

    /// The piece over the given angles.
    ///
    /// # Errors
    /// [`Error::Argument`] when an interval is more than one turn.
    pub fn with_domain(self, u: Interval, v: Interval) -> Result<Self, Error> {
        check_angles("angle u", u)?;
        check_angles("angle v", v)?;
        Ok(Self { u, v, ..self })
    }

    /// Position; the origin is the centre, `z` the axis.
    #[must_use]
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Radius of the circle that is the middle of the tube.
    #[must_use]
    pub fn major_radius(&self) -> f64 {
        self.major_radius
    }

    /// Radius of the tube.
    #[must_use]
    pub fn minor_radius(&self) -> f64 {
        self.minor_radius
    }

    /// The closest point of the torus or of its piece.
    ///
    /// On the axis all `u`, on the middle circle of the tube all `v` are equally near: there the answer
    /// is at the start of the domain in that parameter.
    #[must_use]
    pub fn footpoint(&self, x: &Vector3<f64>) -> SurfaceFoot {
        let local = self.frame.local(x);
        let (u, radial) = nearest_angle(self.u, local.x, local.y);
        let (v, _) = nearest_angle(self.v, radial - self.major_radius, local.z);
        let point = self.point(u, v);
        SurfaceFoot { parameters: [u, v], point, distance: (x - point).norm() }
    }

    /// The exact rational B-spline surface of degree 2 × 2.
    ///
    /// # Errors
    /// None for a torus that could be made, unless its coordinates overflow.
    pub fn to_nurbs(&self) -> Result<BsplineSurface, Error> {
        let (knots_v, meridian) = circle_meridian(self.major_radius, self.minor_radius, self.v)?;
        revolved::to_nurbs(&self.frame, self.u, knots_v, &meridian)
    }
}

impl ParametricSurface for Torus {
    fn domain(&self) -> [Interval; 2] {
        [self.u, self.v]
    }

    fn period(&self) -> [Option<f64>; 2] {
        [self.u, self.v].map(|angles| is_full_turn(angles).then(|| angles.length()))
    }

    fn jet(&self, u: f64, v: f64) -> SurfaceJet {
        revolved::jet(&self.frame, u, &revolved::circle_jet(self.major_radius, self.minor_radius, v))
    }
}
