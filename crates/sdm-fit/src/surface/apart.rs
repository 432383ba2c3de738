//! Points that cannot belong to a surface count for the report nevertheless.

use super::options::SurfaceOptions;
use super::report::SurfaceFit;
use super::runs::share_within;
use crate::cloud_kind::distance_of_far;
use distance_field::PrincipalFrame;
use footpoint::Status as FootStatus;
use nalgebra::Vector3;

/// The points that belong.
pub(crate) fn kept(points: &[Vector3<f64>], belongs: &[bool]) -> Vec<Vector3<f64>> {
    points.iter().zip(belongs).filter(|(_, b)| **b).map(|(p, _)| *p).collect()
}

/// A fit of the points that belong, as one of all finite points: the others are in no frame, in the largest distance, and outside of every
/// tolerance.
pub(super) fn with_apart(
    points: &[Vector3<f64>],
    belongs: &[bool],
    mut found: SurfaceFit,
    options: &SurfaceOptions,
) -> SurfaceFit {
    let is_finite = |p: &Vector3<f64>| p.iter().all(|c| c.is_finite());
    let finite: Vec<(&Vector3<f64>, bool)> =
        points.iter().zip(belongs).filter(|(p, _)| is_finite(p)).map(|(p, b)| (p, *b)).collect();
    if finite.iter().all(|f| f.1) {
        return found;
    }
    let place = found.surface.control_points().first().copied().unwrap_or_else(Vector3::zeros);
    let mut frames = found.frames.into_iter();
    let invalid = || PrincipalFrame::invalid(FootStatus::InvalidPoint);
    found.frames =
        finite.iter().map(|f| if f.1 { frames.next().unwrap_or_else(invalid) } else { invalid() }).collect();
    let fit = &mut found.report.fit;
    let numbers: Vec<usize> = (0..finite.len()).filter(|&k| finite[k].1).collect();
    fit.max_index = numbers.get(fit.max_index).copied().unwrap_or(0);
    for (index, (point, belongs)) in finite.iter().enumerate() {
        let distance = if *belongs { 0.0 } else { distance_of_far(point, &place) };
        if distance > fit.max {
            (fit.max, fit.max_index) = (distance, index);
        }
    }
    fit.samples = finite.len();
    if let Some(tolerance) = options.abs_tolerance {
        let share = share_within(&found.frames, tolerance);
        found.report.share_within = Some(share);
        found.report.within_tolerance = share >= options.share;
    }
    found
}
