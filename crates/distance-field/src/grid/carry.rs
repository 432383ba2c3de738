//! Closest points carried from node to node (Tsai, *Rapid and accurate computation of the distance function using grids*, 2002).

use super::{Element, Lattice, Seed};

/// Most rounds of `2^D` sweeps.
const MOST_ROUNDS: usize = 100;

/// Distances by sweeps in which each node tries the nearest elements of its neighbours, also the diagonal ones; returns the rounds
/// of sweeps as well.
///
/// Every value is the exact distance of an element: of the nearest one if there is one only, and but for few nodes where the
/// nearest of many reaches a node through no chain of neighbours.
#[must_use]
pub fn carry<const D: usize>(
    lattice: &Lattice<D>,
    elements: &[Element<D>],
    seeds: &[Seed],
) -> (Vec<f64>, usize) {
    let nodes = lattice.len();
    let mut values = vec![f64::INFINITY; nodes];
    let mut nearest = vec![u32::MAX; nodes];
    for seed in seeds {
        (values[seed.node], nearest[seed.node]) = (seed.distance, seed.element);
    }
    for round in 1..=MOST_ROUNDS {
        let mut has_changed = false;
        for direction in 0..1usize << D {
            has_changed |= one_way(lattice, direction, elements, &mut values, &mut nearest);
        }
        if !has_changed {
            return (values, round);
        }
    }
    (values, MOST_ROUNDS)
}

/// One sweep, along axis `k` downwards where bit `k` of `direction` is set; returns whether a value has changed.
fn one_way<const D: usize>(
    lattice: &Lattice<D>,
    direction: usize,
    elements: &[Element<D>],
    values: &mut [f64],
    nearest: &mut [u32],
) -> bool {
    let counts = lattice.counts();
    let strides: [usize; D] = std::array::from_fn(|k| lattice.stride(k));
    let mut has_changed = false;
    let mut step = [0usize; D];
    loop {
        let at: [usize; D] =
            std::array::from_fn(|k| if direction >> k & 1 == 1 { counts[k] - 1 - step[k] } else { step[k] });
        let node: usize = (0..D).map(|k| at[k] * strides[k]).sum();
        let x = lattice.point(node);
        // All offsets of −1, 0, 1 along the axes.
        let mut tried = nearest[node];
        for offset in 0..3usize.pow(u32::try_from(D).unwrap_or(3)) {
            let mut rest = offset;
            let mut other = Some(0);
            for k in 0..D {
                let place = (at[k] + rest % 3).checked_sub(1).filter(|&place| place < counts[k]);
                other = other.zip(place).map(|(sum, place)| sum + place * strides[k]);
                rest /= 3;
            }
            let Some(element) = other.map(|other| nearest[other]).filter(|&e| e != u32::MAX && e != tried)
            else {
                continue;
            };
            tried = element;
            let distance = elements[element as usize].distance(&x);
            if distance < values[node] {
                (values[node], nearest[node]) = (distance, element);
                has_changed = true;
            }
        }
        let Some(axis) = (0..D).rev().find(|&k| step[k] + 1 < counts[k]) else { return has_changed };
        step[axis] += 1;
        step[axis + 1..].fill(0);
    }
}
