//! The starts of a registration: tried with some of the points, ranked, and the best followed with all.

use crate::error::Error;
use crate::planar_start;
use crate::progress::Progress;
use crate::registering::{Cloud, Job};
use crate::registration_elsewhere::{self as elsewhere, Elsewhere, Look};
use crate::registration_field::{Extent, Fit, RegistrationField};
use crate::registration_model::RegistrationModel;
use crate::registration_report::StartResult;
use crate::registration_sight::Sights;
use crate::registration_verdict as verdict;
use crate::wording::counted;
use industrial_geometry::mesh::nalgebra::Vector3;
use industrial_geometry::register::start::{CoarseStart, OrientedPoints, StartCandidate, StartOptions};
use industrial_geometry::register::{
    Error as RegisterError, Pose, RegisterReport, Rejection, Source, StepRecord,
};
use std::time::Instant;

/// Share of the points near the model above which the given start is good enough.
const GOOD_SHARE: f64 = 0.9;
/// Candidates of a search over all positions from which the registration is run.
const CANDIDATES: usize = 3;
/// Share of a cloud that lies on another one exactly, from which clouds are compared by it.
const LEAST_OVERLAP: f64 = 0.06;
/// The same of a known position from which others are tried with few points first, and the part of it below which they are hopeless.
const MUCH_OVERLAP: f64 = 0.15;
const HOPELESS: f64 = 0.5;
/// Root mean square displacement, as a share of the size of the model, up to which two positions are one, and points that tell.
const SAME: f64 = 0.01;
const COMPARED: usize = 200;
/// Share of a cloud near the other one in the best position below which they have little in common; the tolerance, as a share of the
/// size of the model, by which is judged what fits exactly.
const LITTLE: f64 = 0.8;
const EXACT: f64 = 0.004;

/// The starts that were tried.
pub(crate) struct Tries<'a> {
    job: &'a Job<'a>,
    model: &'a RegistrationModel,
    field: &'a RegistrationField,
    cloud: &'a Cloud<'a>,
    sights: &'a Sights,
    progress: &'a Progress,
    pub(crate) list: Vec<Try>,
}

/// A start and where it led.
pub(crate) struct Try {
    pub(crate) origin: &'static str,
    pub(crate) start: Pose<3>,
    pub(crate) result: RegisterReport<3>,
    fit: Fit,
    /// Whether points float in front of what a scan saw through them.
    floats: bool,
    seconds: f64,
    /// Whether all points were registered.
    pub(crate) is_complete: bool,
}

impl Try {
    fn is_good(&self) -> bool {
        self.result.is_converged() && !self.floats && self.fit.near >= GOOD_SHARE
    }

    pub(crate) fn summary(&self) -> StartResult {
        StartResult::new(self.origin, &self.start, &self.result, &self.fit, self.seconds)
    }
}

impl<'a> Tries<'a> {
    pub(crate) fn new(
        job: &'a Job<'a>,
        model: &'a RegistrationModel,
        field: &'a RegistrationField,
        cloud: &'a Cloud<'a>,
        sights: &'a Sights,
        progress: &'a Progress,
    ) -> Self {
        Self { job, model, field, cloud, sights, progress, list: Vec::new() }
    }

    pub(crate) fn add(&mut self, origin: &'static str, start: &Pose<3>, extent: Extent) -> Result<(), Error> {
        let tried = self.attempt(origin, start, extent)?;
        self.list.push(tried);
        Ok(())
    }

    fn attempt(&self, origin: &'static str, start: &Pose<3>, extent: Extent) -> Result<Try, Error> {
        let began = Instant::now();
        let Self { job, field, cloud, progress, .. } = self;
        let some = match extent {
            Extent::All => None,
            Extent::Some | Extent::Few => register(job, field, cloud, start, extent, progress)?,
        };
        let is_complete = some.is_none();
        let result = match some {
            Some(result) => result,
            None => register_all(job, field, cloud, start, progress)?,
        };
        let result = verdict::flat(self.model, &cloud.positions, result);
        let fit = field.compare(&cloud.positions, &result.pose, job.options.scale);
        let floats = self.sights.contradiction(&result.pose).is_some();
        let seconds = began.elapsed().as_secs_f64();
        Ok(Try { origin, start: *start, result, fit, floats, seconds, is_complete })
    }

    /// Which other positions are to be looked at after an end: none where degrees of freedom are locked.
    fn look_after(&self, result: &RegisterReport<3>) -> Look {
        let is_on_cloud = matches!(self.model, RegistrationModel::Cloud(_));
        if self.job.options.locks.any() || !result.is_converged() {
            Look::Nowhere
        } else {
            Look::after(result, is_on_cloud)
        }
    }

    /// Whether not all positions need be searched.
    pub(crate) fn is_good(&self, one: &Try) -> bool {
        one.is_good() && self.look_after(&one.result) < Look::Everywhere
    }

