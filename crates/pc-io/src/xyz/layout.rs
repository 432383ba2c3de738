//! How the lines of a table are built: separator, header, count.

use crate::columns::{is_position, names_a_position};
use crate::number::{lex, parse, parse_count};
use crate::source::{Source, is_blank, quoted, words};
use crate::{Error, Format};

/// What stands between the numbers of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Separator {
    /// Blanks and tabs.
    Blank,
    /// A comma, semicolon or tab, with or without blanks around it.
    Byte(u8),
}

/// What the beginning of a table tells.
#[derive(Debug)]
pub(super) struct Layout {
    pub(super) separator: Separator,
    /// Names of the columns, where there is a header line.
    pub(super) names: Option<Vec<String>>,
    /// Places of named columns, other than coordinates, that hold text in the first row.
    pub(super) texts: Vec<usize>,
    /// The number of points in the first line of a PTS file.
    pub(super) promised: Option<u64>,
    /// Where the rows begin.
    pub(super) data: usize,
}

/// Whether a line is blank or a comment.
pub(super) fn is_comment(line: &[u8]) -> bool {
    let line = line.trim_ascii_start();
    line.is_empty() || line.starts_with(b"#") || line.starts_with(b"//")
}

/// Whether a line consists of numbers, of which it has two or more (or one count, as in PTS).
pub(crate) fn looks_like_row(line: &[u8]) -> bool {
    let separator = Separator::of(line);
    let fields: Vec<_> = separator.fields(line).map(unquoted).collect();
    match fields.as_slice() {
        [] => false,
        [count] => parse_count(count).is_some(),
        fields => fields.iter().all(|field| parse(field).is_some()) || has_decimal_comma(line),
    }
}

/// Whether a line, perhaps a comment, names columns among which are x and y.
pub(crate) fn looks_like_header(line: &[u8]) -> bool {
    names_a_position(names(uncommented(line)).iter().map(String::as_str))
}

/// A line without the signs of a comment before it.
fn uncommented(line: &[u8]) -> &[u8] {
    let line = line.trim_ascii();
    &line[line.iter().take_while(|&&byte| matches!(byte, b'#' | b'/')).count()..]
}

/// The format of a file whose rows are like this one.
pub(crate) fn format_of_row(line: &[u8]) -> Format {
    match Separator::of(line) {
        Separator::Byte(_) => Format::Csv,
        Separator::Blank if parse_count(line.trim_ascii()).is_some() => Format::Pts,
        Separator::Blank => Format::Xyz,
    }
}

impl Layout {
    pub(super) fn detect(source: Source<'_>) -> Result<Self, Error> {
        let mut lines = source.lines_from(0);
        let mut described: Option<&[u8]> = None;
        let mut data = source.data.len();
        let mut first: Option<&[u8]> = None;
        for (at, line) in lines.by_ref() {
            if !is_comment(line) {
                (first, data) = (Some(line), at);
                break;
            }
            // Names may stand in the last comment before the rows: "# x y z" or "//X Y Z".
            let comment = uncommented(line);
            if names_a_position(names(comment).iter().map(String::as_str)) {
                described = Some(comment);
            }
        }
        let Some(mut row) = first else {
            return Ok(Self {
                separator: Separator::Blank,
                names: described.map(names),
                texts: Vec::new(),
                promised: None,
                data,
            });
        };
        let promised = parse_count(row.trim_ascii());
        let is_header = promised.is_none()
            && Separator::of(row).fields(row).any(|field| parse(unquoted(field)).is_none());
        let mut header = None;
        if is_header && !has_decimal_comma(row) {
            header = Some((row, data));
        }
        if promised.is_some() || header.is_some() {
            data = lines.offset();
            row = lines.find(|(_, line)| !is_comment(line)).map_or(b"".as_slice(), |(_, line)| line);
        }
        if has_decimal_comma(row) {
            return Err(decimal_comma(source, data, row));
        }
        let separator =
            Separator::of(if row.is_empty() { header.map_or(row, |(line, _)| line) } else { row });
        let names = match (header, described) {
            (Some((line, at)), _) => {
                let found = names(line);
                if !names_a_position(found.iter().map(String::as_str)) {
                    return Err(not_a_header(source, at, line));
                }
                Some(found)
            }
            (None, Some(comment)) => {
                let found = names(comment);
                (row.is_empty() || found.len() == separator.fields(row).count()).then_some(found)
            }
            (None, None) => None,
        };
        let texts = names.as_ref().map_or_else(Vec::new, |names| text_columns(separator, names, row));
        Ok(Self { separator, names, texts, promised, data })
    }
}

/// Places of the columns that hold text in `row`, coordinates excepted: a label, a date, the name of a status.
fn text_columns(separator: Separator, names: &[String], row: &[u8]) -> Vec<usize> {
    let is_text = |field: &[u8]| !unquoted(field).is_empty() && parse(unquoted(field)).is_none();
    let columns = names.iter().zip(separator.fields(row)).enumerate();
    let texts = columns.filter(|(_, (name, field))| is_text(field) && !is_position(name));
    texts.map(|(place, _)| place).collect()
}

fn not_a_header(source: Source<'_>, at: usize, line: &[u8]) -> Error {
    source.line_error(
        at,
        format!(
            "{} holds neither numbers nor names of columns among which are x and y",
            quoted(line.trim_ascii())
        ),
        "write the names of the columns into the first line (x,y,z,nx,ny,nz,r,g,b,intensity,…), or remove it",
    )
}

fn decimal_comma(source: Source<'_>, at: usize, line: &[u8]) -> Error {
    source.line_error(
        at,
        format!(
            "{} seems to have decimal commas, which cannot be told from separators for certain",
            quoted(line.trim_ascii())
        ),
        "replace the decimal commas by points",
    )
}

