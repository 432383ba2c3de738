//! Colours for signed deviations, safe for readers who do not tell red from green.

use crate::Tolerance;

/// From far below to far above: dark blue, light blue, pale yellow, orange, dark red. Blue and red differ in every common
/// kind of colour blindness, and lightness falls to both sides. The middle is neither white nor grey, so that it is seen
/// on both.
pub(crate) const STOPS: [[f64; 3]; 7] = [
    [33.0, 47.0, 140.0],
    [58.0, 118.0, 196.0],
    [129.0, 190.0, 219.0],
    [250.0, 240.0, 180.0],
    [247.0, 170.0, 90.0],
    [222.0, 78.0, 52.0],
    [150.0, 8.0, 38.0],
];

/// Grey, for points that were not measured.
const NOT_MEASURED: [u8; 3] = [150, 150, 150];

/// The colour at a place from −1 (dark blue) through 0 (pale yellow) to 1 (dark red); beyond, the end.
#[must_use]
pub fn diverging(place: f64) -> [u8; 3] {
    if place.is_nan() {
        return NOT_MEASURED;
    }
    let place = (0.5 + 0.5 * place.clamp(-1.0, 1.0)) * (STOPS.len() - 1) as f64;
    let below = index(place).min(STOPS.len() - 2);
    let part = place - below as f64;
    std::array::from_fn(|channel| {
        let value = STOPS[below][channel] * (1.0 - part) + STOPS[below + 1][channel] * part;
        u8::try_from(index(value.round())).unwrap_or(u8::MAX)
    })
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "small numbers that are not negative"
)]
fn index(value: f64) -> usize {
    value.max(0.0) as usize
}

/// Colours by tolerance: the light part of the scale within the limits, its dark ends beyond.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColourScale {
    tolerance: Tolerance,
}

impl ColourScale {
    /// Place of the limits on the scale: between light blue and blue, orange and red.
    pub(crate) const LIMIT: f64 = 0.55;

    /// The scale for a tolerance.
    #[must_use]
    pub fn new(tolerance: Tolerance) -> Self {
        Self { tolerance }
    }

    /// The colour of a deviation; grey for NaN.
    #[must_use]
    pub fn colour(&self, deviation: f64) -> [u8; 3] {
        diverging(self.place(deviation))
    }

    /// The place of a deviation on the scale of [`diverging`]: within the limits up to ±0.55, beyond −1 or 1.
    #[must_use]
    pub fn place(&self, deviation: f64) -> f64 {
        let Tolerance { lower, upper } = self.tolerance;
        let target = self.tolerance.target();
        if deviation.is_nan() {
            f64::NAN
        } else if deviation > upper {
            1.0
        } else if deviation < lower {
            -1.0
        } else if deviation == target {
            0.0
        } else if deviation > target {
            Self::LIMIT * ((deviation - target) / (upper - target)).min(1.0)
        } else {
            -Self::LIMIT * ((target - deviation) / (target - lower)).min(1.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_and_middle() {
        assert_eq!(diverging(0.0), [250, 240, 180]);
        assert_eq!((diverging(-7.0), diverging(7.0)), ([33, 47, 140], [150, 8, 38]));
        let scale = ColourScale::new(Tolerance::new(-0.1, 0.3).unwrap());
        assert_eq!(scale.colour(0.0), diverging(0.0));
        assert_eq!([scale.colour(-0.101), scale.colour(0.301)], [diverging(-1.0), diverging(1.0)]);
        assert_ne!(scale.colour(0.3), scale.colour(0.301));
        assert_eq!(scale.colour(f64::NAN), [150, 150, 150]);
        // What is best has the colour of the middle, where it is a limit as well.
        for (lower, upper) in [(0.0, 0.3), (-0.3, 0.0)] {
            let scale = ColourScale::new(Tolerance::new(lower, upper).unwrap());
            assert_eq!(
                [lower, upper, 0.0].map(|d| scale.place(d)),
                [lower, upper, 0.0].map(|d| d / 0.3 * 0.55)
            );
        }
    }

    /// Two deviations of different sign stay apart for the three kinds of colour blindness, here as lightness and blue
    /// against yellow, which all of them see.
    #[test]
    fn sides_differ_without_red_against_green() {
        for step in 2..=10 {
            let place = f64::from(step) / 10.0;
            let [low, high] = [diverging(-place), diverging(place)].map(|c| c.map(f64::from));
            let yellow = |c: [f64; 3]| 0.5 * (c[0] + c[1]) - c[2];
            assert!(yellow(high) - yellow(low) > 50.0, "{place}");
        }
    }
}
