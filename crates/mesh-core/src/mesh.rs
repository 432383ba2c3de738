//! Triangle meshes.

use nalgebra::{Point3, Vector3};

use crate::bounds::is_finite;
use crate::triangle::Triangle;
use crate::{Attributes, BoundingBox, Error, MeshTopology, PointCloud, VertexWelder, seams};

/// Which vertices of a mesh are one corner.
#[derive(Debug, Clone, PartialEq)]
pub struct Weld {
    /// For every vertex the first vertex that is the same corner; itself where there is none before it.
    pub first: Vec<u32>,
    /// Number of positions that were joined with another that differs from it by rounding.
    pub joined: usize,
    /// The largest difference of a coordinate between such positions.
    pub largest_gap: f64,
}

/// Triangles over shared vertices, with attributes per vertex.
///
/// Every index refers to a vertex; the constructor sees to it. Nothing else is promised: triangles may be
/// degenerate, vertices unused or not finite, the surface open or tangled ([`TriangleMesh::topology`] tells).
#[derive(Debug, Clone, PartialEq)]
pub struct TriangleMesh {
    vertices: PointCloud,
    triangles: Vec<[u32; 3]>,
}

impl TriangleMesh {
    /// A mesh without attributes.
    ///
    /// # Errors
    /// [`Error::VertexIndex`] for a triangle that refers to a missing vertex, [`Error::TooMany`] beyond 32-bit indices.
    pub fn new(vertices: Vec<Point3<f64>>, triangles: Vec<[u32; 3]>) -> Result<Self, Error> {
        Self::from_cloud(PointCloud::new(vertices), triangles)
    }

    /// A mesh over the points of a cloud, whose attributes it takes over.
    ///
    /// # Errors
    /// As [`TriangleMesh::new`].
    pub fn from_cloud(vertices: PointCloud, triangles: Vec<[u32; 3]>) -> Result<Self, Error> {
        for (what, count) in [("vertices", vertices.len()), ("triangles", triangles.len())] {
            // The largest index is kept free to mean "none".
            if u32::try_from(count).is_err() {
                return Err(Error::TooMany { what, count });
            }
        }
        for (triangle, corners) in triangles.iter().enumerate() {
            for (corner, &index) in corners.iter().enumerate() {
                if index as usize >= vertices.len() {
                    return Err(Error::VertexIndex { triangle, corner, index, vertices: vertices.len() });
                }
            }
        }
        Ok(Self { vertices, triangles })
    }

    /// Replaces all vertex attributes.
    ///
    /// # Errors
    /// [`Error::AttributeLength`] if an attribute has not one value per vertex.
    pub fn with_attributes(self, attributes: Attributes) -> Result<Self, Error> {
        Ok(Self { vertices: self.vertices.with_attributes(attributes)?, triangles: self.triangles })
    }

    /// Other triangles over the same vertices; every index refers to one of them.
    pub(crate) fn with_triangles(&self, triangles: Vec<[u32; 3]>) -> Self {
        Self { vertices: self.vertices.clone(), triangles }
    }

    /// The vertices.
    #[must_use]
    pub fn vertices(&self) -> &[Point3<f64>] {
        self.vertices.positions()
    }

    /// Vertex indices of the triangles; counter-clockwise seen from outside in well-kept files.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The attributes of the vertices.
    #[must_use]
    pub const fn attributes(&self) -> &Attributes {
        self.vertices.attributes()
    }

    /// The vertices with their attributes.
    #[must_use]
    pub const fn cloud(&self) -> &PointCloud {
        &self.vertices
    }

    /// Vertices and triangles, taken apart.
    #[must_use]
    pub fn into_parts(self) -> (PointCloud, Vec<[u32; 3]>) {
        (self.vertices, self.triangles)
    }

    /// Positions of the three corners of a triangle, if it exists.
    #[must_use]
    pub fn corners(&self, triangle: usize) -> Option<[Point3<f64>; 3]> {
        self.triangles.get(triangle).map(|corners| self.positions_of(corners))
    }

    /// The smallest box around the vertices with finite coordinates; `None` if there is none.
    #[must_use]
    pub fn bounding_box(&self) -> Option<BoundingBox> {
        self.vertices.bounding_box()
    }

