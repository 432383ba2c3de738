//! The starts of a registration: tried with some of the points, ranked, and the best followed with all.

use crate::commands::register::approach::Approach;
use crate::commands::register::elsewhere::{self as elsewhere, Elsewhere, Look};
use crate::commands::register::field::{Extent, Fit, RegistrationField};
use crate::commands::register::model::RegistrationModel;
use crate::commands::register::request::{Cloud, Job};
use crate::commands::register::results::StartResult;
use crate::commands::register::runs::{register, register_few, register_whole, search_space};
use crate::commands::register::sight::Sights;
use crate::commands::register::{planar_start, verdict};
use crate::error::Error;
use crate::runtime::progress::Progress;
use industrial_geometry::mesh::nalgebra::Vector3;
use industrial_geometry::register::{Pose, RegisterReport};
use std::cmp::Ordering;
use std::time::Instant;

/// Share of the points near the model above which the given start is good enough.
const GOOD_SHARE: f64 = 0.9;
/// Share of a cloud that lies on another one exactly, from which clouds are compared by it.
const LEAST_OVERLAP: f64 = 0.06;
/// Overlap over that of another position from which the two do not differ by it, and score over the other's below which they differ by that.
const AS_MUCH: f64 = 0.9;
const AT_ALL: f64 = 0.9;
/// The same of a known position from which others are tried with few points first, and the part of it below which they are hopeless.
const MUCH_OVERLAP: f64 = 0.15;
const HOPELESS: f64 = 0.5;
/// Root mean square displacement, as a share of the size of the model, up to which two positions are one, and points that tell.
const SAME: f64 = 0.01;
const COMPARED: usize = 200;

