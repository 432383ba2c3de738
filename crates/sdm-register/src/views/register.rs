//! The loop: match, solve, move, until nothing moves.

use footpoint::Progress;
use nalgebra::{Vector3, Vector6};
use nurbs_core::Aabb;
use sdm_core::{
    Controller, Problem, Status, StepControl, StepDirection, StepLimits, StepTaken, Stop, Trial, minimise,
};
use std::convert::Infallible;

use super::ViewsOptions;
use super::graph::components;
use super::matching::{Matches, Rules, find};
use super::report::{PairReport, ViewReport, ViewsReport, ViewsStatus, ViewsStep};
use super::system::System;
use super::view::{Prepared, View};
use crate::neighbourhood::own_noise;
use crate::source::too_large;
use crate::start::Placement;
use crate::{Error, Pose};

/// Fewest points of a view, and fewest matches that link two views.
const FEWEST: usize = 3;
const FEWEST_MATCHES: usize = 12;

/// Points per view while the poses are coarse, and the motion that ends this stage.
const COARSE_POINTS: usize = 400;
const COARSE_MOTION: f64 = 2e-4;

/// Motions below this share of the standard error of the mean distance are not worth another step.
const NEGLIGIBLE: f64 = 0.1;
/// Motion, in units of that error, and number of steps no longer, after which the iteration goes to and fro between other matches of the same
/// noise: far from the centre of what two views have in common, a pose is known to some of these units.
const WANDERING: (f64, usize) = (10.0, 10);
/// Share of the steps after which the coarse points have shown what they can.
const COARSE_STEPS: f64 = 0.4;

/// Root mean square distance of two views, as a share of their size and in units of their own noise, above which their places are doubted.
const DOUBTFUL: f64 = 0.005;
const DISAGREEING: f64 = 3.0;

/// Distances beyond this multiple of their median absolute value do not count (Tukey's constant times 1.48), and never
/// less than this share of the diagonal, the noise of rounding.
const OUTLYING: f64 = 4.685 * 1.4826;
const LEAST_LIMIT: f64 = 1e-12;

/// Registers views whose poses are known roughly: to a fraction of their size and some ten degrees.
///
/// The first view of every component of the graph of overlaps stays where it is. `progress` is told the number of steps and
/// their limit, and may cancel.
///
/// # Errors
/// [`Error::Input`] for a view with fewer than three usable points; [`Error::Length`] if there is not one pose per view;
/// [`Error::NotAMotion`] for a pose that is not finite or has a scale; [`Error::Option`].
pub fn register_views(
    views: &[View],
    poses: &[Pose<3>],
    options: &ViewsOptions,
    progress: Progress<'_>,
) -> Result<ViewsReport, Error> {
    options.validate()?;
    check(views)?;
    if poses.len() != views.len() {
        return Err(Error::Length { what: "poses", found: poses.len(), points: views.len() });
    }
    if poses.iter().any(|pose| !pose.is_finite() || pose.scale != 1.0) {
        return Err(Error::NotAMotion { deviation: f64::NAN });
    }
    let mut run = Run::new(views, poses, options)?;
    let status = run.iterate(progress);
    Ok(run.report(views, status))
}

pub(super) fn check(views: &[View]) -> Result<(), Error> {
    for (index, view) in views.iter().enumerate() {
        let name = || format!("view {index}");
        if let Some(error) = too_large(view.points()) {
            return Err(error.of(name()));
        }
        let found = view.points().len();
        if found < FEWEST {
            let error = Error::TooFewPoints { total: found + view.dropped(), finite: found, needed: FEWEST };
            return Err(error.of(name()));
        }
        if view.bounding_box().is_none_or(|bounds| bounds.diagonal() <= 0.0) {
            return Err(Error::Collinear { width: 0.0, length: 0.0 }.of(name()));
        }
    }
    if views.len() < 2 {
        return Err(
            Error::TooFewPoints { total: views.len(), finite: views.len(), needed: 2 }.of("list of views")
        );
    }
    Ok(())
}

/// The state of a registration, in a frame in which a view has the size 1.
struct Run<'a> {
    options: &'a ViewsOptions,
    views: Vec<Prepared>,
    centres: Vec<Vector3<f64>>,
    poses: Vec<Placement>,
    first: Vec<Placement>,
    centre: Vector3<f64>,
    scale: f64,
    /// Directed pairs that overlap.
    pairs: Vec<[usize; 2]>,
    components: Vec<Vec<usize>>,
    limit: f64,
    history: Vec<ViewsStep>,
}

