//! The rows after the header of a PLY file.

use super::header::{Element, Encoding, Property};
use crate::Error;
use crate::error::{Location, Place};
use crate::number::lex;
use crate::number_type::{NumberType, Strided};
use crate::source::{Source, is_blank, quoted};

/// Takes the numbers of an element row by row.
pub(super) trait Visitor {
    /// A number that is not in a list.
    fn scalar(&mut self, property: usize, value: f64);
    /// Where the numbers of a property go that is no list, if they are wanted.
    fn values(&mut self, property: usize) -> Option<&mut Vec<f64>>;
    /// The next number of a list.
    fn item(&mut self, property: usize, value: f64);
    /// The end of a row that began at `place`; binary rows without lists are not told one by one.
    fn end_row(&mut self, place: Place) -> Result<(), Error>;
}

/// Where reading stands.
#[derive(Debug)]
pub(super) struct Rows<'a> {
    source: Source<'a>,
    encoding: Encoding,
    at: usize,
    /// Rows of a text with more numbers than the header has properties.
    pub(super) overlong: usize,
}

impl<'a> Rows<'a> {
    pub(super) const fn new(source: Source<'a>, encoding: Encoding, at: usize) -> Self {
        Self { source, encoding, at, overlong: 0 }
    }

    /// Makes sure that nothing is left after the last row but the end of a line: else the rows of a binary file begin or
    /// end elsewhere, and the numbers read are not those that were written. In a text, lines that are left over are told,
    /// unless the header says that there are no rows at all.
    pub(super) fn check_end(&self, elements: &[Element], warnings: &mut Vec<String>) -> Result<(), Error> {
        let rest = self.source.data.get(self.at..).unwrap_or_default();
        let is_text = self.encoding == Encoding::Ascii;
        let is_end = matches!(rest, b"" | b"\n" | b"\r" | b"\r\n");
        if is_end || is_text && rest.trim_ascii().is_empty() {
            return Ok(());
        }
        let counts: Vec<String> =
            elements.iter().map(|element| format!("{} {}", element.count, element.name)).collect();
        let counts = counts.join(", ");
        let what = if is_text { "lines".to_owned() } else { format!("{} bytes", rest.len()) };
        let what = format!("{what} follow after the last row that the header tells of ({counts})");
        let at = self.at + rest.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        let line = self.source.line_at(at);
        if is_text && elements.iter().any(|element| element.count > 0) {
            warnings.push(format!("{what}, from line {line} on"));
            return Ok(());
        }
        let place = if is_text { Place::Line(line) } else { Place::Byte(self.at) };
        let advice = "the counts or types in the header, or its line ends, are wrong; export the file again";
        Err(Error::malformed(place, what, advice))
    }

    /// The number of rows of the next element, which is known to fit into the file.
    pub(super) fn checked_count(&self, element: &Element) -> Result<usize, Error> {
        let size = element.min_row_size(self.encoding);
        if size == 0 {
            return Ok(0);
        }
        let what = format_args!("rows of the element {:?}", element.name);
        self.source.check_promise(self.at, what, element.count, size, self.encoding == Encoding::Ascii)
    }

    /// Reads all rows of the next element.
    pub(super) fn visit(&mut self, element: &Element, visitor: &mut impl Visitor) -> Result<(), Error> {
        let count = self.checked_count(element)?;
        match self.encoding {
            Encoding::Ascii => self.visit_text(element, count, visitor),
            Encoding::LittleEndian if element.has_list() => {
                self.visit_binary::<true>(element, count, visitor)
            }
            Encoding::BigEndian if element.has_list() => self.visit_binary::<false>(element, count, visitor),
            Encoding::LittleEndian | Encoding::BigEndian => {
                self.visit_columns(element, count, visitor);
                Ok(())
            }
        }
    }

    /// Passes over all rows of the next element.
    pub(super) fn skip(&mut self, element: &Element) -> Result<(), Error> {
        struct Nobody;
        impl Visitor for Nobody {
            fn scalar(&mut self, _: usize, _: f64) {}
            fn values(&mut self, _: usize) -> Option<&mut Vec<f64>> {
                None
            }
            fn item(&mut self, _: usize, _: f64) {}
            fn end_row(&mut self, _: Place) -> Result<(), Error> {
                Ok(())
            }
        }
        if self.encoding == Encoding::Ascii || element.has_list() {
            return self.visit(element, &mut Nobody);
        }
        self.at += self.checked_count(element)? * element.min_row_size(self.encoding);
        Ok(())
    }

