//! The stages of a registration in their order: coarse points before all, wide limits before narrow ones.

use crate::evidence::{CUT, Evidence, Nearness, noise_floor};
use crate::iterate::{History, Job, Outcome, Stage};
use crate::slide_back::slide_back;
use crate::source::Prepared;
use crate::view::View;
use crate::weights::{Kernel, Outliers, Rejection, Rule, Weighting};
use crate::{Method, Pose, RegisterStep, Status};
use distance_field::Spread;
use std::rc::Rc;

/// What may be left of the motion in a stage that only has to come near, as a share of the size of the cloud.
const COARSE: f64 = 1e-4;
/// The same while the limit of the distance is narrowed.
const NARROWING: f64 = 3e-3;
/// Steps for each limit.
const NARROWING_STEPS: usize = 6;
/// Share of the largest eigenvalue up to which a motion is not made after the cloud was moved back along the free ones.
const HARDLY_FIXED: f64 = 1e-5;
/// By what share the cloud may fit worse there, with fewer points.
const NO_WORSE: f64 = 0.1;
/// Fewest points for which it pays to sort them by their feet: many of them need one step alone.
const SORTED: usize = 300_000;
/// Most repetitions of the last stage with another set of inliers, and the share of the points up to which it is the same.
const REPETITIONS: usize = 3;
const SAME_SET: f64 = 2e-3;

/// A way to narrow the limit of the distance.
#[derive(Clone, Copy, Debug)]
struct Way {
    /// From which limit on points beyond the boundary are left out.
    boundary_from: usize,
    /// Whether only points count whose normals are those of the model, more or less.
    facing: bool,
}

/// Largest angle between normals of points and feet that belong together, radians.
const FACING: f64 = 0.8;

/// Rules with a limit for the angle between normals, if none is given.
fn facing_only(rejection: Rejection, facing: bool) -> Rejection {
    if facing && rejection.normal_angle.is_none() { rejection.with_normal_angle(FACING) } else { rejection }
}

/// How a registration ends.
#[derive(Clone, Copy, Debug)]
enum Last {
    /// With a rule for the weights of all points.
    Fit(Rule),
    /// With the inliers alone.
    Cut,
}

/// The stages of one registration and what they did.
pub(crate) struct Plan<'a, const D: usize> {
    job: &'a Job<'a, D>,
    cloud: Rc<Prepared<D>>,
    /// Some of the points; all of them where they are few.
    coarse: Rc<Prepared<D>>,
    /// Share of the largest eigenvalue up to which a motion is not made.
    null_tolerance: f64,
    /// Whether little of the cloud lies on the shape, so that what lies near it otherwise has to be told by its normals.
    facing: bool,
    /// The rule of the last stage.
    last: Last,
    pub(crate) history: History,
    pub(crate) evaluations: usize,
    /// Whether the cloud is a part of the points, by which a start is judged.
    is_part: bool,
    /// Whether the limit is narrowed in the first two ways alone.
    is_quick: bool,
}

impl<'a, const D: usize> Plan<'a, D> {
    pub(crate) fn new(job: &'a Job<'a, D>, cloud: Prepared<D>) -> Self {
        let cloud = Rc::new(cloud);
        let coarse = cloud.coarse(job.options.coarse_points);
        let coarse = coarse.map_or_else(|| Rc::clone(&cloud), Rc::new);
        let null_tolerance = job.options.null_tolerance;
        let last = Last::Fit(Rule::Fixed(Weighting::SQUARES));
        Self {
            job,
            cloud,
            coarse,
            null_tolerance,
            facing: false,
            last,
            history: History::new(),
            evaluations: 0,
            is_part: false,
            is_quick: false,
        }
    }

    /// The same for a first look: of the ways to narrow the limit the first two.
    pub(crate) fn quick(self) -> Self {
        Self { is_part: true, is_quick: true, ..self }
    }

    /// The same after earlier steps, for all points or a part of them.
    pub(crate) fn after(self, steps: &[RegisterStep], is_part: bool) -> Self {
        Self { history: steps.to_vec(), is_part, ..self }
    }

