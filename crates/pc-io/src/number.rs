//! Numbers as text, both ways.

use std::io::{self, Write};

/// Powers of ten that are exact doubles.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];
/// Integers up to here are exact doubles.
const EXACT: u64 = 1 << 53;
/// Below this another digit fits into 64 bits.
const ROOM: u64 = 1_000_000_000_000_000_000;

/// The number at the start of `text` and its length in bytes; correctly rounded.
///
/// Reads what programs write: a sign, `1.`, `.5`, exponents after `e`, `E`, `d` or `D`, `inf`, `infinity` and `nan` in
/// any case (also `nan(ind)`), and `1.#QNAN`, `1.#INF`.
pub(crate) fn lex(text: &[u8]) -> Option<(f64, usize)> {
    let digit = |at: usize| text.get(at).map(|byte| byte.wrapping_sub(b'0')).filter(|&value| value < 10);
    let negative = text.first() == Some(&b'-');
    let start = usize::from(matches!(text.first(), Some(b'-' | b'+')));
    let mut at = start;
    let (mut mantissa, mut exponent, mut exact) = (0u64, 0i32, true);
    let mut digits = 0usize;
    while let Some(value) = digit(at) {
        if mantissa < ROOM {
            mantissa = mantissa * 10 + u64::from(value);
        } else {
            exponent = exponent.saturating_add(1);
            exact &= value == 0;
        }
        at += 1;
        digits += 1;
    }
    if text.get(at) == Some(&b'.') {
        at += 1;
        while let Some(value) = digit(at) {
            if mantissa < ROOM {
                mantissa = mantissa * 10 + u64::from(value);
                exponent = exponent.saturating_sub(1);
            } else {
                exact &= value == 0;
            }
            at += 1;
            digits += 1;
        }
    }
    if digits == 0 {
        return lex_special(text, start, negative);
    }
    if text.get(at) == Some(&b'#') {
        let length = text[at + 1..].iter().take_while(|byte| byte.is_ascii_alphanumeric()).count();
        let infinite = text[at + 1..].len() >= 3 && text[at + 1..at + 4].eq_ignore_ascii_case(b"inf");
        return Some((special(infinite, negative), at + 1 + length));
    }
    let mut fortran = None;
    if let Some(b'e' | b'E' | b'd' | b'D') = text.get(at) {
        let signed = usize::from(matches!(text.get(at + 1), Some(b'-' | b'+')));
        let mut end = at + 1 + signed;
        let mut written = 0i32;
        while let Some(value) = digit(end) {
            written = written.saturating_mul(10).saturating_add(i32::from(value));
            end += 1;
        }
        if end > at + 1 + signed {
            fortran = matches!(text[at], b'd' | b'D').then_some(at);
            exponent = exponent.saturating_add(if text[at + 1] == b'-' { -written } else { written });
            at = end;
        }
    }
    // Both factors are exact, so that one correctly rounded operation gives the correctly rounded value.
    if exact && mantissa <= EXACT && exponent.unsigned_abs() < 23 {
        let power = POWERS[exponent.unsigned_abs() as usize];
        let value = if exponent < 0 { mantissa as f64 / power } else { mantissa as f64 * power };
        return Some((if negative { -value } else { value }, at));
    }
    let literal = std::str::from_utf8(&text[..at]).ok()?;
    let value = match fortran {
        None => literal.parse().ok()?,
        Some(at) => format!("{}e{}", &literal[..at], &literal[at + 1..]).parse().ok()?,
    };
    Some((value, at))
}

fn lex_special(text: &[u8], start: usize, negative: bool) -> Option<(f64, usize)> {
    let word = &text[start..];
    let is = |name: &[u8]| word.len() >= name.len() && word[..name.len()].eq_ignore_ascii_case(name);
    for (name, infinite) in [(b"infinity".as_slice(), true), (b"inf", true), (b"nan", false)] {
        if is(name) {
            let mut end = start + name.len();
            if !infinite && text.get(end) == Some(&b'(') {
                let inside =
                    text[end..].iter().take_while(|&&byte| byte != b')' && byte.is_ascii_graphic()).count();
                // A bracket that nothing closes does not belong to the number.
                end += if text.get(end + inside) == Some(&b')') { inside + 1 } else { 0 };
            }
            return Some((special(infinite, negative), end));
        }
    }
    None
}

