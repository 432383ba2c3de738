//! Writing E57: one scan in the coordinates of the points.

use std::io::{self, Cursor, Write};

use ::e57::{E57Writer, Extension, Record, RecordDataType, RecordName, RecordValue};

use super::layout::{INTENSITY, NORMALS, OWN, TIME};
use crate::foreign::guarded;
use crate::shape::{Keeps, Shape};
use crate::{Error, Place};

const KEEPS: Keeps = Keeps {
    normals: true,
    colours: true,
    opacity: false,
    scalars: true,
    texts: false,
    triangles: false,
    plane: false,
};
/// Where the extensions are defined.
const NORMALS_URL: &str = "http://www.libe57.org/E57_EXT_surface_normals.txt";
const OWN_URL: &str = "urn:industrial-geometry:scalars";
/// Numbers of a packet for points of many scalars; more would not fit into it.
const MOST_SCALARS: usize = 2000;

/// A number of each point.
enum Value<'a> {
    Position(usize),
    /// 2 where the position is not finite.
    State,
    Normal(usize),
    Colour(usize),
    Double(&'a [f64]),
    Integer(&'a [f64]),
}

/// Writes doubles; scalars without a name of the standard go into an extension.
pub(crate) fn write(out: &mut dyn Write, shape: Shape<'_>, warnings: &mut Vec<String>) -> io::Result<()> {
    shape.warn_of_loss(KEEPS, warnings);
    if shape.attributes().scalars().len() > MOST_SCALARS {
        return Err(io::Error::other("more than 2000 scalars do not fit into E57; choose ply or csv"));
    }
    let columns = columns(shape, warnings);
    let bytes = guarded("E57", || {
        encode(shape, &columns)
            .map_err(|error| Error::unsupported(Place::Whole, error.to_string(), "choose another format"))
    });
    out.write_all(&bytes.map_err(io::Error::other)?)
}

fn is_finite(shape: Shape<'_>, row: usize) -> bool {
    shape.positions()[row].iter().all(|value| value.is_finite())
}

/// The smallest and largest of integers, if all values are such.
#[expect(clippy::cast_possible_truncation, reason = "limited before")]
fn integers(values: &[f64]) -> Option<(i64, i64)> {
    const MOST: f64 = 4_503_599_627_370_496.0;
    let whole = |value: &f64| value.fract() == 0.0 && value.abs() <= MOST;
    if values.is_empty() || !values.iter().all(whole) {
        return None;
    }
    let (low, high) =
        values.iter().fold((f64::MAX, f64::MIN), |(low, high), &value| (low.min(value), high.max(value)));
    Some((low as i64, high as i64))
}

/// The numbers of each point, and how they are written.
fn columns<'a>(shape: Shape<'a>, warnings: &mut Vec<String>) -> Vec<(Record, Value<'a>)> {
    let mut columns = Vec::new();
    let mut add = |name: RecordName, data_type: RecordDataType, value: Value<'a>| {
        columns.push((Record { name, data_type }, value));
    };
    let axes = [RecordName::CartesianX, RecordName::CartesianY, RecordName::CartesianZ];
    for (axis, name) in axes.into_iter().enumerate() {
        add(name, RecordDataType::F64, Value::Position(axis));
    }
    if !(0..shape.positions().len()).all(|row| is_finite(shape, row)) {
        warnings.push("points whose coordinates are not finite were marked as not measured".to_owned());
        add(RecordName::CartesianInvalidState, RecordDataType::Integer { min: 0, max: 2 }, Value::State);
    }
    if shape.colours().is_some() {
        let channels = [RecordName::ColorRed, RecordName::ColorGreen, RecordName::ColorBlue];
        for (channel, name) in channels.into_iter().enumerate() {
            add(name, RecordDataType::U8, Value::Colour(channel));
        }
    }
    if shape.normals().is_some() {
        for (axis, name) in ["normalX", "normalY", "normalZ"].into_iter().enumerate() {
            let name = RecordName::Unknown { namespace: NORMALS.to_owned(), name: name.to_owned() };
            add(name, RecordDataType::F64, Value::Normal(axis));
        }
    }
    let has = |name: &str| {
        shape
            .attributes()
            .scalar(name)
            .is_some_and(|values| integers(values).is_some_and(|(low, _)| low >= 0))
    };
    let has_returns = has("return_number") && has("number_of_returns");
    let mut taken: Vec<String> = Vec::new();
    for (name, field) in shape.scalar_names(warnings).into_iter().zip(shape.attributes().scalars()) {
        let values = field.values.as_slice();
        let own = match (name.as_str(), integers(values)) {
            ("row_index", Some(_)) => Some(RecordName::RowIndex),
            ("column_index", Some(_)) => Some(RecordName::ColumnIndex),
            ("return_number", Some(_)) if has_returns => Some(RecordName::ReturnIndex),
            ("number_of_returns", Some(_)) if has_returns => Some(RecordName::ReturnCount),
            _ => None,
        };
        if let (Some(own), Some((min, max))) = (own, integers(values)) {
            // Integers that are all the same would take no bits.
            add(own, RecordDataType::Integer { min, max: max.max(min + 1) }, Value::Integer(values));
            continue;
        }
        let own = match name.as_str() {
            INTENSITY => Some(RecordName::Intensity),
            TIME => Some(RecordName::TimeStamp),
            _ => None,
        };
        let name = own.unwrap_or_else(|| {
            let name = plain(&name, &taken);
            if name != field.name {
                warnings.push(format!("the scalar {:?} was written as {name:?}", field.name));
            }
            taken.push(name.clone());
            RecordName::Unknown { namespace: OWN.to_owned(), name }
        });
        let finite = || values.iter().copied().filter(|value| value.is_finite());
        let (low, high) =
            (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
        let is_all = finite().count() == values.len() && low <= high;
        // Limits let other programs scale intensities.
        let limits = is_all && name == RecordName::Intensity;
        let kind = RecordDataType::Double { min: limits.then_some(low), max: limits.then_some(high) };
        add(name, kind, Value::Double(values));
    }
    columns
}