impl<'a> Run<'a> {
    fn new(views: &[View], poses: &[Pose<3>], options: &'a ViewsOptions) -> Result<Self, Error> {
        let boxes: Vec<Aabb<3>> = views.iter().filter_map(View::bounding_box).collect();
        let mut diagonals: Vec<f64> = boxes.iter().map(Aabb::diagonal).collect();
        diagonals.sort_by(f64::total_cmp);
        let scale = diagonals[diagonals.len() / 2];
        let centres: Vec<Vector3<f64>> = boxes.iter().map(Aabb::centre).collect();
        let placed = poses.iter().zip(&centres).map(|(pose, centre)| pose.apply(centre));
        let centre = placed.sum::<Vector3<f64>>() / views.len() as f64;
        let mut prepared = Vec::with_capacity(views.len());
        for (index, (view, own)) in views.iter().zip(&centres).enumerate() {
            let seed = options.seed.wrapping_add(index as u64);
            let sample = options.points_per_view;
            prepared.push(Prepared::new(view, own, scale, options.neighbours, sample, seed)?);
        }
        let placement =
            |(pose, own): (&Pose<3>, &Vector3<f64>)| Placement::from_pose(pose, own, &centre, scale);
        let placements: Vec<Placement> = poses.iter().zip(&centres).map(placement).collect();
        Ok(Self {
            options,
            views: prepared,
            poses: placements.clone(),
            first: placements,
            centres,
            centre,
            scale,
            pairs: Vec::new(),
            components: Vec::new(),
            limit: options.max_distance,
            history: Vec::new(),
        })
    }

    fn iterate(&mut self, progress: Progress<'_>) -> ViewsStatus {
        self.link(COARSE_POINTS);
        if self.pairs.is_empty() {
            return ViewsStatus::NoOverlap;
        }
        let count = COARSE_POINTS.min(self.options.points_per_view);
        let limit = self.options.max_iterations;
        let mut steps = Steps { run: self, progress, count, wandering: 0, last: None };
        let Ok(status) =
            minimise(&mut steps, &mut Controller::new(StepControl::None, StepLimits::default()), limit);
        match (status, steps.last) {
            (Status::Converged, Some(system)) => self.verdict(&system),
            (Status::NoOverlap, _) => ViewsStatus::NoOverlap,
            (Status::Cancelled, _) => ViewsStatus::Cancelled,
            _ => ViewsStatus::MaxIterations,
        }
    }

    fn verdict(&self, system: &System) -> ViewsStatus {
        if self.components.len() > 1 {
            ViewsStatus::Disconnected
        } else if system.free_motions() > 0 {
            ViewsStatus::Underdetermined
        } else {
            ViewsStatus::Converged
        }
    }

    fn rules(&self, limit: f64) -> Rules {
        Rules { limit, cosine: self.options.max_angle.cos(), oriented: self.options.oriented }
    }

    /// Finds the pairs that overlap at the present poses.
    fn link(&mut self, count: usize) {
        let total = self.views.len();
        let near = |i: usize, j: usize| {
            let apart = (self.poses[i].shift - self.poses[j].shift).norm();
            apart <= self.views[i].radius + self.views[j].radius + self.limit
        };
        let mut tried = Vec::new();
        for i in 0..total {
            tried.extend((0..i).filter(|&j| near(i, j)).flat_map(|j| [[j, i], [i, j]]));
        }
        tried.sort_unstable();
        let rules = self.rules(self.limit);
        let found = find(&mut self.views, &self.poses, &tried, count, &rules);
        let share = |i: usize, j: usize| {
            let place = found.binary_search_by(|matches| matches.views.cmp(&[i, j]));
            place.map_or(0.0, |at| share_of(&found[at]))
        };
        let least = self.options.min_overlap;
        self.pairs = tried.iter().copied().filter(|&[i, j]| share(i, j).max(share(j, i)) >= least).collect();
        let enough = |pair: &[usize; 2]| {
            let [i, j] = *pair;
            let both = found.iter().filter(|matches| matches.views == [i, j] || matches.views == [j, i]);
            both.map(|matches| matches.list.len()).sum::<usize>() >= FEWEST_MATCHES
        };
        self.pairs.retain(enough);
        self.components = components(total, self.pairs.iter().copied());
    }

