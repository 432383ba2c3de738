//! Spheres.

use super::frame::positive;
use super::revolved::{self, check_angles, circle_meridian, is_full_turn, nearest_angle};
use super::{Frame, SurfaceFoot};
use crate::{BsplineSurface, Error, Interval, ParametricSurface, SurfaceJet};
use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_2, TAU};

/// A sphere or a piece of it between meridians and parallels.
///
/// `s(u, v) = m + r cos v (cos u · x + sin u · y) + r sin v · z`: longitude `u`, latitude `v`; the normal
/// points outwards. The poles `v = ±π/2` are singular points of the parameterisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    frame: Frame,
    radius: f64,
    u: Interval,
    v: Interval,
}

impl Sphere {
    /// The whole sphere around the origin of a frame.
    ///
    /// # Errors
    /// [`Error::Argument`] when the radius is not positive.
    pub fn new(frame: Frame, radius: f64) -> Result<Self, Error> {
        positive("radius of the sphere", radius)?;
        let u = Interval::from_ordered(0.0, TAU);
        let v = Interval::from_ordered(-FRAC_PI_2, FRAC_PI_2);
        Ok(Self { frame, radius, u, v })
    }

    /// The piece over the given longitudes and latitudes.
    ///
    /// # Errors
    /// [`Error::Argument`] when `u` is more than one turn or `v` leaves `[−π/2, π/2]`.
    pub fn with_domain(self, u: Interval, v: Interval) -> Result<Self, Error> {
        check_angles("longitude", u)?;
        if v.start() < -FRAC_PI_2 || v.end() > FRAC_PI_2 {
            let what = format!("the latitude [{}, {}] leaves [-π/2, π/2]", v.start(), v.end());
            return Err(Error::argument(what));
        }
        Ok(Self { u, v, ..self })
    }

    /// Position; the origin is the centre.
    #[must_use]
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Radius.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The closest point of the sphere or of its piece.
    ///
    /// The centre is equally far from all points: there, and in `u` on the axis, the answer is the
    /// start of the domain.
    #[must_use]
    pub fn footpoint(&self, x: &Vector3<f64>) -> SurfaceFoot {
        let local = self.frame.local(x);
        let (u, radial) = nearest_angle(self.u, local.x, local.y);
        let (v, _) = nearest_angle(self.v, radial, local.z);
        let point = self.point(u, v);
        SurfaceFoot { parameters: [u, v], point, distance: (x - point).norm() }
    }

    /// The exact rational B-spline surface of degree 2 × 2; poles become rows of equal points.
    ///
    /// # Errors
    /// None for a sphere that could be made, unless its coordinates overflow.
    pub fn to_nurbs(&self) -> Result<BsplineSurface, Error> {
        let (knots_v, meridian) = circle_meridian(0.0, self.radius, self.v)?;
        revolved::to_nurbs(&self.frame, self.u, knots_v, &meridian)
    }
}

impl ParametricSurface for Sphere {
    fn domain(&self) -> [Interval; 2] {
        [self.u, self.v]
    }

    fn period(&self) -> [Option<f64>; 2] {
        [is_full_turn(self.u).then(|| self.u.length()), None]
    }

    fn jet(&self, u: f64, v: f64) -> SurfaceJet {
        revolved::jet(&self.frame, u, &revolved::circle_jet(0.0, self.radius, v))
    }
}
