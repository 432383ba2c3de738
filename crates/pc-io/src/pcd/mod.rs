//! PCD, the point cloud format of PCL: ascii, binary and compressed.

mod header;
mod lzf;
mod write;

use std::borrow::Cow;

use mesh_core::Colours;

use self::header::{Encoding, Field, Header};
use crate::columns::{Column, Kind, assemble};
use crate::number;
use crate::number_type::{NumberType, Strided, warn_of_wide};
use crate::parsed::Parsed;
use crate::source::{Source, quoted, words};
use crate::{Error, Format, Place, not_points};

pub(crate) use self::write::write;

const EXPORT: &str = "the file is truncated or damaged, export it again";

/// Reads points. Padding fields (`_`) are passed over, fields of several numbers become scalars `name_0`, `name_1`, …
pub(crate) fn read(source: Source<'_>) -> Result<Parsed, Error> {
    let mut header = header::read(source)?;
    let mut warnings = std::mem::take(&mut header.warnings);
    let mut columns = empty_columns(&header.fields);
    match header.encoding {
        Encoding::Ascii => read_text(source, &header, &mut columns, &mut warnings)?,
        Encoding::Binary => read_binary(source, &header, &mut columns)?,
        Encoding::Compressed => read_compressed(source, &header, &mut columns)?,
    }
    let mut colours = None;
    let mut plain = Vec::new();
    for column in columns {
        if column.packed.is_some() && colours.is_none() {
            colours = Some(unpack_colours(&column));
        } else {
            warn_of_wide(&column.name, column.kind, &column.values, &mut warnings);
            plain.push(column);
        }
    }
    let plain = plain.into_iter().map(|column| Column {
        name: column.name,
        kind: column.kind,
        values: column.values,
    });
    let cloud = assemble(plain.collect(), &mut warnings).map_err(not_points)?;
    let mut attributes = cloud.attributes().clone();
    if let Some(colours) = colours {
        attributes.set_colours(Some(colours));
    }
    let cloud = cloud.with_attributes(attributes).map_err(Error::shape)?;
    Ok(Parsed::cloud(Format::Pcd, cloud, warnings))
}

/// A column in the making.
struct PcdColumn {
    name: String,
    kind: Kind,
    values: Vec<f64>,
    /// Whether the numbers are colours packed into 32 bits, and whether with opacity.
    packed: Option<bool>,
}

/// The columns of all fields but padding, in the order of the numbers of a point.
fn empty_columns(fields: &[Field]) -> Vec<PcdColumn> {
    let mut columns = Vec::new();
    for field in fields {
        let Some(value) = field.value else { continue };
        let kind = value.kind();
        let packs = field.size == 4 && field.count == 1;
        let packed = match field.name.to_ascii_lowercase().as_str() {
            "rgb" if packs => Some(false),
            "rgba" if packs => Some(true),
            _ => None,
        };
        for index in 0..field.count {
            let name = if field.count == 1 { field.name.clone() } else { format!("{}_{index}", field.name) };
            columns.push(PcdColumn { name, kind, values: Vec::new(), packed });
        }
    }
    columns
}

/// The bits 0xAARRGGBB, which are kept as their integer value.
fn unpack_colours(column: &PcdColumn) -> Colours {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the value came from 32 bits"
    )]
    let bytes = |value: f64| (value as u32).to_be_bytes();
    if column.packed == Some(true) {
        Colours::Rgba(
            column.values.iter().map(|&value| bytes(value)).map(|[a, r, g, b]| [r, g, b, a]).collect(),
        )
    } else {
        Colours::Rgb(column.values.iter().map(|&value| bytes(value)).map(|[_, r, g, b]| [r, g, b]).collect())
    }
}

fn read_text(
    source: Source<'_>,
    header: &Header,
    columns: &mut [PcdColumn],
    warnings: &mut Vec<String>,
) -> Result<(), Error> {
    let per_point: usize = header.fields.iter().map(|field| field.count).sum();
    let points = source.check_promise(header.end, "points", header.points, 2 * per_point.max(1), true)?;
    for column in columns.iter_mut() {
        column.values.reserve_exact(points);
    }
    let mut lines = source.lines_from(header.end);
    for point in 0..points {
        let Some((at, line)) = lines.by_ref().find(|(_, line)| !line.trim_ascii().is_empty()) else {
            let what = format!("the text ends after {point} of {points} points");
            return Err(source.line_error(source.data.len(), what, EXPORT));
        };
        let mut words = words(line);
        let mut columns = columns.iter_mut();
        for field in &header.fields {
            for _ in 0..field.count {
                let Some(word) = words.next() else {
                    let what = format!("{} has fewer than {per_point} numbers", quoted(line.trim_ascii()));
                    return Err(source.line_error(at, what, EXPORT));
                };
                let Some(value) = field.value else { continue };
                let bad = || {
                    let what = format!("{} is not a number (field {})", quoted(word), field.name);
                    source.line_error(at, what, "numbers are separated by blanks; correct the line")
                };
                let number = number::parse(word).ok_or_else(bad)?;
                if let Some(column) = columns.next() {
                    column.values.push(if column.packed.is_some() {
                        packed_bits(word, number, value)
                    } else {
                        number
                    });
                }
            }
        }
        if words.next().is_some() {
            let what = format!("{} has more than {per_point} numbers", quoted(line.trim_ascii()));
            return Err(source.line_error(at, what, "correct the line or the header"));
        }
    }
    if let Some((at, line)) = lines.find(|(_, line)| !line.trim_ascii().is_empty()) {
        let what = format!(
            "{} follows after the {points} points that the header tells of",
            quoted(line.trim_ascii())
        );
        if points == 0 {
            return Err(source.line_error(at, what, "correct POINTS, or WIDTH and HEIGHT, in the header"));
        }
        warnings.push(format!("{what} (line {})", source.line_at(at)));
    }
    Ok(())
}

