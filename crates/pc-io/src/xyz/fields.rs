//! The fields of a line: separators, quotes, comments.

use crate::source::is_blank;

/// What stands between the fields of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Separator {
    /// Blanks and tabs, any number of them.
    Blank,
    /// One comma, semicolon, tab or bar, with or without blanks around it.
    Byte(u8),
}

/// A field without the blanks and quotes around it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Field<'a> {
    pub(super) text: &'a [u8],
    /// Whether it stood in quotes; quotes within it are doubled then.
    pub(super) quoted: bool,
}

impl Field<'_> {
    pub(super) fn is_empty(self) -> bool {
        self.text.is_empty() || !self.quoted && is_nothing(self.text)
    }
}

/// What programs write where there is no number.
fn is_nothing(text: &[u8]) -> bool {
    const WORDS: [&[u8]; 10] =
        [b"NA", b"N/A", b"null", b"none", b"-", b"--", b"#N/A", b"#NV", b"#VALUE!", b"#DIV/0!"];
    WORDS.iter().any(|word| text.eq_ignore_ascii_case(word))
}

/// Whether a line is blank or a comment.
pub(super) fn is_comment(line: &[u8]) -> bool {
    let line = line.trim_ascii_start();
    line.is_empty() || starts_comment(line) || line.starts_with(b"!")
}

/// Whether a comment begins here, where a field could begin.
pub(super) fn starts_comment(text: &[u8]) -> bool {
    let word = text.split(|byte| byte.is_ascii_whitespace() || b",;".contains(byte)).next().unwrap_or(text);
    (text.starts_with(b"#") && !is_nothing(word)) || text.starts_with(b"//") || text.starts_with(b"%")
}

impl Separator {
    fn is(self, byte: u8) -> bool {
        match self {
            Self::Blank => is_blank(byte),
            Self::Byte(own) => byte == own,
        }
    }

    /// Whether a byte may be passed over between fields.
    pub(super) fn is_padding(self, byte: u8) -> bool {
        is_blank(byte) && self != Self::Byte(byte)
    }

    /// Whether a line ends with a separator.
    pub(super) fn ends(self, line: &[u8]) -> bool {
        matches!(self, Self::Byte(byte) if line.iter().rfind(|&&last| !self.is_padding(last)) == Some(&byte))
    }

    /// The fields of a line up to a comment. A separator at its end opens another field, which is empty.
    pub(super) fn fields(self, line: &[u8]) -> Fields<'_> {
        Fields { separator: self, rest: Some(line), is_first: true }
    }

    /// The separator of a line by itself, such as a header: outside quotes a semicolon, else a tab between words that
    /// have blanks in them, else a bar or a comma, else blanks.
    pub(super) fn of(line: &[u8]) -> Self {
        let line = line.trim_ascii();
        let has = |byte: u8| Self::Byte(byte).fields(line).nth(1).is_some();
        if has(b';') {
            return Self::Byte(b';');
        }
        if has(b'\t') && line.iter().any(|&byte| byte == b' ' || byte == b',') {
            return Self::Byte(b'\t');
        }
        [b'|', b','].into_iter().find(|&byte| has(byte)).map_or(Self::Blank, Self::Byte)
    }
}

/// See [`Separator::fields`].
#[derive(Debug, Clone)]
pub(super) struct Fields<'a> {
    separator: Separator,
    rest: Option<&'a [u8]>,
    is_first: bool,
}

impl<'a> Fields<'a> {
    /// Everything that is left of the line, from the next field on, without a comment.
    pub(super) fn tail(&self) -> &'a [u8] {
        let mut fields = self.clone();
        let start = skip(self.rest.unwrap_or_default(), |byte| self.separator.is_padding(byte));
        let end = loop {
            if fields.next().is_none() {
                // What is left after the last field is a comment.
                break fields.rest.map_or(0, <[u8]>::len);
            }
        };
        start[..start.len().saturating_sub(end)].trim_ascii()
    }
}

fn skip(text: &[u8], passed: impl Fn(u8) -> bool) -> &[u8] {
    &text[text.iter().take_while(|&&byte| passed(byte)).count()..]
}

/// The length of a text in quotes with them, if it ends.
pub(super) fn quoted_length(text: &[u8]) -> Option<usize> {
    let mut at = 1;
    while text.first() == Some(&b'"') {
        at += text.get(at..)?.iter().position(|&byte| byte == b'"')? + 1;
        if text.get(at) != Some(&b'"') {
            return Some(at);
        }
        at += 1;
    }
    None
}

