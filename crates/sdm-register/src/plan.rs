//! The stages of a registration in their order: coarse points before all, wide limits before narrow ones.

use crate::iterate::{History, Outcome, Problem, Stage};
use crate::source::Prepared;
use crate::view::View;
use crate::weights::{Kernel, Outliers, Rule, Weighting};
use crate::{Method, Pose, Status};
use distance_field::Spread;
use std::borrow::Cow;

/// What may be left of the motion in a stage that only has to come near, as a share of the size of the cloud.
const COARSE: f64 = 1e-4;
/// The same while the limit of the distance is narrowed.
const NARROWING: f64 = 3e-3;
/// Steps for each limit.
const NARROWING_STEPS: usize = 6;
/// Distances in standard deviations of the noise at which a point no longer is one of the inliers.
const CUT: f64 = 4.685;
/// Distances in standard deviations that a normal distribution does not show: a single point there is an outlier.
const IMPOSSIBLE: f64 = 8.0;
/// Noise as a share of the size of the cloud above which the minimum may be a wrong one.
const NOISY: f64 = 0.012;
/// Smallest noise that is believed, as a share of the size of the cloud.
const NOISE_FLOOR: f64 = 1e-12;

/// The stages of one registration and what they did.
pub(crate) struct Plan<'a, const D: usize> {
    problem: &'a Problem<'a, D>,
    cloud: &'a Prepared<D>,
    coarse: Cow<'a, Prepared<D>>,
    pub(crate) history: History,
    pub(crate) evaluations: usize,
}

impl<'a, const D: usize> Plan<'a, D> {
    pub(crate) fn new(problem: &'a Problem<'a, D>, cloud: &'a Prepared<D>) -> Self {
        let step = cloud.points.len() / problem.options.coarse_points.max(1);
        let coarse = if step >= 2 { Cow::Owned(cloud.thinned(step)) } else { Cow::Borrowed(cloud) };
        Self { problem, cloud, coarse, history: History::new(), evaluations: 0 }
    }

    /// The points of the stages that only have to come near.
    pub(crate) fn coarse(&self) -> &Prepared<D> {
        &self.coarse
    }

    fn is_thinned(&self) -> bool {
        matches!(self.coarse, Cow::Owned(_))
    }

    /// The coarse points in the starting pose.
    pub(crate) fn first_view(&mut self, start: Pose<D>) -> View<D> {
        self.evaluations += 1;
        self.problem.view(&self.coarse, start)
    }

    /// All stages, from a view of the coarse points.
    pub(crate) fn run(&mut self, view: View<D>) -> Outcome<D> {
        match self.problem.options.outliers {
            Outliers::None => self.fit(view, Rule::Fixed(Weighting::SQUARES)),
            Outliers::Trimmed { overlap } => self.fit(view, Rule::Trimmed { overlap }),
            Outliers::Kernel { kernel, abs_scale } => self.kernel(view, kernel, abs_scale),
            Outliers::Automatic => self.automatic(view),
        }
    }

    /// A stage with the options' own settings.
    fn stage<'b>(&self, name: &'static str, cloud: &'b Prepared<D>, rule: Rule) -> Stage<'b, D> {
        let options = self.problem.options;
        Stage {
            name,
            cloud,
            method: options.method,
            rule,
            rejection: options.rejection,
            tolerance: options.tolerance,
            max_iterations: options.max_iterations,
        }
    }

    fn go(&mut self, stage: &Stage<'_, D>, view: View<D>) -> Outcome<D> {
        let outcome = self.problem.run(stage, view, &mut self.history);
        self.evaluations += outcome.evaluations;
        outcome
    }

    /// From the coarse points to all of them.
    fn all_points(&mut self, outcome: Outcome<D>) -> View<D> {
        if !self.is_thinned() {
            return outcome.view;
        }
        self.evaluations += 1;
        self.problem.view(self.cloud, outcome.view.pose)
    }

    /// One rule for all: the coarse points, then all.
    fn fit(&mut self, view: View<D>, rule: Rule) -> Outcome<D> {
        if !self.is_thinned() {
            return self.go(&self.stage("fit", self.cloud, rule), view);
        }
        let coarse = self.coarse.clone();
        let near = self.go(&Stage { tolerance: COARSE, ..self.stage("coarse", &coarse, rule) }, view);
        if near.status == Status::Cancelled {
            return near;
        }
        let view = self.all_points(near);
        self.go(&self.stage("fit", self.cloud, rule), view)
    }

    /// The limits of the options, one after the other, and then the estimated noise, on the coarse points.
    fn narrow(&mut self, view: View<D>, kernel: Kernel) -> Outcome<D> {
        let coarse = self.coarse.clone();
        let size = coarse.diagonal * view.pose.scale;
        let mut view = view;
        // Points beyond the boundary of the shape have their feet there and would draw the cloud inwards.
        let rejection = self.problem.options.rejection.with_boundary(true);
        for limit in self.problem.options.limits {
            let rule = Rule::Fixed(Weighting::Kernel { kernel, scale: limit * size });
            let stage = Stage {
                method: Method::TANGENT,
                rejection,
                tolerance: NARROWING,
                max_iterations: NARROWING_STEPS,
                ..self.stage("narrow", &coarse, rule)
            };
            let outcome = self.go(&stage, view);
            if outcome.status == Status::Cancelled {
                return outcome;
            }
            view = outcome.view;
        }
        let limit = self.problem.options.limits[2] * size;
        let rule = Rule::Estimated { kernel, limit, floor: NOISE_FLOOR * size };
        let stage = Stage {
            rejection,
            method: Method::TANGENT,
            tolerance: COARSE,
            max_iterations: 3 * NARROWING_STEPS,
            ..self.stage("narrow", &coarse, rule)
        };
        self.go(&stage, view)
    }

