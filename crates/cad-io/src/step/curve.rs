//! Curves of STEP as edge curves, with the parameters of their vertices.

use super::reader::Reader;
use brep_core::description::EdgeCurve;
use nalgebra::Vector3;
use nurbs_core::{BsplineCurve, Frame, Interval, KnotVector, ParametricCurve};
use std::f64::consts::TAU;
use std::sync::Arc;
use step_io::model::{Axis2PlacementRef, VectorRef};
use step_io::scene::{Curve, CurveKind, Edge, NurbsCurve};

/// Depth to which curves on surfaces may be nested.
const NESTING: usize = 16;

/// Distance, as a share of the size of the coordinates, below which a vertex counts as the end of its curve.
const AT_END: f64 = 1e-9;

/// A curve with the parameters of start and end.
pub(super) type Piece = (EdgeCurve, [f64; 2]);

impl Reader<'_> {
    /// The curve of an edge, run through from its start to its end.
    pub(super) fn edge_curve(&self, edge: &Edge<'_>) -> Result<Piece, String> {
        let ends = [edge.start(), edge.end()].map(|v| v.and_then(|v| v.point()).map(|p| p.xyz()));
        let [Some(start), Some(end)] = ends else {
            return Err("a vertex of the edge has no point".to_owned());
        };
        let [start, end] = [Vector3::from(start), Vector3::from(end)];
        if !start.iter().chain(end.iter()).all(|c| c.is_finite()) {
            return Err("a vertex of the edge is not finite".to_owned());
        }
        let size = start.amax().max(end.amax());
        let same_vertex = edge.start().map(|v| v.key()) == edge.end().map(|v| v.key());
        let closed = same_vertex || (end - start).norm() <= AT_END * size;
        let mut curve = edge.curve();
        for _ in 0..NESTING {
            match curve.curve_3d() {
                Some(inner) => curve = inner,
                None => break,
            }
        }
        let forward = edge.same_sense();
        match curve.kind() {
            CurveKind::Line(line) => {
                let origin = self.point(&line.pnt)?;
                let VectorRef::Vector(id) = &line.dir else {
                    return Err("the direction of the line is not a VECTOR".to_owned());
                };
                let along = self.direction(&self.model[*id].orientation)?;
                let mut direction = along / along.norm();
                let [mut a, mut b] = [start, end].map(|p| (p - origin).dot(&direction));
                if b < a {
                    direction = -direction;
                    [a, b] = [-a, -b];
                }
                if !(a < b && direction.iter().all(|c| c.is_finite())) {
                    return Err("the edge is a line of length 0".to_owned());
                }
                Ok((EdgeCurve::Line { origin, direction }, [a, b]))
            }
            CurveKind::Circle(circle) => {
                let frame = self.curve_frame(&circle.position, forward)?;
                let radius = circle.radius;
                if !(radius > 0.0 && radius.is_finite()) {
                    return Err(format!("the radius of the circle is {radius}"));
                }
                Ok(arc(EdgeCurve::Circle { frame, radius }, &start, &end, closed))
            }
            CurveKind::Ellipse(ellipse) => {
                let frame = self.curve_frame(&ellipse.position, forward)?;
                let semi_axes = [ellipse.semi_axis_1, ellipse.semi_axis_2];
                if !semi_axes.iter().all(|a| *a > 0.0 && a.is_finite()) {
                    return Err(format!("the semi-axes of the ellipse are {semi_axes:?}"));
                }
                Ok(arc(EdgeCurve::Ellipse { frame, semi_axes }, &start, &end, closed))
            }
            CurveKind::Parabola(_) | CurveKind::Hyperbola(_) => {
                let nurbs = edge.to_nurbs().ok_or("the conic has no finite piece between its vertices")?;
                let curve = nurbs_curve(nurbs, false)?;
                let range = [curve.domain().start(), curve.domain().end()];
                Ok((EdgeCurve::Nurbs(Arc::new(curve)), range))
            }
            _ => {
                let whole = self.whole_curve(&curve)?;
                spline(whole, forward, &start, &end, closed, size).map_err(|e| e.to_string())
            }
        }
    }

    fn curve_frame(&self, position: &Axis2PlacementRef, forward: bool) -> Result<Frame, String> {
        let Axis2PlacementRef::Axis2Placement3d(id) = position else {
            return Err("the curve has no position in space".to_owned());
        };
        let frame = self.frame(*id)?;
        if forward {
            return Ok(frame);
        }
        // The same conic run through backwards.
        Frame::new(frame.origin(), -frame.z(), frame.x()).map_err(|e| e.to_string())
    }

    /// A curve as a B-spline, whole.
    pub(super) fn whole_curve(&self, curve: &Curve<'_>) -> Result<BsplineCurve<3>, String> {
        let nurbs = curve.to_nurbs().ok_or("the curve has no exact form as a B-spline")?;
        nurbs_curve(nurbs, self.is_rational(curve.key()))
    }
}

