//! Limits of a signed deviation.

use crate::Error;

/// The interval of allowed deviations, limits included.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Tolerance {
    /// Smallest allowed deviation.
    pub lower: f64,
    /// Largest allowed deviation.
    pub upper: f64,
}

impl Tolerance {
    /// From `lower` to `upper`, which may both lie on the same side of zero. Infinite limits allow everything.
    ///
    /// # Errors
    /// [`Error::Tolerance`] unless `lower < upper`.
    pub fn new(lower: f64, upper: f64) -> Result<Self, Error> {
        if lower < upper { Ok(Self { lower, upper }) } else { Err(Error::Tolerance { lower, upper }) }
    }

    /// From `-half` to `half`.
    ///
    /// # Errors
    /// [`Error::Tolerance`] unless `half` is positive.
    pub fn symmetric(half: f64) -> Result<Self, Error> {
        Self::new(-half, half)
    }

    /// Where a deviation lies; NaN is above every limit.
    #[must_use]
    pub fn class(&self, deviation: f64) -> Class {
        if deviation < self.lower {
            Class::Under
        } else if deviation <= self.upper {
            Class::Within
        } else {
            Class::Over
        }
    }

    /// The deviation that counts as perfect: zero if that is allowed, otherwise the middle.
    #[must_use]
    pub fn target(&self) -> f64 {
        if self.lower <= 0.0 && self.upper >= 0.0 { 0.0 } else { 0.5 * self.lower + 0.5 * self.upper }
    }
}

/// Where a deviation lies with respect to a tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Class {
    /// Below the lower limit: material is missing (where normals point out of it).
    Under,
    /// Between the limits.
    Within,
    /// Above the upper limit: there is too much material.
    Over,
}

impl Class {
    /// The name used in files: `under`, `within`, `over`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Under => "under",
            Self::Within => "within",
            Self::Over => "over",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_belong_to_the_tolerance() {
        let tolerance = Tolerance::new(-0.1, 0.2).unwrap();
        let classes = [-0.1, 0.2, -0.100_000_000_000_001, 0.3, f64::NAN].map(|d| tolerance.class(d));
        assert_eq!(classes, [Class::Within, Class::Within, Class::Under, Class::Over, Class::Over]);
        assert_eq!(tolerance.target(), 0.0);
        assert_eq!(Tolerance::new(0.25, 0.75).unwrap().target(), 0.5);
        // A limit of 0 allows 0, and nothing is better.
        for (lower, upper) in [(0.0, 0.2), (-0.2, 0.0), (0.0, f64::INFINITY)] {
            let tolerance = Tolerance::new(lower, upper).unwrap();
            assert_eq!((tolerance.target(), tolerance.class(0.0)), (0.0, Class::Within), "{lower} {upper}");
        }
        assert!(Tolerance::symmetric(0.0).is_err() && Tolerance::symmetric(f64::NAN).is_err());
        assert_eq!(Tolerance::symmetric(f64::INFINITY).unwrap().class(1e300), Class::Within);
    }
}
