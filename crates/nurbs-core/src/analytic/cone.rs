//! Cones.

use super::frame::{finite, positive};
use super::revolved::{self, check_angles, is_full_turn, nearest_angle};
use super::{Frame, SurfaceFoot};
use crate::{BsplineSurface, CurveJet, Error, Interval, KnotVector, ParametricSurface, SurfaceJet};
use nalgebra::{Vector2, Vector3};
use std::f64::consts::TAU;

/// A circular cone between two parallel circles, one of which may be the apex.
///
/// `s(u, v) = m + r(v) (cos u · x + sin u · y) + v z`: angle `u`, height `v` along the axis,
/// `r(v)` linear from the radius at `v = 0` to the one at the full height; the normal points outwards.
/// An apex is a singular point of the parameterisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    frame: Frame,
    radii: [f64; 2],
    height: f64,
    u: Interval,
}

impl Cone {
    /// The cone around the `z` axis of a frame with radius `base` at the origin and `top` at `height`.
    ///
    /// # Errors
    /// [`Error::Argument`] when the height is not positive, a radius is negative or both are zero.
    pub fn new(frame: Frame, base: f64, top: f64, height: f64) -> Result<Self, Error> {
        positive("height of the cone", height)?;
        finite("radii of the cone", &[base, top])?;
        if base < 0.0 || top < 0.0 || base + top == 0.0 {
            return Err(Error::argument(format!(
                "a cone with radii {base} and {top} does not exist; both must be at least 0, one above 0"
            )));
        }
        Ok(Self { frame, radii: [base, top], height, u: Interval::from_ordered(0.0, TAU) })
    }

    /// The piece over the given angles.
    ///
    /// # Errors
    /// [`Error::Argument`] when the angles are more than one turn.
    pub fn with_angles(self, u: Interval) -> Result<Self, Error> {
        check_angles("angle u", u)?;
        Ok(Self { u, ..self })
    }

    /// Position; the origin is the centre of the base, `z` the axis.
    #[must_use]
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Radii at the base (`v = 0`) and at the top (`v` = height).
    #[must_use]
    pub fn radii(&self) -> [f64; 2] {
        self.radii
    }

    /// Height.
    #[must_use]
    pub fn height(&self) -> f64 {
        self.height
    }

    /// Angle between the axis and the generators, in radians; negative when the cone narrows upwards.
    #[must_use]
    pub fn half_angle(&self) -> f64 {
        (self.radii[1] - self.radii[0]).atan2(self.height)
    }

    /// The closest point of the cone or of its piece.
    ///
    /// On the axis all angles `u` are equally near: the answer is at the start of the domain.
    #[must_use]
    pub fn footpoint(&self, x: &Vector3<f64>) -> SurfaceFoot {
        let local = self.frame.local(x);
        let (u, radial) = nearest_angle(self.u, local.x, local.y);
        let (slope, height) = (self.radii[1] - self.radii[0], self.height);
        // The foot on the generator, as a fraction of the way; scaled by the height against overflow.
        let ratio = slope / height;
        let s = ((radial - self.radii[0]) * ratio + local.z) / (height * (ratio * ratio + 1.0));
        let v = self.domain()[1].clamp(height * s);
        let point = self.point(u, v);
        SurfaceFoot { parameters: [u, v], point, distance: (x - point).norm() }
    }

    /// The exact rational B-spline surface of degree 2 × 1; an apex becomes a column of equal points.
    ///
    /// # Errors
    /// None for a cone that could be made, unless its coordinates overflow.
    pub fn to_nurbs(&self) -> Result<BsplineSurface, Error> {
        let knots_v = KnotVector::bezier(1, self.domain()[1])?;
        let meridian = [[self.radii[0], 0.0, 1.0], [self.radii[1], self.height, 1.0]];
        revolved::to_nurbs(&self.frame, self.u, knots_v, &meridian)
    }
}

impl ParametricSurface for Cone {
    fn domain(&self) -> [Interval; 2] {
        [self.u, Interval::from_ordered(0.0, self.height)]
    }

    fn period(&self) -> [Option<f64>; 2] {
        [is_full_turn(self.u).then(|| self.u.length()), None]
    }

    fn jet(&self, u: f64, v: f64) -> SurfaceJet {
        let s = v / self.height;
        // Weighted mean: both radii are met exactly.
        let radius = (1.0 - s) * self.radii[0] + s * self.radii[1];
        let slope = (self.radii[1] - self.radii[0]) / self.height;
        let meridian =
            CurveJet { point: Vector2::new(radius, v), d1: Vector2::new(slope, 1.0), d2: Vector2::zeros() };
        revolved::jet(&self.frame, u, &meridian)
    }
}
