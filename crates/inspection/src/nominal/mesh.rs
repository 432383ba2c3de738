//! Deviations from a triangle mesh.

use super::signed;
use crate::{Deviation, DeviationRecord, Error, Outcome, Place};
use footpoint::Facing;
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

    /// The deviation along the shortest line, to the triangles that face a direction if one is given.
    pub(super) fn shortest(&self, x: &Point3<f64>, facing: Option<&Facing>) -> Deviation {
        // The only reason for an error is a distance beyond the range of doubles.
        let found = match facing {
            None => self.projector.project(x).map(|foot| Some((foot, false))),
            Some(facing) => {
                let found = self.projector.project_facing(x, facing.direction(), facing.max_angle());
                found.map(|found| found.map(|found| (found.foot, !found.is_nearest)))
            }
        };
        let (foot, is_restricted) = match found {
            Ok(Some(found)) => found,
            Ok(None) => return Deviation::none(Outcome::NoMatchingFoot),
            Err(_) => return Deviation::none(Outcome::NotConverged),
        };
        let (place, corner, on_boundary) = self.place(foot.triangle, foot.feature);
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
            corner,
            on_boundary,
            is_restricted,
        }
    }

    /// The deviation along a line in a direction of length 1, to the triangles that face a direction if one is given.
    pub(super) fn along(
        &self,
        x: &Point3<f64>,
        direction: &Vector3<f64>,
        facing: Option<&Facing>,
    ) -> Deviation {
        let Ok(Some(nearest)) = self.projector.nearest_on_line(x, direction) else {
            return Deviation::none(Outcome::NoHit);
        };
        let (hit, is_restricted) = match facing.filter(|facing| !facing.agrees(&nearest.normal)) {
            None => (nearest, false),
            Some(facing) => {
                let (towards, most) = (facing.direction(), facing.max_angle());
                match self.projector.nearest_on_line_facing(x, direction, towards, most) {
                    Ok(Some(hit)) => (hit, hit.offset.abs() > nearest.offset.abs()),
                    _ => return Deviation::none(Outcome::NoMatchingFoot),
                }
            }
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
            corner: 0,
            on_boundary: false,
            is_restricted,
        }
    }

    /// The unit normal at a foot that [`shortest`](Self::shortest) has found, or [`along`](Self::along).
    pub(super) fn normal(
        &self,
        record: &DeviationRecord,
        is_hit: bool,
        facing: Option<&Facing>,
    ) -> Vector3<f64> {
        let triangle = record.triangle() as usize;
        let feature = match record.place {
            Place::TriangleEdge => Feature::Edge(record.corner),
            Place::Vertex => Feature::Vertex(record.corner),
            _ => Feature::Face,
        };
        match facing.filter(|_| record.is_restricted()) {
            Some(facing) if feature != Feature::Face => {
                self.projector.facing_normal(&record.foot, facing.direction(), facing.max_angle())
            }
            Some(_) => self.projector.face_normal(triangle),
            None if is_hit => self.projector.face_normal(triangle),
            None => self.projector.normal_at(triangle, feature, &record.foot),
        }
    }

    fn distance(&self, distance: f64, offset: &Vector3<f64>, normal: &Vector3<f64>) -> f64 {
        if self.is_signed() { signed(distance, offset, normal) } else { distance }
    }

    /// Where a foot lies, the number of the edge or corner, and whether that is on the boundary.
    fn place(&self, triangle: usize, feature: Feature) -> (Place, u8, bool) {
        let corners = &self.corners[triangle];
        match feature {
            Feature::Face => (Place::Face, 0, false),
            Feature::Edge(edge) => {
                (Place::TriangleEdge, edge, self.boundary_edges.contains(&sides(corners, edge.into())))
            }
            Feature::Vertex(corner) => {
                (Place::Vertex, corner, self.boundary_vertices.contains(&corners[usize::from(corner)]))
            }
        }
    }
}

/// The vertices at the ends of an edge, the smaller one first.
fn sides(corners: &[u32; 3], edge: usize) -> [u32; 2] {
    let (a, b) = (corners[edge], corners[(edge + 1) % 3]);
    [a.min(b), a.max(b)]
}
