//! Every inner vertex as a mean of its neighbours.

use super::pieces::Piece;
use crate::Error;
use nurbs_core::linear::{Sparse, solve_general};
use std::collections::BTreeMap;

/// Rounding beyond the boundary of the domain that a solution may have.
const ROUNDING: f64 = 1e-9;

/// The parameters of all vertices, with those of the boundary given. Vertices of no triangle have none: NaN.
pub(super) fn solve(
    pieces: &[Piece],
    count: usize,
    fixed: &BTreeMap<u32, [f64; 2]>,
) -> Result<Vec<[f64; 2]>, Error> {
    let mut parameters = vec![[f64::NAN; 2]; count];
    let mut unknown = vec![usize::MAX; count];
    let mut free = 0;
    for vertex in pieces.iter().flat_map(|piece| piece.corners) {
        match fixed.get(&vertex) {
            Some(at) => parameters[vertex as usize] = *at,
            None if unknown[vertex as usize] == usize::MAX => {
                unknown[vertex as usize] = free;
                free += 1;
            }
            None => {}
        }
    }
    if free == 0 {
        return Ok(parameters);
    }
    let mut sums = vec![0.0; free];
    let mut columns: Vec<Vec<usize>> = (0..free).map(|k| vec![k]).collect();
    each_weight(pieces, |from, to, weight| {
        let (row, column) = (unknown[from as usize], unknown[to as usize]);
        if row < free {
            sums[row] += weight;
            if column < free {
                columns[column].push(row);
            }
        }
    });
    if sums.iter().any(|sum| !(*sum > 0.0 && sum.is_finite())) {
        return Err(Error::Unsolvable);
    }
    let mut matrix = Sparse::with_pattern(columns);
    let mut right = vec![0.0; 2 * free];
    for k in 0..free {
        matrix.add(k, k, 1.0);
    }
    each_weight(pieces, |from, to, weight| {
        let row = unknown[from as usize];
        if row < free {
            let share = weight / sums[row];
            match unknown[to as usize] {
                column if column < free => matrix.add(row, column, -share),
                _ => {
                    let [u, v] = parameters[to as usize];
                    right[row] += share * u;
                    right[free + row] += share * v;
                }
            }
        }
    });
    let is_valid = |value: &f64| (-ROUNDING..=1.0 + ROUNDING).contains(value);
    if !solve_general(&matrix, &mut right) || !right.iter().all(is_valid) {
        return Err(Error::Unsolvable);
    }
    for (vertex, &k) in unknown.iter().enumerate().filter(|(_, k)| **k < free) {
        parameters[vertex] = [right[k], right[free + k]];
    }
    Ok(parameters)
}

/// Calls `add` with every part of a weight from one vertex to another.
fn each_weight(pieces: &[Piece], mut add: impl FnMut(u32, u32, f64)) {
    for piece in pieces {
        let tangents = piece.half_tangents();
        for k in 0..3 {
            let (next, before) = ((k + 1) % 3, (k + 2) % 3);
            add(piece.corners[k], piece.corners[next], tangents[k] / piece.lengths[k]);
            add(piece.corners[k], piece.corners[before], tangents[k] / piece.lengths[before]);
        }
    }
}
