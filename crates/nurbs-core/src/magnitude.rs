//! The range of numbers in which shapes can be computed with, checked where they are constructed.
//!
//! What is computed from a shape takes products of its numbers: squared lengths, fourth powers of lengths in the determinant
//! of the first fundamental form, squared weights times squared lengths in distance functions. They must stay within the
//! range of doubles. Weights matter by their ratios only, so all of them may be large or small together: then they are
//! computed with after a division by a power of two, which leaves every bit as it is.

use crate::{BsplineCurve, BsplineSurface, Error};
use nalgebra::SVector;

/// Largest magnitude of a coordinate of a control point.
pub const MAX_COORDINATE: f64 = 1e70;

/// Largest ratio of two weights of one shape.
pub const MAX_WEIGHT_RATIO: f64 = 1e70;

/// Weights whose largest has a binary exponent beyond this are scaled before they are computed with.
const ORDINARY: i32 = 100;

/// Checks the coordinates of control points.
pub(crate) fn check_points<const D: usize>(points: &[SVector<f64, D>]) -> Result<(), Error> {
    for (index, point) in points.iter().enumerate() {
        if point.iter().any(|c| !c.is_finite()) {
            return Err(Error::NonFiniteControlPoint { index });
        }
        if let Some(&value) = point.iter().find(|c| c.abs() > MAX_COORDINATE) {
            return Err(Error::Magnitude { index, value });
        }
    }
    Ok(())
}

/// Checks the weights, and returns those to be computed with where they differ from the given ones by a common factor.
pub(crate) fn check_weights(weights: Option<&[f64]>, needed: usize) -> Result<Option<Vec<f64>>, Error> {
    let Some(weights) = weights else { return Ok(None) };
    if weights.len() != needed {
        return Err(Error::WeightCount { found: weights.len(), needed });
    }
    if let Some(index) = weights.iter().position(|w| !(w.is_finite() && *w > 0.0)) {
        return Err(Error::Weight { index, value: weights[index] });
    }
    let largest = weights.iter().copied().fold(0.0, f64::max);
    let exponent = exponent(largest);
    let scaled = |w: f64| scaled_by_power_of_two(w, -exponent);
    let share = |w: f64| scaled(w) / scaled(largest);
    if let Some(index) = weights.iter().position(|&w| share(w) * MAX_WEIGHT_RATIO < 1.0 - 1e-12) {
        return Err(Error::WeightRatio { index, value: weights[index], largest });
    }
    Ok((exponent.abs() > ORDINARY).then(|| weights.iter().map(|&w| scaled(w)).collect()))
}

/// The binary exponent of a finite number: `2^e ≤ |x| < 2^(e + 1)`; 0 for zero.
#[must_use]
pub fn exponent(x: f64) -> i32 {
    if x == 0.0 {
        return 0;
    }
    let biased = |x: f64| i32::try_from(x.to_bits() >> 52 & 0x7ff).unwrap_or(0);
    match biased(x) {
        // Subnormal: brought into the normal range first.
        0 => biased(x * f64::from_bits((1023 + 64) << 52)) - 1023 - 64,
        biased => biased - 1023,
    }
}

/// `x · 2^exponent`, rounded once, for exponents whose powers of two are no doubles too.
#[must_use]
pub fn scaled_by_power_of_two(x: f64, exponent: i32) -> f64 {
    let power = |e: i32| f64::from_bits(u64::try_from(1023 + e.clamp(-1022, 1023)).unwrap_or(0) << 52);
    if (-1022..=1023).contains(&exponent) {
        return x * power(exponent);
    }
    // In two steps: the first keeps all bits unless the result is zero or infinite anyway.
    let first = exponent / 2;
    let rest = exponent - first;
    x * power(first) * power(rest)
}

impl<const D: usize> BsplineCurve<D> {
    /// The curve scaled by `2^exponent` about the origin: the same bits, with other exponents.
    ///
    /// # Errors
    /// When a coordinate becomes larger than [`MAX_COORDINATE`].
    pub fn scaled_by_power_of_two(&self, exponent: i32) -> Result<Self, Error> {
        self.mapped(|p| p.map(|c| scaled_by_power_of_two(c, exponent)))
    }
}

impl BsplineSurface {
    /// The surface scaled by `2^exponent` about the origin: the same bits, with other exponents.
    ///
    /// # Errors
    /// When a coordinate becomes larger than [`MAX_COORDINATE`].
    pub fn scaled_by_power_of_two(&self, exponent: i32) -> Result<Self, Error> {
        self.mapped(|p| p.map(|c| scaled_by_power_of_two(c, exponent)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_of_all_magnitudes() {
        for e in -1074..=1023 {
            let x = scaled_by_power_of_two(1.0, e);
            assert_eq!((exponent(x), exponent(-x)), (e, e));
            assert_eq!(scaled_by_power_of_two(x, -e), 1.0);
            if e > -1022 {
                assert_eq!(exponent(x * 1.999), e);
            }
        }
        assert_eq!((exponent(0.0), exponent(f64::MAX)), (0, 1023));
        // A common factor of weights is divided out; beyond the ratio they are refused, with the number.
        let weights = [3e300, 1e300, 2e300];
        let scaled = check_weights(Some(&weights), 3).unwrap().unwrap();
        assert!(scaled.iter().zip(weights).all(|(a, b)| a / scaled[0] == b / weights[0]) && scaled[0] < 2.0);
        assert_eq!(check_weights(Some(&[1e-20, 1e20]), 2), Ok(None));
        assert_eq!(
            check_weights(Some(&[1.0, 1e-300, 1e300]), 3),
            Err(Error::WeightRatio { index: 0, value: 1.0, largest: 1e300 })
        );
        assert!(check_weights(Some(&[5e-324, 5e-324]), 2).unwrap().is_some());
    }
}
