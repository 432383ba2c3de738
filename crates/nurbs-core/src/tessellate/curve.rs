//! Curves to polylines.

use super::TessellationOptions;
use crate::{BezierCurve, BsplineCurve, Error, Interval};
use nalgebra::SVector;

/// Points on a curve, in order.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline<const D: usize> {
    /// The vertices; those of a closed curve end with the first one again.
    pub points: Vec<SVector<f64, D>>,
    /// The parameter of each vertex.
    pub parameters: Vec<f64>,
}

impl<const D: usize> BsplineCurve<D> {
    /// A polyline with vertices on the curve whose chords are within the tolerance of it.
    ///
    /// Bézier pieces are halved until all their control points are that close to the chord; the curve
    /// is then too, since it lies in their convex hull. Knots are vertices always.
    ///
    /// # Errors
    /// [`Error::Argument`] when the tolerance is not positive or takes more vertices than allowed.
    pub fn tessellate(&self, options: &TessellationOptions) -> Result<Polyline<D>, Error> {
        options.check()?;
        let mut stack = self.bezier_curves();
        stack.reverse();
        let mut out = Polyline { points: Vec::new(), parameters: Vec::new() };
        if let Some(first) = stack.last() {
            out.points.push(first.control_points[0]);
            out.parameters.push(first.interval.start());
        }
        while let Some(piece) = stack.pop() {
            if out.points.len() + stack.len() >= options.max_vertices {
                return Err(options.too_many());
            }
            let end = piece.control_points[piece.control_points.len() - 1];
            match halves(&piece).filter(|_| deviation(&piece.control_points) > options.abs_tolerance) {
                Some([left, right]) => stack.extend([right, left]),
                // A parameter interval that cannot be halved any more is as fine as numbers get.
                None => {
                    out.points.push(end);
                    out.parameters.push(piece.interval.end());
                }
            }
        }
        Ok(out)
    }
}

/// Largest distance of the points from the segment between the first and the last.
fn deviation<const D: usize>(points: &[SVector<f64, D>]) -> f64 {
    let (start, end) = (points[0], points[points.len() - 1]);
    let chord = end - start;
    let squared = chord.norm_squared();
    points.iter().fold(0.0, |worst: f64, p| {
        let s = if squared > 0.0 { ((p - start).dot(&chord) / squared).clamp(0.0, 1.0) } else { 0.0 };
        worst.max((p - start - chord * s).norm())
    })
}

/// The two halves of a piece ([PT97, sec. 1.7], de Casteljau); `None` when the parameter has no middle.
fn halves<const D: usize>(piece: &BezierCurve<D>) -> Option<[BezierCurve<D>; 2]> {
    let middle = piece.interval.midpoint();
    let first = Interval::new(piece.interval.start(), middle).ok()?;
    let second = Interval::new(middle, piece.interval.end()).ok()?;
    let n = piece.control_points.len();
    let mut weights = piece.weights.clone().unwrap_or_else(|| vec![1.0; n]);
    let mut points: Vec<_> = piece.control_points.iter().zip(&weights).map(|(p, w)| p * *w).collect();
    let (mut left, mut left_weights) = (points.clone(), weights.clone());
    for level in 1..n {
        for k in 0..n - level {
            points[k] = (points[k] + points[k + 1]) * 0.5;
            weights[k] = 0.5 * (weights[k] + weights[k + 1]);
        }
        left[level] = points[0];
        left_weights[level] = weights[0];
    }
    let rational = piece.weights.is_some();
    let build = |interval, mut points: Vec<SVector<f64, D>>, weights: Vec<f64>| {
        for (point, weight) in points.iter_mut().zip(&weights) {
            *point /= *weight;
        }
        BezierCurve { interval, control_points: points, weights: rational.then_some(weights) }
    };
    Some([build(first, left, left_weights), build(second, points, weights)])
}