    /// The points of a view: a run that was cancelled ends with the coarse ones.
    pub(crate) fn seen_by(&self, view: &View<D>) -> &Prepared<D> {
        if view.frames.len() == self.cloud.points.len() { &self.cloud } else { &self.coarse }
    }

    fn is_thinned(&self) -> bool {
        !Rc::ptr_eq(&self.coarse, &self.cloud)
    }

    /// The coarse points in the starting pose.
    pub(crate) fn first_view(&mut self, start: Pose<D>) -> View<D> {
        self.evaluations += 1;
        self.job.view(&self.coarse, start)
    }

    /// All stages, from a view of the coarse points.
    pub(crate) fn run(&mut self, view: View<D>) -> Outcome<D> {
        let start = view.pose;
        let outcome = match self.job.options.outliers {
            Outliers::None => self.fit(view, Rule::Fixed(Weighting::SQUARES)),
            Outliers::Trimmed { outliers } => self.fit(view, Rule::Trimmed { outliers }),
            Outliers::Kernel { kernel, abs_scale } => self.kernel(view, kernel, abs_scale),
            Outliers::Automatic => self.automatic(view),
        };
        self.back_along_free_motions(outcome, &start)
    }

    /// Of the poses that the shape does not tell apart, the one nearest to the start.
    ///
    /// Before it is known which points count, and while the cloud is out of place, few points may fix a motion that the shape
    /// leaves free in the end, and carry the cloud far along it.
    fn back_along_free_motions(&mut self, outcome: Outcome<D>, start: &Pose<D>) -> Outcome<D> {
        // An outcome on the coarse points alone was cancelled.
        if !outcome.status.is_converged() || outcome.view.frames.len() != self.cloud.points.len() {
            return outcome;
        }
        let (fields, tolerance) = self.job.free_fields(&outcome, &self.cloud);
        let Some(pose) = slide_back(&self.cloud.points, &outcome.view.pose, start, &fields) else {
            return outcome;
        };
        let pose = self.job.chart.held(&pose);
        self.evaluations += 1;
        let view = self.job.view(&self.cloud, pose);
        // The motions that were undone are not made again.
        let given = self.null_tolerance;
        self.null_tolerance = given.max(HARDLY_FIXED).max(tolerance);
        let other = match self.last {
            Last::Fit(rule) => self.fit_all(view, rule),
            Last::Cut => self.cut(view),
        };
        self.null_tolerance = given;
        let [(rms, used), (others, left)] = [&outcome, &other].map(|o| o.view.rms(&o.base, &o.weighting));
        let as_good = others <= rms * (1.0 + NO_WORSE) && left as f64 >= used as f64 * (1.0 - NO_WORSE);
        // A cancelled run ends where it was.
        if other.status == Status::Cancelled || other.status.is_converged() && as_good {
            other
        } else {
            outcome
        }
    }

    /// A stage with the options' own settings.
    fn stage<'b>(&self, name: &'static str, cloud: &'b Prepared<D>, rule: Rule) -> Stage<'b, D> {
        let options = self.job.options;
        Stage {
            name,
            cloud,
            method: options.method,
            rule,
            rejection: options.rejection,
            holds_rejection: false,
            null_tolerance: self.null_tolerance,
            is_long: self.is_part,
            moving: 0.0,
            tolerance: options.tolerance,
            max_iterations: options.max_iterations,
        }
    }

    fn go(&mut self, stage: &Stage<'_, D>, view: View<D>) -> Outcome<D> {
        let outcome = self.job.run(stage, view, &mut self.history);
        self.evaluations += outcome.evaluations;
        outcome
    }

    /// The stage that fits all points by one rule.
    fn fit_all(&mut self, view: View<D>, rule: Rule) -> Outcome<D> {
        let cloud = Rc::clone(&self.cloud);
        let is_long = self.is_thinned() || self.is_part;
        self.go(&Stage { is_long, ..self.stage("fit", &cloud, rule) }, view)
    }

