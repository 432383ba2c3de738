//! Poses as the search handles them: a matrix and a shift, between frames in which the model has the size 1.

use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::Pose;
use crate::rotation::orthonormalized;

/// `x ↦ R x + t`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Placement {
    pub(crate) rotation: Matrix3<f64>,
    pub(crate) shift: Vector3<f64>,
}

impl Placement {
    #[inline]
    pub(crate) fn apply(&self, x: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * x + self.shift
    }

    /// The point that comes to lie at `x`.
    #[inline]
    pub(crate) fn apply_inverse(&self, x: &Vector3<f64>) -> Vector3<f64> {
        self.rotation.tr_mul(&(x - self.shift))
    }

    /// Root mean square displacement between two placements of a body with the given radius of inertia.
    pub(crate) fn distance(&self, other: &Self, radius: f64) -> f64 {
        // A random point of a body with equal moments is turned by R₁ − R₂ to a mean square of r²/3 · ‖R₁ − R₂‖².
        let turned = (self.rotation - other.rotation).norm_squared() * radius * radius / 3.0;
        ((self.shift - other.shift).norm_squared() + turned).sqrt()
    }

    /// The placement moved on by the rotation vector and the translation of a twist.
    pub(crate) fn moved(&self, rotation: Vector3<f64>, translation: Vector3<f64>) -> Self {
        let turn = Rotation3::from_scaled_axis(rotation);
        Self { rotation: turn.matrix() * self.rotation, shift: turn * self.shift + translation }
    }

    /// The pose between the files' frames, if the scaled ones are `(x − centre) / scale`.
    pub(crate) fn to_pose(
        self,
        cloud_centre: &Vector3<f64>,
        model_centre: &Vector3<f64>,
        scale: f64,
    ) -> Pose<3> {
        Pose {
            scale: 1.0,
            rotation: orthonormalized(&self.rotation),
            source_origin: *cloud_centre,
            target_origin: model_centre + self.shift * scale,
        }
    }

    /// The placement between scaled frames of a pose between the files' frames.
    pub(crate) fn from_pose(
        pose: &Pose<3>,
        cloud_centre: &Vector3<f64>,
        model_centre: &Vector3<f64>,
        scale: f64,
    ) -> Self {
        Self { rotation: pose.rotation, shift: (pose.apply(cloud_centre) - model_centre) / scale }
    }
}
