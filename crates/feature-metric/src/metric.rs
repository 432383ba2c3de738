//! The two metrics.

use crate::Error;
use std::ops::RangeInclusive;

/// Lengths that can be computed with: their squares, and products of these, neither underflow nor overflow.
pub(crate) const LENGTHS: RangeInclusive<f64> = 1e-70..=1e70;

/// How lengths on a surface are measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Metric {
    /// In space.
    Euclidean,
    /// On the image `(x, w n) ∈ R⁶` of the surface, with the unit normal `n` (\[P05, sec. 6\]): curves that cross features,
    /// where the normal turns, are long.
    Feature {
        /// The length `w ≥ 0`: fillets with a radius below it count as features. 0 gives the Euclidean metric.
        width: f64,
    },
}

impl Metric {
    /// The width, 0 for the Euclidean metric.
    #[must_use]
    pub fn width(self) -> f64 {
        if let Self::Feature { width } = self { width } else { 0.0 }
    }

    /// Checks the width.
    ///
    /// # Errors
    /// [`Error::Option`] if it is negative, not finite, or beyond what can be computed with.
    pub fn validate(self) -> Result<(), Error> {
        let value = self.width();
        if value == 0.0 || LENGTHS.contains(&value) {
            return Ok(());
        }
        Err(Error::Option { name: "width", value, allowed: "0, or a length between 1e-70 and 1e70" })
    }
}
