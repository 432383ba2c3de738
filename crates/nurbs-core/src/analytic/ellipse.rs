//! Ellipses.

use super::arc::{arc_net, cos_sin};
use super::circle::check_axes;
use super::frame::{finite, positive};
use super::{CurveFoot, Frame};
use crate::{BsplineCurve, CurveJet, Error, Interval, ParametricCurve};
use nalgebra::{SVector, Vector2};
use std::f64::consts::TAU;

/// An ellipse `c(t) = m + a cos t · x + b sin t · y`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipse<const D: usize> {
    centre: SVector<f64, D>,
    axes: [SVector<f64, D>; 2],
    semi_axes: [f64; 2],
}

impl Ellipse<2> {
    /// The ellipse with the given semi-axes along the coordinate axes.
    ///
    /// # Errors
    /// [`Error::Argument`] when the centre is not finite or a semi-axis is not positive.
    pub fn new(centre: Vector2<f64>, semi_axes: [f64; 2]) -> Result<Self, Error> {
        Self::with_axes(centre, [Vector2::x(), Vector2::y()], semi_axes)
    }
}

impl Ellipse<3> {
    /// The ellipse with the given semi-axes along the `x` and `y` axes of a frame.
    ///
    /// # Errors
    /// [`Error::Argument`] when a semi-axis is not positive.
    pub fn in_frame(frame: &Frame, semi_axes: [f64; 2]) -> Result<Self, Error> {
        Self::with_axes(frame.origin(), [frame.x(), frame.y()], semi_axes)
    }
}

impl<const D: usize> Ellipse<D> {
    /// The ellipse in the plane of two orthonormal vectors, along which its semi-axes lie.
    ///
    /// # Errors
    /// [`Error::Argument`] when the centre is not finite, the vectors are not orthonormal within 1e-9,
    /// or a semi-axis is not positive.
    pub fn with_axes(
        centre: SVector<f64, D>,
        axes: [SVector<f64, D>; 2],
        semi_axes: [f64; 2],
    ) -> Result<Self, Error> {
        finite("centre of the ellipse", centre.as_slice())?;
        semi_axes.iter().try_for_each(|&a| positive("semi-axis of the ellipse", a))?;
        check_axes(&axes)?;
        Ok(Self { centre, axes, semi_axes })
    }

    /// Centre.
    #[must_use]
    pub fn centre(&self) -> SVector<f64, D> {
        self.centre
    }

    /// Unit vectors along the semi-axes.
    #[must_use]
    pub fn axes(&self) -> [SVector<f64, D>; 2] {
        self.axes
    }

    /// Semi-axes `a` and `b`, lengths.
    #[must_use]
    pub fn semi_axes(&self) -> [f64; 2] {
        self.semi_axes
    }

    /// The closest point of the ellipse, to rounding.
    ///
    /// On the inner part of the longer axis two points are equally near: the one at the positive side of
    /// the shorter axis is given; at the centre of a circle the one at `t = 0`.
    #[must_use]
    pub fn footpoint(&self, x: &SVector<f64, D>) -> CurveFoot<D> {
        let d = x - self.centre;
        let (p, q) = (d.dot(&self.axes[0]), d.dot(&self.axes[1]));
        let [a, b] = self.semi_axes;
        // In the quadrant where both coordinates are positive, the longer semi-axis first.
        let (cosine, sine) = if a >= b {
            quadrant(a, b, p.abs(), q.abs())
        } else {
            let (s, c) = quadrant(b, a, q.abs(), p.abs());
            (c, s)
        };
        let sign = |value: f64| if value < 0.0 { -1.0 } else { 1.0 };
        let parameter = (sign(q) * sine).atan2(sign(p) * cosine).rem_euclid(TAU);
        // The remainder of a tiny negative angle rounds to the whole turn.
        let parameter = if parameter < TAU { parameter } else { 0.0 };
        let point = self.point(parameter);
        CurveFoot { parameter, point, distance: (x - point).norm() }
    }

    /// The exact rational quadratic B-spline of four pieces, knots at multiples of π/2.
    ///
    /// # Errors
    /// None for an ellipse that could be made, unless its coordinates overflow.
    pub fn to_nurbs(&self) -> Result<BsplineCurve<D>, Error> {
        let (knots, net) = arc_net(self.domain())?;
        let [a, b] = self.semi_axes;
        let place = |x: f64, y: f64| self.centre + self.axes[0] * (a * x) + self.axes[1] * (b * y);
        let points = net.iter().map(|p| place(p.x, p.y)).collect();
        BsplineCurve::new(knots, points, Some(net.iter().map(|p| p.weight).collect()))
    }
}

/// Cosine and sine of the parameter of the foot of `(p, q)`, `p, q ≥ 0`, for `a ≥ b`.
///
/// The foot is `(a² p / (λ + a²), b² q / (λ + b²))` with the largest root `λ > −b²` of
/// `(a p / (λ + a²))² + (b q / (λ + b²))² = 1`, a decreasing function, by bisection.
fn quadrant(a: f64, b: f64, p: f64, q: f64) -> (f64, f64) {
    // In units of b² with λ = (s − 1) b², so that the bracket starts at s = 0.
    let (ratio, y, z) = ((a / b) * (a / b), p / b * (a / b), q / b);
    if z == 0.0 {
        // On the longer axis: beyond the centre of curvature of the vertex the vertex itself is nearest.
        let cosine = y / (ratio - 1.0);
        // NaN (the centre of a circle) goes with the vertex too.
        let inner = cosine < 1.0;
        return if inner { (cosine, (1.0 - cosine * cosine).sqrt()) } else { (1.0, 0.0) };
    }
    let value = |s: f64| (y / (s + (ratio - 1.0))).hypot(z / s);
    let (mut low, mut high) = (z, y.hypot(z));
    let mut s = high;
    for _ in 0..1100 {
        s = 0.5 * (low + high);
        if s <= low || s >= high {
            break;
        }
        if value(s) > 1.0 {
            low = s;
        } else {
            high = s;
        }
    }
    (y / (s + (ratio - 1.0)), z / s)
}

impl<const D: usize> ParametricCurve<D> for Ellipse<D> {
    fn domain(&self) -> Interval {
        Interval::from_ordered(0.0, TAU)
    }

    fn period(&self) -> Option<f64> {
        Some(TAU)
    }

    fn jet(&self, t: f64) -> CurveJet<D> {
        let (c, s) = cos_sin(t);
        let [a, b] = self.semi_axes;
        let [x, y] = self.axes;
        let outwards = x * (a * c) + y * (b * s);
        CurveJet { point: self.centre + outwards, d1: y * (b * c) - x * (a * s), d2: -outwards }
    }
}
