//! One helical motion for several regions: the flanks and crests of a thread share axis and pitch.
//!
//! A flank alone is told from a torus only without noise: over a small turn both fit. All of them together are: one motion with five
//! unknowns in place of a torus with seven each ([P05, sec. 6]).

use crate::carrier::Carrier;
use crate::decide::limit;
use crate::grow::{Cloud, Region};
use crate::jets::PointNormal;
use crate::least_squares::mean;
use crate::sweep::{Sweep, helix_near, refine};
use crate::velocity::Fields;
use nalgebra::Point3;

/// Fewest regions that share a motion.
const FEWEST: usize = 3;
/// Fewest points of a region that takes part.
const POINTS: usize = 60;
/// Points of a region that take part in the search for the motion, and in the test.
const SAMPLE: usize = 300;
const TESTED: usize = 600;
/// Points of a piece of the profile of all regions, and of one.
const PIECE: usize = 16;
const OWN_PIECE: usize = 40;
/// Rounds in which regions that the motion does not carry are left out.
const ROUNDS: usize = 4;

/// A region that may be carried by the common motion.
struct Candidate {
    region: usize,
    points: Vec<Point3<f64>>,
    normals: Vec<PointNormal>,
}

/// Finds a helical motion that carries at least three of the regions taken for tori, or for no primitive, within the noise, and makes them
/// helical surfaces with this motion.
pub(crate) fn share_helix(cloud: &Cloud<'_>, regions: &mut [Region]) {
    let mut inside = vec![false; cloud.points.len()];
    let may_be = |region: &Region| matches!(region.carrier, None | Some(Carrier::Torus { .. }));
    let mut candidates: Vec<Candidate> = Vec::new();
    for (k, region) in regions.iter().enumerate().filter(|(_, r)| may_be(r)) {
        let core = cloud.core(&region.points, &mut inside);
        if core.len() >= POINTS {
            let some: Vec<u32> = core.iter().copied().step_by(core.len().div_ceil(TESTED).max(1)).collect();
            candidates.push(Candidate {
                region: k,
                points: cloud.positions(&some),
                normals: cloud.normals(&some),
            });
        }
    }
    let Some(sweep) = common_motion(cloud, &candidates) else { return };
    let carried: Vec<(usize, f64)> = candidates
        .iter()
        .filter_map(|candidate| deviation(cloud, &sweep, candidate).map(|rms| (candidate.region, rms)))
        .collect();
    if carried.len() >= FEWEST {
        for (k, rms) in carried {
            (regions[k].carrier, regions[k].sweep, regions[k].rms) = (None, Some(sweep), rms);
        }
    }
}

/// The standard deviation of a region's distances from its profile under a motion, if it agrees with the noise.
fn deviation(cloud: &Cloud<'_>, sweep: &Sweep, candidate: &Candidate) -> Option<f64> {
    let rms = sweep.deviation(&candidate.points, OWN_PIECE)?;
    (rms < 1.05 * limit(cloud.sigma, candidate.points.len())).then_some(rms)
}

/// The helical motion of most candidates: that of all, without those again and again that it carries least.
fn common_motion(cloud: &Cloud<'_>, candidates: &[Candidate]) -> Option<Sweep> {
    let mut chosen: Vec<&Candidate> = candidates.iter().collect();
    for _ in 0..ROUNDS {
        if chosen.len() < FEWEST {
            return None;
        }
        let (mut points, mut normals) = (Vec::new(), Vec::new());
        for candidate in &chosen {
            let step = candidate.points.len().div_ceil(SAMPLE).max(1);
            points.extend(candidate.points.iter().step_by(step));
            normals.extend(candidate.normals.iter().step_by(step));
        }
        let fields = Fields::new(&points, &normals)?;
        let centre = mean(&points);
        let extent = points.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
        let start = helix_near(&fields, &centre, extent)?;
        let step = points.len().div_ceil(SAMPLE * FEWEST).max(1);
        let some: Vec<Point3<f64>> = points.iter().copied().step_by(step).collect();
        let (sweep, _) = refine(&start, &some, cloud.sigma, extent, PIECE)?;
        let carried: Vec<&Candidate> =
            chosen.iter().copied().filter(|c| deviation(cloud, &sweep, c).is_some()).collect();
        if carried.len() == chosen.len() || 2 * carried.len() > chosen.len() && carried.len() >= FEWEST {
            return Some(sweep);
        }
        // The better half of them tells more.
        let mut order: Vec<(f64, &Candidate)> = chosen
            .iter()
            .map(|c| (sweep.deviation(&c.points, OWN_PIECE).unwrap_or(f64::INFINITY), *c))
            .collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.region.cmp(&b.1.region)));
        order.truncate((2 * chosen.len()).div_ceil(3).min(chosen.len() - 1));
        chosen = order.into_iter().map(|(_, candidate)| candidate).collect();
    }
    None
}
