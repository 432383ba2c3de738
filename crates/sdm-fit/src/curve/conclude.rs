//! The report on a curve.

use super::crossing::self_crossings;
use super::judge::limits;
use super::places::length;
use super::report::{Closure, CurveFit, CurveReport, CurveStart, PointFoot};
use super::tree::Groups;
use super::work::{State, Work};
use crate::coverage_curve::of_curve;
use crate::report::status_within;
use crate::weights::weigh;
use crate::{CurveCoverage, Error};
use footpoint::{CurveFootpoint, CurveProjector};
use mesh_core::CloudIndex;
use nalgebra::{Point, SVector};
use nurbs_core::{BsplineCurve, ParametricCurve};
use sdm_core::Robust;

/// How near points that are left out may be to each other before they are a part of the data that is missed: in spacings, and in units of the
/// noise.
const TOGETHER: [f64; 2] = [3.0, 4.0];
/// Number and share of the points from which on they are.
const MISSED: (usize, f64) = (8, 0.02);
/// Length beyond an end, in spacings, in which points may be missed, and the share of those of the curve from which on they are.
const BEYOND: f64 = 6.0;
const GOES_ON: f64 = 0.3;
/// Share of the distance that is explained up to which a point is no outlier.
const NEAR: f64 = 0.4;
/// Root mean square distance as a share of the length from which on points that show no path lie on no curve.
const LOST: f64 = 0.01;
/// Share of the points that may be left out.
const LEFT_OUT: f64 = 0.3;

/// The points of a fit.
#[derive(Clone, Copy)]
pub(super) struct Cloud<'a, const D: usize> {
    pub(super) points: &'a [SVector<f64, D>],
    /// Indices of those to which a curve is fitted, and of those that are finite but too far away.
    pub(super) kept: &'a [usize],
    pub(super) astray: &'a [usize],
    /// The former from their centre.
    pub(super) local: &'a [SVector<f64, D>],
    pub(super) centre: SVector<f64, D>,
}

/// Where a curve comes from.
#[derive(Clone, Copy)]
pub(super) struct Origin {
    pub(super) closed: bool,
    pub(super) closure: Closure,
    pub(super) start: CurveStart,
    /// Whether the points show no path.
    pub(super) lost: bool,
}

impl<const D: usize> Work<'_, D> {
    pub(super) fn conclude(
        self,
        state: State<D>,
        cloud: &Cloud<'_, D>,
        origin: Origin,
    ) -> Result<CurveFit<D>, Error> {
        let Cloud { points, kept, astray, local, centre } = *cloud;
        let robust = self.options.fit.robust;
        let projector = CurveProjector::new(&state.curve);
        let found = projector.project_all(local);
        let nothing = PointFoot { parameter: f64::NAN, foot: SVector::repeat(f64::NAN), distance: f64::NAN };
        let mut feet = vec![nothing; points.len()];
        for (&index, foot) in kept.iter().zip(&found) {
            feet[index] =
                PointFoot { parameter: foot.parameter, foot: foot.point + centre, distance: foot.distance };
        }
        for &index in astray {
            // From as far away as the curve is large, in the same direction.
            let away = points[index] - centre;
            let foot = projector.project(&(away / away.amax() * self.size * 1e3));
            let (parameter, foot) = (foot.parameter, foot.point + centre);
            feet[index] = PointFoot { parameter, foot, distance: length(&(points[index] - foot)) };
        }
        // Where outliers are left out, those that are within what spacing or noise explain in any case count.
        let usual = if robust == Robust::None { 0.0 } else { self.coverage(&state).distance_limit * NEAR };
        let counts = counted(&found, robust, usual.max(super::work::EXACT * self.size));
        let members: Vec<usize> = (0..local.len()).filter(|&k| counts[k]).collect();
        let some = |k: &usize| local[*k];
        let used: Vec<SVector<f64, D>> = members.iter().map(some).collect();
        let used_feet: Vec<CurveFootpoint<D>> = members.iter().map(|&k| found[k]).collect();
        let asked = limits(local, self.options, self.given);
        let mut coverage = of_curve(&state.curve, &used, &used_feet, asked);
        let left: Vec<SVector<f64, D>> = (0..local.len()).filter(|&k| !counts[k]).map(|k| local[k]).collect();
        coverage.points_far +=
            missed(&left, local.len(), &coverage) + beyond_ends(&state.curve, &left, &coverage);
        let outliers = robust != Robust::None;
        if !outliers {
            coverage.points_far += astray.len();
        }
        // Points that are astray count unless outliers are to be left out.
        let far = if outliers { &[][..] } else { astray };
        let judged: Vec<usize> = members.iter().map(|&k| kept[k]).chain(far.iter().copied()).collect();
        let largest = judged.iter().map(|&i| feet[i].distance).fold(0.0, f64::max);
        let max_index = judged.iter().copied().find(|&i| feet[i].distance == largest).unwrap_or(0);
        let shares = judged.iter().map(|&i| (feet[i].distance / largest.max(f64::MIN_POSITIVE)).powi(2));
        let rms = largest * (shares.sum::<f64>() / judged.len().max(1) as f64).sqrt();
        coverage.spread_out |= origin.lost && rms > LOST * coverage.length;
        let tolerance = self.options.abs_tolerance;
        let within = |limit: f64| judged.iter().filter(|&&i| feet[i].distance <= limit).count() as f64;
        let reached = tolerance.map(|limit| largest <= limit);
        coverage.moved(&centre.iter().copied().collect::<Vec<_>>());
        let report = CurveReport {
            status: status_within(state.report.status, reached == Some(true)),
            closed: origin.closed,
            closure: origin.closure,
            start: origin.start,
            points: points.len(),
            dropped: points.len() - kept.len() - astray.len(),
            astray: astray.len(),
            used: judged.len(),
            controls: state.curve.knots().distinct_count(),
            degree: state.curve.degree(),
            rms,
            max: largest,
            max_index,
            tolerance,
            share_within: tolerance.map(|limit| within(limit) / judged.len().max(1) as f64),
            reached,
            open_ends: None,
            loops: 0,
            covered: coverage.holds(),
            coverage,
            lambda: state.report.lambda,
            iterations: self.stages.iter().map(|stage| stage.iterations).sum(),
            steps_lifted: self.history.iter().filter(|step| step.lifted).count(),
            crossings: self_crossings(&state.curve),
            stages: self.stages,
            history: self.history,
        };
        let evolution = self.evolution.iter().map(|c| c.translated(&centre)).collect::<Result<_, _>>()?;
        Ok(CurveFit { curve: state.curve.translated(&centre)?, report, feet, evolution })
    }
}

