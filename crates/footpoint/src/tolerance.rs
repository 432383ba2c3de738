//! Tolerances of classification: when a step, an angle or a distance counts as nothing.

use crate::global::curve::all_feet_line::APART;

/// Local parameters this close to a border are on it.
pub(crate) const ON_BORDER: f64 = 1e-12;
/// Share of the size of the model within which points are the same.
pub(crate) const SAME_POINT: f64 = APART;
/// Cosine of the angle between the connecting line and a tangent that still counts as a right angle.
pub(crate) const ORTHOGONAL: f64 = 1e-6;
/// Component of the connecting line along a tangent that counts as none next to the shape, as a share of the size of the model.
pub(crate) const ORTHOGONAL_FLOOR: f64 = 1e-11;
/// Squared sine of the angle between the tangents, times the squared ratio of their lengths, down to which they have a normal.
pub(crate) const DEGENERATE_SQ: f64 = 1e-18;
/// Speed, as a share of the size of the model, below which a parameter does not move the point.
pub(crate) const STANDSTILL: f64 = 1e-9;
/// `1 − d κ` below this asks whether the footpoint is one of a continuum.
pub(super) const FLAT: f64 = 1e-4;
/// Decrease of the squared distance, as a share of it, that rounding errors hide.
pub(super) const NO_GAIN: f64 = 64.0 * f64::EPSILON;
