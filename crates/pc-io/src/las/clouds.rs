//! LAS and LAZ that are read piece by piece with all that points carry.
//!
//! Which fields hold anything, and what turns colours into bytes, depends on all points: a first way through the file finds it out.

use mesh_core::{Attributes, PointCloud};
use nalgebra::Vector3;

use super::{Field, NORMALS, Stream, position};
use crate::Error;
use crate::columns::{Column, Kind, ROUNDED_COLOURS, free_name, integer_scale, scaled_colours};
use crate::foreign::Input;
use crate::number_type::NumberType;
use crate::parsed::Parsed;

/// What the first way through a file finds.
struct Survey {
    /// Whether a field holds anything but zeros.
    kept: Vec<bool>,
    /// What turns colours into bytes.
    scale: f64,
    rounds: bool,
}

impl Survey {
    fn of(stream: &mut Stream) -> Result<Self, Error> {
        let fields = stream.fields(&mut Vec::new());
        let (length, colour) = (stream.format.length.max(1), stream.format.colour());
        let mut kept = vec![false; fields.len()];
        let (mut largest, mut is_multiple) = (0u16, true);
        loop {
            let records = stream.next_records(u64::MAX)?;
            if records.is_empty() {
                break;
            }
            for record in records.chunks_exact(length) {
                for (kept, field) in kept.iter_mut().zip(&fields).filter(|(kept, _)| !**kept) {
                    *kept = field.of_record(record) != 0.0;
                }
                for channel in colour.into_iter().flat_map(|at| record[at..at + 6].chunks_exact(2)) {
                    let value = u16::from_le_bytes([channel[0], channel[1]]);
                    largest = largest.max(value);
                    is_multiple &= value.is_multiple_of(257);
                }
            }
        }
        let scale = integer_scale(f64::from(largest));
        Ok(Self { kept, scale, rounds: scale < 1.0 && !is_multiple })
    }
}

/// Hands over the points with what they carry in pieces of at most `limit`, with what is to be told, which is the same every time;
/// false, before the first piece, where the file has to be read as a whole.
pub(crate) fn read_clouds(
    mut open: impl FnMut() -> Result<Input, Error>,
    limit: usize,
    take: &mut dyn FnMut(Parsed) -> Result<bool, Error>,
) -> Result<bool, Error> {
    let survey = Survey::of(&mut Stream::open(open()?)?)?;
    let mut stream = Stream::open(open()?)?;
    let mut warnings = Vec::new();
    let all = stream.fields(&mut warnings);
    let has_normals = NORMALS.iter().all(|name| all.iter().filter(|field| field.name == *name).count() == 1);
    let is_normal = |field: &Field| has_normals && NORMALS.contains(&field.name.as_str());
    // Of large integers what is lost has to be looked at in memory.
    if all.iter().zip(&survey.kept).any(|(field, kept)| *kept && field.is_wide() && !is_normal(field)) {
        return Ok(false);
    }
    if stream.format.colour().is_some() && survey.rounds {
        warnings.push(ROUNDED_COLOURS.to_owned());
    }
    if stream.format.format.has_waveform {
        warnings.push("not read: waveforms".to_owned());
    }
    // Of normals a component may be zero everywhere.
    let kept = all.into_iter().zip(&survey.kept).filter(|(field, kept)| **kept || is_normal(field));
    let kept: Vec<Field> = kept.map(|(field, _)| field).collect();
    let mut goes_on = true;
    while goes_on {
        let (cloud, more) = next_cloud(&mut stream, &kept, has_normals, survey.scale, limit)?;
        if cloud.is_empty() {
            break;
        }
        let mut warnings = warnings.clone();
        warnings.extend(more);
        goes_on = take(Parsed::cloud(stream.name(), cloud, warnings))?;
    }
    Ok(true)
}

/// The next points, and what is to be told about names.
fn next_cloud(
    stream: &mut Stream,
    kept: &[Field],
    has_normals: bool,
    scale: f64,
    limit: usize,
) -> Result<(PointCloud, Vec<String>), Error> {
    let mut warnings = Vec::new();
    let (format, transform) = (stream.format, stream.transform);
    let mut positions = Vec::new();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); kept.len()];
    let mut channels = ["red", "green", "blue"].map(|name| Column {
        name: name.to_owned(),
        kind: Kind::Integer,
        values: Vec::new(),
    });
    while positions.len() < limit {
        let records = stream.next_records((limit - positions.len()) as u64)?;
        if records.is_empty() {
            break;
        }
        for record in records.chunks_exact(format.length.max(1)) {
            positions.push(position(record, transform));
            if let Some(at) = format.colour() {
                for (channel, at) in channels.iter_mut().zip([at, at + 2, at + 4]) {
                    channel.values.push(NumberType::U16.decode::<true>(&record[at..at + 2]));
                }
            }
            for (values, field) in columns.iter_mut().zip(kept) {
                values.push(field.of_record(record));
            }
        }
    }
    let mut attributes = Attributes::default();
    if format.colour().is_some() {
        let [red, green, blue] = &channels;
        attributes.set_colours(scaled_colours(&[red, green, blue], scale, &mut false));
    }
    let names = kept.iter().map(|field| field.name.clone());
    let mut fields: Vec<(String, Vec<f64>)> = names.zip(columns).collect();
    if has_normals {
        let mut take = |name: &str| {
            let place = fields.iter().position(|(own, _)| own == name).unwrap_or_default();
            fields.remove(place).1
        };
        let [x, y, z] = NORMALS.map(&mut take);
        let normals = x.into_iter().zip(y).zip(z).map(|((x, y), z)| Vector3::new(x, y, z));
        attributes.set_normals(Some(normals.collect()));
    }
    for (name, values) in fields {
        let name = free_name(&attributes, name, &mut warnings);
        attributes.push_scalar(name, values).map_err(Error::shape)?;
    }
    let cloud = PointCloud::new(positions).with_attributes(attributes).map_err(Error::shape)?;
    Ok((cloud, warnings))
}
