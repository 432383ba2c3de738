//! Every point goes to the carrier that explains it best together with its neighbours.

use crate::carrier::Carrier;
use crate::graph::as_index;
use crate::grow::{Cloud, NONE, Region};
use crate::least_squares::refine;
use crate::sweep::Sweep;
use nalgebra::Point3;

/// Cost of a point that no carrier explains: that of 4 standard deviations.
const UNEXPLAINED: f64 = 8.0;
/// Cost of a distance beyond 5 standard deviations.
const FAR: f64 = 12.5;
/// Largest cost of a normal.
const TURNED: f64 = 3.0;
/// Bias of normals in radians that costs nothing.
const FREE_TURN: f64 = 0.1;
/// Cost of a neighbour with another label.
const BORDER: f64 = 1.0;
/// Regions of fewer points are linked over all neighbours: narrow strips have no others of their own between them.
pub(crate) const SMALL: usize = 500;
/// Most sweeps.
const SWEEPS: usize = 8;

/// Cost of a point on a region.
fn cost(cloud: &Cloud<'_>, region: &Region, label: u32, labels: &[u32], i: usize) -> f64 {
    let sigma = cloud.sigma;
    let Some(carrier) = &region.carrier else {
        let along = match &region.sweep {
            Some(Sweep::Extrusion { axis }) => tilt_cost(cloud, i, axis),
            _ => 0.0,
        };
        return smooth_cost(cloud, label, labels, i) + along;
    };
    let (d, n) = carrier.at(&cloud.points[i]);
    let q = d / sigma;
    (0.5 * q * q).min(FAR) + turn_cost(cloud, i, &n)
}

fn turn_cost(cloud: &Cloud<'_>, i: usize, normal: &nalgebra::Vector3<f64>) -> f64 {
    let own = &cloud.jets.normals[i];
    if !own.deviation.is_finite() {
        return 0.0;
    }
    let angle = own.normal.dot(normal).abs().min(1.0).acos();
    let q = (angle - FREE_TURN).max(0.0) / own.deviation.max(0.02);
    (0.5 * q * q).min(TURNED)
}

/// Cost of a normal that is not perpendicular to the direction of an extrusion.
fn tilt_cost(cloud: &Cloud<'_>, i: usize, axis: &nalgebra::Vector3<f64>) -> f64 {
    let own = &cloud.jets.normals[i];
    if !own.deviation.is_finite() {
        return 0.0;
    }
    let q = (own.normal.dot(axis).abs().min(1.0).asin() - FREE_TURN).max(0.0) / own.deviation.max(0.02);
    (0.5 * q * q).min(FAR)
}

/// Distance from a smooth region: from the local quadrics of the nearest of its points.
fn smooth_cost(cloud: &Cloud<'_>, label: u32, labels: &[u32], i: usize) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    let mut turn = f64::INFINITY;
    for &j in cloud.graph.near(i) {
        let j = j as usize;
        if labels[j] != label {
            continue;
        }
        let Some(jet) = &cloud.jets.jets[j] else { continue };
        let (d, n, away) = jet.at(&cloud.points[i]);
        if away > 1.5 || jet.residual > 2.0 * cloud.sigma {
            continue;
        }
        sum += d * d;
        turn = turn.min(turn_cost(cloud, i, &n));
        count += 1;
        if count == 3 {
            break;
        }
    }
    if count == 0 {
        return FAR;
    }
    let q = sum / f64::from(count) / (1.5 * cloud.sigma * cloud.sigma);
    (0.5 * q).min(FAR) + turn
}

/// Iterated conditional modes over the graph of neighbours.
pub(crate) fn assign(cloud: &Cloud<'_>, regions: &[Region], labels: &mut [u32]) {
    for _ in 0..SWEEPS {
        let mut changed = 0;
        for i in 0..labels.len() {
            let mut candidates = [NONE; 10];
            let mut count = 1;
            let own = labels[i];
            for label in std::iter::once(own).chain(cloud.graph.near(i).iter().map(|&j| labels[j as usize])) {
                if label != NONE && count < candidates.len() && !candidates[..count].contains(&label) {
                    candidates[count] = label;
                    count += 1;
                }
            }
            if count == 1 {
                continue;
            }
            let links = cloud.graph.links(i);
            let mut best = (f64::INFINITY, NONE);
            for &label in &candidates[..count] {
                let data = if label == NONE {
                    UNEXPLAINED
                } else {
                    cost(cloud, &regions[label as usize], label, labels, i)
                };
                let others = links.iter().filter(|&&j| labels[j as usize] != label).count();
                let total = data + BORDER * others as f64;
                if total < best.0 || total == best.0 && label == own {
                    best = (total, label);
                }
            }
            if best.1 != own {
                labels[i] = best.1;
                changed += 1;
            }
        }
        if changed * 2000 < labels.len() {
            break;
        }
    }
    // An isolated change may leave the last few sweeps unfinished: the labels are valid at any time.
}

