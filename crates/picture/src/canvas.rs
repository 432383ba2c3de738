//! Pixels in colours, drawn at twice the size and averaged.

/// Pixels along each side of one of the picture.
pub(crate) const FINE: usize = 2;

/// A colour, each part between 0 and 1.
pub(crate) type Colour = [f32; 3];

/// What is drawn on: `FINE × FINE` pixels for each of the picture.
#[derive(Clone, Debug)]
pub(crate) struct Canvas {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) pixels: Vec<Colour>,
}

/// A finished picture: three bytes for each pixel, row by row from top to bottom.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Raster {
    /// Pixels in a row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Red, green and blue of each.
    pub colours: Vec<u8>,
}

impl Canvas {
    /// A white canvas for a picture of this size.
    pub(crate) fn new(width: usize, height: usize) -> Self {
        let (width, height) = (width * FINE, height * FINE);
        Self { width, height, pixels: vec![[1.0; 3]; width * height] }
    }

    /// Mixes a colour into a pixel.
    pub(crate) fn blend(&mut self, x: usize, y: usize, colour: Colour, share: f32) {
        let pixel = &mut self.pixels[y * self.width + x];
        for k in 0..3 {
            pixel[k] += (colour[k] - pixel[k]) * share.clamp(0.0, 1.0);
        }
    }

    /// The picture.
    pub(crate) fn finished(&self) -> Raster {
        let (width, height) = (self.width / FINE, self.height / FINE);
        let row = |y: usize| {
            let byte = |x: usize, k: usize| {
                let mut sum = 0.0;
                for dy in 0..FINE {
                    for dx in 0..FINE {
                        sum += self.pixels[(y * FINE + dy) * self.width + x * FINE + dx][k];
                    }
                }
                to_byte(sum / (FINE * FINE) as f32)
            };
            (0..width).flat_map(|x| [byte(x, 0), byte(x, 1), byte(x, 2)]).collect::<Vec<u8>>()
        };
        let rows: Vec<Vec<u8>> = lanes::tasks(height, row);
        Raster { width, height, colours: rows.concat() }
    }
}

impl Raster {
    /// A white picture.
    pub(crate) fn white(width: usize, height: usize) -> Self {
        Self { width, height, colours: vec![255; 3 * width * height] }
    }

    /// Puts another picture in, its left upper corner at a place; what lies outside is left out.
    pub(crate) fn put(&mut self, other: &Self, left: usize, top: usize) {
        let columns = other.width.min(self.width.saturating_sub(left));
        for row in 0..other.height.min(self.height.saturating_sub(top)) {
            let to = 3 * ((top + row) * self.width + left);
            let from = 3 * row * other.width;
            self.colours[to..to + 3 * columns].copy_from_slice(&other.colours[from..from + 3 * columns]);
        }
    }
}

/// A part of a colour as a byte.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 255")]
fn to_byte(value: f32) -> u8 {
    (255.0 * value.clamp(0.0, 1.0)).round() as u8
}

/// Share of a pixel that a line covers whose middle is at a distance, all in pixels.
pub(crate) fn cover(distance: f64, half_width: f64) -> f32 {
    to_f32((half_width + 0.5 - distance).clamp(0.0, 1.0))
}

/// A number of ordinary size.
#[expect(clippy::cast_possible_truncation, reason = "colours need no more digits")]
pub(crate) fn to_f32(value: f64) -> f32 {
    value as f32
}

/// The pixels from one place to another, cut to those that exist.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the canvas")]
pub(crate) fn range(from: f64, to: f64, count: usize) -> std::ops::Range<usize> {
    let most = count as f64;
    let start = from.floor().clamp(0.0, most) as usize;
    start..(to.ceil() + 1.0).clamp(0.0, most) as usize
}

/// Distance of a point from a segment, and the share of the way at its foot.
pub(crate) fn from_segment(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> (f64, f64) {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let square = dx * dx + dy * dy;
    let t = if square > 0.0 { ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / square } else { 0.0 };
    let t = t.clamp(0.0, 1.0);
    ((p[0] - a[0] - t * dx).hypot(p[1] - a[1] - t * dy), t)
}
