//! Pictures side by side, with titles and a colour bar, as SVG or PNG.

use crate::canvas::Raster;
use crate::colour::of_share;
use crate::glyphs;
use std::fmt::Write as _;

/// Room between pictures and around them, for a title, and for a colour bar, in pixels.
const GAP: usize = 16;
const TITLE: usize = 30;
const BAR: usize = 22;
const NUMBERS: usize = 110;
/// Ticks of a colour bar.
const TICKS: usize = 5;
/// Width of a character of the caption, at most.
const CHARACTER: f64 = 7.4;

/// Pictures in a row.
#[derive(Clone, Debug, Default)]
pub struct Sheet {
    pictures: Vec<(String, Raster)>,
    bar: Option<[f64; 2]>,
    caption: String,
}

impl Sheet {
    /// An empty sheet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The same with one more picture on the right; titles are in SVG only.
    #[must_use]
    pub fn with(mut self, title: &str, picture: Raster) -> Self {
        self.pictures.push((title.to_owned(), picture));
        self
    }

    /// The same with a colour bar on the right.
    #[must_use]
    pub fn with_bar(mut self, range: [f64; 2]) -> Self {
        self.bar = Some(range);
        self
    }

    /// The same with a line of text below, in SVG.
    #[must_use]
    pub fn with_caption(mut self, caption: &str) -> Self {
        caption.clone_into(&mut self.caption);
        self
    }

    fn has_titles(&self) -> bool {
        self.pictures.iter().any(|(title, _)| !title.is_empty())
    }

    fn height(&self) -> usize {
        self.pictures.iter().map(|(_, picture)| picture.height).max().unwrap_or(0)
    }

    /// Left upper corners of the pictures, and where the bar begins.
    fn places(&self, top: usize) -> (Vec<[usize; 2]>, usize) {
        let (mut left, height) = (GAP, self.height());
        let mut places = Vec::with_capacity(self.pictures.len());
        for (_, picture) in &self.pictures {
            places.push([left, top + (height - picture.height) / 2]);
            left += picture.width + GAP;
        }
        (places, left)
    }

    fn tick(&self, k: usize) -> Option<(f64, String)> {
        let [low, high] = self.bar?;
        let share = k as f64 / (TICKS - 1) as f64;
        Some((share, short(low + (high - low) * share, high - low)))
    }

