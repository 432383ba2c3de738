//! A short registration on the grid of samples: enough to tell a good placement from a bad one.

use nalgebra::{Matrix6, Vector3, Vector6};

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
    mut placement: Placement,
    scorer: &Scorer,
    cloud: &OrientedPoints,
    count: usize,
    finest: f64,
) -> Placement {
    let (mut step_count, mut limit, mut rounds, mut finest) = (0, LIMITS[0], 0, finest);
    while rounds < ROUNDS {
        let (matrix, rhs) = normal_equations(&placement, scorer, cloud, count, limit);
        let Some((step, size)) = solve(matrix, &rhs) else { return placement };
        placement = placement.moved(step.fixed_rows::<3>(0).into(), step.fixed_rows::<3>(3).into());
        if limit <= finest {
            rounds += 1;
            if size < 1e-6 {
                break;
            }
        }
        step_count += 1;
        if step_count == LIMITS.len() {
            finest =
                finest.max(OUTLYING * scorer.spread(&placement, cloud, count)).min(LIMITS[LIMITS.len() - 1]);
        }
        limit = LIMITS.get(step_count).copied().unwrap_or(limit * SHRINK).max(finest);
    }
    placement
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
