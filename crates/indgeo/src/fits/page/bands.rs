//! Points by their distance: an even sample, and the colours of bands.

use super::SHOWN;
use crate::output::html::{note, swatch};
use industrial_geometry::inspection::html::number;

/// Colours of distances, from none to the limit, and beyond it.
pub(super) const BANDS: [[u8; 3]; 5] =
    [[0x0b, 0x6e, 0x99], [0x35, 0xa1, 0x86], [0xa7, 0xb7, 0x3a], [0xe0, 0x99, 0x2f], [0xc8, 0x42, 0x2b]];
pub(super) const BEYOND: [u8; 3] = [0x8b, 0x2f, 0xae];

/// Points that are shown, with their distances.
pub(super) struct Shown<P> {
    pub(super) points: Vec<(P, f64)>,
    /// How many there are.
    total: usize,
    /// The distance of the last band.
    limit: f64,
    is_tolerance: bool,
}

/// Indices of the points that are shown.
pub(super) fn picked(count: usize) -> impl Iterator<Item = usize> {
    (0..count).step_by(count.div_ceil(SHOWN).max(1))
}

impl<P> Shown<P> {
    /// Points and distances that are numbers, of so many; colours are up to the tolerance, or to the largest distance that counts.
    pub(super) fn new(points: Vec<(P, f64)>, total: usize, tolerance: Option<f64>, max: f64) -> Self {
        Self { points, total, limit: tolerance.unwrap_or(max), is_tolerance: tolerance.is_some() }
    }

    pub(super) fn colour(&self, distance: f64) -> [u8; 3] {
        // Where all distances are 0 all are in the first band.
        if distance <= 0.0 {
            return BANDS[0];
        }
        let share = distance / self.limit * BANDS.len() as f64;
        (0..BANDS.len()).find(|&band| share <= (band + 1) as f64).map_or(BEYOND, |band| BANDS[band])
    }

    /// What the colours mean, and how many points there are.
    pub(super) fn legend(&self) -> String {
        let mut swatches = String::new();
        for (band, colour) in BANDS.iter().enumerate() {
            let upper = self.limit * (band + 1) as f64 / BANDS.len() as f64;
            swatches += &swatch(&hex(*colour), &format!("up to {}", number(upper)));
        }
        let beyond = if self.is_tolerance { "beyond the tolerance" } else { "farther, not counted" };
        swatches += &swatch(&hex(BEYOND), beyond);
        let shown = format!("{} of {} points are shown.", self.points.len(), self.total);
        format!("<p class=\"note\">{swatches}</p>\n{}", note(&shown))
    }
}

pub(super) fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

pub(super) fn parts(colour: [u8; 3]) -> [f32; 3] {
    colour.map(|c| f32::from(c) / 255.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_fall_into_their_bands() {
        let shown = Shown::new(vec![((), 0.0)], 1, Some(1.0), 3.0);
        let colours = [0.0, 0.2, 0.21, 1.0, 1.01].map(|d| shown.colour(d));
        assert_eq!(colours, [BANDS[0], BANDS[0], BANDS[1], BANDS[4], BEYOND]);
        assert_eq!(Shown::new(vec![((), 0.0)], 1, None, 0.0).colour(0.0), BANDS[0]);
        assert_eq!(picked(3).count(), 3);
        assert!(picked(1_000_003).count() <= SHOWN);
    }
}
