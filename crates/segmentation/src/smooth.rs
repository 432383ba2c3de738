//! Pieces of one smooth surface become one region: swept by a motion, or free-form.
//!
//! On a surface that is no primitive, primitives fit piece by piece. The borders between such pieces show neither an edge nor a jump of
//! curvature, while carriers of a part that meet tangentially differ in curvature: by as much as the smaller one turns.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};

use crate::assign::compact;
use crate::carrier::Carrier;
use crate::graph::as_index;
use crate::grow::{Cloud, NONE, Region};
use crate::jets::{CLEAN, FEW, Jet};
use crate::least_squares::refine;
use crate::merge::adjacency;
use crate::sweep::{SAMPLES, Sweep, decide_sweep, is_no_revolution};
use crate::trend::has_trend;

/// Angle in radians between the normals of two carriers at a border beyond which it is an edge.
pub(crate) const EDGE: f64 = 0.06;
/// Angle in radians by which the curvatures may differ over the width of the smaller piece.
pub(crate) const BEND: f64 = 0.35;
/// Share of the noise (of its lower limit in data without any) below which distances leave no doubt about a carrier.
pub(crate) const EXACT: f64 = 0.06;
/// Fewest links of a smooth border.
pub(crate) const LINKS: usize = 6;
/// Fewest points of a smooth region.
const FEWEST: usize = 30;

/// Connected unlabelled points with clean neighbourhoods become smooth regions.
pub(crate) fn gather(cloud: &Cloud<'_>, regions: &mut Vec<Region>, labels: &mut [u32]) -> usize {
    let is_clean = |i: usize| cloud.jets.normals[i].deviation.is_finite();
    let agrees = |i: usize, j: usize| {
        cloud.jets.jets[i].as_ref().is_some_and(|jet| {
            let (d, n, away) = jet.at(&cloud.points[j]);
            away < 1.5 && d.abs() < 4.0 * cloud.sigma && n.dot(&cloud.jets.normals[j].normal).abs() > 0.94
        })
    };
    gather_where(cloud, regions, labels, is_clean, agrees)
}

/// Connected unlabelled points whose neighbourhoods are no quadrics, but smooth on the scale of their spacing, become smooth regions:
/// strips of exact data that bend on this scale.
pub(crate) fn gather_bent(cloud: &Cloud<'_>, regions: &mut Vec<Region>, labels: &mut [u32]) -> usize {
    let jet =
        |i: usize| cloud.jets.jets[i].as_ref().filter(|jet| jet.residual < ROUGH * cloud.graph.spacing[i]);
    let is_even = |i: usize| jet(i).is_some();
    let agrees = |i: usize, j: usize| {
        let (Some(one), Some(other)) = (jet(i), jet(j)) else { return false };
        let (d, n, away) = one.at(&cloud.points[j]);
        away < 1.0 && d.abs() < 3.0 * ROUGH * cloud.graph.spacing[i] && n.dot(&other.normal()).abs() > 0.9
    };
    gather_where(cloud, regions, labels, is_even, agrees)
}

/// Residual of a quadric, as a share of the spacing, beyond which a neighbourhood is not smooth: at an edge of 90 degrees it is 0.3.
const ROUGH: f64 = 0.08;

fn gather_where(
    cloud: &Cloud<'_>,
    regions: &mut Vec<Region>,
    labels: &mut [u32],
    may_belong: impl Fn(usize) -> bool,
    agrees: impl Fn(usize, usize) -> bool,
) -> usize {
    let before = regions.len();
    let is_free = |labels: &[u32], i: usize| labels[i] == NONE && may_belong(i);
    let mut seen = vec![false; labels.len()];
    for start in 0..labels.len() {
        if seen[start] || !is_free(labels, start) {
            continue;
        }
        seen[start] = true;
        let mut members = vec![as_index(start)];
        let mut k = 0;
        while k < members.len() {
            let i = members[k] as usize;
            k += 1;
            for &j in cloud.graph.around(i) {
                let j = j as usize;
                if !seen[j] && is_free(labels, j) && agrees(i, j) {
                    seen[j] = true;
                    members.push(as_index(j));
                }
            }
        }
        if members.len() >= FEWEST {
            members.sort_unstable();
            let label = as_index(regions.len());
            for &i in &members {
                labels[i as usize] = label;
            }
            regions.push(Region { points: members, carrier: None, sweep: None, rms: cloud.sigma });
        }
    }
    regions.len() - before
}

