//! Curves of edges as exact B-splines.

use brep_core::description::EdgeCurve;
use nalgebra::{Vector2, Vector3};
use nurbs_core::{BsplineCurve, Circle, Error, Frame, Interval, KnotVector, ParametricCurve};

/// The piece of the curve over `range` as a B-spline. A B-spline over its whole domain stays as it is.
pub(crate) fn nurbs(curve: &EdgeCurve, range: [f64; 2]) -> Result<BsplineCurve<3>, Error> {
    let interval = Interval::new(range[0], range[1])?;
    match curve {
        EdgeCurve::Line { .. } => {
            let ends = range.map(|t| curve.point(t));
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
