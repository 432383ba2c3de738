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
    let around = around(lattice);
    let directions = 1usize << D;
    // When no direction has changed anything since it was last swept, none will.
    let mut quiet = 0;
    for count in 1..=MOST_ROUNDS * directions {
        let direction = (count - 1) % directions;
        let has_changed = one_way(lattice, direction, elements, &around, &mut values, &mut nearest);
        quiet = if has_changed { 0 } else { quiet + 1 };
        if quiet == directions {
            return (values, count.div_ceil(directions));
        }
    }
    (values, MOST_ROUNDS)
}

/// The offsets of −1, 0, 1 along the axes, as differences of nodes.
fn around<const D: usize>(lattice: &Lattice<D>) -> Vec<isize> {
    let strides: [usize; D] = std::array::from_fn(|k| lattice.stride(k));
    let difference = |offset: usize| {
        let mut rest = offset;
        let mut sum = 0;
        for stride in strides {
            let stride = isize::try_from(stride).unwrap_or(isize::MAX);
            sum += match rest % 3 {
                0 => -stride,
                1 => 0,
                _ => stride,
            };
            rest /= 3;
        }
        sum
    };
    (0..3usize.pow(u32::try_from(D).unwrap_or(3))).map(difference).collect()
}

/// One sweep, along axis `k` downwards where bit `k` of `direction` is set; returns whether a value has changed.
fn one_way<const D: usize>(
    lattice: &Lattice<D>,
    direction: usize,
    elements: &[Element<D>],
    around: &[isize],
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
        let is_inner = (0..D).all(|k| at[k] > 0 && at[k] + 1 < counts[k]);
        let mut tried = nearest[node];
        let mut place = None;
        for (offset, &difference) in around.iter().enumerate() {
            let other = if is_inner {
                Some(node.wrapping_add_signed(difference))
            } else {
                beside(&at, &counts, offset).then(|| node.wrapping_add_signed(difference))
            };
            let Some(element) = other.map(|other| nearest[other]).filter(|&e| e != u32::MAX && e != tried)
            else {
                continue;
            };
            tried = element;
            let x = place.get_or_insert_with(|| lattice.point(node));
            let distance = elements[element as usize].distance(x);
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

/// Whether the node at an offset is one of the grid.
fn beside<const D: usize>(at: &[usize; D], counts: &[usize; D], offset: usize) -> bool {
    let mut rest = offset;
    (0..D).all(|k| {
        let place = (at[k] + rest % 3).checked_sub(1);
        rest /= 3;
        place.is_some_and(|place| place < counts[k])
    })
}
