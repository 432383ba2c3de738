//! Edges at which meshes fold back on themselves.

use crate::Error;
use mesh_core::{LoopScheme, TriangleMesh};
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// Angle in degrees between the normals of two triangles beyond which the edge between them is folded.
const FOLDED: f64 = 150.0;
/// How often a control mesh is subdivided for the mesh of its limit surface.
const LEVELS: usize = 2;
/// Most neighbours of a vertex of a control mesh: the triangles around a vertex depend on all of its neighbours each.
pub(super) const MOST_NEIGHBOURS: usize = 128;

/// Edges whose triangles' normals differ by more than 150 degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct FoldedEdges {
    /// Of the control mesh.
    pub control: usize,
    /// Of the mesh of the limit surface, the control mesh subdivided twice, its vertices on the limit surface.
    pub limit: usize,
}

impl FoldedEdges {
    /// Of a control mesh and its limit surface.
    ///
    /// # Errors
    /// [`Error::Field`] for a mesh that cannot be subdivided.
    pub fn of(control: &TriangleMesh) -> Result<Self, Error> {
        check_neighbours(control)?;
        let mut mesh = control.clone();
        for _ in 0..LEVELS {
            mesh = LoopScheme::new(&mesh).subdivide()?;
        }
        let corners = LoopScheme::new(&mesh).limits().iter().map(|limit| limit.position).collect();
        let limit = TriangleMesh::new(corners, mesh.triangles().to_vec())?;
        Ok(Self { control: folded_edges(control), limit: folded_edges(&limit) })
    }
}

/// Number of edges of a mesh at which the normals of the two triangles differ by more than 150 degrees.
#[must_use]
pub fn folded_edges(mesh: &TriangleMesh) -> usize {
    let corner = |k: u32| mesh.vertices()[k as usize];
    let normal = |t: &[u32; 3]| -> Option<Vector3<f64>> {
        let [a, b, c] = t.map(corner);
        (b - a).cross(&(c - a)).try_normalize(0.0).filter(|n| n.iter().all(|c| c.is_finite()))
    };
    let mut open: BTreeMap<[u32; 2], Option<Vector3<f64>>> = BTreeMap::new();
    let limit = FOLDED.to_radians().cos();
    let mut count = 0;
    for triangle in mesh.triangles() {
        let here = normal(triangle);
        for k in 0..3 {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            // Triangles on both sides of an edge run along it in opposite directions.
            if let Some(other) = open.remove(&[b, a]) {
                if let (Some(m), Some(n)) = (here, other)
                    && m.dot(&n) < limit
                {
                    count += 1;
                }
            } else {
                open.insert([a, b], here);
            }
        }
    }
    count
}

/// Whether no vertex has so many neighbours that its surroundings do not fit into memory.
pub(super) fn check_neighbours(mesh: &TriangleMesh) -> Result<(), Error> {
    let mut counts = vec![0usize; mesh.vertices().len()];
    mesh.triangles().iter().flatten().for_each(|&v| counts[v as usize] += 1);
    let most = counts.iter().enumerate().max_by_key(|(_, n)| **n);
    match most.filter(|(_, n)| **n > MOST_NEIGHBOURS) {
        Some((vertex, count)) => Err(Error::Field {
            reason: format!(
                "vertex {vertex} of the control mesh has {count} triangles around it, more than {MOST_NEIGHBOURS}; divide them evenly, or remesh"
            ),
        }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::HalfEdgeMesh;
    use nalgebra::Point3;

    #[test]
    fn a_sheet_folded_flat_has_a_folded_edge() {
        let corners =
            |x: f64| [[0., 0., 0.], [0., 1., 0.], [1., 0.5, 0.], [x, 0.5, 0.05]].map(Point3::from).to_vec();
        let mesh = |x: f64| TriangleMesh::new(corners(x), vec![[0, 2, 1], [0, 1, 3]]).unwrap();
        assert_eq!(folded_edges(&mesh(-1.0)), 0);
        assert_eq!(folded_edges(&mesh(1.0)), 1);
    }

    #[test]
    fn a_fan_around_a_vertex_of_many_neighbours_is_refused() {
        let n = 1000u32;
        let rim = (0..n).map(|k| f64::from(k) * std::f64::consts::TAU / f64::from(n));
        let mut corners: Vec<Point3<f64>> = rim.map(|a| Point3::new(a.cos(), a.sin(), 0.0)).collect();
        corners.push(Point3::origin());
        let fan = TriangleMesh::new(corners, (0..n).map(|k| [n, k, (k + 1) % n]).collect()).unwrap();
        assert!(matches!(FoldedEdges::of(&fan), Err(Error::Field { .. })));
        assert!(HalfEdgeMesh::new(&fan).defects().is_empty());
    }
}
