//! From values to places in a picture, and round numbers in between.

/// An affine map from a range of values to a range of pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale {
    /// Values at both ends.
    pub(crate) values: [f64; 2],
    /// Pixels at both ends.
    pub(crate) pixels: [f64; 2],
}

impl Scale {
    /// The pixel of a value.
    pub(crate) fn at(&self, value: f64) -> f64 {
        let [low, high] = self.values;
        self.pixels[0] + (value - low) / (high - low) * (self.pixels[1] - self.pixels[0])
    }

    /// Multiples of `step` within the values.
    pub(crate) fn ticks(&self, step: f64) -> Vec<f64> {
        let low = self.values[0].min(self.values[1]);
        let high = self.values[0].max(self.values[1]);
        let first = (low / step - 1e-9).ceil();
        (0..1000)
            .map(|i| (first + f64::from(i)) * step)
            .take_while(|&tick| tick <= high + 1e-9 * step)
            .collect()
    }
}

/// The smallest number of the form 1, 2 or 5 times a power of ten that is not below `value` (which is positive).
pub(crate) fn round_up(value: f64) -> f64 {
    let power = 10f64.powf(value.log10().floor());
    [1.0, 2.0, 5.0].iter().map(|factor| factor * power).find(|&round| round >= value).unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_and_ticks() {
        let scale = Scale { values: [-1.0, 3.0], pixels: [100.0, 20.0] };
        assert_eq!(scale.at(1.0), 60.0);
        assert_eq!(scale.ticks(2.0), [0.0, 2.0]);
        assert_eq!([0.13, 0.2, 0.21, 7.0].map(round_up), [0.2, 0.2, 0.5, 10.0]);
    }
}
