//! PNG files (the only file that knows `png`).

use super::check_pixels;
use crate::Error;
use crate::error::MOST_BYTES;
use png::{BitDepth, ColorType, Decoder, Limits, Transformations};
use std::io::Cursor;

const NAME: &str = "PNG";
/// Parts of red, green and blue in the luminance (Rec. 709), of the values as they are stored.
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Whether bytes begin as a PNG does.
pub(super) fn is_png(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x89PNG\r\n\x1a\n")
}

/// Width, height and values, row by row from top to bottom.
pub(super) fn read(bytes: &[u8]) -> Result<(usize, usize, Vec<f64>), Error> {
    let mut source = Cursor::new(bytes);
    let limits = Limits { bytes: usize::try_from(MOST_BYTES).unwrap_or(usize::MAX) };
    let mut decoder = Decoder::new_with_limits(&mut source, limits);
    decoder.set_transformations(Transformations::EXPAND);
    let broken = |error: png::DecodingError| {
        Error::malformed(NAME, bytes.len(), format!("cannot be decoded: {error}"))
    };
    let header = decoder.read_header_info().map_err(broken)?;
    let (width, height) = (header.width, header.height);
    let count = check_pixels(u64::from(width), u64::from(height))?;
    let mut reader = decoder.read_info().map_err(broken)?;
    let size = reader.output_buffer_size();
    let size = size.ok_or_else(|| Error::malformed(NAME, 0, "the image has no size that can be held"))?;
    check_pixels(size.div_ceil(8) as u64, 1)?;
    let mut buffer = vec![0; size];
    let frame = reader.next_frame(&mut buffer).map_err(broken)?;
    let wide = frame.bit_depth == BitDepth::Sixteen;
    let (most, step) = if wide { (65535.0, 2) } else { (255.0, 1) };
    let channels = frame.color_type.samples();
    let sample = |pixel: &[u8], channel: usize| {
        let part = &pixel[channel * step..(channel + 1) * step];
        part.iter().fold(0.0, |value, &byte| value * 256.0 + f64::from(byte))
    };
    let grey = |pixel: &[u8]| {
        let value = match frame.color_type {
            ColorType::Rgb | ColorType::Rgba => {
                (0..3).map(|channel| LUMINANCE[channel] * sample(pixel, channel)).sum()
            }
            _ => sample(pixel, 0),
        };
        match frame.color_type {
            ColorType::Rgba | ColorType::GrayscaleAlpha => {
                let share = sample(pixel, channels - 1) / most;
                value * share + most * (1.0 - share)
            }
            _ => value,
        }
    };
    let row = width as usize * channels * step;
    let values: Vec<f64> = buffer
        .chunks_exact(frame.line_size.max(1))
        .take(height as usize)
        .flat_map(|line| line[..row.min(line.len())].chunks_exact(channels * step))
        .map(grey)
        .collect();
    if values.len() != count {
        return Err(Error::malformed(
            NAME,
            bytes.len(),
            format!("{} of {count} pixels are there", values.len()),
        ));
    }
    Ok((width as usize, height as usize, values))
}

/// Writes an image in colours as PNG: three bytes for each pixel, row by row from top to bottom.
///
/// # Errors
/// [`Error::Malformed`] where the number of bytes is not that of the pixels, or an image without any.
pub fn write_png(width: u32, height: u32, colours: &[u8]) -> Result<Vec<u8>, Error> {
    let mut out = Vec::new();
    let failed = |error: png::EncodingError| Error::malformed(NAME, 0, error.to_string());
    let mut encoder = png::Encoder::new(&mut out, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(colours).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_come_back_as_grey() {
        let colours: Vec<u8> = (0u8..4 * 5).flat_map(|k| [k * 10, k * 10, k * 10]).collect();
        let bytes = write_png(4, 5, &colours).unwrap();
        let (width, height, values) = read(&bytes).unwrap();
        assert_eq!((width, height), (4, 5));
        for (k, value) in (0u8..).zip(&values) {
            assert!((value - f64::from(k) * 10.0).abs() < 1e-9);
        }
        let (_, _, red) = read(&write_png(1, 1, &[255, 0, 0]).unwrap()).unwrap();
        assert!((red[0] - 0.2126 * 255.0).abs() < 1e-9);
    }

    #[test]
    fn truncated_and_damaged_files_are_refused() {
        let colours = vec![77; 3 * 30 * 20];
        let bytes = write_png(30, 20, &colours).unwrap();
        for length in 8..bytes.len() - 12 {
            assert!(read(&bytes[..length]).is_err(), "{length} of {}", bytes.len());
        }
        // Whatever a byte is turned into: an error or an image of some size, never a panic.
        for at in 8..bytes.len() {
            let mut changed = bytes.clone();
            changed[at] ^= 0x55;
            if let Ok((width, height, values)) = read(&changed) {
                assert_eq!(values.len(), width * height);
            }
        }
        assert!(write_png(2, 2, &[0; 3]).is_err() && write_png(0, 2, &[]).is_err());
    }
}
