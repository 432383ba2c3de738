//! Bytes, lines, and the places of errors in them.

use std::borrow::Cow;
use std::fmt;

use memchr::{memchr_iter, memchr2};

use crate::error::Location;
use crate::{Error, Place};

/// The bytes of a file.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Source<'a> {
    pub(crate) data: &'a [u8],
}

impl<'a> Source<'a> {
    /// The line, counted from 1, that holds the byte at `offset`.
    pub(crate) fn line_at(self, offset: usize) -> usize {
        let before = &self.data[..offset.min(self.data.len())];
        let lone_returns =
            memchr_iter(b'\r', before).filter(|&at| self.data.get(at + 1) != Some(&b'\n')).count();
        1 + memchr_iter(b'\n', before).count() + lone_returns
    }

    /// An error at the line that holds the byte at `offset`.
    pub(crate) fn line_error(
        self,
        offset: usize,
        what: impl Into<String>,
        advice: impl Into<String>,
    ) -> Error {
        Error::malformed(Place::Line(self.line_at(offset)), what, advice)
    }

    /// Checks, before anything is allocated, that `promised` items of at least `size` bytes fit into what is left.
    pub(crate) fn check_promise(
        self,
        offset: usize,
        what: impl fmt::Display,
        promised: u64,
        size: usize,
        text: bool,
    ) -> Result<usize, Error> {
        let left = self.data.len().saturating_sub(offset) as u64;
        // The separator after the last number of a text may be missing.
        let needed = promised.saturating_mul(size as u64).saturating_sub(u64::from(text && promised > 0));
        match usize::try_from(promised) {
            Ok(count) if needed <= left => Ok(count),
            _ => {
                let place = if text { Place::Line(self.line_at(offset)) } else { Place::Byte(offset) };
                Err(Error::Truncated {
                    location: Location { file: None, place },
                    what: what.to_string(),
                    promised,
                    needed,
                    left,
                })
            }
        }
    }

    pub(crate) fn lines_from(self, offset: usize) -> Lines<'a> {
        Lines { data: self.data, next: offset.min(self.data.len()) }
    }
}

/// Lines with the offsets of their first bytes. A line ends with `\n`, `\r\n` or `\r`, which do not belong to it.
#[derive(Debug, Clone)]
pub(crate) struct Lines<'a> {
    data: &'a [u8],
    next: usize,
}

impl<'a> Lines<'a> {
    pub(crate) const fn new(data: &'a [u8]) -> Self {
        Self { data, next: 0 }
    }

    /// Offset of the line that comes next.
    pub(crate) const fn offset(&self) -> usize {
        self.next
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (usize, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        let start = self.next;
        let rest = self.data.get(start..).filter(|rest| !rest.is_empty())?;
        let length = memchr2(b'\n', b'\r', rest).unwrap_or(rest.len());
        let ending = match rest.get(length..) {
            Some([b'\r', b'\n', ..]) => 2,
            Some([]) | None => 0,
            Some(_) => 1,
        };
        self.next = start + length + ending;
        Some((start, &rest[..length]))
    }
}

/// Blank within a line.
pub(crate) const fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | 0x0b | 0x0c)
}

/// The words of a line.
pub(crate) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(|&byte| is_blank(byte)).filter(|word| !word.is_empty())
}

/// Text for messages: whatever is not UTF-8 is replaced, and long texts are cut.
pub(crate) fn quoted(text: &[u8]) -> String {
    const LONGEST: usize = 40;
    let shown = String::from_utf8_lossy(&text[..text.len().min(LONGEST)]);
    let dots = if text.len() > LONGEST { "…" } else { "" };
    format!("\"{}{dots}\"", shown.escape_debug())
}

/// A name or label in UTF-8, else in the code page of Western Windows.
pub(crate) fn decode_name(text: &[u8]) -> Cow<'_, str> {
    // The characters 80 to 9f; the others are those of Latin 1.
    const WINDOWS: [char; 32] = [
        '€', '\u{81}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{8d}', 'Ž', '\u{8f}',
        '\u{90}', '‘', '’', '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{9d}', 'ž', 'Ÿ',
    ];
    std::str::from_utf8(text).map_or_else(
        |_| {
            let letter = |&byte: &u8| match byte {
                0x80..=0x9f => WINDOWS[usize::from(byte - 0x80)],
                _ => char::from(byte),
            };
            Cow::Owned(text.iter().map(letter).collect())
        },
        Cow::Borrowed,
    )
}

/// Whether text of two bytes per letter begins here, and in which order the bytes are, without a mark: letters of
/// ASCII, of which more than a few are looked at.
fn wide_order(data: &[u8]) -> Option<bool> {
    let head = &data[..data.len().min(256)];
    let pairs = || head.chunks_exact(2).map(|pair| [pair[0], pair[1]]);
    let is_letter = |byte: u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
    let all = |letter: usize| pairs().all(|pair| pair[1 - letter] == 0 && is_letter(pair[letter]));
    if head.len() < 16 {
        return None;
    }
    all(0).then_some(true).or_else(|| all(1).then_some(false))
}

/// Removes the byte order mark of UTF-8, and turns UTF-16 into UTF-8.
pub(crate) fn decode_text(data: &[u8]) -> Cow<'_, [u8]> {
    let wide = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
        let text: String =
            char::decode_utf16(units).map(|decoded| decoded.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
        Cow::Owned(text.into_bytes())
    };
    match data {
        [0xef, 0xbb, 0xbf, rest @ ..] => Cow::Borrowed(rest),
        [0xfe, 0xff, rest @ ..] => wide(rest, u16::from_be_bytes),
        [0xff, 0xfe, rest @ ..] => wide(rest, u16::from_le_bytes),
        _ => match wide_order(data) {
            Some(true) => wide(data, u16::from_le_bytes),
            Some(false) => wide(data, u16::from_be_bytes),
            None => Cow::Borrowed(data),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splits_lines_of_every_kind() {
        let data = b"a\nb\r\n\rc\rd";
        let lines: Vec<_> = Lines::new(data).collect();
        assert_eq!(lines, [(0, b"a".as_slice()), (2, b"b"), (5, b""), (6, b"c"), (8, b"d")]);
        let source = Source { data };
        assert_eq!(lines.iter().map(|&(at, _)| source.line_at(at)).collect::<Vec<_>>(), [1, 2, 3, 4, 5]);
    }

    #[test]
    fn decodes_utf_16() {
        assert_eq!(decode_text(b"\xfe\xff\0v\0 ").as_ref(), b"v ");
        assert_eq!(decode_text(b"\xff\xfev\0 \0\xe4\0").as_ref(), "v ä".as_bytes());
        assert_eq!(decode_text(b"\xef\xbb\xbfv").as_ref(), b"v");
        let bare: Vec<u8> = b"v 1 2 3\nv 4".iter().flat_map(|&byte| [byte, 0]).collect();
        assert_eq!(decode_text(&bare).as_ref(), b"v 1 2 3\nv 4");
        assert_eq!(decode_name(b"H\xf6he \x80"), "Höhe €");
    }

    #[test]
    fn compares_promises_with_the_bytes_left() {
        let source = Source { data: b"1 2\n3 4" };
        assert_eq!(source.check_promise(0, "points", 2, 4, true).unwrap(), 2);
        let error = source.check_promise(4, "points", 1_000_000_000_000, 4, true).unwrap_err();
        assert!(error.to_string().starts_with("line 2: 1000000000000 points are promised"), "{error}");
        assert!(source.check_promise(0, "points", u64::MAX, 24, false).is_err());
    }
}
