//! A polygon along a cloud: from the order of its points, or from their places alone.

use crate::parallel;
use distance_field::quantile_in_place;
use mesh_core::CloudIndex;
use nalgebra::{DMatrix, Point, SVector};

/// Points taken for a skeleton at most.
const SKELETON: usize = 4000;
/// Numbers of neighbours tried for it.
const NEIGHBOURS: [usize; 11] = [6, 10, 16, 25, 40, 63, 100, 160, 250, 400, 630];
/// Passes that draw points to the local line.
const PASSES: usize = 4;
/// Share of the nodes that may lie off the path.
const STRAY: f64 = 0.02;
/// Steps between consecutive points of an ordered cloud, as a share of the distance of points half a cloud apart.
const STEP: [f64; 2] = [0.2, 0.35];
/// Gap between the ends, in units of the largest steps, up to which a path is closed.
const GAP: f64 = 2.5;
/// A polygon is smooth where twice the window shortens it by less than this factor.
const ZIGZAG: f64 = 1.1;

/// A polygon along the data.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Path<const D: usize> {
    pub(crate) nodes: Vec<SVector<f64, D>>,
    /// Distance between the ends, and what it was compared with.
    pub(crate) gap: f64,
    pub(crate) gap_limit: f64,
    /// Whether the order of the points was used.
    pub(crate) ordered: bool,
}

impl<const D: usize> Path<D> {
    /// Whether the ends are as near to each other as neighbours on the path.
    pub(crate) fn is_closed(&self) -> bool {
        self.nodes.len() > 3 && self.gap <= self.gap_limit
    }

    /// Lengths from the first node to each, and in all, the way back included if `closed`.
    pub(crate) fn lengths(&self, closed: bool) -> (Vec<f64>, f64) {
        let mut out = vec![0.0];
        let mut at = 0.0;
        for pair in self.nodes.windows(2) {
            at += (pair[1] - pair[0]).norm();
            out.push(at);
        }
        let back = match (self.nodes.first(), self.nodes.last()) {
            (Some(first), Some(last)) if closed => (first - last).norm(),
            _ => 0.0,
        };
        (out, at + back)
    }
}

/// Whether consecutive points are neighbours.
pub(crate) fn is_ordered<const D: usize>(points: &[SVector<f64, D>]) -> bool {
    let n = points.len();
    if n < 4 {
        return true;
    }
    let mut steps: Vec<f64> = points.windows(2).map(|p| (p[1] - p[0]).norm()).collect();
    let mut far: Vec<f64> = (0..n).map(|i| (points[(i + n / 2) % n] - points[i]).norm()).collect();
    let far = quantile_in_place(&mut far, 0.5);
    // Few points are far from each other even along a curve.
    let few = 4.0 / n as f64;
    [0.5, 0.9]
        .into_iter()
        .zip(STEP)
        .all(|(share, limit)| quantile_in_place(&mut steps, share) <= limit.max(few * limit / STEP[0]) * far)
}

/// The path through points in their order, averaged over as few of them as take out the zigzag of noise.
pub(crate) fn along_order<const D: usize>(points: &[SVector<f64, D>]) -> Path<D> {
    let averaged = |window: usize| -> Vec<SVector<f64, D>> {
        points
            .chunks(window)
            .filter(|block| 2 * block.len() > window)
            .map(|block| block.iter().sum::<SVector<f64, D>>() / block.len() as f64)
            .collect()
    };
    let length = |nodes: &[SVector<f64, D>]| nodes.windows(2).map(|p| (p[1] - p[0]).norm()).sum::<f64>();
    let mut window = 1;
    let mut nodes = averaged(1);
    loop {
        let wider = averaged(2 * window);
        // The ends are half a window shorter.
        let reach = 1.0 + 1.0 / wider.len().max(1) as f64;
        if wider.len() < 8 || length(&nodes) <= ZIGZAG * reach * length(&wider) {
            break;
        }
        (window, nodes) = (2 * window, wider);
    }
    let mut steps: Vec<f64> = nodes.windows(2).map(|p| (p[1] - p[0]).norm()).collect();
    let gap_limit = GAP * quantile_in_place(&mut steps, 0.9);
    let gap = nodes.first().zip(nodes.last()).map_or(0.0, |(a, b)| (b - a).norm());
    if gap == 0.0 && nodes.len() > 2 {
        // The first point is repeated at the end.
        nodes.pop();
    }
    Path { nodes, gap, gap_limit, ordered: true }
}

