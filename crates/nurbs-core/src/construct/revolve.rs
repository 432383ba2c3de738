//! Surfaces of revolution.

use crate::analytic::{arc_net, check_angles};
use crate::{BsplineCurve, BsplineSurface, Error, Frame, Interval};
use nalgebra::Vector3;

/// Part of the size of the curve within which a control point counts as lying on the axis.
const ON_AXIS: f64 = 1e-14;

/// The surface swept by a curve that turns about the axis through `origin` along `axis`, by `angle`
/// radians (up to a whole turn, right-handed): `u` is the angle, `v` runs along the curve
/// ([PT97, sec. 8.5]).
///
/// Control points on the axis, up to rounding (1e-14 of the size of the curve), give poles.
/// In between the knots, which are multiples of at most a quarter turn, `u` is not quite the angle.
///
/// # Errors
/// [`Error::Argument`] when the axis is zero or the angle not in `(0, 2π]`.
pub fn revolve(
    curve: &BsplineCurve<3>,
    origin: &Vector3<f64>,
    axis: &Vector3<f64>,
    angle: f64,
) -> Result<BsplineSurface, Error> {
    let frame = Frame::from_axis(*origin, *axis)?;
    let angles = Interval::new(0.0, angle)
        .map_err(|_| Error::argument(format!("the angle of revolution is {angle}; it must be in (0, 2π]")))?;
    check_angles("angle of revolution", angles)?;
    let (knots_u, ring) = arc_net(angles)?;
    let size = curve.control_points().iter().map(|p| (p - origin).norm()).fold(0.0, f64::max);
    let mut points = Vec::with_capacity(ring.len() * curve.control_points().len());
    let mut weights = Vec::with_capacity(points.capacity());
    for a in &ring {
        for (i, point) in curve.control_points().iter().enumerate() {
            let foot = origin + frame.z() * (point - origin).dot(&frame.z());
            let outwards = point - foot;
            points.push(if outwards.norm() <= ON_AXIS * size {
                foot
            } else if a.x == 1.0 && a.y == 0.0 {
                // The curve itself comes back exactly.
                *point
            } else {
                foot + outwards * a.x + frame.z().cross(&outwards) * a.y
            });
            weights.push(a.weight * curve.weight(i));
        }
    }
    BsplineSurface::new(knots_u, curve.knots().clone(), points, Some(weights))
}
