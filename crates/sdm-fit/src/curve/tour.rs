//! Short closed tours through points that go straight on where they can.

use mesh_core::CloudIndex;
use nalgebra::{Point, SVector};

/// Neighbours to which a tour may go on from a point.
pub(super) const NEIGHBOURS: usize = 12;
/// Passes over all points at most.
const PASSES: usize = 40;
/// What a turn costs, in units of the shorter of the two edges that meet there, for a right angle.
const BEND: f64 = 3.0;
/// Most points that are moved to another place of the tour together.
const MOVED: usize = 3;
/// Cost that points must save where they are taken out, in units of the edge before them, to be moved at all.
const STRAIGHT: f64 = 0.3;
/// Share of its parts by which a cost must fall.
const LESS: f64 = 1e-12;

/// For each point its neighbours, the nearest first; `None` where there are too many points.
pub(super) fn neighbours<const D: usize>(points: &[SVector<f64, D>]) -> Option<Vec<Vec<usize>>> {
    let places: Vec<Point<f64, D>> = points.iter().copied().map(Point::from).collect();
    let index = CloudIndex::new(&places).ok()?;
    Some(index.map_nearest_n(&places, NEIGHBOURS + 1, |i, near| {
        near.iter().map(|n| n.index).filter(|&j| j != i).collect()
    }))
}

/// A closed tour through points, no two of them equal, that is short and straight: an edge costs its length, but no more than `cap`, a turn
/// what it bends between edges that are not longer than that. Edges are taken from the shortest one up, what they leave apart is
/// joined, and pairs of edges exchanged (2-opt), few points moved or stretches exchanged (Or-opt, 3-opt) as long as that lowers the cost.
///
/// Through points on a curve it follows the curve, also where that is narrow, where a tree of shortest edges would pass from one side
/// to the other, and straight across itself. Where the curve has ends or falls into parts, edges longer than `cap` remain.
pub(super) fn short_tour<const D: usize>(
    points: &[SVector<f64, D>],
    near: &[Vec<usize>],
    cap: f64,
) -> Vec<usize> {
    let order = joined(points, near);
    let mut tour = Tour { points, near, cap, place: vec![0; order.len()], order };
    tour.number();
    tour.improve();
    tour.order
}

/// The cost of going through some points: of the edges, and of the turns at all but the first and the last.
pub(super) fn cost<const D: usize>(way: &[SVector<f64, D>], cap: f64) -> f64 {
    sum(way.iter().copied(), cap)
}

fn sum<const D: usize>(mut way: impl Iterator<Item = SVector<f64, D>>, cap: f64) -> f64 {
    let Some(mut at) = way.next() else { return 0.0 };
    let mut sum = 0.0;
    let mut before: Option<(SVector<f64, D>, f64)> = None;
    for next in way {
        let edge = next - at;
        let length = edge.norm();
        sum += length.min(cap);
        if let Some((other, shorter)) = before
            && length <= cap
            && shorter <= cap
            && length > 0.0
            && shorter > 0.0
        {
            sum += BEND * (1.0 - other.dot(&edge) / (length * shorter)) * length.min(shorter);
        }
        (before, at) = (Some((edge, length)), next);
    }
    sum
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

/// A closed tour and where each point is on it.
struct Tour<'a, const D: usize> {
    points: &'a [SVector<f64, D>],
    near: &'a [Vec<usize>],
    cap: f64,
    order: Vec<usize>,
    place: Vec<usize>,
}

