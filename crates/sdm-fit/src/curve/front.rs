//! A contour that grows inside a closed plane cloud until it meets the points: a start for curves that begin far away.
//!
//! Squared distance minimisation finds the nearest local minimum. A contour that is driven outwards by a constant pressure and
//! stopped where the distance function of the cloud says that points are near (an active contour whose motion is a front that
//! marches on a grid) finds the whole outline, however long and bent it is.

use super::crossing::plane;
use crate::Error;
use distance_field::{Grid, LevelSetField};
use mesh_core::CloudIndex;
use nalgebra::{Point2, SVector, Vector2};
use nurbs_core::{BsplineCurve, CurveFitOptions, KnotVector, ParametricCurve};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Cells along the longer side of the cloud, and cells around it.
const CELLS: f64 = 180.0;
const AROUND: usize = 6;
/// First width of the barrier in cells, the factor by which it grows while it leaks, and the widest as a share of the size.
const BARRIER: f64 = 1.5;
const WIDER: f64 = 1.25;
const WIDEST: f64 = 0.25;
/// What is said of points that enclose nothing.
const ENCLOSES_NOTHING: Error =
    Error::Degenerate { shape: "a closed contour", what: "so that they enclose nothing" };
/// Share of the points that must lie beside what is enclosed, and how far away as shares of the
/// thickness of the barrier and, at most, of the size.
const SEEN: f64 = 0.98;
const THICK: f64 = 1.25;
const FARTHEST: f64 = 0.2;
/// Bending of the curves through contours, and samples of a start.
const BRIDGE: f64 = 1e-6;
const SAMPLES: usize = 400;

/// Closed polygons on the way from a start to the outline of a closed cloud, the last one along it.
///
/// The part of the start that lies inside the outline grows; a start that lies outside altogether is moved to the place inside that
/// is farthest from all points. Without a start, growth begins there.
///
/// # Errors
/// [`Error::Option`] unless `D` is 2, [`Error::Degenerate`] when the points enclose nothing.
pub(super) fn contours<const D: usize>(
    points: &[SVector<f64, D>],
    start: Option<&BsplineCurve<D>>,
    stages: usize,
) -> Result<Vec<Vec<SVector<f64, D>>>, Error> {
    if D != 2 {
        return Err(Error::Option { name: "search", value: 1.0, allowed: "false (0) for curves in space" });
    }
    let points: Vec<Vector2<f64>> = points.iter().map(plane).collect();
    let start: Vec<Vector2<f64>> = start.map_or_else(Vec::new, |curve| {
        let at = |k: usize| curve.point(curve.domain().lerp(k as f64 / SAMPLES as f64));
        (0..SAMPLES).map(|k| plane(&at(k))).collect()
    });
    let map = DistanceMap::new(&points)?;
    let inside = map.enclosed(&points)?;
    let seeds = map.seeds(&inside, &start);
    let times = map.march(&inside, &seeds);
    let last = times.iter().copied().filter(|t| t.is_finite()).fold(0.0, f64::max);
    let mut polygons = Vec::with_capacity(stages);
    for stage in 1..=stages {
        // The last contour has all of the inside within it.
        let until = if stage == stages { last + map.cell } else { last * stage as f64 / stages as f64 };
        let limit = 2.0 * map.cell;
        let values = times.iter().map(|t| (t - until).clamp(-limit, limit)).collect();
        let grid = Grid::new(map.low, Vector2::repeat(map.cell), map.counts, values)?;
        let field = LevelSetField::<2>::new(&grid)?;
        if let Some(contour) = field.contours().first() {
            polygons.push(contour.vertices().iter().map(|p| SVector::from_fn(|c, _| p[c])).collect());
        }
    }
    if polygons.is_empty() { Err(ENCLOSES_NOTHING) } else { Ok(polygons) }
}

/// The least squares curve with periodic knots through a closed polygon.
pub(super) fn through<const D: usize>(
    nodes: &[SVector<f64, D>],
    knots: &KnotVector,
) -> Result<BsplineCurve<D>, Error> {
    let mut lengths = vec![0.0];
    for k in 0..nodes.len() {
        lengths.push(lengths[k] + (nodes[(k + 1) % nodes.len()] - nodes[k]).norm());
    }
    let total = lengths[nodes.len()].max(f64::MIN_POSITIVE);
    let parameters: Vec<f64> =
        lengths[..nodes.len()].iter().map(|l| knots.domain().lerp(l / total)).collect();
    let options = CurveFitOptions::default().with_regularization(BRIDGE);
    Ok(BsplineCurve::approximate(knots.clone(), &parameters, nodes, &options)?.shape)
}

