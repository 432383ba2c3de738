//! LAS and LAZ (ASPRS LAS 1.0 to 1.4), decoded by the crates `las` and `laz`. COPC files are read as the LAZ files they are.

mod check;
mod clouds;
mod extra;
mod fields;
mod grid;
mod write;

use std::io::{Seek, SeekFrom};

use mesh_core::{Attributes, PointCloud};
use nalgebra::{Point3, Vector3};

use self::fields::{Field, Format};
use crate::columns::{Column, Kind, colours, free_name};
use crate::foreign::{DAMAGED, Input, guarded};
use crate::number_type::{NumberType, warn_of_wide};
use crate::parsed::Parsed;
use crate::piece::{Piece, Taker};
use crate::{Error, Place};

pub(crate) use self::clouds::read_clouds;
pub(crate) use self::write::write;

/// Names of extra bytes that are normals.
const NORMALS: [&str; 3] = ["nx", "ny", "nz"];
/// Bytes of records that are decoded at a time.
const CHUNK: usize = 1 << 20;

/// A file that is read piece by piece.
struct Stream {
    reader: ::las::Reader,
    records: ::las::PointData,
    format: Format,
    /// Factor and summand of each coordinate.
    transform: [(f64, f64); 3],
    /// Points that are not read yet.
    left: u64,
    /// Descriptions of the extra bytes.
    descriptions: Vec<u8>,
}

impl Stream {
    /// Reads and checks what stands before the points.
    fn open(mut input: Input) -> Result<Self, Error> {
        guarded("LAS", || {
            let header = ::las::raw::Header::read_from(&mut input.reader).map_err(refused)?;
            let checked = check::check(&mut input, &header)?;
            input.reader.seek(SeekFrom::Start(0)).map_err(|error| refused(error.into()))?;
            // Small pieces are read from files otherwise.
            let reader = ::las::Reader::new(std::io::BufReader::with_capacity(1 << 16, input.reader))
                .map_err(refused)?;
            let found = reader.header();
            if found.number_of_points() != checked.points {
                return Err(Error::malformed(
                    Place::Byte(107),
                    "the counts of points contradict each other",
                    DAMAGED,
                ));
            }
            let transforms = *found.transforms();
            let transform = [transforms.x, transforms.y, transforms.z].map(|axis| (axis.scale, axis.offset));
            let format = Format {
                format: *found.point_format(),
                length: usize::from(header.point_data_record_length),
            };
            let descriptions = found
                .all_vlrs()
                .filter(|record| record.user_id == extra::USER && record.record_id == extra::RECORD)
                .flat_map(|record| record.data.iter().copied())
                .collect();
            let records = ::las::PointDataBuilder::new().for_header(found).build();
            Ok(Self { left: checked.points, reader, records, format, transform, descriptions })
        })
    }

    /// Reads on at the first point of `range`, up to its end.
    fn limit_to(&mut self, range: std::ops::Range<u64>) -> Result<(), Error> {
        self.left = range.end - range.start;
        if range.start > 0 && self.left > 0 {
            let reader = &mut self.reader;
            guarded("LAS", || reader.seek(range.start).map_err(refused))?;
        }
        Ok(())
    }

    /// The format of the file.
    const fn name(&self) -> crate::Format {
        if self.format.format.is_compressed { crate::Format::Laz } else { crate::Format::Las }
    }

    /// The records of the next points, at most `limit`; empty at the end.
    fn next_records(&mut self, limit: u64) -> Result<&[u8], Error> {
        let length = self.format.length.max(1);
        let count = self.left.min(limit).min((CHUNK / length).max(1) as u64);
        if count == 0 {
            return Ok(&[]);
        }
        let (reader, records) = (&mut self.reader, &mut self.records);
        let read = guarded("LAS", || reader.fill_points(count, records).map_err(refused))?;
        if read != count || self.records.raw_bytes().len() as u64 != count * length as u64 {
            return Err(Error::malformed(Place::Whole, "the points end early", DAMAGED));
        }
        self.left -= count;
        Ok(self.records.raw_bytes())
    }

    /// The next points, at most `limit`, with their normals; none at the end.
    fn next_piece(&mut self, limit: usize) -> Result<Piece, Error> {
        let (length, transform) = (self.format.length.max(1), self.transform);
        let mut fields = self.fields(&mut Vec::new());
        fields.retain(|field| NORMALS.contains(&field.name.as_str()));
        let mut positions = Vec::new();
        while positions.len() < limit {
            let records = self.next_records((limit - positions.len()) as u64)?;
            if records.is_empty() {
                break;
            }
            for record in records.chunks_exact(length) {
                positions.push(position(record, transform));
                fields.iter_mut().for_each(|field| field.push(record));
            }
        }
        let normals = take_normals(&mut fields, positions.len());
        Ok(Piece { positions, normals })
    }

