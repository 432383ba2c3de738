//! Paths by the length of their edges alone: through points in their order, the shortest tour through points on a curve, or the longest
//! path in the tree of shortest edges of a skeleton.
//!
//! Through points that lie on a curve without noise the shortest tour follows the curve however unevenly they lie, also where it is thin and its
//! two sides are nearer to each other than neighbours along them. It does not go straight on where a curve crosses itself.

mod tour;
mod tree;

use super::nodes::{principal, thin};
use super::path::{Path, is_ordered, without_zigzag};
use crate::parallel;
use distance_field::quantile_in_place;
use mesh_core::CloudIndex;
use nalgebra::{DMatrix, Point, SVector};
use std::cmp::Ordering;
use tour::short_tour;
use tree::{longest_path, tree_length};

/// Points taken for a path at most.
const MOST: usize = 4000;
/// Numbers of neighbours tried for it.
const NEIGHBOURS: [usize; 11] = [6, 10, 16, 25, 40, 63, 100, 160, 250, 400, 630];
/// Passes that draw points to the local line.
const PASSES: usize = 4;
/// Share of the nodes that may lie off the path.
const STRAY: f64 = 0.02;
/// Fewest points of a path through all of them.
const LEAST: usize = 8;
/// Length of a tour through points on a curve, without its longest step, over that of the tree of shortest edges, at most.
const DETOUR: f64 = 1.15;
/// Gap between the ends of such a path, in units of its longest step, and of its length, up to which it is closed.
const RING: [f64; 2] = [1.5, 0.01];
/// Gap between the ends, in units of the largest steps, up to which a path is closed.
const GAP: f64 = 2.5;

/// The path by length alone; `None` where there is none.
pub(super) fn shortest<const D: usize>(points: &[SVector<f64, D>]) -> Option<Path<D>> {
    if is_ordered(points) {
        return Some(along_order(points));
    }
    through_points(points).or_else(|| through_cloud(points))
}

/// The path through points in their order, averaged over as few of them as take out the zigzag of noise.
fn along_order<const D: usize>(points: &[SVector<f64, D>]) -> Path<D> {
    let (_, mut nodes) = without_zigzag(points);
    let mut steps: Vec<f64> = nodes.windows(2).map(|p| (p[1] - p[0]).norm()).collect();
    let gap_limit = GAP * quantile_in_place(&mut steps, 0.9);
    let gap = nodes.first().zip(nodes.last()).map_or(0.0, |(a, b)| (b - a).norm());
    if gap == 0.0 && nodes.len() > 2 {
        // The first point is repeated at the end.
        nodes.pop();
    }
    Path { nodes, gap, gap_limit, ordered: true }
}

/// The path through points that lie on a curve, however unevenly: a short tour, if it is hardly longer than the tree of shortest edges
/// and does not pass to and fro across the curve, as it does where there is noise.
fn through_points<const D: usize>(points: &[SVector<f64, D>]) -> Option<Path<D>> {
    let stride = points.len().div_ceil(MOST).max(1);
    let mut nodes: Vec<SVector<f64, D>> = points.iter().step_by(stride).copied().collect();
    let order = |a: &SVector<f64, D>, b: &SVector<f64, D>| {
        a.iter().zip(b).map(|(x, y)| x.total_cmp(y)).find(|o| o.is_ne()).unwrap_or(Ordering::Equal)
    };
    nodes.sort_by(order);
    nodes.dedup();
    if nodes.len() < LEAST {
        return None;
    }
    let mut tour = short_tour(&nodes)?;
    let step = |k: usize| (nodes[tour[(k + 1) % tour.len()]] - nodes[tour[k]]).norm();
    let mut steps: Vec<f64> = (0..tour.len()).map(step).collect();
    let widest = (0..steps.len()).max_by(|&a, &b| steps[a].total_cmp(&steps[b]))?;
    tour.rotate_left((widest + 1) % steps.len());
    let gap = steps.swap_remove(widest);
    let second = steps.iter().copied().fold(0.0, f64::max);
    let length: f64 = steps.iter().sum();
    if length > DETOUR * tree_length(&nodes) {
        return None;
    }
    let nodes: Vec<SVector<f64, D>> = tour.into_iter().map(|i| nodes[i]).collect();
    if without_zigzag(&nodes).0 > 1 {
        return None;
    }
    Some(Path { nodes, gap, gap_limit: RING[0] * second + RING[1] * length, ordered: false })
}

/// The longest path in the tree of shortest edges between points drawn to a skeleton, for the narrowest neighbourhoods
/// for which it passes all of them.
fn through_cloud<const D: usize>(points: &[SVector<f64, D>]) -> Option<Path<D>> {
    let stride = points.len().div_ceil(MOST).max(1);
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

    /// A thin section, its points dense at the ends and wide apart on the sides, as far as these are from each other.
    fn thin_section(n: usize) -> Vec<Vector2<f64>> {
        let angle = |i: usize| std::f64::consts::TAU * i as f64 / n as f64;
        let slowed = |a: f64| a - 0.49 * (2.0 * a).sin();
        (0..n).map(angle).map(slowed).map(|a| Vector2::new(20.0 * a.cos(), a.sin())).collect()
    }

    #[test]
    fn narrow_rings_with_uneven_points_are_followed() {
        let ring = thin_section(100);
        let path = through_points(&shuffled(&ring)).unwrap();
        assert!(path.is_closed() && path.nodes.len() == ring.len(), "{} {}", path.gap, path.gap_limit);
        // In the order of the ring, one way or the other, from some point on.
        let place = |p: &Vector2<f64>| ring.iter().position(|q| p == q).unwrap();
        let order: Vec<usize> = path.nodes.iter().map(place).collect();
        let steps = order.iter().zip(order.iter().cycle().skip(1)).map(|(a, b)| (b + 100 - a) % 100);
        let steps: Vec<usize> = steps.collect();
        assert!(steps.iter().all(|&s| s == steps[0]) && [1, 99].contains(&steps[0]), "{steps:?}");
        // Without a side it is open.
        let open: Vec<_> = ring.iter().filter(|p| p.y > -0.2).copied().collect();
        let path = through_points(&open).unwrap();
        assert!(!path.is_closed(), "{} {}", path.gap, path.gap_limit);
    }

    #[test]
    fn a_thick_cloud_has_no_path_through_all_points() {
        let spread = |i: u32, step: f64| (f64::from(i) * step).fract() - 0.5;
        let noisy = |i: u32| {
            let a = std::f64::consts::TAU * spread(i, 0.618_034);
            Vector2::new(a.cos(), a.sin()) * (1.0 + 0.2 * spread(i, 0.754_878))
        };
        assert!(through_points(&(0..600).map(noisy).collect::<Vec<_>>()).is_none());
    }
}