/// Which points count: all, or those that have a weight, or are near.
fn counted<const D: usize>(feet: &[CurveFootpoint<D>], robust: Robust, near: f64) -> Vec<bool> {
    let mut weights = vec![1.0; feet.len()];
    weigh(&mut weights, &|i| feet[i].distance, robust);
    // Where nearly all points are exact, small distances are no reason to leave some out.
    weights.iter().zip(feet).map(|(w, foot)| *w > 0.0 || foot.distance <= near).collect()
}

/// Number of points that are left out and go on where an open curve ends.
fn beyond_ends<const D: usize>(
    curve: &BsplineCurve<D>,
    left: &[SVector<f64, D>],
    coverage: &CurveCoverage,
) -> usize {
    if curve.knots().is_periodic() {
        return 0;
    }
    let along = BEYOND * coverage.spacing + coverage.noise;
    let across = coverage.spacing + coverage.noise;
    let domain = curve.domain();
    let count = |end: f64, sense: f64| {
        let (place, jet) = (curve.point(end), curve.jet(end));
        let Some(way) = jet.unit_tangent() else { return 0 };
        let goes_on = |p: &&SVector<f64, D>| {
            let away = *p - place;
            let ahead = sense * way.dot(&away);
            (0.0..=along).contains(&ahead) && (away - way * way.dot(&away)).norm() <= across
        };
        left.iter().filter(goes_on).count()
    };
    let enough = (GOES_ON * along / coverage.spacing.max(f64::MIN_POSITIVE)).max(3.0);
    [count(domain.start(), -1.0), count(domain.end(), 1.0)].into_iter().filter(|&n| n as f64 >= enough).sum()
}

/// Number of points that are left out and lie together, or that are too many to be outliers.
fn missed<const D: usize>(left: &[SVector<f64, D>], total: usize, coverage: &CurveCoverage) -> usize {
    if left.len() as f64 > LEFT_OUT * total as f64 {
        return left.len();
    }
    let places: Vec<Point<f64, D>> = left.iter().copied().map(Point::from).collect();
    let Ok(index) = CloudIndex::new(&places) else { return 0 };
    let reach = TOGETHER[0] * coverage.spacing + TOGETHER[1] * coverage.noise;
    let mut groups = Groups::new(left.len());
    for i in 0..left.len() {
        for near in index.within(&places[i], reach) {
            groups.connect(i, near.index);
        }
    }
    let mut sizes = vec![0; left.len()];
    (0..left.len()).for_each(|i| sizes[groups.first(i)] += 1);
    let fewest = (MISSED.0 as f64).max(MISSED.1 * total as f64);
    sizes.into_iter().filter(|&size| size as f64 >= fewest).sum()
}
