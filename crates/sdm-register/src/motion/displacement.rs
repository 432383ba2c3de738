//! A motion in the frame of the moment: scale, rotation, translation.

use nalgebra::{SMatrix, SVector};

/// The map `x ↦ s R x + t` in whatever frame its user agrees on; [`Pose`](crate::Pose) is the one that knows where the
/// files' coordinates are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Displacement<const D: usize> {
    /// `s`, 1 unless the scale is estimated.
    pub scale: f64,
    /// `R`, a rotation.
    pub rotation: SMatrix<f64, D, D>,
    /// `t`.
    pub translation: SVector<f64, D>,
}

impl<const D: usize> Displacement<D> {
    /// The map that moves nothing.
    #[must_use]
    pub fn identity() -> Self {
        Self { scale: 1.0, rotation: SMatrix::identity(), translation: SVector::zeros() }
    }

    /// The image of a point.
    #[inline]
    #[must_use]
    pub fn apply(&self, x: &SVector<f64, D>) -> SVector<f64, D> {
        self.rotation * x * self.scale + self.translation
    }
}
