//! Closed curves through points of the plane.

use nalgebra::Vector2;
use nurbs_core::{BsplineCurve, ParameterMethod, ParametricCurve};

/// Samples per point of a curve by which its length is measured.
const FINE: usize = 8;

/// A closed cubic curve with a table of its length, anticlockwise.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosedCurve {
    curve: BsplineCurve<2>,
    points: usize,
    /// Length up to each of the fine samples; the last is the whole.
    lengths: Vec<f64>,
}

impl ClosedCurve {
    /// The curve through points in order, the last joined with the first: chord length parameters, averaged knots
    /// ([PT97, sec. 9.2]). Points that coincide with their predecessors are dropped. `None` for fewer than 5 points, or
    /// where the points do not determine a curve.
    #[must_use]
    pub fn through(points: &[Vector2<f64>]) -> Option<Self> {
        let mut points = points.to_vec();
        if points.len() < 5 {
            return None;
        }
        let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
        points.dedup_by(|a, b| (*a - *b).norm() <= 1e-9 * size);
        while points.len() > 1 && (points[0] - points[points.len() - 1]).norm() <= 1e-9 * size {
            points.pop();
        }
        if points.len() < 5 {
            return None;
        }
        if area(&points) < 0.0 {
            points.reverse();
        }
        let curve = BsplineCurve::interpolate_closed(&points, 3, ParameterMethod::ChordLength).ok()?;
        let mut found = Self { curve, points: points.len(), lengths: vec![0.0] };
        let fine = found.polygon(FINE);
        let mut sum = 0.0;
        for i in 0..fine.len() {
            sum += (fine[(i + 1) % fine.len()] - fine[i]).norm();
            found.lengths.push(sum);
        }
        (sum > 0.0 && sum.is_finite()).then_some(found)
    }

    /// The curve through samples of a closed polygon that are about `step` apart, `most` at most, each the mean of the
    /// polygon around it.
    pub(crate) fn through_polygon(polygon: &[Vector2<f64>], step: f64, most: usize) -> Option<Self> {
        let edge = |i: usize| (polygon[(i + 1) % polygon.len()] - polygon[i]).norm();
        let length: f64 = (0..polygon.len()).map(edge).sum();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let count = (length / step).round().clamp(12.0, most.max(12) as f64) as usize;
        // Four samples for each point, then their mean.
        let (mut fine, mut i, mut start) = (Vec::with_capacity(4 * count), 0, 0.0);
        for k in 0..4 * count {
            let at = length * k as f64 / (4 * count) as f64;
            while i + 1 < polygon.len() && start + edge(i) < at {
                start += edge(i);
                i += 1;
            }
            let share = ((at - start) / edge(i).max(f64::MIN_POSITIVE)).min(1.0);
            fine.push(polygon[i].lerp(&polygon[(i + 1) % polygon.len()], share));
        }
        let mean = |k: usize| {
            let around = |d: usize| fine[(4 * k + d + 4 * count - 2) % (4 * count)];
            (around(0) + around(1) * 2.0 + around(2) * 2.0 + around(3) * 2.0 + around(4)) / 8.0
        };
        Self::through(&(0..count).map(mean).collect::<Vec<_>>())
    }

    /// The curve.
    #[must_use]
    pub fn curve(&self) -> &BsplineCurve<2> {
        &self.curve
    }

    /// Number of points that it was laid through.
    #[must_use]
    pub fn points(&self) -> usize {
        self.points
    }

    /// Its length.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.lengths[self.lengths.len() - 1]
    }

    /// Samples at equal steps of the parameter, `per_point` for each point of the curve.
    #[must_use]
    pub fn polygon(&self, per_point: usize) -> Vec<Vector2<f64>> {
        let count = self.points * per_point.max(1);
        let domain = self.curve.domain();
        (0..count).map(|i| self.curve.point(domain.lerp(i as f64 / count as f64))).collect()
    }

    /// The parameter at a share of the length, counted from a start that is fixed for the curve.
    #[must_use]
    pub fn parameter(&self, share: f64) -> f64 {
        let wanted = share.rem_euclid(1.0) * self.length();
        let after = self.lengths.partition_point(|&l| l <= wanted).clamp(1, self.lengths.len() - 1);
        let (a, b) = (self.lengths[after - 1], self.lengths[after]);
        let within = if b > a { (wanted - a) / (b - a) } else { 0.0 };
        let steps = (self.lengths.len() - 1) as f64;
        self.curve.domain().lerp(((after - 1) as f64 + within) / steps)
    }

    /// `count` points at equal lengths from each other, the first at a share `start` of the length.
    #[must_use]
    pub fn resampled(&self, count: usize, start: f64) -> Vec<Vector2<f64>> {
        (0..count).map(|i| self.curve.point(self.parameter(start + i as f64 / count as f64))).collect()
    }

    /// Points as [`resampled`](Self::resampled), with the unit normals there that point outwards.
    #[must_use]
    pub fn resampled_with_normals(&self, count: usize) -> Vec<(Vector2<f64>, Vector2<f64>)> {
        (0..count)
            .map(|i| {
                let jet = self.curve.jet(self.parameter(i as f64 / count as f64));
                let normal = Vector2::new(jet.d1.y, -jet.d1.x);
                (jet.point, normal.try_normalize(0.0).unwrap_or_else(Vector2::zeros))
            })
            .collect()
    }
}

/// Twice the signed area of a polygon, halved.
pub(crate) fn area(points: &[Vector2<f64>]) -> f64 {
    let next = points.iter().cycle().skip(1);
    0.5 * points.iter().zip(next).map(|(a, b)| a.perp(b)).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn samples_at_equal_lengths() {
        let ellipse: Vec<_> = (0..40)
            .map(|i| TAU * f64::from(i) / 40.0)
            .map(|t| Vector2::new(3.0 * t.cos(), -t.sin()))
            .collect();
        let curve = ClosedCurve::through(&ellipse).unwrap();
        assert!((curve.length() - 13.364893).abs() < 2e-3);
        let samples = curve.resampled(100, 0.25);
        assert!(area(&samples) > 0.0);
        let steps: Vec<f64> = (0..100).map(|i| (samples[(i + 1) % 100] - samples[i]).norm()).collect();
        assert!(steps.iter().all(|s| (s - 0.1336).abs() < 2e-3), "{steps:?}");
        for (p, n) in curve.resampled_with_normals(17) {
            assert!(n.dot(&Vector2::new(p.x / 9.0, p.y)) > 0.0);
        }
    }

    #[test]
    fn too_few_points_are_no_curve() {
        let p = Vector2::new(1.0, 2.0);
        assert!(ClosedCurve::through(&[p; 20]).is_none());
        assert!(ClosedCurve::through(&[]).is_none());
    }
}