    /// The sheet as PNG.
    ///
    /// # Errors
    /// A text, where the picture cannot be encoded.
    pub fn to_png(&self) -> Result<Vec<u8>, String> {
        let (places, right) = self.places(GAP);
        let width = right + if self.bar.is_some() { BAR + NUMBERS } else { 0 };
        let mut all = Raster::white(width, self.height() + 2 * GAP);
        for ((_, picture), [left, top]) in self.pictures.iter().zip(&places) {
            all.put(picture, *left, *top);
        }
        if self.bar.is_some() {
            all.put(&bar(self.height()), right, GAP);
            for (share, text) in (0..TICKS).filter_map(|k| self.tick(k)) {
                let y = GAP as f64 + (1.0 - share) * self.height() as f64;
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "within the picture"
                )]
                let middle = (y as usize).clamp(8, (GAP + self.height()).max(8));
                glyphs::write(&mut all, &text, right + BAR + 6, middle);
            }
        }
        encode(&all)
    }

    /// The sheet as SVG: the pictures as they are, titles, numbers and caption as text.
    ///
    /// # Errors
    /// As for [`Sheet::to_png`].
    pub fn to_svg(&self) -> Result<String, String> {
        let top = if self.has_titles() { TITLE } else { GAP };
        let (places, right) = self.places(top);
        let width = right + if self.bar.is_some() { BAR + NUMBERS } else { 0 };
        let below = if self.caption.is_empty() { GAP } else { GAP + 24 };
        let height = top + self.height() + below;
        let width = (width as f64).max(CHARACTER * self.caption.chars().count() as f64 + 2.0 * GAP as f64);
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height}\" width=\"{width:.0}\" height=\"{height}\" \
             font-family=\"sans-serif\" font-size=\"14\" fill=\"#20242a\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
        );
        let image = |out: &mut String, picture: &Raster, left: usize, top: usize| -> Result<(), String> {
            let data = base64(&encode(picture)?);
            // Writing to memory cannot fail.
            let _ = writeln!(
                out,
                "<image x=\"{left}\" y=\"{top}\" width=\"{}\" height=\"{}\" href=\"data:image/png;base64,{data}\"/>",
                picture.width, picture.height
            );
            Ok(())
        };
        for ((title, picture), [left, above]) in self.pictures.iter().zip(&places) {
            image(&mut out, picture, *left, *above)?;
            let middle = *left as f64 + 0.5 * picture.width as f64;
            if !title.is_empty() {
                let title = escaped(title);
                let _ =
                    writeln!(out, "<text x=\"{middle:.0}\" y=\"20\" text-anchor=\"middle\">{title}</text>");
            }
        }
        if self.bar.is_some() {
            image(&mut out, &bar(self.height()), right, top)?;
            for (share, text) in (0..TICKS).filter_map(|k| self.tick(k)) {
                let y = top as f64 + (1.0 - share) * self.height() as f64 + 5.0 - 5.0 * (0.5 - share);
                let _ = writeln!(out, "<text x=\"{}\" y=\"{y:.0}\">{text}</text>", right + BAR + 6);
            }
        }
        if !self.caption.is_empty() {
            let y = top + self.height() + GAP + 10;
            let text = escaped(&self.caption);
            let _ = writeln!(out, "<text x=\"{GAP}\" y=\"{y}\" fill=\"#59626e\">{text}</text>");
        }
        out.push_str("</svg>\n");
        Ok(out)
    }
}

/// A bar of the colours of values, the last on top.
fn bar(height: usize) -> Raster {
    let mut raster = Raster::white(BAR - 4, height);
    for y in 0..height {
        let colour = of_share(1.0 - (y as f64 + 0.5) / height as f64);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 255")]
        let bytes = colour.map(|c| (255.0 * c).round() as u8);
        for x in 0..raster.width {
            let place = 3 * (y * raster.width + x);
            raster.colours[place..place + 3].copy_from_slice(&bytes);
        }
    }
    raster
}

/// A number with four digits of the size of a range.
fn short(value: f64, size: f64) -> String {
    let size = size.abs().max(value.abs());
    if !(1e-3..1e5).contains(&size) {
        return format!("{value:.2e}");
    }
    let digits = if size >= 1000.0 {
        0
    } else if size >= 100.0 {
        1
    } else if size >= 10.0 {
        2
    } else {
        3
    };
    format!("{value:.digits$}")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

fn encode(raster: &Raster) -> Result<Vec<u8>, String> {
    let side = |count: usize| u32::try_from(count).map_err(|error| error.to_string());
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, side(raster.width)?, side(raster.height)?);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().map_err(|error| error.to_string())?;
    writer.write_image_data(&raster.colours).map_err(|error| error.to_string())?;
    writer.finish().map_err(|error| error.to_string())?;
    Ok(out)
}

/// Bytes as text (RFC 4648).
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let part = |k: usize| u32::from(chunk.get(k).copied().unwrap_or(0));
        let bits = part(0) << 16 | part(1) << 8 | part(2);
        for k in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * k) & 63) as usize];
            out.push(if k <= chunk.len() { char::from(digit) } else { '=' });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_become_text() {
        assert_eq!(base64(b""), "");
        assert_eq!([base64(b"f"), base64(b"fo"), base64(b"foo")], ["Zg==", "Zm8=", "Zm9v"]);
    }

    #[test]
    fn numbers_have_as_many_digits_as_they_need() {
        assert_eq!(short(0.25, 1.0), "0.250");
        assert_eq!(short(1234.5, 2000.0), "1234");
        assert_eq!(short(2e-7, 4e-7), "2.00e-7");
    }
}
