//! Convex hulls in space, with exact predicates.

mod faces;
mod flat;
mod grow;
mod predicates;
mod simplex;

use crate::Error;
use nalgebra::Vector3;
use predicates::Scaled;
use simplex::Start;

/// The convex hull of points in space, of whatever dimension it is.
///
/// Built with conflict lists, the farthest point first (\[BDH96\]); every decision is the exact sign of a determinant, so
/// that flat, duplicate and collinear input of any size gives the hull and not an approximation of it. A point in the plane
/// of a face counts as not beyond it: points inside faces and edges of the hull may or may not be among its vertices.
///
/// ```
/// use cloud_param::ConvexHull;
/// use nalgebra::Vector3;
///
/// let corners = (0..8).map(|i| Vector3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)));
/// let points: Vec<_> = corners.chain([Vector3::repeat(0.5)]).collect();
/// let hull = ConvexHull::new(&points)?;
/// assert_eq!((hull.dimension(), hull.vertices().len(), hull.faces().len()), (3, 8, 12));
/// assert!((hull.volume(&points) - 1.0).abs() < 1e-15);
/// # Ok::<(), cloud_param::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexHull {
    dimension: usize,
    vertices: Vec<u32>,
    faces: Vec<[u32; 3]>,
}

impl ConvexHull {
    /// The hull of finite points.
    ///
    /// # Errors
    /// [`Error::TooFewPoints`] for no points, [`Error::TooManyPoints`], [`Error::NotFinite`].
    pub fn new(points: &[Vector3<f64>]) -> Result<Self, Error> {
        if points.is_empty() {
            return Err(Error::TooFewPoints { total: 0, usable: 0, needed: 1 });
        }
        if points.len() >= u32::MAX as usize {
            return Err(Error::TooManyPoints { count: points.len() });
        }
        if let Some(index) = points.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
            return Err(Error::NotFinite { index });
        }
        let scaled = Scaled::new(points);
        Ok(match Start::find(&scaled) {
            Start::Point(a) => Self { dimension: 0, vertices: vec![a], faces: Vec::new() },
            Start::Segment(ends) => Self { dimension: 1, vertices: ends.to_vec(), faces: Vec::new() },
            Start::Triangle(corners) => {
                Self { dimension: 2, vertices: flat::polygon(&scaled, corners), faces: Vec::new() }
            }
            Start::Tetrahedron(corners) => {
                let faces = grow::faces(&scaled, corners);
                let mut vertices: Vec<u32> = faces.iter().flatten().copied().collect();
                vertices.sort_unstable();
                vertices.dedup();
                Self { dimension: 3, vertices, faces }
            }
        })
    }

    /// 0 for a point, 1 for a segment, 2 for a polygon, 3 for a solid.
    #[must_use]
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Indices of the vertices: in ascending order for a solid, in their order around a polygon.
    #[must_use]
    pub fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// The triangles of a solid, anticlockwise seen from outside; none in lower dimensions.
    #[must_use]
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// The volume, `points` being those of the hull.
    #[must_use]
    pub fn volume(&self, points: &[Vector3<f64>]) -> f64 {
        let Some(&first) = self.vertices.first() else { return 0.0 };
        let centre = points[first as usize];
        let corner = |i: u32| points[i as usize] - centre;
        self.faces.iter().map(|&[a, b, c]| corner(a).dot(&corner(b).cross(&corner(c)))).sum::<f64>() / 6.0
    }
}