/// The starts that were tried.
pub(crate) struct Tries<'a> {
    job: &'a Job<'a>,
    model: &'a RegistrationModel,
    field: &'a RegistrationField,
    cloud: &'a Cloud<'a>,
    sights: &'a Sights,
    progress: &'a Progress,
    approach: Option<Approach>,
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
    /// Share of the points that lie on the model, or are scattered off it.
    explained: f64,
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
    ) -> Result<Self, Error> {
        let approach = Approach::of(job, model, cloud)?;
        Ok(Self { job, model, field, cloud, sights, progress, approach, list: Vec::new() })
    }

    pub(crate) fn add(
        &mut self,
        origin: &'static str,
        start: &Pose<3>,
        extent: Extent<'_>,
    ) -> Result<(), Error> {
        let tried = self.attempt(origin, start, extent)?;
        self.list.push(tried);
        Ok(())
    }

    fn attempt(&self, origin: &'static str, start: &Pose<3>, extent: Extent<'_>) -> Result<Try, Error> {
        let began = Instant::now();
        let Self { job, field, cloud, progress, .. } = self;
        let given = start;
        // A search leads near the model itself.
        let approach = self.approach.as_ref().filter(|_| origin != "search");
        let start = &approach.map_or(Ok(*given), |approach| approach.from(given))?;
        let some = match extent {
            Extent::All | Extent::Rest(_) => None,
            Extent::Some | Extent::Few => register(job, field, cloud, start, extent, progress)?,
        };
        let is_complete = some.is_none();
        let result = match some {
            Some(result) => result,
            None => {
                let extent = if let Extent::Rest(_) = extent { extent } else { Extent::All };
                register_whole(job, field, cloud, start, extent, progress)?
            }
        };
        let result = verdict::flat(self.model, &cloud.positions, result);
        let fit = field.compare(&cloud.positions, &result.pose, job.options.scale);
        let floats = self.sights.contradiction(&result.pose).is_some();
        let explained = self.explained(&result);
        let seconds = began.elapsed().as_secs_f64();
        Ok(Try { origin, start: *given, result, fit, floats, explained, seconds, is_complete })
    }

    /// Share of the points that lie on the model at an end, or are scattered off it: what is left out, but shows a surface, may belong to the
    /// model in another position.
    fn explained(&self, result: &RegisterReport<3>) -> f64 {
        let share = result.support.share;
        let limit = result.limit.filter(|_| share < elsewhere::LEFT_OUT && result.pose.is_finite());
        let left_out = |limit| self.field.surface_left_out(&self.cloud.positions, &result.pose, limit);
        limit.and_then(left_out).map_or(share, |left_out| share.max(1.0 - left_out))
    }

    /// Which other positions are to be looked at after an end: none where degrees of freedom are locked.
    fn look_after(&self, result: &RegisterReport<3>, explained: f64) -> Look {
        let is_on_cloud = matches!(self.model, RegistrationModel::Cloud(_));
        if self.job.options.locks.any() || !result.is_converged() {
            Look::Nowhere
        } else {
            Look::after(result, explained, is_on_cloud)
        }
    }

    /// Whether not all positions need be searched.
    pub(crate) fn is_good(&self, one: &Try) -> bool {
        one.is_good() && self.look_after(&one.result, one.explained) < Look::Everywhere
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
        let Self { cloud, field, .. } = self;
        let mut starts = elsewhere::beside(&cloud.positions, end, self.model.is_planar());
        if matches!(self.model, RegistrationModel::Cloud(_)) {
            starts.retain(|start| elsewhere::lies_roughly(field, [&cloud.positions; 2], &end.pose, start));
        }
        starts
    }

    /// Registers from positions beside the best end as well, if that leaves much unexplained.
    pub(crate) fn add_beside(&mut self) -> Result<(), Error> {
        let best = self.best().filter(|best| self.look_after(&best.result, best.explained) >= Look::Beside);
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
        let look = self.look_after(end, self.explained(end));
        if look == Look::Nowhere {
            return Ok(None);
        }
        let beside = self.elsewhere(&end.pose, &self.beside(end), at_all)?;
        if beside.is_some() || look == Look::Beside {
            return Ok(beside);
        }
        self.elsewhere(&end.pose, &self.search()?, at_all)
    }

    /// How much better the mirror image of the points fits than they do at an end that leaves much unexplained, if it does distinctly.
    pub(crate) fn better_mirrored(&self, end: &RegisterReport<3>) -> Result<Option<Elsewhere>, Error> {
        if !end.is_converged()
            || !elsewhere::may_be_mirrored(end, self.explained(end))
            || self.job.options.locks.any()
        {
            return Ok(None);
        }
        let Self { job, field, cloud, progress, .. } = self;
        let own = field.compare(&cloud.positions, &end.pose, job.options.scale);
        for (positions, across) in
            elsewhere::mirror_images(&cloud.positions, &end.pose, self.model.is_planar())
        {
            if matches!(self.model, RegistrationModel::Cloud(_))
                && !elsewhere::lies_roughly(
                    field,
                    [&cloud.positions, &positions],
                    &end.pose,
                    &Pose::identity(),
                )
            {
                continue;
            }
            let normals: Option<Vec<Vector3<f64>>> =
                cloud.normals.map(|all| all.iter().map(|n| across * end.pose.rotate(n)).collect());
            let image = Cloud { positions, normals: normals.as_deref(), weights: cloud.weights.clone() };
            let found = register_few(job, field, &image, &Pose::identity(), progress)?;
            let fit = field.compare(&image.positions, &found.pose, job.options.scale);
            if found.is_converged() && elsewhere::is_better(&fit, &own, false, false) {
                return Ok(Some(Elsewhere { fits: [own, fit], angle: 0.0, by_overlap: false }));
            }
        }
        Ok(None)
    }

    /// Whether other starts led to where about as many other points lie on the model.
    pub(crate) fn has_another_copy(&self, end: &Pose<3>) -> bool {
        let points = &self.cloud.positions;
        let here = self.field.near(points, end);
        let others = self.list.iter().filter(|one| one.result.is_converged() && one.fit.near < GOOD_SHARE);
        others
            .into_iter()
            .any(|one| elsewhere::is_another_copy(&here, &self.field.near(points, &one.result.pose)))
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
        let same = |pose: &Pose<3>| is_same(self.field, &self.cloud.positions, pose, start);
        let is_known = self.list.iter().any(|one| {
            let has_led = one.origin == "search" || one.result.is_converged();
            has_led && (same(&one.start) || same(&one.result.pose))
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

    pub(crate) fn last_is_good(&self) -> bool {
        self.list.last().is_some_and(|last| self.is_good(last))
    }

    /// The start whose result fits best, of those that converged if any did; the first of equals.
    ///
    /// Clouds need not have much in common: there the share that lies on the other one beyond what chance explains decides, as long as
    /// any has enough of it; where two have about the same, the distances of all points, by which the first one has to be beaten distinctly.
    pub(crate) fn best_index(&self) -> Option<usize> {
        let by_overlap = self.is_by_overlap();
        let rank = |one: &Try| (!one.result.is_converged(), one.floats);
        let is_better = |one: &Try, than: &Try| match rank(one).cmp(&rank(than)) {
            Ordering::Less => true,
            Ordering::Greater => false,
            Ordering::Equal if by_overlap => {
                let [more, less] =
                    [one.fit.overlap.max(than.fit.overlap), one.fit.overlap.min(than.fit.overlap)];
                if less >= AS_MUCH * more {
                    one.fit.score < AT_ALL * than.fit.score
                } else {
                    one.fit.overlap == more
                }
            }
            Ordering::Equal => one.fit.score < than.fit.score,
        };
        (0..self.list.len())
            .reduce(|best, i| if is_better(&self.list[i], &self.list[best]) { i } else { best })
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
            let Try { origin, ref start, ref result, seconds, .. } = self.list[best];
            let mut whole = self.attempt(origin, start, Extent::Rest(result))?;
            whole.seconds += seconds;
            self.list[best] = whole;
        }
        Ok(())
    }
}

/// Whether two poses take points to nearly the same places.
pub(crate) fn is_same(
    field: &RegistrationField,
    points: &[Vector3<f64>],
    one: &Pose<3>,
    other: &Pose<3>,
) -> bool {
    let step = points.len().div_ceil(COMPARED).max(1);
    let finite = points.iter().step_by(step).filter(|x| x.iter().all(|c| c.is_finite()));
    let (sum, count) = finite.fold((0.0, 0.0), |(sum, count), x| {
        (sum + (one.apply(x) - other.apply(x)).norm_squared(), count + 1.0)
    });
    sum <= (SAME * field.diagonal()).powi(2) * count
}
