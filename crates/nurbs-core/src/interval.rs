//! Closed parameter intervals.

use crate::Error;

/// A closed parameter interval `[start, end]` with `start < end`, both finite.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Interval {
    start: f64,
    end: f64,
}

impl Interval {
    /// The interval from 0 to 1.
    pub const UNIT: Self = Self { start: 0.0, end: 1.0 };

    /// The interval `[start, end]`.
    ///
    /// # Errors
    /// [`Error::EmptyInterval`] unless both ends are finite and `start < end`.
    ///
    /// ```
    /// # use nurbs_core::{Error, Interval};
    /// assert!(matches!(Interval::new(1.0, 1.0), Err(Error::EmptyInterval { .. })));
    /// ```
    pub fn new(start: f64, end: f64) -> Result<Self, Error> {
        if start.is_finite() && end.is_finite() && start < end {
            Ok(Self { start, end })
        } else {
            Err(Error::EmptyInterval { start, end })
        }
    }

    /// For callers that have already checked `start < end`.
    pub(crate) fn from_ordered(start: f64, end: f64) -> Self {
        debug_assert!(start < end);
        Self { start, end }
    }

    /// Lower end.
    #[must_use]
    pub fn start(self) -> f64 {
        self.start
    }

    /// Upper end.
    #[must_use]
    pub fn end(self) -> f64 {
        self.end
    }

    /// `end − start`.
    #[must_use]
    pub fn length(self) -> f64 {
        self.end - self.start
    }

    /// The parameter in the middle.
    #[must_use]
    pub fn midpoint(self) -> f64 {
        0.5 * (self.start + self.end)
    }

    /// Whether `t` lies in the closed interval (false for NaN).
    #[must_use]
    pub fn contains(self, t: f64) -> bool {
        self.start <= t && t <= self.end
    }

    /// The parameter of the interval that is nearest to `t`; NaN becomes the lower end.
    #[must_use]
    pub fn clamp(self, t: f64) -> f64 {
        // `max` drops a NaN operand, so the order matters here.
        t.max(self.start).min(self.end)
    }

    /// The parameter at the fraction `s` of the way, exact at `s = 0` and `s = 1`.
    #[must_use]
    pub fn lerp(self, s: f64) -> f64 {
        (1.0 - s) * self.start + s * self.end
    }

    /// The inverse of [`lerp`](Self::lerp): the fraction of the way at which `t` lies.
    #[must_use]
    pub fn fraction(self, t: f64) -> f64 {
        (t - self.start) / self.length()
    }

    /// `t` moved into `[start, end)` by whole multiples of the length.
    ///
    /// The interval is taken as one period of a closed shape.
    #[must_use]
    pub fn wrap(self, t: f64) -> f64 {
        if self.start <= t && t < self.end {
            return t;
        }
        let wrapped = self.start + (t - self.start).rem_euclid(self.length());
        // Rounding may land exactly on the upper end, which is the lower one of the next period.
        if wrapped >= self.start && wrapped < self.end { wrapped } else { self.start }
    }
}

/// From `{"start": …, "end": …}`, checked.
#[cfg(feature = "serde")]
impl<'de> serde::Deserialize<'de> for Interval {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(serde::Deserialize)]
        struct Ends {
            start: f64,
            end: f64,
        }
        let Ends { start, end } = Ends::deserialize(deserializer)?;
        Self::new(start, end).map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wraps_clamps_and_interpolates() {
        let i = Interval::new(-1.0, 3.0).unwrap();
        assert_eq!(i.wrap(3.0), -1.0);
        assert_eq!(i.wrap(-1.5), 2.5);
        assert_eq!(i.wrap(11.25), -0.75);
        assert_eq!(i.clamp(9.0), 3.0);
        assert_eq!(i.clamp(f64::NAN), -1.0);
        assert_eq!(i.lerp(1.0), 3.0);
        assert_eq!(i.fraction(0.0), 0.25);
    }
}
