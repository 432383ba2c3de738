//! Half-edge connectivity of a triangle mesh.

use std::fmt;

use crate::TriangleMesh;
use crate::topology::NONE;

/// A directed edge of a triangle: corner `edge` of it to the next. Its number is `3 × triangle + edge`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct HalfEdge(u32);

impl HalfEdge {
    /// The half-edge from corner `edge` (0, 1 or 2) of a triangle to the next.
    #[must_use]
    pub const fn new(triangle: u32, edge: u8) -> Self {
        Self(3 * triangle + (edge % 3) as u32)
    }

    /// Its triangle.
    #[must_use]
    pub const fn triangle(self) -> usize {
        (self.0 / 3) as usize
    }

    /// The corner of the triangle in which it begins: 0, 1 or 2.
    #[must_use]
    pub const fn edge(self) -> usize {
        (self.0 % 3) as usize
    }

    /// The next half-edge of the same triangle.
    #[must_use]
    pub const fn next(self) -> Self {
        Self(if self.0 % 3 == 2 { self.0 - 2 } else { self.0 + 1 })
    }

    /// The half-edge of the same triangle before this one.
    #[must_use]
    pub const fn previous(self) -> Self {
        Self(if self.0.is_multiple_of(3) { self.0 + 2 } else { self.0 - 1 })
    }
}

/// What keeps a mesh from being an oriented manifold. Edges are pairs of vertices, smaller index first.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Defects {
    /// Edges of more than two triangles.
    pub non_manifold_edges: Vec<[u32; 2]>,
    /// Edges that two triangles run through in the same direction.
    pub inconsistent_edges: Vec<[u32; 2]>,
    /// Vertices at which several fans of triangles meet in nothing but the vertex.
    pub non_manifold_vertices: Vec<u32>,
    /// Triangles that name a vertex twice; they have no part in the connectivity.
    pub degenerate_triangles: Vec<u32>,
}

impl Defects {
    /// Whether there is none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.non_manifold_edges.is_empty()
            && self.inconsistent_edges.is_empty()
            && self.non_manifold_vertices.is_empty()
            && self.degenerate_triangles.is_empty()
    }
}

impl fmt::Display for Defects {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        for (count, what) in [
            (self.non_manifold_edges.len(), "edges of more than two triangles"),
            (self.inconsistent_edges.len(), "edges with disagreeing normals"),
            (self.non_manifold_vertices.len(), "vertices of several fans"),
            (self.degenerate_triangles.len(), "degenerate triangles"),
        ] {
            if count > 0 {
                write!(f, "{separator}{count} {what}")?;
                separator = ", ";
            }
        }
        if separator.is_empty() { f.write_str("an oriented manifold") } else { Ok(()) }
    }
}

/// Which triangles, edges and vertices of a mesh are adjacent.
///
/// Half-edges of two triangles that share an edge in opposite directions are twins. All other edges, those of
/// [`Defects`] included, have no twins: the surface ends there, and what is wrong is reported, not repaired. Every vertex
/// starts from one half-edge; around a vertex with several fans only the one of that half-edge is seen.
///
/// ```
/// use mesh_core::HalfEdgeMesh;
///
/// let square = HalfEdgeMesh::of(4, &[[0, 1, 2], [0, 2, 3]]);
/// assert!(square.defects().is_empty());
/// assert_eq!(square.boundary_loops(), [[0, 1, 2, 3]]);
/// assert_eq!(square.neighbours(0).collect::<Vec<_>>(), [1, 2, 3]);
/// ```
#[derive(Debug, Clone)]
pub struct HalfEdgeMesh {
    triangles: Vec<[u32; 3]>,
    /// The twin of each half-edge, [`NONE`] at the boundary.
    twins: Vec<u32>,
    /// A half-edge out of each vertex, the first of its fan where it lies on the boundary; [`NONE`] if unused.
    outgoing: Vec<u32>,
    defects: Defects,
}

impl HalfEdgeMesh {
    /// The connectivity of a mesh, in which vertices that are one corner count as one: the first of them.
    #[must_use]
    pub fn new(mesh: &TriangleMesh) -> Self {
        Self::of(mesh.vertices().len(), &mesh.welded_triangles())
    }

