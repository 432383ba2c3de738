//! The masks of Loop's scheme, over a vertex and its neighbours.

use std::f64::consts::{PI, TAU};

/// Weights of control vertices, by their numbers.
pub type Mask = Vec<(u32, f64)>;

/// Weight of each of `n` neighbours in the new position of an interior vertex (\[Lo87\]).
fn interior_weight(n: usize) -> f64 {
    let root = 0.375 + 0.25 * (TAU / n as f64).cos();
    (0.625 - root * root) / n as f64
}

/// New position of an interior vertex.
pub(super) fn interior_vertex(vertex: u32, around: &[u32]) -> Mask {
    star(vertex, around, interior_weight(around.len()))
}

/// Limit position of an interior vertex.
pub(super) fn interior_limit(vertex: u32, around: &[u32]) -> Mask {
    let n = around.len();
    star(vertex, around, 1.0 / (0.375 / interior_weight(n) + n as f64))
}

/// The same weight for all neighbours, the rest for the vertex.
fn star(vertex: u32, around: &[u32], weight: f64) -> Mask {
    let own = (vertex, 1.0 - around.len() as f64 * weight);
    std::iter::once(own).chain(around.iter().map(|&other| (other, weight))).collect()
}

/// Two tangent vectors at the limit of an interior vertex: the left eigenvectors of the subdivision matrix with the
/// second largest eigenvalue. Their vector product is along the normal.
pub(super) fn interior_tangents(around: &[u32]) -> [Mask; 2] {
    let step = TAU / around.len() as f64;
    let mask = |weight: fn(f64) -> f64| {
        around.iter().enumerate().map(|(i, &other)| (other, weight(step * i as f64))).collect()
    };
    [mask(f64::cos), mask(f64::sin)]
}

/// New position of a vertex on the boundary, a cubic B-spline curve.
pub(super) fn boundary_vertex(vertex: u32, [before, after]: [u32; 2]) -> Mask {
    vec![(vertex, 0.75), (before, 0.125), (after, 0.125)]
}

/// Limit position of a vertex on the boundary.
pub(super) fn boundary_limit(vertex: u32, [before, after]: [u32; 2]) -> Mask {
    vec![(vertex, 2.0 / 3.0), (before, 1.0 / 6.0), (after, 1.0 / 6.0)]
}

/// Tangent vectors along and across the boundary at the limit of a vertex on it, whose neighbours run counter-clockwise
/// from one side of the boundary to the other. Their vector product is along the normal.
///
/// The second is the left eigenvector of the subdivision matrix with the eigenvalue `3/8 + cos θ / 4`,
/// `θ = π / (k − 1)`. Its inner weights are `sin iθ`, and from the columns of the boundary and of the vertex follow
/// `−cot(θ/2) cos θ / (1 + 2 cos θ)` and `−cot(θ/2) / (1 + 2 cos θ)`. With two neighbours it is the eigenvector of 1/4.
pub(super) fn boundary_tangents(vertex: u32, around: &[u32]) -> Option<[Mask; 2]> {
    let [first, inner @ .., last] = around else { return None };
    let along = vec![(*first, 0.5), (*last, -0.5)];
    if inner.is_empty() {
        return Some([along, vec![(*first, 1.0), (*last, 1.0), (vertex, -2.0)]]);
    }
    let theta = PI / (inner.len() + 1) as f64;
    let own = -1.0 / ((0.5 * theta).tan() * (1.0 + 2.0 * theta.cos()));
    let end = own * theta.cos();
    let mut across = vec![(vertex, own), (*first, end), (*last, end)];
    across.extend(inner.iter().enumerate().map(|(i, &other)| (other, (theta * (i + 1) as f64).sin())));
    Some([along, across])
}
