//! How far a curve and a level set are apart, from both sides.

use crate::Error;
use distance_field::{DistanceField, Hint, LevelSetField, Search};
use footpoint::CurveProjector;
use mesh_core::Polyline;
use nalgebra::Vector2;
use nurbs_core::{BsplineCurve, ParametricCurve};

/// Samples of a curve on each of its spans, its ends included.
const PER_SPAN: usize = 16;

/// Points on a chord between vertices for each cell of its length, and most of them.
const PER_CELL: f64 = 4.0;
const MOST: f64 = 4.0;

/// A point of a contour, and its length along the contour.
pub(crate) type Sample = (f64, Vector2<f64>);

/// Points of the level set along a contour: its vertices, and the feet of points on the chords between them, four in a cell.
///
/// Between neighbours is at most about a third of a cell.
pub(crate) fn along(field: &LevelSetField<2>, contour: &Polyline<2>) -> Vec<Sample> {
    let vertices = contour.vertices();
    let cell = field.grid().spacing().amax();
    let mut out = Vec::with_capacity(2 * vertices.len());
    for (k, vertex) in vertices.iter().enumerate() {
        let length = contour.cumulative_lengths()[k.min(contour.cumulative_lengths().len() - 1)];
        out.push((length, vertex.coords));
        let Some([a, b]) = contour.segment(k) else { continue };
        let step = (b - a).norm();
        let ends = [(length, a.coords), (length + step, b.coords)];
        let pieces = (PER_CELL * step / cell - 0.5).ceil().min(MOST);
        let mut k = 1.0;
        while k < pieces {
            out.extend(between(field, ends, k / pieces));
            k += 1.0;
        }
    }
    out
}

/// The same with a point between each two neighbours where these are wanted, by the length of the first; around a closed contour of a given
/// length the last one's neighbour is the first.
pub(crate) fn denser(
    field: &LevelSetField<2>,
    samples: &[Sample],
    around: Option<f64>,
    wanted: impl Fn(f64) -> bool,
) -> Vec<Sample> {
    let mut out = Vec::with_capacity(samples.len());
    let beyond = around.and_then(|length| samples.first().map(|first| (first.0 + length, first.1)));
    for (k, &sample) in samples.iter().enumerate() {
        out.push(sample);
        let next = samples.get(k + 1).copied().or(beyond);
        if let Some(next) = next.filter(|_| wanted(sample.0)) {
            out.extend(between(field, [sample, next], 0.5));
        }
    }
    out
}

/// The point of the level set next to a share of the way between two others, if it lies on the same part.
fn between(field: &LevelSetField<2>, [(from, a), (to, b)]: [Sample; 2], share: f64) -> Option<Sample> {
    let frame = field.frame(&a.lerp(&b, share), Search::Global, &Hint::NONE);
    // Where another part is nearer, or the foot is none, the neighbours speak for the part between them.
    let is_near = frame.status.is_converged() && frame.distance.abs() <= 0.5 * (b - a).norm();
    is_near.then_some((from + share * (to - from), frame.foot))
}

/// The larger of two distances; one that is not a number is larger than all, so that no verdict passes over it.
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b <= a { a } else { b }
}

/// Largest distances between a curve and a level set.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Gap {
    /// Of points of the curve from the level set.
    pub(crate) forth: f64,
    /// Of points of the contour from the curve.
    pub(crate) back: f64,
    /// The larger of both on each span of the curve, in the order of its spans.
    pub(crate) spans: Vec<f64>,
}

impl Gap {
    pub(crate) fn largest(&self) -> f64 {
        larger(self.forth, self.back)
    }
}

pub(crate) fn gap(
    field: &LevelSetField<2>,
    samples: &[Sample],
    curve: &BsplineCurve<2>,
) -> Result<Gap, Error> {
    let knots = curve.knots();
    let intervals: Vec<_> = knots.spans().map(|span| knots.span_interval(span)).collect();
    let mut spans = vec![0.0f64; intervals.len()];
    let mut forth = 0.0f64;
    let points: Vec<Vector2<f64>> = intervals
        .iter()
        .flat_map(|interval| (0..=PER_SPAN).map(|k| interval.lerp(k as f64 / PER_SPAN as f64)))
        .map(|t| curve.point(t))
        .collect();
    for (k, frame) in field.frames(&points, Search::Global, &[]).iter().enumerate() {
        // The nearest point, foot or not, is on the level set.
        let distance = (points[k] - frame.foot).norm();
        forth = larger(forth, distance);
        let span = &mut spans[k / (PER_SPAN + 1)];
        *span = larger(*span, distance);
    }
    let projector = CurveProjector::new(curve);
    let queries: Vec<Vector2<f64>> = samples.iter().map(|(_, point)| *point).collect();
    let mut back = 0.0f64;
    for foot in projector.project_all(&queries) {
        back = larger(back, foot.distance);
        let t = foot.parameter;
        if let Some(span) = intervals.iter().position(|i| i.start() <= t && t <= i.end()) {
            spans[span] = larger(spans[span], foot.distance);
        }
    }
    Ok(Gap { forth, back, spans })
}

#[cfg(test)]
mod tests {
    use super::larger;

    #[test]
    fn what_is_not_a_number_is_not_lost() {
        assert_eq!([larger(1.0, 2.0), larger(2.0, 1.0)], [2.0, 2.0]);
        assert!(larger(f64::NAN, 1.0).is_nan() && larger(1.0, f64::NAN).is_nan());
        assert!([1.0, f64::NAN, 0.5].into_iter().fold(0.0, larger).is_nan());
    }
}
