//! Height fields as uniform bicubic splines.

use super::lattice::{Lattice, basis, locate, slopes};
use crate::Error;
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, Interval, KnotVector};

/// A smooth function `z = f(x, y)` on a rectangle: a uniform bicubic spline.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightField {
    domain: [Interval; 2],
    lattice: Lattice,
}

impl HeightField {
    pub(super) fn new(domain: [Interval; 2], lattice: Lattice) -> Self {
        Self { domain, lattice }
    }

    /// The rectangle, `x` and `y`.
    #[must_use]
    pub fn domain(&self) -> [Interval; 2] {
        self.domain
    }

    /// Number of polynomial pieces in `x` and `y`.
    #[must_use]
    pub fn spans(&self) -> [usize; 2] {
        self.lattice.spans()
    }

    /// The height at `(x, y)`; outside the rectangle the outermost pieces are continued.
    #[must_use]
    pub fn value(&self, x: f64, y: f64) -> f64 {
        let ([x, y], _) = self.to_lattice(x, y);
        self.lattice.value(x, y)
    }

    /// The slopes `∂f/∂x` and `∂f/∂y`.
    #[must_use]
    pub fn gradient(&self, x: f64, y: f64) -> [f64; 2] {
        let ([x, y], scale) = self.to_lattice(x, y);
        let [m, n] = self.lattice.spans();
        let ((i, s), (j, t)) = (locate(x, m), locate(y, n));
        [
            scale[0] * self.lattice.combine(i, j, &slopes(s), &basis(t)),
            scale[1] * self.lattice.combine(i, j, &basis(s), &slopes(t)),
        ]
    }

    fn to_lattice(&self, x: f64, y: f64) -> ([f64; 2], [f64; 2]) {
        let [m, n] = self.lattice.spans();
        let scale = [m as f64 / self.domain[0].length(), n as f64 / self.domain[1].length()];
        ([(x - self.domain[0].start()) * scale[0], (y - self.domain[1].start()) * scale[1]], scale)
    }

    /// The graph as a surface `(u, v) ↦ (u, v, f(u, v))`, exactly: cubic, with uniform knots that go on beyond the ends of
    /// the domain.
    ///
    /// # Errors
    /// When a coordinate overflows.
    pub fn to_surface(&self) -> Result<BsplineSurface, Error> {
        let spans = self.lattice.spans();
        let place = |axis: usize, i: f64| {
            let side = self.domain[axis];
            side.start() + side.length() * (i / spans[axis] as f64)
        };
        let knots = |axis: usize| {
            let count = spans[axis];
            let values = (0..count + 7)
                .map(|i| if i == count + 3 { self.domain[axis].end() } else { place(axis, i as f64 - 3.0) });
            KnotVector::new(3, values.collect())
        };
        let width = spans[1] + 3;
        let point = |(k, &z): (usize, &f64)| {
            Vector3::new(place(0, (k / width) as f64 - 1.0), place(1, (k % width) as f64 - 1.0), z)
        };
        let net = self.lattice.values.iter().enumerate().map(point).collect();
        Ok(BsplineSurface::new(knots(0)?, knots(1)?, net, None)?)
    }
}