/// Normal of a region's surface at a place next to one of its points.
fn normal_at(cloud: &Cloud<'_>, region: &Region, own: usize, x: &Point3<f64>) -> Option<Vector3<f64>> {
    match &region.carrier {
        Some(carrier) => Some(carrier.at(x).1),
        // Quadrics that reach over an edge make it smooth.
        None => {
            let clean = |jet: &&Jet| jet.residual < CLEAN * cloud.sigma;
            cloud.jets.jets[own].as_ref().filter(clean).map(|jet| jet.at(x).1)
        }
    }
}

/// Points next to each other on both sides of the borders of regions, by their labels.
pub(crate) fn border_links(
    cloud: &Cloud<'_>,
    labels: &[u32],
    pairs: &BTreeMap<(u32, u32), usize>,
) -> BTreeMap<(u32, u32), Vec<(u32, u32)>> {
    let mut borders: BTreeMap<(u32, u32), Vec<(u32, u32)>> = BTreeMap::new();
    for i in 0..labels.len() {
        for &j in cloud.graph.around(i) {
            let (a, b) = (labels[i], labels[j as usize]);
            if a < b && a != NONE && b != NONE && pairs.get(&(a, b)).is_some_and(|&c| c >= LINKS) {
                borders.entry((a, b)).or_default().push((as_index(i), j));
            }
        }
    }
    borders
}

/// Joins clusters of pieces with smooth borders; returns the number of clusters.
pub(crate) fn join(cloud: &Cloud<'_>, regions: &mut Vec<Region>, labels: &mut [u32]) -> usize {
    let pairs = adjacency(cloud, labels);
    let mut parent: Vec<usize> = (0..regions.len()).collect();
    fn root(parent: &mut [usize], mut k: usize) -> usize {
        while parent[k] != k {
            parent[k] = parent[parent[k]];
            k = parent[k];
        }
        k
    }
    for ((a, b), links) in &border_links(cloud, labels, &pairs) {
        let (one, other) = (&regions[*a as usize], &regions[*b as usize]);
        // Planes are no pieces of curved surfaces, and few points make no border.
        let is_plane = |r: &Region| matches!(r.carrier, Some(Carrier::Plane { .. }));
        // Pieces grow until the noise is exceeded: a carrier whose distances stay far below it is no piece, and an extrusion has its own.
        let is_exact = |r: &Region| {
            r.carrier.is_some() && r.rms < EXACT * cloud.sigma
                || r.carrier.is_none() && matches!(r.sweep, Some(Sweep::Extrusion { .. }))
        };
        let is_few = one.points.len().min(other.points.len()) < FEWEST;
        if is_plane(one) || is_plane(other) || is_exact(one) || is_exact(other) || is_few {
            continue;
        }
        if is_smooth(cloud, labels, one, other, links) {
            let (x, y) = (root(&mut parent, *a as usize), root(&mut parent, *b as usize));
            parent[x.max(y)] = x.min(y);
        }
    }
    let mut clusters: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for k in 0..regions.len() {
        let r = root(&mut parent, k);
        clusters.entry(r).or_default().push(k);
    }
    let mut joined = 0;
    for (first, members) in clusters {
        if members.len() < 2 || is_mostly_one(regions, &members) {
            continue;
        }
        let mut points: Vec<u32> = members.iter().flat_map(|&k| regions[k].points.iter().copied()).collect();
        points.sort_unstable();
        for &i in &points {
            labels[i as usize] = as_index(first);
        }
        for &k in &members {
            regions[k].points.clear();
        }
        regions[first] = Region { points, carrier: None, sweep: None, rms: cloud.sigma };
        joined += 1;
    }
    compact(regions, labels, 1);
    joined
}

