//! Back along the motions that a shape leaves free.

use crate::{Pose, Velocity};
use nalgebra::{DMatrix, DVector, SVector};

/// A change as a share of the size of the cloud for which it is worth to go back.
const WORTH: f64 = 1e-3;
/// Most steps; a helical motion of many turns needs some.
const STEPS: usize = 30;
/// Points that are looked at, about.
const SAMPLE: usize = 500;

/// The pose nearest to the start, in the least squares sense over the cloud, that is reached along velocity fields, which are
/// given with the origin of the pose; `None` where it is hardly nearer.
///
/// Gauss-Newton's method in the coefficients of the fields, which stay the same in the frame of the model while the cloud moves:
/// motions that carry a shape into itself do so from every place.
pub(crate) fn slide_back<const D: usize>(
    points: &[SVector<f64, D>],
    pose: &Pose<D>,
    start: &Pose<D>,
    fields: &[Velocity<D>],
) -> Option<Pose<D>> {
    if fields.is_empty() {
        return None;
    }
    let sample = || points.iter().step_by(points.len().div_ceil(SAMPLE).max(1));
    // Points are relative to the common origin of both poses in the source.
    let at = |pose: &Pose<D>, x: &SVector<f64, D>| pose.apply(&(x + pose.source_origin));
    let misfit = |pose: &Pose<D>| sample().map(|x| (at(start, x) - at(pose, x)).norm_squared()).sum::<f64>();
    let mut best = *pose;
    let first = misfit(pose);
    let mut least = first;
    for _ in 0..STEPS {
        let moved = best.target_origin - pose.target_origin;
        let here: Vec<Velocity<D>> = fields.iter().map(|field| field.about_origin(&moved)).collect();
        let n = here.len();
        let (mut matrix, mut right) = (DMatrix::zeros(n, n), DVector::zeros(n));
        for x in sample() {
            let now = at(&best, x);
            let towards = at(start, x) - now;
            let velocities: Vec<_> = here.iter().map(|v| v.at(&(now - best.target_origin))).collect();
            for (i, v) in velocities.iter().enumerate() {
                right[i] += v.dot(&towards);
                for (j, w) in velocities.iter().enumerate() {
                    matrix[(i, j)] += v.dot(w);
                }
            }
        }
        let Some(coefficients) = matrix.cholesky().map(|c| c.solve(&right)) else { break };
        let next = best.then(&combination(&here, &coefficients).helical());
        let left = misfit(&next);
        if left.is_nan() || left >= least * (1.0 - 1e-9) {
            break;
        }
        (best, least) = (next, left);
    }
    let sizes = sample().map(SVector::norm_squared).sum::<f64>() * pose.scale * pose.scale;
    (first - least > WORTH * WORTH * sizes).then_some(best)
}

fn combination<const D: usize>(fields: &[Velocity<D>], coefficients: &DVector<f64>) -> Velocity<D> {
    fields.iter().zip(coefficients.iter()).fold(Velocity::zero(), |sum, (v, &c)| Velocity {
        translation: sum.translation + v.translation * c,
        rotation: sum.rotation + v.rotation * c,
        growth: sum.growth + v.growth * c,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// A helical motion about an axis that does not meet the origin.
    fn helix() -> Velocity<3> {
        let axis = Vector3::new(0.6, 0.0, 0.8);
        Velocity {
            translation: axis * 0.3 - axis.cross(&Vector3::new(0.0, 2.0, 0.0)),
            rotation: axis,
            growth: 0.0,
        }
    }

    #[test]
    fn a_helical_motion_is_undone() {
        let points: Vec<_> = (0..700)
            .map(f64::from)
            .map(|t| Vector3::new((t * 0.37).sin(), (t * 0.73).cos(), (t * 0.11).sin() * 3.0))
            .collect();
        let start = Pose::new(nalgebra::Matrix3::identity(), Vector3::new(0.2, -0.1, 0.4));
        let away = (0..3).fold(start, |pose, _| {
            let here = helix().about_origin(&(pose.target_origin - start.target_origin));
            pose.then(&combination(&[here], &DVector::from_element(1, 0.8)).helical())
        });
        let field = helix().about_origin(&(away.target_origin - start.target_origin));
        let back = slide_back(&points, &away, &start, &[field]).unwrap();
        assert!((back.rotation - start.rotation).norm() < 1e-6, "{back:?}");
        assert!((back.target_origin - start.target_origin).norm() < 1e-6);
        assert!(slide_back(&points, &start, &start, &[helix()]).is_none());
        assert!(slide_back(&points, &away, &start, &[]).is_none());
    }
}
