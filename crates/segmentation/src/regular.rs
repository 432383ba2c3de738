//! Cones that their own points do not tell from cylinders and spheres, but the part does.
//!
//! A face of small draft and a narrow chamfer agree, within the noise, with a cylinder whose axis has a direction of its own, and with a
//! sphere. A cone about a direction that the part shows elsewhere needs fewer numbers to be told: it is the simpler explanation.

use nalgebra::{Point3, Vector3};

use crate::carrier::{Carrier, UNKNOWNS, cylindrical};
use crate::decide::{limit, line_about};
use crate::graph::as_index;
use crate::grow::{Cloud, Region};
use crate::least_squares::{Fit, covariance, deviation, refine, refine_some};
use crate::trend::is_systematic;

/// Fewest points of a plane or of a cylinder whose direction counts, and their share of those of the region that is looked at.
const FIRM: usize = 100;
const SHARE: f64 = 0.5;
/// Sine of the largest angle between the axis of a cylinder and that of the cone in its place.
const TURNED: f64 = 0.26;
/// An axis is parallel to a direction within this many standard deviations, or within this angle in radians.
const DEVIATIONS: f64 = 3.0;
const PARALLEL: f64 = 0.004;
/// Angles in radians of cones that are neither nearly a cylinder nor nearly a plane.
const STEEP: std::ops::Range<f64> = 0.1..1.45;
/// Share of the points of a sphere that the cone in its place carries.
const KEPT: f64 = 0.8;
/// Angle in radians between the axis of a ring and that of the surface beside it.
const COAXIAL: f64 = 0.1;
/// Difference of χ² over the logarithm of the number of points that decides nothing, with rows of the faces beside a ring among its points:
/// rings around an axis are chamfers then.
const UNDECIDED: f64 = 3.0;
/// Fewest points.
const FEWEST: usize = 24;
/// Steps of a refinement.
const STEPS: usize = 30;
/// Most points that take part.
const SAMPLE: usize = 1500;

/// A direction that planes and cylinders of the part have, and how many points tell it.
type Direction = (Vector3<f64>, usize);

/// Makes cones of cylinders that are parallel to nothing, and of spheres around an axis, where a cone with a known axis agrees with the
/// points.
pub(crate) fn find_cones(cloud: &Cloud<'_>, regions: &mut [Region], labels: &[u32]) {
    let directions = known_directions(regions);
    let mut inside = vec![false; labels.len()];
    let mut changes: Vec<(usize, Fit)> = Vec::new();
    for (k, region) in regions.iter().enumerate() {
        let fit = match region.carrier {
            Some(Carrier::Cylinder { axis, .. }) => {
                let points = sample(cloud, &cloud.core(&region.points, &mut inside));
                let around = neighbours(cloud, labels, region, k);
                drafted(cloud, regions, &around, &directions, region, &axis, &points)
            }
            Some(Carrier::Sphere { .. }) => {
                let points = sample(cloud, &cloud.core(&region.points, &mut inside));
                let around = neighbours(cloud, labels, region, k);
                chamfer(cloud, regions, &around, region, &points)
            }
            _ => None,
        };
        changes.extend(fit.map(|fit| (k, fit)));
    }
    for (k, Fit { carrier, rms }) in changes {
        (regions[k].carrier, regions[k].rms) = (Some(carrier), rms);
    }
}

fn sample(cloud: &Cloud<'_>, points: &[u32]) -> Vec<Point3<f64>> {
    let step = points.len().div_ceil(SAMPLE).max(1);
    points.iter().step_by(step).map(|&i| cloud.points[i as usize]).collect()
}

/// Labels of the regions next to one, ascending.
fn neighbours(cloud: &Cloud<'_>, labels: &[u32], region: &Region, own: usize) -> Vec<usize> {
    let mut found: Vec<u32> = (region.points.iter())
        .flat_map(|&i| cloud.graph.around(i as usize).iter().map(|&j| labels[j as usize]))
        .filter(|&label| label != crate::grow::NONE && label != as_index(own))
        .collect();
    found.sort_unstable();
    found.dedup();
    found.into_iter().map(|label| label as usize).collect()
}

/// Normals of planes, and axes of cylinders that are parallel to such a normal or to each other.
fn known_directions(regions: &[Region]) -> Vec<Direction> {
    let firm = |r: &&Region| r.points.len() >= FIRM;
    let mut found: Vec<Direction> = Vec::new();
    for region in regions.iter().filter(firm) {
        if let Some(Carrier::Plane { normal, .. }) = region.carrier {
            match found.iter_mut().find(|(d, _)| d.cross(&normal).norm() < PARALLEL) {
                Some((_, count)) => *count += region.points.len(),
                None => found.push((normal, region.points.len())),
            }
        }
    }
    found.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    found
}

