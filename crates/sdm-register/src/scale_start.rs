//! Starts of an unknown scale, by the sizes of cloud and model.

use crate::Pose;
use crate::source::Prepared;
use nurbs_core::Aabb;

/// Scales over the ratio of the sizes that are tried: a scan may be a part of the model, or have more than the model.
const FACTORS: [f64; 9] = [1.0, 0.8, 1.25, 0.6, 0.45, 1.6, 0.33, 0.2, 2.2];

/// Poses to start from: the given one, and those which give the cloud about the size of the model, grown about the origin of the
/// coordinates (as other units do) and laid centre on centre.
pub(crate) fn poses<const D: usize>(bounds: &Aabb<D>, cloud: &Prepared<D>, start: &Pose<D>) -> Vec<Pose<D>> {
    let ratio = bounds.diagonal() / (cloud.diagonal * start.scale);
    let mut poses = vec![*start];
    if !(ratio.is_finite() && ratio > 0.0) {
        return poses;
    }
    for factor in FACTORS {
        let growth = ratio * factor;
        let about_origin =
            Pose { scale: start.scale * growth, target_origin: start.target_origin * growth, ..*start };
        let centred = Pose { target_origin: bounds.centre(), ..about_origin };
        // Where the two are nearly the same, one is enough.
        let apart = (about_origin.target_origin - centred.target_origin).norm();
        if apart <= bounds.diagonal() && apart > 0.05 * bounds.diagonal() {
            poses.push(about_origin);
        }
        poses.push(centred);
    }
    poses
}
