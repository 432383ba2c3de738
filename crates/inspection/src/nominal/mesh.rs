//! Deviations from a triangle mesh.

use super::signed;
use crate::{Deviation, Error, Outcome, Place};
use footpoint::Progress;
use mesh_core::{Feature, MeshProjector, TriangleMesh};
use nalgebra::{Point3, Vector3};
use std::collections::HashSet;

/// A mesh, and where it ends.
#[derive(Debug)]
pub(super) struct MeshNominal {
    mesh: TriangleMesh,
    projector: MeshProjector,
    /// Vertices of each triangle, those at the same position counting as one.
    corners: Vec<[u32; 3]>,
    /// Edges of one triangle only, smaller vertex first.
    boundary_edges: HashSet<[u32; 2]>,
    boundary_vertices: HashSet<u32>,
}

impl MeshNominal {
    pub(super) fn new(mesh: &TriangleMesh) -> Result<Self, Error> {
        let projector = MeshProjector::new(mesh)?;
        let first = mesh.coincident_vertices();
        let weld = |corners: &[u32; 3]| corners.map(|vertex| first[vertex as usize]);
        let corners: Vec<[u32; 3]> = mesh.triangles().iter().map(weld).collect();
        let mut edges: Vec<[u32; 2]> = (corners.iter())
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .flat_map(|corners| [0, 1, 2].map(|edge| sides(corners, edge)))
            .collect();
        edges.sort_unstable();
        let alone = edges.chunk_by(|a, b| a == b).filter(|same| same.len() == 1);
        let boundary_edges: HashSet<[u32; 2]> = alone.map(|same| same[0]).collect();
        let boundary_vertices = boundary_edges.iter().flatten().copied().collect();
        Ok(Self { mesh: mesh.clone(), projector, corners, boundary_edges, boundary_vertices })
    }

    pub(super) fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    pub(super) fn triangle_count(&self) -> usize {
        self.projector.topology().triangles
    }

    /// Whether normals tell sides: neighbouring triangles agree on them.
    pub(super) fn is_signed(&self) -> bool {
        self.projector.topology().is_oriented()
    }

    /// Deviations along the shortest lines.
    pub(super) fn shortest(&self, points: &[Point3<f64>], progress: Progress<'_>) -> Vec<Deviation> {
        let cancelled = Deviation::none(Outcome::Cancelled);
        crate::parallel::map(points.len(), &cancelled, progress, |index| self.deviation(&points[index]))
    }

    fn deviation(&self, x: &Point3<f64>) -> Deviation {
        if !x.iter().all(|value| value.is_finite()) {
            return Deviation::none(Outcome::InvalidPoint);
        }
        // The only other reason for an error is a distance beyond the range of doubles.
        let Ok(foot) = self.projector.project(x) else { return Deviation::none(Outcome::NotConverged) };
        let (place, on_boundary) = self.place(foot.triangle, foot.feature);
        Deviation {
            outcome: Outcome::Measured,
            foot: foot.point,
            normal: foot.normal,
            distance: self.distance(foot.distance, &(x - foot.point), &foot.normal),
            gap: 0.0,
            parameter: [f64::NAN; 2],
            shape: 0,
            triangle: u32::try_from(foot.triangle).unwrap_or(u32::MAX),
            place,
            on_boundary,
        }
    }

    /// The deviation along a line in a direction of length 1.
    pub(super) fn along(&self, x: &Point3<f64>, direction: &Vector3<f64>) -> Deviation {
        let Ok(Some(hit)) = self.projector.nearest_on_line(x, direction) else {
            return Deviation::none(Outcome::NoHit);
        };
        Deviation {
            outcome: Outcome::Measured,
            foot: hit.point,
            normal: hit.normal,
            distance: self.distance(hit.offset.abs(), &(direction * -hit.offset), &hit.normal),
            gap: 0.0,
            parameter: [f64::NAN; 2],
            shape: 0,
            triangle: u32::try_from(hit.triangle).unwrap_or(u32::MAX),
            place: Place::Face,
            on_boundary: false,
        }
    }

    fn distance(&self, distance: f64, offset: &Vector3<f64>, normal: &Vector3<f64>) -> f64 {
        if self.is_signed() { signed(distance, offset, normal) } else { distance }
    }

    fn place(&self, triangle: usize, feature: Feature) -> (Place, bool) {
        let corners = &self.corners[triangle];
        match feature {
            Feature::Face => (Place::Face, false),
            Feature::Edge(edge) => {
                (Place::TriangleEdge, self.boundary_edges.contains(&sides(corners, edge.into())))
            }
            Feature::Vertex(corner) => {
                (Place::Vertex, self.boundary_vertices.contains(&corners[usize::from(corner)]))
            }
        }
    }
}

/// The vertices at the ends of an edge, the smaller one first.
fn sides(corners: &[u32; 3], edge: usize) -> [u32; 2] {
    let (a, b) = (corners[edge], corners[(edge + 1) % 3]);
    [a.min(b), a.max(b)]
}