/// The part of a circle or an ellipse from one point to another.
fn arc(curve: EdgeCurve, start: &Vector3<f64>, end: &Vector3<f64>, closed: bool) -> Piece {
    let a = curve.parameter_of(start);
    if closed {
        return (curve, [a, a + TAU]);
    }
    let mut b = curve.parameter_of(end);
    if b <= a {
        b += TAU;
    }
    (curve, [a, b])
}

/// The part of a B-spline from one vertex to another.
fn spline(
    whole: BsplineCurve<3>,
    forward: bool,
    start: &Vector3<f64>,
    end: &Vector3<f64>,
    closed: bool,
    size: f64,
) -> Result<Piece, nurbs_core::Error> {
    let curve = if forward { whole } else { whole.reversed()? };
    let (a, b) = (curve.domain().start(), curve.domain().end());
    let near = AT_END * size.max(curve.control_box().diagonal());
    let ends = [curve.point(a), curve.point(b)];
    let round = (ends[0] - ends[1]).norm() <= near;
    let snapped = |x: &Vector3<f64>, at: &Vector3<f64>| (x - at).norm() <= near;
    let whole_piece = |curve: BsplineCurve<3>| Ok((EdgeCurve::Nurbs(Arc::new(curve)), [a, b]));
    if snapped(start, &ends[0]) && snapped(end, &ends[1]) {
        return whole_piece(curve);
    }
    let shared = EdgeCurve::Nurbs(Arc::new(curve.clone()));
    let slack = 1e-9 * (b - a);
    let parameter = |x: &Vector3<f64>, own: usize| {
        if snapped(x, &ends[own]) {
            return [a, b][own];
        }
        let t = shared.parameter_of(x);
        if t - a <= slack {
            a
        } else if b - t <= slack {
            b
        } else {
            t
        }
    };
    let (mut from, mut to) = (parameter(start, 0), parameter(end, 1));
    if closed {
        // Of a closed edge the curve is closed too: it is opened at the vertex.
        if from <= a || from >= b || !round {
            return whole_piece(curve);
        }
        to = from;
    }
    if round && from >= b {
        from = a;
    }
    if round && to <= a {
        to = b;
    }
    if from < to {
        return Ok((shared, [from, to]));
    }
    if round {
        let (first, second) =
            (curve.trimmed(Interval::new(from, b)?)?, curve.trimmed(Interval::new(a, to)?)?);
        let joined = first.join(&second, 2.0 * near)?;
        let range = [joined.domain().start(), joined.domain().end()];
        return Ok((EdgeCurve::Nurbs(Arc::new(joined)), range));
    }
    // The vertices stand in the other order along an open curve: they count, not the flag.
    let back = curve.reversed()?;
    let range = Interval::new(a + b - from, a + b - to)?;
    Ok((EdgeCurve::Nurbs(Arc::new(back)), [range.start(), range.end()]))
}

fn nurbs_curve(nurbs: NurbsCurve, rational: bool) -> Result<BsplineCurve<3>, String> {
    let weights = (rational || nurbs.weights.iter().any(|w| *w != 1.0)).then_some(nurbs.weights);
    let points = nurbs.control_points.into_iter().map(Vector3::from).collect();
    let build = || BsplineCurve::new(KnotVector::new(nurbs.degree, nurbs.knots)?, points, weights);
    build().map_err(|e: nurbs_core::Error| e.to_string())
}
