//! Regions grown from seeds over the graph of neighbours.

use std::collections::VecDeque;

use nalgebra::Point3;

use crate::carrier::Carrier;
use crate::decide::{Decision, decide};
use crate::graph::{Graph, as_index};
use crate::jets::{CLEAN, Jets, PointNormal};
use crate::least_squares::{Fit, normal_equations};
use crate::sweep::Sweep;

/// Label of points that belong to no region yet.
pub(crate) const NONE: u32 = u32::MAX;

/// A region with its carrier.
#[derive(Clone, Debug)]
pub(crate) struct Region {
    pub(crate) points: Vec<u32>,
    /// `None` for a region that is only smooth.
    pub(crate) carrier: Option<Carrier>,
    /// The motion that sweeps a smooth region, where one does.
    pub(crate) sweep: Option<Sweep>,
    pub(crate) rms: f64,
}

/// What growth works on.
pub(crate) struct Cloud<'a> {
    pub(crate) points: &'a [Point3<f64>],
    pub(crate) graph: &'a Graph,
    pub(crate) jets: &'a Jets,
    pub(crate) sigma: f64,
}

impl Cloud<'_> {
    pub(crate) fn positions(&self, indices: &[u32]) -> Vec<Point3<f64>> {
        indices.iter().map(|&i| self.points[i as usize]).collect()
    }

    pub(crate) fn normals(&self, indices: &[u32]) -> Vec<PointNormal> {
        indices.iter().map(|&i| self.jets.normals[i as usize]).collect()
    }

    /// Whether a point lies on a carrier: its distance and, where it is known, its normal.
    pub(crate) fn explains(&self, carrier: &Carrier, i: usize) -> bool {
        self.explains_within(carrier, i, self.sigma * self.sigma)
    }

    /// The same for a given variance of the distance.
    fn explains_within(&self, carrier: &Carrier, i: usize, variance: f64) -> bool {
        let (d, n) = carrier.at(&self.points[i]);
        if d * d >= 9.0 * variance {
            return false;
        }
        let own = &self.jets.normals[i];
        if !own.deviation.is_finite()
            || own.normal.dot(&n).abs() > (3.0 * own.deviation + NORMAL_BIAS).min(1.2).cos()
        {
            return true;
        }
        // Next to edges normals mislead: the neighbours on the carrier then tell.
        let links = self.graph.links(i);
        let on = |j: &&u32| carrier.at(&self.points[**j as usize]).0.powi(2) < 9.0 * variance;
        8 * links.iter().filter(on).count() >= 5 * links.len()
    }

    /// Decides the type on the points of a region away from its border, or on all if that leaves few.
    pub(crate) fn decide(
        &self,
        region: &[u32],
        start: Option<&Carrier>,
        all_types: bool,
        inside: &mut [bool],
    ) -> (Decision, usize) {
        let used = self.core(region, inside);
        (decide(&self.positions(&used), &self.normals(&used), self.sigma, start, all_types), used.len())
    }

    /// The points of a region away from its border, or all if that leaves few.
    pub(crate) fn core(&self, region: &[u32], inside: &mut [bool]) -> Vec<u32> {
        for &i in region {
            inside[i as usize] = true;
        }
        let core: Vec<u32> = (region.iter().copied())
            .filter(|&i| self.graph.links(i as usize).iter().all(|&j| inside[j as usize]))
            .collect();
        for &i in region {
            inside[i as usize] = false;
        }
        if core.len() >= 24 && 4 * core.len() >= region.len() { core } else { region.to_vec() }
    }
}

impl Cloud<'_> {
    /// The points that tell the parameters of a region at the end: those away from its border where they are at least half of it. Fewer say
    /// less than the rows next to the border may spoil.
    pub(crate) fn telling(&self, region: &[u32], inside: &mut [bool]) -> Vec<u32> {
        let core = self.core(region, inside);
        if 2 * core.len() >= region.len() { core } else { region.to_vec() }
    }

    /// The points of a region that are at least `rings` links away from its border; these may be none.
    pub(crate) fn inner(&self, region: &[u32], rings: usize, inside: &mut [bool]) -> Vec<u32> {
        let mut kept = region.to_vec();
        for _ in 0..rings {
            for &i in &kept {
                inside[i as usize] = true;
            }
            let is_inner = |i: &u32| self.graph.links(*i as usize).iter().all(|&j| inside[j as usize]);
            let next: Vec<u32> = kept.iter().copied().filter(is_inner).collect();
            for &i in &kept {
                inside[i as usize] = false;
            }
            kept = next;
        }
        kept
    }
}

/// Bias of normals in radians that is allowed on top of 3 standard deviations.
const NORMAL_BIAS: f64 = 0.15;