/// The distances from the cloud on a grid around it.
struct DistanceMap {
    low: Vector2<f64>,
    cell: f64,
    counts: [usize; 2],
    distances: Vec<f64>,
    size: f64,
}

impl DistanceMap {
    fn new(points: &[Vector2<f64>]) -> Result<Self, Error> {
        let mut low = Vector2::repeat(f64::INFINITY);
        let mut high = -low;
        for p in points {
            (low, high) = (low.inf(p), high.sup(p));
        }
        let size = (high - low).max();
        let cell = size / CELLS;
        if !(cell > 0.0 && cell.is_finite()) {
            return Err(Error::Degenerate { shape: "a closed contour", what: "all at one place" });
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to CELLS")]
        let counts = [0, 1].map(|d| ((high[d] - low[d]) / cell).ceil() as usize + 1 + 2 * AROUND);
        low -= Vector2::repeat(AROUND as f64 * cell);
        let index = CloudIndex::new(&points.iter().map(|p| Point2::from(*p)).collect::<Vec<_>>())?;
        let mut map = Self { low, cell, counts, distances: Vec::new(), size };
        map.distances = crate::parallel::map(counts[0] * counts[1], |k| {
            index.nearest(&Point2::from(map.place(k))).map_or(f64::INFINITY, |near| near.distance())
        });
        Ok(map)
    }

    fn place(&self, node: usize) -> Vector2<f64> {
        self.low + Vector2::new((node / self.counts[1]) as f64, (node % self.counts[1]) as f64) * self.cell
    }

    fn neighbours(&self, node: usize) -> [Option<usize>; 4] {
        let [m, n] = self.counts;
        let (i, j) = (node / n, node % n);
        [
            (i > 0).then(|| node - n),
            (i + 1 < m).then(|| node + n),
            (j > 0).then(|| node - 1),
            (j + 1 < n).then(|| node + 1),
        ]
    }

    /// Nodes at the edges of the grid, all of which are outside.
    fn border(&self) -> impl Iterator<Item = usize> {
        (0..self.distances.len()).filter(|&k| self.neighbours(k).contains(&None))
    }

    /// Nodes that are reached from some through those that are open.
    fn flooded(&self, from: impl IntoIterator<Item = usize>, open: &dyn Fn(usize) -> bool) -> Vec<bool> {
        let mut reached = vec![false; self.distances.len()];
        let mut stack: Vec<usize> = from.into_iter().filter(|&k| open(k)).collect();
        while let Some(node) = stack.pop() {
            if !std::mem::replace(&mut reached[node], true) {
                stack.extend(self.neighbours(node).into_iter().flatten().filter(|&k| !reached[k] && open(k)));
            }
        }
        reached
    }

    /// The largest connected part of the plane that a barrier around the points encloses, the narrowest one beside which nearly
    /// all of them lie.
    fn enclosed(&self, points: &[Vector2<f64>]) -> Result<Vec<bool>, Error> {
        let mut width = BARRIER * self.cell;
        while width <= WIDEST * self.size {
            let free = |k: usize| self.distances[k] > width;
            let outside = self.flooded(self.border(), &free);
            let mut left: Vec<bool> = (0..outside.len()).map(|k| free(k) && !outside[k]).collect();
            let mut best: Vec<usize> = Vec::new();
            for node in 0..left.len() {
                if left[node] {
                    let part = self.flooded([node], &|k| left[k]);
                    let part: Vec<usize> = (0..part.len()).filter(|&k| part[k]).collect();
                    part.iter().for_each(|&k| left[k] = false);
                    if part.len() > best.len() {
                        best = part;
                    }
                }
            }
            let index =
                CloudIndex::new(&best.iter().map(|&k| Point2::from(self.place(k))).collect::<Vec<_>>())?;
            // From the inside to the far side of the barrier, which is as thick as the cloud is noisy.
            let barrier = self.distances.iter().filter(|d| **d <= width).count() as f64 * self.cell;
            let rim = best.iter().filter(|&&k| self.neighbours(k).into_iter().flatten().any(|n| !free(n)));
            let reach = (THICK * barrier / rim.count().max(1) as f64).min(FARTHEST * self.size) + self.cell;
            let seen =
                points.iter().filter(|p| index.nearest_within(&Point2::from(**p), reach).is_some()).count();
            if !best.is_empty() && seen as f64 >= SEEN * points.len() as f64 {
                let mut inside = vec![false; self.distances.len()];
                best.iter().for_each(|&k| inside[k] = true);
                return Ok(inside);
            }
            width *= WIDER;
        }
        Err(ENCLOSES_NOTHING)
    }

    /// Where growth begins.
    fn seeds(&self, inside: &[bool], polygon: &[Vector2<f64>]) -> Vec<usize> {
        let nodes: Vec<usize> = (0..inside.len()).filter(|&k| inside[k]).collect();
        let deepest = nodes.iter().copied().max_by(|&a, &b| self.distances[a].total_cmp(&self.distances[b]));
        let Some(deepest) = deepest else { return Vec::new() };
        let within = |shift: &Vector2<f64>| -> Vec<usize> {
            nodes.iter().copied().filter(|&k| is_within(&(self.place(k) - shift), polygon)).collect()
        };
        let found = within(&Vector2::zeros());
        if !found.is_empty() || polygon.is_empty() {
            return if found.is_empty() { vec![deepest] } else { found };
        }
        let centre = polygon.iter().sum::<Vector2<f64>>() / polygon.len() as f64;
        let mut moved = within(&(self.place(deepest) - centre));
        // The front is one piece, about its first place.
        let part = self.flooded([deepest], &|k| moved.binary_search(&k).is_ok());
        moved.retain(|&k| part[k]);
        if moved.is_empty() { vec![deepest] } else { moved }
    }

    /// When a front that moves with unit speed arrives at each node inside (the eikonal equation by upwind differences); infinite
    /// elsewhere.
    fn march(&self, inside: &[bool], seeds: &[usize]) -> Vec<f64> {
        let mut times = vec![f64::INFINITY; inside.len()];
        let mut heap = BinaryHeap::new();
        for &seed in seeds {
            times[seed] = 0.0;
            heap.push(Arrival { time: 0.0, node: seed });
        }
        while let Some(Arrival { time, node }) = heap.pop() {
            if time > times[node] {
                continue;
            }
            for next in self.neighbours(node).into_iter().flatten().filter(|&k| inside[k]) {
                let arrival = self.arrival(next, &times);
                if arrival < times[next] {
                    times[next] = arrival;
                    heap.push(Arrival { time: arrival, node: next });
                }
            }
        }
        times
    }

    fn arrival(&self, node: usize, times: &[f64]) -> f64 {
        let near = self.neighbours(node).map(|k| k.map_or(f64::INFINITY, |k| times[k]));
        let (a, b) = (near[0].min(near[1]), near[2].min(near[3]));
        let (first, second, h) = (a.min(b), a.max(b), self.cell);
        // Both directions, if the front comes obliquely, otherwise one.
        let gap = second - first;
        if gap < h { 0.5 * (first + second + (2.0 * h * h - gap * gap).sqrt()) } else { first + h }
    }
}

/// A front at a node, in the order of times, the first greatest.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Arrival {
    time: f64,
    node: usize,
}

impl Eq for Arrival {}

impl PartialOrd for Arrival {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Arrival {
    fn cmp(&self, other: &Self) -> Ordering {
        other.time.total_cmp(&self.time).then(other.node.cmp(&self.node))
    }
}

/// Whether a ray to the right crosses a closed polygon an odd number of times.
fn is_within(x: &Vector2<f64>, polygon: &[Vector2<f64>]) -> bool {
    let crosses = |k: usize| {
        let (a, b) = (polygon[k], polygon[(k + 1) % polygon.len()]);
        (a.y > x.y) != (b.y > x.y) && x.x < a.x + (b.x - a.x) * (x.y - a.y) / (b.y - a.y)
    };
    (0..polygon.len()).filter(|&k| crosses(k)).count() % 2 == 1
}
