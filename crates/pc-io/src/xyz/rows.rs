//! The rows of a table.

use mesh_core::TextField;

use super::fields::{Field, Separator, is_comment, quoted_length, starts_comment};
use super::layout::{Layout, MOST_COLUMNS};
use super::notation::PLAIN;
use crate::number::{lex, parse_count};
use crate::source::{Source, decode_name, quoted};
use crate::{Error, Place};

/// The cells of all rows.
#[derive(Debug)]
pub(super) struct Rows {
    /// Numbers of all rows one after another; NaN where a cell is empty or text.
    pub(super) values: Vec<f64>,
    /// Number of columns.
    pub(super) width: usize,
    /// One per column of text of the layout.
    pub(super) texts: Vec<TextField>,
    /// Number of empty cells.
    pub(super) empty: usize,
}

const SAME_WIDTH: &str =
    "every line must have as many as the first; correct the line, or turn it into a comment with #";

/// Reads all rows.
pub(super) fn read(source: Source<'_>, layout: &Layout) -> Result<Rows, Error> {
    let mut reader = RowReader::new(layout);
    reader.rows.values = Vec::with_capacity(source.data.len().saturating_sub(layout.data) / 10);
    for (at, line) in source.lines_from(layout.data) {
        if !reader.read_line(source, layout, (at, line))? {
            break;
        }
    }
    Ok(reader.finish())
}

/// Reads rows one after another.
#[derive(Debug)]
pub(super) struct RowReader {
    pub(super) rows: Rows,
    /// Number of columns, where it is known.
    width: Option<usize>,
}

impl RowReader {
    pub(super) fn new(layout: &Layout) -> Self {
        let texts = layout.texts.iter().map(|_| TextField::default()).collect();
        let rows = Rows { values: Vec::new(), width: 0, texts, empty: 0 };
        Self { rows, width: layout.names.as_ref().map(Vec::len).or(layout.width) }
    }

    /// The rows read.
    pub(super) fn finish(mut self) -> Rows {
        self.rows.width = self.width();
        self.rows
    }

    /// Number of columns.
    pub(super) fn width(&self) -> usize {
        self.width.unwrap_or(3)
    }

    /// Reads the line at a place of the source; false if no rows follow any more.
    pub(super) fn read_line(
        &mut self,
        source: Source<'_>,
        layout: &Layout,
        (at, line): (usize, &[u8]),
    ) -> Result<bool, Error> {
        if is_comment(line) {
            return Ok(true);
        }
        let rows = &mut self.rows;
        let before = rows.values.len();
        rows.read_line(source, layout, (at, line), self.width)?;
        let found = rows.values.len() - before;
        let expected = *self.width.get_or_insert(found);
        if found != expected {
            // Several PTS scans in one file: each begins with its count.
            if layout.promised.is_some() && found == 1 && parse_count(line.trim_ascii()).is_some() {
                rows.values.truncate(before);
                return Ok(true);
            }
            if expected < 2 {
                return Ok(false);
            }
            return Err(source.line_error(
                at,
                format!("{} has {found} columns where {expected} are expected", quoted(line.trim_ascii())),
                SAME_WIDTH,
            ));
        }
        if expected > MOST_COLUMNS {
            return Err(Error::malformed(
                Place::Line(source.line_at(at)),
                format!("the lines have {expected} columns, which is no list of points"),
                "give a file with one point per line",
            ));
        }
        Ok(true)
    }
}

