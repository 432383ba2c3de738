//! The fit from the places of points: along the shortest path, and where that does not hold along one that goes straight on.

use super::adapt;
use super::conclude::{Cloud, Origin};
use super::crossing::meets_itself;
use super::options::CurveOptions;
use super::rational;
use super::report::{Closure, CurveFit, CurveReport};
use super::start::Layout;
use super::work::{State, Work};
use crate::iterate::Progress;
use crate::{Error, Status};
use distance_field::quantile_in_place;
use nalgebra::SVector;
use nurbs_core::{BsplineCurve, ParametricCurve};
use sdm_core::Robust;

/// Length of an open curve, in units of the gap between its ends, from which on it may be closed.
const AROUND: f64 = 3.0;
/// What passes for near where a curve may cross itself: in spacings of the points, and in units of the noise.
const MEETS: [f64; 2] = [3.0, 6.0];

/// Root mean square distance in spacings from which on distances tell whether they are noise; the mean fourth power of noise in units of the square
/// of its mean square, by dimension, from and to; and the mean squared difference of neighbours in units of twice the mean square.
const TOLD: f64 = 0.5;
const FOURTH: [[f64; 2]; 2] = [[2.2, 4.5], [1.5, 3.2]];
const CHANGE: [f64; 2] = [0.6, 1.4];

/// A fit along a path, and what speaks against it.
struct Attempt<const D: usize> {
    fit: CurveFit<D>,
    layout: Layout<D>,
    /// Whether the curve is open though its ends are near to each other, or turns where it could go straight on.
    doubtful: bool,
    /// Whether what is left does not look like noise.
    irregular: bool,
    /// How often it crosses itself beyond what the path does.
    crossings: usize,
}

impl<const D: usize> Attempt<D> {
    fn is_sound(&self) -> bool {
        let report = &self.fit.report;
        report.covered
            && report.reached != Some(false)
            && !self.doubtful
            && !self.irregular
            && self.crossings == 0
    }

    /// The fit, and how often it crosses itself though its path does not; a search has no path.
    fn told(self, options: &CurveOptions) -> (CurveFit<D>, usize) {
        let crosses = self.layout.crossings() == 0 && !self.layout.lost && !options.search;
        (self.fit, if crosses { self.crossings } else { 0 })
    }

    /// The Bayesian information criterion, by the median so that outliers do not matter.
    fn criterion(&self) -> f64 {
        let mut distances: Vec<f64> =
            self.fit.feet.iter().map(|foot| foot.distance).filter(|d| d.is_finite()).collect();
        let count = distances.len() as f64;
        let scale = quantile_in_place(&mut distances, 0.5).max(f64::MIN_POSITIVE);
        count * 2.0 * scale.ln() + self.fit.report.controls as f64 * count.ln()
    }

    /// What speaks against it, the most important first, to be compared.
    fn faults(&self) -> (bool, bool, f64, bool, bool, usize, bool, f64) {
        let report = &self.fit.report;
        (
            matches!(report.status, Status::Diverged | Status::Singular),
            !report.covered,
            if report.covered { 0.0 } else { report.coverage.badness(report.points) },
            report.reached == Some(false),
            self.doubtful,
            self.crossings,
            !report.is_converged(),
            self.criterion(),
        )
    }
}

/// The fit to points of which nothing else is known, so many of which are at different places.
pub(super) fn from_cloud<const D: usize>(
    cloud: &Cloud<'_, D>,
    distinct: usize,
    options: &CurveOptions,
    progress: Progress<'_>,
) -> Result<CurveFit<D>, Error> {
    let (mut fit, loops) = best_of(cloud, distinct, options, progress)?;
    // What the points leave open is not claimed, and neither is what the path through them contradicts.
    fit.report.open_ends = near_ends(&fit.curve, &fit.report);
    fit.report.loops = loops;
    fit.report.covered &= fit.report.open_ends.is_none() && loops == 0;
    Ok(fit)
}

/// The better one of the fits along the shortest path and along one that goes straight on, and how often it crosses itself though its path does not.
fn best_of<const D: usize>(
    cloud: &Cloud<'_, D>,
    distinct: usize,
    options: &CurveOptions,
    progress: Progress<'_>,
) -> Result<(CurveFit<D>, usize), Error> {
    let first = attempt(cloud, Layout::shortest(cloud.local, options)?, distinct, options, progress)?;
    if first.is_sound() || options.search || first.fit.report.status == Status::Cancelled {
        return Ok(first.told(options));
    }
    let layout = match Layout::straight(cloud.local, options) {
        Ok(layout) => layout,
        // What holds is one curve.
        Err(Error::SeveralParts { .. }) if first.fit.report.covered => return Ok(first.told(options)),
        Err(error) => return Err(error),
    };
    if layout.is_along(&first.layout) {
        return Ok(first.told(options));
    }
    let second = attempt(cloud, layout, distinct, options, progress)?;
    let cancelled = second.fit.report.status == Status::Cancelled;
    let (mut best, mut other) =
        if !cancelled && second.faults() < first.faults() { (second, first) } else { (first, second) };
    let report = &mut best.fit.report;
    other.fit.report.stages.iter_mut().for_each(|stage| stage.kept = false);
    report.stages.splice(0..0, other.fit.report.stages);
    report.iterations += other.fit.report.iterations;
    if cancelled {
        report.status = Status::Cancelled;
    }
    Ok(best.told(options))
}