/// The longest path in the tree of shortest edges between points drawn to a skeleton, for the narrowest neighbourhoods
/// for which it passes all of them.
pub(crate) fn through_cloud<const D: usize>(points: &[SVector<f64, D>]) -> Option<Path<D>> {
    let stride = points.len().div_ceil(SKELETON).max(1);
    let sample: Vec<SVector<f64, D>> = points.iter().step_by(stride).copied().collect();
    let places: Vec<Point<f64, D>> = sample.iter().copied().map(Point::from).collect();
    let index = CloudIndex::new(&places).ok()?;
    let mut best: Option<(f64, Path<D>)> = None;
    for count in NEIGHBOURS {
        if count > (sample.len() / 3).max(NEIGHBOURS[0]) {
            break;
        }
        let mut reach =
            index.map_nearest_n(&places, count + 1, |_, near| near.last().map_or(0.0, |n| n.distance()));
        let radius = quantile_in_place(&mut reach, 0.5);
        if radius.is_nan() || radius <= 0.0 {
            continue;
        }
        let drawn = draw(&index, &sample, radius);
        let nodes = thin(&drawn, 0.5 * radius);
        if nodes.len() < 4 {
            continue;
        }
        let order = longest_path(&nodes);
        let path: Vec<_> = order.iter().map(|&i| nodes[i]).collect();
        let stray = nodes.iter().filter(|node| distance(&path, node) > radius).count();
        let stray = stray as f64 / nodes.len() as f64;
        let longest = path.windows(2).map(|p| (p[1] - p[0]).norm()).fold(0.0, f64::max);
        let ends = path.first().zip(path.last()).map_or(0.0, |(a, b)| (b - a).norm());
        let gap_limit = (GAP * radius).min(0.5 * longest.max(radius) * path.len() as f64).max(longest);
        let path = Path { nodes: path, gap: ends, gap_limit, ordered: false };
        let fits = stray <= STRAY && longest <= 3.0 * radius;
        if fits {
            return Some(path);
        }
        if best.as_ref().is_none_or(|b| stray < b.0) {
            best = Some((stray, path));
        }
    }
    best.filter(|b| b.0 < 0.1).map(|b| b.1)
}

/// Points drawn to the line of least squares through their neighbourhoods, a few times.
fn draw<const D: usize>(
    index: &CloudIndex<D>,
    sample: &[SVector<f64, D>],
    radius: f64,
) -> Vec<SVector<f64, D>> {
    parallel::map(sample.len(), |i| {
        let mut x = sample[i];
        for _ in 0..PASSES {
            let near = index.within(&Point::from(x), radius);
            let Some((centre, direction)) = local_line(sample, &near, radius) else { break };
            x = centre + direction * direction.dot(&(x - centre));
        }
        x
    })
}

fn local_line<const D: usize>(
    sample: &[SVector<f64, D>],
    near: &[mesh_core::Neighbour],
    radius: f64,
) -> Option<(SVector<f64, D>, SVector<f64, D>)> {
    let weight = |n: &mesh_core::Neighbour| (1.0 - n.distance_sq / (radius * radius)).max(0.0).powi(2);
    let total: f64 = near.iter().map(weight).sum();
    if near.len() < 3 || total <= 0.0 {
        return None;
    }
    let centre = near.iter().map(|n| sample[n.index] * weight(n)).sum::<SVector<f64, D>>() / total;
    let mut moments = DMatrix::zeros(D, D);
    for n in near {
        let r = sample[n.index] - centre;
        for a in 0..D {
            for b in 0..D {
                moments[(a, b)] += weight(n) * r[a] * r[b];
            }
        }
    }
    principal(moments).map(|(direction, _)| (centre, direction))
}

