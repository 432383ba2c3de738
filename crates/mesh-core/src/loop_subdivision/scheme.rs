//! Subdivision and limits of a control mesh.

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};

use super::masks::{self, Mask};
use crate::normals::unit;
use crate::topology::NONE;
use crate::{Error, HalfEdgeMesh, TriangleMesh};

/// A point of the limit surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitPoint {
    /// Its position.
    pub position: Point3<f64>,
    /// Two tangent vectors, not of unit length and not orthogonal; on the boundary the first is along it. Zero at
    /// vertices that stay where they are.
    pub tangents: [Vector3<f64>; 2],
    /// Unit normal, on the side from which the triangles run counter-clockwise; `None` where tangents are parallel.
    pub normal: Option<Vector3<f64>>,
}

/// How a vertex moves.
enum Rule {
    /// Inside the surface: its neighbours.
    Interior(Vec<u32>),
    /// On the boundary: its neighbours from side to side.
    Boundary(Vec<u32>),
    /// It does not.
    Fixed,
}

/// Loop's subdivision scheme on a control mesh (\[Lo87\]).
///
/// Vertices at exactly the same position count as one. The boundary is a cubic B-spline curve of its own. Vertices that no
/// triangle uses stay, and so do those with a defect ([`HalfEdgeMesh::defects`]): at edges that are not manifold, or
/// not consistently oriented, the surface ends as at a boundary, and vertices of several fans do not move.
#[derive(Debug, Clone)]
pub struct LoopScheme {
    connectivity: HalfEdgeMesh,
    positions: Vec<Point3<f64>>,
    /// The first vertex at the same position.
    first: Vec<u32>,
    fixed: Vec<bool>,
}

impl LoopScheme {
    /// Prepares a control mesh. Its attributes play no part.
    #[must_use]
    pub fn new(mesh: &TriangleMesh) -> Self {
        let connectivity = HalfEdgeMesh::new(mesh);
        let mut fixed = vec![false; mesh.vertices().len()];
        let defects = connectivity.defects();
        let edges = defects.non_manifold_edges.iter().chain(&defects.inconsistent_edges).flatten();
        for &vertex in edges.chain(&defects.non_manifold_vertices) {
            fixed[vertex as usize] = true;
        }
        Self { connectivity, positions: mesh.vertices().to_vec(), first: mesh.coincident_vertices(), fixed }
    }

    /// The scheme on triangles alone, for masks.
    pub(super) fn of_triangles(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        Self {
            connectivity: HalfEdgeMesh::of(vertices, triangles),
            positions: Vec::new(),
            first: (0u32..).take(vertices).collect(),
            fixed: vec![false; vertices],
        }
    }

    /// The positions of the control vertices.
    pub(super) fn positions(&self) -> &[Point3<f64>] {
        &self.positions
    }

    /// Whether a vertex moves by a rule of its own.
    pub(super) fn is_smooth(&self, vertex: u32) -> bool {
        !matches!(self.rule(vertex), Rule::Fixed)
    }

    /// The connectivity of the control mesh.
    #[must_use]
    pub const fn connectivity(&self) -> &HalfEdgeMesh {
        &self.connectivity
    }

    /// The mesh with every triangle divided into four.
    ///
    /// Vertices keep their indices; those of the edges follow. Triangle `t` becomes `4 t` (at its first corner) to
    /// `4 t + 3` (in the middle).
    ///
    /// # Errors
    /// [`Error::TooMany`] beyond 32-bit indices.
    pub fn subdivide(&self) -> Result<TriangleMesh, Error> {
        let (masks, triangles) = self.refine()?;
        TriangleMesh::new(masks.iter().map(|mask| self.moved(mask)).collect(), triangles)
    }

