//! Grey images: values, and the level functions that they become.

mod pgm;
mod png_file;
mod smooth;

pub use png_file::write_png;

use crate::Error;
use crate::error::check_size;
use distance_field::Grid;
use nalgebra::Vector2;

/// Fewest pixels in each direction.
const LEAST: usize = 4;

/// Which values lie inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Inside {
    /// Those above the level.
    Bright,
    /// Those below the level.
    Dark,
    /// Those that are rarer along the border of the image than the others: what an image shows stands in front of its background.
    #[default]
    Automatic,
}

/// A grey image. Values are those of the file (0 to 255 for 8 bits), rows from top to bottom.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: usize,
    height: usize,
    values: Vec<f64>,
}

impl Image {
    /// An image of `width × height` values, row by row from top to bottom.
    ///
    /// # Errors
    /// [`Error::TooSmall`] below 4 × 4 pixels, [`Error::NotFinite`], and [`Error::Malformed`] where the number of values is not that of the
    /// pixels.
    pub fn new(width: usize, height: usize, values: Vec<f64>) -> Result<Self, Error> {
        if width < LEAST || height < LEAST {
            return Err(Error::TooSmall { width, height });
        }
        if width.checked_mul(height) != Some(values.len()) {
            let what = format!("{} values for {width} x {height} pixels", values.len());
            return Err(Error::malformed("image", 0, what));
        }
        if let Some(index) = values.iter().position(|value| !value.is_finite()) {
            return Err(Error::NotFinite { index, value: values[index] });
        }
        Ok(Self { width, height, values })
    }

    /// Whether bytes begin as an image of a format that can be read: PNG, or PGM (`P2`, `P5`).
    #[must_use]
    pub fn is_image(bytes: &[u8]) -> bool {
        png_file::is_png(bytes) || pgm::is_pgm(bytes)
    }

    /// The image that the bytes of a file hold, PNG or PGM, recognised by content.
    ///
    /// Colours become grey by their luminance (0.2126, 0.7152, 0.0722 of the stored values); what is transparent lies on white.
    ///
    /// # Errors
    /// [`Error::Malformed`] for anything else and for files that end too early; [`Error::TooLarge`] and [`Error::TooSmall`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        let (width, height, values) = if png_file::is_png(bytes) {
            png_file::read(bytes)?
        } else if pgm::is_pgm(bytes) {
            pgm::read(bytes)?
        } else {
            return Err(Error::malformed("image", 0, "neither PNG nor PGM (P2, P5) begins like this"));
        };
        Self::new(width, height, values)
    }

    /// Pixels from left to right.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Pixels from top to bottom.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// The values, row by row from top to bottom.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Smallest and largest value.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        let fold = |[low, high]: [f64; 2], value: &f64| [low.min(*value), high.max(*value)];
        self.values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], fold)
    }

    /// Makes sure that there is something to be seen.
    pub(crate) fn check_contrast(&self) -> Result<(), Error> {
        let [low, high] = self.range();
        // Values of 1e300 are images as well, as long as their differences are numbers.
        let is_seen = high - low > 1e-9 * low.abs().max(high.abs()) && (high - low).is_finite();
        if is_seen { Ok(()) } else { Err(Error::NoContrast { value: low }) }
    }

    /// Whether the image has two values only, so that its edges are steps of whole pixels.
    #[must_use]
    pub fn is_black_and_white(&self) -> bool {
        let [least, most] = self.range();
        self.values.iter().all(|&value| value == least || value == most)
    }

    /// `Bright` or `Dark`, whichever is meant.
    #[must_use]
    pub fn side(&self, level: f64, inside: Inside) -> Inside {
        if inside != Inside::Automatic {
            return inside;
        }
        let (w, h) = (self.width, self.height);
        let border =
            (0..w).flat_map(|i| [i, (h - 1) * w + i]).chain((1..h - 1).flat_map(|j| [j * w, j * w + w - 1]));
        let (mut bright, mut count) = (0usize, 0usize);
        for pixel in border {
            bright += usize::from(self.values[pixel] > level);
            count += 1;
        }
        if 2 * bright > count { Inside::Dark } else { Inside::Bright }
    }

    /// The values at the centres of the pixels in coordinates: node `(i, j)` is the pixel in column `i` and row `j` from below.
    ///
    /// # Errors
    /// None for an image that could be made.
    pub fn grid(&self) -> Result<Grid<2>, Error> {
        let (w, h) = (self.width, self.height);
        let values = (0..w * h).map(|node| self.values[(h - 1 - node % h) * w + node / h]).collect();
        Ok(Grid::new(Vector2::repeat(0.5), Vector2::repeat(1.0), [w, h], values)?)
    }

    /// The level function: negative inside, zero at the level, in units of the contrast.
    ///
    /// With `smoothing > 0` (a length in pixels) the values are convolved with a Gaussian of this standard deviation first, which a sampled
    /// edge needs to be seen between its pixels. A Gaussian moves the level in the middle of a bent edge towards its centre of
    /// curvature, by `κ σ²/2`; so does the area of a pixel, by `κ/24`. Both are undone: the second derivative along the contour, which
    /// moves it, is taken off. A straight edge stays where it is.
    ///
    /// # Errors
    /// [`Error::NoContrast`], [`Error::Level`] for a level outside of the values, and [`Error::Option`] for a smoothing that is
    /// negative, not finite, or larger than the image.
    pub fn level_function(&self, level: f64, inside: Inside, smoothing: f64) -> Result<Grid<2>, Error> {
        self.check_contrast()?;
        let [least, most] = self.range();
        if !(least < level && level < most) {
            return Err(Error::Level { level, least, most });
        }
        let largest = self.width.min(self.height) as f64;
        if !(0.0..=largest).contains(&smoothing) {
            let what = "it must be a number of pixels, at least 0 and at most the size of the image";
            return Err(Error::Option { option: "smoothing", value: smoothing, what });
        }
        let sign = if self.side(level, inside) == Inside::Bright { -1.0 } else { 1.0 };
        let grid = self.grid()?;
        let values: Vec<f64> =
            grid.values().iter().map(|value| sign * (value - level) / (most - least)).collect();
        let grid = grid.with_values(values)?;
        if smoothing == 0.0 { Ok(grid) } else { smooth::sharpened(&grid, smoothing) }
    }

    /// The values convolved with a Gaussian of a standard deviation in pixels, in coordinates as [`Image::grid`].
    ///
    /// # Errors
    /// None for an image that could be made.
    pub fn smoothed(&self, deviation: f64) -> Result<Grid<2>, Error> {
        smooth::convolved(&self.grid()?, deviation)
    }
}

