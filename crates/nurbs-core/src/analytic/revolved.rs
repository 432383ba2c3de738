//! What all surfaces of revolution have in common.
//!
//! A meridian `(r(v), z(v))` with `r ≥ 0` turns about the `z` axis of a frame. Whatever point of the
//! meridian is considered, its ring is nearest at the same angle `u`: that of the test point, or the
//! nearer end of the piece. So the closest point on the surface is found in one meridian plane.

use super::Frame;
use super::arc::{arc_net, cos_sin};
use crate::{BsplineSurface, CurveJet, Error, Interval, KnotVector, SurfaceJet};
use nalgebra::{Vector2, Vector3};
use std::f64::consts::TAU;

/// Angles are compared with this slack, in radians.
const ANGLE: f64 = 1e-12;

/// Whether the interval of angles is one whole turn.
pub(crate) fn is_full_turn(angles: Interval) -> bool {
    (angles.length() - TAU).abs() <= ANGLE
}

/// An error when the interval of angles exceeds one turn.
pub(crate) fn check_angles(name: &str, angles: Interval) -> Result<(), Error> {
    if angles.length() <= TAU + ANGLE {
        Ok(())
    } else {
        let (start, end) = (angles.start(), angles.end());
        Err(Error::argument(format!("the {name} [{start}, {end}] is more than one turn (2π, in radians)")))
    }
}

/// The angle of the interval nearest to the direction `(x, y)`, and the coordinate of `(x, y)` along it.
///
/// The start of the interval for `(0, 0)` and NaN.
pub(super) fn nearest_angle(angles: Interval, x: f64, y: f64) -> (f64, f64) {
    let radius = x.hypot(y);
    if radius == 0.0 || radius.is_nan() {
        return (angles.start(), radius);
    }
    let angle = angles.start() + (y.atan2(x) - angles.start()).rem_euclid(TAU);
    if angle <= angles.end() {
        return (angle, radius);
    }
    if is_full_turn(angles) {
        return (angles.end(), radius);
    }
    let after = angle - angles.end();
    let before = angles.start() + TAU - angle;
    let nearest = if before < after { angles.start() } else { angles.end() };
    let (c, s) = cos_sin(nearest);
    (nearest, x * c + y * s)
}

/// The jet of the surface at the angle `u` from the jet `(r, z)` of its meridian.
pub(super) fn jet(frame: &Frame, u: f64, meridian: &CurveJet<2>) -> SurfaceJet {
    let (c, s) = cos_sin(u);
    let outwards = frame.x() * c + frame.y() * s;
    let around = frame.y() * c - frame.x() * s;
    let z = frame.z();
    let CurveJet { point, d1, d2 } = meridian;
    SurfaceJet {
        point: frame.origin() + outwards * point.x + z * point.y,
        du: around * point.x,
        dv: outwards * d1.x + z * d1.y,
        duu: outwards * -point.x,
        duv: around * d1.x,
        dvv: outwards * d2.x + z * d2.y,
    }
}

/// The jet of the meridian that is the circle around `(centre, 0)`, by angle.
pub(super) fn circle_jet(centre: f64, radius: f64, v: f64) -> CurveJet<2> {
    let (c, s) = cos_sin(v);
    let outwards = Vector2::new(radius * c, radius * s);
    CurveJet {
        point: Vector2::new(centre + outwards.x, outwards.y),
        d1: Vector2::new(-outwards.y, outwards.x),
        d2: -outwards,
    }
}

/// A control point `(r, z)` of a meridian and its weight.
pub(super) type MeridianPoint = [f64; 3];

/// The rational B-spline surface of revolution over the angles `u`.
///
/// Rows of the net run in `u`; a meridian point on the axis gives a column of equal points.
pub(super) fn to_nurbs(
    frame: &Frame,
    u: Interval,
    knots_v: KnotVector,
    meridian: &[MeridianPoint],
) -> Result<BsplineSurface, Error> {
    let (knots_u, ring) = arc_net(u)?;
    let mut points = Vec::with_capacity(ring.len() * meridian.len());
    let mut weights = Vec::with_capacity(points.capacity());
    for a in &ring {
        for [r, z, weight] in meridian {
            points.push(frame.point(&Vector3::new(r * a.x, r * a.y, *z)));
            weights.push(a.weight * weight);
        }
    }
    BsplineSurface::new(knots_u, knots_v, points, Some(weights))
}

/// Knots and control points of the meridian that is an arc of the circle around `(centre, 0)`.
pub(super) fn circle_meridian(
    centre: f64,
    radius: f64,
    v: Interval,
) -> Result<(KnotVector, Vec<MeridianPoint>), Error> {
    let (knots, net) = arc_net(v)?;
    Ok((knots, net.iter().map(|p| [centre + radius * p.x, radius * p.y, p.weight]).collect()))
}
