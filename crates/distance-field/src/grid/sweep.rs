//! Fast sweeping (Zhao, *A fast sweeping method for Eikonal equations*, 2005).

use super::eikonal::solve;
use super::{Lattice, Medium, Seed};

/// Changes below this share of the size of the box end the sweeps.
const AT_REST: f64 = 1e-14;
/// Most rounds of `2^D` sweeps. Without obstacles one round is enough; around obstacles each bend may take another one.
const MOST_ROUNDS: usize = 1000;

/// Distances by Gauss-Seidel sweeps in all `2^D` directions over the nodes, of first order; returns the rounds of sweeps as well.
///
/// Seeds keep their distances, blocked nodes and those that cannot be reached are infinite.
#[must_use]
pub fn sweep<const D: usize>(lattice: &Lattice<D>, seeds: &[Seed], medium: &Medium) -> (Vec<f64>, usize) {
    let mut values = vec![f64::INFINITY; lattice.len()];
    let mut is_free: Vec<bool> = (0..lattice.len()).map(|node| !medium.is_blocked(node)).collect();
    for seed in seeds {
        if is_free[seed.node] {
            values[seed.node] = seed.distance;
            is_free[seed.node] = false;
        }
    }
    let at_rest = AT_REST * (lattice.high() - lattice.low()).norm();
    for round in 1..=MOST_ROUNDS {
        let mut change = 0.0f64;
        for direction in 0..1usize << D {
            change = change.max(one_way(lattice, direction, &is_free, medium, &mut values));
        }
        if change <= at_rest {
            return (values, round);
        }
    }
    (values, MOST_ROUNDS)
}

/// One sweep, along axis `k` downwards where bit `k` of `direction` is set; returns the largest change.
fn one_way<const D: usize>(
    lattice: &Lattice<D>,
    direction: usize,
    is_free: &[bool],
    medium: &Medium,
    values: &mut [f64],
) -> f64 {
    let (counts, spacing) = (lattice.counts(), lattice.spacing());
    let strides: [usize; D] = std::array::from_fn(|k| lattice.stride(k));
    let c: [f64; D] = std::array::from_fn(|k| 1.0 / spacing[k]);
    let mut change = 0.0f64;
    let mut step = [0usize; D];
    loop {
        let at: [usize; D] =
            std::array::from_fn(|k| if direction >> k & 1 == 1 { counts[k] - 1 - step[k] } else { step[k] });
        let node: usize = (0..D).map(|k| at[k] * strides[k]).sum();
        if is_free[node] {
            let mut b = [f64::INFINITY; D];
            for k in 0..D {
                if at[k] > 0 {
                    b[k] = values[node - strides[k]];
                }
                if at[k] + 1 < counts[k] {
                    b[k] = b[k].min(values[node + strides[k]]);
                }
            }
            let found = solve(b, c, medium.slowness(node));
            if found < values[node] {
                change = change.max(values[node] - found);
                values[node] = found;
            }
        }
        let Some(axis) = (0..D).rev().find(|&k| step[k] + 1 < counts[k]) else { return change };
        step[axis] += 1;
        step[axis + 1..].fill(0);
    }
}
