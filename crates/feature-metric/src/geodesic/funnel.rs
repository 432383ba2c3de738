//! The shortest way through a strip of unfolded triangles.

use crate::MetricMesh;
use mesh_core::HalfEdge;

/// A bend of the shortest way: the side of the portal at which it lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Bend {
    /// Index of a portal of which the vertex is an end.
    pub(super) portal: usize,
    /// The vertex.
    pub(super) vertex: u32,
}

/// A strip unfolded into the plane.
#[derive(Debug)]
pub(super) struct Strip {
    /// Left and right ends of the edges that are crossed.
    pub(super) portals: Vec<[[f64; 2]; 2]>,
    pub(super) start: [f64; 2],
    pub(super) end: [f64; 2],
}

impl Strip {
    /// Unfolds the triangles between edges, each given by its half-edge in the triangle that is left; the strip begins in the vertex
    /// opposite to the first and ends in the one behind the last. `None` without edges, and where the strip runs into a boundary.
    pub(super) fn unfold(mesh: &MetricMesh, crossed: &[HalfEdge]) -> Option<Self> {
        let first = *crossed.first()?;
        let [x, y] = mesh.apex(first);
        // The first edge along the first axis; the way leaves to its right, so its target is on the left of the way.
        let mut portals = vec![[[mesh.length(first), 0.0], [0.0, 0.0]]];
        let mut end = [x, y];
        for (k, &edge) in crossed.iter().enumerate() {
            let entered = mesh.connectivity.twin(edge)?;
            let [left, right] = portals[k];
            // The half-edge of the entered triangle runs from left to right.
            let length = mesh.length(entered);
            let (cosine, sine) = if length > 0.0 {
                ((right[0] - left[0]) / length, (right[1] - left[1]) / length)
            } else {
                (1.0, 0.0)
            };
            let [x, y] = mesh.apex(entered);
            let apex = [left[0] + x * cosine - y * sine, left[1] + x * sine + y * cosine];
            end = apex;
            if let Some(&next) = crossed.get(k + 1) {
                // From the target of the twin's next: right to apex, or apex to left.
                if next == entered.next() {
                    portals.push([apex, right]);
                } else if next == entered.previous() {
                    portals.push([left, apex]);
                } else {
                    return None;
                }
            }
        }
        Some(Self { portals, start: [x, y], end })
    }

    /// The bends of the shortest way, by the funnel algorithm.
    pub(super) fn bends(&self, mesh: &MetricMesh, crossed: &[HalfEdge]) -> Vec<Bend> {
        let count = self.portals.len();
        // The end is a portal without width.
        let portal = |k: usize| self.portals.get(k).copied().unwrap_or([self.end, self.end]);
        let vertex = |k: usize, side: usize| {
            let edge = crossed[k.min(count - 1)];
            if side == 0 { mesh.connectivity.target(edge) } else { mesh.connectivity.origin(edge) }
        };
        let mut bends = Vec::new();
        let mut apex = self.start;
        let (mut ends, mut at) = (portal(0), [0usize; 2]);
        let mut k = 1;
        // Each restart moves the apex forward along the strip.
        while k <= count {
            let next = portal(k);
            let mut restart = None;
            for side in [0usize, 1] {
                let sign = if side == 0 { 1.0 } else { -1.0 };
                let other = 1 - side;
                // Inwards of the present end on this side?
                if sign * turn(apex, ends[side], next[side]) <= 0.0 {
                    if apex == ends[side] || sign * turn(apex, ends[other], next[side]) > 0.0 {
                        (ends[side], at[side]) = (next[side], k);
                    } else {
                        // Over the other side: the way bends there.
                        restart = Some(other);
                        break;
                    }
                }
            }
            // At the end both sides are one: nothing bends there.
            if let Some(side) = restart.filter(|&side| at[side] < count) {
                bends.push(Bend { portal: at[side], vertex: vertex(at[side], side) });
                apex = ends[side];
                // Past all portals that end in this vertex.
                let mut from = at[side];
                while from + 1 < count && portal(from + 1)[side] == apex {
                    from += 1;
                }
                (ends, at) = (portal(from + 1), [from + 1; 2]);
                k = from + 2;
                continue;
            }
            k += 1;
        }
        bends
    }
}

/// Twice the area of a triangle, positive if it turns left.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}