impl<'a> Iterator for Fields<'a> {
    type Item = Field<'a>;

    fn next(&mut self) -> Option<Field<'a>> {
        let separator = self.separator;
        let start = skip(self.rest?, |byte| separator.is_padding(byte));
        if starts_comment(start) && !(self.is_first && separator != Separator::Blank) {
            // A field is open before a comment only where a separator says so, and is empty then.
            self.rest = Some(start);
            return None;
        }
        if start.is_empty() && (separator == Separator::Blank || self.is_first) {
            self.rest = None;
            return None;
        }
        self.is_first = false;
        if let Some(length) = quoted_length(start) {
            let after = skip(&start[length..], |byte| separator.is_padding(byte));
            let ended =
                after.is_empty() || separator == Separator::Blank && after.len() < start.len() - length;
            if ended || after.first().is_some_and(|&byte| separator.is(byte)) || starts_comment(after) {
                self.rest = match separator {
                    _ if after.is_empty() => None,
                    Separator::Blank => Some(after),
                    Separator::Byte(byte) => Some(after.strip_prefix(&[byte]).unwrap_or(after)),
                };
                return Some(Field { text: start[1..length - 1].trim_ascii(), quoted: true });
            }
        }
        let mut length = start.len();
        let mut comment = None;
        let mut at = 0;
        while let Some(&byte) = start.get(at) {
            if separator.is(byte) {
                length = at;
                break;
            }
            let spaced = at == 0 || is_blank(start[at - 1]);
            // A comment begins after a blank.
            if at > 0 && spaced && starts_comment(&start[at..]) {
                (length, comment) = (at, Some(&start[at..]));
                break;
            }
            // Words in quotes stay together wherever they stand.
            at += if spaced { quoted_length(&start[at..]).unwrap_or(1) } else { 1 };
        }
        self.rest = comment.or_else(|| start.get(length + 1..));
        Some(Field { text: start[..length].trim_ascii(), quoted: false })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(separator: Separator, line: &str) -> Vec<String> {
        separator
            .fields(line.as_bytes())
            .map(|field| String::from_utf8_lossy(field.text).into_owned())
            .collect()
    }

    #[test]
    fn splits_at_separators_outside_quotes() {
        let comma = Separator::Byte(b',');
        assert_eq!(split(comma, " 1, 2 ,\"a, \"\"b\"\"\",,x y ,"), ["1", "2", "a, \"\"b\"\"", "", "x y", ""]);
        assert_eq!(split(comma, "\"a\"b,2"), ["\"a\"b", "2"]);
        assert_eq!(split(comma, "1,2 # a, b"), ["1", "2"]);
        assert_eq!(split(Separator::Byte(b';'), "1 \"a;b\" 2"), ["1 \"a;b\" 2"]);
        assert_eq!(split(comma, "1,#N/A,3"), ["1", "#N/A", "3"]);
        assert_eq!(split(comma, "P#1,2,3//"), ["P#1", "2", "3//"]);
        assert_eq!(split(Separator::Byte(b'\t'), "1\t\t 3 \t"), ["1", "", "3", ""]);
        assert_eq!(split(Separator::Blank, "  1\t 2  \"a b\" 3 // end"), ["1", "2", "a b", "3"]);
        assert_eq!(split(Separator::Blank, "1 2 3 % of"), ["1", "2", "3"]);
        assert_eq!(split(Separator::Byte(b';'), ""), [""; 0]);
    }

    #[test]
    fn guesses_the_separator_of_a_line() {
        assert_eq!(Separator::of(b"a;b,c"), Separator::Byte(b';'));
        assert_eq!(Separator::of(b"\"a;b\",c"), Separator::Byte(b','));
        assert_eq!(Separator::of(b"x y\tb"), Separator::Byte(b'\t'));
        assert_eq!(Separator::of(b"1\t2"), Separator::Blank);
        assert_eq!(Separator::of(b"a | b"), Separator::Byte(b'|'));
    }

    #[test]
    fn keeps_the_tail_of_a_line() {
        let mut fields = Separator::Blank.fields(b"1 2 3 top left # seen");
        assert_eq!(fields.nth(2).map(|field| field.text), Some(b"3".as_slice()));
        assert_eq!(fields.tail(), b"top left");
    }
}
