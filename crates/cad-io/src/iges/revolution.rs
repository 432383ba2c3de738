//! Surfaces of revolution (type 120).

use super::chart::Chart;
use super::fault::Fault;
use super::file::{Cursor, File};
use super::ruled;
use super::surfaces::Bounds;
use brep_core::description::{Carrier, EdgeCurve};
use nalgebra::{Rotation3, Unit, Vector3};
use nurbs_core::{CurveJet, Error, Frame, construct};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;

/// Angles (radians) and shares of the size up to which a position counts as special: parallel, normal, on the axis.
const SPECIAL: f64 = 1e-9;

/// Where on the curve positions and normals are compared: away from the middle, where arcs may meet the axis.
const STATION: f64 = 0.4;

/// A curve that turns about an axis, and the frame of the axis: `z` along it.
struct Turning<'a> {
    curve: &'a EdgeCurve,
    range: [f64; 2],
    frame: Frame,
    /// Largest distance of the curve from the origin of the frame.
    size: f64,
}

/// Reads the surface; where loops bound it, planes, cylinders, cones, spheres and tori are recognised.
///
/// Also tells whether the normal of the carrier is that of the parameters of the file (curve, angle).
pub(crate) fn read(
    file: &File<'_>,
    values: &mut Cursor<'_>,
    bounds: Bounds,
) -> Result<(Carrier, bool, Chart), Fault> {
    let axis = values.pointer("pointer to the axis")?;
    let curve = values.pointer("pointer to the curve")?;
    let [start, end] = values.reals("start and end angle")?;
    let line = ruled::single(file, values, axis)?;
    let EdgeCurve::Line { origin, direction } = line.curve else {
        return Err(values.invalid(format!("the axis (entity {}) is no line", axis.sequence)));
    };
    let piece = ruled::single(file, values, curve)?;
    let axis = Unit::try_new(direction, 0.0).filter(|axis| axis.iter().all(|c| c.is_finite()));
    let Some(axis) = axis else { return Err(values.invalid("the axis has no length")) };
    let angle = end - start;
    if !(angle > 0.0 && angle <= TAU * (1.0 + SPECIAL)) {
        let what = format!("the angles {start} and {end} are no turn of more than 0 and at most 2π");
        return Err(values.invalid(what));
    }
    let chart = Chart::Revolution { curve: piece.curve.clone(), origin, axis };
    let invalid = |error: Error| values.invalid(format!("the surface is not valid: {error}"));
    if bounds == Bounds::Loops {
        let frame = Frame::from_axis(origin, axis.into_inner()).map_err(invalid)?;
        let [a, b] = piece.ends();
        let size = (a - origin).norm().max((b - origin).norm());
        let turning = Turning { curve: &piece.curve, range: piece.range, frame, size };
        if let Some((carrier, same_sense)) = turning.analytic().map_err(invalid)? {
            return Ok((carrier, same_sense, chart));
        }
    }
    let make = || {
        let turn = Rotation3::from_axis_angle(&axis, start);
        let curve = piece.nurbs()?;
        let curve =
            if start == 0.0 { curve } else { curve.transformed(turn.matrix(), &(origin - turn * origin))? };
        construct::revolve(&curve, &origin, &axis, angle.min(TAU))?.transposed()
    };
    Ok((Carrier::Nurbs(Arc::new(make().map_err(invalid)?)), true, chart))
}

