//! How numbers are written: the decimal sign, and the sign between thousands.

use crate::number;

/// The decimal sign of a table, and whether the other one of `.` and `,` may stand between thousands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Notation {
    /// 1.5, and 1,234.5 if grouped.
    Point { grouped: bool },
    /// 1,5, and 1.234,5 if grouped.
    Comma { grouped: bool },
}

pub(super) const PLAIN: Notation = Notation::Point { grouped: false };

/// What the numbers seen so far say about their notation.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Evidence {
    /// A point, or a comma, that can be nothing but a decimal sign.
    point: bool,
    comma: bool,
    /// One that can only stand between thousands.
    point_groups: bool,
    comma_groups: bool,
    /// One before exactly three digits, which can be either.
    point_open: bool,
    comma_open: bool,
}

/// What follows from the evidence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Found {
    /// One notation fits all numbers.
    Certain(Notation),
    /// Commas before three digits everywhere, and no point: decimals or thousands.
    OpenComma,
    /// No notation fits all numbers.
    Contradiction,
}

impl Evidence {
    /// Takes a field into account; of text nothing follows.
    pub(super) fn add(&mut self, text: &[u8]) {
        // Spaces and apostrophes between thousands say nothing about the other signs.
        let is_other = |byte: &&u8| !matches!(byte, b' ' | b'\'' | 0x80..);
        let text: Vec<u8> = text.iter().filter(is_other).copied().collect();
        let body = text.strip_prefix(b"-").or_else(|| text.strip_prefix(b"+")).unwrap_or(&text);
        let end =
            body.iter().position(|byte| !byte.is_ascii_digit() && !is_sign(*byte)).unwrap_or(body.len());
        let (digits, exponent) = body.split_at(end);
        let is_number = digits.iter().any(u8::is_ascii_digit)
            && (exponent.is_empty() || matches!(exponent[0], b'e' | b'E' | b'd' | b'D'));
        if !is_number {
            return;
        }
        let count = |sign: u8| digits.iter().filter(|&&byte| byte == sign).count();
        let last = digits.iter().rev().find(|&&byte| byte == b'.' || byte == b',');
        let (points, commas) = (count(b'.'), count(b','));
        let Some(&last) = last else { return };
        let after = digits.iter().rev().take_while(|byte| byte.is_ascii_digit()).count();
        let before = digits.iter().take_while(|byte| byte.is_ascii_digit()).count();
        // Thousands never begin with a zero or with more than three digits, and have no exponent.
        let can_group = after == 3 && (1..=3).contains(&before) && digits[0] != b'0' && exponent.is_empty();
        match (points, commas, last) {
            (1, 0, _) if can_group => self.point_open = true,
            (1, 0, _) => self.point = true,
            (0, 1, _) if can_group => self.comma_open = true,
            (0, 1, _) => self.comma = true,
            (0, _, _) => self.comma_groups = true,
            (_, 0, _) => self.point_groups = true,
            (1, _, b'.') => (self.point, self.comma_groups) = (true, true),
            (_, 1, b',') => (self.comma, self.point_groups) = (true, true),
            _ => (self.point, self.comma) = (true, true),
        }
    }

    /// The notation that fits. Signs before three digits are thousands only where others are for certain.
    pub(super) const fn found(self) -> Found {
        let by_point = self.point || self.comma_groups;
        let by_comma = self.comma || self.point_groups;
        match (by_point, by_comma) {
            (true, true) => Found::Contradiction,
            (true, false) if self.comma_open && !self.comma_groups => Found::Contradiction,
            (true, false) => Found::Certain(Notation::Point { grouped: self.comma_groups }),
            (false, true) if self.point_open && !self.point_groups => Found::Contradiction,
            (false, true) => Found::Certain(Notation::Comma { grouped: self.point_groups }),
            (false, false) if self.comma_open && self.point_open => Found::Contradiction,
            (false, false) if self.comma_open => Found::OpenComma,
            (false, false) => Found::Certain(PLAIN),
        }
    }
}

const fn is_sign(byte: u8) -> bool {
    byte == b'.' || byte == b','
}

impl Notation {
    /// The number that all of `text` stands for. Apostrophes and spaces may stand between thousands in any notation.
    pub(super) fn parse(self, text: &[u8]) -> Option<f64> {
        let (decimal, group, grouped) = match self {
            Self::Point { grouped } => (b'.', b',', grouped),
            Self::Comma { grouped } => (b',', b'.', grouped),
        };
        if decimal == b'.'
            && let Some(value) = number::parse(text)
        {
            return Some(value);
        }
        let text = unspaced(text)?;
        if text.len() > LONGEST {
            return None;
        }
        let end =
            text.iter().position(|&byte| byte == decimal || byte.is_ascii_alphabetic()).unwrap_or(text.len());
        let (whole, rest) = text.split_at(end);
        if !grouped && whole.contains(&group) {
            return None;
        }
        let mut plain = Vec::with_capacity(text.len());
        plain.extend(without_groups(whole, if grouped { group } else { b'\'' })?);
        match rest.split_first() {
            Some((&first, fraction)) if first == decimal => {
                if fraction.contains(&decimal) || fraction.contains(&group) {
                    return None;
                }
                plain.push(b'.');
                plain.extend(fraction);
            }
            _ => plain.extend(rest),
        }
        number::parse(&plain)
    }
}

