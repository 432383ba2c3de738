//! Whether a curve stays with its points, and what is done where it does not.

use super::adapt;
use super::options::CurveOptions;
use super::start::Layout;
use super::work::{State, Work};
use crate::coverage_curve::{Limits, of_curve};
use crate::options::Smoothing;
use crate::shape::ActiveShape;
use crate::{ActiveCurve, CurveCoverage, Error, Status};
use footpoint::{CurveFootpoint, CurveProjector};
use nalgebra::SVector;
use nurbs_core::{BsplineCurve, Interval, ParametricCurve};
use sdm_core::Robust;

/// Share of the diagonal that a point may be away where the number of control points is given.
const COARSE: f64 = 0.01;
/// Distance from the path, in units of the tolerance, of the curve from which points are followed.
const FOLLOWED_FROM: f64 = 3.0;
/// Share of the distance that is explained by spacing and noise to which a curve is fitted that is not within it.
const GOAL: f64 = 0.7;
/// Share of the points that keep a weight where few are outliers.
const ENOUGH: f64 = 0.8;
/// Iterations at the end of a run by which is seen what it still gains, how much of the spacing that may be, and by which share distances may grow.
const LATELY: usize = 20;
const RESOLVED: f64 = 0.02;
const CREEP: f64 = 0.02;
/// Distance of points that say where an open curve ends, where some may be outliers: in spacings and in units of the noise. And length from the next
/// one beyond which an end point is an outlier.
const SPACINGS: f64 = 3.0;
const NOISES: f64 = 3.5;
const LONE: f64 = 6.0;
const NOISE_ALONG: f64 = 2.0;
/// And length from the last but two beyond which the last two are: an end that leads to one outlier leads on to the next.
const PAIR: f64 = 9.0;
/// Chords by which the length of an end is measured.
const CHORDS: usize = 64;
/// Factor of the energy below which it is none.
const NOTHING: f64 = 1e-16;

/// What is asked of curves and points.
pub(super) fn limits<const D: usize>(
    points: &[SVector<f64, D>],
    options: &CurveOptions,
    given: bool,
) -> Limits {
    let mut low = SVector::<f64, D>::repeat(f64::INFINITY);
    let mut high = -low;
    for p in points {
        (low, high) = (low.inf(p), high.sup(p));
    }
    let coarse = if options.controls.is_some() || given { COARSE * (high - low).norm() } else { 0.0 };
    Limits {
        distance: options.abs_tolerance.unwrap_or(coarse),
        gap: options.max_gap,
        outliers: options.fit.robust != Robust::None,
        free_ends: false,
    }
}

/// The distance that a curve which leaves its points shall come to: what spacing and noise explain, less where it hardly follows them.
fn wanted(coverage: &CurveCoverage) -> f64 {
    let limit = coverage.distance_limit;
    if coverage.points_far > 0 { limit } else { limit.min(NOISES * coverage.noise + coverage.spacing) }
}

