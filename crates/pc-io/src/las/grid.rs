//! The steps of LAS coordinates, which are integers: multiples of a scale from an offset on.

/// Steps that are tried for coordinates that came from such integers, the coarsest first.
const SCALES: [f64; 11] = [1.0, 0.5, 0.1, 0.01, 0.001, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9];
/// Largest number of steps from the offset.
const MOST: f64 = i32::MAX as f64;

/// The steps of a coordinate, and how well they fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Grid {
    pub(super) scale: f64,
    pub(super) offset: f64,
    /// Largest difference between a value and its step.
    pub(super) error: f64,
}

impl Grid {
    /// The number of steps of a value.
    #[expect(clippy::cast_possible_truncation, reason = "limited first")]
    pub(super) fn steps(self, value: f64) -> i32 {
        ((value - self.offset) / self.scale).round().clamp(-MOST, MOST) as i32
    }

    fn value(self, steps: i32) -> f64 {
        f64::from(steps) * self.scale + self.offset
    }

    /// Whether all values are whole steps to the last bit.
    fn is_exact(self, values: impl Iterator<Item = f64>) -> bool {
        let mut values = values;
        values.all(|value| self.value(self.steps(value)) == value)
    }

    /// Steps on which all values lie to the last bit, where some decimal step has that; else steps as fine as the integers
    /// allow.
    pub(super) fn of(values: impl Iterator<Item = f64> + Clone) -> Self {
        let bounds = values.clone().fold(None, |bounds: Option<(f64, f64)>, value| {
            Some(bounds.map_or((value, value), |(low, high)| (low.min(value), high.max(value))))
        });
        let Some((low, high)) = bounds else {
            return Self { scale: 0.001, offset: 0.0, error: 0.0 };
        };
        let middle = low / 2.0 + high / 2.0;
        let round = |power: i32| {
            let unit = 10f64.powi(power);
            [(middle / unit).round() * unit, (low / unit).floor() * unit]
        };
        let offsets = || [0.0, low].into_iter().chain((0..=7).rev().flat_map(round));
        for scale in SCALES {
            for offset in offsets() {
                let grid = Self { scale, offset, error: 0.0 };
                if grid.is_exact(values.clone()) {
                    return grid;
                }
            }
        }
        let reach = (high / 2.0 - low / 2.0).max(f64::MIN_POSITIVE);
        #[expect(clippy::cast_possible_truncation, reason = "limited first")]
        let mut scale = 10f64.powi((reach / MOST).log10().ceil().clamp(-300.0, 308.0) as i32);
        // The logarithm may be rounded down.
        while reach / scale > MOST && scale < 1e300 {
            scale *= 10.0;
        }
        let grid = Self { scale, offset: middle, error: 0.0 };
        let error = values.map(|value| (grid.value(grid.steps(value)) - value).abs()).fold(0.0, f64::max);
        Self { error, ..grid }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_steps_that_values_came_from() {
        for (scale, offset) in [(0.01, 0.0), (0.001, 500_000.0), (0.25e-3, 4_500_000.0), (1e-6, 0.0)] {
            let given = Grid { scale, offset, error: 0.0 };
            let values: Vec<f64> = (-9000..9000).map(|step| given.value(step * 7)).collect();
            let found = Grid::of(values.iter().copied());
            assert!(found.error == 0.0, "{scale} {offset}: {found:?}");
            assert!(found.is_exact(values.iter().copied()), "{scale} {offset}: {found:?}");
        }
    }

    #[test]
    fn other_values_are_rounded_as_little_as_the_integers_allow() {
        let values = [std::f64::consts::PI, 17.0f64.sqrt(), -3.0f64.sqrt()];
        let found = Grid::of(values.into_iter());
        assert_eq!(found.scale, 1e-8);
        assert!(found.error > 0.0 && found.error <= 0.51e-8, "{found:?}");
        for extreme in [[1e300, -1e300, 0.1], [1e-300, 3e-300, 7e-301], [0.1, 0.1, 0.1]] {
            let found = Grid::of(extreme.into_iter());
            assert!(found.scale > 0.0 && found.scale.is_finite() && found.offset.is_finite(), "{found:?}");
        }
        assert_eq!(Grid::of(std::iter::empty()).error, 0.0);
    }
}
