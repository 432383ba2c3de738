//! Carriers of points that no grown region holds: narrow strips, small holes, corners.
//!
//! Their neighbourhoods reach over edges, so that local quadrics say nothing. Instead few points next to each other propose a carrier,
//! with axes taken from the regions around them, and the number of connected points within the noise decides ([SWK07], with the
//! draws restricted to neighbours).

use nalgebra::{Point3, Vector3};

use crate::carrier::{Carrier, cylindrical};
use crate::decide::{circle, circle_about, limit, sphere_start};
use crate::graph::as_index;
use crate::grow::{Cloud, NONE, Region, Scratch, spread};
use crate::least_squares::refine;
use crate::parallel;
use crate::trend::is_systematic;

/// Points of a neighbourhood of unlabelled points.
const LOCAL: usize = 40;
/// Draws per kind of carrier and axis.
const DRAWS: usize = 16;
/// Most neighbourhoods of a round.
const CENTRES: usize = 500;
/// Most points that a carrier is fitted to before its support is known.
const SAMPLE: usize = 300;
/// Most rounds.
const ROUNDS: usize = 6;

/// A proposed region.
struct Proposal {
    score: usize,
    carrier: Carrier,
    rms: f64,
    support: Vec<u32>,
}

/// Finds carriers of unlabelled points and labels their points; returns the number of new regions.
pub(crate) fn propose(cloud: &Cloud<'_>, regions: &mut Vec<Region>, labels: &mut [u32]) -> usize {
    let before = regions.len();
    for round in 0..ROUNDS {
        let mut free: Vec<u32> = (0..labels.len()).filter(|&i| labels[i] == NONE).map(as_index).collect();
        let stride = free.len().div_ceil(CENTRES).max(1);
        free = free.into_iter().skip(round % stride).step_by(stride).collect();
        let fixed: &[u32] = labels;
        let known: &[Region] = regions;
        let mut proposals: Vec<Proposal> = parallel::flat_chunks(&free, |centres| {
            let mut scratch = Scratch::new(fixed.len());
            centres.iter().filter_map(|&c| best_at(cloud, known, fixed, c, &mut scratch)).collect()
        });
        // The order of the centres breaks ties.
        proposals.sort_by_key(|proposal| std::cmp::Reverse(proposal.score));
        let mut accepted = 0;
        for proposal in proposals {
            let open = proposal.support.iter().filter(|&&i| labels[i as usize] == NONE).count();
            if open < proposal.support.len() {
                continue;
            }
            let label = as_index(regions.len());
            for &i in &proposal.support {
                labels[i as usize] = label;
            }
            regions.push(Region {
                points: proposal.support,
                carrier: Some(proposal.carrier),
                sweep: None,
                rms: proposal.rms,
            });
            accepted += 1;
        }
        if accepted == 0 {
            break;
        }
    }
    regions.len() - before
}

/// Numbers for the draws at a point, by the generator `SplitMix64` ([SLF14]).
struct Draws(u64);

impl Draws {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        #[expect(clippy::cast_possible_truncation, reason = "the remainder is below n")]
        let below = (z % n.max(1) as u64) as usize;
        below
    }
}

/// The unlabelled points around one, in the order in which they are reached.
fn local(cloud: &Cloud<'_>, labels: &[u32], centre: u32) -> Vec<u32> {
    let mut found = vec![centre];
    let mut k = 0;
    while k < found.len() && found.len() < LOCAL {
        for &j in cloud.graph.around(found[k] as usize) {
            if labels[j as usize] == NONE && !found.contains(&j) {
                found.push(j);
            }
        }
        k += 1;
    }
    found.truncate(LOCAL);
    found
}