    /// From the coarse points to all of them.
    fn all_points(&mut self, outcome: Outcome<D>) -> View<D> {
        if !self.is_thinned() {
            return outcome.view;
        }
        self.evaluations += 1;
        let view = self.job.view(&self.cloud, outcome.view.pose);
        if self.cloud.points.len() < SORTED {
            return view;
        }
        let Some(order) = view.order_of_feet() else { return view };
        // From now on all points are looked at again and again: so what is kept of the shape is read from one end to the other.
        self.cloud = Rc::new(self.cloud.picked(&order));
        view.picked(&order)
    }

    /// One rule for all: the coarse points, then all.
    fn fit(&mut self, view: View<D>, rule: Rule) -> Outcome<D> {
        self.last = Last::Fit(rule);
        if !self.is_thinned() {
            return self.fit_all(view, rule);
        }
        let coarse = Rc::clone(&self.coarse);
        let near = self.go(&Stage { tolerance: COARSE, ..self.stage("coarse", &coarse, rule) }, view);
        if near.status == Status::Cancelled {
            return near;
        }
        let view = self.all_points(near);
        self.fit_all(view, rule)
    }

    /// The limits of the options, one after the other, and then the estimated noise, on the coarse points.
    ///
    /// Points beyond the boundary of the shape have their feet there and draw the cloud inwards. That is wrong where the
    /// shape is only a part of what was scanned, but leads back a cloud that has slid off the shape: they are left out from
    /// the limit with the index `boundary_from` on.
    fn narrow(&mut self, view: View<D>, kernel: Kernel, way: Way) -> Outcome<D> {
        let Way { boundary_from, facing } = way;
        let coarse =
            if facing { Rc::new(self.coarse.with_estimated_normals()) } else { Rc::clone(&self.coarse) };
        let size = view.size(&coarse);
        let mut view = view;
        let given = facing_only(self.job.options.rejection, facing);
        for (index, limit) in self.job.options.limits.into_iter().enumerate() {
            let rule = Rule::Fixed(Weighting::Kernel { kernel, scale: limit * size });
            let stage = Stage {
                method: Method::TANGENT,
                rejection: given.with_boundary(given.boundary || index >= boundary_from),
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
        let limit = self.job.options.limits[2] * size;
        let rule = Rule::Estimated { kernel, limit, floor: noise_floor(&view, &coarse) };
        let stage = Stage {
            rejection: given.with_boundary(true),
            moving: self.history.last().map_or(0.0, |step| step.motion),
            method: Method::TANGENT,
            tolerance: COARSE,
            max_iterations: 3 * NARROWING_STEPS,
            ..self.stage("narrow", &coarse, rule)
        };
        self.go(&stage, view)
    }

    /// The best of several ways to narrow the limit, by the support of all points: more ways are tried as long as less than
    /// a certain share of the points supports the best one.
    ///
    /// From the start with and without the points beyond the boundary, from where least squares over all points lead, and with those
    /// points alone that face the way of the model.
    fn narrow_well(&mut self, start: &View<D>, plain: Option<&View<D>>, kernel: Kernel) -> Outcome<D> {
        let mut best = self.narrow(start.clone(), kernel, Way { boundary_from: 0, facing: false });
        let mut support = Nearness::of(&best, &self.coarse);
        let ways = [(Some(start), 2, false), (plain, 0, false), (plain, 2, false), (Some(start), 0, true)];
        let ways = ways
            .into_iter()
            .filter_map(|(from, boundary_from, facing)| Some((from?, Way { boundary_from, facing })))
            .take(if self.is_quick { 1 } else { usize::MAX });
        for (from, way) in ways {
            if best.status == Status::Cancelled || support.is_enough() {
                break;
            }
            let other = self.narrow(from.clone(), kernel, way);
            let others = Nearness::of(&other, &self.coarse);
            if other.status == Status::Cancelled || others.cost < support.cost {
                (best, support) = (other, others);
            }
        }
        best
    }

    fn kernel(&mut self, view: View<D>, kernel: Kernel, abs_scale: Option<f64>) -> Outcome<D> {
        if kernel == Kernel::Square {
            return self.fit(view, Rule::Fixed(Weighting::SQUARES));
        }
        let near = self.narrow_well(&view, None, kernel);
        if near.status == Status::Cancelled {
            return near;
        }
        let view = self.all_points(near);
        let base = view.base_weights(&self.cloud, &self.job.options.rejection);
        let size = view.size(&self.cloud);
        let limit = self.job.options.limits[2] * size;
        let estimated = Rule::Estimated { kernel, limit, floor: noise_floor(&view, &self.cloud) };
        // The given one is in the unit of the model.
        let scale = abs_scale
            .map(|scale| scale / view.unit())
            .or_else(|| estimated.weighting(&mut view.distances(&base), 0.0).scale());
        let scale = scale.unwrap_or(limit);
        let rule = Rule::Fixed(Weighting::Kernel { kernel, scale });
        self.last = Last::Fit(rule);
        self.fit_all(view, rule)
    }

    fn automatic(&mut self, start: View<D>) -> Outcome<D> {
        let coarse = Rc::clone(&self.coarse);
        let squares = Rule::Fixed(Weighting::SQUARES);
        let tolerance = if self.is_thinned() { COARSE } else { self.job.options.tolerance };
        let stage = Stage { tolerance, ..self.stage("fit", &coarse, squares) };
        let plain = self.go(&stage, start.clone());
        if plain.status == Status::Cancelled {
            return plain;
        }
        let evidence = Evidence::of(&plain, &coarse);
        if evidence.suspicious() || !plain.status.is_converged() {
            let robust = self.narrow_well(&start, Some(&plain.view), Kernel::Tukey);
            if robust.status == Status::Cancelled {
                return robust;
            }
            let better = Evidence::of(&robust, &coarse);
            let worse_noise = if evidence.outliers > 0 { 1.05 } else { 0.5 };
            if better.sigma <= worse_noise * evidence.sigma || !plain.status.is_converged() {
                self.facing = !Nearness::of(&robust, &coarse).is_enough();
                let view = self.all_points(robust);
                return self.cut(view);
            }
        }
        if !self.is_thinned() {
            return if evidence.outliers > 0 { self.cut(plain.view) } else { plain };
        }
        let view = self.all_points(plain);
        let fit = self.fit_all(view, squares);
        if fit.status == Status::Cancelled || Evidence::of(&fit, &self.cloud).outliers == 0 {
            return fit;
        }
        self.cut(fit.view)
    }

    /// Least squares over the points within the noise, away from the boundary of the shape, where points of what lies
    /// beyond it have their feet. Which these are is held fast while the pose is improved, and judged again at the end, as
    /// is the noise.
    fn cut(&mut self, view: View<D>) -> Outcome<D> {
        self.last = Last::Cut;
        let rejection = facing_only(self.job.options.rejection, self.facing).with_boundary(true);
        if self.facing {
            self.cloud = Rc::new(self.cloud.with_estimated_normals());
        }
        let cloud = Rc::clone(&self.cloud);
        let judge = |view: &View<D>| {
            let base = view.base_weights(&cloud, &rejection);
            let sigma = Spread::of(&mut view.distances(&base), CUT).sigma;
            let limit = (CUT * sigma).max(noise_floor(view, &cloud));
            (base, limit)
        };
        let mut view = view;
        let (_, mut distance) = judge(&view);
        let mut repetition = 0;
        loop {
            let rule = Rule::Fixed(Weighting::Cut { limit: distance });
            let is_long = self.is_thinned() || self.is_part;
            let stage =
                Stage { rejection, holds_rejection: true, is_long, ..self.stage("inliers", &cloud, rule) };
            let outcome = self.job.run(&stage, view, &mut self.history);
            self.evaluations += outcome.evaluations;
            let (base, next) = judge(&outcome.view);
            let changed = base.iter().zip(&outcome.base).filter(|(a, b)| a != b).count();
            let same = (next - distance).abs() <= 0.02 * distance
                && changed as f64 <= SAME_SET * cloud.points.len() as f64;
            if repetition == REPETITIONS || !outcome.status.is_converged() || same {
                return outcome;
            }
            (view, distance) = (outcome.view, next);
            repetition += 1;
        }
    }
}