/// Grows regions of primitives from all seeds.
pub(crate) fn primitives(cloud: &Cloud<'_>, labels: &mut [u32]) -> Vec<Region> {
    let n = cloud.points.len();
    let mut seeds: Vec<(f64, u32)> = (0..n)
        .filter_map(|i| {
            let jet = cloud.jets.jets[i].as_ref()?;
            let [k, _] = jet.curvatures();
            let bend = (k.0 * jet.radius()).abs();
            (jet.residual < CLEAN * cloud.sigma).then(|| (bend, as_index(i)))
        })
        .collect();
    seeds.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut tried = vec![false; n];
    let mut scratch = Scratch::new(n);
    let mut regions: Vec<Region> = Vec::new();
    for (_, seed) in seeds {
        if tried[seed as usize] || labels[seed as usize] != NONE {
            continue;
        }
        match grow(cloud, seed, labels, &mut scratch) {
            Growth::Region(region) => {
                let label = as_index(regions.len());
                for &i in &region.points {
                    labels[i as usize] = label;
                }
                regions.push(region);
            }
            Growth::Refused(points) => {
                for i in points {
                    tried[i as usize] = true;
                }
            }
        }
        tried[seed as usize] = true;
    }
    regions
}

/// Memory used again.
pub(crate) struct Scratch {
    inside: Vec<bool>,
    seen: Vec<u32>,
    round: u32,
}

impl Scratch {
    pub(crate) fn new(n: usize) -> Self {
        Self { inside: vec![false; n], seen: vec![0; n], round: 0 }
    }
}

enum Growth {
    Region(Region),
    /// The points of the last accepted support.
    Refused(Vec<u32>),
}

/// Points connected to the seed that a carrier explains, at most `most`.
pub(crate) fn spread(
    cloud: &Cloud<'_>,
    seeds: &[u32],
    free: impl Fn(usize) -> bool,
    carrier: &Carrier,
    fitted: Option<&[u32]>,
    most: usize,
    scratch: &mut Scratch,
) -> Vec<u32> {
    // A carrier of few points is uncertain beyond them.
    let inverse = fitted.and_then(|some| {
        let (_, _, matrix) = normal_equations(carrier, &cloud.positions(some));
        Some(matrix.cholesky()?.inverse())
    });
    let explains = |i: usize| {
        let unit = match &inverse {
            Some(inverse) => {
                let (_, row) = carrier.linear(&cloud.points[i]);
                (1.0 + row.dot(&(inverse * row))).min(9.0)
            }
            None => 1.0,
        };
        cloud.explains_within(carrier, i, unit * cloud.sigma * cloud.sigma)
    };
    scratch.round += 1;
    let round = scratch.round;
    let mut queue: VecDeque<u32> = VecDeque::new();
    let mut found = Vec::new();
    for &s in seeds {
        if scratch.seen[s as usize] != round && free(s as usize) && explains(s as usize) {
            scratch.seen[s as usize] = round;
            queue.push_back(s);
        }
    }
    while let Some(i) = queue.pop_front() {
        found.push(i);
        if found.len() >= most {
            break;
        }
        for &j in cloud.graph.around(i as usize) {
            let j = j as usize;
            if scratch.seen[j] != round && free(j) && explains(j) {
                scratch.seen[j] = round;
                queue.push_back(as_index(j));
            }
        }
    }
    found
}

/// Fewest points of a grown region.
const FEWEST: usize = 12;

fn grow(cloud: &Cloud<'_>, seed: u32, labels: &[u32], scratch: &mut Scratch) -> Growth {
    let free = |i: usize| labels[i] == NONE;
    let mut support: Vec<u32> = std::iter::once(seed)
        .chain(cloud.graph.near(seed as usize).iter().take(15).copied().filter(|&j| free(j as usize)))
        .collect();
    if support.len() < FEWEST {
        return Growth::Refused(Vec::new());
    }
    let first = support.len();
    let mut last: Option<Carrier> = None;
    for round in 0..60 {
        let (decision, _) = cloud.decide(&support, last.as_ref(), false, &mut scratch.inside);
        let Some(Fit { carrier, rms }) = decision.accepted else {
            return Growth::Refused(support);
        };
        let next = spread(
            cloud,
            &support[..1],
            free,
            &carrier,
            Some(&support).filter(|s| s.len() < 500).map(Vec::as_slice),
            2 * support.len(),
            scratch,
        );
        let complete = next.len() < 2 * support.len();
        let settled = complete && next.len().abs_diff(support.len()) * 50 <= support.len();
        if next.len() < first.max(FEWEST) {
            return Growth::Refused(support);
        }
        support = next;
        last = Some(carrier);
        if settled || round > 40 && complete {
            return Growth::Region(Region { points: support, carrier: Some(carrier), sweep: None, rms });
        }
    }
    Growth::Refused(support)
}