impl<const D: usize> Tour<'_, D> {
    fn number(&mut self) {
        for (k, &i) in self.order.iter().enumerate() {
            self.place[i] = k;
        }
    }

    /// The point some places before or behind another one.
    fn from(&self, point: usize, steps: isize) -> usize {
        let n = self.order.len().cast_signed();
        self.order[(self.place[point].cast_signed() + steps).rem_euclid(n).cast_unsigned()]
    }

    fn cost(&self, way: &[usize]) -> f64 {
        sum(way.iter().map(|&i| self.points[i]), self.cap)
    }

    fn improve(&mut self) {
        let n = self.order.len();
        if n < 8 {
            return;
        }
        let mut idle = 0;
        for _ in 0..PASSES {
            let mut improved = false;
            for a in 0..n {
                improved |= self.exchange(a);
                improved |= self.shift(a);
                improved |= self.swap(a);
            }
            // The last kind of change looks ahead only: once more the other way round.
            idle = if improved { 0 } else { idle + 1 };
            if idle == 2 {
                break;
            }
            self.order.reverse();
            self.number();
        }
    }

    /// Exchanges the stretch behind a point and one that comes later, turning the former round or not, if that is better: what no exchange of
    /// two edges does without a loss on the way.
    fn swap(&mut self, a: usize) -> bool {
        let n = self.order.len();
        let b = self.from(a, 1);
        let first = (self.points[a] - self.points[b]).norm().min(self.cap);
        let behind = |x: usize| (self.place[x] + n - self.place[a]) % n;
        for &c in self.near[a].iter().take_while(|&&c| (self.points[a] - self.points[c]).norm() < first) {
            if behind(c) < 2 {
                continue;
            }
            let d = self.from(c, -1);
            for (end, other) in [(d, b), (b, d)] {
                for &e in &self.near[end] {
                    if behind(e) < behind(c) || e == a {
                        continue;
                    }
                    let f = self.from(e, 1);
                    let [aa, bb, dd] = [self.from(a, -1), self.from(b, 1), self.from(d, -1)];
                    let [cc, ee, ff] = [self.from(c, 1), self.from(e, -1), self.from(f, 1)];
                    let beyond = |x: usize| if x == b { bb } else { dd };
                    let old =
                        self.cost(&[aa, a, b, bb]) + self.cost(&[dd, d, c, cc]) + self.cost(&[ee, e, f, ff]);
                    let new = self.cost(&[aa, a, c, cc])
                        + self.cost(&[ee, e, end, beyond(end)])
                        + self.cost(&[beyond(other), other, f, ff]);
                    // Stretches of one point have no inner edge.
                    if b == d || c == e || f == a || new >= old - LESS * (old + new) {
                        continue;
                    }
                    let (turned, middle, last) = (end == d, behind(c), behind(e));
                    self.order.rotate_left(self.place[a]);
                    let mut stretch: Vec<usize> = self.order[1..middle].to_vec();
                    if turned {
                        stretch.reverse();
                    }
                    let later: Vec<usize> = self.order[middle..=last].to_vec();
                    self.order.splice(1..=last, later.into_iter().chain(stretch));
                    self.number();
                    return true;
                }
            }
        }
        false
    }

    /// Exchanges an edge at a point and another one for two others, if that is better.
    fn exchange(&mut self, a: usize) -> bool {
        // The edges after both points, or before both, for those two and what then lies between them turned round.
        for step in [1, -1] {
            let b = self.from(a, step);
            let found = self.near[a].iter().copied().find(|&c| {
                let d = self.from(c, step);
                if c == b || d == a {
                    return false;
                }
                let [before, behind] = [self.from(a, -step), self.from(b, step)];
                let [inside, beyond] = [self.from(c, -step), self.from(d, step)];
                let old = self.cost(&[before, a, b, behind]) + self.cost(&[inside, c, d, beyond]);
                let new = self.cost(&[before, a, c, inside]) + self.cost(&[behind, b, d, beyond]);
                new < old - LESS * (old + new)
            });
            if let Some(c) = found {
                let (from, to) = if step == 1 { (b, c) } else { (c, b) };
                self.turn(self.place[from], self.place[to]);
                return true;
            }
        }
        false
    }

    /// Moves a point, and up to two behind it, to between two others, if that is better.
    fn shift(&mut self, first: usize) -> bool {
        for count in 1..=MOVED {
            let moved: Vec<usize> = (0..count.cast_signed()).map(|k| self.from(first, k)).collect();
            let last = moved[count - 1];
            let [pp, p] = [self.from(first, -2), self.from(first, -1)];
            let [n, nn] = [self.from(last, 1), self.from(last, 2)];
            let mut way = vec![pp, p];
            way.extend(&moved);
            way.extend([n, nn]);
            let gain = self.cost(&way) - self.cost(&[pp, p, n, nn]);
            // What goes straight on is where it belongs.
            if gain <= STRAIGHT * (self.points[first] - self.points[p]).norm().min(self.cap) {
                continue;
            }
            let reversed: Vec<usize> = moved.iter().rev().copied().collect();
            for (end, segment) in [(first, &moved), (last, &reversed)] {
                // The end comes next to a neighbour of its own, behind it or before it.
                for &c in &self.near[end] {
                    for step in [1, -1] {
                        let [cc, d, dd] = [-step, step, 2 * step].map(|k| self.from(c, k));
                        if [c, d, cc, dd].iter().any(|x| way[1..way.len() - 1].contains(x)) {
                            continue;
                        }
                        let mut other = vec![cc, c];
                        other.extend(segment);
                        other.extend([d, dd]);
                        let loss = self.cost(&other) - self.cost(&[cc, c, d, dd]);
                        if loss < gain - LESS * (loss.abs() + gain.abs()) {
                            let behind = if step == 1 { c } else { d };
                            let segment: Vec<usize> = if step == 1 {
                                segment.clone()
                            } else {
                                segment.iter().rev().copied().collect()
                            };
                            self.put(&segment, behind);
                            return true;
                        }
                    }
                }
            }
        }
        false
    }

    /// Puts points behind another one.
    fn put(&mut self, segment: &[usize], behind: usize) {
        self.order.retain(|i| !segment.contains(i));
        let at = self.order.iter().position(|&i| i == behind).map_or(0, |k| k + 1);
        self.order.splice(at..at, segment.iter().copied());
        self.number();
    }

    /// Turns round the part from one place to another, or, which comes to the same, the rest, if that is shorter.
    fn turn(&mut self, from: usize, to: usize) {
        let n = self.order.len();
        let count = (to + n - from) % n + 1;
        let (from, to, count) =
            if 2 * count > n { ((to + 1) % n, (from + n - 1) % n, n - count) } else { (from, to, count) };
        for k in 0..count / 2 {
            let (i, j) = ((from + k) % n, (to + n - k) % n);
            self.order.swap(i, j);
            (self.place[self.order[i]], self.place[self.order[j]]) = (i, j);
        }
    }
}
