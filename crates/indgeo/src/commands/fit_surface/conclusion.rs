//! What the report of a fitted surface says about all points, which of them are outliers, and where the data end.

use crate::commands::fit_surface::finish::HARMLESS;
use crate::commands::fit_surface::judgement::Judgement;
use crate::commands::fit_surface::start::{Found, NOISE, Refusal, Start};
use industrial_geometry::cloud_param::{Error as ParameterError, consistent, crowded, resolution};
use industrial_geometry::fit::{
    Folds, Robust, Status, SurfaceCoverage, SurfaceDistances, SurfaceOptions, SurfaceReport, cut_to_feet,
    measurable, surface_frames,
};
use industrial_geometry::footpoint::SurfaceProjector;
use industrial_geometry::nurbs::BsplineSurface;
use industrial_geometry::nurbs::nalgebra::Vector3;

/// Last step, and distance that is left, in spacings, of a surface that goes on moving but resolves the points.
const AT_REST: f64 = 0.01;
/// Largest distance of a point, in spacings, from a surface that is right, where the distances are not those of noise.
const VERIFIED: f64 = 0.25;

/// The points with others beside them; those by themselves have no place.
pub(crate) fn in_crowds(points: &[Vector3<f64>]) -> Result<Vec<Vector3<f64>>, ParameterError> {
    let crowded = crowded(points, &measurable(points)?)?;
    let nowhere = Vector3::repeat(f64::NAN);
    Ok(points.iter().zip(crowded).map(|(p, crowded)| if crowded { *p } else { nowhere }).collect())
}

/// Diagonal of the box around the points that can belong to one shape.
pub(crate) fn diagonal(points: &[Vector3<f64>]) -> f64 {
    let belongs = measurable(points).unwrap_or_else(|_| vec![false; points.len()]);
    let kept = points.iter().zip(belongs).filter(|(_, b)| *b).map(|(p, _)| *p);
    let bounds = kept.fold(None, |bounds: Option<[Vector3<f64>; 2]>, p| {
        Some(bounds.map_or([p, p], |[low, high]| [low.inf(&p), high.sup(&p)]))
    });
    bounds.map_or(0.0, |[low, high]| (high - low).norm())
}

/// A kernel without a scale of its own with one that leaves regions their weight where the surface does not resolve the points.
pub(crate) fn with_scale(robust: Robust, sigma: Option<f64>) -> Robust {
    match (robust, sigma) {
        (Robust::Kernel { kernel, abs_scale: None }, Some(sigma)) => {
            Robust::Kernel { kernel, abs_scale: Some(kernel.tuning() * sigma) }
        }
        _ => robust,
    }
}

/// What is assumed about outliers with a scale by the distances of points from a surface, and the points that say where the data end: those that are
/// no outliers.
fn counting(
    points: &[Vector3<f64>],
    belongs: &[bool],
    surface: &BsplineSurface,
    robust: Robust,
) -> Result<(Robust, Vec<Vector3<f64>>), ParameterError> {
    let kept = |counts: &dyn Fn(usize) -> bool| {
        (0..points.len()).filter(|&i| counts(i)).map(|i| points[i]).collect()
    };
    if robust == Robust::None {
        return Ok((robust, kept(&|i| belongs[i])));
    }
    let feet = SurfaceProjector::new(surface).project_all(points);
    let agree = consistent(points, &feet, belongs, HARMLESS)?;
    let seen = resolution(points, &feet, &agree)?;
    let robust = with_scale(robust, seen.unresolved.then_some(seen.sigma));
    let found = SurfaceDistances::of(surface, points, robust)?;
    // Points without noise are off by more than the scale of a kernel where the surface does not resolve them.
    let near = |i: usize| found.weights[i] > 0.0 || found.distances[i] <= HARMLESS * seen.spacing;
    Ok((robust, kept(&|i| agree[i] && near(i))))
}

/// What the report says about the surface that is left, and all finite points, whether they were used or not.
pub(crate) fn concluded(
    points: &[Vector3<f64>],
    mut surface: BsplineSurface,
    mut report: SurfaceReport,
    mut start: Start,
    options: &SurfaceOptions,
) -> Result<Found, Refusal> {
    let belongs = measurable(points)?;
    let kept: Vec<Vector3<f64>> = points.iter().zip(&belongs).filter(|(_, b)| **b).map(|(p, _)| *p).collect();
    // Open ends stop where the points do that are no outliers.
    let (robust, counting) =
        counting(points, &belongs, &surface, options.fit.robust).map_err(Refusal::Points)?;
    let frames = surface_frames(&surface, &counting)?;
    if let Some(cut) = cut_to_feet(&surface, &frames)? {
        surface = cut;
        report.controls = [surface.knots_u().distinct_count(), surface.knots_v().distinct_count()];
        report.folds = Folds::of(&surface);
    }
    report.dropped = points.iter().filter(|p| !p.iter().all(|c| c.is_finite())).count();
    let found = SurfaceDistances::of(&surface, points, robust)?;
    let finite_before =
        |index: usize| points[..index].iter().filter(|p| p.iter().all(|c| c.is_finite())).count();
    report.fit.rms = found.rms;
    report.fit.max = found.max;
    report.fit.max_index = finite_before(found.max_index);
    report.fit.samples = found.finite();
    report.fit.used = found.used;
    let noise = SurfaceCoverage::noise_of(&found.distances);
    // What belongs to nothing does not say how far the data go.
    let outliers = robust != Robust::None;
    let near = if outliers { &counting } else { &kept };
    let piece = SurfaceCoverage::up_to_data(&surface, near, noise, options.abs_tolerance, outliers)?;
    let coverage = piece.coverage;
    report.trim = piece.trim;
    if let Some(opened) = piece.opened {
        surface = opened;
        report.controls = [surface.knots_u().distinct_count(), surface.knots_v().distinct_count()];
    }
    if let Some(tolerance) = options.abs_tolerance {
        let share = found.share_within(tolerance);
        report.share_within = Some(share);
        report.within_tolerance = share >= options.share;
    }
    let judgement = Judgement::of(points, &found, &coverage, options.abs_tolerance, robust);
    (start.far, start.far_max, start.unresolved) = (judgement.far, judgement.far_max, judgement.unresolved);
    start.missed = judgement.missed;
    // What is near all points, with all of its parts, is right, whatever it began with.
    let is_noise = found.disagreement >= NOISE && found.rms <= coverage.spacing;
    let is_near = coverage.is_complete()
        && (report.fit.max <= VERIFIED * coverage.spacing || is_noise && judgement.is_clean());
    start.doubtful &= !(is_near && report.folds.count() == 0);
    let last = report.fit.history.last().map_or(f64::INFINITY, |step| step.displacement);
    if report.fit.status == Status::MaxIterations && last.max(report.fit.rms) <= AT_REST * coverage.spacing {
        report.fit.status = Status::Converged;
    }
    report.coverage = Some(coverage);
    Ok((surface, report, start))
}
