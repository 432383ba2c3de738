//! How far the points of a cloud have weight.

use mesh_core::{CloudIndex, Neighbour};
use nalgebra::Point3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Neighbours that tell the spacing around a point, itself not counted.
const AROUND: usize = 6;
/// Neighbours along which the reach grows.
const LINKS: usize = 12;
/// Largest growth of the reach per distance along neighbours.
pub(super) const GROWTH: f64 = 0.25;

/// One reach per point: `factor` times the distance to the sixth neighbour, made smaller where a point nearby has a much smaller one,
/// so that it changes slowly; 0 for points that are not finite or all lie together.
pub(super) fn reaches(index: &CloudIndex<3>, points: &[Point3<f64>], factor: f64) -> Vec<f64> {
    let (mut reach, links): (Vec<f64>, Vec<Vec<Neighbour>>) = index
        .map_nearest_n(points, LINKS + 1, |i, near| {
            let spacing = near.get(AROUND).or(near.last()).map_or(0.0, Neighbour::distance);
            (spacing * factor, near.iter().filter(|n| n.index != i).copied().collect())
        })
        .into_iter()
        .unzip();
    // Smallest first, so that each point is left once.
    let mut queue: BinaryHeap<Reverse<(Ordered, usize)>> =
        reach.iter().enumerate().map(|(i, &r)| Reverse((Ordered(r), i))).collect();
    while let Some(Reverse((Ordered(r), i))) = queue.pop() {
        if r > reach[i] || r <= 0.0 {
            continue;
        }
        for near in &links[i] {
            let most = r + GROWTH * near.distance();
            if most < reach[near.index] {
                reach[near.index] = most;
                queue.push(Reverse((Ordered(most), near.index)));
            }
        }
    }
    reach
}

/// Numbers in their total order.
#[derive(PartialEq)]
struct Ordered(f64);

impl Eq for Ordered {}

impl PartialOrd for Ordered {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Ordered {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}