/// The eigenvector of the largest eigenvalue of a symmetric matrix, and all eigenvalues in decreasing order.
pub(crate) fn principal<const D: usize>(moments: DMatrix<f64>) -> Option<(SVector<f64, D>, Vec<f64>)> {
    if moments.iter().any(|x| !x.is_finite()) {
        return None;
    }
    let eigen = moments.symmetric_eigen();
    let direction = SVector::from_fn(|i, _| eigen.eigenvectors[(i, eigen.eigenvalues.imax())]);
    let mut values: Vec<f64> = eigen.eigenvalues.iter().copied().collect();
    values.sort_by(|a, b| b.total_cmp(a));
    Some((direction, values))
}

/// Points of which no two are nearer than `spacing`, by first come.
fn thin<const D: usize>(points: &[SVector<f64, D>], spacing: f64) -> Vec<SVector<f64, D>> {
    let mut out: Vec<SVector<f64, D>> = Vec::new();
    for p in points {
        if out.iter().all(|q| (p - q).norm() >= spacing) {
            out.push(*p);
        }
    }
    out
}

/// The longest path in the minimum spanning tree (Prim's algorithm; twice the furthest node).
fn longest_path<const D: usize>(nodes: &[SVector<f64, D>]) -> Vec<usize> {
    let n = nodes.len();
    let mut tree: Vec<Vec<(usize, f64)>> = vec![Vec::new(); n];
    let mut nearest = vec![(f64::INFINITY, 0); n];
    let mut inside = vec![false; n];
    let mut current = 0;
    for _ in 1..n {
        inside[current] = true;
        let mut next = (f64::INFINITY, usize::MAX);
        for i in 0..n {
            if inside[i] {
                continue;
            }
            let length = (nodes[i] - nodes[current]).norm();
            if length < nearest[i].0 {
                nearest[i] = (length, current);
            }
            if nearest[i].0 < next.0 {
                next = (nearest[i].0, i);
            }
        }
        if next.1 == usize::MAX {
            break;
        }
        let (length, from) = nearest[next.1];
        tree[from].push((next.1, length));
        tree[next.1].push((from, length));
        current = next.1;
    }
    let (end, _) = furthest(&tree, 0);
    let (other, before) = furthest(&tree, end);
    let mut path = vec![other];
    let mut at = other;
    while at != end {
        at = before[at];
        path.push(at);
    }
    path
}

/// The node furthest from another along the tree, and for each node the one before on the way.
fn furthest(tree: &[Vec<(usize, f64)>], from: usize) -> (usize, Vec<usize>) {
    let mut before = vec![from; tree.len()];
    let mut best = (0.0, from);
    let mut stack = vec![(from, from, 0.0)];
    while let Some((node, parent, length)) = stack.pop() {
        before[node] = parent;
        if length > best.0 {
            best = (length, node);
        }
        for &(next, edge) in tree[node].iter().filter(|(next, _)| *next != parent) {
            stack.push((next, node, length + edge));
        }
    }
    (best.1, before)
}

fn distance<const D: usize>(path: &[SVector<f64, D>], x: &SVector<f64, D>) -> f64 {
    path.iter().map(|p| (p - x).norm()).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    fn arc(n: usize, angle: f64) -> Vec<Vector2<f64>> {
        (0..n).map(|i| angle * i as f64 / (n - 1) as f64).map(|a| Vector2::new(a.cos(), a.sin())).collect()
    }

    /// The points of a count that 77 has no factor in common with, in a scattered order.
    fn shuffled(points: &[Vector2<f64>]) -> Vec<Vector2<f64>> {
        (0..points.len()).map(|i| points[i * 77 % points.len()]).collect()
    }

    #[test]
    fn order_and_closure_are_seen() {
        for n in [8, 20, 101] {
            let ring = &arc(n + 1, std::f64::consts::TAU)[..n];
            assert!(is_ordered(ring) && along_order(ring).is_closed(), "{n}");
            let half = arc(n, 3.0);
            assert!(is_ordered(&half) && !along_order(&half).is_closed(), "{n}");
        }
        let ring = shuffled(&arc(200, 6.25));
        assert!(!is_ordered(&ring));
        let path = through_cloud(&ring).unwrap();
        assert!(path.is_closed() && path.nodes.len() > 10);
        let path = through_cloud(&shuffled(&arc(200, 4.0))).unwrap();
        assert!(!path.is_closed());
    }
}
