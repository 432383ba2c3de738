//! Pieces of a general cylinder become one region, before other pieces are joined.
//!
//! On an extrusion primitives fit piece by piece: cylinders and strips of planes, all parallel to one direction. What is only smooth beside
//! it, as a blend along its end, is not, and must not be joined with it.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use nalgebra::Vector3;

use crate::assign::compact;
use crate::carrier::Carrier;
use crate::graph::as_index;
use crate::grow::{Cloud, NONE, Region};
use crate::merge::adjacency;
use crate::smooth::{LINKS, border_links, is_mostly_one, is_smooth};
use crate::sweep::{Sweep, decide_sweep};

/// Sine of the angle by which pieces of noisy points may be turned out of the common direction.
const PARALLEL: f64 = 0.06;
/// Fewest points of a piece that a cluster begins with, and of one that may follow.
const FIRST: usize = 60;
const FEWEST: usize = 20;

/// The direction of a region that is swept along one.
fn direction(region: &Region) -> Option<Vector3<f64>> {
    match (&region.carrier, &region.sweep) {
        (Some(Carrier::Cylinder { axis, .. }), _) | (None, Some(Sweep::Extrusion { axis })) => Some(*axis),
        _ => None,
    }
}

/// Whether a region may be a piece of an extrusion along a direction.
fn is_along(region: &Region, axis: &Vector3<f64>) -> bool {
    if let Some(Carrier::Plane { normal, .. }) = &region.carrier {
        return normal.dot(axis).abs() < PARALLEL;
    }
    direction(region).is_some_and(|own| own.cross(axis).norm() < PARALLEL)
}

/// Joins clusters of smoothly connected pieces that one direction sweeps; returns the number of clusters.
pub(crate) fn extrude(cloud: &Cloud<'_>, regions: &mut Vec<Region>, labels: &mut [u32]) -> usize {
    let pairs = adjacency(cloud, labels);
    let borders = border_links(cloud, labels, &pairs);
    let mut around: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
    for &(a, b) in borders.keys() {
        around.entry(a).or_default().insert(b);
        around.entry(b).or_default().insert(a);
    }
    let mut order: Vec<u32> = (0..regions.len()).map(as_index).collect();
    order.sort_by_key(|&k| (std::cmp::Reverse(regions[k as usize].points.len()), k));
    let mut taken = vec![false; regions.len()];
    let mut inside = vec![false; labels.len()];
    let mut joined = 0;
    for first in order {
        let seed = &regions[first as usize];
        let Some(axis) = direction(seed).filter(|_| seed.points.len() >= FIRST) else { continue };
        if taken[first as usize] {
            continue;
        }
        let mut members = vec![first];
        let mut queue = VecDeque::from([first]);
        let mut seen = BTreeSet::from([first]);
        while let Some(k) = queue.pop_front() {
            for &other in around.get(&k).into_iter().flatten() {
                let region = &regions[other as usize];
                if seen.contains(&other)
                    || taken[other as usize]
                    || region.points.len() < FEWEST
                    || !is_along(region, &axis)
                {
                    continue;
                }
                let (a, b) = (k.min(other), k.max(other));
                let Some(links) = borders.get(&(a, b)).filter(|links| links.len() >= LINKS) else { continue };
                if is_smooth(cloud, labels, &regions[a as usize], &regions[b as usize], links) {
                    seen.insert(other);
                    members.push(other);
                    queue.push_back(other);
                }
            }
        }
        let places: Vec<usize> = members.iter().map(|&k| k as usize).collect();
        if members.len() < 2 || is_mostly_one(regions, &places) {
            continue;
        }
        let mut points: Vec<u32> = places.iter().flat_map(|&k| regions[k].points.iter().copied()).collect();
        points.sort_unstable();
        let core = cloud.core(&points, &mut inside);
        let found = decide_sweep(&cloud.positions(&core), &cloud.normals(&core), cloud.sigma);
        let Some((sweep @ Sweep::Extrusion { .. }, rms)) = found else { continue };
        for &k in &places {
            taken[k] = true;
            regions[k].points.clear();
        }
        for &i in &points {
            labels[i as usize] = first;
        }
        regions[first as usize] = Region { points, carrier: None, sweep: Some(sweep), rms };
        joined += 1;
    }
    compact(regions, labels, 1);
    debug_assert!(labels.iter().all(|&l| l == NONE || (l as usize) < regions.len()));
    joined
}