    /// Number of vertices with a coordinate that is NaN or infinite.
    #[must_use]
    pub fn count_non_finite(&self) -> usize {
        self.vertices.count_non_finite()
    }

    /// Drops the vertices that are not finite and the triangles that use them; returns the number of vertices dropped.
    pub fn retain_finite(&mut self) -> usize {
        let mut renumbered = Vec::with_capacity(self.vertices.len());
        let mut next = 0u32;
        for vertex in self.vertices.positions() {
            let keep = is_finite(vertex);
            renumbered.push(keep.then_some(next));
            next += u32::from(keep);
        }
        let dropped = self.vertices.retain_finite();
        if dropped > 0 {
            let corner = |index: u32| renumbered.get(index as usize).copied().flatten();
            self.triangles = (self.triangles.iter())
                .filter_map(|&[a, b, c]| Some([corner(a)?, corner(b)?, corner(c)?]))
                .collect();
        }
        dropped
    }

    /// Which vertices are one corner: those at exactly the same position (zeros of either sign are the same), and those
    /// along open edges that differ by no more than the rounding of the coordinates.
    ///
    /// Files without shared vertices, such as STL, and files that repeat vertices for the sake of normals or texture
    /// become connected when triangles are read through this map. Rounding is 1e-9 of the diagonal;
    /// for singles two units in the last place, or 1e-7 of the largest coordinate; one unit of the last decimal or digit
    /// where the coordinates are written with 6 to 9 of them. Two open edges are joined where both ends agree; never so that a triangle loses its area, that two sides
    /// of a thin sheet become one, or that more than two triangles meet. O(n log n).
    ///
    /// ```
    /// use mesh_core::{TriangleMesh, nalgebra::Point3};
    ///
    /// let [a, b, c] = [Point3::new(0.0, 0.0, 0.0), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 0.0)];
    /// let (d, e) = (Point3::new(1.0, 1.0, 0.0), Point3::new(0.0, 1.0, -2.5e-16));
    /// let weld = TriangleMesh::new(vec![a, b, c, b, d, e], vec![[0, 1, 2], [3, 4, 5]])?.weld();
    /// assert_eq!((weld.first, weld.joined), (vec![0, 1, 2, 1, 4, 2], 1));
    /// # Ok::<(), mesh_core::Error>(())
    /// ```
    #[must_use]
    pub fn weld(&self) -> Weld {
        let first = self.equal_vertices();
        let corners = |corners: &[u32; 3]| corners.map(|index| first[index as usize]);
        let triangles: Vec<[u32; 3]> = self.triangles.iter().map(corners).collect();
        match seams::join(self.vertices(), &triangles) {
            None => Weld { first, joined: 0, largest_gap: 0.0 },
            Some(joined) => Weld {
                first: first.iter().map(|&vertex| joined.roots[vertex as usize]).collect(),
                joined: joined.count,
                largest_gap: joined.largest,
            },
        }
    }

    /// For every vertex the first vertex that is the same corner (itself where there is none before it), see
    /// [`TriangleMesh::weld`].
    #[must_use]
    pub fn coincident_vertices(&self) -> Vec<u32> {
        self.weld().first
    }

    /// The same mesh with one vertex per corner ([`TriangleMesh::weld`]), in the order of the first of each. Of copies
    /// that differ by rounding the one with the smallest coordinates stays, since rounding errors stand beside zeros.
    /// Of their attributes, those of the first.
    #[must_use]
    pub fn welded(&self) -> (Self, Weld) {
        let weld = self.weld();
        let size =
            |vertex: u32| self.vertices()[vertex as usize].iter().map(|value| value.abs()).sum::<f64>();
        let mut kept: Vec<u32> = (0u32..).take(self.vertices.len()).collect();
        for (&first, vertex) in weld.first.iter().zip(0u32..) {
            let best = &mut kept[first as usize];
            *best = if size(vertex) < size(*best) { vertex } else { *best };
        }
        let mut numbers = vec![0u32; self.vertices.len()];
        let firsts: Vec<u32> = (weld.first.iter().zip(0u32..))
            .filter(|(first, vertex)| *first == vertex)
            .map(|(_, v)| v)
            .collect();
        firsts.iter().zip(0u32..).for_each(|(&first, number)| numbers[first as usize] = number);
        let positions = firsts.iter().map(|&first| self.vertices()[kept[first as usize] as usize]).collect();
        let corner = |index: u32| numbers[weld.first[index as usize] as usize];
        let triangles = self.triangles.iter().map(|corners| corners.map(corner)).collect();
        let vertices = self.vertices.selected_at(&firsts, positions);
        (Self { vertices, triangles }, weld)
    }

