//! Colours for signed distances.

use industrial_geometry::inspection::diverging;

/// Number of different colours.
pub(crate) const STEPS: usize = 25;
/// Colour of what lies beyond the model.
pub(crate) const BEYOND: [u8; 3] = [176, 182, 188];

/// The step for a distance on a scale from `-limit` to `limit`; what exceeds it gets the last step.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "limited to 0..STEPS")]
pub(crate) fn step(distance: f64, limit: f64) -> usize {
    let part = (0.5 + 0.5 * distance / limit).clamp(0.0, 1.0);
    ((part * STEPS as f64) as usize).min(STEPS - 1)
}

/// The colour of a step, darkened by `light` (1 for none).
pub(crate) fn colour(step: usize, light: f64) -> [u8; 3] {
    darken(diverging(2.0 * step as f64 / (STEPS - 1) as f64 - 1.0), light)
}

/// A colour, darkened.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "limited to 0..=255")]
pub(crate) fn darken(colour: [u8; 3], light: f64) -> [u8; 3] {
    colour.map(|channel| (f64::from(channel) * light).round().clamp(0.0, 255.0) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_and_middle() {
        assert_eq!([step(-9.0, 1.0), step(0.0, 1.0), step(9.0, 1.0)], [0, STEPS / 2, STEPS - 1]);
        assert_eq!(colour(STEPS / 2, 1.0), [250, 240, 180]);
        assert_eq!(colour(0, 1.0), [33, 47, 140]);
        assert_eq!(darken([200, 100, 0], 0.5), [100, 50, 0]);
    }
}