    fn held(&self) -> Vec<bool> {
        let mut held = vec![false; self.views.len()];
        for component in &self.components {
            held[component[0]] = true;
        }
        held
    }

    /// Where the centres of the views are.
    fn places(&self) -> Vec<Vector3<f64>> {
        self.poses.iter().map(|pose| pose.shift).collect()
    }

    fn report(mut self, views: &[View], status: ViewsStatus) -> ViewsReport {
        let count = self.options.points_per_view;
        let pairs = std::mem::take(&mut self.pairs);
        let (early, late) = (self.rules(self.options.max_distance), self.rules(self.limit.max(LEAST_LIMIT)));
        let before = find(&mut self.views, &self.first, &pairs, count, &early);
        let after = find(&mut self.views, &self.poses, &pairs, count, &late);
        let system = System::new(
            &after,
            &self.held(),
            self.places(),
            robust_limit(&after).unwrap_or(self.limit).max(LEAST_LIMIT),
        );
        let matched: usize = after.iter().map(|matches| matches.list.len()).sum();
        let known = status != ViewsStatus::NoOverlap && system.free_motions() == 0;
        let covariances = if known { system.covariances(matched) } else { None };
        let given = views;
        let reports = (0..views.len()).map(|index| ViewReport {
            pose: self.poses[index].to_pose(&self.centres[index], &self.centre, self.scale),
            // Twists in the scaled frame: translations are in units of the scale.
            covariance: covariances.as_ref().map(|all| {
                let unit = |i: usize| if i < 3 { 1.0 } else { self.scale };
                let block = all[index];
                nalgebra::Matrix6::from_fn(|i, j| block[(i, j)] * unit(i) * unit(j))
            }),
            component: self.components.iter().position(|members| members.contains(&index)).unwrap_or(0),
            dropped: views[index].dropped(),
        });
        let views = reports.collect();
        let of = |all: &[Matches], i: usize, j: usize| all.iter().find(|m| m.views == [i, j]).cloned();
        let pair_reports = pairs.iter().filter(|[i, j]| i < j).filter_map(|&[i, j]| {
            let (there, back) = (of(&after, i, j)?, of(&after, j, i)?);
            let (earlier_there, earlier_back) = (of(&before, i, j)?, of(&before, j, i)?);
            let rms_after = rms(&[&there, &back]) * self.scale;
            Some(PairReport {
                is_doubtful: is_doubtful([&given[i], &given[j]], rms_after),
                is_ambiguous: false,
                views: [i, j],
                overlap: [share_of(&there), share_of(&back)],
                count: there.list.len() + back.list.len(),
                rms_before: rms(&[&earlier_there, &earlier_back]) * self.scale,
                rms_after,
            })
        });
        let pairs: Vec<PairReport> = pair_reports.collect();
        let is_doubtful = status == ViewsStatus::Converged && pairs.iter().any(|pair| pair.is_doubtful);
        ViewsReport {
            status: if is_doubtful { ViewsStatus::Doubtful } else { status },
            pairs,
            views,
            components: self.components,
            centre: self.centre,
            rms: rms(&after.iter().collect::<Vec<_>>()) * self.scale,
            history: self.history,
        }
    }
}

/// The Gauss-Newton method in the motions of all views: whole steps, since matches change with each of them.
struct Steps<'r, 'a> {
    run: &'r mut Run<'a>,
    progress: Progress<'r>,
    /// Points per view.
    count: usize,
    /// Steps no longer than noise makes them.
    wandering: usize,
    /// The system of the last step.
    last: Option<System>,
}

/// Matches of the present poses, and what follows from them.
struct Linear {
    matched: usize,
    system: System,
    limit: f64,
}

/// The poses that a step leads to. Their cost is not known before points are matched again.
struct Moved {
    poses: Vec<Placement>,
    /// The largest motion of a point.
    motion: f64,
}

impl Trial for Moved {
    fn cost(&self) -> f64 {
        f64::NAN
    }
}

impl Problem for Steps<'_, '_> {
    type Linear = Linear;
    type Step = Vec<Vector6<f64>>;
    type Trial = Moved;
    type Error = Infallible;