/// A cone in place of a cylinder whose axis is parallel to no direction of the part, not even to that in which two planes beside it meet.
fn drafted(
    cloud: &Cloud<'_>,
    regions: &[Region],
    around: &[usize],
    directions: &[Direction],
    region: &Region,
    axis: &Vector3<f64>,
    points: &[Point3<f64>],
) -> Option<Fit> {
    let carrier = region.carrier?;
    let n = points.len();
    if n < FEWEST {
        return None;
    }
    // The uncertainty of the axis, its larger principal deviation.
    let matrix = covariance(&carrier, points, cloud.sigma)?;
    let tilt = (matrix[(2, 2)] + matrix[(3, 3)]).sqrt();
    let is_parallel = |d: &Vector3<f64>| d.cross(axis).norm() < (DEVIATIONS * tilt).max(PARALLEL);
    let planes: Vec<Vector3<f64>> = (around.iter())
        .filter_map(|&k| match regions[k].carrier {
            Some(Carrier::Plane { normal, .. }) => Some(normal),
            _ => None,
        })
        .collect();
    let meet = planes.iter().enumerate().any(|(k, a)| {
        planes[..k].iter().any(|b| {
            let cross = a.cross(b);
            cross.norm() > 0.05 && is_parallel(&cross.normalize())
        })
    });
    let other_axes = regions.iter().any(|r| match r.carrier {
        Some(Carrier::Cylinder { axis: other, .. }) => {
            r.points.len() > 2 * region.points.len() && is_parallel(&other)
        }
        _ => false,
    });
    if meet || other_axes || directions.iter().any(|(d, _)| is_parallel(d)) {
        return None;
    }
    let before = deviation(&carrier, points);
    let near = |d: &Vector3<f64>| d.cross(axis).norm() < TURNED;
    directions
        .iter()
        .filter(|(d, count)| near(d) && *count as f64 >= SHARE * region.points.len() as f64)
        .filter_map(|(d, _)| {
            let d = if d.dot(axis) < 0.0 { -d } else { *d };
            let Carrier::Cylinder { point, radius, .. } = carrier else { return None };
            let start = Carrier::Cone { point, axis: d, radius, angle: 0.0 };
            // Shifts, radius and angle; the direction stays.
            let fit = refine_some(&start, points, STEPS, &free(&[0, 1, 4, 5]))?;
            (fit.rms < limit(cloud.sigma, n)
                && gain(before, &fit, n, cloud.sigma) > -(n as f64).ln()
                && !is_systematic(&fit.carrier, points, cloud.sigma))
            .then_some(fit)
        })
        .min_by(|a, b| a.rms.total_cmp(&b.rms))
}

/// A cone in place of a sphere between a plane and what is turned about its normal, or between two surfaces of one axis.
fn chamfer(
    cloud: &Cloud<'_>,
    regions: &[Region],
    around: &[usize],
    region: &Region,
    points: &[Point3<f64>],
) -> Option<Fit> {
    let carrier = region.carrier?;
    let Carrier::Sphere { centre, .. } = carrier else { return None };
    if points.len() < FEWEST {
        return None;
    }
    let own = covariance(&carrier, points, cloud.sigma)?;
    let off = (own[(0, 0)] + own[(1, 1)] + own[(2, 2)]).sqrt();
    let lines: Vec<(Point3<f64>, Vector3<f64>)> = (around.iter())
        .filter(|&&k| regions[k].points.len() >= FIRM.min(region.points.len()))
        .filter_map(|&k| match regions[k].carrier {
            Some(Carrier::Cylinder { point, axis, .. } | Carrier::Cone { point, axis, .. }) => {
                Some((point, axis))
            }
            _ => None,
        })
        .collect();
    lines
        .into_iter()
        .filter(|(point, axis)| {
            // A ring about the axis that a sphere could carry: the axis passes its centre.
            let (_, away, _) = cylindrical(&centre, point, axis);
            away < (DEVIATIONS * off).max(DEVIATIONS * cloud.sigma)
        })
        .filter_map(|(point, axis)| {
            // The axis of a short face beside it is known less well than by the ring itself: it is the start.
            let mut fit = refine(&line_about(points, &point, &axis)?, points, STEPS)?;
            // A sphere takes rows of the faces beside the ring along, which the cone leaves.
            let on = |c: &Carrier| -> Vec<Point3<f64>> {
                points.iter().copied().filter(|x| c.at(x).0.abs() < 3.0 * cloud.sigma).collect()
            };
            let mut kept = points.to_vec();
            for _ in 0..2 {
                kept = on(&fit.carrier);
                fit = refine(&fit.carrier, &kept, STEPS)?;
            }
            let Carrier::Cone { angle, axis: turned, .. } = fit.carrier else { return None };
            let n = kept.len();
            let sphere = refine(&carrier, &kept, STEPS)?;
            let square = |fit: &Fit| kept.iter().map(|x| fit.carrier.at(x).0.powi(2)).sum::<f64>();
            (STEEP.contains(&angle.abs())
                && turned.cross(&axis).norm() < COAXIAL
                && n as f64 > KEPT * points.len() as f64
                && fit.rms < limit(cloud.sigma, n)
                && square(&fit) - square(&sphere) < UNDECIDED * (n as f64).ln() * cloud.sigma.powi(2)
                && !is_systematic(&fit.carrier, &kept, cloud.sigma))
            .then_some(fit)
        })
        .min_by(|a, b| a.rms.total_cmp(&b.rms))
}

/// How much less the sum of squares is in units of the noise.
fn gain(before: f64, fit: &Fit, n: usize, sigma: f64) -> f64 {
    (before.powi(2) - fit.rms.powi(2)) * n as f64 / (sigma * sigma)
}

fn free(which: &[usize]) -> [bool; UNKNOWNS] {
    let mut free = [false; UNKNOWNS];
    for &k in which {
        free[k] = true;
    }
    free
}
