//! Normals of the faces and vertices of a mesh.

use nalgebra::Vector3;

use super::unit;
use crate::TriangleMesh;
use crate::triangle::Triangle;

/// Unit normals, one per face or vertex.
#[derive(Debug, Clone, PartialEq)]
pub struct Normals {
    /// The normals; zero where there is none.
    pub normals: Vec<Vector3<f64>>,
    /// How many are zero.
    pub undefined: usize,
}

impl Normals {
    pub(crate) fn of(directions: impl Iterator<Item = Vector3<f64>>) -> Self {
        let normals: Vec<_> = directions.map(|vector| unit(&vector).unwrap_or_else(Vector3::zeros)).collect();
        let undefined = normals.iter().filter(|&&normal| normal == Vector3::zeros()).count();
        Self { normals, undefined }
    }
}

impl TriangleMesh {
    /// Unit normals of the triangles, on the side from which their corners run counter-clockwise.
    ///
    /// Triangles without area or with a vertex that is not finite have none.
    #[must_use]
    pub fn face_normals(&self) -> Normals {
        Normals::of(self.area_vectors())
    }

    /// Unit normals of the vertices: those of the faces around, weighted by their angles at the vertex (\[BA05\]).
    ///
    /// Vertices at exactly the same position have the same normal. Vertices of no triangle with area have none, and
    /// neither have those around which the faces cancel out.
    #[must_use]
    pub fn vertex_normals(&self) -> Normals {
        let first = self.coincident_vertices();
        let mut sums = vec![Vector3::zeros(); self.vertices().len()];
        for indices in self.triangles() {
            let shape = Triangle(self.positions_of(indices));
            let Some(normal) = unit(&shape.area_vector()) else { continue };
            for (corner, &vertex) in indices.iter().enumerate() {
                sums[first[vertex as usize] as usize] += normal * shape.angle(corner);
            }
        }
        Normals::of(first.iter().map(|&vertex| sums[vertex as usize]))
    }
}
