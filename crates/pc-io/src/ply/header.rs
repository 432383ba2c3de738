//! The header of a PLY file.

use crate::Error;
use crate::number::parse_count;
use crate::number_type::NumberType;
use crate::source::{Source, quoted, words};

/// How the numbers after the header are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// A number, or a list of numbers after their count, per row of an element.
#[derive(Debug, Clone)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) value: NumberType,
    /// The type of the count, where the property is a list.
    pub(super) list: Option<NumberType>,
}

/// Rows with the same properties.
#[derive(Debug, Clone)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

impl Element {
    pub(super) fn has_list(&self) -> bool {
        self.properties.iter().any(|property| property.list.is_some())
    }

    /// Bytes of a row whose lists are empty.
    pub(super) fn min_row_size(&self, encoding: Encoding) -> usize {
        let size = |property: &Property| match encoding {
            // A digit and a separator.
            Encoding::Ascii => 2,
            _ => property.list.unwrap_or(property.value).size(),
        };
        self.properties.iter().map(size).sum()
    }
}

/// What the header says.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Offset of the first byte after the header.
    pub(super) end: usize,
}

const EXPORT: &str = "correct the header or export the file again";

/// Reads the header. Lines end as the first one does, also with LF CR; behind a lone return binary data may begin with
/// any byte.
pub(super) fn read(source: Source<'_>) -> Result<Header, Error> {
    let data = source.data;
    let start = data.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
    let mut lines = source.lines_from(start);
    let magic = lines.next().map_or(b"".as_slice(), |(_, line)| line);
    if magic.trim_ascii() != b"ply" {
        return Err(source.line_error(start, "a PLY file begins with a line \"ply\"", EXPORT));
    }
    let ending = data.get(start + magic.len()..).unwrap_or_default();
    let lone_return = ending.starts_with(b"\r") && !ending.starts_with(b"\r\n");
    let reversed = ending.starts_with(b"\n\r");
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    while let Some((at, line)) = lines.next() {
        let mut words = words(line);
        match words.next() {
            None | Some(b"comment" | b"obj_info") => {}
            Some(b"format") => encoding = Some(encoding_of(source, at, words.next().unwrap_or_default())?),
            Some(b"element") => elements.push(element(source, at, line, words)?),
            Some(b"property") => {
                let property = property(words).ok_or_else(|| unknown(source, at, line))?;
                match elements.last_mut() {
                    Some(element) => element.properties.push(property),
                    None => return Err(source.line_error(at, "a property before the first element", EXPORT)),
                }
            }
            Some(b"end_header") => {
                let encoding = encoding
                    .ok_or_else(|| source.line_error(at, "the header has no line \"format\"", EXPORT))?;
                let mut end =
                    if lone_return { (at + line.len() + 1).min(data.len()) } else { lines.offset() };
                if reversed && data.get(end) == Some(&b'\r') {
                    end += 1;
                }
                return Ok(Header { encoding, elements, end });
            }
            Some(_) => return Err(unknown(source, at, line)),
        }
    }
    Err(source.line_error(data.len(), "the header does not end with a line \"end_header\"", EXPORT))
}

fn unknown(source: Source<'_>, at: usize, line: &[u8]) -> Error {
    source.line_error(at, format!("{} is not a line of a PLY header", quoted(line)), EXPORT)
}

fn encoding_of(source: Source<'_>, at: usize, word: &[u8]) -> Result<Encoding, Error> {
    match word {
        b"ascii" => Ok(Encoding::Ascii),
        b"binary_little_endian" => Ok(Encoding::LittleEndian),
        b"binary_big_endian" => Ok(Encoding::BigEndian),
        _ => Err(source.line_error(
            at,
            format!("the format {} is not ascii, binary_little_endian or binary_big_endian", quoted(word)),
            EXPORT,
        )),
    }
}

fn element<'a>(
    source: Source<'_>,
    at: usize,
    line: &[u8],
    mut words: impl Iterator<Item = &'a [u8]>,
) -> Result<Element, Error> {
    let parsed = words.next().zip(words.next().and_then(parse_count));
    let (name, count) = parsed.ok_or_else(|| {
        source.line_error(at, format!("{} is not \"element NAME COUNT\"", quoted(line)), EXPORT)
    })?;
    Ok(Element { name: String::from_utf8_lossy(name).into_owned(), count, properties: Vec::new() })
}

fn property<'a>(mut words: impl Iterator<Item = &'a [u8]>) -> Option<Property> {
    let first = words.next()?;
    let (list, value) = if first == b"list" {
        let count = type_from_name(words.next()?)
            .filter(|count| !matches!(count, NumberType::F32 | NumberType::F64))?;
        (Some(count), type_from_name(words.next()?)?)
    } else {
        (None, type_from_name(first)?)
    };
    Some(Property { name: String::from_utf8_lossy(words.next()?).into_owned(), value, list })
}

fn type_from_name(name: &[u8]) -> Option<NumberType> {
    Some(match name {
        b"char" | b"int8" => NumberType::I8,
        b"uchar" | b"uint8" => NumberType::U8,
        b"short" | b"int16" => NumberType::I16,
        b"ushort" | b"uint16" => NumberType::U16,
        b"int" | b"int32" => NumberType::I32,
        b"uint" | b"uint32" => NumberType::U32,
        b"int64" | b"long" => NumberType::I64,
        b"uint64" | b"ulong" => NumberType::U64,
        b"float" | b"float32" => NumberType::F32,
        b"double" | b"float64" => NumberType::F64,
        _ => return None,
    })
}
