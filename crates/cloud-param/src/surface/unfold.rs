//! Folds and loops of a base surface smoothed away, where they are.

use super::SampleGrid;
use crate::Error;
use crate::defects::loops;
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, KnotVector};
use sdm_fit::Folds;

/// How often places around folds are smoothed, and how many places around a fold are reached at first.
const ROUNDS: usize = 24;
const REACH: usize = 2;
/// Rounds after which folds that are still there reach one place more.
const WIDER: usize = 6;
/// Share of the cells that may be folded for it to be a matter of places.
const FEW: f64 = 0.1;

/// The grid with places around folded cells and loops moved to the middle of their neighbours until nothing is folded, and the
/// surface through it; `None` where much is folded, or stays so.
pub(super) fn unfolded(
    grid: &SampleGrid,
    surface: &BsplineSurface,
    axes: Option<&[Vector3<f64>; 3]>,
) -> Result<Option<(SampleGrid, BsplineSurface)>, Error> {
    let (mut grid, mut surface) = (grid.clone(), surface.clone());
    for round in 0..ROUNDS {
        let folds = Folds::of(&surface);
        let loops = axes.map_or_else(Vec::new, |axes| loops(&surface, axes));
        if folds.count() == 0 && loops.is_empty() {
            return Ok(Some((grid, surface)));
        }
        if (folds.count() + loops.len()) as f64 > FEW * folds.cells as f64 {
            return Ok(None);
        }
        let middles = [surface.knots_u(), surface.knots_v()].map(middles);
        let folded = folds.folded.iter().map(|cell| {
            let [u, v] = [0, 1].map(|k| middles[k][cell[k]]);
            ([u, u], v)
        });
        let mut near = vec![false; grid.points.len()];
        for (from_to, v) in folded.chain(loops) {
            mark(&mut near, &grid, from_to, v, REACH + round / WIDER);
        }
        grid = grid.smoothed_where(&near);
        surface = grid.surface()?;
    }
    Ok(None)
}

/// Middles of the spans as shares of the domain.
fn middles(knots: &KnotVector) -> Vec<f64> {
    let domain = knots.domain();
    let middle = |span| (knots.span_interval(span).midpoint() - domain.start()) / domain.length();
    knots.spans().map(middle).collect()
}

/// Marks the places of a grid between two shares of its length in u, which may lie beyond its end, at one of v, and those around.
fn mark(near: &mut [bool], grid: &SampleGrid, [from, to]: [f64; 2], v: f64, reach: usize) {
    let [m, n] = grid.size;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "shares of a grid, at most 2"
    )]
    let index = |share: f64, steps: usize| (share * steps as f64).round().max(0.0) as usize;
    let steps = if grid.closed { m } else { m - 1 };
    let j = index(v, n - 1);
    for at in index(from, steps) + m - reach.min(m)..=index(to, steps) + m + reach {
        if !grid.closed && !(m..2 * m).contains(&at) {
            continue;
        }
        for row in j.saturating_sub(reach)..=(j + reach).min(n - 1) {
            near[at % m * n + row] = true;
        }
    }
}
