//! B-splines as files want them: clamped, and analytic carriers as far as their loops reach.

use crate::edges;
use brep_core::description::{Carrier, FaceDescription, LoopDescription, PartDescription};
use nalgebra::Vector3;
use nurbs_core::{
    BsplineCurve, BsplineSurface, Cone, Cylinder, Direction, Error, Frame, Interval, Plane, Sphere, Torus,
};
use std::borrow::Cow;
use std::f64::consts::TAU;

/// Share of the extent by which carriers reach beyond their loops.
pub(crate) const MARGIN: f64 = 0.01;
/// Narrowest gap between the angles of a face (radians) that a seam is moved into; without one the face goes all around.
const NARROWEST: f64 = 0.1;

/// The surface with the first and last knots repeated, as files want them; periodic ones are cut open at their seam. What is
/// clamped already keeps every bit.
pub(crate) fn clamped(surface: &BsplineSurface) -> Result<Cow<'_, BsplineSurface>, Error> {
    let open = |knots: &nurbs_core::KnotVector| {
        let domain = knots.domain();
        let multiple = |t: f64| knots.multiplicity(t) > knots.degree();
        !knots.is_periodic() && multiple(domain.start()) && multiple(domain.end())
    };
    let mut found = Cow::Borrowed(surface);
    for direction in [Direction::U, Direction::V] {
        let knots = if direction == Direction::U { found.knots_u() } else { found.knots_v() };
        if !open(knots) {
            found = Cow::Owned(found.clamped(direction)?);
        }
    }
    Ok(found)
}

/// The same of a curve.
pub(crate) fn clamped_curve<const D: usize>(
    curve: &BsplineCurve<D>,
) -> Result<Cow<'_, BsplineCurve<D>>, Error> {
    let knots = curve.knots();
    let domain = knots.domain();
    let multiple = |t: f64| knots.multiplicity(t) > knots.degree();
    if !knots.is_periodic() && multiple(domain.start()) && multiple(domain.end()) {
        return Ok(Cow::Borrowed(curve));
    }
    curve.clamped().map(Cow::Owned)
}

/// The carrier of a face as a B-spline that reaches as far as the loops, and by a share of that (`margin`) beyond where it
/// could.
///
/// `None` for an unbounded carrier without loops.
pub(crate) fn nurbs<'a>(
    part: &PartDescription,
    face: &'a FaceDescription,
    margin: f64,
) -> Result<Option<Cow<'a, BsplineSurface>>, Error> {
    let points = hull(part, face)?;
    let made = match &face.carrier {
        Carrier::Nurbs(surface) => return clamped(surface).map(Some),
        Carrier::Sphere { frame, radius } => {
            Sphere::new(turned(frame, &stations(part, face))?, *radius)?.to_nurbs()?
        }
        Carrier::Torus { frame, major_radius, minor_radius } => {
            Torus::new(turned(frame, &stations(part, face))?, *major_radius, *minor_radius)?.to_nurbs()?
        }
        _ if points.is_empty() => return Ok(None),
        Carrier::Plane { frame } => {
            let (u, v) = (extent(frame, &points, 0, margin)?, extent(frame, &points, 1, margin)?);
            Plane::new(*frame, u, v).to_nurbs()?
        }
        Carrier::Cylinder { frame, radius } => {
            let frame = turned(frame, &stations(part, face))?;
            Cylinder::new(frame, *radius, extent(&frame, &points, 2, margin)?)?.to_nurbs()?
        }
        Carrier::Cone { frame, radius, half_angle } => {
            let frame = turned(frame, &stations(part, face))?;
            let heights = extent(&frame, &points, 2, margin)?;
            // Not beyond the apex.
            let slope = half_angle.tan();
            let apex = -radius / slope;
            let (low, high) = if slope > 0.0 {
                (heights.start().max(apex), heights.end())
            } else {
                (heights.start(), heights.end().min(apex))
            };
            let at = |height: f64| (radius + height * slope).max(0.0);
            let base = Frame::new(frame.origin() + frame.z() * low, frame.z(), frame.x())?;
            Cone::new(base, at(low), at(high), high - low)?.to_nurbs()?
        }
    };
    Ok(Some(Cow::Owned(made)))
}

/// Stations of each edge where the angles of a face are looked at.
const STATIONS: u32 = 128;

/// Points on the edges of a face, narrow enough to see gaps between its angles.
fn stations(part: &PartDescription, face: &FaceDescription) -> Vec<Vector3<f64>> {
    let mut points = Vec::new();
    for boundary in &face.loops {
        let LoopDescription::Edges(uses) = boundary else { continue };
        for edge in uses.iter().filter_map(|edge| part.edges.get(edge.edge)) {
            let [start, end] = edge.range;
            let at = |k: u32| {
                let share = f64::from(k) / f64::from(STATIONS);
                (1.0 - share) * start + share * end
            };
            points.extend((0..=STATIONS).map(|k| edge.curve.point(at(k))));
        }
    }
    points
}

/// Points whose convex hull contains the loops of a face.
pub(crate) fn hull(part: &PartDescription, face: &FaceDescription) -> Result<Vec<Vector3<f64>>, Error> {
    let mut points = Vec::new();
    for boundary in &face.loops {
        let LoopDescription::Edges(uses) = boundary else { continue };
        for edge in uses.iter().filter_map(|edge| part.edges.get(edge.edge)) {
            points.extend_from_slice(edges::nurbs(&edge.curve, edge.range)?.control_points());
        }
    }
    Ok(points)
}

/// The interval of a coordinate in a frame that the points take, and a margin.
fn extent(frame: &Frame, points: &[Vector3<f64>], coordinate: usize, margin: f64) -> Result<Interval, Error> {
    let all = points.iter().map(|point| frame.local(point)[coordinate]);
    let (low, high) =
        all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    let margin = margin * (high - low);
    Interval::new(low - margin, high + margin)
}

/// The frame turned about its axis so that the seam (angle 0) lies in the middle of the largest gap between the angles of
/// the points.
fn turned(frame: &Frame, points: &[Vector3<f64>]) -> Result<Frame, Error> {
    let mut angles: Vec<f64> = points
        .iter()
        .map(|point| frame.local(point))
        .filter(|local| local.x != 0.0 || local.y != 0.0)
        .map(|local| local.y.atan2(local.x).rem_euclid(TAU))
        .collect();
    angles.sort_by(f64::total_cmp);
    let (Some(&first), Some(&last)) = (angles.first(), angles.last()) else { return Ok(*frame) };
    let gaps = angles.windows(2).map(|pair| (pair[1] - pair[0], pair[0]));
    let (gap, after) =
        gaps.fold((first + TAU - last, last), |widest, gap| if gap.0 > widest.0 { gap } else { widest });
    if gap < NARROWEST {
        return Ok(*frame);
    }
    let seam = after + 0.5 * gap;
    Frame::new(frame.origin(), frame.z(), frame.x() * seam.cos() + frame.y() * seam.sin())
}