    /// The connectivity of triangles over vertices `0 .. vertices`. Triangles with other indices count as degenerate.
    #[must_use]
    pub fn of(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let mut defects = Defects::default();
        // (smaller vertex, larger vertex, half-edge, runs from smaller to larger)
        let mut edges = Vec::with_capacity(3 * triangles.len());
        for (corners, triangle) in triangles.iter().zip(0u32..) {
            let [a, b, c] = *corners;
            if a == b || b == c || c == a || corners.iter().any(|&index| index as usize >= vertices) {
                defects.degenerate_triangles.push(triangle);
                continue;
            }
            for (edge, from, to) in [(0u8, a, b), (1, b, c), (2, c, a)] {
                edges.push((from.min(to), from.max(to), HalfEdge::new(triangle, edge).0, from < to));
            }
        }
        edges.sort_unstable();
        let mut twins = vec![NONE; 3 * triangles.len()];
        for edge in edges.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)) {
            match *edge {
                [_] => {}
                [one, other] if one.3 != other.3 => {
                    twins[one.2 as usize] = other.2;
                    twins[other.2 as usize] = one.2;
                }
                [one, _] => defects.inconsistent_edges.push([one.0, one.1]),
                _ => defects.non_manifold_edges.push([edge[0].0, edge[0].1]),
            }
        }
        let outgoing = vec![NONE; vertices];
        let mut mesh = Self { triangles: triangles.to_vec(), twins, outgoing, defects };
        mesh.find_fans(edges.iter().map(|edge| edge.2));
        mesh
    }

    /// Chooses a half-edge out of every vertex and notes the vertices with more than one fan.
    fn find_fans(&mut self, half_edges: impl Iterator<Item = u32>) {
        let mut sorted: Vec<u32> = half_edges.collect();
        sorted.sort_unstable();
        let mut seen = vec![false; self.twins.len()];
        for half_edge in sorted {
            if seen[half_edge as usize] {
                continue;
            }
            // Back to the beginning of the fan, or once around.
            let mut first = HalfEdge(half_edge);
            while let Some(before) = self.twin(first).map(HalfEdge::next) {
                first = before;
                if first.0 == half_edge {
                    break;
                }
            }
            let mut fan = Some(first);
            while let Some(spoke) = fan {
                seen[spoke.0 as usize] = true;
                fan = self.twin(spoke.previous()).filter(|&next| next != first);
            }
            let vertex = self.origin(first);
            match self.outgoing[vertex as usize] {
                NONE => self.outgoing[vertex as usize] = first.0,
                _ => self.defects.non_manifold_vertices.push(vertex),
            }
        }
        self.defects.non_manifold_vertices.sort_unstable();
        self.defects.non_manifold_vertices.dedup();
    }

    /// What is wrong with the mesh.
    #[must_use]
    pub const fn defects(&self) -> &Defects {
        &self.defects
    }

    /// Number of vertices, unused ones included.
    #[must_use]
    pub const fn vertex_count(&self) -> usize {
        self.outgoing.len()
    }

    /// The triangles, by the numbers of their vertices.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// All half-edges of triangles that are not degenerate, in ascending order.
    pub fn half_edges(&self) -> impl Iterator<Item = HalfEdge> {
        let mut degenerate = self.defects.degenerate_triangles.iter().peekable();
        (0u32..)
            .take(self.triangles.len())
            .filter(move |triangle| degenerate.next_if_eq(&triangle).is_none())
            .flat_map(|triangle| [0, 1, 2].map(|edge| HalfEdge::new(triangle, edge)))
    }

    /// The vertex in which a half-edge begins.
    #[must_use]
    pub fn origin(&self, half_edge: HalfEdge) -> u32 {
        self.triangles[half_edge.triangle()][half_edge.edge()]
    }

    /// The vertex in which a half-edge ends.
    #[must_use]
    pub fn target(&self, half_edge: HalfEdge) -> u32 {
        self.origin(half_edge.next())
    }

    /// The half-edge along the same edge in the other direction; `None` at the boundary.
    #[must_use]
    pub fn twin(&self, half_edge: HalfEdge) -> Option<HalfEdge> {
        Some(self.twins[half_edge.0 as usize]).filter(|&twin| twin != NONE).map(HalfEdge)
    }

    /// The half-edges out of a vertex, counter-clockwise; on the boundary the first lies on it. Empty if the vertex is
    /// unused or does not exist.
    pub fn spokes(&self, vertex: u32) -> impl Iterator<Item = HalfEdge> {
        let first =
            self.outgoing.get(vertex as usize).filter(|&&first| first != NONE).map(|&first| HalfEdge(first));
        std::iter::successors(first, move |spoke| {
            self.twin(spoke.previous()).filter(|&next| Some(next) != first)
        })
    }

    /// The vertices that share an edge with a vertex, counter-clockwise; around a vertex on the boundary, from one
    /// neighbour along the boundary to the other.
    pub fn neighbours(&self, vertex: u32) -> impl Iterator<Item = u32> {
        // A fan with a beginning ends with an edge into the vertex that has no twin.
        let last = (self.spokes(vertex).last())
            .map(HalfEdge::previous)
            .filter(|&last| self.twin(last).is_none())
            .map(|last| self.origin(last));
        self.spokes(vertex).map(|spoke| self.target(spoke)).chain(last)
    }

    /// Number of neighbours of a vertex.
    #[must_use]
    pub fn valence(&self, vertex: u32) -> usize {
        self.neighbours(vertex).count()
    }

    /// Whether the surface ends at a vertex. Unused vertices do not lie on the boundary.
    #[must_use]
    pub fn is_boundary(&self, vertex: u32) -> bool {
        self.spokes(vertex).next().is_some_and(|first| self.twin(first).is_none())
    }

    /// The boundaries as cycles of vertices, the surface on their left; each begins with its smallest half-edge.
    ///
    /// At a vertex where several fans meet a loop may pass more than once.
    #[must_use]
    pub fn boundary_loops(&self) -> Vec<Vec<u32>> {
        let mut seen = vec![false; self.twins.len()];
        let mut loops = Vec::new();
        for start in self.half_edges().filter(|&half_edge| self.twin(half_edge).is_none()) {
            let mut cycle = Vec::new();
            let mut current = start;
            while !std::mem::replace(&mut seen[current.0 as usize], true) {
                cycle.push(self.origin(current));
                // Around the end of the half-edge to the last triangle of its fan.
                current = current.next();
                while let Some(twin) = self.twin(current) {
                    current = twin.next();
                }
            }
            if !cycle.is_empty() {
                loops.push(cycle);
            }
        }
        loops
    }

    /// Vertices − edges + triangles, unused vertices and degenerate triangles left out: 2 for a sphere, 0 for a torus.
    #[must_use]
    pub fn euler_characteristic(&self) -> i64 {
        let (mut half, mut whole) = (0i64, 0i64);
        for half_edge in self.half_edges() {
            whole += 1;
            half += i64::from(self.twin(half_edge).is_some());
        }
        let vertices: i64 = self.outgoing.iter().map(|&first| i64::from(first != NONE)).sum();
        vertices - (whole - half / 2) + whole / 3
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

    #[test]
    fn walks_around_vertices() {
        let mesh = HalfEdgeMesh::of(5, &TETRAHEDRON);
        assert!(mesh.defects().is_empty());
        assert_eq!(mesh.defects().to_string(), "an oriented manifold");
        for vertex in 0..4 {
            let mut around: Vec<_> = mesh.neighbours(vertex).collect();
            around.sort_unstable();
            assert_eq!(around, (0..4).filter(|&other| other != vertex).collect::<Vec<_>>());
            assert!(!mesh.is_boundary(vertex));
        }
        assert_eq!((mesh.valence(4), mesh.valence(99), mesh.is_boundary(4)), (0, 0, false));
        assert_eq!((mesh.euler_characteristic(), mesh.boundary_loops().len()), (2, 0));
        for half_edge in mesh.half_edges() {
            let twin = mesh.twin(half_edge).unwrap();
            assert_eq!((mesh.origin(twin), mesh.twin(twin)), (mesh.target(half_edge), Some(half_edge)));
            assert_eq!(half_edge.next().next(), half_edge.previous());
        }
    }

    #[test]
    fn names_what_is_wrong() {
        let mut flipped = TETRAHEDRON;
        flipped[0].swap(1, 2);
        let mesh = HalfEdgeMesh::of(4, &flipped);
        assert_eq!(mesh.defects().inconsistent_edges, [[0, 1], [0, 2], [1, 2]]);
        assert_eq!(mesh.boundary_loops().len(), 2);

        let fan = HalfEdgeMesh::of(7, &[[0, 1, 2], [1, 0, 3], [0, 1, 4], [5, 5, 6], [0, 1, 7]]);
        assert_eq!(fan.defects().non_manifold_edges, [[0, 1]]);
        assert_eq!(fan.defects().degenerate_triangles, [3, 4]);
        assert_eq!(fan.half_edges().count(), 9);

        // Two triangles that touch in one vertex.
        let bow = HalfEdgeMesh::of(5, &[[0, 1, 2], [0, 3, 4]]);
        assert_eq!(bow.defects().non_manifold_vertices, [0]);
        assert_eq!(bow.defects().to_string(), "1 vertices of several fans");
        assert_eq!(bow.boundary_loops(), [[0, 1, 2], [0, 3, 4]]);
    }

    #[test]
    fn boundaries_of_a_ring() {
        // A strip of triangles closed to a ring: two boundaries.
        let ring: Vec<[u32; 3]> = (0..6)
            .flat_map(|i| {
                [[2 * i, (2 * i + 2) % 12, 2 * i + 1], [2 * i + 1, (2 * i + 2) % 12, (2 * i + 3) % 12]]
            })
            .collect();
        let mesh = HalfEdgeMesh::of(12, &ring);
        assert!(mesh.defects().is_empty());
        assert_eq!(mesh.boundary_loops(), [[0, 2, 4, 6, 8, 10], [3, 1, 11, 9, 7, 5]]);
        assert_eq!(mesh.euler_characteristic(), 0);
        assert_eq!(mesh.neighbours(2).collect::<Vec<_>>(), [4, 3, 1, 0]);
        assert!((0..12u32).all(|vertex| mesh.is_boundary(vertex)));
    }
}
