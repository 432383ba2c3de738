//! Neighbouring regions that one carrier explains become one.

use std::collections::{BTreeMap, BTreeSet};

use crate::assign::{SMALL, compact, covers};
use crate::graph::as_index;
use crate::carrier::Carrier;
use crate::grow::{Cloud, NONE, Region};

/// Numbers of links between regions, the smaller label first.
pub(crate) fn adjacency(cloud: &Cloud<'_>, labels: &[u32]) -> BTreeMap<(u32, u32), usize> {
    let mut pairs = BTreeMap::new();
    for i in 0..labels.len() {
        for &j in cloud.graph.around(i) {
            let (a, b) = (labels[i], labels[j as usize]);
            if a != b && a != NONE && b != NONE {
                *pairs.entry((a.min(b), a.max(b))).or_insert(0) += 1;
            }
        }
    }
    pairs
}

/// Merges pairs until no pair is left that one carrier explains. `links` is the least number of links of neighbours.
pub(crate) fn merge(cloud: &Cloud<'_>, regions: &mut Vec<Region>, labels: &mut [u32], links: usize) -> usize {
    let mut inside = vec![false; labels.len()];
    let mut merged = 0;
    // Pairs that no carrier explains, by what decides it: the labels and the numbers of points.
    let mut refused: BTreeSet<(u32, u32, usize, usize)> = BTreeSet::new();
    loop {
        let mut pairs = adjacency(cloud, labels);
        add_small(cloud, regions, labels, &mut pairs);
        let mut order: Vec<(usize, u32, u32)> = pairs
            .iter()
            .filter(|(_, count)| **count >= links)
            .map(|(&(a, b), _)| {
                let (x, y) = (regions[a as usize].points.len(), regions[b as usize].points.len());
                (x.min(y), a, b)
            })
            .collect();
        order.sort_unstable();
        let mut changed = vec![false; regions.len()];
        let mut any = false;
        for (_, a, b) in order {
            if changed[a as usize] || changed[b as usize] {
                continue;
            }
            let (one, other) = (&regions[a as usize], &regions[b as usize]);
            let (large, small) = if one.points.len() >= other.points.len() { (a, b) } else { (b, a) };
            let (big, little) = (&regions[large as usize], &regions[small as usize]);
            let (Some(carrier), Some(_)) = (big.carrier, little.carrier) else { continue };
            if !refused.insert((a, b, one.points.len(), other.points.len())) {
                continue;
            }
            // Cheap refusal: neither carrier comes near the points of the other.
            if !near(cloud, &carrier, &little.points) {
                continue;
            }
            let joint: Vec<u32> = {
                let mut all: Vec<u32> = big.points.iter().chain(&little.points).copied().collect();
                all.sort_unstable();
                all
            };
            let (decision, _) = cloud.decide(&joint, Some(&carrier), false, &mut inside);
            let Some(fit) = decision.accepted else { continue };
            if !covers(cloud, &fit.carrier, &little.points) || !covers(cloud, &fit.carrier, &big.points) {
                continue;
            }
            for &i in &regions[small as usize].points {
                labels[i as usize] = large;
            }
            regions[small as usize].points.clear();
            regions[large as usize] = Region { points: joint, carrier: Some(fit.carrier), sweep: None, rms: fit.rms };
            changed[a as usize] = true;
            changed[b as usize] = true;
            any = true;
            merged += 1;
        }
        if !any {
            break;
        }
    }
    compact(regions, labels, 1);
    merged
}

/// Whether a carrier comes near enough to some points that another of nearly the same shape may explain them.
fn near(cloud: &Cloud<'_>, carrier: &Carrier, points: &[u32]) -> bool {
    let mut far: Vec<f64> = points.iter().map(|&i| carrier.at(&cloud.points[i as usize]).0.abs()).collect();
    let middle = far.len() / 2;
    let (_, median, _) = far.select_nth_unstable_by(middle, f64::total_cmp);
    let spacing = cloud.graph.spacing[points[points.len() / 2] as usize];
    *median < 10.0 * cloud.sigma + 0.5 * spacing
}

/// Links of small regions over all their neighbours.
fn add_small(cloud: &Cloud<'_>, regions: &[Region], labels: &[u32], pairs: &mut BTreeMap<(u32, u32), usize>) {
    for (k, region) in regions.iter().enumerate().filter(|(_, r)| r.points.len() < SMALL) {
        for &i in &region.points {
            for &j in cloud.graph.near(i as usize) {
                let (a, b) = (as_index(k), labels[j as usize]);
                if b != NONE && a != b && regions[b as usize].points.len() < SMALL {
                    *pairs.entry((a.min(b), a.max(b))).or_insert(0) += 1;
                }
            }
        }
    }
}