impl Rows {
    /// Appends the cells of a line.
    fn read_line(
        &mut self,
        source: Source<'_>,
        layout: &Layout,
        (at, line): (usize, &[u8]),
        width: Option<usize>,
    ) -> Result<(), Error> {
        if layout.texts.is_empty() && layout.notation == PLAIN {
            let before = self.values.len();
            let empty = self.empty;
            if self.read_numbers(layout.separator, line) {
                self.fit(layout, line, before, width);
                return Ok(());
            }
            self.values.truncate(before);
            self.empty = empty;
        }
        let before = self.values.len();
        let mut fields = layout.separator.fields(line);
        let mut tail = fields.clone();
        while let Some(field) = fields.next() {
            let place = self.values.len() - before;
            let last = width.is_some_and(|width| place + 1 == width);
            if width == Some(place) && field.text.is_empty() {
                // A separator at the end of a line.
                break;
            }
            let Some(index) = layout.texts.iter().position(|&text| text == place) else {
                let value = self.number(source, layout, (at, line), field)?;
                self.values.push(value);
                tail = fields.clone();
                continue;
            };
            // The last of columns that blanks divide may be several words.
            let several = last && layout.separator == Separator::Blank && !field.quoted;
            let text = if several { tail.tail() } else { field.text };
            let text = decode_name(text);
            self.texts[index].push(&if field.quoted { text.replace("\"\"", "\"").into() } else { text });
            self.values.push(f64::NAN);
            if several {
                break;
            }
            tail = fields.clone();
        }
        self.fit(layout, line, before, width);
        Ok(())
    }

    /// Adds the texts, and the empty cell after a last separator, that the line leaves out.
    fn fit(&mut self, layout: &Layout, line: &[u8], before: usize, width: Option<usize>) {
        let Some(width) = width else { return };
        let found = self.values.len() - before;
        if found == width + 1
            && self.values.last().is_some_and(|value| value.is_nan())
            && layout.separator.ends(line)
        {
            self.values.pop();
            self.empty = self.empty.saturating_sub(1);
        }
        if (found..width).all(|place| layout.texts.contains(&place)) {
            for place in found..width {
                if let Some(index) = layout.texts.iter().position(|&text| text == place) {
                    self.texts[index].push("");
                }
                self.values.push(f64::NAN);
            }
        }
    }

    /// The common case without any detour: numbers, blanks, separators, empty cells. Anything else is left to others.
    fn read_numbers(&mut self, separator: Separator, line: &[u8]) -> bool {
        let mut rest = line;
        let skip_padding = |rest: &mut &[u8]| {
            while let [first, tail @ ..] = rest
                && separator.is_padding(*first)
            {
                *rest = tail;
            }
        };
        skip_padding(&mut rest);
        while !rest.is_empty() {
            let number = lex(rest);
            let mut after = rest;
            if let Some((value, length)) = number {
                self.values.push(value);
                after = &rest[length..];
            } else if matches!(separator, Separator::Byte(byte) if rest.first() == Some(&byte)) {
                self.values.push(f64::NAN);
                self.empty += 1;
            } else {
                return false;
            }
            let spaced = after.first().is_none_or(|&byte| separator.is_padding(byte));
            skip_padding(&mut after);
            match (separator, after) {
                (_, []) => break,
                (Separator::Blank, _) if spaced => rest = after,
                (Separator::Byte(byte), [first, tail @ ..]) if *first == byte => {
                    rest = tail;
                    skip_padding(&mut rest);
                    if rest.is_empty() {
                        self.values.push(f64::NAN);
                        self.empty += 1;
                    }
                }
                _ => return false,
            }
        }
        true
    }

    /// The number in a field; NaN, which is counted, in an empty one.
    fn number(
        &mut self,
        source: Source<'_>,
        layout: &Layout,
        (at, line): (usize, &[u8]),
        field: Field<'_>,
    ) -> Result<f64, Error> {
        if let Some(value) = layout.notation.parse(field.text) {
            return Ok(value);
        }
        if field.is_empty() && (layout.separator != Separator::Blank || field.quoted || field.text.len() > 1)
        {
            self.empty += 1;
            return Ok(f64::NAN);
        }
        let open = !starts_comment(line)
            && line.contains(&b'"')
            && !field.quoted
            && quoted_length(field.text).is_none();
        let what = if open && field.text.starts_with(b"\"") {
            format!("{} begins with a quote that does not end in this line", quoted(field.text))
        } else {
            format!("{} is not a number", quoted(field.text))
        };
        Err(source.line_error(at, what, "correct the line, or turn it into a comment with #"))
    }
}