    fn kernel(&mut self, view: View<D>, kernel: Kernel, abs_scale: Option<f64>) -> Outcome<D> {
        if kernel == Kernel::Square {
            return self.fit(view, Rule::Fixed(Weighting::SQUARES));
        }
        let near = self.narrow(view, kernel);
        if near.status == Status::Cancelled {
            return near;
        }
        let view = self.all_points(near);
        let base = view.base_weights(self.cloud, &self.problem.options.rejection);
        let size = self.cloud.diagonal * view.pose.scale;
        let limit = self.problem.options.limits[2] * size;
        let estimated = Rule::Estimated { kernel, limit, floor: NOISE_FLOOR * size };
        let scale = abs_scale.or_else(|| estimated.weighting(&mut view.distances(&base)).scale());
        let scale = scale.unwrap_or(limit);
        let rule = Rule::Fixed(Weighting::Kernel { kernel, scale });
        self.go(&self.stage("fit", self.cloud, rule), view)
    }

    fn automatic(&mut self, start: View<D>) -> Outcome<D> {
        let coarse = self.coarse.clone();
        let squares = Rule::Fixed(Weighting::SQUARES);
        let tolerance = if self.is_thinned() { COARSE } else { self.problem.options.tolerance };
        let stage = Stage { tolerance, ..self.stage("fit", &coarse, squares) };
        let plain = self.go(&stage, start.clone());
        if plain.status == Status::Cancelled {
            return plain;
        }
        let evidence = Evidence::of(&plain, &coarse);
        if evidence.suspicious() || !plain.status.is_converged() {
            let robust = self.narrow(start, Kernel::Tukey);
            if robust.status == Status::Cancelled {
                return robust;
            }
            let better = Evidence::of(&robust, &coarse);
            let worse_noise = if evidence.outliers > 0 { 1.05 } else { 0.5 };
            if better.sigma <= worse_noise * evidence.sigma || !plain.status.is_converged() {
                let view = self.all_points(robust);
                return self.cut(view);
            }
        }
        if !self.is_thinned() {
            return if evidence.outliers > 0 { self.cut(plain.view) } else { plain };
        }
        let view = self.all_points(plain);
        let fit = self.go(&self.stage("fit", self.cloud, squares), view);
        if fit.status == Status::Cancelled || Evidence::of(&fit, self.cloud).outliers == 0 {
            return fit;
        }
        self.cut(fit.view)
    }

    /// Least squares over the points within the noise, away from the boundary of the shape, where points of what lies
    /// beyond it have their feet. The noise is estimated again at the end.
    fn cut(&mut self, view: View<D>) -> Outcome<D> {
        let size = self.cloud.diagonal * view.pose.scale;
        let rejection = self.problem.options.rejection.with_boundary(true);
        let limit = |view: &View<D>| {
            let base = view.base_weights(self.cloud, &rejection);
            (CUT * Spread::of(&mut view.distances(&base), CUT).sigma).max(NOISE_FLOOR * size)
        };
        let mut view = view;
        let mut distance = limit(&view);
        let mut repetition = 0;
        loop {
            let rule = Rule::Fixed(Weighting::Cut { limit: distance });
            let stage = Stage { rejection, ..self.stage("inliers", self.cloud, rule) };
            let outcome = self.problem.run(&stage, view, &mut self.history);
            self.evaluations += outcome.evaluations;
            let next = limit(&outcome.view);
            if repetition == 3 || !outcome.status.is_converged() || (next - distance).abs() <= 0.02 * distance
            {
                return outcome;
            }
            (view, distance) = (outcome.view, next);
            repetition += 1;
        }
    }
}

/// What the distances at the end of a stage say about outliers.
#[derive(Clone, Copy, Debug)]
struct Evidence {
    /// Standard deviation of the noise.
    sigma: f64,
    /// Number of points that cannot be noise.
    outliers: usize,
    /// Whether the noise is large for the size of the cloud.
    noisy: bool,
}

impl Evidence {
    fn of<const D: usize>(outcome: &Outcome<D>, cloud: &Prepared<D>) -> Self {
        let distances = outcome.view.distances(&outcome.base);
        let sigma = Spread::of(&mut distances.clone(), CUT).sigma;
        let size = cloud.diagonal * outcome.view.pose.scale;
        let limit = IMPOSSIBLE * sigma.max(NOISE_FLOOR * size);
        let outliers = distances.iter().filter(|d| **d > limit).count();
        Self { sigma, outliers, noisy: sigma > NOISY * size }
    }

    fn suspicious(&self) -> bool {
        self.outliers > 0 || self.noisy
    }
}