    /// Where a search over all positions would start, none if there is none.
    pub(crate) fn search(&self) -> Result<Vec<Pose<3>>, Error> {
        let Self { job, model, field, cloud, progress, .. } = self;
        if matches!(model, RegistrationModel::Curves(_)) {
            Ok(Vec::new())
        } else if model.is_planar() {
            Ok(planar_start::poses(field, &cloud.positions, job.options.scale))
        } else {
            search_space(job, model, field, cloud, progress)
        }
    }

    fn beside(&self, end: &RegisterReport<3>) -> Vec<Pose<3>> {
        elsewhere::beside(&self.cloud.positions, end, self.model.is_planar())
    }

    /// Registers from positions beside the best end as well, if that leaves much unexplained.
    pub(crate) fn add_beside(&mut self) -> Result<(), Error> {
        let best = self.best().filter(|best| self.look_after(&best.result) >= Look::Beside);
        let starts = best.map_or_else(Vec::new, |best| self.beside(&best.result));
        for start in &starts {
            self.add("search", start, Extent::Some)?;
        }
        Ok(())
    }

    /// A position in which the points fit distinctly better than at an end that leaves much unexplained, or, if `at_all`, better.
    pub(crate) fn better_than(
        &self,
        end: &RegisterReport<3>,
        at_all: bool,
    ) -> Result<Option<Elsewhere>, Error> {
        let look = self.look_after(end);
        if look == Look::Nowhere {
            return Ok(None);
        }
        let beside = self.elsewhere(&end.pose, &self.beside(end), at_all)?;
        if beside.is_some() || look == Look::Beside {
            return Ok(beside);
        }
        self.elsewhere(&end.pose, &self.search()?, at_all)
    }

    /// Where some of the starts lead, if the points fit distinctly better there than at an end.
    fn elsewhere(&self, end: &Pose<3>, starts: &[Pose<3>], at_all: bool) -> Result<Option<Elsewhere>, Error> {
        let of = |pose: &Pose<3>| self.field.compare(&self.cloud.positions, pose, self.job.options.scale);
        let own = of(end);
        for start in starts {
            let there = self.attempt("search", start, Extent::Few)?;
            let least = own.overlap.max(there.fit.overlap);
            let by_overlap = matches!(self.model, RegistrationModel::Cloud(_)) && least >= LEAST_OVERLAP;
            let is_better = elsewhere::is_better(&there.fit, &own, by_overlap, at_all);
            if is_better && there.result.is_converged() && !there.floats {
                let turn = end.inverse().followed_by(&there.result.pose);
                let angle = turn.rotation_vector().norm();
                return Ok(Some(Elsewhere { fits: [own, there.fit], angle, by_overlap }));
            }
        }
        Ok(None)
    }

    /// Registers from a position that a search found, unless that leads to where another start led, and with few points first where
    /// a better one is known: most positions turn out hopeless with those.
    pub(crate) fn add_found(&mut self, start: &Pose<3>) -> Result<(), Error> {
        let is_known = self.list.iter().any(|one| {
            let has_led = one.origin == "search" || one.result.is_converged();
            has_led && (self.is_same(&one.start, start) || self.is_same(&one.result.pose, start))
        });
        if is_known {
            return Ok(());
        }
        let known = self.best().filter(|best| best.result.is_converged() && !best.floats);
        let known = known.filter(|_| self.is_by_overlap()).map(|best| best.fit.overlap);
        if let Some(overlap) = known.filter(|overlap| *overlap >= MUCH_OVERLAP) {
            self.add("search", start, Extent::Few)?;
            let is_hopeless = self.list.last().is_some_and(|few| few.fit.overlap < HOPELESS * overlap);
            if is_hopeless {
                return Ok(());
            }
            self.list.pop();
        }
        self.add("search", start, Extent::Some)
    }

    /// Whether two poses take the points to nearly the same places.
    fn is_same(&self, one: &Pose<3>, other: &Pose<3>) -> bool {
        let points = &self.cloud.positions;
        let step = points.len().div_ceil(COMPARED).max(1);
        let finite = points.iter().step_by(step).filter(|x| x.iter().all(|c| c.is_finite()));
        let (sum, count) = finite.fold((0.0, 0.0), |(sum, count), x| {
            (sum + (one.apply(x) - other.apply(x)).norm_squared(), count + 1.0)
        });
        sum <= (SAME * self.field.diagonal()).powi(2) * count
    }

    pub(crate) fn last_is_good(&self) -> bool {
        self.list.last().is_some_and(|last| self.is_good(last))
    }

    /// The start whose result fits best, of those that converged if any did; the first of equals.
    ///
    /// Clouds need not have much in common: there the share that lies on the other one beyond what chance explains decides, as long as
    /// any has enough of it.
    pub(crate) fn best_index(&self) -> Option<usize> {
        let by_overlap = self.is_by_overlap();
        let rank = |one: &Try| {
            let cost = if by_overlap { -one.fit.overlap } else { one.fit.score };
            (!one.result.is_converged(), one.floats, cost)
        };
        (0..self.list.len()).reduce(
            |best, i| {
                if rank(&self.list[i]) < rank(&self.list[best]) { i } else { best }
            },
        )
    }

