//! What is known at the end of a stage: how well the pose is determined, what is not, and what the points say about it.

use crate::constraint::{Chart, Freedom};
use crate::correlation::Correlation;
use crate::covariance::Residuals;
use crate::iterate::{Job, Outcome, fewest};
use crate::linearise::NormalSystem;
use crate::noise_fixed::noise_share;
use crate::one_sided;
use crate::solve::Scaled;
use crate::source::Prepared;
use crate::support::{Circumstances, Support};
use crate::view::Terms;
use crate::{Covariance, FreeMotion, Locks, Method, Velocity};
use nalgebra::DMatrix;

/// Share of growth in a motion below which it has none.
const GROWTH: f64 = 1e-6;

/// What the tangent planes at the end of a stage fix.
struct Conditioning<const D: usize> {
    system: NormalSystem<D>,
    freedom: Freedom<D>,
    tangent: DMatrix<f64>,
    scaled: Scaled,
    length: f64,
    /// Share of the largest eigenvalue up to which a motion is free.
    tolerance: f64,
}

impl<const D: usize> Conditioning<D> {
    fn free_fields(&self) -> Vec<Velocity<D>> {
        self.scaled.free_steps().iter().map(|step| self.freedom.velocity(step)).collect()
    }
}

impl<const D: usize> Job<'_, D> {
    /// How well the pose at the end of a stage is determined, and the motions that are not.
    pub(crate) fn analyse(
        &self,
        outcome: &Outcome<D>,
        cloud: &Prepared<D>,
        rms: f64,
    ) -> (Option<Covariance<D>>, Vec<FreeMotion<D>>) {
        let Some(end) = self.conditioning(outcome, cloud) else { return (None, Vec::new()) };
        let origin = outcome.view.pose.target_origin;
        let named = FreeMotion::name_all(&end.free_fields(), &origin, end.length);
        let squares = rms * rms * end.system.weight;
        let residuals =
            Residuals { squares, unit: outcome.view.unit(), correlation: Correlation::of(outcome, cloud) };
        let Conditioning { system, freedom, tangent, scaled, .. } = &end;
        let covariance =
            Covariance::new(system, freedom, scaled, tangent, &residuals, self.options.scale, origin);
        (Some(covariance), named)
    }

    /// What the points that count say about the pose at the end of a stage.
    pub(crate) fn support(
        &self,
        outcome: &Outcome<D>,
        cloud: &Prepared<D>,
        rms: f64,
        has_free_motions: bool,
    ) -> Support {
        let unknowns = self.chart.freedom(&outcome.view.pose).count();
        let unlocked = self.options.locks.any().then(|| self.left_without_locks(outcome, cloud)).flatten();
        let model_size = self.options.scale.then(|| self.field.bounding_box().diagonal());
        Support::of(outcome, cloud, rms, &Circumstances { unknowns, has_free_motions, unlocked, model_size })
    }

    /// Share of the squared distances that would be left after a step without locks.
    fn left_without_locks(&self, outcome: &Outcome<D>, cloud: &Prepared<D>) -> Option<f64> {
        let terms = Terms { term: Method::TANGENT.term(), taylor: false, symmetric: false };
        let view = &outcome.view;
        let system = view.system(cloud, &outcome.base, &outcome.weighting, &terms);
        if system.squares.is_nan() || system.squares <= 0.0 || !view.pose.is_finite() {
            return None;
        }
        let free = Chart::new(Locks::default(), self.options.scale, view.pose).freedom(&view.pose);
        let (tangent, vector) = (free.reduce(&system.tangent), free.reduce_vector(&system.vector));
        let length = cloud.diagonal * view.pose.scale * 0.5;
        let scaled = Scaled::new(&tangent, &free.is_translation, length, self.options.null_tolerance);
        let step = scaled.step(&scaled.spectrum(&tangent, &vector), 0.0);
        Some((1.0 + vector.dot(&step) / system.squares).clamp(0.0, 1.0))
    }

    /// Whether the scale is not determined at the end of a stage, as by points of a plane.
    pub(crate) fn leaves_scale_free(&self, outcome: &Outcome<D>, cloud: &Prepared<D>) -> bool {
        let size = outcome.view.size(cloud) * outcome.view.unit();
        let grows = |v: &Velocity<D>| {
            let others = v.rotation.norm() + v.translation.norm() / size;
            v.growth.abs() > GROWTH * (v.growth.abs() + others)
        };
        self.free_fields(outcome, cloud).0.iter().any(grows)
    }

    /// The velocity fields of the motions that are not determined at the end of a stage, and the share of the largest eigenvalue up to
    /// which that is so.
    pub(crate) fn free_fields(&self, outcome: &Outcome<D>, cloud: &Prepared<D>) -> (Vec<Velocity<D>>, f64) {
        let end = self.conditioning(outcome, cloud);
        end.map_or_else(|| (Vec::new(), 0.0), |end| (end.free_fields(), end.tolerance))
    }

    fn conditioning(&self, outcome: &Outcome<D>, cloud: &Prepared<D>) -> Option<Conditioning<D>> {
        let terms = Terms { term: Method::TANGENT.term(), taylor: false, symmetric: false };
        let view = &outcome.view;
        let system = view.system(cloud, &outcome.base, &outcome.weighting, &terms);
        if system.count < fewest(D) || !view.pose.is_finite() {
            return None;
        }
        let freedom = self.chart.freedom(&view.pose);
        let mut tangent = freedom.reduce(&system.tangent);
        let length = cloud.diagonal * view.pose.scale * 0.5;
        let given = self.options.null_tolerance;
        let scaled = Scaled::new(&tangent, &freedom.is_translation, length, given);
        let ends = (length, given);
        if let Some(other) = one_sided::without(outcome, cloud, &freedom, &terms, (&tangent, &scaled), ends) {
            tangent = other;
        }
        let at = |tolerance: f64| Scaled::new(&tangent, &freedom.is_translation, length, tolerance);
        let mut tolerance = self.options.null_tolerance;
        let mut scaled = at(tolerance);
        if self.field.has_estimated_normals() {
            let share = noise_share(outcome, cloud, &freedom, &scaled);
            if share > tolerance {
                (tolerance, scaled) = (share, at(share));
            }
        }
        Some(Conditioning { system, freedom, tangent, scaled, length, tolerance })
    }
}