/// Axes and axis lines that the regions around a point suggest.
fn suggested(
    cloud: &Cloud<'_>,
    regions: &[Region],
    labels: &[u32],
    members: &[u32],
) -> (Vec<Vector3<f64>>, Vec<(Point3<f64>, Vector3<f64>)>) {
    let mut around: Vec<u32> = Vec::new();
    for &i in members.iter().take(20) {
        for &j in cloud.graph.near(i as usize).iter().take(12) {
            let label = labels[j as usize];
            if label != NONE && !around.contains(&label) && around.len() < 8 {
                around.push(label);
            }
        }
    }
    let (mut axes, mut lines): (Vec<Vector3<f64>>, Vec<_>) = (Vec::new(), Vec::new());
    let mut planes = Vec::new();
    let add = |axes: &mut Vec<Vector3<f64>>, axis: Vector3<f64>| {
        if axes.len() < 8 && axes.iter().all(|a| a.cross(&axis).norm() > 0.003) {
            axes.push(axis);
        }
    };
    for label in around {
        match regions[label as usize].carrier {
            Some(Carrier::Plane { normal, .. }) => planes.push(normal),
            Some(Carrier::Cylinder { point, axis, .. } | Carrier::Cone { point, axis, .. }) => {
                add(&mut axes, axis);
                lines.push((point, axis));
            }
            Some(Carrier::Torus { centre, axis, .. }) => {
                add(&mut axes, axis);
                lines.push((centre, axis));
            }
            _ => {}
        }
    }
    for (k, n) in planes.iter().enumerate() {
        for m in &planes[..k] {
            let cross = n.cross(m);
            if cross.norm() > 0.05 {
                add(&mut axes, cross.normalize());
            }
        }
    }
    for n in &planes {
        add(&mut axes, *n);
    }
    lines.truncate(4);
    (axes, lines)
}

/// The proposal with the largest connected support at a point.
fn best_at(
    cloud: &Cloud<'_>,
    regions: &[Region],
    labels: &[u32],
    centre: u32,
    scratch: &mut Scratch,
) -> Option<Proposal> {
    let members = local(cloud, labels, centre);
    let n = members.len();
    if n < FEWEST {
        return None;
    }
    let points = cloud.positions(&members);
    let within = 3.0 * cloud.sigma;
    let extent = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
    // Points that lie within the noise of any surface by chance.
    let chance = (6.0 * cloud.sigma / extent.max(f64::MIN_POSITIVE)).min(0.5) * n as f64;
    let mut draws = Draws(u64::from(centre));
    let mut best: [Option<(usize, Carrier)>; 5] = [None; 5];
    let mut offer = |carrier: Carrier| {
        if carrier.at(&points[0]).0.abs() > within || carrier.size() > 20.0 * extent && carrier.unknowns() > 3
        {
            return;
        }
        let on = points.iter().filter(|p| carrier.at(p).0.abs() < within).count();
        let dof = carrier.unknowns();
        if (on as f64) < dof as f64 + 4.0 + chance {
            return;
        }
        // The best of each kind, told apart by their numbers of unknowns.
        let kept = &mut best[dof - 3];
        if kept.is_none_or(|(most, _)| on > most) {
            *kept = Some((on, carrier));
        }
    };
    let mut wide = false;
    let mut pick = |k: usize| -> Option<Vec<Point3<f64>>> {
        // Every other draw reaches farther: short arcs say little about circles.
        wide = !wide;
        let reach = if wide { n } else { n.min(16) };
        let mut chosen = vec![0];
        for _ in 1..k {
            let i = 1 + draws.below(reach - 1);
            if chosen.contains(&i) {
                return None;
            }
            chosen.push(i);
        }
        Some(chosen.iter().map(|&i| points[i]).collect())
    };
    for _ in 0..3 * DRAWS {
        let Some(p) = pick(3) else { continue };
        let normal = (p[1] - p[0]).cross(&(p[2] - p[0]));
        if normal.norm() > 1e-3 * extent * extent * 1e-2 {
            offer(Carrier::Plane { point: p[0], normal: normal.normalize() });
        }
    }
    let (axes, lines) = suggested(cloud, regions, labels, &members);
    for axis in &axes {
        for _ in 0..DRAWS {
            let Some(p) = pick(3) else { continue };
            if let Some(carrier) = circle_about(&p, axis) {
                offer(carrier);
            }
        }
    }
    for (point, axis) in &lines {
        for _ in 0..DRAWS {
            let Some(p) = pick(3) else { continue };
            let flat: Vec<(f64, f64)> = p
                .iter()
                .map(|p| {
                    let (h, r, _) = cylindrical(p, point, axis);
                    (r, h)
                })
                .collect();
            if let Some((radius, h, minor)) = circle(&flat).filter(|c| c.0 > 0.0) {
                offer(Carrier::Torus { centre: point + axis * h, axis: *axis, radius, minor });
            }
            let [(r0, h0), (r1, h1), ..] = flat[..] else { continue };
            let angle = ((r1 - r0) * (h1 - h0).signum()).atan2((h1 - h0).abs());
            if angle.abs() < 1.5 {
                offer(Carrier::Cone { point: point + axis * h0, axis: *axis, radius: r0, angle });
            }
        }
    }
    for _ in 0..DRAWS {
        let Some(p) = pick(4) else { continue };
        if let Some(carrier) = sphere_start(&p) {
            offer(carrier);
        }
    }
    // Without help from the neighbours: the nearest points alone.
    for k in [16, 24] {
        if n >= k {
            let normals = cloud.normals(&members[..k]);
            if let Some(fit) =
                crate::decide::decide(&points[..k], &normals, cloud.sigma, None, false).accepted
            {
                offer(fit.carrier);
            }
        }
    }
    let mut proposals: Vec<Proposal> = Vec::new();
    let most = best.iter().flatten().map(|b| b.0).max().unwrap_or(0);
    for (on, carrier) in best.into_iter().flatten() {
        if 2 * on < most {
            continue;
        }
        if let Some(p) = settle(cloud, labels, &members, &carrier, scratch) {
            proposals.push(p);
        }
    }
    proposals.into_iter().min_by(|a, b| b.score.cmp(&a.score))
}