    /// The masks of the vertices of the divided mesh, and its triangles.
    pub(super) fn refine(&self) -> Result<(Vec<Mask>, Vec<[u32; 3]>), Error> {
        let triangles: Vec<[u32; 3]> = self
            .connectivity
            .half_edges()
            .step_by(3)
            .map(|edge| self.connectivity.triangles()[edge.triangle()])
            .collect();
        let mut masks: Vec<Mask> = self.first.iter().map(|&vertex| self.vertex_mask(vertex)).collect();
        let mut middles = vec![[NONE; 3]; self.connectivity.triangles().len()];
        // Edges without twins may still have several triangles.
        let mut open: HashMap<[u32; 2], u32> = HashMap::new();
        for edge in self.connectivity.half_edges() {
            let next = u32::try_from(masks.len()).ok().filter(|&index| index != NONE);
            let next = next.ok_or(Error::TooMany { what: "vertices", count: masks.len() })?;
            let (from, to) = (self.connectivity.origin(edge), self.connectivity.target(edge));
            let known = match self.connectivity.twin(edge) {
                Some(twin) => Some(middles[twin.triangle()][twin.edge()]).filter(|&index| index != NONE),
                None => {
                    let index = *open.entry([from.min(to), from.max(to)]).or_insert(next);
                    Some(index).filter(|&index| index != next)
                }
            };
            middles[edge.triangle()][edge.edge()] = known.unwrap_or(next);
            if known.is_none() {
                let opposite = |edge: crate::HalfEdge| self.connectivity.origin(edge.previous());
                masks.push(match self.connectivity.twin(edge) {
                    Some(twin) => {
                        vec![(from, 0.375), (to, 0.375), (opposite(edge), 0.125), (opposite(twin), 0.125)]
                    }
                    None => vec![(from, 0.5), (to, 0.5)],
                });
            }
        }
        let usable = middles.into_iter().filter(|[ab, _, _]| *ab != NONE);
        let divided = (triangles.into_iter().zip(usable))
            .flat_map(|([a, b, c], [ab, bc, ca])| [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]])
            .collect();
        Ok((masks, divided))
    }

    /// Where a vertex of the control mesh ends on the limit surface, and the tangent plane there. `None` if the vertex
    /// does not exist.
    #[must_use]
    pub fn limit(&self, vertex: u32) -> Option<LimitPoint> {
        let position = self.moved(&self.limit_mask(vertex)?);
        let Some([first, second]) = self.tangent_masks(vertex) else {
            return Some(LimitPoint { position, tangents: [Vector3::zeros(); 2], normal: None });
        };
        // Weights sum to zero, so that the origin does not matter; relative to the limit it costs no digits.
        let vector = |mask: &Mask| {
            (mask.iter())
                .map(|&(index, weight)| (self.positions[index as usize] - position) * weight)
                .sum::<Vector3<f64>>()
        };
        let tangents = [vector(&first), vector(&second)];
        Some(LimitPoint { position, tangents, normal: unit(&tangents[0].cross(&tangents[1])) })
    }

    /// The limits of all vertices.
    #[must_use]
    pub fn limits(&self) -> Vec<LimitPoint> {
        (0u32..).take(self.positions.len()).filter_map(|vertex| self.limit(vertex)).collect()
    }

    /// The weights of the control vertices whose sum is the limit position of a vertex. `None` if it does not exist.
    #[must_use]
    pub fn limit_mask(&self, vertex: u32) -> Option<Mask> {
        let vertex = *self.first.get(vertex as usize)?;
        Some(match self.rule(vertex) {
            Rule::Interior(around) => masks::interior_limit(vertex, &around),
            Rule::Boundary(around) => masks::boundary_limit(vertex, ends(vertex, &around)),
            Rule::Fixed => vec![(vertex, 1.0)],
        })
    }

    /// The weights of the control vertices whose sums are two tangent vectors at the limit of a vertex. `None` if the
    /// vertex does not exist or does not move.
    #[must_use]
    pub fn tangent_masks(&self, vertex: u32) -> Option<[Mask; 2]> {
        let vertex = *self.first.get(vertex as usize)?;
        match self.rule(vertex) {
            Rule::Interior(around) => Some(masks::interior_tangents(&around)),
            Rule::Boundary(around) => masks::boundary_tangents(vertex, &around),
            Rule::Fixed => None,
        }
    }

    fn vertex_mask(&self, vertex: u32) -> Mask {
        match self.rule(vertex) {
            Rule::Interior(around) => masks::interior_vertex(vertex, &around),
            Rule::Boundary(around) => masks::boundary_vertex(vertex, ends(vertex, &around)),
            Rule::Fixed => vec![(vertex, 1.0)],
        }
    }

    fn rule(&self, vertex: u32) -> Rule {
        let around: Vec<u32> = self.connectivity.neighbours(vertex).collect();
        // Fewer than three neighbours close no surface around a vertex.
        match around.len() {
            _ if self.fixed[vertex as usize] => Rule::Fixed,
            0 | 1 => Rule::Fixed,
            _ if self.connectivity.is_boundary(vertex) => Rule::Boundary(around),
            2 => Rule::Fixed,
            _ => Rule::Interior(around),
        }
    }

    /// The point of a mask whose weights sum to one, computed relative to its first vertex.
    fn moved(&self, mask: &Mask) -> Point3<f64> {
        let Some(&(first, _)) = mask.first() else { return Point3::origin() };
        let origin = self.positions[first as usize];
        let shift: Vector3<f64> =
            mask[1..].iter().map(|&(index, weight)| (self.positions[index as usize] - origin) * weight).sum();
        origin + shift
    }
}

/// The first and the last neighbour of a vertex on the boundary.
fn ends(vertex: u32, around: &[u32]) -> [u32; 2] {
    [around.first(), around.last()].map(|end| end.copied().unwrap_or(vertex))
}