    fn visit_text(
        &mut self,
        element: &Element,
        count: usize,
        visitor: &mut impl Visitor,
    ) -> Result<(), Error> {
        let mut lines = self.source.lines_from(self.at);
        for row in 0..count {
            let Some((start, line)) = lines.find(|(_, line)| !line.iter().all(|&byte| is_blank(byte))) else {
                return Err(self.source.line_error(
                    self.source.data.len(),
                    format!("the text ends after {row} of {count} rows of the element {:?}", element.name),
                    "the file is truncated or its header damaged, export it again",
                ));
            };
            let mut text = TextRow { source: self.source, start, line, at: 0 };
            for (index, property) in element.properties.iter().enumerate() {
                let value = text.number(property)?;
                if property.list.is_none() {
                    visitor.scalar(index, value);
                    continue;
                }
                for _ in 0..text.list_length(property, value)? {
                    visitor.item(index, text.number(property)?);
                }
            }
            text.skip_blanks();
            self.overlong += usize::from(text.at < line.len());
            // The line is counted only where there is something to tell.
            let source = self.source;
            visitor.end_row(Place::Byte(start)).map_err(|error| at_line(error, source))?;
        }
        self.at = lines.offset();
        Ok(())
    }

    fn visit_binary<const LITTLE: bool>(
        &mut self,
        element: &Element,
        count: usize,
        visitor: &mut impl Visitor,
    ) -> Result<(), Error> {
        let data = self.source.data;
        for _ in 0..count {
            let start = self.at;
            for (index, property) in element.properties.iter().enumerate() {
                let Some(count_type) = property.list else {
                    visitor.scalar(index, self.next::<LITTLE>(property.value, element)?);
                    continue;
                };
                let length = self.next::<LITTLE>(count_type, element)?;
                if length < 0.0 {
                    return Err(Error::malformed(
                        Place::Byte(self.at - count_type.size()),
                        format!(
                            "the list {:?} of the element {:?} has the length {length}",
                            property.name, element.name
                        ),
                        "the file is damaged, export it again",
                    ));
                }
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a length is an integer"
                )]
                let length = length as u64;
                let size = property.value.size();
                let what = format_args!("items of the list {:?}", property.name);
                let length = self.source.check_promise(self.at, what, length, size, false)?;
                for item in data[self.at..self.at + length * size].chunks_exact(size) {
                    visitor.item(index, property.value.decode::<LITTLE>(item));
                }
                self.at += length * size;
            }
            visitor.end_row(Place::Byte(start))?;
        }
        Ok(())
    }

    /// Rows without lists have all the same size: one pass per property is much faster than one per row.
    fn visit_columns(&mut self, element: &Element, count: usize, visitor: &mut impl Visitor) {
        let stride = element.min_row_size(self.encoding);
        let rows = &self.source.data[self.at..self.at + count * stride];
        let little_endian = self.encoding == Encoding::LittleEndian;
        let mut offset = 0;
        for (index, property) in element.properties.iter().enumerate() {
            if let Some(values) = visitor.values(index) {
                Strided { rows, stride, offset, number: property.value, little_endian }.append_to(values);
            }
            offset += property.value.size();
        }
        self.at += count * stride;
    }

    fn next<const LITTLE: bool>(&mut self, value: NumberType, element: &Element) -> Result<f64, Error> {
        let end = self.at + value.size();
        let Some(bytes) = self.source.data.get(self.at..end) else {
            return Err(Error::malformed(
                Place::Byte(self.source.data.len()),
                format!("the file ends within a row of the element {:?}", element.name),
                "the file is truncated, export it again",
            ));
        };
        self.at = end;
        Ok(value.decode::<LITTLE>(bytes))
    }
}

/// Turns the offset of a row into its line.
fn at_line(mut error: Error, source: Source<'_>) -> Error {
    if let Error::Malformed { location: Location { place, .. }, .. } = &mut error
        && let Place::Byte(offset) = *place
    {
        *place = Place::Line(source.line_at(offset));
    }
    error
}

/// One line of a text.
struct TextRow<'a> {
    source: Source<'a>,
    start: usize,
    line: &'a [u8],
    at: usize,
}

impl TextRow<'_> {
    fn skip_blanks(&mut self) {
        while self.line.get(self.at).is_some_and(|&byte| is_blank(byte)) {
            self.at += 1;
        }
    }

    fn number(&mut self, property: &Property) -> Result<f64, Error> {
        self.skip_blanks();
        let rest = &self.line[self.at..];
        match lex(rest) {
            Some((value, length)) if rest.get(length).is_none_or(|&byte| is_blank(byte)) => {
                self.at += length;
                Ok(value)
            }
            _ => {
                let word = rest.split(|&byte| is_blank(byte)).next().unwrap_or_default();
                let found = if word.is_empty() { "the line ends".to_owned() } else { quoted(word) };
                Err(self.source.line_error(
                    self.start,
                    format!("{found} where the number {} is expected", property.name),
                    "the line has fewer numbers than the header says, or text among them; correct it or export the file again",
                ))
            }
        }
    }

    /// Checks the length of a list against the line before anything is allocated for it.
    fn list_length(&self, property: &Property, length: f64) -> Result<usize, Error> {
        let left = self.line.len() - self.at;
        if !(length >= 0.0 && length.fract() == 0.0 && length <= left as f64) {
            return Err(self.source.line_error(
                self.start,
                format!(
                    "the list {:?} is to have {length} items, but {left} characters of the line are left",
                    property.name
                ),
                "correct the line or export the file again",
            ));
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked above")]
        Ok(length as usize)
    }
}
