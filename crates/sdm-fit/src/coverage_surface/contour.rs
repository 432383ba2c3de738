//! Where a function on a grid is zero, as closed polygons.

use std::collections::HashMap;

/// Share of the distance of grid lines by which polygons may leave the zeros when vertices are left out.
const NEAR: f64 = 0.3;
/// Vertices up to which it is seen whether a polygon crosses itself without some of them.
const SEEN: usize = 3000;

/// The polygons on which a function is zero that is given where lines of constant u and v meet (v runs faster); on their left it is positive. Beyond the
/// grid it is negative: polygons run along the edge where the function is positive there.
pub(super) fn contours(lines: &[Vec<f64>; 2], field: &[f64]) -> Vec<Vec<[f64; 2]>> {
    let grid = Grid { rows: lines[0].len() + 2, columns: lines[1].len() + 2, field };
    let mut next: HashMap<Edge, Edge> = HashMap::new();
    let mut order = Vec::new();
    for i in 0..grid.rows - 1 {
        for j in 0..grid.columns - 1 {
            for (from, to) in grid.cell(i, j).into_iter().flatten() {
                next.insert(from, to);
                order.push(from);
            }
        }
    }
    let mut found = Vec::new();
    for first in order {
        let mut polygon = Vec::new();
        let mut at = first;
        while let Some(to) = next.remove(&at) {
            polygon.push(grid.zero(at));
            at = to;
        }
        if polygon.len() > 2 {
            found.push(polygon);
        }
    }
    found
        .into_iter()
        .map(|polygon| in_parameters(&simplified(polygon), lines))
        .filter(|p| p.len() > 2)
        .collect()
}

/// An edge of the grid with a ring of places around it: its lower end, and whether it runs in v.
type Edge = (usize, usize, bool);

struct Grid<'a> {
    /// Those of the function and one on each side.
    rows: usize,
    columns: usize,
    field: &'a [f64],
}

impl Grid<'_> {
    /// The value at a place; negative around.
    fn value(&self, i: usize, j: usize) -> f64 {
        if i == 0 || j == 0 || i + 1 == self.rows || j + 1 == self.columns {
            return -1.0;
        }
        self.field[(i - 1) * (self.columns - 2) + j - 1]
    }

    /// The pieces of polygons in a cell, from edge to edge, with positive values on their left (u to the right, v up).
    fn cell(&self, i: usize, j: usize) -> [Option<(Edge, Edge)>; 2] {
        let values = [self.value(i, j), self.value(i + 1, j), self.value(i + 1, j + 1), self.value(i, j + 1)];
        // In u at the bottom, in v to the right, in u at the top, in v to the left.
        let edges = [(i, j, false), (i + 1, j, true), (i, j + 1, false), (i, j, true)];
        let inside = values.map(|v| v > 0.0);
        // Around the cell counter-clockwise the function goes below zero on some edges and above it on as many: a piece runs from the former to the
        // latter with what is positive between them on its left.
        let falls: Vec<usize> = (0..4).filter(|&k| inside[k] && !inside[(k + 1) % 4]).collect();
        let rises: Vec<usize> = (0..4).filter(|&k| !inside[k] && inside[(k + 1) % 4]).collect();
        match (&falls[..], &rises[..]) {
            ([fall], [rise]) => [Some((edges[*fall], edges[*rise])), None],
            ([first, second], [_, _]) => {
                // Two corners opposite to each other: joined where the middle is positive.
                let joined = values.iter().map(|v| v.clamp(-1e300, 1e300) / 4.0).sum::<f64>() > 0.0;
                let to = |fall: usize| edges[if joined { (fall + 1) % 4 } else { (fall + 3) % 4 }];
                [Some((edges[*first], to(*first))), Some((edges[*second], to(*second)))]
            }
            _ => [None, None],
        }
    }

    /// Where the function is zero on an edge, in numbers of grid lines.
    fn zero(&self, (i, j, in_v): Edge) -> [f64; 2] {
        let (a, b) = (self.value(i, j), self.value(i + usize::from(!in_v), j + usize::from(in_v)));
        let share = (a / (a - b)).clamp(0.0, 1.0);
        let share = if share.is_nan() { 0.5 } else { share };
        let place = |k: usize, along: bool, lines: usize| {
            // The ring lies on the edge of the domain.
            let at = k as f64 - 1.0 + if along { share } else { 0.0 };
            at.clamp(0.0, lines as f64 - 3.0)
        };
        [place(i, !in_v, self.rows), place(j, in_v, self.columns)]
    }
}