/// Refines a carrier on its connected points until they stay.
fn settle(
    cloud: &Cloud<'_>,
    labels: &[u32],
    members: &[u32],
    start: &Carrier,
    scratch: &mut Scratch,
) -> Option<Proposal> {
    let mut carrier = *start;
    let mut support: Vec<u32> = members
        .iter()
        .copied()
        .filter(|&i| carrier.at(&cloud.points[i as usize]).0.abs() < 3.0 * cloud.sigma)
        .collect();
    let mut rms = 0.0;
    for _ in 0..5 {
        if support.len() < FEWEST.max(carrier.unknowns() + 5) {
            return None;
        }
        let step = support.len().div_ceil(SAMPLE).max(1);
        let some: Vec<u32> = support.iter().copied().step_by(step).collect();
        let sample = cloud.positions(&some);
        let fit = refine(&carrier, &sample, 15)?;
        (carrier, rms) = (fit.carrier, fit.rms);
        if rms > limit(cloud.sigma, sample.len()) {
            return None;
        }
        let most = 2 * support.len();
        let free = |i: usize| labels[i] == NONE;
        let next = spread_by_distance(cloud, &support, free, &carrier, most, scratch);
        let settled = next.len() < most && next.len().abs_diff(support.len()) * 20 <= support.len();
        support = next;
        if settled {
            break;
        }
    }
    let sample = cloud.positions(&support);
    if support.len() < FEWEST.max(carrier.unknowns() + 5) || is_systematic(&carrier, &sample, cloud.sigma) {
        return None;
    }
    support.sort_unstable();
    let score = support.len().saturating_sub(2 * carrier.unknowns());
    Some(Proposal { score, carrier, rms, support })
}

/// Connected points within the noise, from the first of some that is one.
fn spread_by_distance(
    cloud: &Cloud<'_>,
    seeds: &[u32],
    free: impl Fn(usize) -> bool,
    carrier: &Carrier,
    most: usize,
    scratch: &mut Scratch,
) -> Vec<u32> {
    let first: Vec<u32> = seeds.iter().copied().take(1).collect();
    spread(cloud, &first, free, carrier, Some(seeds).filter(|s| s.len() < 500), most, scratch)
}

/// Fewest points of a proposal.
const FEWEST: usize = 8;