/// Collects the points of the regions from the labels, drops those that lost too many, and fits the carriers again.
pub(crate) fn refit(cloud: &Cloud<'_>, regions: &mut Vec<Region>, labels: &mut [u32], fewest: usize) {
    for region in regions.iter_mut() {
        region.points.clear();
    }
    for (i, &label) in labels.iter().enumerate() {
        if label != NONE {
            regions[label as usize].points.push(as_index(i));
        }
    }
    compact(regions, labels, fewest);
    let mut inside = vec![false; labels.len()];
    for region in regions {
        let core = cloud.core(&region.points, &mut inside);
        if let Some(carrier) = region.carrier {
            let sample = carried(cloud, &carrier, &core);
            if let Some(fit) = refine(&carrier, &sample, 10) {
                region.carrier = Some(fit.carrier);
                region.rms = fit.rms;
            }
        }
    }
}

/// Fits the carriers of finished regions to all that tells their parameters. Cones stay: others have told their axes.
pub(crate) fn settle(cloud: &Cloud<'_>, regions: &mut [Region]) {
    let mut inside = vec![false; cloud.points.len()];
    for region in regions {
        let Some(carrier) = region.carrier.filter(|c| !matches!(c, Carrier::Cone { .. })) else { continue };
        let sample = carried(cloud, &carrier, &cloud.telling(&region.points, &mut inside));
        if let Some(fit) = refine(&carrier, &sample, 10) {
            (region.carrier, region.rms) = (Some(fit.carrier), fit.rms);
        }
    }
}

/// The points that a carrier explains, or all if that leaves less than half of them.
///
/// A point that its neighbours draw to a region but that lies elsewhere would take the carrier of few points away from all others.
fn carried(cloud: &Cloud<'_>, carrier: &Carrier, points: &[u32]) -> Vec<Point3<f64>> {
    let all = cloud.positions(points);
    let near: Vec<_> = all.iter().copied().filter(|x| carrier.at(x).0.abs() < 3.0 * cloud.sigma).collect();
    if 2 * near.len() >= all.len() { near } else { all }
}

/// Drops regions of fewer points and numbers the rest anew.
pub(crate) fn compact(regions: &mut Vec<Region>, labels: &mut [u32], fewest: usize) {
    let mut place = Vec::with_capacity(regions.len());
    let mut next = 0;
    for region in regions.iter() {
        if region.points.len() >= fewest {
            place.push(next);
            next += 1;
        } else {
            place.push(NONE);
        }
    }
    regions.retain(|region| region.points.len() >= fewest);
    for label in labels {
        if *label != NONE {
            *label = place[*label as usize];
        }
    }
}

/// Splits labels into connected pieces: the largest keeps the label, others become regions of their own where they are large, else
/// unlabelled.
pub(crate) fn split(cloud: &Cloud<'_>, regions: &mut Vec<Region>, labels: &mut [u32], fewest: usize) {
    let n = labels.len();
    let mut piece = vec![NONE; n];
    let mut pieces: Vec<(u32, Vec<u32>)> = Vec::new();
    for start in 0..n {
        if labels[start] == NONE || piece[start] != NONE {
            continue;
        }
        let id = as_index(pieces.len());
        let mut members = vec![as_index(start)];
        piece[start] = id;
        let mut k = 0;
        while k < members.len() {
            let i = members[k] as usize;
            k += 1;
            let small = regions[labels[start] as usize].points.len() < SMALL;
            let wide = if small { cloud.graph.near(i) } else { &[] };
            for &j in cloud.graph.around(i).iter().chain(wide) {
                let j = j as usize;
                if piece[j] == NONE && labels[j] == labels[start] {
                    piece[j] = id;
                    members.push(as_index(j));
                }
            }
        }
        pieces.push((labels[start], members));
    }
    let mut largest: Vec<Option<usize>> = vec![None; regions.len()];
    for (k, (label, members)) in pieces.iter().enumerate() {
        let best = &mut largest[*label as usize];
        if best.is_none_or(|b: usize| pieces[b].1.len() < members.len()) {
            *best = Some(k);
        }
    }
    for (k, (label, members)) in pieces.iter().enumerate() {
        if largest[*label as usize] == Some(k) {
            continue;
        }
        let new = if members.len() >= fewest {
            let id = as_index(regions.len());
            let old: &Region = &regions[*label as usize];
            let copy =
                Region { points: members.clone(), carrier: old.carrier, sweep: old.sweep, rms: old.rms };
            regions.push(copy);
            id
        } else {
            NONE
        };
        for &i in members {
            labels[i as usize] = new;
        }
    }
}

/// Whether a carrier explains at least 4 of 5 points.
pub(crate) fn covers(cloud: &Cloud<'_>, carrier: &Carrier, points: &[u32]) -> bool {
    let on = points.iter().filter(|&&i| cloud.explains(carrier, i as usize)).count();
    5 * on >= 4 * points.len()
}