fn in_parameters(polygon: &[[f64; 2]], lines: &[Vec<f64>; 2]) -> Vec<[f64; 2]> {
    let at = |x: f64, lines: &[f64]| {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 0 and their number"
        )]
        let k = (x as usize).min(lines.len() - 2);
        lines[k] + (lines[k + 1] - lines[k]) * (x - k as f64)
    };
    let mut out: Vec<[f64; 2]> = polygon.iter().map(|p| [at(p[0], &lines[0]), at(p[1], &lines[1])]).collect();
    out.dedup();
    out
}

/// A polygon with vertices only where it bends, if it does not cross itself then: on both halves what is farthest from a chord stays
/// (\[DP73\]).
fn simplified(polygon: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let n = polygon.len();
    let far = (0..n).max_by(|&a, &b| {
        let away = |k: usize| square(&polygon[k], &polygon[0]);
        away(a).total_cmp(&away(b)).then(b.cmp(&a))
    });
    let Some(far) = far.filter(|far| *far > 0) else { return polygon };
    let mut keep = vec![false; n + 1];
    let at = |k: usize| &polygon[k % n];
    let mut open = vec![(0, far), (far, n)];
    while let Some((a, b)) = open.pop() {
        (keep[a], keep[b]) = (true, true);
        let worst = (a + 1..b).map(|k| (distance(at(k), at(a), at(b)), k));
        let worst = worst.fold((0.0, a), |best, x| if x.0 > best.0 { x } else { best });
        if worst.0 > NEAR {
            open.push((a, worst.1));
            open.push((worst.1, b));
        }
    }
    let fewer: Vec<[f64; 2]> = (0..n).filter(|&k| keep[k]).map(|k| polygon[k]).collect();
    if fewer.len() > 2 && fewer.len() <= SEEN && !crosses_itself(&fewer) { fewer } else { polygon }
}

fn square(a: &[f64; 2], b: &[f64; 2]) -> f64 {
    (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
}

/// Distance from a segment.
fn distance(p: &[f64; 2], a: &[f64; 2], b: &[f64; 2]) -> f64 {
    let (along, away) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let length = along[0] * along[0] + along[1] * along[1];
    let share = (along[0] * away[0] + along[1] * away[1]) / length.max(f64::MIN_POSITIVE);
    let share = share.clamp(0.0, 1.0);
    square(&away, &[along[0] * share, along[1] * share]).sqrt()
}

fn crosses_itself(polygon: &[[f64; 2]]) -> bool {
    let n = polygon.len();
    let side = |a: &[f64; 2], b: &[f64; 2], p: &[f64; 2]| {
        (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
    };
    (0..n).any(|i| {
        let (a, b) = (&polygon[i], &polygon[(i + 1) % n]);
        (i + 2..n).filter(|&j| (j + 1) % n != i).any(|j| {
            let (c, d) = (&polygon[j], &polygon[(j + 1) % n]);
            side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(polygon: &[[f64; 2]]) -> f64 {
        let next = polygon.iter().cycle().skip(1);
        0.5 * polygon.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f64>()
    }

    #[test]
    fn rings_have_two_polygons_of_opposite_sense() {
        let line: Vec<f64> = (0..81).map(|k| f64::from(k) / 40.0 - 1.0).collect();
        let lines = [line.clone(), line.clone()];
        let at = |k: usize| line[k / 81].hypot(line[k % 81]);
        let ring: Vec<f64> = (0..81 * 81).map(|k| (0.8 - at(k)).min(at(k) - 0.3)).collect();
        let found = contours(&lines, &ring);
        let mut areas: Vec<f64> = found.iter().map(|p| area(p)).collect();
        areas.sort_by(f64::total_cmp);
        let pi = std::f64::consts::PI;
        assert!(
            areas.len() == 2 && (areas[0] + pi * 0.09).abs() < 0.015 && (areas[1] - pi * 0.64).abs() < 0.03
        );
        assert!(found.iter().all(|p| p.len() < 100 && !crosses_itself(p)));
    }

    #[test]
    fn polygons_run_along_the_edge_and_corners_are_apart() {
        let lines = [vec![0.0, 1.0, 2.0, 4.0], vec![0.0, 1.0, 2.0]];
        let whole = contours(&lines, &[1.0; 12]);
        assert!(whole.len() == 1 && (area(&whole[0]) - 8.0).abs() < 1e-12, "{whole:?}");
        // Two corners that meet in a cell.
        let diagonal = |far: f64| {
            let mut field = [-far; 12];
            (field[0], field[4]) = (1.0, 1.0);
            contours(&lines, &field)
        };
        assert_eq!((diagonal(3.0).len(), diagonal(0.5).len()), (2, 1));
    }
}