/// The bits of a packed colour in a text: of the float, or the integer itself.
fn packed_bits(word: &[u8], number: f64, value: NumberType) -> f64 {
    let is_float = value == NumberType::F32 && !(word.iter().all(u8::is_ascii_digit) && number >= 1.0);
    if is_float { float_bits(number) } else { number }
}

/// Colours packed into a float are tiny numbers; their bits are what counts.
#[expect(clippy::cast_possible_truncation, reason = "the number came from single precision")]
fn float_bits(number: f64) -> f64 {
    f64::from((number as f32).to_bits())
}

fn read_binary(source: Source<'_>, header: &Header, columns: &mut [PcdColumn]) -> Result<(), Error> {
    let stride: usize = header.fields.iter().map(Field::bytes).sum();
    let points = source.check_promise(header.end, "points", header.points, stride.max(1), false)?;
    let (rows, rest) = source.data[header.end..].split_at(points * stride);
    check_rest(rest, source)?;
    let mut offset = 0;
    let mut columns = columns.iter_mut();
    for field in &header.fields {
        let Some(value) = field.value else {
            offset += field.bytes();
            continue;
        };
        for column in columns.by_ref().take(field.count) {
            decode_all(rows, stride, offset, value, column);
            offset += field.size;
        }
    }
    Ok(())
}

/// PCL fills files with zeros to whole pages of memory; anything else means that the header tells of other points.
fn check_rest(rest: &[u8], source: Source<'_>) -> Result<(), Error> {
    if rest.iter().all(|&byte| byte == 0) || rest.trim_ascii().is_empty() {
        return Ok(());
    }
    Err(Error::malformed(
        Place::Byte(source.data.len() - rest.len()),
        format!("{} bytes follow after the last point that the header tells of", rest.len()),
        "the counts or sizes in the header are wrong; export the file again",
    ))
}

/// Compressed points are stored field by field.
fn read_compressed(source: Source<'_>, header: &Header, columns: &mut [PcdColumn]) -> Result<(), Error> {
    if header.points == 0 {
        return Ok(());
    }
    let sizes = source.data.get(header.end..header.end + 8).ok_or_else(|| {
        let what = "the file ends where the sizes of the compressed data are expected";
        Error::malformed(Place::Byte(source.data.len()), what, EXPORT)
    })?;
    let size_at = |at: usize| u32::from_le_bytes([sizes[at], sizes[at + 1], sizes[at + 2], sizes[at + 3]]);
    let start = header.end + 8;
    let packed = source.check_promise(start, "bytes of compressed data", u64::from(size_at(0)), 1, false)?;
    let stride: usize = header.fields.iter().map(Field::bytes).sum();
    let unpacked = u64::from(size_at(4));
    if header.points.saturating_mul(stride as u64) != unpacked {
        let what =
            format!("{} points of {stride} bytes do not make the {unpacked} bytes stated", header.points);
        return Err(Error::malformed(Place::Byte(header.end), what, EXPORT));
    }
    let size = size_at(4) as usize;
    let data: Cow<'_, [u8]> = lzf::unpack(&source.data[start..start + packed], size, start)?.into();
    let points = size.checked_div(stride).unwrap_or(0);
    check_rest(&source.data[start + packed..], source)?;
    let mut offset = 0;
    let mut columns = columns.iter_mut();
    for field in &header.fields {
        let block = &data[offset..offset + field.bytes() * points];
        offset += block.len();
        let Some(value) = field.value else { continue };
        for (index, column) in columns.by_ref().take(field.count).enumerate() {
            decode_all(block, field.bytes(), index * field.size, value, column);
        }
    }
    Ok(())
}

/// Appends one number of every row; of packed colours the bits, whatever their type.
fn decode_all(rows: &[u8], stride: usize, offset: usize, value: NumberType, column: &mut PcdColumn) {
    let number = if column.packed.is_some() { NumberType::U32 } else { value };
    column.values.reserve_exact(rows.len() / stride);
    Strided { rows, stride, offset, number, little_endian: true }.append_to(&mut column.values);
}
