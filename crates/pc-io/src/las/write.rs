//! Writing LAS 1.4 and LAZ.

use std::io::{self, Cursor, Write};

use mesh_core::ScalarField;

use super::check::MOST_COMPRESSED;
use super::extra;
use super::fields::ANGLE;
use super::grid::Grid;
use crate::shape::{Keeps, Shape};
use crate::wording::counted;

const KEEPS: Keeps = Keeps {
    normals: true,
    colours: true,
    opacity: false,
    scalars: true,
    texts: false,
    triangles: false,
    plane: false,
};
/// Points that are encoded at a time.
const CHUNK: usize = 1 << 14;
/// Bytes of a name in the description of extra bytes.
const LONGEST_NAME: usize = 32;

/// How a number of a record is written.
#[derive(Debug, Clone, Copy)]
enum Kind {
    /// An unsigned integer up to the second number, shifted by the first.
    Bits(u32, u16),
    /// Whole degrees.
    Degrees,
    /// Units of [`ANGLE`].
    Angle,
    Double,
}

/// A place in a record that a scalar of this name goes to, if all of its values fit.
#[derive(Debug)]
struct Standard {
    name: &'static str,
    at: usize,
    kind: Kind,
}

const fn standard(name: &'static str, at: usize, kind: Kind) -> Standard {
    Standard { name, at, kind }
}

/// The fields of formats 6 and 7 by the names that the reader gives them.
const EXTENDED: [Standard; 15] = [
    standard("intensity", 12, Kind::Bits(0, u16::MAX)),
    standard("return_number", 14, Kind::Bits(0, 15)),
    standard("number_of_returns", 14, Kind::Bits(4, 15)),
    standard("synthetic", 15, Kind::Bits(0, 1)),
    standard("key_point", 15, Kind::Bits(1, 1)),
    standard("withheld", 15, Kind::Bits(2, 1)),
    standard("overlap", 15, Kind::Bits(3, 1)),
    standard("scanner_channel", 15, Kind::Bits(4, 3)),
    standard("scan_direction_flag", 15, Kind::Bits(6, 1)),
    standard("edge_of_flight_line", 15, Kind::Bits(7, 1)),
    standard("classification", 16, Kind::Bits(0, 255)),
    standard("user_data", 17, Kind::Bits(0, 255)),
    standard("scan_angle", 18, Kind::Angle),
    standard("point_source_id", 20, Kind::Bits(0, u16::MAX)),
    standard("gps_time", 22, Kind::Double),
];

/// The fields of formats 1 and 3, whose angles are whole degrees.
const LEGACY: [Standard; 13] = [
    standard("intensity", 12, Kind::Bits(0, u16::MAX)),
    standard("return_number", 14, Kind::Bits(0, 7)),
    standard("number_of_returns", 14, Kind::Bits(3, 7)),
    standard("scan_direction_flag", 14, Kind::Bits(6, 1)),
    standard("edge_of_flight_line", 14, Kind::Bits(7, 1)),
    standard("classification", 15, Kind::Bits(0, 31)),
    standard("synthetic", 15, Kind::Bits(5, 1)),
    standard("key_point", 15, Kind::Bits(6, 1)),
    standard("withheld", 15, Kind::Bits(7, 1)),
    standard("scan_angle", 16, Kind::Degrees),
    standard("user_data", 17, Kind::Bits(0, 255)),
    standard("point_source_id", 18, Kind::Bits(0, u16::MAX)),
    standard("gps_time", 20, Kind::Double),
];

/// Other names that programs give to parts of records; extra bytes of these names cannot be told from them.
const TAKEN: [&str; 9] = [
    "X",
    "Y",
    "Z",
    "nir",
    "scan_angle_rank",
    "raw_classification",
    "bit_fields",
    "classification_flags",
    "flag_byte",
];

impl Standard {
    fn holds(&self, values: &[f64]) -> bool {
        values.iter().all(|&value| match self.kind {
            Kind::Bits(_, most) => value.fract() == 0.0 && (0.0..=f64::from(most)).contains(&value),
            Kind::Degrees => value.fract() == 0.0 && (-128.0..=127.0).contains(&value),
            Kind::Angle => angle(value).is_some(),
            Kind::Double => value.is_finite(),
        })
    }

    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked by `holds`")]
    fn put(&self, record: &mut [u8], value: f64) {
        let at = self.at;
        match self.kind {
            Kind::Bits(_, u16::MAX) => record[at..at + 2].copy_from_slice(&(value as u16).to_le_bytes()),
            Kind::Bits(shift, _) => record[at] |= ((value as u16) << shift) as u8,
            Kind::Degrees => record[at] = (value as i8).to_le_bytes()[0],
            Kind::Angle => record[at..at + 2].copy_from_slice(&angle(value).unwrap_or(0).to_le_bytes()),
            Kind::Double => record[at..at + 8].copy_from_slice(&value.to_le_bytes()),
        }
    }
}

