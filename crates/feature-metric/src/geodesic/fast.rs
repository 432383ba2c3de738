//! Distances from triangle to triangle, corrected until none becomes shorter.

use super::queue::Queue;
use crate::MetricMesh;
use mesh_core::HalfEdge;

/// Times that a distance may be corrected after it was thought to be final: obtuse triangles need some.
const CORRECTIONS: u8 = 10;
/// Share by which a distance must become shorter to count as corrected.
const PROGRESS: f64 = 1e-12;

/// The form of a wave front that enters a triangle over an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Front {
    /// A circle around the point that has the distances of both ends.
    Circle,
    /// A straight line.
    Line,
}

/// Distances of all vertices from the nearest source.
pub(super) fn distances(mesh: &MetricMesh, sources: &[u32], front: Front) -> Vec<f64> {
    let count = mesh.connectivity.vertex_count();
    let (mut distances, mut corrections) = (vec![f64::INFINITY; count], vec![0u8; count]);
    let mut queue = Queue::new();
    for &source in sources {
        distances[source as usize] = 0.0;
        queue.push(0.0, source);
    }
    while let Some((distance, vertex)) = queue.pop() {
        if distance > distances[vertex as usize] || corrections[vertex as usize] > CORRECTIONS {
            continue;
        }
        corrections[vertex as usize] += 1;
        let mut improve = |vertex: u32, value: f64| {
            let known = &mut distances[vertex as usize];
            if value < *known * (1.0 - PROGRESS) || known.is_infinite() && value.is_finite() {
                *known = value;
                queue.push(value, vertex);
            }
            *known
        };
        for spoke in mesh.spokes(vertex) {
            let (across, back) = (spoke.next(), spoke.previous());
            let (b, c) = (mesh.connectivity.target(spoke), mesh.connectivity.origin(back));
            let (to_b, to_c, between) = (mesh.length(spoke), mesh.length(back), mesh.length(across));
            let at_b = improve(b, distance + to_b);
            let at_c = improve(c, distance + to_c);
            // Over the edge from the vertex to each of the others.
            improve(c, over(front, [distance, at_b], to_b, to_c, between));
            improve(b, over(front, [distance, at_c], to_c, to_b, between));
            // Over the opposite edge, into the next triangle.
            if let Some(next) = mesh.connectivity.twin(across) {
                let apex = mesh.connectivity.origin(next.previous());
                let direct = if distance == 0.0 { unfolded(mesh, spoke, next) } else { None };
                if let Some(length) = direct {
                    improve(apex, length);
                }
            }
        }
    }
    distances
}

/// The distance of a vertex that the wave reaches over an edge of this length, at whose ends it is known; `near` and `far` are the
/// lengths of the edges from these ends to the vertex. Infinite where the wave does not come over the edge.
fn over(front: Front, known: [f64; 2], length: f64, near: f64, far: f64) -> f64 {
    let [a, b] = known;
    if !(b.is_finite() && length > 0.0) {
        return f64::INFINITY;
    }
    // The edge along the first axis, the vertex above it.
    let x = (length * length + near * near - far * far) / (2.0 * length);
    let y = (near * near - x * x).max(0.0).sqrt();
    match front {
        Front::Circle => {
            let u = (length * length + a * a - b * b) / (2.0 * length);
            let height = a * a - u * u;
            // Without a point that has both distances, the shorter one came along the edge.
            if height < 0.0 {
                return f64::INFINITY;
            }
            let v = height.sqrt();
            let crossing = u + (x - u) * v / (v + y);
            if (0.0..=length).contains(&crossing) { (x - u).hypot(y + v) } else { f64::INFINITY }
        }
        Front::Line => {
            let slope = (b - a) / length;
            if slope.abs() >= 1.0 {
                return f64::INFINITY;
            }
            let rise = (1.0 - slope * slope).sqrt();
            // The line from the vertex against the direction of the wave meets the edge.
            let crossing = x - y * slope / rise;
            if (0.0..=length).contains(&crossing) { a + x * slope + y * rise } else { f64::INFINITY }
        }
    }
}

/// The straight line from the origin of a spoke to the far vertex of the triangle behind its opposite edge, if it crosses that.
fn unfolded(mesh: &MetricMesh, spoke: HalfEdge, next: HalfEdge) -> Option<f64> {
    let across = spoke.next();
    // Along the opposite edge: the vertex on its left, the far one on its right.
    let [px, py] = mesh.apex(across);
    let [qx, qy] = mesh.apex(next);
    let length = mesh.length(across);
    let (qx, qy) = (length - qx, -qy);
    let crossing = px + (qx - px) * py / (py - qy);
    (0.0..=length).contains(&crossing).then(|| (qx - px).hypot(qy - py))
}
