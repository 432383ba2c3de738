//! Neighbouring regions that one carrier explains become one.

use std::collections::{BTreeMap, BTreeSet};

use crate::assign::{SMALL, compact, covers};
use crate::carrier::Carrier;
use crate::graph::as_index;
use crate::grow::{Cloud, NONE, Region};
use crate::least_squares::{Fit, refine};
use nalgebra::Point3;

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
            let same = one_carrier(cloud, &carrier, big, little);
            let fit = match same {
                Some(fit) => fit,
                None => {
                    let (decision, _) = cloud.decide(&joint, Some(&carrier), false, &mut inside);
                    let Some(fit) = decision.accepted else { continue };
                    fit
                }
            };
            if !covers(cloud, &fit.carrier, &little.points) || !covers(cloud, &fit.carrier, &big.points) {
                continue;
            }
            for &i in &regions[small as usize].points {
                labels[i as usize] = large;
            }
            regions[small as usize].points.clear();
            regions[large as usize] =
                Region { points: joint, carrier: Some(fit.carrier), sweep: None, rms: fit.rms };
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

/// Most points of a region that take part in the comparison with another.
const SAMPLE: usize = 1500;

fn sample(cloud: &Cloud<'_>, points: &[u32]) -> Vec<Point3<f64>> {
    let step = points.len().div_ceil(SAMPLE).max(1);
    points.iter().step_by(step).map(|&i| cloud.points[i as usize]).collect()
}

/// The common carrier of two regions of one type, if the sums of squares of both together do not exceed those of each by more than
/// noise would: χ² with as many degrees of freedom as there are unknowns.
fn one_carrier(cloud: &Cloud<'_>, carrier: &Carrier, big: &Region, little: &Region) -> Option<Fit> {
    let other = little.carrier.filter(|c| c.unknowns() == carrier.unknowns())?;
    let (a, b) = (sample(cloud, &big.points), sample(cloud, &little.points));
    let square = |c: &Carrier, points: &[Point3<f64>]| points.iter().map(|x| c.at(x).0.powi(2)).sum::<f64>();
    let own = |c: &Carrier, points: &[Point3<f64>]| {
        refine(c, points, 10).map_or_else(|| square(c, points), |fit| square(&fit.carrier, points))
    };
    let joint: Vec<Point3<f64>> = a.iter().chain(&b).copied().collect();
    let fit = refine(carrier, &joint, 15)?;
    let more = square(&fit.carrier, &joint) - own(carrier, &a) - own(&other, &b);
    let k = carrier.unknowns() as f64;
    (more < (k + 4.0 * (2.0 * k).sqrt() + 0.01 * joint.len() as f64) * cloud.sigma.powi(2)).then_some(fit)
}
