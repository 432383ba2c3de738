//! A short registration on the grid of samples: enough to tell a good placement from a bad one.

use nalgebra::{Matrix6, Vector3, Vector6};
use sdm_core::{
    Controller, Problem, Status, StepControl, StepDirection, StepLimits, StepTaken, Stop, Trial, minimise,
};
use std::convert::Infallible;

use super::{OrientedPoints, placement::Placement, score::Scorer};

/// Eigenvalues of the normal matrix below this share of its mean count as free motions of the shape.
const FREE_SHARE: f64 = 3e-3;

/// Distance limits of the first steps; the later ones are smaller by this factor each, down to the finest.
const LIMITS: [f64; 7] = [0.06, 0.06, 0.06, 0.05, 0.05, 0.04, 0.04];
const SHRINK: f64 = 0.85;

/// Most steps at the finest limit.
const ROUNDS: usize = 3;

/// Distances beyond this multiple of their spread are outlying.
pub(crate) const OUTLYING: f64 = 3.0;

/// Gauss-Newton steps for distances to tangent planes with Tukey's weights, down to the distance limit `finest`, or to the
/// spread of the distances where the cloud deviates more from the model.
pub(crate) fn refine(
    placement: Placement,
    scorer: &Scorer,
    cloud: &OrientedPoints,
    count: usize,
    finest: f64,
) -> Placement {
    let mut descent =
        Descent { placement, scorer, cloud, count, finest, limit: LIMITS[0], steps: 0, rounds: 0 };
    let mut control = Controller::new(StepControl::None, StepLimits::default());
    let Ok(_) = minimise(&mut descent, &mut control, usize::MAX);
    descent.placement
}

/// Whole steps under a distance limit that becomes smaller.
struct Descent<'a> {
    placement: Placement,
    scorer: &'a Scorer,
    cloud: &'a OrientedPoints,
    /// How many of the points count.
    count: usize,
    finest: f64,
    limit: f64,
    steps: usize,
    /// Steps at the finest limit.
    rounds: usize,
}

/// The placement that a step leads to. The next step has another limit, and with it another cost.
struct Moved(Placement, f64);

impl Trial for Moved {
    fn cost(&self) -> f64 {
        f64::NAN
    }
}

impl Problem for Descent<'_> {
    type Linear = (Matrix6<f64>, Vector6<f64>);
    type Step = (Vector6<f64>, f64);
    type Trial = Moved;
    type Error = Infallible;

    fn linearise(&mut self) -> Result<Self::Linear, Stop<Infallible>> {
        Ok(normal_equations(&self.placement, self.scorer, self.cloud, self.count, self.limit))
    }

    fn cost(&self, _: &Self::Linear) -> f64 {
        f64::NAN
    }

    fn direction(
        &mut self,
        linear: &Self::Linear,
        _: f64,
    ) -> Result<StepDirection<Self::Step>, Stop<Infallible>> {
        match solve(linear.0, &linear.1) {
            Some(step) => Ok(StepDirection::along(step, 0.0)),
            None => Err(Stop::Ended(Status::Singular)),
        }
    }

    fn advance(
        &mut self,
        _: &Self::Linear,
        (step, size): &Self::Step,
        _: f64,
    ) -> Result<Option<Moved>, Stop<Infallible>> {
        let moved = self.placement.moved(step.fixed_rows::<3>(0).into(), step.fixed_rows::<3>(3).into());
        Ok(Some(Moved(moved, *size)))
    }

    fn accept(
        &mut self,
        _: Self::Linear,
        Moved(placement, size): Moved,
        _: StepTaken,
    ) -> Result<(), Stop<Infallible>> {
        self.placement = placement;
        if self.limit <= self.finest {
            self.rounds += 1;
            if size < 1e-6 || self.rounds == ROUNDS {
                return Err(Stop::Ended(Status::Converged));
            }
        }
        self.steps += 1;
        if self.steps == LIMITS.len() {
            let spread = self.scorer.spread(&self.placement, self.cloud, self.count);
            self.finest = self.finest.max(OUTLYING * spread).min(LIMITS[LIMITS.len() - 1]);
        }
        self.limit = LIMITS.get(self.steps).copied().unwrap_or(self.limit * SHRINK).max(self.finest);
        Ok(())
    }
}

/// Number of independent motions that the distances do not resist: 3 for a sphere, 0 for most shapes.
pub(crate) fn free_motions(
    placement: &Placement,
    scorer: &Scorer,
    cloud: &OrientedPoints,
    count: usize,
    limit: f64,
) -> usize {
    let (matrix, _) = normal_equations(placement, scorer, cloud, count, limit);
    let scale = matrix.trace() / 6.0;
    // Rotations about the centre of the model move its points by about a quarter of the diagonal at most, hence the scale.
    let units = Vector6::new(4.0, 4.0, 4.0, 1.0, 1.0, 1.0);
    let matrix = Matrix6::from_fn(|i, j| matrix[(i, j)] * units[i] * units[j]);
    matrix.symmetric_eigenvalues().iter().filter(|&&value| value <= FREE_SHARE * scale).count()
}

fn normal_equations(
    placement: &Placement,
    scorer: &Scorer,
    cloud: &OrientedPoints,
    count: usize,
    limit: f64,
) -> (Matrix6<f64>, Vector6<f64>) {
    let (mut matrix, mut rhs) = (Matrix6::zeros(), Vector6::zeros());
    let per_limit_sq = 1.0 / (limit * limit);
    for index in 0..count {
        let x: Vector3<f64> = placement.apply(&cloud.points()[index]);
        let Some(contact) = scorer.contact(&x, &(placement.rotation * cloud.normals()[index])) else {
            continue;
        };
        let inside = 1.0 - contact.distance_sq * per_limit_sq;
        if inside > 0.0 {
            // The arm of the foot, not of the point beside it: it vanishes where the shape slides along itself.
            let arm = contact.foot.cross(&contact.normal);
            let n = contact.normal;
            let row = Vector6::new(arm.x, arm.y, arm.z, n.x, n.y, n.z);
            let weighted = row * (inside * inside);
            matrix += weighted * row.transpose();
            rhs -= weighted * contact.height;
        }
    }
    (matrix, rhs)
}

/// The step and its largest component; slightly damped, so that motions the shape does not resist stay small.
fn solve(mut matrix: Matrix6<f64>, rhs: &Vector6<f64>) -> Option<(Vector6<f64>, f64)> {
    let damping = matrix.trace() * 1e-5;
    for i in 0..6 {
        matrix[(i, i)] += damping;
    }
    let mut step = matrix.cholesky()?.solve(rhs);
    let size = step.amax();
    if !size.is_finite() {
        return None;
    }
    if size > 0.3 {
        step *= 0.3 / size;
    }
    Some((step, size))
}
