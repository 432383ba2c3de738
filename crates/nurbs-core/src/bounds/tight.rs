//! Tight bounding boxes of curves and surfaces.
//!
//! Each side of the box is an extremum of one coordinate, a rational function with positive weights:
//! on a Bézier piece it lies between the coefficients, and its values at the corners are attained.
//! Pieces are bisected, the most promising first, until both bounds agree.

use crate::bernstein::Net;
use crate::{Aabb, BsplineCurve, BsplineSurface};
use nalgebra::{SVector, Vector1};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Most bisections per side of a box; a side whose extremum is attained along a whole curve needs
/// the most. The box then is a little larger than asked for, never smaller.
const MAX_STEPS: usize = 200_000;

/// One coordinate of a Bézier piece in homogeneous form, `values / weights`.
#[derive(Clone, Debug)]
struct Piece {
    values: Net<1>,
    weights: Net<1>,
    bound: f64,
}

impl PartialEq for Piece {
    fn eq(&self, other: &Self) -> bool {
        self.bound == other.bound
    }
}
impl Eq for Piece {}
impl PartialOrd for Piece {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Piece {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound)
    }
}

impl Piece {
    fn new(values: Net<1>, weights: Net<1>) -> Self {
        let ratios = values.values().iter().zip(weights.values()).map(|(a, w)| a.x / w.x);
        let bound = ratios.fold(f64::NEG_INFINITY, f64::max);
        Self { values, weights, bound }
    }

    fn ratio(&self, i: usize, j: usize) -> f64 {
        self.values.at(i, j).x / self.weights.at(i, j).x
    }

    /// Largest value at a corner.
    fn attained(&self) -> f64 {
        let [p, q] = self.values.degrees();
        self.ratio(0, 0).max(self.ratio(0, q)).max(self.ratio(p, 0)).max(self.ratio(p, q))
    }

    /// Largest second difference along each direction: how far the coefficients are from linear.
    fn bend(&self) -> [f64; 2] {
        let [p, q] = self.values.degrees();
        let second = |a: f64, b: f64, c: f64| (a - 2.0 * b + c).abs();
        let mut bend = [0.0_f64; 2];
        for i in 0..=p {
            for j in 0..=q {
                let here = self.ratio(i, j);
                if i + 2 <= p {
                    bend[0] = bend[0].max(second(here, self.ratio(i + 1, j), self.ratio(i + 2, j)));
                }
                if j + 2 <= q {
                    bend[1] = bend[1].max(second(here, self.ratio(i, j + 1), self.ratio(i, j + 2)));
                }
            }
        }
        bend
    }

    /// The two halves, cut across the direction that bends more.
    fn halves(mut self) -> [Self; 2] {
        let [p, q] = self.values.degrees();
        let [bend_u, bend_v] = self.bend();
        // No second difference: the bound may not be attained yet, when weights differ.
        let along_u = if bend_u == bend_v { p >= q } else { bend_u > bend_v };
        let left = self.values.split(along_u, 0.5);
        let left_weights = self.weights.split(along_u, 0.5);
        [Self::new(left, left_weights), Self::new(self.values, self.weights)]
    }
}

/// An upper bound of the largest value over all pieces, at most `tolerance` above it.
fn maximum(pieces: Vec<Piece>, tolerance: f64) -> f64 {
    let mut attained = pieces.iter().map(Piece::attained).fold(f64::NEG_INFINITY, f64::max);
    let mut heap = BinaryHeap::from(pieces);
    let mut steps = 0;
    while let Some(piece) = heap.pop() {
        if piece.bound <= attained + tolerance || steps == MAX_STEPS {
            return piece.bound.max(attained);
        }
        steps += 1;
        for half in piece.halves() {
            attained = attained.max(half.attained());
            heap.push(half);
        }
    }
    attained
}

/// One Bézier piece of a shape: degrees, points, weights.
type Bezier<const D: usize> = ([usize; 2], Vec<SVector<f64, D>>, Option<Vec<f64>>);

