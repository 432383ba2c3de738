//! The limit surface as a parametric surface over the control triangles.

use super::limit_patch::{Kinds, LimitPatch};
use super::scheme::LoopScheme;
use crate::{Error, TriangleMesh};
use nalgebra::{Point3, Vector3};

/// A point of the limit surface with its derivatives by the barycentric coordinates `v` and `w` of a control triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitJet {
    /// The point.
    pub position: Point3<f64>,
    /// First derivatives, by `v` and `w`.
    pub first: [Vector3<f64>; 2],
    /// Second derivatives, by `vv`, `vw`, `ww`.
    pub second: [Vector3<f64>; 3],
}

/// The limit surface of Loop's scheme, evaluated anywhere without subdivision (\[Lo87, St98\]).
///
/// Over control triangle `f` with the corners `a`, `b`, `c` a place is told by its barycentric coordinates `v` (at `b`) and
/// `w` (at `c`). Regular triangles are quartic box splines; at vertices with another number of neighbours than six, and on
/// boundaries, the subdivision matrix of the corner is applied as often as needed, so that the result is that of infinite
/// subdivision to rounding errors. The surface is twice continuously differentiable except at irregular vertices: there
/// first derivatives vanish or grow with the way to the vertex, as the parameters do not fit the surface, while
/// [`LoopScheme::limit`] knows point and normal.
///
/// ```
/// use mesh_core::{LoopSurface, TriangleMesh, nalgebra::Point3};
///
/// let corners = [[1., 1., 1.], [1., -1., -1.], [-1., 1., -1.], [-1., -1., 1.]].map(Point3::from);
/// let tetrahedron = TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])?;
/// let surface = LoopSurface::new(&tetrahedron)?;
/// let middle = surface.jet(0, [1.0 / 3.0; 2]).unwrap();
/// let normal = middle.first[0].cross(&middle.first[1]).normalize();
/// assert!((normal.dot(&middle.position.coords.normalize()) - 1.0).abs() < 1e-12);
/// # Ok::<(), mesh_core::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct LoopSurface {
    positions: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
    patches: Vec<LimitPatch>,
    kinds: Kinds,
}

impl LoopSurface {
    /// Prepares a control mesh; vertices at exactly the same position count as one.
    ///
    /// # Errors
    /// [`Error::Subdivision`] when the mesh is not an oriented manifold or has a vertex with less than three neighbours
    /// inside.
    pub fn new(mesh: &TriangleMesh) -> Result<Self, Error> {
        let scheme = LoopScheme::new(mesh);
        let connectivity = scheme.connectivity();
        if !connectivity.defects().is_empty() {
            return Err(Error::Subdivision { what: "the control mesh is not an oriented manifold" });
        }
        let triangles = connectivity.triangles().to_vec();
        let mut kinds = Kinds::default();
        let mut patches = Vec::with_capacity(triangles.len());
        for &triangle in &triangles {
            if !triangle.iter().all(|&vertex| scheme.is_smooth(vertex)) {
                return Err(Error::Subdivision { what: "a vertex has too few neighbours" });
            }
            patches.push(LimitPatch::new(connectivity, triangle, &mut kinds)?);
        }
        Ok(Self { positions: scheme.positions().to_vec(), triangles, patches, kinds })
    }

    /// The control triangles, by the numbers of their vertices.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The control vertices.
    #[must_use]
    pub fn positions(&self) -> &[Point3<f64>] {
        &self.positions
    }

    /// Moves the control vertices; the connectivity stays.
    ///
    /// # Errors
    /// [`Error::AttributeLength`] unless there is one position per vertex.
    pub fn set_positions(&mut self, positions: &[Point3<f64>]) -> Result<(), Error> {
        if positions.len() != self.positions.len() {
            let name = "positions".to_owned();
            return Err(Error::AttributeLength {
                name,
                found: positions.len(),
                expected: self.positions.len(),
            });
        }
        self.positions.copy_from_slice(positions);
        Ok(())
    }

    /// The control vertices that act on a triangle, in the order of [`weights`](Self::weights); small meshes may name one
    /// more than once. `None` if the triangle does not exist.
    #[must_use]
    pub fn acting(&self, triangle: usize) -> Option<&[u32]> {
        Some(&self.patches.get(triangle)?.vertices)
    }

    /// The weights of the [acting](Self::acting) vertices in the point at `(v, w)`, and in its derivatives by `v`, `w`, `vv`,
    /// `vw`, `ww`. Empty if the triangle does not exist; coordinates outside the triangle are no error, but mean nothing.
    pub fn weights(&self, triangle: usize, at: [f64; 2], out: &mut Vec<[f64; 6]>) {
        out.clear();
        if let Some(patch) = self.patches.get(triangle) {
            patch.weights(&self.kinds.kinds, at, out);
        }
    }

    /// Point and derivatives at `(v, w)`. `None` if the triangle does not exist.
    #[must_use]
    pub fn jet(&self, triangle: usize, at: [f64; 2]) -> Option<LimitJet> {
        let patch = self.patches.get(triangle)?;
        let mut weights = Vec::new();
        self.weights(triangle, at, &mut weights);
        // Relative to a control vertex: weights sum to one or zero but for rounding.
        let origin = self.positions[*patch.vertices.first()? as usize];
        let mut sums = [Vector3::zeros(); 6];
        for (&vertex, weight) in patch.vertices.iter().zip(&weights) {
            let arm = self.positions[vertex as usize] - origin;
            for (sum, weight) in sums.iter_mut().zip(weight) {
                *sum += arm * *weight;
            }
        }
        let [point, v, w, vv, vw, ww] = sums;
        Some(LimitJet { position: origin + point, first: [v, w], second: [vv, vw, ww] })
    }
}
