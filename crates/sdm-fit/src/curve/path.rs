//! A polygon along a cloud: from the order of its points, or from their places alone.

use super::crossing::plane;
use super::nodes::{dense, draw, roundness, supported, thin};
use super::parts::{Asked, Parts, chains, in_order};
use crate::parallel;
use distance_field::quantile_in_place;
use mesh_core::CloudIndex;
use nalgebra::{Point, SVector, Vector2};
use std::cmp::Ordering;

/// Points taken for a path at most.
const MOST: usize = 4000;
/// Numbers of neighbours tried for it.
const NEIGHBOURS: [usize; 11] = [6, 10, 16, 25, 40, 63, 100, 160, 250, 400, 630];
/// Share of the points that may lie off the path.
const STRAY: f64 = 0.1;
/// Steps between consecutive points of an ordered cloud, as a share of the distance of points half a cloud apart.
const STEP: [f64; 2] = [0.2, 0.35];
/// Points by which the scatter about a path is told, at most.
const SCATTERED: usize = 500;
/// Fewest points of a path.
const LEAST: usize = 4;
/// Median angle between the edges of a path through points and through drawn nodes, at most, and of one that is better than none, in radians.
const TURNS: [f64; 3] = [0.5, 0.6, 1.0];
/// A polygon is smooth where twice the window shortens it by less than this factor.
const ZIGZAG: f64 = 1.1;
/// Parts into which points in their order may fall.
const PARTS: usize = 12;
/// Width of a neighbourhood as a share of its length beyond which no curve is to be seen, first and, if there is no path then, at last.
const ROUND: [f64; 2] = [0.35, 0.45];
/// Wider neighbourhoods that are tried where there are several paths.
const WIDER: usize = 2;
/// Edges of a path that are nearly next to each other.
const NEXT: usize = 6;

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

    /// Distance of a point from the nearest edge, the one from the last node to the first included if the path is closed.
    pub(crate) fn distance(&self, x: &SVector<f64, D>) -> f64 {
        let back = if self.is_closed() { self.nodes.last().zip(self.nodes.first()) } else { None };
        let edges = self.nodes.iter().zip(self.nodes.iter().skip(1)).chain(back);
        let square = |(a, b): (&SVector<f64, D>, &SVector<f64, D>)| {
            let (along, away) = (b - a, x - a);
            let share = (along.dot(&away) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            (away - along * share).norm_squared()
        };
        edges.map(square).fold(f64::INFINITY, f64::min).sqrt()
    }

    /// Root mean square distance of points from the nearest edge of the path.
    pub(crate) fn scatter(&self, points: &[SVector<f64, D>]) -> f64 {
        let stride = points.len().div_ceil(SCATTERED).max(1);
        let squares: Vec<f64> = points.iter().step_by(stride).map(|x| self.distance(x).powi(2)).collect();
        (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
    }

    /// How often a path in the plane crosses itself, but for crossings of edges that are nearly next to each other.
    pub(crate) fn crossings(&self, closed: bool) -> usize {
        let n = self.nodes.len();
        if D != 2 || n < 2 * NEXT {
            return 0;
        }
        let edges = if closed { n } else { n - 1 };
        let edge = |k: usize| (plane(&self.nodes[k]), plane(&self.nodes[(k + 1) % n]));
        let crosses = |i: usize, j: usize| {
            let ((a, b), (c, d)) = (edge(i), edge(j));
            let apart = a.inf(&b).zip_map(&c.sup(&d), |low, high| low > high);
            let beyond = c.inf(&d).zip_map(&a.sup(&b), |low, high| low > high);
            if apart.iter().chain(beyond.iter()).any(|x| *x) {
                return false;
            }
            let side = |p: &Vector2<f64>, q: &Vector2<f64>, x: &Vector2<f64>| (q - p).perp(&(x - p)) > 0.0;
            side(&a, &b, &c) != side(&a, &b, &d) && side(&c, &d, &a) != side(&c, &d, &b)
        };
        let counts = parallel::map(edges, |i| {
            let near = |j: usize| j - i <= NEXT || closed && n + i - j <= NEXT;
            (i + 1..edges).filter(|&j| !near(j) && crosses(i, j)).count()
        });
        counts.iter().sum()
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

/// Points averaged by so many in their order as take out the zigzag of noise, and how many these are.
pub(super) fn without_zigzag<const D: usize>(points: &[SVector<f64, D>]) -> (usize, Vec<SVector<f64, D>>) {
    let averaged = |window: usize| -> Vec<SVector<f64, D>> {
        points
            .chunks(window)
            .filter(|block| 2 * block.len() > window)
            .map(|block| block.iter().sum::<SVector<f64, D>>() / block.len() as f64)
            .collect()
    };
    let length = |nodes: &[SVector<f64, D>]| nodes.windows(2).map(|p| (p[1] - p[0]).norm()).sum::<f64>();
    let (mut window, mut nodes) = (1, averaged(1));
    loop {
        let wider = averaged(2 * window);
        // The ends are half a window shorter.
        let reach = 1.0 + 1.0 / wider.len().max(1) as f64;
        if wider.len() < 8 || length(&nodes) <= ZIGZAG * reach * length(&wider) {
            return (window, nodes);
        }
        (window, nodes) = (2 * window, wider);
    }
}

/// The paths through points in their order, averaged over as few of them as take out the zigzag of noise; `None` where they fall into
/// many.
pub(super) fn along_order<const D: usize>(points: &[SVector<f64, D>], asked: Asked) -> Option<Vec<Path<D>>> {
    let (_, nodes) = without_zigzag(points);
    let found = in_order(nodes, asked);
    (1..=PARTS).contains(&found.paths.len()).then_some(found.paths)
}

/// The paths through points in any order: through the points themselves if that goes straight on, else through what is left when points
/// are drawn to the lines of their neighbourhoods, the narrowest ones for which it does. `None` where there is no path.
pub(super) fn through<const D: usize>(points: &[SVector<f64, D>], asked: Asked) -> Option<Vec<Path<D>>> {
    let stride = points.len().div_ceil(MOST).max(1);
    let mut sample: Vec<SVector<f64, D>> = points.iter().step_by(stride).copied().collect();
    let order = |a: &SVector<f64, D>, b: &SVector<f64, D>| {
        a.iter().zip(b).map(|(x, y)| x.total_cmp(y)).find(|o| o.is_ne()).unwrap_or(Ordering::Equal)
    };
    sample.sort_by(order);
    sample.dedup();
    if sample.len() < LEAST {
        return None;
    }
    let mut sample = supported(sample);
    sample.dedup();
    let sample = sample;
    if let Some(found) = chains(&sample, None, asked)
        && is_good(&found, TURNS[0])
        && strays(&found.paths, &sample, None) <= STRAY
    {
        return Some(found.paths);
    }
    let places: Vec<Point<f64, D>> = sample.iter().copied().map(Point::from).collect();
    let index = CloudIndex::new(&places).ok()?;
    // The best of what is not good, if nothing is.
    let mut second: Option<(f64, Vec<Path<D>>)> = None;
    let (mut several, mut tried): (Option<Vec<Path<D>>>, usize) = (None, 0);
    for (round, count) in ROUND.into_iter().flat_map(|round| NEIGHBOURS.map(|count| (round, count))) {
        if count > (sample.len() / 3).max(NEIGHBOURS[0]) {
            continue;
        }
        let mut reach =
            index.map_nearest_n(&places, count + 1, |_, near| near.last().map_or(0.0, |n| n.distance()));
        let radius = quantile_in_place(&mut reach, 0.5);
        if radius.is_nan() || radius <= 0.0 {
            continue;
        }
        let width = roundness(&index, &sample, radius);
        // The second time those that were not looked at before.
        if width > round || round > ROUND[0] && width <= ROUND[0] {
            continue;
        }
        let drawn = draw(&index, &sample, radius);
        let nodes = dense(&drawn, thin(&drawn, 0.5 * radius), radius);
        if nodes.len() < LEAST {
            continue;
        }
        let Some(mut found) = chains(&nodes, Some(&drawn), asked) else { continue };
        let stray = strays(&found.paths, &sample, Some(radius));
        if stray > STRAY || found.turn > TURNS[2] || found.lanes || found.paths.is_empty() {
            continue;
        }
        found
            .paths
            .iter_mut()
            .filter(|path| !path.is_closed())
            .for_each(|path| reach_ends(path, &drawn, radius));
        if is_good(&found, TURNS[1]) {
            if found.paths.len() == 1 {
                return Some(found.paths);
            }
            // Points that hardly show a path may show two where there is one that a little more width makes out.
            several.get_or_insert(found.paths);
            tried += 1;
            if tried > WIDER {
                return several;
            }
            continue;
        }
        if second.as_ref().is_none_or(|other| found.turn < other.0) {
            second = Some((found.turn, found.paths));
        }
    }
    several.or(second.map(|found| found.1))
}

fn is_good<const D: usize>(found: &Parts<D>, turn: f64) -> bool {
    !found.paths.is_empty() && !found.lanes && found.turn <= turn
}

/// Share of the points that are further from all paths than a distance; than a step of the path, if none is given.
fn strays<const D: usize>(paths: &[Path<D>], points: &[SVector<f64, D>], far: Option<f64>) -> f64 {
    let far = far.unwrap_or_else(|| {
        let mut steps: Vec<f64> =
            paths.iter().flat_map(|p| p.nodes.windows(2).map(|n| (n[1] - n[0]).norm())).collect();
        quantile_in_place(&mut steps, 0.9)
    });
    let stray = parallel::map(points.len(), |i| paths.iter().all(|path| path.distance(&points[i]) > far));
    stray.iter().filter(|s| **s).count() as f64 / points.len().max(1) as f64
}

/// Lengthens a path at its ends to where the points end.
fn reach_ends<const D: usize>(path: &mut Path<D>, drawn: &[SVector<f64, D>], radius: f64) {
    for _ in 0..2 {
        path.nodes.reverse();
        let n = path.nodes.len();
        let end = path.nodes[n - 1];
        let Some(way) = (end - path.nodes[n.saturating_sub(3)]).try_normalize(0.0) else { continue };
        let beyond = |p: &SVector<f64, D>| {
            let (along, across) = (way.dot(&(p - end)), (p - end) - way * way.dot(&(p - end)));
            (along > 0.0 && along <= 2.0 * radius && across.norm() <= 0.5 * radius).then_some(along)
        };
        let furthest = drawn.iter().filter_map(beyond).fold(0.0, f64::max);
        if furthest > 0.1 * radius {
            path.nodes.push(end + way * furthest);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    const ANY: Asked = Asked { closed: None, gap: None, outliers: false };

    fn arc(n: usize, angle: f64) -> Vec<Vector2<f64>> {
        (0..n).map(|i| angle * i as f64 / (n - 1) as f64).map(|a| Vector2::new(a.cos(), a.sin())).collect()
    }

    /// The points of a count that 77 has no factor in common with, in a scattered order.
    fn shuffled(points: &[Vector2<f64>]) -> Vec<Vector2<f64>> {
        (0..points.len()).map(|i| points[i * 77 % points.len()]).collect()
    }

    fn single(paths: Option<Vec<Path<2>>>) -> Path<2> {
        let mut paths = paths.unwrap();
        assert_eq!(paths.len(), 1);
        paths.remove(0)
    }

    #[test]
    fn order_and_closure_are_seen() {
        for n in [8, 20, 101] {
            let ring = &arc(n + 1, std::f64::consts::TAU)[..n];
            assert!(is_ordered(ring) && single(along_order(ring, ANY)).is_closed(), "{n}");
            let half = arc(n, 3.0);
            assert!(is_ordered(&half) && !single(along_order(&half, ANY)).is_closed(), "{n}");
        }
        let ring = shuffled(&arc(200, 6.25));
        assert!(!is_ordered(&ring));
        let path = single(through(&ring, ANY));
        assert!(path.is_closed() && path.nodes.len() > 10);
        assert!(!single(through(&shuffled(&arc(200, 4.0)), ANY)).is_closed());
    }

    #[test]
    fn a_thick_ring_is_followed_and_a_disc_is_none() {
        let spread = |i: u32, step: f64| (f64::from(i) * step).fract() - 0.5;
        let noisy = |i: u32| {
            let a = std::f64::consts::TAU * spread(i, 0.618_034);
            Vector2::new(a.cos(), a.sin()) * (1.0 + 0.2 * spread(i, 0.754_878))
        };
        let path = single(through(&(0..600).map(noisy).collect::<Vec<_>>(), ANY));
        assert!(path.is_closed() && path.nodes.len() < 200, "{}", path.nodes.len());
        let disc = |i: u32| noisy(i).normalize() * (spread(i, 0.754_878) + 0.5).sqrt();
        assert!(through(&(0..600).map(disc).collect::<Vec<_>>(), ANY).is_none());
    }
}
