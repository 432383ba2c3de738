//! Pieces of a general cylinder become one region, before other pieces are joined.
//!
//! On an extrusion primitives fit piece by piece: cylinders and strips of planes, all parallel to one direction. What is only smooth beside
//! it, as a blend along its end, is not, and must not be joined with it.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use nalgebra::{Matrix3, Vector2, Vector3};

use crate::assign::compact;
use crate::carrier::{Carrier, across};
use crate::graph::as_index;
use crate::grow::{Cloud, NONE, Region};
use crate::merge::adjacency;
use crate::smooth::{BEND, EDGE, EXACT, LINKS, border_links, is_smooth};
use crate::sweep::{Sweep, decide_sweep};

/// Sine of the angle by which pieces of noisy points may be turned out of the common direction.
const PARALLEL: f64 = 0.06;
/// Share of a cluster that one primitive holds and is no piece of another surface then.
const NEARLY_ALL: f64 = 0.85;
/// Angle in radians between normals and the cross section that is allowed on top of 3 standard deviations.
const TILT: f64 = 0.06;
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

/// Whether the distances of a region stay far below the noise or its lower limit: pieces grow until they do not.
fn is_exact(cloud: &Cloud<'_>, region: &Region) -> bool {
    region.carrier.is_some() && region.rms < EXACT * cloud.sigma
}

/// Whether one piece holds so many points of a cluster that it is none of a larger surface: more than half of them with one other piece of
/// size or none, nearly all with more.
fn is_no_piece(regions: &[Region], members: &[usize]) -> bool {
    let counts = || members.iter().map(|&k| regions[k].points.len());
    let (all, most): (usize, usize) = (counts().sum(), counts().max().unwrap_or(0));
    let share = if counts().filter(|&n| n >= FIRST).count() < 3 { 0.5 } else { NEARLY_ALL };
    most as f64 > share * all as f64
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
        if taken[first as usize] || is_exact(cloud, seed) {
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
                    || is_exact(cloud, region)
                {
                    continue;
                }
                let (a, b) = (k.min(other), k.max(other));
                let Some(links) = borders.get(&(a, b)).filter(|links| links.len() >= LINKS) else { continue };
                let (one, two) = (&regions[a as usize], &regions[b as usize]);
                let goes_on = continues(cloud, &axis, one, two, links)
                    .unwrap_or_else(|| is_smooth(cloud, labels, one, two, links));
                if goes_on {
                    seen.insert(other);
                    members.push(other);
                    queue.push_back(other);
                }
            }
        }
        let places: Vec<usize> = members.iter().map(|&k| k as usize).collect();
        if members.len() < 2 || is_no_piece(regions, &places) {
            continue;
        }
        let mut points: Vec<u32> = places.iter().flat_map(|&k| regions[k].points.iter().copied()).collect();
        // Rows of a blend that pieces took along are not parallel to the direction: others may have them.
        let tilted = |i: &u32| {
            let own = &cloud.jets.normals[*i as usize];
            own.deviation.is_finite()
                && own.normal.dot(&axis).abs() > (TILT + 3.0 * own.deviation).min(1.2).sin()
        };
        let dropped: Vec<u32> = points.iter().copied().filter(tilted).collect();
        points.retain(|i| !tilted(i));
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
        for i in dropped {
            labels[i as usize] = NONE;
        }
        regions[first as usize] = Region { points, carrier: None, sweep: Some(sweep), rms };
        joined += 1;
    }
    compact(regions, labels, 1);

    joined
}

/// Shares of the smaller piece that are looked at on both sides of a border, the least that tells enough counts.
const WINDOWS: [f64; 4] = [0.2, 0.3, 0.4, 0.6];
/// Standard deviation of the turn of a piece that tells enough, in radians.
const TOLD: f64 = 0.08;
/// Fewest points of a window.
const WINDOW: usize = 24;

/// Whether the cross section of two pieces goes on over their border without an edge and without a jump of curvature, by parabolas on both
/// sides. `None` where the border does not run along the direction, or where the points do not tell.
fn continues(
    cloud: &Cloud<'_>,
    axis: &Vector3<f64>,
    one: &Region,
    other: &Region,
    links: &[(u32, u32)],
) -> Option<bool> {
    let (e, f) = across(axis);
    let flat = |i: u32| {
        let x = cloud.points[i as usize].coords;
        Vector2::new(x.dot(&e), x.dot(&f))
    };
    let middles: Vec<Vector2<f64>> = links.iter().map(|&(i, j)| (flat(i) + flat(j)) * 0.5).collect();
    let middle = middles.iter().sum::<Vector2<f64>>() / middles.len().max(1) as f64;
    let spread = (middles.iter().map(|m| (m - middle).norm_squared()).sum::<f64>()
        / middles.len().max(1) as f64)
        .sqrt();
    // Towards the second piece, from the points of both next to the border.
    let towards = links.iter().map(|&(i, j)| flat(j) - flat(i)).sum::<Vector2<f64>>().try_normalize(0.0)?;
    let rise = Vector2::new(-towards.y, towards.x);
    let local = |region: &Region, sign: f64| -> Vec<(f64, f64)> {
        let all = region.points.iter().map(|&i| {
            let q = flat(i) - middle;
            (sign * q.dot(&towards), q.dot(&rise))
        });
        all.filter(|(u, v)| *u > 0.0 && v.abs() < 2.0 * u.abs() + spread).collect()
    };
    let sides = [local(one, -1.0), local(other, 1.0)];
    let reach = |side: &[(f64, f64)]| side.iter().map(|q| q.0).fold(0.0, f64::max);
    let width = reach(&sides[0]).min(reach(&sides[1]));
    if 4.0 * spread > width {
        return None;
    }
    for window in WINDOWS {
        let [a, b] = [parabola(&sides[0], window * width), parabola(&sides[1], window * width)];
        let (Some((left, p)), Some((right, q))) = (a, b) else { continue };
        let deviation = |k: usize| cloud.sigma * (p[k] + q[k]).sqrt();
        let turn = (left[2] - right[2]).abs() * 2.0 * width;
        if 2.0 * width * deviation(2) > TOLD {
            continue;
        }
        // On one side the parameter runs the other way.
        let edge = (left[1] + right[1]).abs();
        return Some(edge < EDGE + 3.0 * deviation(1) && turn < BEND);
    }
    None
}

/// The parabola of least squares over the points up to a distance: coefficients and their variances for unit noise.
fn parabola(points: &[(f64, f64)], most: f64) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let (mut matrix, mut right, mut count) = (Matrix3::zeros(), Vector3::zeros(), 0);
    for &(u, v) in points.iter().filter(|q| q.0 < most) {
        let row = Vector3::new(1.0, u / most, (u / most).powi(2));
        matrix += row * row.transpose();
        right += row * v;
        count += 1;
    }
    if count < WINDOW {
        return None;
    }
    let inverse = matrix.cholesky()?.inverse();
    let scale = Vector3::new(1.0, most, most * most);
    let found = (inverse * right).component_div(&scale);
    Some((found, inverse.diagonal().component_div(&scale.component_mul(&scale))))
}
