//! Cylinders.

use super::frame::positive;
use super::revolved::{self, check_angles, is_full_turn, nearest_angle};
use super::{Frame, SurfaceFoot};
use crate::{BsplineSurface, CurveJet, Error, Interval, KnotVector, ParametricSurface, SurfaceJet};
use nalgebra::{Vector2, Vector3};
use std::f64::consts::TAU;

/// A circular cylinder between two parallel planes.
///
/// `s(u, v) = m + r (cos u · x + sin u · y) + v z`: angle `u`, height `v`; the normal points outwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    frame: Frame,
    radius: f64,
    u: Interval,
    v: Interval,
}

impl Cylinder {
    /// The cylinder around the `z` axis of a frame over an interval of heights.
    ///
    /// # Errors
    /// [`Error::Argument`] when the radius is not positive.
    pub fn new(frame: Frame, radius: f64, heights: Interval) -> Result<Self, Error> {
        positive("radius of the cylinder", radius)?;
        Ok(Self { frame, radius, u: Interval::from_ordered(0.0, TAU), v: heights })
    }

    /// The piece over the given angles.
    ///
    /// # Errors
    /// [`Error::Argument`] when the angles are more than one turn.
    pub fn with_angles(self, u: Interval) -> Result<Self, Error> {
        check_angles("angle u", u)?;
        Ok(Self { u, ..self })
    }

    /// Position; `z` is the axis.
    #[must_use]
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Radius.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The closest point of the cylinder or of its piece.
    ///
    /// On the axis all angles `u` are equally near: the answer is at the start of the domain.
    #[must_use]
    pub fn footpoint(&self, x: &Vector3<f64>) -> SurfaceFoot {
        let local = self.frame.local(x);
        let (u, _) = nearest_angle(self.u, local.x, local.y);
        let v = self.v.clamp(local.z);
        let point = self.point(u, v);
        SurfaceFoot { parameters: [u, v], point, distance: (x - point).norm() }
    }

    /// The exact rational B-spline surface of degree 2 × 1.
    ///
    /// # Errors
    /// None for a cylinder that could be made, unless its coordinates overflow.
    pub fn to_nurbs(&self) -> Result<BsplineSurface, Error> {
        let knots_v = KnotVector::bezier(1, self.v)?;
        let meridian = [[self.radius, self.v.start(), 1.0], [self.radius, self.v.end(), 1.0]];
        revolved::to_nurbs(&self.frame, self.u, knots_v, &meridian)
    }
}

impl ParametricSurface for Cylinder {
    fn domain(&self) -> [Interval; 2] {
        [self.u, self.v]
    }

    fn period(&self) -> [Option<f64>; 2] {
        [is_full_turn(self.u).then(|| self.u.length()), None]
    }

    fn jet(&self, u: f64, v: f64) -> SurfaceJet {
        let meridian =
            CurveJet { point: Vector2::new(self.radius, v), d1: Vector2::y(), d2: Vector2::zeros() };
        revolved::jet(&self.frame, u, &meridian)
    }
}
