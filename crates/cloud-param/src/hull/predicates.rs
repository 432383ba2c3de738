//! Exact orientation of points (the only file that knows `robust`).

use nalgebra::Vector3;
use robust::{Coord, Coord3D, orient2d, orient3d};

/// Points scaled by a power of two to coordinates of at most 1, where products neither overflow nor lose digits.
#[derive(Debug)]
pub(super) struct Scaled {
    pub(super) points: Vec<Vector3<f64>>,
    /// Largest extent along an axis.
    pub(super) extent: f64,
}

impl Scaled {
    pub(super) fn new(points: &[Vector3<f64>]) -> Self {
        let largest = points.iter().flat_map(|p| p.iter()).fold(0.0f64, |m, c| m.max(c.abs()));
        #[expect(clippy::cast_possible_truncation, reason = "exponents of doubles are below 1100")]
        let exponent = if largest > 0.0 { largest.log2().ceil() as i32 } else { 0 };
        // Two steps: one alone may overflow.
        let (first, second) = (-exponent / 2, -exponent - -exponent / 2);
        let scale = |c: f64| c * 2f64.powi(first) * 2f64.powi(second);
        let points: Vec<_> = points.iter().map(|p| p.map(scale)).collect();
        let (mut low, mut high) = (points[0], points[0]);
        for p in &points {
            low = low.inf(p);
            high = high.sup(p);
        }
        let extent = (high - low).max();
        Self { points, extent }
    }

    fn at(&self, i: u32) -> Coord3D<f64> {
        let p = &self.points[i as usize];
        Coord3D { x: p.x, y: p.y, z: p.z }
    }

    /// Positive if `d` lies on the side of the plane `abc` from which they appear anticlockwise.
    pub(super) fn side(&self, [a, b, c]: [u32; 3], d: u32) -> f64 {
        -orient3d(self.at(a), self.at(b), self.at(c), self.at(d))
    }

    /// Positive if `abc` turns to the left in the projection that leaves out `axis`.
    pub(super) fn turn(&self, axis: usize, [a, b, c]: [u32; 3]) -> f64 {
        let at = |i: u32| {
            let p = &self.points[i as usize];
            Coord { x: p[(axis + 1) % 3], y: p[(axis + 2) % 3] }
        };
        orient2d(at(a), at(b), at(c))
    }

    /// Whether three points lie on a line.
    pub(super) fn is_collinear(&self, abc: [u32; 3]) -> bool {
        (0..3).all(|axis| self.turn(axis, abc) == 0.0)
    }
}
