//! Regions told in the coordinates of the input.

use nalgebra::{Point3, Vector3};

use crate::carrier::Carrier;
use crate::grow::{Cloud, NONE, Region};
use crate::least_squares::mean;
use crate::report::{RegionReport, RunnerUp, Segmentation, Shape};
use crate::segment::Frame;
use crate::sweep::Sweep;
use crate::uncertainty::covariance;

/// The report of a finished segmentation, the largest region first.
pub(crate) fn describe(
    cloud: &Cloud<'_>,
    regions: &[Region],
    labels: &[u32],
    frame: &Frame,
    spacing: f64,
) -> Segmentation {
    let mut order: Vec<usize> = (0..regions.len()).collect();
    order.sort_by_key(|&k| (std::cmp::Reverse(regions[k].points.len()), k));
    let mut new = vec![0u32; regions.len()];
    for (label, &k) in (0u32..).zip(&order) {
        new[k] = label;
    }
    let mut inside = vec![false; labels.len()];
    let reports = (0u32..)
        .zip(&order)
        .map(|(label, &k)| {
            let region = &regions[k];
            let core = cloud.core(&region.points, &mut inside);
            let points = cloud.positions(&core);
            let telling = cloud.telling(&region.points, &mut inside);
            let chi2 = (region.rms / cloud.sigma).powi(2);
            let matrix =
                region.carrier.and_then(|c| covariance(cloud, regions, labels, k, &telling).map(|m| (c, m)));
            let covariance = matrix.map_or_else(Vec::new, |(carrier, m)| {
                let unit = |i: usize| if is_angle(&carrier, i) { 1.0 } else { frame.scale };
                let row = |i: usize| (0..m.ncols()).map(|j| m[(i, j)] * unit(i) * unit(j)).collect();
                (0..m.nrows()).map(row).collect()
            });
            let covariance = match &region.sweep {
                Some(sweep) if region.carrier.is_none() => of_sweep(sweep, &points, cloud.sigma, frame.scale),
                _ => covariance,
            };
            let (decision, _) = cloud.decide(&region.points, region.carrier.as_ref(), true, &mut inside);
            let others = decision.refused.iter().chain(&decision.accepted);
            let runner_up = others
                .filter(|fit| region.carrier.is_none_or(|c| c.unknowns() != fit.carrier.unknowns()))
                .min_by(|a, b| a.rms.total_cmp(&b.rms))
                .map(|fit| RunnerUp {
                    name: shape(&fit.carrier, &points, frame).name(),
                    chi2: (fit.rms / cloud.sigma).powi(2),
                });
            RegionReport {
                label,
                shape: match (&region.carrier, &region.sweep) {
                    (Some(carrier), _) => shape(carrier, &points, frame),
                    (None, Some(sweep)) => swept(sweep, &points, frame),
                    (None, None) => Shape::Freeform,
                },
                covariance,
                rms: region.rms * frame.scale,
                support: region.points.len(),
                chi2,
                runner_up,
            }
        })
        .collect();
    Segmentation {
        labels: labels.iter().map(|&l| (l != NONE).then(|| new[l as usize])).collect(),
        regions: reports,
        sigma: cloud.sigma * frame.scale,
        spacing: spacing * frame.scale,
    }
}

/// Covariance of the unknowns of a motion, lengths in those of the input, the pitch per turn; empty where the points do not determine it.
fn of_sweep(sweep: &Sweep, points: &[Point3<f64>], sigma: f64, scale: f64) -> Vec<Vec<f64>> {
    let Some(matrix) = crate::sweep::covariance(sweep, points, sigma) else { return Vec::new() };
    let unit = |i: usize| match i {
        0 | 1 => 1.0,
        2 | 3 => scale,
        _ => std::f64::consts::TAU * scale,
    };
    let row = |i: usize| (0..matrix.ncols()).map(|j| matrix[(i, j)] * unit(i) * unit(j)).collect();
    (0..matrix.nrows()).map(row).collect()
}

/// Whether an unknown is an angle.
fn is_angle(carrier: &Carrier, unknown: usize) -> bool {
    match carrier {
        Carrier::Plane { .. } => (1..3).contains(&unknown),
        Carrier::Sphere { .. } => false,
        Carrier::Cylinder { .. } => (2..4).contains(&unknown),
        Carrier::Cone { .. } => (2..4).contains(&unknown) || unknown == 5,
        Carrier::Torus { .. } => (3..5).contains(&unknown),
    }
}

/// A direction of two, so that its largest component is positive.
fn upwards(v: &Vector3<f64>) -> Vector3<f64> {
    if v[v.iamax()] < 0.0 { -v } else { *v }
}

fn shape(carrier: &Carrier, points: &[Point3<f64>], frame: &Frame) -> Shape {
    let middle = mean(points);
    match *carrier {
        Carrier::Plane { normal, .. } => {
            let point = middle - normal * carrier.at(&middle).0;
            Shape::Plane { point: frame.outwards(&point), normal: upwards(&normal) }
        }
        Carrier::Sphere { centre, radius } => {
            Shape::Sphere { point: frame.outwards(&centre), radius: radius * frame.scale }
        }
        Carrier::Cylinder { point, axis, radius } => Shape::Cylinder {
            point: frame.outwards(&(point + axis * (middle - point).dot(&axis))),
            axis: upwards(&axis),
            radius: radius * frame.scale,
        },
        Carrier::Cone { point, axis, radius, angle } => {
            // A cone of angle zero has no apex; the least angle keeps it finite.
            let steep = if angle.abs() < 1e-9 { 1e-9 } else { angle };
            let apex = point - axis * (radius / steep.tan());
            Shape::Cone { point: frame.outwards(&apex), axis: axis * steep.signum(), half_angle: steep.abs() }
        }
        Carrier::Torus { centre, axis, radius, minor } => Shape::Torus {
            point: frame.outwards(&centre),
            axis: upwards(&axis),
            radius: radius * frame.scale,
            minor_radius: minor * frame.scale,
        },
    }
}

fn swept(sweep: &Sweep, points: &[Point3<f64>], frame: &Frame) -> Shape {
    let middle = mean(points);
    let near = |point: &Point3<f64>, axis: &Vector3<f64>| {
        frame.outwards(&(point + axis * (middle - point).dot(axis)))
    };
    match sweep {
        Sweep::Extrusion { axis } => Shape::Extrusion { axis: upwards(axis) },
        Sweep::Revolution { point, axis } => {
            Shape::Revolution { point: near(point, axis), axis: upwards(axis) }
        }
        Sweep::Helix { point, axis, pitch } => Shape::Helix {
            point: near(point, axis),
            axis: upwards(axis),
            pitch: pitch * 2.0 * std::f64::consts::PI * frame.scale,
        },
    }
}
