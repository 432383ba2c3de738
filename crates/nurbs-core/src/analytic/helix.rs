//! Circular helices.

use super::Frame;
use super::frame::{finite, positive};
use crate::{CurveJet, Error, Interval, ParametricCurve, ThirdOrderCurve};
use nalgebra::Vector3;
use std::f64::consts::TAU;

/// The helix `c(t) = m + r (cos t · x + sin t · y) + (h t / 2π) z` in a frame, by the angle `t`.
///
/// No B-spline is a helix; this one is exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Helix {
    frame: Frame,
    radius: f64,
    pitch: f64,
    angles: Interval,
}

impl Helix {
    /// The helix around the `z` axis of a frame that climbs by `pitch` in each turn; `turns` of it.
    /// A negative pitch gives a left-handed helix.
    ///
    /// # Errors
    /// [`Error::Argument`] when radius or turns are not positive or the pitch is not finite.
    pub fn new(frame: Frame, radius: f64, pitch: f64, turns: f64) -> Result<Self, Error> {
        positive("radius of the helix", radius)?;
        positive("number of turns of the helix", turns)?;
        finite("pitch of the helix", &[pitch])?;
        Ok(Self { frame, radius, pitch, angles: Interval::new(0.0, TAU * turns)? })
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

    /// Height gained in a turn.
    #[must_use]
    pub fn pitch(&self) -> f64 {
        self.pitch
    }

    /// Height gained in one radian.
    fn rise(&self) -> f64 {
        self.pitch / TAU
    }

    /// Length.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.radius.hypot(self.rise()) * self.angles.length()
    }

    /// Curvature, `r / (r² + (h/2π)²)` everywhere.
    #[must_use]
    pub fn curvature(&self) -> f64 {
        self.radius / (self.radius * self.radius + self.rise() * self.rise())
    }

    /// Torsion, `(h/2π) / (r² + (h/2π)²)` everywhere.
    #[must_use]
    pub fn torsion(&self) -> f64 {
        self.rise() / (self.radius * self.radius + self.rise() * self.rise())
    }
}

impl ParametricCurve<3> for Helix {
    fn domain(&self) -> Interval {
        self.angles
    }

    fn jet(&self, t: f64) -> CurveJet<3> {
        let (s, c) = t.sin_cos();
        let place = |x: f64, y: f64, z: f64| self.frame.vector(&Vector3::new(x, y, z));
        let (x, y) = (self.radius * c, self.radius * s);
        CurveJet {
            point: self.frame.origin() + place(x, y, self.rise() * t),
            d1: place(-y, x, self.rise()),
            d2: place(-x, -y, 0.0),
        }
    }
}

impl ThirdOrderCurve<3> for Helix {
    fn third_derivative(&self, t: f64) -> Vector3<f64> {
        let (s, c) = t.sin_cos();
        self.frame.vector(&Vector3::new(self.radius * s, -self.radius * c, 0.0))
    }
}
