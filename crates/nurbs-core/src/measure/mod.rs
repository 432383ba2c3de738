//! Lengths and areas, by adaptive quadrature with an error estimate.

mod arc_length;
mod area;
mod rule;

pub use arc_length::{ArcLength, arc_length};
pub use area::area;

/// Relative tolerance of a length or area that is good for almost every purpose.
pub const MEASURE_TOLERANCE: f64 = 1e-10;

/// A number found by quadrature.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Measure {
    /// The length or area, in the units of the shape (squared).
    pub value: f64,
    /// Estimate of the absolute error; it exceeds what was asked for when the work limit was reached
    /// first, which takes a shape that is not even piecewise smooth.
    pub error: f64,
}

/// The tolerance that quadrature works to: below rounding error there is nothing to gain.
fn attainable(relative_tolerance: f64) -> f64 {
    // `max` also turns NaN into the bound.
    relative_tolerance.max(4.0 * f64::EPSILON)
}

/// Rounding error of points whose largest coordinates are given: no length is better known than that.
fn noise(coordinates: impl Iterator<Item = f64>) -> f64 {
    8.0 * f64::EPSILON * coordinates.fold(0.0, f64::max)
}