    /// Whether starts are compared by what lies on the model beyond chance.
    fn is_by_overlap(&self) -> bool {
        let most = self.list.iter().map(|one| one.fit.overlap).fold(0.0, f64::max);
        matches!(self.model, RegistrationModel::Cloud(_)) && most >= LEAST_OVERLAP
    }

    pub(crate) fn best(&self) -> Option<&Try> {
        self.best_index().map(|best| &self.list[best])
    }

    /// Registers all points from the best start; and from the next best where that was not the best after all.
    pub(crate) fn complete(&mut self) -> Result<(), Error> {
        while let Some(best) = self.best_index().filter(|&best| !self.list[best].is_complete) {
            let Try { origin, start, seconds, .. } = self.list[best];
            self.add(origin, &start, Extent::All)?;
            let mut whole = self.list.swap_remove(self.list.len() - 1);
            whole.seconds += seconds;
            self.list[best] = whole;
        }
        Ok(())
    }
}

/// The best of all positions in space.
fn search_space(
    job: &Job<'_>,
    model: &RegistrationModel,
    field: &RegistrationField,
    cloud: &Cloud<'_>,
    progress: &Progress,
) -> Result<Vec<Pose<3>>, Error> {
    // The search knows one scale: where it is unknown, that by the sizes.
    let growth = if job.options.scale { field.relative_size(&cloud.positions) } else { 1.0 };
    let grown: Vec<Vector3<f64>> = cloud.positions.iter().map(|x| x * growth).collect();
    let failed =
        |error: RegisterError| Error::content(job.points, error.to_string(), "check it with `indgeo info`");
    let oriented = match cloud.normals {
        Some(normals) => OrientedPoints::new(&grown, normals),
        None => OrientedPoints::without_normals(&grown),
    };
    let oriented = oriented.map_err(failed)?;
    let tell = |done: usize, total: usize| progress.part("searching all positions", done, total);
    let samples = model.samples(job.model)?;
    let options = StartOptions::default();
    let start = CoarseStart::new(&samples, &options).map_err(failed)?;
    let search = start.look(&oriented, &tell).map_err(failed)?;
    let found = search.report(options.tolerance).map_err(failed)?;
    let mut poses: Vec<Pose<3>> =
        found.candidates.iter().take(CANDIDATES).map(|candidate| candidate.pose).collect();
    // Clouds with little in common fit roughly in many ways: what fits exactly comes first.
    let is_little = found.best().is_none_or(|best| best.share < LITTLE);
    if matches!(model, RegistrationModel::Cloud(_)) && is_little {
        let mut found = search.report(EXACT).map_err(failed)?;
        let excess = |candidate: &StartCandidate| candidate.excess(found.tolerance);
        found.candidates.sort_by(|a, b| excess(b).total_cmp(&excess(a)));
        poses.splice(0..0, found.candidates.iter().take(CANDIDATES).map(|candidate| candidate.pose));
    }
    let back = |pose: Pose<3>| Pose {
        scale: pose.scale * growth,
        source_origin: pose.source_origin / growth,
        ..pose
    };
    Ok(poses.into_iter().map(back).collect())
}

pub(crate) fn register_all(
    job: &Job<'_>,
    field: &RegistrationField,
    cloud: &Cloud<'_>,
    start: &Pose<3>,
    progress: &Progress,
) -> Result<RegisterReport<3>, Error> {
    let found = register(job, field, cloud, start, Extent::All, progress)?;
    found.ok_or_else(|| Error::content(job.points, "there are no points", "check it with `indgeo info`"))
}

/// The registration of as many points as tell whether a position is worth while.
pub(crate) fn register_few(
    job: &Job<'_>,
    field: &RegistrationField,
    cloud: &Cloud<'_>,
    start: &Pose<3>,
    progress: &Progress,
) -> Result<RegisterReport<3>, Error> {
    match register(job, field, cloud, start, Extent::Few, progress)? {
        Some(report) => Ok(report),
        None => register_all(job, field, cloud, start, progress),
    }
}

fn register(
    job: &Job<'_>,
    field: &RegistrationField,
    cloud: &Cloud<'_>,
    start: &Pose<3>,
    extent: Extent,
    progress: &Progress,
) -> Result<Option<RegisterReport<3>>, Error> {
    progress.begin();
    let most = job.options.max_iterations;
    let tell = |step: &StepRecord| {
        progress.next_iteration(most, &format!("{}, rms {:.3e}", counted(step.points, "point"), step.rms))
    };
    let mut options = job.options;
    if let Some(angle) = job.max_angle {
        options.rejection =
            Rejection { oriented_normals: true, ..options.rejection.with_normal_angle(angle) };
    }
    let source =
        Source { points: &cloud.positions, normals: cloud.normals, weights: cloud.weights.as_deref() };
    field.register(&source, start, &options, extent, &tell).map_err(|error| match error {
        RegisterError::Option { name, value, allowed } => {
            Error::option(name, value, allowed, "see `indgeo register --help`")
        }
        other => Error::content(job.points, other.to_string(), "check it with `indgeo info`"),
    })
}