    fn linearise(&mut self) -> Result<Linear, Stop<Infallible>> {
        let run = &mut *self.run;
        if (self.progress)(run.history.len(), run.options.max_iterations).is_break() {
            return Err(Stop::Ended(Status::Cancelled));
        }
        let rules = run.rules(run.limit.max(LEAST_LIMIT));
        let matches = find(&mut run.views, &run.poses, &run.pairs, self.count, &rules);
        let Some(limit) = robust_limit(&matches) else { return Err(Stop::Ended(Status::NoOverlap)) };
        let limit = limit.min(rules.limit);
        let system = System::new(&matches, &run.held(), run.places(), limit);
        Ok(Linear { matched: matches.iter().map(|pair| pair.list.len()).sum(), system, limit })
    }

    fn cost(&self, linear: &Linear) -> f64 {
        linear.system.cost
    }

    fn direction(&mut self, linear: &Linear, _: f64) -> Result<StepDirection<Self::Step>, Stop<Infallible>> {
        match linear.system.solve() {
            Some(twists) => Ok(StepDirection::along(twists, 0.0)),
            None => Err(Stop::Ended(Status::NoOverlap)),
        }
    }

    fn advance(
        &mut self,
        _: &Linear,
        twists: &Self::Step,
        factor: f64,
    ) -> Result<Option<Moved>, Stop<Infallible>> {
        let (mut poses, mut motion) = (Vec::with_capacity(twists.len()), 0.0f64);
        for ((view, pose), twist) in self.run.views.iter().zip(&self.run.poses).zip(twists) {
            let [rotation, translation] = [0, 3].map(|row| twist.fixed_rows::<3>(row) * factor);
            let next = pose.moved(rotation, translation);
            motion = motion.max((next.shift - pose.shift).norm() + rotation.norm() * view.radius);
            poses.push(next);
        }
        Ok(Some(Moved { poses, motion }))
    }

    fn accept(&mut self, linear: Linear, trial: Moved, _: StepTaken) -> Result<(), Stop<Infallible>> {
        let all = self.run.options.points_per_view;
        let run = &mut *self.run;
        let Linear { matched, system, limit } = linear;
        run.poses = trial.poses;
        run.history.push(ViewsStep {
            count: matched,
            rms: (system.cost / system.weight.max(f64::MIN_POSITIVE)).sqrt() * run.scale,
            limit: limit * run.scale,
            motion: trial.motion * run.scale,
        });
        // Later matches may be no farther than now: with a margin, since other points are matched after a motion.
        run.limit = run.limit.min((2.0 * limit).max(LEAST_LIMIT)).max(2.0 * trial.motion);
        let fine = self.count == all;
        let error = system.standard_error();
        self.wandering += usize::from(fine && trial.motion <= WANDERING.0 * error);
        let is_settled = trial.motion <= run.options.tolerance.max(NEGLIGIBLE * error);
        if fine && (is_settled || self.wandering >= WANDERING.1) {
            self.last = Some(system);
            return Err(Stop::Ended(Status::Converged));
        }
        let is_long = run.history.len() as f64 > COARSE_STEPS * run.options.max_iterations as f64;
        if !fine && (trial.motion <= COARSE_MOTION.max(error) || is_long) {
            self.count = all;
            run.link(all);
        }
        Ok(())
    }
}

/// Whether views that overlap are much farther apart than their own points explain.
fn is_doubtful(views: [&View; 2], rms: f64) -> bool {
    let size = |view: &View| view.bounding_box().map_or(0.0, |bounds| bounds.diagonal());
    let large = DOUBTFUL * size(views[0]).max(size(views[1]));
    let noise = |view: &View| own_noise(view.points()).unwrap_or(f64::INFINITY);
    rms > large && rms > DISAGREEING * noise(views[0]).max(noise(views[1]))
}

fn share_of(matches: &Matches) -> f64 {
    matches.list.len() as f64 / matches.tried.max(1) as f64
}

fn rms(matches: &[&Matches]) -> f64 {
    let count: usize = matches.iter().map(|pair| pair.list.len()).sum();
    let sum: f64 = matches.iter().flat_map(|pair| &pair.list).map(|found| found.distance.powi(2)).sum();
    (sum / count.max(1) as f64).sqrt()
}

/// The distance beyond which matches do not count; `None` without matches.
fn robust_limit(matches: &[Matches]) -> Option<f64> {
    let mut distances: Vec<f64> =
        matches.iter().flat_map(|pair| &pair.list).map(|m| m.distance.abs()).collect();
    if distances.is_empty() {
        return None;
    }
    let middle = distances.len() / 2;
    let (_, median, _) = distances.select_nth_unstable_by(middle, f64::total_cmp);
    Some((OUTLYING * *median).max(LEAST_LIMIT))
}
