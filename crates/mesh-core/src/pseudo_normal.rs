//! Angle-weighted pseudo-normals: which side of a closed mesh a point is on.
//!
//! The sign of the distance is the sign of ⟨x − foot, N⟩, where N belongs to the part of the mesh on which the foot
//! lies: the normal of a face, the sum of the two unit normals at an edge, the sum of the unit normals weighted by
//! the angles at a vertex. With other weights the sign is wrong in places (\[BA05\]).

use nalgebra::Vector3;

use crate::topology::NONE;
use crate::triangle::{Feature, Triangle};

/// Pseudo-normals of all features of a mesh.
#[derive(Debug, Clone)]
pub(crate) struct PseudoNormals {
    faces: Vec<Vector3<f64>>,
    vertices: Vec<Vector3<f64>>,
    /// Vertices at which a triangle without area ends.
    doubtful: Vec<bool>,
}

impl PseudoNormals {
    /// `corners` are the vertex numbers of the triangles, below `vertices`.
    pub(crate) fn new(triangles: &[Triangle], corners: &[[u32; 3]], vertices: usize) -> Self {
        let faces: Vec<_> = triangles.iter().map(Triangle::unit_normal).collect();
        let mut sums = vec![Vector3::zeros(); vertices];
        let mut doubtful = vec![false; vertices];
        for ((triangle, normal), indices) in triangles.iter().zip(&faces).zip(corners) {
            for (corner, &vertex) in indices.iter().enumerate() {
                sums[vertex as usize] += normal * triangle.angle(corner);
                doubtful[vertex as usize] |= *normal == Vector3::zeros();
            }
        }
        Self { faces, vertices: sums, doubtful }
    }

    /// The pseudo-normal, not of unit length, of a feature of a triangle with the given vertices and neighbours.
    ///
    /// `None` where a triangle without area takes part: its normal is unknown, and the surface around the feature
    /// has to be gathered by position instead.
    pub(crate) fn at(
        &self,
        triangle: usize,
        feature: Feature,
        corners: &[u32; 3],
        neighbours: &[u32; 3],
    ) -> Option<Vector3<f64>> {
        let known = |normal: Vector3<f64>| (normal != Vector3::zeros()).then_some(normal);
        let own = known(self.faces[triangle])?;
        match feature {
            Feature::Face => Some(own),
            Feature::Edge(edge) => match neighbours[usize::from(edge)] {
                NONE => Some(own),
                other => Some(own + known(self.faces[other as usize])?),
            },
            Feature::Vertex(corner) => {
                let vertex = corners[usize::from(corner)] as usize;
                (!self.doubtful[vertex]).then_some(self.vertices[vertex])
            }
        }
    }

    /// The unit normal of a triangle, zero without area.
    pub(crate) fn face(&self, triangle: usize) -> &Vector3<f64> {
        &self.faces[triangle]
    }

    /// What a triangle adds to the pseudo-normal at a point that lies on it.
    pub(crate) fn share(&self, triangle: usize, shape: &Triangle, feature: Feature) -> Vector3<f64> {
        let angle = match feature {
            Feature::Face => std::f64::consts::TAU,
            Feature::Edge(_) => std::f64::consts::PI,
            Feature::Vertex(corner) => shape.angle(usize::from(corner)),
        };
        self.faces[triangle] * angle
    }
}
