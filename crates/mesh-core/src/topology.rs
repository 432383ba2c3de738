//! How the triangles of a mesh hang together.

use std::fmt;

/// Edges of a mesh, counted by the triangles that meet there.
///
/// Triangles that name a vertex twice have no area and no edges; they are counted and left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MeshTopology {
    /// Number of triangles, those without edges included.
    pub triangles: usize,
    /// Number of different edges.
    pub edges: usize,
    /// Edges of one triangle only.
    pub boundary_edges: usize,
    /// Edges of more than two triangles.
    pub non_manifold_edges: usize,
    /// Edges that two triangles run through in the same direction, so that their normals disagree.
    pub inconsistent_edges: usize,
    /// Triangles that name a vertex twice.
    pub degenerate_triangles: usize,
}

impl MeshTopology {
    /// Counts the edges of triangles given by vertex indices.
    #[must_use]
    pub fn of(triangles: &[[u32; 3]]) -> Self {
        EdgeMap::of(triangles).topology
    }

    /// Whether every edge belongs to exactly two triangles, and there is at least one.
    #[must_use]
    pub const fn is_closed(&self) -> bool {
        self.edges > 0 && self.boundary_edges == 0 && self.non_manifold_edges == 0
    }

    /// Whether neighbouring triangles always agree on the side of their normals.
    #[must_use]
    pub const fn is_oriented(&self) -> bool {
        self.inconsistent_edges == 0
    }

    /// Whether the mesh encloses a solid: closed and oriented.
    #[must_use]
    pub const fn is_solid(&self) -> bool {
        self.is_closed() && self.is_oriented()
    }
}

impl fmt::Display for MeshTopology {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} triangles, {} edges", self.triangles, self.edges)?;
        for (count, what) in [
            (self.boundary_edges, "boundary edges"),
            (self.non_manifold_edges, "edges of more than two triangles"),
            (self.inconsistent_edges, "edges with disagreeing normals"),
            (self.degenerate_triangles, "degenerate triangles"),
        ] {
            if count > 0 {
                write!(f, ", {count} {what}")?;
            }
        }
        f.write_str(if self.is_solid() { "; closed" } else { "; not a closed solid" })
    }
}

/// Means "no triangle" in [`EdgeMap::neighbours`].
pub(crate) const NONE: u32 = u32::MAX;

/// The triangle across each edge.
pub(crate) struct EdgeMap {
    pub(crate) topology: MeshTopology,
    /// Per triangle and edge the one other triangle there, [`NONE`] where there is none or more than one.
    pub(crate) neighbours: Vec<[u32; 3]>,
}

impl EdgeMap {
    pub(crate) fn of(triangles: &[[u32; 3]]) -> Self {
        let mut topology = MeshTopology { triangles: triangles.len(), ..MeshTopology::default() };
        // Sorted half edges: (smaller vertex, larger vertex, triangle, edge, runs from smaller to larger).
        let mut half_edges = Vec::with_capacity(3 * triangles.len());
        for (corners, triangle) in triangles.iter().zip(0u32..) {
            let [a, b, c] = *corners;
            if a == b || b == c || c == a {
                topology.degenerate_triangles += 1;
                continue;
            }
            for (edge, from, to) in [(0u8, a, b), (1, b, c), (2, c, a)] {
                half_edges.push((from.min(to), from.max(to), triangle, edge, from < to));
            }
        }
        half_edges.sort_unstable();
        let mut neighbours = vec![[NONE; 3]; triangles.len()];
        for edge in half_edges.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)) {
            topology.edges += 1;
            match *edge {
                [_] => topology.boundary_edges += 1,
                [one, other] => {
                    topology.inconsistent_edges += usize::from(one.4 == other.4);
                    neighbours[one.2 as usize][usize::from(one.3)] = other.2;
                    neighbours[other.2 as usize][usize::from(other.3)] = one.2;
                }
                _ => topology.non_manifold_edges += 1,
            }
        }
        Self { topology, neighbours }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

    #[test]
    fn recognises_a_solid() {
        let topology = MeshTopology::of(&TETRAHEDRON);
        assert!(topology.is_solid());
        assert_eq!(topology.to_string(), "4 triangles, 6 edges; closed");
        assert!(!MeshTopology::of(&[]).is_closed());
    }

    #[test]
    fn counts_what_is_wrong() {
        let open = MeshTopology::of(&TETRAHEDRON[..3]);
        assert_eq!((open.boundary_edges, open.is_closed()), (3, false));
        let mut flipped = TETRAHEDRON;
        flipped[0].swap(1, 2);
        assert_eq!(MeshTopology::of(&flipped).inconsistent_edges, 3);
        let fan = MeshTopology::of(&[[0, 1, 2], [1, 0, 3], [0, 1, 4], [5, 5, 6]]);
        assert_eq!((fan.non_manifold_edges, fan.degenerate_triangles), (1, 1));
        assert_eq!(
            fan.to_string(),
            "4 triangles, 7 edges, 6 boundary edges, 1 edges of more than two triangles, 1 degenerate triangles; \
             not a closed solid"
        );
    }
}
