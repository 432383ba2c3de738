//! Coarse control meshes from fine ones.

use super::folded::MOST_NEIGHBOURS;
use crate::Error;
use mesh_core::{HalfEdgeMesh, TriangleMesh};
use nalgebra::{Point3, Vector3};
use std::cmp::Ordering;
use std::collections::{BTreeSet, BinaryHeap};

/// Least cosine of the angle by which the normal of a triangle may turn in one collapse.
const TURN: f64 = 0.2;

/// A mesh of about so many vertices with the shape of a fine one: its shortest edges are collapsed one after the other, each to its
/// middle.
///
/// The mesh stays an oriented manifold of the same genus; boundaries keep their vertices, and no triangle turns over. Where that
/// allows no collapse any more, more vertices than asked for remain. Lengths count, not errors: a control mesh for
/// [`fit_subdivision`](super::fit_subdivision) should be even.
///
/// # Errors
/// [`Error::Field`] for a mesh that is not an oriented manifold or has coordinates that are not finite.
pub fn coarsened(mesh: &TriangleMesh, vertices: usize) -> Result<TriangleMesh, Error> {
    let connectivity = HalfEdgeMesh::new(mesh);
    if !connectivity.defects().is_empty() {
        return Err(Error::Field { reason: "the mesh to coarsen is not an oriented manifold".to_owned() });
    }
    if mesh.count_non_finite() > 0 {
        return Err(Error::Field {
            reason: "the mesh to coarsen has coordinates that are not finite".to_owned(),
        });
    }
    let count = mesh.vertices().len();
    let mut state = Coarse {
        positions: mesh.vertices().to_vec(),
        triangles: connectivity.triangles().iter().map(|t| Some(*t)).collect(),
        around: vec![BTreeSet::new(); count],
        boundary: (0..u32::try_from(count).unwrap_or(u32::MAX))
            .map(|v| connectivity.is_boundary(v))
            .collect(),
    };
    for (index, triangle) in connectivity.triangles().iter().enumerate() {
        triangle.iter().for_each(|&v| _ = state.around[v as usize].insert(index));
    }
    let mut left = state.around.iter().filter(|around| !around.is_empty()).count();
    let mut heap = BinaryHeap::new();
    for triangle in connectivity.triangles() {
        for k in 0..3 {
            heap.extend(state.candidate(triangle[k], triangle[(k + 1) % 3]));
        }
    }
    while left > vertices.max(4) {
        let Some(Candidate { length, ends: [a, b] }) = heap.pop() else { break };
        // Edges that have changed since are in the heap once more.
        if state.length(a, b) != length || !state.can_collapse(a, b) {
            continue;
        }
        state.collapse(a, b);
        left -= 1;
        for c in state.neighbours(a) {
            heap.extend(state.candidate(a, c));
        }
    }
    state.mesh()
}

/// An edge in the order of lengths, the shortest greatest.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Candidate {
    length: f64,
    ends: [u32; 2],
}

impl Eq for Candidate {}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        other.length.total_cmp(&self.length).then(other.ends.cmp(&self.ends))
    }
}

/// A mesh whose edges collapse.
struct Coarse {
    positions: Vec<Point3<f64>>,
    triangles: Vec<Option<[u32; 3]>>,
    /// The triangles around each vertex; none around those that are gone.
    around: Vec<BTreeSet<usize>>,
    boundary: Vec<bool>,
}

impl Coarse {
    fn length(&self, a: u32, b: u32) -> f64 {
        (self.positions[a as usize] - self.positions[b as usize]).norm()
    }

    fn candidate(&self, a: u32, b: u32) -> Option<Candidate> {
        let inside = !self.boundary[a as usize] && !self.boundary[b as usize];
        inside.then(|| Candidate { length: self.length(a, b), ends: [a.min(b), a.max(b)] })
    }

    fn corners_around(&self, vertex: u32) -> impl Iterator<Item = (usize, [u32; 3])> {
        self.around[vertex as usize].iter().filter_map(|&t| Some((t, self.triangles[t]?)))
    }

    fn neighbours(&self, vertex: u32) -> BTreeSet<u32> {
        let corners = self.corners_around(vertex).flat_map(|(_, corners)| corners);
        corners.filter(|&other| other != vertex).collect()
    }

    /// Whether the mesh stays a manifold whose inner vertices have three neighbours or more, and no triangle turns over.
    fn can_collapse(&self, a: u32, b: u32) -> bool {
        // Two triangles vanish, and each of the others is around the one vertex that is left.
        let triangles = |v: u32| self.around[v as usize].len();
        if triangles(a) + triangles(b) > MOST_NEIGHBOURS + 4 {
            return false;
        }
        let (around_a, around_b) = (self.neighbours(a), self.neighbours(b));
        let common: Vec<u32> = around_a.intersection(&around_b).copied().collect();
        if !around_a.contains(&b) || common.len() != 2 || around_a.len() + around_b.len() < 8 {
            return false;
        }
        // Those opposite the edge lose a neighbour.
        if common.iter().any(|&c| triangles(c) <= if self.boundary[c as usize] { 2 } else { 4 }) {
            return false;
        }
        let middle = nalgebra::center(&self.positions[a as usize], &self.positions[b as usize]);
        let keeps = |vertex: u32| {
            self.corners_around(vertex).all(|(_, corners)| {
                if corners.contains(&a) && corners.contains(&b) {
                    return true;
                }
                let before = normal(corners.map(|c| self.positions[c as usize]));
                let moved = |c: u32| if c == vertex { middle } else { self.positions[c as usize] };
                let after = normal(corners.map(moved));
                before.dot(&after) >= TURN * before.norm() * after.norm() && after.norm() > 0.0
            })
        };
        keeps(a) && keeps(b)
    }

    /// Moves both ends to the middle and makes them one.
    fn collapse(&mut self, a: u32, b: u32) {
        self.positions[a as usize] =
            nalgebra::center(&self.positions[a as usize], &self.positions[b as usize]);
        for index in std::mem::take(&mut self.around[b as usize]) {
            let Some(corners) = self.triangles[index] else { continue };
            if corners.contains(&a) {
                self.triangles[index] = None;
                for corner in corners {
                    self.around[corner as usize].remove(&index);
                }
            } else {
                self.triangles[index] = Some(corners.map(|c| if c == b { a } else { c }));
                self.around[a as usize].insert(index);
            }
        }
    }

    /// What is left, numbered anew.
    fn mesh(&self) -> Result<TriangleMesh, Error> {
        let mut numbers = vec![u32::MAX; self.positions.len()];
        let mut positions = Vec::new();
        for (vertex, around) in self.around.iter().enumerate().filter(|(_, around)| !around.is_empty()) {
            debug_assert!(around.iter().all(|&t| self.triangles[t].is_some()));
            numbers[vertex] = u32::try_from(positions.len()).unwrap_or(u32::MAX);
            positions.push(self.positions[vertex]);
        }
        let triangles = self.triangles.iter().flatten().map(|t| t.map(|v| numbers[v as usize])).collect();
        Ok(TriangleMesh::new(positions, triangles)?)
    }
}

fn normal([a, b, c]: [Point3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}
