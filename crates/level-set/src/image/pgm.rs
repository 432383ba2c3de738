//! Portable grey maps: `P2` (text) and `P5` (binary).

use super::check_pixels;
use crate::Error;

const NAME: &str = "PGM";

/// Whether bytes begin as a PGM does.
pub(super) fn is_pgm(bytes: &[u8]) -> bool {
    matches!(bytes, [b'P', b'2' | b'5', b' ' | b'\t' | b'\r' | b'\n' | b'#', ..])
}

/// Width, height and values, row by row from top to bottom.
pub(super) fn read(bytes: &[u8]) -> Result<(usize, usize, Vec<f64>), Error> {
    let is_text = bytes.get(1) == Some(&b'2');
    let mut reader = Reader { bytes, at: 2 };
    let width = reader.number("the width")?;
    let height = reader.number("the height")?;
    let most = reader.number("the largest value")?;
    if !(1..=65535).contains(&most) {
        return Err(Error::malformed(
            NAME,
            reader.at,
            format!("the largest value is {most}, not 1 to 65535"),
        ));
    }
    let count = check_pixels(width, height)?;
    let side = |value: u64| usize::try_from(value).unwrap_or(usize::MAX);
    if is_text {
        // Two bytes at least for each value: what is announced must be there before anything is allocated.
        reader.expect(count.saturating_mul(2).saturating_sub(1))?;
        let values: Result<Vec<f64>, Error> = (0..count)
            .map(|_| {
                let at = reader.at;
                let value = reader.number("a value")?;
                if value <= most { Ok(value as f64) } else { Err(too_large(at, value, most)) }
            })
            .collect();
        return Ok((side(width), side(height), values?));
    }
    // One blank, then the values.
    reader.at += 1;
    let size = if most < 256 { 1 } else { 2 };
    reader.expect(count.saturating_mul(size))?;
    let mut values = Vec::with_capacity(count);
    for part in bytes[reader.at..].chunks_exact(size).take(count) {
        let value = part.iter().fold(0u64, |value, &byte| value << 8 | u64::from(byte));
        if value > most {
            return Err(too_large(reader.at + values.len() * size, value, most));
        }
        values.push(value as f64);
    }
    Ok((side(width), side(height), values))
}

fn too_large(at: usize, value: u64, most: u64) -> Error {
    Error::malformed(NAME, at, format!("the value {value} is larger than the largest one, {most}"))
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    /// Makes sure that so many bytes are left.
    fn expect(&self, count: usize) -> Result<(), Error> {
        let left = self.bytes.len().saturating_sub(self.at);
        if left >= count {
            return Ok(());
        }
        Err(Error::malformed(
            NAME,
            self.bytes.len(),
            format!("the file ends: {count} bytes of values are needed, {left} are there"),
        ))
    }

    /// A whole number, after blanks and comments.
    fn number(&mut self, what: &str) -> Result<u64, Error> {
        let mut in_comment = false;
        while let Some(byte) = self.bytes.get(self.at) {
            match byte {
                b'\n' | b'\r' => in_comment = false,
                b'#' => in_comment = true,
                _ if in_comment || byte.is_ascii_whitespace() => {}
                _ => break,
            }
            self.at += 1;
        }
        let from = self.at;
        let mut value = 0u64;
        while let Some(digit) = self.bytes.get(self.at).filter(|byte| byte.is_ascii_digit()) {
            value = value.saturating_mul(10).saturating_add(u64::from(digit - b'0'));
            self.at += 1;
        }
        if self.at == from {
            return Err(Error::malformed(NAME, from, format!("{what} is missing")));
        }
        Ok(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_and_binary_files_hold_the_same() {
        let text = b"P2 # grey\n3 2\n# largest\n255\n0 1 2\n253 254 255\n";
        let (width, height, values) = read(text).unwrap();
        assert_eq!((width, height, values.as_slice()), (3, 2, &[0.0, 1.0, 2.0, 253.0, 254.0, 255.0][..]));
        assert_eq!(read(b"P5 3 2 255\n\x00\x01\x02\xfd\xfe\xff").unwrap().2, values);
        assert_eq!(read(b"P5 1 2 1000\n\x03\xe8\x00\x07").unwrap().2, [1000.0, 7.0]);
    }

    #[test]
    fn broken_files_are_refused_with_the_place() {
        for (bytes, what) in [
            (
                &b"P5 3 2 255\n\x00\x01"[..],
                "byte 13: the file ends: 6 bytes of values are needed, 2 are there",
            ),
            (b"P5 3", "byte 4: the height is missing"),
            (b"P5 3 2 0\n", "the largest value is 0"),
            (b"P2 2 1 10 3 11", "the value 11 is larger"),
            (b"P2 2 1 10 3 x", "a value is missing"),
            (b"P5 4294967295 4294967295 255\n", "147573952520956936200 bytes"),
            (b"P5 99999999999999999999999 1 255\n", "bytes"),
        ] {
            let error = read(bytes).unwrap_err().to_string();
            assert!(error.contains(what), "{error}");
        }
    }
}
