//! Conic arcs (type 104).

use super::curves;
use super::fault::Fault;
use super::file::Cursor;
use brep_core::description::EdgeCurve;
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use nurbs_core::{BsplineCurve, Error, Frame};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Share of the size up to which a point counts as lying on the conic, and two points as one.
const ON_CONIC: f64 = 1e-6;

/// A conic `A x² + B xy + C y² + D x + E y + F = 0` in a plane of constant z, and the ends of the arc on it.
struct Conic {
    /// The symmetric matrix of the equation for `(x, y, 1)`.
    matrix: Matrix3<f64>,
    z: f64,
    ends: [Vector2<f64>; 2],
}

/// Reads the arc: an ellipse as such, a parabola or hyperbola as a rational quadratic.
///
/// The arc of an ellipse runs counter-clockwise from its start to its end.
pub(crate) fn read(form: i64, values: &mut Cursor<'_>) -> Result<(EdgeCurve, [f64; 2]), Fault> {
    let [a, b, c, d, e, f] = values.reals("coefficient of the conic")?;
    let z = values.real("z of the conic")?;
    let [x1, y1, x2, y2] = values.reals("start and end of the conic arc")?;
    let matrix = Matrix3::new(a, 0.5 * b, 0.5 * d, 0.5 * b, c, 0.5 * e, 0.5 * d, 0.5 * e, f);
    let conic = Conic { matrix, z, ends: [Vector2::new(x1, y1), Vector2::new(x2, y2)] };
    let discriminant = a * c - 0.25 * b * b;
    let found = match form {
        1 => conic.ellipse(),
        2 | 3 => conic.quadratic(),
        _ if discriminant > 1e-12 * (a * a + b * b + c * c) => conic.ellipse(),
        _ => conic.quadratic(),
    };
    found.map_err(|what| values.invalid(format!("the conic arc is not valid: {what}")))
}

impl Conic {
    fn ellipse(&self) -> Result<(EdgeCurve, [f64; 2]), String> {
        let m = &self.matrix;
        let quadratic: Matrix2<f64> = m.fixed_view::<2, 2>(0, 0).into_owned();
        let linear = Vector2::new(m[(0, 2)], m[(1, 2)]);
        let inverse = quadratic.try_inverse().ok_or("the equation is not that of an ellipse")?;
        let centre = -(inverse * linear);
        let level = m[(2, 2)] + linear.dot(&centre);
        // Directions of the axes: where the mixed term vanishes.
        let angle = 0.5 * (2.0 * m[(0, 1)]).atan2(m[(0, 0)] - m[(1, 1)]);
        let (sin, cos) = angle.sin_cos();
        let axes = if m[(0, 1)] == 0.0 {
            [Vector2::x(), Vector2::y()]
        } else {
            [Vector2::new(cos, sin), Vector2::new(-sin, cos)]
        };
        let semi_axes = axes.map(|axis| (-level / axis.dot(&(quadratic * axis))).sqrt());
        if semi_axes.iter().any(|semi_axis| !(*semi_axis > 0.0 && semi_axis.is_finite())) {
            return Err("the equation is not that of an ellipse".to_owned());
        }
        let size = semi_axes[0].max(semi_axes[1]);
        let mut angles = [0.0; 2];
        for (angle, end) in angles.iter_mut().zip(&self.ends) {
            let from = end - centre;
            let [x, y] = [from.dot(&axes[0]) / semi_axes[0], from.dot(&axes[1]) / semi_axes[1]];
            if (x.hypot(y) - 1.0).abs() > 1e-3 {
                return Err(format!("its end ({}, {}) does not lie on the ellipse", end.x, end.y));
            }
            *angle = y.atan2(x).rem_euclid(TAU);
        }
        let closed = (self.ends[1] - self.ends[0]).norm() <= 1e-3 * ON_CONIC * size;
        let sweep = if closed { TAU } else { (angles[1] - angles[0]).rem_euclid(TAU) };
        let in_space = |v: Vector2<f64>, z: f64| Vector3::new(v.x, v.y, z);
        let frame = Frame::new(in_space(centre, self.z), Vector3::z(), in_space(axes[0], 0.0));
        let frame = frame.map_err(|error| error.to_string())?;
        Ok((EdgeCurve::Ellipse { frame, semi_axes }, [angles[0], angles[0] + sweep]))
    }

    /// The arc between two points of one branch: end points `p`, `q`, the meeting point `t` of their tangents, and its weight.
    ///
    /// With `M` the matrix of the equation and `b(s) = (1−s)² p + 2 s (1−s) w t + s² q` the form `bᵀ M b` vanishes for
    /// all `s` when `w² = −pᵀMq / (2 tᵀMt)`.
    fn quadratic(&self) -> Result<(EdgeCurve, [f64; 2]), String> {
        let [p, q] = self.ends.map(|end| Vector3::new(end.x, end.y, 1.0));
        let (at_p, at_q) = (self.matrix * p, self.matrix * q);
        let size = (p - q).norm();
        for (end, line) in [(p, at_p), (q, at_q)] {
            let slope = line.x.hypot(line.y);
            let is_on = end.dot(&line).abs() <= ON_CONIC * size * slope;
            if !is_on {
                return Err(format!("its end ({}, {}) does not lie on the conic", end.x, end.y));
            }
        }
        // Where the tangents, which are the polars of the ends, meet.
        let meeting = at_p.cross(&at_q);
        let do_meet = meeting.z.abs() > 1e-12 * meeting.amax();
        if !do_meet {
            return Err("its tangents at the ends are parallel".to_owned());
        }
        let tangent = meeting / meeting.z;
        let square = -p.dot(&at_q) / (2.0 * tangent.dot(&(self.matrix * tangent)));
        if !(square > 0.0 && square.is_finite()) {
            return Err("its ends lie on different branches".to_owned());
        }
        let points = [p, tangent, q].map(|v| Vector3::new(v.x, v.y, self.z));
        let weights = vec![1.0, square.sqrt(), 1.0];
        let curve = BsplineCurve::bezier(points.to_vec(), curves::rational(weights));
        let curve = curve.map_err(|error: Error| error.to_string())?;
        Ok((EdgeCurve::Nurbs(Arc::new(curve)), [0.0, 1.0]))
    }
}