/// A name that can stand in the XML part, and none of `taken`.
fn plain(name: &str, taken: &[String]) -> String {
    let letters = name
        .chars()
        .map(|letter| if letter.is_ascii_alphanumeric() || "_-".contains(letter) { letter } else { '_' });
    let mut name: String = letters.collect();
    let starts_well = name.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_');
    if !starts_well || name.to_ascii_lowercase().starts_with("xml") {
        name.insert_str(0, "s_");
    }
    let is_free = |name: &String| !taken.contains(name);
    if is_free(&name) {
        return name;
    }
    (2usize..).map(|number| format!("{name}_{number}")).find(is_free).unwrap_or(name)
}

/// An identifier that the points determine, so that the same points make the same file: FNV-1a, twice.
fn identifier(shape: Shape<'_>, part: u64) -> String {
    let fold = |seed: u64| {
        shape.positions().iter().flat_map(|point| point.iter()).fold(seed ^ part, |hash, value| {
            value
                .to_bits()
                .to_le_bytes()
                .iter()
                .fold(hash, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
        })
    };
    let (a, b) = (fold(0xcbf2_9ce4_8422_2325), fold(0x6c62_272e_07bb_0142));
    format!(
        "{{{:08x}-{:04x}-{:04x}-{:04x}-{:012x}}}",
        a >> 32,
        (a >> 16) & 0xffff,
        a & 0xffff,
        b >> 48,
        b & 0xffff_ffff_ffff
    )
}

fn encode(shape: Shape<'_>, columns: &[(Record, Value<'_>)]) -> Result<Vec<u8>, ::e57::Error> {
    let mut bytes = Cursor::new(Vec::new());
    let mut file = E57Writer::new(&mut bytes, &identifier(shape, 0))?;
    for (namespace, url) in [(NORMALS, NORMALS_URL), (OWN, OWN_URL)] {
        let is_used = |(record, _): &(Record, Value<'_>)| matches!(&record.name, RecordName::Unknown { namespace: own, .. } if own == namespace);
        if columns.iter().any(is_used) {
            file.register_extension(Extension::new(namespace, url))?;
        }
    }
    let prototype = columns.iter().map(|(record, _)| record.clone()).collect();
    let mut scan = file.add_pointcloud(&identifier(shape, 1), prototype)?;
    for row in 0..shape.positions().len() {
        let values = columns.iter().map(|(_, value)| cell(shape, value, row)).collect();
        scan.add_point(values)?;
    }
    scan.finalize()?;
    file.finalize()?;
    drop(file);
    Ok(bytes.into_inner())
}

#[expect(clippy::cast_possible_truncation, reason = "whole numbers within the range")]
fn cell(shape: Shape<'_>, value: &Value<'_>, row: usize) -> RecordValue {
    match value {
        // What is marked as not measured still has to be a number.
        Value::Position(axis) if is_finite(shape, row) => RecordValue::Double(shape.positions()[row][*axis]),
        Value::Position(_) => RecordValue::Double(0.0),
        Value::State => RecordValue::Integer(if is_finite(shape, row) { 0 } else { 2 }),
        Value::Normal(axis) => RecordValue::Double(
            shape.normals().and_then(|normals| normals.get(row)).map_or(f64::NAN, |normal| normal[*axis]),
        ),
        Value::Colour(channel) => {
            let colour = shape.colours().and_then(|colours| colours.rgba(row)).unwrap_or_default();
            RecordValue::Integer(i64::from(colour[*channel]))
        }
        Value::Double(values) => RecordValue::Double(values[row]),
        Value::Integer(values) => RecordValue::Integer(values[row] as i64),
    }
}
