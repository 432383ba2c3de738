//! Where a straight line meets a triangle mesh.

use crate::bounds::is_finite;
use crate::triangle::Triangle;
use crate::{Error, MeshProjector};
use nalgebra::{Point3, Vector3};

/// A point that a line and a mesh have in common.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineHit {
    /// Index of the triangle; the smallest where several are equally near.
    pub triangle: usize,
    /// Weights of the triangle's corners: not negative, their sum is 1 up to rounding.
    pub barycentric: [f64; 3],
    /// The point, on the triangle up to rounding.
    pub point: Point3<f64>,
    /// Signed length from the origin of the line to the point, along the direction.
    pub offset: f64,
    /// Unit normal of the triangle.
    pub normal: Vector3<f64>,
}

impl MeshProjector {
    /// The point nearest to `origin` in which the line through it along `direction` (of any length, either sense) meets
    /// the mesh; `None` where it does not.
    ///
    /// Exact up to rounding, and without leaks: a line that passes through an edge or a corner meets a triangle there
    /// (the test of \[WBW13\]). Triangles that contain the direction are not met.
    ///
    /// ```
    /// use mesh_core::{MeshProjector, TriangleMesh, nalgebra::{Point3, Vector3}};
    ///
    /// let corners = vec![Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 0.0)];
    /// let mesh = MeshProjector::new(&TriangleMesh::new(corners, vec![[0, 1, 2]])?)?;
    /// let hit = mesh.nearest_on_line(&Point3::new(0.25, 0.25, 2.0), &Vector3::new(0.0, 0.0, 3.0))?;
    /// assert_eq!(hit.map(|hit| hit.offset), Some(-2.0));
    /// assert_eq!(mesh.nearest_on_line(&Point3::new(0.25, 0.25, 2.0), &Vector3::x())?, None);
    /// # Ok::<(), mesh_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::NonFinitePoint`] if a coordinate of `origin` or `direction` is NaN or infinite, or `direction` is zero.
    pub fn nearest_on_line(
        &self,
        origin: &Point3<f64>,
        direction: &Vector3<f64>,
    ) -> Result<Option<LineHit>, Error> {
        self.nearest_on_line_where(origin, direction, |_| true, |_| true)
    }

    /// The same among the nodes of the hierarchy and the triangles, by their places, that are kept.
    pub(crate) fn nearest_on_line_where(
        &self,
        origin: &Point3<f64>,
        direction: &Vector3<f64>,
        keeps_node: impl Fn(usize) -> bool,
        keeps: impl Fn(usize) -> bool,
    ) -> Result<Option<LineHit>, Error> {
        if !is_finite(origin) {
            return Err(Error::NonFinitePoint { x: origin.x, y: origin.y, z: origin.z });
        }
        let largest = direction.amax();
        // The largest component first: squares of tiny or huge ones would vanish or overflow.
        let unit = (largest.is_finite() && largest > 0.0).then(|| (direction / largest).normalize());
        let Some(unit) = unit.filter(|unit| unit.iter().all(|value| value.is_finite())) else {
            return Err(Error::NonFinitePoint { x: direction.x, y: direction.y, z: direction.z });
        };
        let line = Line::new(*origin, unit);
        let mut best: Option<(usize, Crossing)> = None;
        let mut limit = f64::INFINITY;
        self.bvh.along_line(origin, &unit.into(), keeps_node, |place| {
            if let Some(crossing) = line.crossing(&self.triangles[place]).filter(|_| keeps(place)) {
                let size = crossing.offset.abs();
                let tied =
                    |best: &(usize, Crossing)| size == limit && self.indices[place] < self.indices[best.0];
                if size < limit || best.as_ref().is_some_and(tied) {
                    limit = size;
                    best = Some((place, crossing));
                }
            }
            limit
        });
        Ok(best.map(|(place, crossing)| {
            let Triangle([a, b, c]) = self.triangles[place];
            let [_, s, t] = crossing.barycentric;
            LineHit {
                triangle: self.indices[place] as usize,
                barycentric: crossing.barycentric,
                point: a + (b - a) * s + (c - a) * t,
                offset: crossing.offset,
                normal: self.triangles[place].unit_normal(),
            }
        }))
    }
}

/// A line, prepared for tests against triangles: the axis along which it runs fastest, and shears that make it that axis.
struct Line {
    origin: Point3<f64>,
    axes: [usize; 3],
    shear: [f64; 2],
    scale: f64,
}

/// Where a line meets a triangle.
struct Crossing {
    barycentric: [f64; 3],
    offset: f64,
}

impl Line {
    fn new(origin: Point3<f64>, unit: Vector3<f64>) -> Self {
        let fastest = unit.iamax();
        let axes = [(fastest + 1) % 3, (fastest + 2) % 3, fastest];
        let along = unit[fastest];
        Self { origin, axes, shear: [unit[axes[0]] / along, unit[axes[1]] / along], scale: 1.0 / along }
    }

    /// \[WBW13\]: signs of areas in the plane across the line, computed in the same way from both sides of an edge.
    fn crossing(&self, triangle: &Triangle) -> Option<Crossing> {
        let [a, b, c] = triangle.0.map(|corner| {
            let relative = corner - self.origin;
            let height = relative[self.axes[2]];
            [
                relative[self.axes[0]] - self.shear[0] * height,
                relative[self.axes[1]] - self.shear[1] * height,
                height * self.scale,
            ]
        });
        let area = |p: &[f64; 3], q: &[f64; 3]| p[0] * q[1] - p[1] * q[0];
        let weights = [area(&b, &c), area(&c, &a), area(&a, &b)];
        let negative = weights.iter().any(|&weight| weight < 0.0);
        let positive = weights.iter().any(|&weight| weight > 0.0);
        let total: f64 = weights.iter().sum();
        // Also false for NaN.
        if negative && positive || !(total.abs() > 0.0 && total.is_finite()) {
            return None;
        }
        let barycentric = weights.map(|weight| weight / total);
        let offset = barycentric[0] * a[2] + barycentric[1] * b[2] + barycentric[2] * c[2];
        Some(Crossing { barycentric, offset })
    }
}