    fn fields(&self, warnings: &mut Vec<String>) -> Vec<Field> {
        let available = usize::from(self.format.format.extra_bytes);
        self.format.fields(extra::describe(&self.descriptions, available, warnings))
    }
}

/// The normals, where extra bytes are called `nx`, `ny` and `nz`, as the writer calls them.
fn take_normals(fields: &mut Vec<Field>, points: usize) -> Option<Vec<Vector3<f64>>> {
    let is_there = |name: &&str| fields.iter().filter(|field| field.name == **name).count() == 1;
    if !NORMALS.iter().all(is_there) {
        return None;
    }
    let [x, y, z] = NORMALS.map(|name| {
        let place = fields.iter().position(|field| field.name == name)?;
        Some(fields.remove(place).into_values().unwrap_or_else(|| vec![0.0; points]))
    });
    let (x, y, z) = (x?, y?, z?);
    Some(x.into_iter().zip(y).zip(z).map(|((x, y), z)| Vector3::new(x, y, z)).collect())
}

/// The coordinates of a record: multiples of the scale from the offset on.
fn position(record: &[u8], transform: [(f64, f64); 3]) -> Point3<f64> {
    let axis = |axis: usize| {
        let (scale, offset) = transform[axis];
        NumberType::I32.decode::<true>(&record[4 * axis..4 * axis + 4]) * scale + offset
    };
    Point3::new(axis(0), axis(1), axis(2))
}

/// An error of the decoder.
fn refused(error: ::las::Error) -> Error {
    let what = match &error {
        ::las::Error::Io(source) if source.kind() == std::io::ErrorKind::UnexpectedEof => {
            "the LAS file ends early".to_owned()
        }
        _ => format!("the LAS decoder refuses the file: {error}"),
    };
    Error::malformed(Place::Whole, what, DAMAGED)
}

/// Hands over the positions and normals of all points in pieces of at most `limit`.
pub(crate) fn read_pieces<E>(input: Input, limit: usize, taker: &mut Taker<'_, E>) -> Result<Parsed, Error> {
    let mut stream = Stream::open(input)?;
    stream.limit_to(taker.begin(stream.left))?;
    loop {
        let piece = stream.next_piece(limit)?;
        if piece.positions.is_empty() || !taker.give(piece) {
            return Ok(Parsed::cloud(stream.name(), PointCloud::new(Vec::new()), Vec::new()));
        }
    }
}

/// Reads all points with what they carry; fields that are 0 everywhere are left out.
pub(crate) fn read(input: Input) -> Result<Parsed, Error> {
    let mut stream = Stream::open(input)?;
    let mut warnings = Vec::new();
    let mut fields = stream.fields(&mut warnings);
    let format = stream.format;
    let (length, transform) = (format.length, stream.transform);
    let mut positions = Vec::new();
    let mut channels = ["red", "green", "blue"].map(|name| Column {
        name: name.to_owned(),
        kind: Kind::Integer,
        values: Vec::new(),
    });
    loop {
        let records = stream.next_records(u64::MAX)?;
        if records.is_empty() {
            break;
        }
        for record in records.chunks_exact(length) {
            positions.push(position(record, transform));
            if let Some(at) = format.colour() {
                for (channel, at) in channels.iter_mut().zip([at, at + 2, at + 4]) {
                    channel.values.push(NumberType::U16.decode::<true>(&record[at..at + 2]));
                }
            }
            fields.iter_mut().for_each(|field| field.push(record));
        }
    }
    let mut attributes = Attributes::default();
    if format.colour().is_some() {
        let [red, green, blue] = &channels;
        attributes.set_colours(colours(&[red, green, blue], &mut warnings));
    }
    drop(channels);
    if format.format.has_waveform {
        warnings.push("not read: waveforms".to_owned());
    }
    attributes.set_normals(take_normals(&mut fields, positions.len()));
    for field in fields {
        let (name, is_wide) = (field.name.clone(), field.is_wide());
        let Some(values) = field.into_values() else { continue };
        if is_wide {
            warn_of_wide(&name, Kind::Integer, &values, &mut warnings);
        }
        let name = free_name(&attributes, name, &mut warnings);
        attributes.push_scalar(name, values).map_err(Error::shape)?;
    }
    let cloud = PointCloud::new(positions).with_attributes(attributes).map_err(Error::shape)?;
    Ok(Parsed::cloud(stream.name(), cloud, warnings))
}
