//! Trees of shortest edges.

use nalgebra::SVector;

/// Points that are connected.
pub(super) struct Groups {
    parent: Vec<usize>,
}

impl Groups {
    pub(super) fn new(count: usize) -> Self {
        Self { parent: (0..count).collect() }
    }

    /// The first point of a group, the same for all of its points.
    pub(super) fn first(&mut self, mut i: usize) -> usize {
        while self.parent[i] != i {
            self.parent[i] = self.parent[self.parent[i]];
            i = self.parent[i];
        }
        i
    }

    /// Connects two points; whether they were not connected.
    pub(super) fn connect(&mut self, i: usize, j: usize) -> bool {
        let (a, b) = (self.first(i), self.first(j));
        self.parent[a.max(b)] = a.min(b);
        a != b
    }
}

/// The edges of the shortest forest among edges to neighbours (Kruskal's algorithm), the shortest first, with their lengths.
pub(super) fn shortest_forest<const D: usize>(
    points: &[SVector<f64, D>],
    near: &[Vec<usize>],
) -> Vec<(usize, usize, f64)> {
    let mut edges: Vec<(usize, usize, f64)> = Vec::new();
    for (i, near) in near.iter().enumerate() {
        edges.extend(near.iter().map(|&j| (i.min(j), i.max(j), (points[i] - points[j]).norm())));
    }
    edges.sort_by(|a, b| a.2.total_cmp(&b.2).then((a.0, a.1).cmp(&(b.0, b.1))));
    let mut groups = Groups::new(points.len());
    edges.retain(|&(i, j, _)| groups.connect(i, j));
    edges
}
