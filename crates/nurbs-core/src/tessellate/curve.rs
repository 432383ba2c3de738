//! Curves to polylines.

use super::TessellationOptions;
use crate::bernstein::Net;
use crate::{BezierCurve, BsplineCurve, Error, Interval};
use nalgebra::{SVector, Vector1};

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

/// The two halves of a piece; `None` when the parameter has no middle.
fn halves<const D: usize>(piece: &BezierCurve<D>) -> Option<[BezierCurve<D>; 2]> {
    let middle = piece.interval.midpoint();
    let first = Interval::new(piece.interval.start(), middle).ok()?;
    let second = Interval::new(middle, piece.interval.end()).ok()?;
    let degrees = [0, piece.control_points.len() - 1];
    let mut points = piece.control_points.clone();
    let Some(weights) = &piece.weights else {
        let mut right = Net::new(degrees, points);
        let left = right.split(false, 0.5);
        return Some([(first, left), (second, right)].map(|(interval, net)| BezierCurve {
            interval,
            control_points: net.values().to_vec(),
            weights: None,
        }));
    };
    points.iter_mut().zip(weights).for_each(|(p, w)| *p *= *w);
    let mut right = Net::new(degrees, points);
    let mut right_weights = Net::new(degrees, weights.iter().map(|w| Vector1::new(*w)).collect());
    let (left, left_weights) = (right.split(false, 0.5), right_weights.split(false, 0.5));
    Some([(first, left, left_weights), (second, right, right_weights)].map(|(interval, net, weights)| {
        BezierCurve {
            interval,
            control_points: net.values().iter().zip(weights.values()).map(|(a, w)| a / w.x).collect(),
            weights: Some(weights.values().iter().map(|w| w.x).collect()),
        }
    }))
}
