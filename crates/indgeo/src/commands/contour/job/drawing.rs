//! Pictures of an image or a grid with its contours: SVG and PNG.

use super::output::path_of;
use crate::error::Error;
use crate::files;
use crate::report::{Output, Report, Timings};
use industrial_geometry::distance_field::Grid;
use industrial_geometry::level_set::{FittedContour, write_png};
use industrial_geometry::mesh::nalgebra::Vector2;
use industrial_geometry::nurbs::ParametricCurve;
use std::fmt::Write;
use std::path::Path;

/// Length of the longer side that a picture has at least, and how much pixels grow at most.
const SIDE: usize = 900;
const GROWTH: usize = 8;
/// Colours of outer contours and of holes.
const OUTER: [u8; 3] = [0xe0, 0x10, 0x10];
const HOLE: [u8; 3] = [0x10, 0x60, 0xff];
/// Points of a curve on each span.
const SAMPLES: usize = 24;

/// Makes sure that the extension names a format of pictures.
pub(super) fn check(path: &Path) -> Result<(), Error> {
    match files::extension(path).as_str() {
        "svg" | "png" => Ok(()),
        _ => Err(Error::content(path, "the extension names no format of pictures", "choose .svg or .png")),
    }
}

/// Draws the values in grey and the contours on them.
pub(super) fn write(
    path: &Path,
    values: &Grid<2>,
    fitted: &[FittedContour],
    report: &mut Report,
) -> Result<(), Error> {
    let mut timings = report.timings;
    let bytes = Timings::measure(&mut timings.write, || {
        let failed = |error: industrial_geometry::level_set::Error| {
            Error::content(path, error.to_string(), "leave out --picture")
        };
        let [w, h] = values.counts();
        let small = |side: usize| u32::try_from(side).unwrap_or(u32::MAX);
        if files::extension(path) == "svg" {
            let image = write_png(small(w), small(h), &grey(values, 1)).map_err(failed)?;
            let text = svg(values, fitted, &image);
            return files::write(path, |out| out.write_all(text.as_bytes()));
        }
        let growth = (SIDE / w.max(h)).clamp(1, GROWTH);
        let mut colours = grey(values, growth);
        for contour in fitted {
            line(&mut colours, [w * growth, h * growth], growth, values, contour);
        }
        let image = write_png(small(w * growth), small(h * growth), &colours).map_err(failed)?;
        files::write(path, |out| out.write_all(&image))
    })?;
    report.timings = timings;
    report.add_output(Output { path: path.to_path_buf(), bytes, content: "picture".to_owned() });
    Ok(())
}

/// Red, green and blue of the values, each a square of so many pixels, row by row from the top.
fn grey(values: &Grid<2>, growth: usize) -> Vec<u8> {
    let [w, h] = values.counts();
    let fold = |[low, high]: [f64; 2], value: &f64| [low.min(*value), high.max(*value)];
    let [low, high] = values.values().iter().fold([f64::INFINITY, f64::NEG_INFINITY], fold);
    let (width, height) = (w * growth, h * growth);
    let mut out = Vec::with_capacity(3 * width * height);
    for row in 0..height {
        for column in 0..width {
            let node = column / growth * h + (h - 1 - row / growth);
            let share = (values.values()[node] - low) / (high - low);
            // A little lighter and darker than the lines.
            out.extend([to_byte(255.0 * share); 3]);
        }
    }
    out
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to a byte")]
fn to_byte(value: f64) -> u8 {
    value.round().clamp(0.0, 255.0) as u8
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the picture")]
fn to_index(value: f64, count: usize) -> usize {
    value.clamp(0.0, (count - 1) as f64) as usize
}

/// Place of a point in a picture in which a cell has the size 1, y downwards.
fn place(values: &Grid<2>, p: &Vector2<f64>) -> [f64; 2] {
    let at = (p - values.origin()).component_div(values.spacing());
    [at.x + 0.5, values.counts()[1] as f64 - 0.5 - at.y]
}

/// Draws a curve two pixels wide.
fn line(
    colours: &mut [u8],
    [width, height]: [usize; 2],
    growth: usize,
    values: &Grid<2>,
    contour: &FittedContour,
) {
    let colour = if contour.is_hole { HOLE } else { OUTER };
    let knots = contour.curve.knots();
    let mut last: Option<[f64; 2]> = None;
    for span in knots.spans() {
        let interval = knots.span_interval(span);
        for k in 0..=SAMPLES {
            let p = contour.curve.point(interval.lerp(k as f64 / SAMPLES as f64));
            let at = place(values, &p).map(|c| c * growth as f64);
            let from = last.unwrap_or(at);
            let length = (at[0] - from[0]).hypot(at[1] - from[1]);
            let steps = to_index((2.0 * length).ceil(), 4 * (width + height));
            for step in 0..=steps {
                let share = step as f64 / steps.max(1) as f64;
                let [x, y] = [0, 1].map(|c| from[c] + share * (at[c] - from[c]));
                for (dx, dy) in [(-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)] {
                    let pixel = to_index(y + dy, height) * width + to_index(x + dx, width);
                    colours[3 * pixel..3 * pixel + 3].copy_from_slice(&colour);
                }
            }
            last = Some(at);
        }
    }
}

fn svg(values: &Grid<2>, fitted: &[FittedContour], image: &[u8]) -> String {
    let [w, h] = values.counts();
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\">\n<title>Contours</title>\n\
         <image width=\"{w}\" height=\"{h}\" style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{}\"/>\n\
         <g fill=\"none\" stroke-width=\"2\">\n",
        base64(image)
    );
    for contour in fitted {
        let [r, g, b] = if contour.is_hole { HOLE } else { OUTER };
        let path = path_of(&contour.curve, contour.is_closed, |p| place(values, p));
        // Writing to memory cannot fail.
        let _ = writeln!(
            text,
            "<path stroke=\"#{r:02x}{g:02x}{b:02x}\" vector-effect=\"non-scaling-stroke\" d=\"{path}\"/>"
        );
    }
    text + "</g>\n</svg>\n"
}

/// Bytes as text (RFC 4648).
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for part in bytes.chunks(3) {
        let three = [0, 1, 2].map(|k| part.get(k).copied().unwrap_or(0));
        let bits = three.iter().fold(0usize, |bits, &byte| bits << 8 | usize::from(byte));
        for k in 0..4 {
            let letter = LETTERS[bits >> (18 - 6 * k) & 63];
            out.push(if k <= part.len() { char::from(letter) } else { '=' });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_encoded_as_in_the_standard() {
        let pairs = [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")];
        for (bytes, text) in pairs {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }
}
