//! Rectangles in planes.

use super::{Frame, SurfaceFoot};
use crate::{BsplineSurface, Error, Interval, KnotVector, ParametricSurface, SurfaceJet};
use nalgebra::Vector3;

/// A rectangle in the plane of the `x` and `y` axes of a frame, `s(u, v) = m + u x + v y`.
///
/// The parameters are lengths; the normal is the `z` axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    frame: Frame,
    u: Interval,
    v: Interval,
}

impl Plane {
    /// The rectangle over the given intervals.
    #[must_use]
    pub fn new(frame: Frame, u: Interval, v: Interval) -> Self {
        Self { frame, u, v }
    }

    /// Position; `z` is the normal.
    #[must_use]
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// The closest point of the rectangle.
    #[must_use]
    pub fn footpoint(&self, x: &Vector3<f64>) -> SurfaceFoot {
        let local = self.frame.local(x);
        let (u, v) = (self.u.clamp(local.x), self.v.clamp(local.y));
        let point = self.point(u, v);
        SurfaceFoot { parameters: [u, v], point, distance: (x - point).norm() }
    }

    /// The rectangle as a B-spline surface of degree 1 × 1 with the same parameters.
    ///
    /// # Errors
    /// None, unless coordinates overflow.
    pub fn to_nurbs(&self) -> Result<BsplineSurface, Error> {
        let ends = |i: Interval| [i.start(), i.end()];
        let points = ends(self.u).into_iter().flat_map(|u| ends(self.v).map(|v| self.point(u, v))).collect();
        BsplineSurface::new(KnotVector::bezier(1, self.u)?, KnotVector::bezier(1, self.v)?, points, None)
    }
}

impl ParametricSurface for Plane {
    fn domain(&self) -> [Interval; 2] {
        [self.u, self.v]
    }

    fn jet(&self, u: f64, v: f64) -> SurfaceJet {
        let zero = Vector3::zeros();
        SurfaceJet {
            point: self.frame.point(&Vector3::new(u, v, 0.0)),
            du: self.frame.x(),
            dv: self.frame.y(),
            duu: zero,
            duv: zero,
            dvv: zero,
        }
    }
}