    /// For every vertex the first vertex at exactly the same position.
    fn equal_vertices(&self) -> Vec<u32> {
        let mut welder = VertexWelder::with_capacity(self.vertices.len());
        let mut first = Vec::with_capacity(self.vertices.len());
        (self.vertices().iter().zip(0u32..))
            .map(|(&vertex, index)| {
                // There are no more positions than vertices, whose number was checked.
                let number = welder.insert(vertex).map_or(first.len(), |number| number as usize);
                if number == first.len() {
                    first.push(index);
                }
                first[number]
            })
            .collect()
    }

    /// Edges of the mesh as its indices have it.
    #[must_use]
    pub fn topology(&self) -> MeshTopology {
        MeshTopology::of(&self.triangles)
    }

    /// Edges of the mesh when vertices that are one corner count as one ([`TriangleMesh::weld`]).
    #[must_use]
    pub fn welded_topology(&self) -> MeshTopology {
        MeshTopology::of(&self.welded_triangles())
    }

    /// The triangles with every vertex replaced by the first one that is the same corner.
    pub(crate) fn welded_triangles(&self) -> Vec<[u32; 3]> {
        let welded = self.coincident_vertices();
        self.triangles.iter().map(|corners| corners.map(|index| welded[index as usize])).collect()
    }

    /// Sum of the areas of the triangles.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.area_vectors().map(|vector| 0.5 * vector.norm()).fold(0.0, |sum, area| sum + area)
    }

    /// Enclosed volume; negative where the triangles are oriented inwards. Meaningful for closed meshes only.
    #[must_use]
    pub fn signed_volume(&self) -> f64 {
        // Relative to the centre, so that coordinates far from the origin cost no digits.
        let centre = self.bounding_box().map_or_else(Point3::origin, |bounds| bounds.centre());
        (self.triangles.iter().map(|corners| self.positions_of(corners)))
            .map(|[a, b, c]| (a - centre).dot(&(b - centre).cross(&(c - centre))) / 6.0)
            .sum()
    }

    pub(crate) fn area_vectors(&self) -> impl Iterator<Item = Vector3<f64>> {
        self.triangles.iter().map(|corners| Triangle(self.positions_of(corners)).area_vector())
    }

    pub(crate) fn positions_of(&self, corners: &[u32; 3]) -> [Point3<f64>; 3] {
        corners.map(|index| self.vertices()[index as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn welds_by_position_alone() {
        let p = |x: f64, y: f64| Point3::new(x, y, 0.0);
        let mesh = TriangleMesh::new(
            vec![p(0.0, 0.0), p(1.0, 0.0), p(0.0, 1.0), p(1.0, -0.0), p(1.0, 1.0), p(-0.0, 1.0)],
            vec![[0, 1, 2], [3, 4, 5]],
        )
        .unwrap();
        assert_eq!(mesh.coincident_vertices(), [0, 1, 2, 1, 4, 2]);
        assert_eq!(mesh.topology().boundary_edges, 6);
        assert_eq!(mesh.welded_topology().boundary_edges, 4);
        assert_eq!(mesh.area(), 1.0);
    }

    #[test]
    fn drops_triangles_of_vertices_that_are_not_finite() {
        let mut vertices = vec![Point3::origin(); 5];
        vertices[1].x = f64::NAN;
        let mut mesh = TriangleMesh::new(vertices, vec![[0, 1, 2], [2, 3, 4]]).unwrap();
        assert_eq!(mesh.retain_finite(), 1);
        assert_eq!((mesh.vertices().len(), mesh.triangles()), (4, [[1, 2, 3]].as_slice()));
    }
}
