//! Points of a mesh as vertices.

use crate::Error;
use mesh_core::{MeshProjector, TriangleMesh};
use nalgebra::{Point3, Vector3};

/// Share of a triangle below which a point lies on its side, or in its corner.
const ON_SIDE: f64 = 1e-9;

/// A mesh with one vertex more, or the given one where the point is a vertex already.
#[derive(Clone, Debug)]
pub struct InsertedPoint {
    /// The mesh; vertices keep their numbers, and normals are interpolated.
    pub mesh: TriangleMesh,
    /// The vertex at the point.
    pub vertex: usize,
    /// Distance of the given point from the mesh.
    pub distance: f64,
}

/// Makes the nearest point of a mesh a vertex: the triangle around it, or the triangles beside its edge, are split.
///
/// # Errors
/// [`Error::Mesh`] if the point is not finite or the mesh cannot be projected onto.
pub fn insert_point(mesh: &TriangleMesh, point: &Point3<f64>) -> Result<InsertedPoint, Error> {
    let found = MeshProjector::new(mesh)?.project(point)?;
    let triangle = mesh.triangles()[found.triangle];
    let weights = found.barycentric;
    let distance = (found.point - point).norm();
    if let Some(corner) = weights.iter().position(|weight| *weight > 1.0 - ON_SIDE) {
        return Ok(InsertedPoint { mesh: mesh.clone(), vertex: triangle[corner] as usize, distance });
    }
    let mut vertices = mesh.vertices().to_vec();
    let new = u32::try_from(vertices.len()).unwrap_or(u32::MAX);
    let mut triangles = mesh.triangles().to_vec();
    vertices.push(found.point);
    match weights.iter().position(|weight| *weight < ON_SIDE) {
        Some(corner) => {
            // All triangles beside the edge, whichever vertices at its ends they refer to.
            let [a, b] = [1, 2].map(|k| mesh.vertices()[triangle[(corner + k) % 3] as usize]);
            let before = std::mem::take(&mut triangles);
            for [x, y, z] in before {
                let sides = [[x, y, z], [y, z, x], [z, x, y]];
                let side = sides.into_iter().find(|[from, to, _]| {
                    let ends = [*from, *to].map(|index| mesh.vertices()[index as usize]);
                    ends == [a, b] || ends == [b, a]
                });
                match side {
                    Some([from, to, apex]) => triangles.extend([[from, new, apex], [new, to, apex]]),
                    None => triangles.push([x, y, z]),
                }
            }
        }
        None => {
            let [a, b, c] = triangle;
            triangles[found.triangle] = [a, b, new];
            triangles.extend([[b, c, new], [c, a, new]]);
        }
    }
    let mut inserted = TriangleMesh::new(vertices, triangles)?;
    if let Some(normals) = mesh.attributes().normals() {
        let sum: Vector3<f64> =
            triangle.iter().zip(weights).map(|(&index, weight)| normals[index as usize] * weight).sum();
        let (cloud, triangles) = inserted.into_parts();
        let normals = normals.iter().copied().chain([sum]).collect();
        inserted = TriangleMesh::from_cloud(cloud.with_normals(normals)?, triangles)?;
    }
    Ok(InsertedPoint { mesh: inserted, vertex: new as usize, distance })
}
