//! Where the zero set crosses the grid lines, and the curves that connect the crossings in the plane.

use super::grid::Grid;
use nalgebra::SVector;
use std::collections::BTreeMap;

/// Steps of the search for a zero between two nodes: halving alone leaves nothing after so many.
const MAX_STEPS: usize = 60;

/// What is connected in a cell of the plane whose corners differ in sign crosswise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Saddles {
    /// The sign in the middle of the cell decides: the topology of the spline.
    #[default]
    Middle,
    /// The positive corners: regions where the function is negative touch along edges of the grid only (4-connected).
    Separate,
}

/// A zero of the spline between two neighbouring nodes of different sign, as a share of the way (`0 ≤ s ≤ 1`): the
/// secant method, kept in the interval by bisection. Zero counts as
/// positive.
fn zero(value: impl Fn(f64) -> f64, ends: [f64; 2]) -> f64 {
    let ([mut a, mut b], [mut fa, mut fb]) = ([0.0, 1.0], ends);
    for step in 0..MAX_STEPS {
        let secant = a - fa * (b - a) / (fb - fa);
        let s = if step % 3 == 2 || !(a < secant && secant < b) { 0.5 * (a + b) } else { secant };
        let f = value(s);
        if f == 0.0 || b - a <= f64::EPSILON {
            return s;
        }
        if (f < 0.0) == (fa < 0.0) { (a, fa) = (s, f) } else { (b, fb) = (s, f) }
    }
    if fa.abs() <= fb.abs() { a } else { b }
}

/// The crossing of the grid line from a node in a direction, if the sign changes there. Zero counts as positive.
fn crossing<const D: usize>(
    grid: &Grid<D>,
    value: &impl Fn(&SVector<f64, D>) -> f64,
    node: usize,
    direction: usize,
) -> Option<SVector<f64, D>> {
    let ends = [grid.values()[node], grid.values()[node + grid.stride(direction)]];
    if (ends[0] < 0.0) == (ends[1] < 0.0) {
        return None;
    }
    let from = grid.node(node);
    let at = |s: f64| {
        let mut place = from;
        place[direction] += s;
        place
    };
    Some(at(zero(|s| value(&at(s)), ends)))
}

/// All crossings, in units of the spacing, and the largest difference of neighbouring values; the function by places in these units.
pub(crate) fn crossings<const D: usize>(
    grid: &Grid<D>,
    value: &impl Fn(&SVector<f64, D>) -> f64,
) -> (Vec<SVector<f64, D>>, f64) {
    let mut out = Vec::new();
    let mut jump = 0.0f64;
    for node in 0..grid.values().len() {
        let at = grid.node(node);
        for d in 0..D {
            if at[d] + 1.0 < grid.counts()[d] as f64 {
                jump = jump.max((grid.values()[node + grid.stride(d)] - grid.values()[node]).abs());
                out.extend(crossing(grid, value, node, d));
            }
        }
    }
    (out, jump)
}

/// A grid line between two neighbouring nodes: the first of them, and the direction.
type Edge = (usize, usize);

/// The curves of the zero set (marching squares), each with whether it is closed; `f < 0` on their left.
pub(super) fn trace(
    grid: &Grid<2>,
    value: &impl Fn(&SVector<f64, 2>) -> f64,
    saddles: Saddles,
) -> Vec<(Vec<SVector<f64, 2>>, bool)> {
    let [m, n] = grid.counts();
    // From the edge through which a curve enters a cell to the edge through which it leaves: each edge is entered from
    // one cell at most, since the negative side is on the left.
    let mut next: BTreeMap<Edge, Edge> = BTreeMap::new();
    for i in 0..m - 1 {
        for j in 0..n - 1 {
            let node = i * n + j;
            // Counter-clockwise, with the first index to the right and the second upwards.
            let corners = [node, node + n, node + n + 1, node + 1];
            let edges = [(node, 0), (node + n, 1), (node + 1, 0), (node, 1)];
            let negative = corners.map(|corner| grid.values()[corner] < 0.0);
            // Counter-clockwise, a curve with the negative side on its left comes in where an edge leads from negative to
            // positive, and goes out where one leads back.
            let changes = |from: bool| {
                (0..4)
                    .filter(move |&k| negative[k] == from && negative[(k + 1) % 4] != from)
                    .collect::<Vec<_>>()
            };
            let (entries, exits) = (changes(true), changes(false));
            match (entries.as_slice(), exits.as_slice()) {
                ([entry], [exit]) => {
                    next.insert(edges[*entry], edges[*exit]);
                }
                ([first, second], [..]) => {
                    // A saddle: its middle tells which corners are connected.
                    let middle = grid.node(node).add_scalar(0.5);
                    let joined = saddles == Saddles::Middle && value(&middle) < 0.0;
                    for entry in [*first, *second] {
                        // Where the negative corners are connected a curve goes around a positive corner, else around a
                        // negative one.
                        let exit = if joined { (entry + 1) % 4 } else { (entry + 3) % 4 };
                        next.insert(edges[entry], edges[exit]);
                    }
                }
                _ => {}
            }
        }
    }
    let mut entered: BTreeMap<Edge, bool> = next.keys().map(|&edge| (edge, false)).collect();
    for exit in next.values() {
        if let Some(entered) = entered.get_mut(exit) {
            *entered = true;
        }
    }
    // Open curves begin where none comes from; all others are closed.
    let open: Vec<Edge> = entered.iter().filter(|(_, entered)| !**entered).map(|(&edge, _)| edge).collect();
    let mut curves = Vec::new();
    for first in open {
        curves.push((follow(grid, value, &mut next, first), false));
    }
    while let Some((&first, _)) = next.first_key_value() {
        let mut places = follow(grid, value, &mut next, first);
        places.pop();
        curves.push((places, true));
    }
    // A curve through a node meets two or more edges there.
    for (places, closed) in &mut curves {
        places.dedup();
        if *closed && places.len() > 1 && places.first() == places.last() {
            places.pop();
        }
    }
    curves.retain(|(places, closed)| places.len() > if *closed { 2 } else { 1 });
    curves
}

/// The places along a curve from an edge on, the edge at which it ends included.
fn follow(
    grid: &Grid<2>,
    value: &impl Fn(&SVector<f64, 2>) -> f64,
    next: &mut BTreeMap<Edge, Edge>,
    first: Edge,
) -> Vec<SVector<f64, 2>> {
    let mut places = Vec::new();
    let mut edge = first;
    places.extend(crossing(grid, value, edge.0, edge.1));
    while let Some(exit) = next.remove(&edge) {
        places.extend(crossing(grid, value, exit.0, exit.1));
        edge = exit;
    }
    places
}
