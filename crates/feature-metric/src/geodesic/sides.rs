//! What windows need to know of the half-edges of a mesh, side by side in memory.

use crate::MetricMesh;

/// Number of a half-edge: `3 · triangle + edge`.
pub(super) type Number = u32;

/// Stands for the half-edge on the other side where there is none.
const NONE: Number = Number::MAX;

/// A half-edge, seen from inside of its triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    pub(super) length: f64,
    /// The opposite vertex in the frame of the half-edge: along it from its origin, and to its left.
    pub(super) apex: [f64; 2],
    pub(super) origin: u32,
    /// The half-edge on the other side.
    twin: Number,
}

/// All half-edges of a mesh.
#[derive(Debug)]
pub(super) struct Sides {
    sides: Vec<Side>,
}

impl Sides {
    pub(super) fn new(mesh: &MetricMesh) -> Self {
        let connectivity = &mesh.connectivity;
        let empty = Side { length: 0.0, apex: [0.0; 2], origin: 0, twin: NONE };
        let mut sides = vec![empty; 3 * connectivity.triangles().len()];
        for half_edge in connectivity.half_edges() {
            sides[number_of(half_edge) as usize] = Side {
                length: mesh.length(half_edge),
                apex: mesh.apex(half_edge),
                origin: connectivity.origin(half_edge),
                twin: connectivity.twin(half_edge).map_or(NONE, number_of),
            };
        }
        Self { sides }
    }

    pub(super) fn len(&self) -> usize {
        self.sides.len()
    }

    #[inline]
    pub(super) fn get(&self, number: Number) -> &Side {
        &self.sides[number as usize]
    }

    /// The half-edge on the other side; `None` at the boundary.
    #[inline]
    pub(super) fn twin(&self, number: Number) -> Option<Number> {
        let twin = self.get(number).twin;
        (twin != NONE).then_some(twin)
    }

    /// The origin of the half-edge that follows.
    #[inline]
    pub(super) fn target(&self, number: Number) -> u32 {
        self.get(next(number)).origin
    }

    /// The vertex opposite to a half-edge.
    #[inline]
    pub(super) fn opposite(&self, number: Number) -> u32 {
        self.get(previous(number)).origin
    }
}

/// The number of a half-edge.
pub(super) fn number_of(half_edge: mesh_core::HalfEdge) -> Number {
    // Half-edges are counted in 32 bits, so their numbers fit.
    Number::try_from(3 * half_edge.triangle() + half_edge.edge()).unwrap_or(NONE)
}

/// The half-edge that follows in its triangle.
#[inline]
pub(super) fn next(number: Number) -> Number {
    if number % 3 == 2 { number - 2 } else { number + 1 }
}

/// The half-edge before in its triangle.
#[inline]
pub(super) fn previous(number: Number) -> Number {
    if number.is_multiple_of(3) { number + 2 } else { number - 1 }
}