/// Whether a field looks like 1,5.
fn is_decimal_comma(field: &[u8]) -> bool {
    let mut parts = field.split(|&byte| byte == b',');
    let number = |part: Option<&[u8]>| {
        part.is_some_and(|part| lex(part).is_some_and(|(_, length)| length == part.len()))
    };
    let digits = |part: Option<&[u8]>| part.is_some_and(|part| part.first().is_some_and(u8::is_ascii_digit));
    let (whole, fraction, rest) = (parts.next(), parts.next(), parts.next());
    number(whole) && number(fraction) && digits(fraction) && rest.is_none()
}

/// Whether commas stand within fields that other separators divide.
fn has_decimal_comma(line: &[u8]) -> bool {
    if !line.contains(&b',') {
        return false;
    }
    let (separator, least) = if line.contains(&b';') {
        (Separator::Byte(b';'), 1)
    } else if line.trim_ascii().contains(&b'\t') {
        (Separator::Byte(b'\t'), 1)
    } else {
        (Separator::Blank, 2)
    };
    let fields: Vec<_> = separator.fields(line).collect();
    fields.len() >= least
        && fields.iter().any(|field| is_decimal_comma(field))
        && fields.iter().all(|field| is_decimal_comma(field) || parse(field).is_some())
}

/// The names in a header line.
fn names(line: &[u8]) -> Vec<String> {
    let separator = Separator::of(line);
    let name = |field: &[u8]| String::from_utf8_lossy(unquoted(field)).into_owned();
    match separator {
        // A unit in brackets may stand apart from its name: "x [mm] y [mm]".
        Separator::Blank => {
            words(line).filter(|word| !word.starts_with(b"[") && !word.starts_with(b"(")).map(name).collect()
        }
        Separator::Byte(_) => separator.fields(line).map(name).collect(),
    }
}

fn unquoted(field: &[u8]) -> &[u8] {
    let field = field.trim_ascii();
    field.strip_prefix(b"\"").and_then(|inner| inner.strip_suffix(b"\"")).unwrap_or(field).trim_ascii()
}

impl Separator {
    /// The separator of a line: a semicolon, else a comma, else a tab between fields, else blanks.
    pub(super) fn of(line: &[u8]) -> Self {
        let line = line.trim_ascii();
        let found = [b';', b','].into_iter().find(|byte| line.contains(byte));
        found.map_or(Self::Blank, Self::Byte)
    }

    /// The fields of a line; a separator at its end does not make another field.
    pub(super) fn fields(self, line: &[u8]) -> Box<dyn Iterator<Item = &[u8]> + '_> {
        match self {
            Self::Blank => Box::new(words(line)),
            Self::Byte(byte) => {
                let line = line.trim_ascii();
                let line = line.strip_suffix(&[byte]).unwrap_or(line);
                Box::new(line.split(move |&other| other == byte).map(<[u8]>::trim_ascii))
            }
        }
    }

    /// Whether a line ends with a separator.
    pub(super) fn ends(self, line: &[u8]) -> bool {
        matches!(self, Self::Byte(byte) if line.trim_ascii_end().last() == Some(&byte))
    }

    /// Appends the numbers of a line; an empty field counts as NaN, and so does a field in the columns `texts`.
    pub(super) fn numbers(
        self,
        source: Source<'_>,
        (at, line): (usize, &[u8]),
        texts: &[usize],
        values: &mut Vec<f64>,
        empty: &mut usize,
    ) -> Result<(), Error> {
        let mut rest = line;
        let before = values.len();
        let skip_blanks = |rest: &mut &[u8]| {
            while let [first, tail @ ..] = rest
                && is_blank(*first)
            {
                *rest = tail;
            }
        };
        skip_blanks(&mut rest);
        while !rest.is_empty() {
            // The common case without any detour: a number, blanks, a separator.
            let mut field = rest;
            let number = lex(field).map(|(value, length)| {
                field = &field[length..];
                value
            });
            let spaced = field.first().is_none_or(|&byte| is_blank(byte));
            skip_blanks(&mut field);
            let ends = match self {
                Self::Blank => spaced,
                Self::Byte(byte) => field.first().is_none_or(|&next| next == byte),
            };
            match number.filter(|_| ends) {
                Some(value) => values.push(value),
                None => {
                    let end = rest.iter().position(|&byte| match self {
                        Self::Blank => is_blank(byte),
                        Self::Byte(separator) => byte == separator,
                    });
                    let (word, tail) = rest.split_at(end.unwrap_or(rest.len()));
                    let is_text = texts.contains(&(values.len() - before));
                    let value =
                        if is_text { f64::NAN } else { unusual(source, at, line, word, self, empty)? };
                    values.push(value);
                    field = tail;
                    skip_blanks(&mut field);
                }
            }
            rest = field;
            if let (Self::Byte(_), [_, tail @ ..]) = (self, rest) {
                rest = tail;
                skip_blanks(&mut rest);
            }
        }
        Ok(())
    }
}

/// A number in quotes, or none.
fn unusual(
    source: Source<'_>,
    at: usize,
    line: &[u8],
    word: &[u8],
    separator: Separator,
    empty: &mut usize,
) -> Result<f64, Error> {
    let inner = unquoted(word);
    if inner.is_empty() && separator != Separator::Blank {
        *empty += 1;
        return Ok(f64::NAN);
    }
    if let Some(value) = parse(inner) {
        return Ok(value);
    }
    if has_decimal_comma(line) {
        return Err(decimal_comma(source, at, line));
    }
    Err(source.line_error(
        at,
        format!("{} is not a number", quoted(word.trim_ascii())),
        "correct the line, or turn it into a comment with #",
    ))
}