/// The number of units of a scan angle, if it is a whole one.
#[expect(clippy::cast_possible_truncation, reason = "compared after it")]
fn angle(value: f64) -> Option<i16> {
    let units = (value / ANGLE).round() as i16;
    (f64::from(units) * ANGLE == value).then_some(units)
}

/// Where the scalars go.
struct Plan<'a> {
    /// Formats 6 and 7 instead of 1 and 3.
    is_extended: bool,
    standard: Vec<(&'static Standard, &'a [f64])>,
    /// Scalars in extra bytes, with the names they get there.
    extra: Vec<(String, &'a [f64])>,
}

impl<'a> Plan<'a> {
    fn of(shape: Shape<'a>, normals: &'a [Vec<f64>], warnings: &mut Vec<String>) -> Self {
        let names = shape.scalar_names(warnings);
        let scalars = shape.attributes().scalars();
        // How many scalars a table has a place for; the newer formats where both have one for the same.
        let held = |table: &'static [Standard]| {
            let place = |(name, field): &(&String, &ScalarField)| {
                table.iter().any(|place| place.name == *name && place.holds(&field.values))
            };
            names.iter().zip(scalars).filter(place).count()
        };
        let is_extended = held(&EXTENDED) >= held(&LEGACY);
        let table: &'static [Standard] = if is_extended { &EXTENDED } else { &LEGACY };
        let mut plan = Self { is_extended, standard: Vec::new(), extra: Vec::new() };
        for (name, field) in names.iter().zip(scalars) {
            match table.iter().find(|place| place.name == name && place.holds(&field.values)) {
                Some(place) => plan.standard.push((place, &field.values)),
                None => plan.push_extra(name, &field.values, warnings),
            }
        }
        for (name, values) in ["nx", "ny", "nz"].into_iter().zip(normals) {
            plan.push_extra(name, values, warnings);
        }
        plan
    }

    /// Bytes of a record without extra bytes, and of those before the colour.
    const fn base(&self, has_colours: bool) -> (usize, usize) {
        let colour = if self.is_extended { 30 } else { 28 };
        (if has_colours { colour + 6 } else { colour }, colour)
    }

    /// Adds a scalar to the extra bytes, whose names are short and none of those of fields.
    fn push_extra(&mut self, name: &str, values: &'a [f64], warnings: &mut Vec<String>) {
        let short = |name: &str, length: usize| {
            let mut end = name.len().min(length);
            while !name.is_char_boundary(end) {
                end -= 1;
            }
            name[..end].to_owned()
        };
        let is_field = EXTENDED.iter().any(|place| place.name == name) || TAKEN.contains(&name);
        let whole = if is_field { format!("extra_{name}") } else { name.to_owned() };
        let mut free = short(&whole, LONGEST_NAME);
        let mut number = 2usize;
        while self.extra.iter().any(|(other, _)| *other == free) {
            free = format!("{}_{number}", short(&whole, LONGEST_NAME - 8));
            number += 1;
        }
        if is_field {
            warnings.push(format!(
                "the scalar {name:?} was written as {free:?}: its values do not fit the field of LAS"
            ));
        } else if free != name {
            warnings.push(format!(
                "the scalar {name:?} was written as {free:?}: names of extra bytes have up to 32 bytes"
            ));
        }
        self.extra.push((free, values));
    }
}