fn special(infinite: bool, negative: bool) -> f64 {
    let value = if infinite { f64::INFINITY } else { f64::NAN };
    if negative { -value } else { value }
}

/// The number that all of `text` stands for.
pub(crate) fn parse(text: &[u8]) -> Option<f64> {
    lex(text).filter(|&(_, length)| length == text.len()).map(|(value, _)| value)
}

/// The unsigned integer that all of `text` stands for.
pub(crate) fn parse_count(text: &[u8]) -> Option<u64> {
    std::str::from_utf8(text).ok()?.parse().ok()
}

pub(crate) fn starts_with_number(text: &[u8]) -> bool {
    lex(text).is_some()
}

/// Writes the shortest text that reads back as the same double, with an exponent where it would grow long; `nan`, `inf`,
/// `-inf` for the others.
///
/// # Errors
/// Those of `out`.
pub fn write_number(out: &mut dyn Write, value: f64) -> io::Result<()> {
    let size = value.abs();
    if value.is_nan() {
        out.write_all(b"nan")
    } else if size >= 1e16 || (size < 1e-5 && size > 0.0) {
        write!(out, "{value:e}")
    } else {
        write!(out, "{value}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn reads_what_programs_write() {
        for (text, value) in [
            ("1", 1.0),
            ("+1.", 1.0),
            (".5", 0.5),
            ("-.5e1", -5.0),
            ("1.5D+03", 1500.0),
            ("1e-400", 0.0),
            ("1e400", f64::INFINITY),
            ("123456789012345678901234567890", 123456789012345678901234567890.0),
            ("0.1234567890123456789012345", 0.123_456_789_012_345_68),
            ("INF", f64::INFINITY),
            ("-Infinity", f64::NEG_INFINITY),
            ("-1.#INF", f64::NEG_INFINITY),
            ("9007199254740993", 9007199254740993.0),
            ("1e99999999999999999999", f64::INFINITY),
            ("0e99999999999", 0.0),
            ("1.7976931348623157e308", f64::MAX),
            ("5e-324", 5e-324),
            ("123456789012345678901234567890d-2", 1234567890123456789012345678.9),
        ] {
            assert_eq!(parse(text.as_bytes()), Some(value), "{text}");
        }
        for text in ["nan", "-NaN", "nan(ind)", "1.#QNAN", "-1.#IND00"] {
            assert!(parse(text.as_bytes()).is_some_and(f64::is_nan), "{text}");
        }
        for text in ["", "-", ".", "e5", "1,5", "1e", "x", "--1", "1.2.3", "0x10", "nan(", "in"] {
            assert_eq!(parse(text.as_bytes()).filter(|value| !value.is_nan()), None, "{text}");
        }
        assert_eq!(lex(b"3.1+e2"), Some((3.1, 3)));
        assert!(parse(b"-0").is_some_and(|zero| zero == 0.0 && zero.is_sign_negative()));
    }

    proptest! {
        #[test]
        fn agrees_with_the_standard_library(text in "[+-]?[0-9]{0,25}\\.?[0-9]{0,25}([eE][+-]?[0-9]{1,3})?") {
            let expected = text.parse::<f64>().ok();
            prop_assert_eq!(parse(text.as_bytes()).map(f64::to_bits), expected.map(f64::to_bits));
        }

        #[test]
        fn round_trips_every_bit(value in prop::num::f64::ANY) {
            let mut text = Vec::new();
            write_number(&mut text, value).unwrap();
            let read = parse(&text).unwrap();
            prop_assert!(read.to_bits() == value.to_bits() || read.is_nan() && value.is_nan());
        }
    }
}