/// Makes sure that so many pixels may be held, and returns their number.
fn check_pixels(width: u64, height: u64) -> Result<usize, Error> {
    check_size(&[width, height], || format!("{width} x {height} pixels"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn y_points_upwards() {
        let image = Image::new(4, 5, (0..20).map(f64::from).collect()).unwrap();
        let grid = image.grid().unwrap();
        // The first value is the upper left pixel.
        assert_eq!(grid.position(4), Vector2::new(0.5, 4.5));
        assert_eq!((grid.values()[4], grid.values()[0], grid.values()[15]), (0.0, 16.0, 19.0));
    }

    #[test]
    fn the_background_is_what_the_border_shows() {
        let spot = |inside: f64| {
            Image::new(5, 5, (0..25).map(|k| if k == 12 { inside } else { 1.0 }).collect()).unwrap()
        };
        assert_eq!(spot(0.0).side(0.5, Inside::Automatic), Inside::Dark);
        assert_eq!(spot(2.0).side(1.5, Inside::Automatic), Inside::Bright);
        assert_eq!(spot(2.0).side(1.5, Inside::Dark), Inside::Dark);
    }

    #[test]
    fn what_is_no_image_is_refused() {
        assert!(matches!(Image::new(1, 1, vec![0.0]), Err(Error::TooSmall { width: 1, height: 1 })));
        assert!(matches!(Image::new(4, 4, vec![0.0; 15]), Err(Error::Malformed { .. })));
        let mut values = vec![0.0; 16];
        values[3] = f64::NAN;
        assert!(matches!(Image::new(4, 4, values), Err(Error::NotFinite { index: 3, .. })));
        let flat = Image::new(4, 4, vec![7.0; 16]).unwrap();
        assert!(matches!(
            flat.level_function(7.0, Inside::Bright, 1.0),
            Err(Error::NoContrast { value: 7.0 })
        ));
        let image = Image::new(4, 4, (0..16).map(f64::from).collect()).unwrap();
        assert!(matches!(image.level_function(15.0, Inside::Bright, 1.0), Err(Error::Level { .. })));
        for bad in [-1.0, 5.0, f64::NAN] {
            let found = image.level_function(7.5, Inside::Bright, bad);
            assert!(matches!(found, Err(Error::Option { option: "smoothing", .. })));
        }
        assert!(matches!(
            check_pixels(1 << 20, 1 << 20),
            Err(Error::TooLarge { bytes: 0x800_0000_0000, .. })
        ));
    }
}
