//! Free format values: separated by a delimiter, ended by another, strings as `5Htexts`.

use super::fault::{EntityId, Fault};
use super::records::Line;

/// A value as it stands in the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Value<'t> {
    /// Nothing between two delimiters: the default of the standard.
    Empty,
    /// A string without its count.
    Text(&'t [u8]),
    /// A number or a word, without blanks around it.
    Plain(&'t [u8]),
}

/// The two characters that part and end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Delimiters {
    /// Between values.
    pub(crate) value: u8,
    /// After the last value of a record.
    pub(crate) record: u8,
}

/// The text of consecutive lines as one, with a way back to the lines.
#[derive(Debug)]
pub(crate) struct Tokens {
    bytes: Vec<u8>,
    /// Number of each line in the file, and where its text begins.
    starts: Vec<(usize, usize)>,
    at: usize,
    ended: bool,
    entity: Option<EntityId>,
}

impl Tokens {
    /// Joins the first `width` columns of each line; those that the writer left out are blanks.
    pub(crate) fn new<'a>(
        lines: impl Iterator<Item = &'a Line<'a>>,
        width: usize,
        entity: Option<EntityId>,
    ) -> Self {
        let (mut bytes, mut starts) = (Vec::new(), Vec::new());
        for line in lines {
            starts.push((line.number, bytes.len()));
            // Longer than 72 columns only where characters were counted and not bytes.
            let text = if width >= 72 { line.text } else { line.columns(0, width) };
            bytes.extend_from_slice(text);
            bytes.resize(bytes.len() + width.saturating_sub(text.len()), b' ');
        }
        Self { bytes, starts, at: 0, ended: false, entity }
    }

    /// Number of the line that is being read.
    pub(crate) fn line(&self) -> usize {
        let after = self.starts.partition_point(|&(_, start)| start <= self.at);
        self.starts.get(after.saturating_sub(1)).map_or(0, |&(number, _)| number)
    }

    /// Whether the end of the record was read.
    pub(crate) const fn is_ended(&self) -> bool {
        self.ended
    }

    /// Bytes that are left, which bounds the number of values that are left.
    pub(crate) fn left(&self) -> usize {
        if self.ended { 0 } else { self.bytes.len() - self.at }
    }

    /// A fault at the line that is being read.
    pub(crate) fn fault(&self, what: impl Into<String>) -> Fault {
        Fault { entity: self.entity, ..Fault::at_line(self.line(), what) }
    }

    /// The next byte that is no blank, without reading it.
    pub(crate) fn peek(&mut self) -> Option<u8> {
        while self.bytes.get(self.at) == Some(&b' ') {
            self.at += 1;
        }
        self.bytes.get(self.at).copied()
    }

    /// Reads one byte past [`peek`](Self::peek).
    pub(crate) fn skip(&mut self) {
        self.at = (self.at + 1).min(self.bytes.len());
    }

    /// The string that begins here, if one does.
    pub(crate) fn text(&mut self) -> Result<Option<&[u8]>, Fault> {
        self.peek();
        let digits = self.bytes[self.at..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        if digits == 0 || !matches!(self.bytes.get(self.at + digits), Some(b'H' | b'h')) {
            return Ok(None);
        }
        let start = self.at + digits + 1;
        let count = std::str::from_utf8(&self.bytes[self.at..self.at + digits]).ok();
        let count: Option<usize> = count.and_then(|count| count.parse().ok());
        match count.and_then(|count| start.checked_add(count)).filter(|&end| end <= self.bytes.len()) {
            Some(end) => {
                self.at = end;
                Ok(Some(&self.bytes[start..end]))
            }
            None => Err(self.fault("a string is longer than its record")),
        }
    }

    /// The next value; [`Value::Empty`] after the end of the record.
    pub(crate) fn next(&mut self, delimiters: Delimiters) -> Result<Value<'_>, Fault> {
        if self.ended {
            return Ok(Value::Empty);
        }
        let range = self.text()?.map(<[u8]>::len).map(|length| self.at - length..self.at);
        if let Some(range) = range {
            self.delimiter(delimiters, "a string")?;
            return Ok(Value::Text(&self.bytes[range]));
        }
        let start = self.at;
        let is_end = |byte: &u8| *byte == delimiters.value || *byte == delimiters.record;
        let Some(length) = self.bytes[start..].iter().position(is_end) else {
            let what = format!("the record is not ended by `{}`", char::from(delimiters.record));
            return Err(self.fault(what));
        };
        self.at = start + length;
        self.delimiter(delimiters, "a value")?;
        let value = self.bytes[start..start + length].trim_ascii();
        Ok(if value.is_empty() { Value::Empty } else { Value::Plain(value) })
    }

    fn delimiter(&mut self, delimiters: Delimiters, after: &str) -> Result<(), Fault> {
        match self.peek() {
            Some(byte) if byte == delimiters.record => self.ended = true,
            Some(byte) if byte == delimiters.value => {}
            _ => {
                let what = format!("`{}` is missing after {after}", char::from(delimiters.value));
                return Err(self.fault(what));
            }
        }
        self.at += 1;
        Ok(())
    }
}

