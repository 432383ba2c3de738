//! Circles and circular arcs.

use super::arc::{arc_net, cos_sin};
use super::frame::{finite, positive};
use super::revolved::{check_angles, is_full_turn, nearest_angle};
use super::{CurveFoot, Frame};
use crate::{BsplineCurve, CurveJet, Error, Interval, ParametricCurve};
use nalgebra::{SVector, Vector2};
use std::f64::consts::TAU;

/// A circle or circular arc `c(t) = m + r (cos t · x + sin t · y)` with the angle `t` as parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle<const D: usize> {
    centre: SVector<f64, D>,
    axes: [SVector<f64, D>; 2],
    radius: f64,
    arc: Interval,
}

impl Circle<2> {
    /// The whole circle in the plane, counter-clockwise from the direction of the first coordinate axis.
    ///
    /// # Errors
    /// [`Error::Argument`] when the centre is not finite or the radius is not positive.
    pub fn new(centre: Vector2<f64>, radius: f64) -> Result<Self, Error> {
        Self::with_axes(centre, [Vector2::x(), Vector2::y()], radius)
    }
}

impl Circle<3> {
    /// The whole circle around the `z` axis of a frame.
    ///
    /// # Errors
    /// [`Error::Argument`] when the radius is not positive.
    pub fn in_frame(frame: &Frame, radius: f64) -> Result<Self, Error> {
        Self::with_axes(frame.origin(), [frame.x(), frame.y()], radius)
    }
}

impl<const D: usize> Circle<D> {
    /// The whole circle in the plane of two orthonormal vectors, from the first towards the second.
    ///
    /// # Errors
    /// [`Error::Argument`] when the centre is not finite, the vectors are not orthonormal within 1e-9,
    /// or the radius is not positive.
    pub fn with_axes(
        centre: SVector<f64, D>,
        axes: [SVector<f64, D>; 2],
        radius: f64,
    ) -> Result<Self, Error> {
        finite("centre of the circle", centre.as_slice())?;
        positive("radius of the circle", radius)?;
        check_axes(&axes)?;
        Ok(Self { centre, axes, radius, arc: Interval::from_ordered(0.0, TAU) })
    }

    /// The arc over the given angles.
    ///
    /// # Errors
    /// [`Error::Argument`] when the angles span more than one turn.
    pub fn with_arc(self, arc: Interval) -> Result<Self, Error> {
        check_angles("arc", arc)?;
        Ok(Self { arc, ..self })
    }

    /// Centre.
    #[must_use]
    pub fn centre(&self) -> SVector<f64, D> {
        self.centre
    }

    /// Unit vectors towards the angles 0 and π/2.
    #[must_use]
    pub fn axes(&self) -> [SVector<f64, D>; 2] {
        self.axes
    }

    /// Radius.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The closest point of the circle or arc.
    ///
    /// Points on the axis are equally far from all points of the circle: there the answer is the start
    /// of the arc.
    #[must_use]
    pub fn footpoint(&self, x: &SVector<f64, D>) -> CurveFoot<D> {
        let d = x - self.centre;
        let (parameter, _) = nearest_angle(self.arc, d.dot(&self.axes[0]), d.dot(&self.axes[1]));
        let point = self.point(parameter);
        CurveFoot { parameter, point, distance: (x - point).norm() }
    }

    /// The exact rational quadratic B-spline: one piece for each quarter turn begun, knots at angles.
    ///
    /// # Errors
    /// None for a circle that could be made, unless its coordinates overflow.
    pub fn to_nurbs(&self) -> Result<BsplineCurve<D>, Error> {
        let (knots, net) = arc_net(self.arc)?;
        let place = |x: f64, y: f64| self.centre + (self.axes[0] * x + self.axes[1] * y) * self.radius;
        let points = net.iter().map(|p| place(p.x, p.y)).collect();
        BsplineCurve::new(knots, points, Some(net.iter().map(|p| p.weight).collect()))
    }
}

/// An error unless the two vectors are orthonormal within 1e-9.
pub(super) fn check_axes<const D: usize>(axes: &[SVector<f64, D>; 2]) -> Result<(), Error> {
    let [x, y] = axes;
    let off = (x.norm() - 1.0).abs().max((y.norm() - 1.0).abs()).max(x.dot(y).abs());
    if off <= 1e-9 {
        Ok(())
    } else {
        Err(Error::argument(format!("the axes {x:?} and {y:?} are not orthonormal (off by {off})")))
    }
}

impl<const D: usize> ParametricCurve<D> for Circle<D> {
    fn domain(&self) -> Interval {
        self.arc
    }

    fn period(&self) -> Option<f64> {
        is_full_turn(self.arc).then(|| self.arc.length())
    }

    fn jet(&self, t: f64) -> CurveJet<D> {
        let (c, s) = cos_sin(t);
        let outwards = (self.axes[0] * c + self.axes[1] * s) * self.radius;
        let forwards = (self.axes[1] * c - self.axes[0] * s) * self.radius;
        CurveJet { point: self.centre + outwards, d1: forwards, d2: -outwards }
    }
}
