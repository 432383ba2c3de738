//! Short closed tours through points.

use mesh_core::CloudIndex;
use nalgebra::{Point, SVector};

/// Neighbours to which a tour may go on from a point.
const NEIGHBOURS: usize = 12;
/// Passes over all points at most.
const PASSES: usize = 40;

/// A closed tour through points, no two of them equal, that no exchange of two edges for others to near neighbours makes shorter: edges are
/// taken from the shortest one up, what they leave apart is joined, and edges are exchanged (2-opt). `None` where points have no neighbours.
///
/// Through points on a curve it follows the curve, also where that is narrow: a tree of shortest edges would pass from one side to
/// the other.
pub(super) fn short_tour<const D: usize>(points: &[SVector<f64, D>]) -> Option<Vec<usize>> {
    let places: Vec<Point<f64, D>> = points.iter().copied().map(Point::from).collect();
    let index = CloudIndex::new(&places).ok()?;
    let near: Vec<Vec<usize>> = index.map_nearest_n(&places, NEIGHBOURS + 1, |i, near| {
        near.iter().map(|n| n.index).filter(|&j| j != i).collect()
    });
    let mut tour = joined(points, &near);
    improve(points, &near, &mut tour);
    Some(tour)
}

/// Pieces of tours, by the shortest edges first, joined end to end.
fn joined<const D: usize>(points: &[SVector<f64, D>], near: &[Vec<usize>]) -> Vec<usize> {
    let n = points.len();
    let length = |&[i, j]: &[usize; 2]| (points[i] - points[j]).norm_squared();
    let mut edges: Vec<[usize; 2]> = Vec::new();
    for (i, near) in near.iter().enumerate() {
        edges.extend(near.iter().map(|&j| [i.min(j), i.max(j)]));
    }
    edges.sort_by(|a, b| length(a).total_cmp(&length(b)).then(a.cmp(b)));
    edges.dedup();
    let mut pieces = Pieces { links: vec![Vec::new(); n], other_end: (0..n).collect() };
    for [i, j] in edges {
        pieces.link(i, j);
    }
    // From an end to the nearest one of another piece.
    let mut ends: Vec<usize> = (0..n).filter(|&i| pieces.links[i].len() < 2).collect();
    let mut tour = Vec::with_capacity(n);
    let mut at = ends.first().copied().unwrap_or(0);
    loop {
        let last = pieces.walk(at, &mut tour);
        ends.retain(|&i| i != at && i != last);
        let distance = |&i: &usize| (points[i] - points[last]).norm_squared();
        let Some(next) = ends.iter().copied().min_by(|a, b| distance(a).total_cmp(&distance(b))) else {
            break;
        };
        at = next;
    }
    tour
}

/// Open chains of points.
struct Pieces {
    links: Vec<Vec<usize>>,
    /// For each end the other one.
    other_end: Vec<usize>,
}

impl Pieces {
    /// Links two ends of different pieces.
    fn link(&mut self, i: usize, j: usize) {
        if self.links[i].len() == 2 || self.links[j].len() == 2 || self.other_end[i] == j {
            return;
        }
        self.links[i].push(j);
        self.links[j].push(i);
        let (a, b) = (self.other_end[i], self.other_end[j]);
        (self.other_end[a], self.other_end[b]) = (b, a);
    }

    /// Appends a piece from one end on, and gives the other end.
    fn walk(&self, start: usize, tour: &mut Vec<usize>) -> usize {
        let (mut before, mut at) = (usize::MAX, start);
        loop {
            tour.push(at);
            let next = self.links[at].iter().copied().find(|&k| k != before);
            let Some(next) = next else { return at };
            (before, at) = (at, next);
        }
    }
}

/// Exchanges pairs of edges as long as that makes the tour shorter.
fn improve<const D: usize>(points: &[SVector<f64, D>], near: &[Vec<usize>], tour: &mut [usize]) {
    let n = tour.len();
    if n < 5 {
        return;
    }
    let mut place = vec![0; n];
    tour.iter().enumerate().for_each(|(k, &i)| place[i] = k);
    let length = |i: usize, j: usize| (points[i] - points[j]).norm();
    for _ in 0..PASSES {
        let mut improved = false;
        for a in 0..n {
            // The edges after both points, or before both, for those two and what then lies between them turned round.
            for forward in [true, false] {
                let step = |i: usize| if forward { (place[i] + 1) % n } else { (place[i] + n - 1) % n };
                let b = tour[step(a)];
                let Some(c) =
                    near[a].iter().take_while(|&&c| length(a, c) < length(a, b)).copied().find(|&c| {
                        let d = tour[step(c)];
                        let (before, after) = (length(a, b) + length(c, d), length(a, c) + length(b, d));
                        c != b && d != a && after < before * (1.0 - 1e-12)
                    })
                else {
                    continue;
                };
                // Between b and c, in the direction of the tour.
                let (from, to) = if forward { (place[b], place[c]) } else { (place[c], place[b]) };
                turn(tour, &mut place, from, to);
                improved = true;
            }
        }
        if !improved {
            break;
        }
    }
}

/// Turns round the part of a closed tour from one place to another.
fn turn(tour: &mut [usize], place: &mut [usize], from: usize, to: usize) {
    let n = tour.len();
    let count = (to + n - from) % n + 1;
    for k in 0..count / 2 {
        let (i, j) = ((from + k) % n, (to + n - k) % n);
        tour.swap(i, j);
        (place[tour[i]], place[tour[j]]) = (i, j);
    }
}