/// Longest number that is looked at in a notation other than the plain one.
const LONGEST: usize = 400;

/// The whole part of a number without the signs between its thousands; `None` where they stand elsewhere.
fn without_groups(whole: &[u8], sign: u8) -> Option<Vec<u8>> {
    let is_group = |byte: u8| byte == sign || byte == b'\'';
    if !whole.iter().any(|&byte| is_group(byte)) {
        return Some(whole.to_vec());
    }
    let digits = whole.strip_prefix(b"-").or_else(|| whole.strip_prefix(b"+")).unwrap_or(whole);
    for (place, group) in digits.split(|&byte| is_group(byte)).enumerate() {
        let fits = if place == 0 { (1..=3).contains(&group.len()) } else { group.len() == 3 };
        if !fits || !group.iter().all(u8::is_ascii_digit) {
            return None;
        }
    }
    Some(whole.iter().copied().filter(|&byte| !is_group(byte)).collect())
}

/// The text with spaces between groups of digits made apostrophes: blanks, and those that do not break a line.
fn unspaced(text: &[u8]) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(text.len());
    let mut rest = text;
    while let Some((&first, tail)) = rest.split_first() {
        let length = match rest {
            [0xc2, 0xa0, ..] => 2,
            [0xe2, 0x80, 0xaf | 0x89, ..] => 3,
            [b' ' | 0xa0, ..] => 1,
            _ => 0,
        };
        if length == 0 {
            out.push(first);
            rest = tail;
        } else {
            // Two in a row are no sign between thousands.
            if out.last() == Some(&b'\'') {
                return None;
            }
            out.push(b'\'');
            rest = &rest[length..];
        }
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(fields: &[&str]) -> Found {
        let mut evidence = Evidence::default();
        fields.iter().for_each(|field| evidence.add(field.as_bytes()));
        evidence.found()
    }

    #[test]
    fn tells_the_decimal_sign() {
        let comma = |grouped| Found::Certain(Notation::Comma { grouped });
        let point = |grouped| Found::Certain(Notation::Point { grouped });
        assert_eq!(found(&["1,5", "2", "-4,125"]), comma(false));
        assert_eq!(found(&["0,125", "1,125"]), comma(false));
        assert_eq!(found(&["1.234,5", "2.000"]), comma(true));
        assert_eq!(found(&["1.234.567", "1,25e3"]), comma(true));
        assert_eq!(found(&["1,234.5", "12,000"]), point(true));
        assert_eq!(found(&["1.5", "1.234", "7", "text", ",,"]), point(false));
        assert_eq!(found(&["1,234", "5"]), Found::OpenComma);
        assert_eq!(found(&["1,234", "1.5"]), Found::Contradiction);
        assert_eq!(found(&["1,5", "2.25"]), Found::Contradiction);
        assert_eq!(found(&["1,5", "2.125"]), Found::Contradiction);
    }

    #[test]
    fn reads_both_notations() {
        let comma = Notation::Comma { grouped: true };
        for (text, value) in [
            ("-1.234.567,25", Some(-1234567.25)),
            ("1,5e3", Some(1500.0)),
            ("1.23,5", None),
            ("1,5,5", None),
            ("1.5", None),
            ("1 234,5", Some(1234.5)),
            ("1\u{a0}234,5", Some(1234.5)),
            ("1\u{202f}234", Some(1234.0)),
            ("1  234", None),
            ("12'345,5", Some(12345.5)),
            ("nan", Some(f64::NAN)),
            (",5", Some(0.5)),
            (",", None),
        ] {
            let read = comma.parse(text.as_bytes());
            assert!(
                read == value || read.is_some_and(f64::is_nan) && value.is_some_and(f64::is_nan),
                "{text}: {read:?}"
            );
        }
        assert_eq!(Notation::Comma { grouped: false }.parse(b"1.234,5"), None);
        assert_eq!(Notation::Point { grouped: true }.parse(b"+1,234,567.5"), Some(1_234_567.5));
        assert_eq!(PLAIN.parse(b"1,234"), None);
        assert_eq!(PLAIN.parse(b"1'234.5"), Some(1234.5));
    }
}