fn tight_box<const D: usize>(pieces: &[Bezier<D>], relative_tolerance: f64) -> Option<Aabb<D>> {
    let hull = Aabb::of_points(pieces.iter().flat_map(|piece| &piece.1))?;
    let tolerance = relative_tolerance.max(0.0) * hull.diagonal();
    // Values relative to the middle of the hull, so that far-off coordinates lose nothing.
    let centre = hull.centre();
    let side = |k: usize, sign: f64| {
        let scalar = |(degrees, points, weights): &Bezier<D>| {
            let weights = weights.clone().unwrap_or_else(|| vec![1.0; points.len()]);
            let values = points.iter().zip(&weights).map(|(p, w)| sign * (p[k] - centre[k]) * w);
            let values = values.map(Vector1::new).collect();
            let weights = weights.iter().map(|w| Vector1::new(*w)).collect();
            Piece::new(Net::new(*degrees, values), Net::new(*degrees, weights))
        };
        centre[k] + sign * maximum(pieces.iter().map(scalar).collect(), tolerance)
    };
    // Rounding in the subdivision is of this size; the box is to hold every point as evaluated.
    let slack = 4.0 * f64::EPSILON * (hull.diagonal() + centre.amax());
    let tight =
        Aabb { min: SVector::from_fn(|k, _| side(k, -1.0)), max: SVector::from_fn(|k, _| side(k, 1.0)) };
    Some(tight.inflated(slack))
}

impl<const D: usize> BsplineCurve<D> {
    /// The box of the control points: contains the curve, but not tightly.
    #[must_use]
    pub fn control_box(&self) -> Aabb<D> {
        let first = Aabb::of_point(self.control_points()[0]);
        self.control_points().iter().fold(first, |found, point| found.with_point(point))
    }

    /// The bounding box of the curve: contains it, and exceeds the smallest such box on no side by more
    /// than `relative_tolerance` (1e-9, say) of the diagonal of the control polygon's box.
    #[must_use]
    pub fn bounding_box(&self, relative_tolerance: f64) -> Aabb<D> {
        let pieces: Vec<_> = self
            .bezier_curves()
            .into_iter()
            .map(|c| ([0, c.control_points.len() - 1], c.control_points, c.weights))
            .collect();
        tight_box(&pieces, relative_tolerance).unwrap_or_else(|| self.control_box())
    }
}

impl BsplineSurface {
    /// The box of the control points: contains the surface, but not tightly.
    #[must_use]
    pub fn control_box(&self) -> Aabb<3> {
        let first = Aabb::of_point(self.control_points()[0]);
        self.control_points().iter().fold(first, |found, point| found.with_point(point))
    }

    /// The bounding box of the surface: contains it, and exceeds the smallest such box on no side by
    /// more than `relative_tolerance` (1e-9, say) of the diagonal of the control net's box.
    #[must_use]
    pub fn bounding_box(&self, relative_tolerance: f64) -> Aabb<3> {
        let pieces: Vec<_> =
            self.bezier_patches().into_iter().map(|p| (p.degrees, p.control_points, p.weights)).collect();
        tight_box(&pieces, relative_tolerance).unwrap_or_else(|| self.control_box())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector2, Vector3};

    #[test]
    fn parabola_and_quarter_circle() {
        let points = vec![Vector2::new(0.0, 0.0), Vector2::new(1.0, 2.0), Vector2::new(2.0, 0.0)];
        let parabola = BsplineCurve::bezier(points, None).unwrap();
        let tight = parabola.bounding_box(1e-12);
        assert!((tight.max - Vector2::new(2.0, 1.0)).norm() < 1e-11 && tight.min.norm() < 1e-14);
        assert_eq!(parabola.control_box().max.y, 2.0);
        let s = 0.5_f64.sqrt();
        let points = vec![Vector2::new(s, -s), Vector2::new(2.0 * s, 0.0), Vector2::new(s, s)];
        let arc = BsplineCurve::bezier(points, Some(vec![1.0, s, 1.0])).unwrap();
        let tight = arc.bounding_box(1e-12);
        assert!((tight.max - Vector2::new(1.0, s)).norm() < 1e-11, "{tight:?}");
    }

    #[test]
    fn saddle_patch_far_from_the_origin() {
        let far = 1e6;
        let z = [[0.0, 1.0, 0.0], [-1.0, 0.0, -1.0], [0.0, 1.0, 0.0]];
        let points = (0..9).map(|k| Vector3::new((k / 3) as f64, (k % 3) as f64, far + z[k / 3][k % 3]));
        let knots = crate::KnotVector::bezier(2, crate::Interval::UNIT).unwrap();
        let patch = BsplineSurface::new(knots.clone(), knots, points.collect(), None).unwrap();
        let tight = patch.bounding_box(1e-9);
        assert!((tight.max.z - far - 0.5).abs() < 4e-9 && (tight.min.z - far + 0.5).abs() < 4e-9);
    }
}
