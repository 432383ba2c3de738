//! The header of a PCD file.

use crate::number::parse_count;
use crate::number_type::NumberType;
use crate::source::{Source, quoted, words};
use crate::{Error, Place};

/// How the points are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Binary,
    Compressed,
}

/// A field of every point.
#[derive(Debug, Clone)]
pub(super) struct Field {
    pub(super) name: String,
    /// The type; `None` for padding, whose bytes may have any size.
    pub(super) value: Option<NumberType>,
    /// Bytes of one number.
    pub(super) size: usize,
    /// Numbers per point.
    pub(super) count: usize,
}

impl Field {
    pub(super) const fn bytes(&self) -> usize {
        self.size * self.count
    }
}

/// What the header says.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) fields: Vec<Field>,
    pub(super) points: u64,
    pub(super) warnings: Vec<String>,
    /// Offset of the first byte after the header.
    pub(super) end: usize,
}

const EXPORT: &str = "correct the header or export the file again";

/// Largest number of bytes per point, far beyond any use.
const WIDEST: usize = 1 << 20;

/// Entries as they are found, before they are put together.
#[derive(Default)]
struct Entries<'a> {
    names: Option<(usize, Vec<&'a [u8]>)>,
    sizes: Option<Vec<&'a [u8]>>,
    types: Option<Vec<&'a [u8]>>,
    counts: Option<Vec<&'a [u8]>>,
    width: Option<u64>,
    height: Option<u64>,
    points: Option<u64>,
    warnings: Vec<String>,
}

pub(super) fn read(source: Source<'_>) -> Result<Header, Error> {
    let mut entries = Entries::default();
    let mut lines = source.lines_from(0);
    while let Some((at, line)) = lines.next() {
        let mut words = words(line);
        let Some(keyword) = words.next().filter(|word| !word.starts_with(b"#")) else { continue };
        let number = |word: Option<&[u8]>| {
            word.and_then(parse_count).ok_or_else(|| {
                source.line_error(
                    at,
                    format!("{} is not \"KEYWORD NUMBER\"", quoted(line.trim_ascii())),
                    EXPORT,
                )
            })
        };
        match keyword {
            b"VERSION" => {
                if !matches!(
                    words.next(),
                    Some(b".7" | b"0.7" | b".6" | b"0.6" | b".5" | b"0.5" | b".4" | b"0.4")
                ) {
                    entries.warnings.push(format!(
                        "{} is not a known version; it was read as 0.7",
                        quoted(line.trim_ascii())
                    ));
                }
            }
            b"FIELDS" | b"COLUMNS" => entries.names = Some((at, words.collect())),
            b"SIZE" => entries.sizes = Some(words.collect()),
            b"TYPE" => entries.types = Some(words.collect()),
            b"COUNT" => entries.counts = Some(words.collect()),
            b"WIDTH" => entries.width = Some(number(words.next())?),
            b"HEIGHT" => entries.height = Some(number(words.next())?),
            b"POINTS" => entries.points = Some(number(words.next())?),
            b"VIEWPOINT" => {
                let numbers: Vec<_> = words.filter_map(crate::number::parse).collect();
                if numbers != [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0] {
                    entries.warnings.push(
                        "the viewpoint is not the origin; coordinates were read as they stand".to_owned(),
                    );
                }
            }
            b"DATA" => {
                let encoding = match words.next() {
                    Some(b"ascii") => Encoding::Ascii,
                    Some(b"binary") => Encoding::Binary,
                    Some(b"binary_compressed") => Encoding::Compressed,
                    _ => {
                        let what = format!(
                            "{} is not ascii, binary or binary_compressed",
                            quoted(line.trim_ascii())
                        );
                        return Err(source.line_error(at, what, EXPORT));
                    }
                };
                return entries.finish(source, encoding, lines.offset());
            }
            _ if keyword.iter().all(|byte| byte.is_ascii_uppercase() || *byte == b'_') => {
                entries.warnings.push(format!("not read: header line {}", quoted(line.trim_ascii())));
            }
            _ => {
                let what = format!("{} is not a line of a PCD header", quoted(line.trim_ascii()));
                return Err(source.line_error(at, what, EXPORT));
            }
        }
    }
    Err(source.line_error(source.data.len(), "the header does not end with a line \"DATA\"", EXPORT))
}

impl Entries<'_> {
    fn finish(mut self, source: Source<'_>, encoding: Encoding, end: usize) -> Result<Header, Error> {
        let (at, names) = self
            .names
            .take()
            .ok_or_else(|| source.line_error(end, "the header has no line \"FIELDS\"", EXPORT))?;
        let mut fields = Vec::with_capacity(names.len());
        for (place, name) in names.iter().enumerate() {
            let entry = |line: &Option<Vec<&'_ [u8]>>, default: u64| match line {
                None => Some(default),
                Some(words) => words.get(place).copied().and_then(parse_count),
            };
            let small = |number: Option<u64>| {
                number
                    .and_then(|number| usize::try_from(number).ok())
                    .filter(|&number| (1..=WIDEST).contains(&number))
            };
            let size = small(entry(&self.sizes, 4));
            let count = small(entry(&self.counts, 1));
            let letter = self.types.as_ref().map_or(Some(b"F".as_slice()), |types| types.get(place).copied());
            let padding = *name == b"_";
            let value = letter.zip(size).and_then(|(letter, size)| number_type(letter, size));
            let (Some(size), Some(count), true) = (size, count, value.is_some() || padding) else {
                return Err(source.line_error(
                    at,
                    format!("SIZE, TYPE and COUNT of the field {} make no sense", quoted(name)),
                    "every field needs a SIZE of 1, 2, 4 or 8, a TYPE of I, U or F and a COUNT of 1 or more; correct the header",
                ));
            };
            let name = String::from_utf8_lossy(name).into_owned();
            fields.push(Field { name, value: value.filter(|_| !padding), size, count });
        }
        if fields.iter().map(Field::bytes).sum::<usize>() > WIDEST {
            return Err(source.line_error(at, format!("a point takes more than {WIDEST} bytes"), EXPORT));
        }
        let grid = self.width.map(|width| width.saturating_mul(self.height.unwrap_or(1)));
        let points = match (self.points, grid) {
            (Some(points), Some(grid)) if points != grid => {
                self.warnings
                    .push(format!("WIDTH x HEIGHT is {grid}, but POINTS {points}; the latter counts"));
                points
            }
            (Some(points), _) | (None, Some(points)) => points,
            (None, None) => {
                let what = "the header has neither POINTS nor WIDTH";
                return Err(Error::malformed(Place::Line(source.line_at(end)), what, EXPORT));
            }
        };
        Ok(Header { encoding, fields, points, warnings: self.warnings, end })
    }
}

fn number_type(letter: &[u8], size: usize) -> Option<NumberType> {
    Some(match (letter, size) {
        (b"I" | b"i", 1) => NumberType::I8,
        (b"I" | b"i", 2) => NumberType::I16,
        (b"I" | b"i", 4) => NumberType::I32,
        (b"I" | b"i", 8) => NumberType::I64,
        (b"U" | b"u", 1) => NumberType::U8,
        (b"U" | b"u", 2) => NumberType::U16,
        (b"U" | b"u", 4) => NumberType::U32,
        (b"U" | b"u", 8) => NumberType::U64,
        (b"F" | b"f", 4) => NumberType::F32,
        (b"F" | b"f", 8) => NumberType::F64,
        _ => return None,
    })
}