/// The fit along a path.
fn attempt<const D: usize>(
    cloud: &Cloud<'_, D>,
    layout: Layout<D>,
    distinct: usize,
    options: &CurveOptions,
    progress: Progress<'_>,
) -> Result<Attempt<D>, Error> {
    // Which points lie off the path is seen before there is a curve that they could lead astray.
    let inliers = if options.fit.robust == Robust::None { None } else { Some(layout.inliers(cloud.local)) };
    let mut work = Work::new(inliers.as_deref().unwrap_or(cloud.local), options, progress);
    let most = distinct.min(options.max_controls).max(options.degree + 1);
    work.sorted_out = inliers.is_some();
    work.expected = layout.crossings();
    let expected = work.expected;
    let state = work.after_layout(&layout, distinct)?;
    let state = work.with_points(state, &layout, most)?;
    let state = work.weighed(state)?;
    let mut state = work.polished(state)?;
    if options.rational {
        state = rational::with_weights(&mut work, state, Some(&layout))?;
    }
    let state = work.trimmed(state)?;
    let state = work.with_ends(state, &cloud.centre)?;
    let state = work.settled(state);
    let Layout { closed, closure, kind: start, lost, .. } = layout;
    let fit = work.conclude(state, cloud, Origin { closed, closure, start, lost })?;
    let crossings = fit.report.crossings.len().saturating_sub(expected);
    let doubtful = is_doubtful(&fit.curve, &fit.report);
    let irregular = options.fit.robust != Robust::None || is_irregular(&fit, cloud);
    Ok(Attempt { fit, layout, doubtful, irregular, crossings })
}

/// Whether distances that are no smaller than the spacing of the points do not look like noise: neighbours along the curve agree or contradict each
/// other, or there are few small or many large ones.
fn is_irregular<const D: usize>(fit: &CurveFit<D>, cloud: &Cloud<'_, D>) -> bool {
    let Some([least, most]) = D.checked_sub(2).and_then(|k| FOURTH.get(k)) else { return false };
    if fit.report.rms <= TOLD * fit.report.coverage.spacing {
        return false;
    }
    let mut residuals: Vec<(f64, usize)> = cloud.kept.iter().map(|&i| (fit.feet[i].parameter, i)).collect();
    residuals.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let residuals: Vec<SVector<f64, D>> =
        residuals.into_iter().map(|(_, i)| cloud.points[i] - fit.feet[i].foot).collect();
    let count = residuals.len() as f64;
    let square = residuals.iter().map(SVector::norm_squared).sum::<f64>() / count;
    let fourth = residuals.iter().map(|r| r.norm_squared().powi(2)).sum::<f64>() / (count * square * square);
    let change =
        residuals.windows(2).map(|r| (r[1] - r[0]).norm_squared()).sum::<f64>() / (2.0 * count * square);
    !(*least..=*most).contains(&fourth) || !(CHANGE[0]..=CHANGE[1]).contains(&change)
}

/// The gap between the ends of a curve that was made open, if they are as near to each other as neighbours on it may be.
fn near_ends<const D: usize>(curve: &BsplineCurve<D>, report: &CurveReport) -> Option<f64> {
    let coverage = &report.coverage;
    let domain = curve.domain();
    let gap = (curve.point(domain.end()) - curve.point(domain.start())).norm();
    let around = coverage.length >= AROUND * coverage.limit.max(gap);
    let chosen = !report.closed && matches!(report.closure, Closure::Gap { .. });
    (chosen && around && gap <= coverage.limit + 2.0 * coverage.spacing).then_some(gap)
}

/// Whether a curve is open though its ends are as near to each other as neighbours on it may be, or meets itself without crossing.
fn is_doubtful<const D: usize>(curve: &BsplineCurve<D>, report: &CurveReport) -> bool {
    let coverage = &report.coverage;
    let reach = (MEETS[0] * coverage.spacing).max(MEETS[1] * coverage.noise);
    near_ends(curve, report).is_some() || report.crossings.is_empty() && meets_itself(curve, reach)
}

impl<const D: usize> Work<'_, D> {
    /// The fit from the places of the points, so many of which are distinct.
    fn after_layout(&mut self, layout: &Layout<D>, distinct: usize) -> Result<State<D>, Error> {
        if let Some(controls) = self.options.controls {
            let fit = self.loop_options();
            let state = self.with_controls(layout, controls, &fit)?;
            self.keep(&state);
            return Ok(state);
        }
        if self.options.abs_tolerance.is_some() {
            let coarse = adapt::coarse(self);
            let most = distinct.min(self.options.max_controls).max(self.options.degree + 1);
            let state = self.with_controls(layout, (self.options.degree + 5).min(most), &coarse)?;
            self.keep(&state);
            return adapt::to_tolerance(self, state);
        }
        adapt::by_noise(self, layout, distinct)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;
    use nurbs_core::KnotVector;

    #[test]
    fn ends_as_near_as_neighbours_are_told() {
        let ends = |gap: f64, closure: Closure| {
            let corners = [[0.0, gap], [0.0, 10.0], [10.0, 10.0], [10.0, 0.0], [0.0, 0.0]];
            let knots = KnotVector::uniform_clamped(1, 5).unwrap();
            let curve = BsplineCurve::new(knots, corners.map(Vector2::from).to_vec(), None).unwrap();
            let coverage =
                crate::CurveCoverage { length: 40.0 - gap, limit: 3.0, spacing: 0.5, ..Default::default() };
            near_ends(&curve, &CurveReport { closed: false, closure, coverage, ..CurveReport::default() })
        };
        let seen = Closure::Gap { gap: 0.0, limit: 0.0 };
        assert_eq!(ends(2.0, seen), Some(2.0));
        // Further apart, or asked for.
        assert_eq!((ends(5.0, seen), ends(2.0, Closure::Asked)), (None, None));
    }
}