/// Writes LAS 1.4 with point format 6, with colours 7, or 1 and 3 where angles are whole degrees; scalars without a place of their own go into extra bytes.
pub(crate) fn write(
    out: &mut dyn Write,
    shape: Shape<'_>,
    is_compressed: bool,
    warnings: &mut Vec<String>,
) -> io::Result<()> {
    shape.warn_of_loss(KEEPS, warnings);
    let normals = normals(shape);
    let plan = Plan::of(shape, &normals, warnings);
    let length = u16::try_from(plan.base(shape.colours().is_some()).0 + 8 * plan.extra.len())
        .ok()
        .filter(|length| !is_compressed || *length <= MOST_COMPRESSED)
        .ok_or_else(|| {
            io::Error::other(format!(
                "{} scalars do not fit into LAS records; choose ply or csv",
                plan.extra.len()
            ))
        })?;
    let finite = |index: &usize| shape.positions()[*index].iter().all(|value| value.is_finite());
    let kept: Vec<usize> = (0..shape.positions().len()).filter(finite).collect();
    if kept.len() < shape.positions().len() {
        let lost = counted(shape.positions().len() - kept.len(), "point");
        warnings.push(format!("left out: {lost} whose coordinates are not finite, which LAS cannot hold"));
    }
    let grids = [0, 1, 2].map(|axis| Grid::of(kept.iter().map(|&index| shape.positions()[index][axis])));
    let error = grids.iter().map(|grid| grid.error).fold(0.0, f64::max);
    if error > 0.0 {
        warnings.push(format!(
            "coordinates were rounded by up to {error:e}, since LAS holds integers (steps {:e}, {:e}, {:e}); PLY, CSV and E57 keep all digits",
            grids[0].scale, grids[1].scale, grids[2].scale
        ));
    }
    let header = header(&plan, &grids, shape.colours().is_some(), is_compressed).map_err(io::Error::other)?;
    // The writer panics when it is dropped after an error.
    let written = crate::foreign::guarded("LAS", || {
        encode(shape, &plan, &grids, &kept, &header, usize::from(length)).map_err(|error| {
            crate::Error::unsupported(crate::Place::Whole, error.to_string(), "choose another format")
        })
    });
    out.write_all(&written.map_err(io::Error::other)?)
}

/// The normals as columns.
fn normals(shape: Shape<'_>) -> Vec<Vec<f64>> {
    shape.normals().map_or_else(Vec::new, |normals| {
        (0..3).map(|axis| normals.iter().map(|normal| normal[axis]).collect()).collect()
    })
}

fn header(
    plan: &Plan<'_>,
    grids: &[Grid; 3],
    has_colours: bool,
    is_compressed: bool,
) -> Result<::las::Header, ::las::Error> {
    let mut builder = ::las::Builder::from((1, 4));
    let number = match (plan.is_extended, has_colours) {
        (true, true) => 7,
        (true, false) => 6,
        (false, true) => 3,
        (false, false) => 1,
    };
    let mut format = ::las::point::Format::new(number)?;
    format.extra_bytes = u16::try_from(8 * plan.extra.len()).unwrap_or(u16::MAX);
    format.is_compressed = is_compressed;
    builder.point_format = format;
    // The same points make the same bytes on every day.
    builder.date = None;
    builder.system_identifier = String::new();
    builder.generating_software = concat!("pc-io ", env!("CARGO_PKG_VERSION")).to_owned();
    let transform = |grid: Grid| ::las::Transform { scale: grid.scale, offset: grid.offset };
    builder.transforms =
        ::las::Vector { x: transform(grids[0]), y: transform(grids[1]), z: transform(grids[2]) };
    if !plan.extra.is_empty() {
        builder.vlrs.push(::las::Vlr {
            user_id: extra::USER.to_owned(),
            record_id: extra::RECORD,
            description: "extra bytes".to_owned(),
            data: plan.extra.iter().flat_map(|(name, _)| extra::description(name)).collect(),
        });
    }
    builder.into_header()
}

fn encode(
    shape: Shape<'_>,
    plan: &Plan<'_>,
    grids: &[Grid; 3],
    kept: &[usize],
    header: &::las::Header,
    length: usize,
) -> Result<Vec<u8>, ::las::Error> {
    let mut writer = ::las::Writer::new(Cursor::new(Vec::new()), header.clone())?;
    for rows in kept.chunks(CHUNK) {
        let mut bytes = Vec::with_capacity(rows.len() * length);
        for &row in rows {
            let start = bytes.len();
            bytes.resize(start + length, 0);
            let record = &mut bytes[start..];
            for (axis, grid) in grids.iter().enumerate() {
                let steps = grid.steps(shape.positions()[row][axis]);
                record[4 * axis..4 * axis + 4].copy_from_slice(&steps.to_le_bytes());
            }
            for (place, values) in &plan.standard {
                place.put(record, values[row]);
            }
            if let Some(rgba) = shape.colours().and_then(|colours| colours.rgba(row)) {
                for (channel, &value) in rgba[..3].iter().enumerate() {
                    let (wide, at) = (u16::from(value) * 257, plan.base(true).1 + 2 * channel);
                    record[at..at + 2].copy_from_slice(&wide.to_le_bytes());
                }
            }
            let first = length - 8 * plan.extra.len();
            for (place, (_, values)) in plan.extra.iter().enumerate() {
                record[first + 8 * place..first + 8 * place + 8].copy_from_slice(&values[row].to_le_bytes());
            }
        }
        let points = ::las::PointDataBuilder::new().for_header(header).build_from_bytes(bytes)?;
        writer.write_points(&points)?;
    }
    Ok(writer.into_inner()?.into_inner())
}
