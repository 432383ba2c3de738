//! Numbers as text that reads back to the same bits.

use std::io::Write;

/// Appends the shortest decimal text of a finite double, with an exponent where it would grow long.
///
/// Other values become `nan`, `inf` and `-inf`.
pub(super) fn append(bytes: &mut Vec<u8>, value: f64) {
    let size = value.abs();
    // Writing to memory cannot fail.
    let _ = if value.is_nan() {
        bytes.write_all(b"nan")
    } else if size >= 1e16 || (size < 1e-5 && size > 0.0) {
        write!(bytes, "{value:e}")
    } else {
        write!(bytes, "{value}")
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_reads_back() {
        for value in [0.0, -0.0, 0.1, -1.0 / 3.0, 1e-300, f64::MAX, f64::MIN_POSITIVE, 1e16, f64::INFINITY] {
            let mut bytes = Vec::new();
            append(&mut bytes, value);
            let text = String::from_utf8(bytes).unwrap();
            assert_eq!(text.parse::<f64>().unwrap().to_bits(), value.to_bits(), "{text}");
            assert!(text.len() < 25, "{text}");
        }
    }
}
