//! Curves of edges: points, and the exact B-spline.

use brep_core::description::EdgeCurve;
use nalgebra::{Vector2, Vector3};
use nurbs_core::{BsplineCurve, Circle, Error, Frame, Interval, KnotVector, ParametricCurve};

/// The point at a parameter.
pub(crate) fn point(curve: &EdgeCurve, t: f64) -> Vector3<f64> {
    let on_ellipse = |frame: &Frame, a: f64, b: f64| {
        let (sin, cos) = t.sin_cos();
        frame.point(&Vector3::new(a * cos, b * sin, 0.0))
    };
    match curve {
        EdgeCurve::Line { origin, direction } => origin + direction * t,
        EdgeCurve::Circle { frame, radius } => on_ellipse(frame, *radius, *radius),
        EdgeCurve::Ellipse { frame, semi_axes: [a, b] } => on_ellipse(frame, *a, *b),
        EdgeCurve::Nurbs(curve) => curve.point(t),
    }
}

/// Point and derivative at a parameter.
pub(crate) fn jet(curve: &EdgeCurve, t: f64) -> [Vector3<f64>; 2] {
    let on_ellipse = |frame: &Frame, a: f64, b: f64| {
        let (sin, cos) = t.sin_cos();
        frame.vector(&Vector3::new(-a * sin, b * cos, 0.0))
    };
    let derivative = match curve {
        EdgeCurve::Line { direction, .. } => *direction,
        EdgeCurve::Circle { frame, radius } => on_ellipse(frame, *radius, *radius),
        EdgeCurve::Ellipse { frame, semi_axes: [a, b] } => on_ellipse(frame, *a, *b),
        EdgeCurve::Nurbs(curve) => curve.jet(t).d1,
    };
    [point(curve, t), derivative]
}

/// The piece of the curve over `range` as a B-spline. A B-spline over its whole domain stays as it is.
pub(crate) fn nurbs(curve: &EdgeCurve, range: [f64; 2]) -> Result<BsplineCurve<3>, Error> {
    let interval = Interval::new(range[0], range[1])?;
    match curve {
        EdgeCurve::Line { .. } => {
            let ends = range.map(|t| point(curve, t));
            BsplineCurve::new(KnotVector::bezier(1, interval)?, ends.to_vec(), None)
        }
        EdgeCurve::Circle { frame, radius } => arc(frame, [*radius, *radius], interval),
        EdgeCurve::Ellipse { frame, semi_axes } => arc(frame, *semi_axes, interval),
        EdgeCurve::Nurbs(curve) if curve.domain() == interval => Ok(curve.as_ref().clone()),
        EdgeCurve::Nurbs(curve) => curve.trimmed(interval),
    }
}

fn arc(frame: &Frame, [a, b]: [f64; 2], angles: Interval) -> Result<BsplineCurve<3>, Error> {
    let unit = Circle::new(Vector2::zeros(), 1.0)?.with_arc(angles)?.to_nurbs()?;
    let (knots, points, weights) = unit.into_parts();
    let placed = points.iter().map(|p| frame.point(&Vector3::new(a * p.x, b * p.y, 0.0)));
    BsplineCurve::new(knots, placed.collect(), weights)
}