/// A real number: Fortran notation, the exponent after `E` or `D`.
pub(crate) fn real(text: &[u8]) -> Option<f64> {
    let allowed = |byte: &u8| byte.is_ascii_digit() || b"+-.EeDd".contains(byte);
    if text.is_empty() || !text.iter().all(allowed) {
        return None;
    }
    let text = std::str::from_utf8(text).ok()?;
    let value: f64 = match text.find(['D', 'd']) {
        Some(_) => text.replace(['D', 'd'], "E").parse().ok()?,
        None => text.parse().ok()?,
    };
    value.is_finite().then_some(value)
}

/// An integer; also one that was written as a real number.
pub(crate) fn integer(text: &[u8]) -> Option<i64> {
    if let Some(value) = std::str::from_utf8(text).ok().and_then(|text| text.parse().ok()) {
        return Some(value);
    }
    #[expect(clippy::cast_possible_truncation, reason = "whole and below 2^53, as just checked")]
    real(text).filter(|value| value.fract() == 0.0 && value.abs() < 9e15).map(|value| value as i64)
}

/// A string as text: UTF-8, or else Latin-1.
pub(crate) fn decoded(text: &[u8]) -> String {
    match std::str::from_utf8(text) {
        Ok(text) => text.trim().to_owned(),
        Err(_) => text.iter().map(|&byte| char::from(byte)).collect::<String>().trim().to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const USUAL: Delimiters = Delimiters { value: b',', record: b';' };

    fn tokens(lines: &[&str]) -> Tokens {
        let lines: Vec<Line<'_>> =
            (7..).zip(lines).map(|(number, text)| Line { number, text: text.as_bytes() }).collect();
        Tokens::new(lines.iter(), 8, None)
    }

    #[test]
    fn values_strings_and_defaults() {
        // The string goes on in the next line; its first line was cut after its last visible character.
        let mut t = tokens(&["1,, 6Ha", "b;,  ,2", ".5 ;rest"]);
        assert_eq!(t.next(USUAL), Ok(Value::Plain(b"1")));
        assert_eq!(t.next(USUAL), Ok(Value::Empty));
        assert_eq!(t.next(USUAL), Ok(Value::Text(b"a b;, ")));
        assert_eq!(t.line(), 8);
    }

    #[test]
    fn records_end_and_faults_name_the_line() {
        let mut t = tokens(&["1,2 ;junk"]);
        assert_eq!(t.next(USUAL), Ok(Value::Plain(b"1")));
        assert_eq!(t.next(USUAL), Ok(Value::Plain(b"2")));
        assert!(t.is_ended());
        assert_eq!(t.next(USUAL), Ok(Value::Empty));
        let mut t = tokens(&["1,", "2"]);
        t.next(USUAL).unwrap();
        assert_eq!(t.next(USUAL).unwrap_err().line, 8);
        assert!(tokens(&["99Hx"]).next(USUAL).unwrap_err().what.contains("longer"));
        assert!(tokens(&["2Habc,"]).next(USUAL).unwrap_err().what.contains("missing"));
    }

    #[test]
    fn numbers_in_fortran_notation() {
        let cases =
            [("1.", 1.0), (".5", 0.5), ("-1.5D-3", -1.5e-3), ("+2E+02", 200.0), ("7", 7.0), ("-0.", -0.0)];
        for (text, value) in cases {
            assert_eq!(real(text.as_bytes()).map(f64::to_bits), Some(f64::to_bits(value)), "{text}");
        }
        for text in ["", "nan", "inf", "1E999", "1 2", "0x1", "--1", "1.2.3"] {
            assert_eq!(real(text.as_bytes()), None, "{text}");
        }
        assert_eq!((integer(b"3."), integer(b"-7"), integer(b"2.5")), (Some(3), Some(-7), None));
    }
}