/// Whether one primitive holds so many points of a cluster that it is no piece of another surface: a simple one more than half of them,
/// a torus, which bends both ways as pieces do, nearly all.
fn is_mostly_one(regions: &[Region], members: &[usize]) -> bool {
    let all: usize = members.iter().map(|&k| regions[k].points.len()).sum();
    members.iter().any(|&k| {
        let points = regions[k].points.len();
        match regions[k].carrier {
            Some(Carrier::Torus { .. }) => 20 * points > 17 * all,
            Some(_) => 2 * points > all,
            None => false,
        }
    })
}

/// The quadric of the nearest point whose neighbourhood lies within its region: one that reaches over a border hides a jump of curvature.
fn inner_jet<'a>(cloud: &'a Cloud<'_>, labels: &[u32], own: usize) -> Option<&'a Jet> {
    let label = labels[own];
    let is_inner = |k: &usize| {
        labels[*k] == label && cloud.graph.near(*k).iter().take(FEW - 1).all(|&j| labels[j as usize] == label)
    };
    let near = cloud.graph.near(own).iter().map(|&k| k as usize);
    std::iter::once(own).chain(near).find(is_inner).and_then(|k| cloud.jets.jets[k].as_ref())
}

/// Cosine of the angle between a link and the surface up to which it is one of a border; others lead through a wall.
const ALONG: f64 = 0.7;

/// The largest difference, without sign, that a difference of normal curvatures has in any direction, from three of them. That of two
/// carriers has no noise, and changes its sign around a ring, as between a pipe and its bend.
fn largest(differ: impl Fn(&Vector3<f64>) -> Option<f64>, t: &Vector3<f64>, n: &Vector3<f64>) -> Option<f64> {
    let s = n.cross(t);
    let (a, b, c) = (differ(t)?, differ(&s)?, differ(&((t + s) / std::f64::consts::SQRT_2))?);
    let mean = 0.5 * (a + b);
    Some(mean.abs() + (0.5 * (a - b)).hypot(c - mean))
}

/// Whether two pieces meet without an edge and without a jump of curvature.
pub(crate) fn is_smooth(
    cloud: &Cloud<'_>,
    labels: &[u32],
    one: &Region,
    other: &Region,
    links: &[(u32, u32)],
) -> bool {
    let mut turns = Vec::new();
    let mut bends = Vec::new();
    for &(i, j) in links {
        let (x, y) = (cloud.points[i as usize], cloud.points[j as usize]);
        let middle = nalgebra::center(&x, &y);
        let (Some(n), Some(m)) =
            (normal_at(cloud, one, i as usize, &middle), normal_at(cloud, other, j as usize, &middle))
        else {
            continue;
        };
        let along = (y - x) - n * (y - x).dot(&n);
        let length = along.norm();
        if length < ALONG * (y - x).norm() || length <= 0.0 {
            continue;
        }
        turns.push(n.cross(&m).norm());
        let t = along / length;
        let step = 0.5 * cloud.graph.spacing[i as usize].max(length * 0.5);
        let bend = |region: &Region, own: u32, n: &Vector3<f64>, t: &Vector3<f64>| {
            if region.carrier.is_none()
                && let Some(jet) = inner_jet(cloud, labels, own as usize)
            {
                return Some(jet.bend(t, n));
            }
            let next = normal_at(cloud, region, own as usize, &(middle + t * step))?;
            let next = if next.dot(n) < 0.0 { -next } else { next };
            Some((next - n).dot(t) / step)
        };
        let turned = if m.dot(&n) < 0.0 { -m } else { m };
        let differ = |t: &Vector3<f64>| Some(bend(one, i, &n, t)? - bend(other, j, &turned, t)?);
        let found = if one.carrier.is_some() && other.carrier.is_some() {
            largest(differ, &t, &n)
        } else {
            differ(&t)
        };
        bends.extend(found);
    }
    if turns.len() < LINKS || bends.len() < LINKS {
        return false;
    }
    let middle = |values: &mut Vec<f64>| {
        let k = values.len() / 2;
        *values.select_nth_unstable_by(k, f64::total_cmp).1
    };
    let edge = middle(&mut turns);
    let jump = middle(&mut bends).abs();
    let (small, on) = if one.points.len() <= other.points.len() { (one, 0) } else { (other, 1) };
    let border: Vec<Point3<f64>> = links
        .iter()
        .step_by(links.len().div_ceil(60))
        .map(|l| cloud.points[if on == 0 { l.0 } else { l.1 } as usize])
        .collect();
    let sample = small.points.iter().step_by(small.points.len().div_ceil(100).max(1));
    let (mut sum, mut count) = (0.0, 0.0);
    for &i in sample {
        let nearest =
            border.iter().map(|b| (b - cloud.points[i as usize]).norm()).fold(f64::INFINITY, f64::min);
        sum += nearest;
        count += 1.0;
    }
    // A piece of few rows may be part of a wider strip.
    let least = 4.0 * cloud.graph.spacing[small.points[small.points.len() / 2] as usize];
    let width = f64::max(2.0 * sum / f64::max(count, 1.0), least);
    edge < EDGE && jump * width < BEND
}

