//! The axis of a cloud.

use super::normal_lines::{Sample, least};
use crate::{AxisFrame, Coverage, Error};
use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use std::f64::consts::{PI, TAU};

/// Points that the estimate looks at.
const SAMPLE: usize = 20_000;
/// Directions in which the rims are looked for.
const RIM: usize = 72;
/// How much worse a candidate counts whose normals lie along it instead of across.
const ALONG: f64 = 0.3;
/// Advantage in score that a later candidate needs.
const ADVANTAGE: f64 = 0.004;

/// Which axis a turntable has.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum AxisChoice {
    /// The best of all below.
    #[default]
    Automatic,
    /// The given direction.
    Given(Vector3<f64>),
    /// The principal axis around which the cloud closes best.
    Principal,
    /// The axis about which the cloud is most nearly a surface of revolution.
    Rotation,
}

/// Where an estimated axis comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum AxisOrigin {
    /// It was given.
    Given,
    /// An axis of the coordinates.
    Coordinates,
    /// A principal axis.
    Principal,
    /// Perpendicular to the normals.
    Normals,
    /// Met by the normals, as that of a surface of revolution.
    Rotation,
    /// Perpendicular to the open ends.
    Rims,
}

/// An axis and what speaks for it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct AxisEstimate {
    /// Unit vector; its largest component is positive, if it was not given.
    pub direction: Vector3<f64>,
    /// Where it comes from.
    pub origin: AxisOrigin,
    /// How far the layers close around it.
    pub coverage: Coverage,
    /// Mean square of the cosine between normals and axis: 0 for a cylinder, 1/3 for a sphere.
    pub normals_along: f64,
}

impl AxisEstimate {
    fn score(&self) -> f64 {
        self.coverage.mean() - ALONG * self.normals_along
    }
}

/// The axis around which the layers of a cloud close best.
///
/// Candidates are the axes of the coordinates, the principal axes, the direction across the normals, the axis of
/// revolution, and for each of these the common normal of the two rims at its ends. The one with the best coverage
/// counts; on equal terms the one whose normals lie most across it, and the earlier.
///
/// # Errors
/// [`Error::TooFewPoints`] for fewer than 20 finite points; [`Error::Option`] for a given direction of no length.
pub fn estimate_axis(points: &[Vector3<f64>], choice: AxisChoice) -> Result<AxisEstimate, Error> {
    let sample = Sample::new(points, SAMPLE)?;
    if sample.points.len() < 20 {
        return Err(Error::TooFewPoints { total: points.len(), usable: sample.points.len(), needed: 20 });
    }
    let centre = sample.points.iter().sum::<Vector3<f64>>() / sample.points.len() as f64;
    let size = sample.points.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
    let mut candidates: Vec<(Vector3<f64>, AxisOrigin)> = Vec::new();
    let all = choice == AxisChoice::Automatic;
    if let AxisChoice::Given(direction) = choice {
        AxisFrame::new(centre, &direction)?;
        return Ok(estimate(&sample, centre, direction.normalize(), AxisOrigin::Given));
    }
    if all {
        candidates.extend([2, 1, 0].map(|axis| (Vector3::ith(axis, 1.0), AxisOrigin::Coordinates)));
    }
    if all || choice == AxisChoice::Rotation {
        let axis = sample.rotation_axis(&centre, size.max(f64::MIN_POSITIVE));
        candidates.extend(axis.map(|axis| (axis, AxisOrigin::Rotation)));
    }
    if all {
        candidates.extend(sample.cylinder_axis().map(|axis| (axis, AxisOrigin::Normals)));
    }
    if all || choice == AxisChoice::Principal {
        let scatter: Matrix3<f64> =
            sample.points.iter().map(|p| (p - centre) / size).map(|d| d * d.transpose()).sum();
        if scatter.iter().all(|v| v.is_finite()) {
            let axes = SymmetricEigen::new(scatter).eigenvectors;
            candidates.extend(axes.column_iter().map(|axis| (axis.into_owned(), AxisOrigin::Principal)));
        }
    }
    if all {
        let rims = candidates.iter().filter_map(|(axis, _)| rim_normal(&sample.points, &centre, axis));
        candidates.extend(rims.map(|axis| (axis, AxisOrigin::Rims)).collect::<Vec<_>>());
    }
    let mut best: Option<AxisEstimate> = None;
    for (axis, origin) in candidates {
        let axis = if axis[axis.iamax()] < 0.0 { -axis } else { axis };
        let found = estimate(&sample, centre, axis, origin);
        if best.as_ref().is_none_or(|best| found.score() > best.score() + ADVANTAGE) {
            best = Some(found);
        }
    }
    best.ok_or(Error::Shape {
        wanted: "a surface",
        why: "its points have no normals; check that they are not all equal".into(),
    })
}

fn estimate(
    sample: &Sample,
    centre: Vector3<f64>,
    direction: Vector3<f64>,
    origin: AxisOrigin,
) -> AxisEstimate {
    let coverage = AxisFrame::new(centre, &direction)
        .map_or(Coverage { layers: vec![0.0], gaps: vec![1.0], directions: 0 }, |frame| {
            Coverage::new(&sample.points, &frame)
        });
    AxisEstimate { direction, origin, coverage, normals_along: sample.along(&direction) }
}

/// The common normal of the rims: planes of the same direction through the lowest and the highest points around.
fn rim_normal(points: &[Vector3<f64>], centre: &Vector3<f64>, axis: &Vector3<f64>) -> Option<Vector3<f64>> {
    let mut direction = *axis;
    for _ in 0..4 {
        let frame = AxisFrame::new(*centre, &direction).ok()?;
        let mut rims = [[None::<(f64, Vector3<f64>)>; RIM]; 2];
        for p in points {
            let local = frame.to_local(p);
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
            let slot = (((local.y.atan2(local.x) + PI) / TAU * RIM as f64) as usize).min(RIM - 1);
            for (rim, sign) in rims.iter_mut().zip([-1.0, 1.0]) {
                if rim[slot].is_none_or(|(height, _)| sign * local.z > height) {
                    rim[slot] = Some((sign * local.z, *p));
                }
            }
        }
        let mut scatter = Matrix3::zeros();
        for rim in &rims {
            let found: Vec<Vector3<f64>> = rim.iter().flatten().map(|&(_, p)| p).collect();
            let mean = found.iter().sum::<Vector3<f64>>() / found.len().max(1) as f64;
            scatter += found.iter().map(|p| p - mean).map(|d| d * d.transpose()).sum::<Matrix3<f64>>();
        }
        let normal = least(scatter)?;
        let next = if normal.dot(&direction) < 0.0 { -normal } else { normal };
        // Rims across the axis only; others belong to another shape.
        if next.dot(axis) < 0.8 {
            return None;
        }
        direction = next;
    }
    Some(direction)
}