impl<const D: usize> Work<'_, D> {
    /// A curve seen from some of the points, and the other way round.
    pub(super) fn coverage_on(&self, points: &[SVector<f64, D>], curve: &BsplineCurve<D>) -> CurveCoverage {
        let feet = CurveProjector::new(curve).project_all(points);
        // Ends are cut where the points end when there is nothing else to do.
        let limits = Limits { free_ends: !self.given, ..limits(points, self.options, self.given) };
        of_curve(curve, points, &feet, limits)
    }

    pub(super) fn coverage(&self, state: &State<D>) -> CurveCoverage {
        self.coverage_on(self.points, &state.curve)
    }

    /// Whether a curve stays with its points and crosses itself as often as the path.
    fn is_sound(&self, state: &State<D>, coverage: &CurveCoverage) -> bool {
        coverage.holds() && self.crossings(&state.curve) == 0 && self.is_within(state)
    }

    fn is_within(&self, state: &State<D>) -> bool {
        self.options.abs_tolerance.is_none_or(|limit| state.report.max <= limit)
    }

    /// How much is wrong with a curve, the most important first.
    fn rank(&self, state: &State<D>) -> (bool, f64, usize, f64) {
        let coverage = self.coverage(state);
        let failed = matches!(state.report.status, Status::Diverged | Status::Singular);
        (
            failed || !coverage.holds(),
            coverage.badness(self.points.len()),
            self.crossings(&state.curve),
            if self.is_within(state) { 0.0 } else { state.report.max },
        )
    }

    /// The curve, or one that stays better with the points and the path through them: with more knots where points are far away, or from a curve
    /// that is near to the path already, and stays there.
    pub(super) fn with_points(
        &mut self,
        state: State<D>,
        layout: &Layout<D>,
        most: usize,
    ) -> Result<State<D>, Error> {
        let coverage = self.coverage(&state);
        if self.is_sound(&state, &coverage) || self.cancelled {
            return Ok(state);
        }
        let mut best = state;
        if coverage.without_data.is_empty()
            && (coverage.points_far > 0 || coverage.unresolved)
            && self.crossings(&best.curve) == 0
            && !coverage.spread_out
        {
            best = self.towards(best, wanted(&coverage))?;
            if self.is_sound(&best, &self.coverage(&best)) || self.cancelled {
                return Ok(best);
            }
        }
        let kept = self.kept();
        let other = self.along_path(layout, most)?;
        if let Some(other) = other
            && self.rank(&other) < self.rank(&best)
        {
            return Ok(other);
        }
        self.restore(kept);
        Ok(best)
    }

    /// The curve with knots where points are further than spacing and noise explain, if their number is not given.
    fn towards(&mut self, state: State<D>, limit: f64) -> Result<State<D>, Error> {
        if self.options.controls.is_some() || self.options.abs_tolerance.is_some() {
            return Ok(state);
        }
        let kept = self.kept();
        self.restore(kept.clone());
        self.goal = Some(GOAL * limit);
        let next = adapt::to_tolerance(self, state.clone());
        self.goal = None;
        let next = next?;
        if self.rank(&next) < self.rank(&state) {
            return Ok(next);
        }
        self.restore(kept);
        Ok(state)
    }

    /// The fit from a curve near to the path on which points keep to where they are.
    fn along_path(&mut self, layout: &Layout<D>, most: usize) -> Result<Option<State<D>>, Error> {
        let degree = self.options.degree;
        let curve = match (self.options.controls, self.options.abs_tolerance) {
            (Some(controls), _) => layout.bent(degree, controls)?,
            (None, Some(limit)) => {
                layout.faithful(degree, most, (FOLLOWED_FROM * limit).max(layout.scatter(self.points)))?
            }
            (None, None) => layout.faithful(degree, most, layout.nearness(self.points))?,
        };
        let Some(curve) = curve else { return Ok(None) };
        self.follows = true;
        let state = self.run(curve, &adapt::coarse(self), "path")?;
        self.keep(&state);
        if self.options.abs_tolerance.is_some() {
            return adapt::to_tolerance(self, state).map(Some);
        }
        // From there with the nearest feet and the energy that the data ask for.
        self.follows = false;
        let kept = self.kept();
        self.restore(kept.clone());
        let next = self.run(state.curve.clone(), &adapt::warm(self), "fit")?;
        self.keep(&next);
        let state = if self.rank(&next) <= self.rank(&state) {
            next
        } else {
            self.restore(kept);
            state
        };
        let coverage = self.coverage(&state);
        let off = coverage.points_far > 0 || coverage.unresolved;
        if coverage.without_data.is_empty() && off && !self.cancelled {
            return self.towards(state, wanted(&coverage)).map(Some);
        }
        Ok(Some(state))
    }

    /// The fit of points without those off the path, once more with weights by distance, now that there is a curve that tells which ones
    /// are far.
    pub(super) fn weighed(&mut self, state: State<D>) -> Result<State<D>, Error> {
        if !self.sorted_out || self.cancelled {
            return Ok(state);
        }
        self.sorted_out = false;
        let fit = self.loop_options().with_smoothing(Smoothing::Fixed { lambda: state.report.lambda });
        self.sorted_out = true;
        let next = self.run(state.curve.clone(), &fit, "weigh")?;
        let enough = next.report.used as f64 >= ENOUGH * self.points.len() as f64;
        let good = next.report.status.is_converged() || !state.report.status.is_converged();
        if enough && good && self.rank(&next) <= self.rank(&state) {
            self.keep(&next);
            return Ok(next);
        }
        Ok(state)
    }

    /// A run that came to its last iteration, or found no better step, when what it still gained was less than the data resolve has converged.
    pub(super) fn settled(&self, mut state: State<D>) -> State<D> {
        let history = &state.report.history;
        let (Some(last), Some(earlier)) =
            (history.last(), history.len().checked_sub(LATELY).and_then(|k| history.get(k)))
        else {
            return state;
        };
        if matches!(state.report.status, Status::MaxIterations | Status::Stalled) {
            let spacing = self.coverage(&state).spacing;
            let gained = (earlier.rms - last.rms).abs();
            if gained <= RESOLVED * spacing && last.rms <= earlier.rms * (1.0 + CREEP) {
                state.report.status = Status::Converged;
            }
        }
        state
    }

    /// An open curve without what goes on at its ends beyond the first and the last point by more than these are apart.
    pub(super) fn trimmed(&self, mut state: State<D>) -> Result<State<D>, Error> {
        if state.curve.knots().is_periodic() {
            return Ok(state);
        }
        let feet = CurveProjector::new(&state.curve).project_all(self.points);
        let coverage =
            of_curve(&state.curve, self.points, &feet, limits(self.points, self.options, self.given));
        // Where some may be outliers, only what is as near as most says where the points end, and a single one beyond them does not.
        let outliers = self.options.fit.robust != Robust::None;
        let usual = (SPACINGS * coverage.spacing).max(NOISES * coverage.noise);
        let limit = if outliers { usual.min(coverage.distance_limit) } else { coverage.distance_limit };
        let near = |foot: &&CurveFootpoint<D>| foot.distance <= limit;
        let mut parameters: Vec<f64> = feet.iter().filter(near).map(|foot| foot.parameter).collect();
        parameters.sort_by(f64::total_cmp);
        let apart = |a: f64, b: f64| {
            let at = |k: usize| state.curve.point(a + (b - a) * k as f64 / CHORDS as f64);
            (0..CHORDS).map(|k| (at(k + 1) - at(k)).norm()).sum::<f64>()
        };
        let far = |spacings: f64| spacings * coverage.spacing + NOISE_ALONG * coverage.noise;
        let (alone, pair) = (far(LONE), far(PAIR));
        let mut kept = &parameters[..];
        while let [first, next, third, .., inner, before, last] = kept
            && outliers
        {
            if apart(*first, *next) > alone {
                kept = &kept[1..];
            } else if apart(*first, *third) > pair {
                kept = &kept[2..];
            } else if apart(*before, *last) > alone {
                kept = &kept[..kept.len() - 1];
            } else if apart(*inner, *last) > pair {
                kept = &kept[..kept.len() - 2];
            } else {
                break;
            }
        }
        let (Some(&first), Some(&last)) = (kept.first(), kept.last()) else { return Ok(state) };
        let domain = state.curve.domain();
        let least = 1e-6 * domain.length();
        if (last - first).is_nan() || last - first <= least {
            return Ok(state);
        }
        let before = first - domain.start() > least && apart(domain.start(), first) > coverage.spacing;
        let behind = domain.end() - last > least && apart(last, domain.end()) > coverage.spacing;
        let mut curve = state.curve.clone();
        if behind {
            curve = curve.split(last)?.0;
        }
        if before {
            curve = curve.split(first)?.1;
        }
        if before || behind {
            state.curve = curve.reparameterized(Interval::new(domain.start(), domain.end())?)?;
        }
        Ok(state)
    }

    /// Smoothing that begins with no more energy than the distances from a given curve are worth, so that a curve through the points
    /// stays where it is.
    pub(super) fn gentle(&self, curve: &BsplineCurve<D>) -> Result<Smoothing, Error> {
        let smoothing = self.options.fit.smoothing;
        let feet = CurveProjector::new(curve).project_all(self.points);
        let cost = feet.iter().map(|f| f.distance * f.distance).sum::<f64>() / feet.len().max(1) as f64;
        let active = ActiveCurve::new(curve.clone())?;
        let d = active.coefficients();
        let mut energy = 0.0;
        for form in active.energy(self.options.fit.energy) {
            let columns = active.cells().columns(form.cell);
            let k = columns.len();
            energy +=
                (0..k * k).map(|e| form.gram[e] * d[columns[e / k]].dot(&d[columns[e % k]])).sum::<f64>();
        }
        let worth = if energy > 0.0 { cost / energy } else { f64::INFINITY };
        let worth = if worth < NOTHING { 0.0 } else { worth };
        Ok(match smoothing {
            Smoothing::Fixed { .. } => smoothing,
            Smoothing::Continuation { start, factor, floor } => {
                Smoothing::Continuation { start: start.min(worth).max(floor), factor, floor }
            }
            Smoothing::Automatic { start, factor } => {
                Smoothing::Automatic { start: start.min(worth), factor }
            }
        })
    }
}
