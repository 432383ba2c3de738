//! Where a measurement along a curve stops.

use nalgebra::SVector;

/// A point in the order of feet.
#[derive(Clone, Copy)]
pub(super) struct Stop<const D: usize> {
    /// Length of the curve up to the foot.
    pub(super) at: f64,
    pub(super) foot: SVector<f64, D>,
    pub(super) residual: SVector<f64, D>,
    pub(super) index: usize,
}
