//! The triangles of a growing hull.

use super::predicates::Scaled;
use nalgebra::Vector3;

/// No index.
pub(super) const NONE: u32 = u32::MAX;

/// A triangle, anticlockwise from outside, with its neighbours and the points beyond it.
#[derive(Clone, Debug)]
pub(super) struct Face {
    pub(super) corners: [u32; 3],
    /// `neighbours[k]` lies across the edge from corner `k` to the next.
    pub(super) neighbours: [u32; 3],
    normal: Vector3<f64>,
    base: Vector3<f64>,
    /// Values of the plane with smaller size have no certain sign.
    uncertain: f64,
    /// First of the points beyond, a linked list.
    pub(super) first: u32,
    /// The farthest of them, and how far (in units of the normal).
    pub(super) farthest: (u32, f64),
    pub(super) alive: bool,
}

impl Face {
    pub(super) fn new(scaled: &Scaled, corners: [u32; 3], neighbours: [u32; 3]) -> Self {
        let [a, b, c] = corners.map(|i| scaled.points[i as usize]);
        let (e, f) = (b - a, c - a);
        let normal = e.cross(&f);
        let (e, f) = (e.abs(), f.abs());
        let size = e.y * f.z + e.z * f.y + e.z * f.x + e.x * f.z + e.x * f.y + e.y * f.x;
        // Each of the products of three differences errs by less than 8 roundings; the factor leaves room.
        let uncertain = 32.0 * f64::EPSILON * size * scaled.extent;
        Self {
            corners,
            neighbours,
            normal,
            base: a,
            uncertain,
            first: NONE,
            farthest: (NONE, 0.0),
            alive: true,
        }
    }

    /// Whether a point lies beyond the plane of the face, and roughly how far.
    #[inline]
    pub(super) fn beyond(&self, scaled: &Scaled, point: u32) -> Option<f64> {
        let x = &scaled.points[point as usize];
        let value = self.normal.dot(&(x - self.base));
        if value > self.uncertain {
            Some(value)
        } else if value < -self.uncertain {
            None
        } else {
            (scaled.side(self.corners, point) > 0.0).then_some(value.max(0.0))
        }
    }

    /// Puts a point that lies beyond into the list.
    #[inline]
    pub(super) fn push(&mut self, point: u32, distance: f64, next: &mut [u32]) {
        next[point as usize] = self.first;
        self.first = point;
        if self.farthest.0 == NONE || distance > self.farthest.1 {
            self.farthest = (point, distance);
        }
    }

    /// The edge that leads to a neighbour: its start, end, and the neighbour.
    pub(super) fn edge(&self, k: usize) -> (u32, u32, u32) {
        (self.corners[k], self.corners[(k + 1) % 3], self.neighbours[k])
    }
}
