//! The vertices that act on a triangle, in an order that follows from the connectivity alone.

use super::box_spline::REGULAR;
use crate::HalfEdgeMesh;

/// Where the twelve vertices of a regular triangle lie in the lattice that is spanned by its edges from the first corner:
/// the corners, the vertices across the edges, the outer vertices, in the order of the box spline.
pub(super) const PLACES: [[i32; 2]; REGULAR] =
    [[0, 0], [1, 0], [0, 1], [1, -1], [1, 1], [-1, 1], [0, -1], [-1, 0], [2, 0], [2, -1], [-1, 2], [0, 2]];

/// Neighbours in the lattice, counter-clockwise.
const STEPS: [[i32; 2]; 6] = [[1, 0], [0, 1], [-1, 1], [-1, 0], [0, -1], [1, -1]];

/// A vertex as weights of others.
pub(super) type Combination = Vec<(u32, f64)>;

/// How the surface goes on around one corner of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Corner {
    /// All around, with this number of neighbours.
    Inside(usize),
    /// On the boundary, with this number of triangles before and after the triangle, counter-clockwise.
    Boundary(usize, usize),
}

impl Corner {
    /// Whether the limit there is a box spline: six neighbours, or three triangles on the boundary.
    pub(super) fn is_regular(self) -> bool {
        match self {
            Self::Inside(count) => count == 6,
            Self::Boundary(before, after) => before + after == 2,
        }
    }
}

/// The corner `a` of a triangle `a, b, …`, counter-clockwise, and the neighbours of `a` from `b` on. On the boundary the
/// ring is cut: the neighbours before `b` follow at the end, with the number of those that come first.
fn ring(mesh: &HalfEdgeMesh, a: u32, b: u32) -> (Corner, Vec<u32>) {
    let mut around: Vec<u32> = mesh.neighbours(a).collect();
    let start = around.iter().position(|&vertex| vertex == b).unwrap_or(0);
    let corner = if mesh.is_boundary(a) {
        Corner::Boundary(start, around.len().saturating_sub(start + 2))
    } else {
        Corner::Inside(around.len())
    };
    around.rotate_left(start);
    (corner, around)
}

/// How the surface goes on at the three corners.
pub(super) fn corners(mesh: &HalfEdgeMesh, [a, b, c]: [u32; 3]) -> [Corner; 3] {
    [ring(mesh, a, b).0, ring(mesh, b, c).0, ring(mesh, c, a).0]
}

/// All vertices of the triangle and of the rings of its corners, each once.
pub(super) fn vertices(mesh: &HalfEdgeMesh, [a, b, c]: [u32; 3]) -> Vec<u32> {
    let mut out = vec![a, b, c];
    for (corner, next) in [(a, b), (b, c), (c, a)] {
        for vertex in ring(mesh, corner, next).1 {
            if !out.contains(&vertex) {
                out.push(vertex);
            }
        }
    }
    out
}

/// The twelve vertices of a regular triangle. Beyond a boundary there are none: those that would give the rules of the
/// boundary are mirror images of the vertices inside, `a + b − c` across a boundary edge `ab`.
pub(super) fn regular(mesh: &HalfEdgeMesh, triangle: [u32; 3]) -> Option<[Combination; REGULAR]> {
    let mut known: [Option<u32>; REGULAR] = [None; REGULAR];
    for k in 0..3 {
        known[k] = Some(triangle[k]);
    }
    for k in 0..3 {
        let (corner, around) = ring(mesh, triangle[k], triangle[(k + 1) % 3]);
        if !corner.is_regular() {
            return None;
        }
        // Directions around the corner, counter-clockwise, from the next corner on.
        let first = STEPS.iter().position(|step| {
            let [from, to] = [PLACES[k], PLACES[(k + 1) % 3]];
            [from[0] + step[0], from[1] + step[1]] == to
        })?;
        for (i, &vertex) in around.iter().enumerate() {
            let turn = match corner {
                Corner::Inside(_) => i,
                // The last `before` ones come before the first, clockwise.
                Corner::Boundary(before, _) if i + before >= around.len() => 6 + i - around.len(),
                Corner::Boundary(..) => i,
            };
            let step = STEPS[(first + turn) % 6];
            let place = [PLACES[k][0] + step[0], PLACES[k][1] + step[1]];
            if let Some(slot) = PLACES.iter().position(|p| *p == place) {
                known[slot] = Some(vertex);
            }
        }
    }
    let vertex = |place: [i32; 2]| PLACES.iter().position(|p| *p == place).and_then(|slot| known[slot]);
    let mut out: [Combination; REGULAR] = Default::default();
    for (slot, place) in PLACES.iter().enumerate() {
        if let Some(vertex) = known[slot] {
            out[slot] = vec![(vertex, 1.0)];
            continue;
        }
        out[slot] = (0..6).find_map(|k| {
            let (one, other) = (STEPS[k], STEPS[(k + 1) % 6]);
            let a = [place[0] + one[0], place[1] + one[1]];
            let b = [place[0] + other[0], place[1] + other[1]];
            let c = [a[0] + other[0], a[1] + other[1]];
            Some(vec![(vertex(a)?, 1.0), (vertex(b)?, 1.0), (vertex(c)?, -1.0)])
        })?;
    }
    Some(out)
}