impl Turning<'_> {
    /// The analytic surface, and whether its normal is that of the parameters.
    fn analytic(&self) -> Result<Option<(Carrier, bool)>, Error> {
        let found = match self.curve {
            EdgeCurve::Line { direction, .. } => self.by_line(direction)?,
            EdgeCurve::Circle { frame, radius } => self.by_circle(frame, *radius)?,
            EdgeCurve::Ellipse { .. } | EdgeCurve::Nurbs(_) => None,
        };
        let Some((carrier, normal)) = found else { return Ok(None) };
        let CurveJet { point, d1: derivative, .. } = self.curve.jet(self.station());
        let around = self.frame.z().cross(&(point - self.frame.origin()));
        Ok(Some((carrier, derivative.cross(&around).dot(&normal) > 0.0)))
    }

    fn station(&self) -> f64 {
        (1.0 - STATION) * self.range[0] + STATION * self.range[1]
    }

    /// The frame with its origin at a height and its `x` axis towards a point.
    fn frame_at(&self, height: f64, towards: &Vector3<f64>) -> Result<Frame, Error> {
        let z = self.frame.z();
        let reference = towards - self.frame.origin();
        Frame::new(self.frame.origin() + z * height, z, reference)
    }

    /// The carrier, and its normal at the station.
    fn by_line(&self, direction: &Vector3<f64>) -> Result<Option<(Carrier, Vector3<f64>)>, Error> {
        let [start, end] = self.range.map(|t| self.curve.point(t));
        let middle = self.curve.point(self.station());
        let local = |point: &Vector3<f64>| {
            let local = self.frame.local(point);
            [local.x.hypot(local.y), local.z]
        };
        let ([r0, z0], [r1, z1], [radius, height]) = (local(&start), local(&end), local(&middle));
        let direction = direction.normalize();
        let z = self.frame.z();
        let small = SPECIAL * self.size;
        let outwards = || (middle - self.frame.point(&Vector3::new(0.0, 0.0, height))) / radius;
        if direction.dot(&z).abs() <= SPECIAL {
            let frame = self.frame_at(height, if r1 > r0 { &end } else { &start })?;
            return Ok(Some((Carrier::Plane { frame }, z)));
        }
        if direction.cross(&z).norm() <= SPECIAL && radius > small {
            let frame = self.frame_at(height, &middle)?;
            return Ok(Some((Carrier::Cylinder { frame, radius }, outwards())));
        }
        // A line that meets the axis makes a cone, unless it goes through the apex.
        let arm = middle - self.frame.origin();
        let in_plane = arm.dot(&z.cross(&direction)).abs() <= small;
        let one_nappe = ((1.0 - STATION) * r0 + STATION * r1 - radius).abs() <= small;
        if !in_plane || !one_nappe || radius <= small {
            return Ok(None);
        }
        let half_angle = ((r1 - r0) / (z1 - z0)).atan();
        if !(half_angle.abs() > SPECIAL && half_angle.abs() < FRAC_PI_2 - SPECIAL) {
            return Ok(None);
        }
        let frame = self.frame_at(height, &middle)?;
        let normal = outwards() * half_angle.cos() - z * half_angle.sin();
        Ok(Some((Carrier::Cone { frame, radius, half_angle }, normal)))
    }

    fn by_circle(&self, circle: &Frame, radius: f64) -> Result<Option<(Carrier, Vector3<f64>)>, Error> {
        let small = SPECIAL * self.size;
        let z = self.frame.z();
        let centre = self.frame.local(&circle.origin());
        let distance = centre.x.hypot(centre.y);
        let middle = self.curve.point(self.station());
        let normal = (middle - circle.origin()) / radius;
        // The plane of the circle contains the axis.
        let holds_axis = circle.z().dot(&z).abs() <= SPECIAL
            && circle.z().dot(&(circle.origin() - self.frame.origin())).abs() <= small;
        if !holds_axis {
            return Ok(None);
        }
        if distance <= small {
            let frame = Frame::from_axis(self.frame.origin() + z * centre.z, z)?;
            return Ok(Some((Carrier::Sphere { frame, radius }, normal)));
        }
        if distance <= radius * (1.0 + SPECIAL) {
            return Ok(None);
        }
        let frame = self.frame_at(centre.z, &circle.origin())?;
        Ok(Some((Carrier::Torus { frame, major_radius: distance, minor_radius: radius }, normal)))
    }
}
