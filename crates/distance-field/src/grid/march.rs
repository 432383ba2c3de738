//! Fast marching (Sethian 1996), of first and second order.

use super::eikonal::solve;
use super::{Lattice, Medium, Seed};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// A node on the front; the least distance comes first, of equal ones the first node.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Front {
    distance: f64,
    node: usize,
}

impl Eq for Front {}

impl Ord for Front {
    fn cmp(&self, other: &Self) -> Ordering {
        other.distance.total_cmp(&self.distance).then(other.node.cmp(&self.node))
    }
}

impl PartialOrd for Front {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Distances in the order in which a front reaches the nodes, by upwind differences of first or, where two nodes upwind are known,
/// of second order.
///
/// Seeds keep their distances, blocked nodes and those that cannot be reached are infinite. The second order is reached where the
/// seeds fill a ball of some nodes around each source: next to a point the differences are of no order at all.
#[must_use]
pub fn march<const D: usize>(
    lattice: &Lattice<D>,
    seeds: &[Seed],
    medium: &Medium,
    second_order: bool,
) -> Vec<f64> {
    let nodes = lattice.len();
    let mut values = vec![f64::INFINITY; nodes];
    let mut is_done = vec![false; nodes];
    let mut front = BinaryHeap::new();
    for seed in seeds.iter().filter(|seed| !medium.is_blocked(seed.node)) {
        values[seed.node] = seed.distance;
        front.push(Front { distance: seed.distance, node: seed.node });
    }
    let is_seed: Vec<bool> = values.iter().map(|value| value.is_finite()).collect();
    let counts = lattice.counts();
    let strides: [usize; D] = std::array::from_fn(|k| lattice.stride(k));
    while let Some(Front { distance, node }) = front.pop() {
        if is_done[node] || distance > values[node] {
            continue;
        }
        is_done[node] = true;
        let at = lattice.indices(node);
        for k in 0..D {
            for up in [false, true] {
                if if up { at[k] + 1 == counts[k] } else { at[k] == 0 } {
                    continue;
                }
                let next = if up { node + strides[k] } else { node - strides[k] };
                if is_done[next] || is_seed[next] || medium.is_blocked(next) {
                    continue;
                }
                let found = arrival(lattice, &strides, next, &values, &is_done, medium, second_order);
                if found < values[next] {
                    values[next] = found;
                    front.push(Front { distance: found, node: next });
                }
            }
        }
    }
    values
}

/// When the front arrives at a node from those that it has passed.
fn arrival<const D: usize>(
    lattice: &Lattice<D>,
    strides: &[usize; D],
    node: usize,
    values: &[f64],
    is_done: &[bool],
    medium: &Medium,
    second_order: bool,
) -> f64 {
    let (counts, spacing, at) = (lattice.counts(), lattice.spacing(), lattice.indices(node));
    let mut first = ([f64::INFINITY; D], [1.0; D]);
    let mut second = first;
    for k in 0..D {
        let c = 1.0 / spacing[k];
        let stride = strides[k];
        // The value one node away and, if it is known and no larger, the one two nodes away.
        let upwind = |one: usize, further: Option<usize>| {
            let value = if is_done[one] { values[one] } else { f64::INFINITY };
            let two = further.filter(|&two| is_done[two] && values[two] <= value).map(|two| values[two]);
            (value, two)
        };
        let below = if at[k] > 0 {
            upwind(node - stride, (at[k] > 1).then(|| node - 2 * stride))
        } else {
            (f64::INFINITY, None)
        };
        let above = if at[k] + 1 < counts[k] {
            upwind(node + stride, (at[k] + 2 < counts[k]).then(|| node + 2 * stride))
        } else {
            (f64::INFINITY, None)
        };
        let (one, two) = if above.0 < below.0 { above } else { below };
        (first.0[k], first.1[k]) = (one, c);
        (second.0[k], second.1[k]) = match two {
            Some(two) => ((4.0 * one - two) / 3.0, 1.5 * c),
            None => (one, c),
        };
    }
    let slowness = medium.slowness(node);
    let plain = solve(first.0, first.1, slowness);
    if !second_order {
        return plain;
    }
    // Not earlier than what it comes from: where fronts meet, the second differences mean nothing.
    let least = first.0.iter().copied().fold(f64::INFINITY, f64::min);
    let found = solve(second.0, second.1, slowness);
    if found.is_finite() && found >= least { found } else { plain }
}