/// Finds the types of regions without a carrier.
pub(crate) fn find_sweeps(cloud: &Cloud<'_>, regions: &mut [Region]) {
    let mut inside = vec![false; cloud.points.len()];
    for region in regions.iter_mut().filter(|r| r.carrier.is_none()) {
        let core = cloud.core(&region.points, &mut inside);
        let (decision, _) = cloud.decide(&region.points, None, true, &mut inside);
        if let Some(fit) = decision.accepted
            && !is_refuted(cloud, &region.points, &fit.carrier, &mut inside)
        {
            region.carrier = Some(fit.carrier);
            region.rms = fit.rms;
            continue;
        }
        let found = decide_sweep(&cloud.positions(&core), &cloud.normals(&core), cloud.sigma)
            .filter(|(sweep, _)| !is_no_motion(cloud, &region.points, sweep, &mut inside));
        region.sweep = found.map(|f| f.0);
        if let Some((_, rms)) = found {
            region.rms = rms;
        }
    }
}

/// Decides the types of primitives again on what they hold at the end.
pub(crate) fn decide_again(cloud: &Cloud<'_>, regions: &mut [Region]) {
    let mut inside = vec![false; cloud.points.len()];
    for region in regions.iter_mut() {
        let Some(carrier) = region.carrier else { continue };
        let (decision, _) = cloud.decide(&region.points, Some(&carrier), true, &mut inside);
        if let Some(fit) = decision.accepted {
            region.carrier = Some(fit.carrier);
            region.rms = fit.rms;
        }
        if region.carrier.is_some_and(|carrier| is_refuted(cloud, &region.points, &carrier, &mut inside)) {
            region.carrier = None;
        }
    }
}

/// Links between the border of a region and the points that are asked whether a torus carries it: what a neighbour left there is none of
/// it.
const RINGS: usize = 2;
/// Fewest points that tell: ten for each coefficient of the trend.
const TELLING: usize = 200;
/// Share of the variance of the noise that a trend may have far from the border: a bias of a seventh of its standard deviation.
const BIAS: f64 = 0.02;

/// Whether all points of a region together refute its torus.
///
/// A torus has the position, the tangent plane and both curvatures of any smooth surface at a point, so that it explains a large piece of
/// each within the noise of single points. The trend of all distances is asked, then: on a torus it is that of noise.
fn is_refuted(cloud: &Cloud<'_>, region: &[u32], carrier: &Carrier, inside: &mut [bool]) -> bool {
    if !matches!(carrier, Carrier::Torus { .. }) {
        return false;
    }
    let points = cloud.positions(&cloud.inner(region, RINGS, inside));
    if points.len() < TELLING {
        return false;
    }
    refine(carrier, &points, STEPS).is_some_and(|fit| has_trend(&fit.carrier, &points, cloud.sigma, BIAS))
}

/// Steps of a refinement.
const STEPS: usize = 30;

/// The same of a surface of revolution, which a profile gives as much freedom.
fn is_no_motion(cloud: &Cloud<'_>, region: &[u32], sweep: &Sweep, inside: &mut [bool]) -> bool {
    let inner = cloud.inner(region, RINGS, inside);
    let stride = inner.len().div_ceil(SAMPLES[1].0).max(1);
    let some: Vec<u32> = inner.into_iter().step_by(stride).collect();
    some.len() >= TELLING && is_no_revolution(sweep, &cloud.positions(&some), cloud.sigma, BIAS)
}
