//! What a LAS file promises, checked against its size before anything is allocated or decoded.

use std::io::{Read, Seek, SeekFrom};

use ::laz::laszip::ChunkTable;
use ::laz::{LazItemType, LazVlr};

use crate::error::Location;
use crate::foreign::{DAMAGED, Input};
use crate::{Error, Place};

/// Bytes of the head of a variable length record, and of an extended one.
const HEAD: usize = 54;
const EXTENDED_HEAD: usize = 60;
/// Most bytes of a compressed record: the decoder keeps models for each of them.
pub(super) const MOST_COMPRESSED: u16 = 8192;
/// Most points per compressed byte. Points that are all the same take one byte for 140.
const MOST_POINTS_PER_BYTE: u64 = 1024;

/// What is known of a file before its points are read.
pub(super) struct Checked {
    /// Number of points.
    pub(super) points: u64,
}

/// A place in a file as messages name it.
fn byte(offset: u64) -> Place {
    Place::Byte(usize::try_from(offset).unwrap_or(usize::MAX))
}

/// An error of the content at a byte.
fn malformed(offset: u64, what: impl Into<String>) -> Error {
    Error::malformed(byte(offset), what, DAMAGED)
}

fn truncated(offset: u64, what: &str, promised: u64, needed: u64, length: u64) -> Error {
    Error::Truncated {
        location: Location { file: None, place: byte(offset) },
        what: what.to_owned(),
        promised,
        needed,
        left: length.saturating_sub(offset),
    }
}

/// The next `N` bytes at `offset`.
fn bytes<const N: usize>(input: &mut Input, offset: u64, what: &str) -> Result<[u8; N], Error> {
    let mut found = [0; N];
    let ended = |_| malformed(offset, format!("the file ends within {what}"));
    input.reader.seek(SeekFrom::Start(offset)).map_err(ended)?;
    input.reader.read_exact(&mut found).map_err(ended)?;
    Ok(found)
}

fn u16_at(data: &[u8], at: usize) -> u16 {
    data.get(at..at + 2).map_or(0, |bytes| u16::from_le_bytes([bytes[0], bytes[1]]))
}

fn u32_at(data: &[u8], at: usize) -> u32 {
    u32::from(u16_at(data, at)) | u32::from(u16_at(data, at + 2)) << 16
}

fn u64_at(data: &[u8], at: usize) -> u64 {
    u64::from(u32_at(data, at)) | u64::from(u32_at(data, at + 4)) << 32
}

/// Checks versions, sizes and counts of the header, and the records that follow it.
pub(super) fn check(input: &mut Input, header: &::las::raw::Header) -> Result<Checked, Error> {
    let version = header.version;
    if version.major != 1 || version.minor > 4 {
        let what = format!("this is LAS {}.{}, of which 1.0 to 1.4 are read", version.major, version.minor);
        return Err(Error::unsupported(byte(24), what, "convert it to LAS 1.4 first"));
    }
    let (size, start) = (u64::from(header.header_size), u64::from(header.offset_to_point_data));
    if header.header_size < version.header_size() {
        return Err(malformed(94, format!("the header is to have {size} bytes, which are too few")));
    }
    if start < size || start > input.length {
        let what = format!("the points are to begin at byte {start} of {}", input.length);
        return Err(malformed(96, what));
    }
    let transform = [
        (header.x_scale_factor, header.x_offset),
        (header.y_scale_factor, header.y_offset),
        (header.z_scale_factor, header.z_offset),
    ];
    let points = match (header.number_of_point_records, header.large_file) {
        (0, Some(large)) => large.number_of_point_records,
        (count, _) => u64::from(count),
    };
    let usable = |&(scale, offset): &(f64, f64)| scale.is_finite() && scale != 0.0 && offset.is_finite();
    if points > 0
        && let Some((scale, offset)) = transform.iter().find(|pair| !usable(pair))
    {
        let what = format!("coordinates are to be multiples of {scale} from {offset} on");
        return Err(malformed(131, what));
    }
    let compression = check_records(input, header)?;
    if let Some(extended) = header.evlr {
        let at = extended.start_of_first_evlr;
        let head: [u8; EXTENDED_HEAD] = bytes(input, at, "the extended record")?;
        let needed = u64_at(&head, 20);
        if needed > input.length.saturating_sub(at + EXTENDED_HEAD as u64) {
            return Err(truncated(
                at + EXTENDED_HEAD as u64,
                "bytes of an extended record",
                needed,
                needed,
                input.length,
            ));
        }
    }
    let record = u64::from(header.point_data_record_length);
    if header.point_data_record_format & 0x80 == 0 {
        let needed = points.saturating_mul(record);
        if needed > input.length - start {
            return Err(truncated(start, "points", points, needed, input.length));
        }
        return Ok(Checked { points });
    }
    let Some(compression) = compression else {
        return Err(malformed(size, "the points are compressed, but no record says how"));
    };
    check_compressed(input, start, record, points, &compression)?;
    Ok(Checked { points })
}

/// Walks over the variable length records; returns that of the compression.
fn check_records(input: &mut Input, header: &::las::raw::Header) -> Result<Option<Vec<u8>>, Error> {
    let start = u64::from(header.offset_to_point_data);
    let mut at = u64::from(header.header_size);
    let mut compression = None;
    for number in 0..header.number_of_variable_length_records {
        let what = || {
            let count = header.number_of_variable_length_records;
            format!("record {} of {count} between header and points does not fit there", number + 1)
        };
        if at + HEAD as u64 > start {
            return Err(malformed(at, what()));
        }
        let head: [u8; HEAD] = bytes(input, at, "a record behind the header")?;
        let length = u16_at(&head, 20);
        if at + HEAD as u64 + u64::from(length) > start {
            return Err(malformed(at, what()));
        }
        let user = head[2..18].split(|&byte| byte == 0).next().unwrap_or_default();
        if user == LazVlr::USER_ID.as_bytes() && u16_at(&head, 18) == LazVlr::RECORD_ID {
            let mut data = vec![0; usize::from(length)];
            input.reader.read_exact(&mut data).map_err(|_| malformed(at, "the file ends within a record"))?;
            compression = Some(data);
        }
        at += HEAD as u64 + u64::from(length);
    }
    Ok(compression)
}

/// Layers of a field in a chunk of the layered compression, each with its size.
fn layers(item: LazItemType) -> u64 {
    match item {
        LazItemType::Point14 => 9,
        LazItemType::RGBNIR14 => 2,
        LazItemType::Byte14(count) => u64::from(count),
        _ => 1,
    }
}

/// Checks the compression, the table of chunks, and the sizes within each chunk: the decoder allocates what they say.
fn check_compressed(
    input: &mut Input,
    start: u64,
    record: u64,
    points: u64,
    compression: &[u8],
) -> Result<(), Error> {
    let refused =
        |error: ::laz::LasZipError| malformed(start, format!("the compression is not read: {error}"));
    let laz = LazVlr::from_buffer(compression).map_err(refused)?;
    let size: u64 = laz.items().iter().map(|item| u64::from(item.size())).sum();
    if size != record {
        let what = format!("records have {record} bytes, but the compression is for {size}");
        return Err(malformed(105, what));
    }
    if record > u64::from(MOST_COMPRESSED) {
        let what =
            format!("records of {record} bytes are compressed; {MOST_COMPRESSED} is the most that is read");
        return Err(Error::unsupported(byte(105), what, "convert it to LAS first"));
    }
    if points == 0 {
        return Ok(());
    }
    let left = input.length - start;
    if points > left.saturating_mul(MOST_POINTS_PER_BYTE) {
        return Err(truncated(start, "points", points, points / MOST_POINTS_PER_BYTE, input.length));
    }
    // 1 is one chunk of all points, 2 are chunks, 3 are chunks of layers.
    let kind = u16_at(compression, 0);
    let variable = laz.uses_variable_size_chunks();
    if kind == 1 {
        return Ok(());
    }
    let table = chunk_table(input, start, record, &laz)?;
    if kind != 3 {
        return match table {
            Some((table, at)) if !variable => check_count(&table, u64::from(laz.chunk_size()), points, at),
            _ => Ok(()),
        };
    }
    let layers: u64 = laz.items().iter().map(|item| layers(item.item_type())).sum();
    let mut at = start + 8;
    let mut found = 0;
    let mut chunk = 0;
    while found < points {
        let sizes = at + record + 4;
        let [head] = [bytes::<4>(input, at + record, "a chunk of points")?];
        let count = u64::from(u32::from_le_bytes(head));
        let expected = match &table {
            Some((table, _)) if variable => table.as_ref().get(chunk).map(|entry| entry.point_count),
            _ if variable => None,
            _ => Some(u64::from(laz.chunk_size()).min(points - found)),
        };
        if expected != Some(count) || count == 0 {
            let what =
                format!("chunk {} holds {count} points, which contradicts the table of chunks", chunk + 1);
            return Err(malformed(at, what));
        }
        let mut needed = 0;
        for layer in 0..layers {
            needed += u64::from(u32::from_le_bytes(bytes(input, sizes + 4 * layer, "a chunk of points")?));
        }
        let data = sizes + 4 * layers;
        if needed > input.length.saturating_sub(data) {
            return Err(truncated(data, "bytes of a chunk of points", needed, needed, input.length));
        }
        at = data + needed;
        found += count;
        chunk += 1;
    }
    if found > points {
        return Err(malformed(107, format!("{points} points are promised, but the chunks hold {found}")));
    }
    Ok(())
}

/// The table of chunks and where it is; `None` where the file has none that can be read, which chunks of one size do without.
fn chunk_table(
    input: &mut Input,
    start: u64,
    record: u64,
    laz: &LazVlr,
) -> Result<Option<(ChunkTable, u64)>, Error> {
    // A writer that could not go back put the place at the end of the file.
    let usable = |place: &u64| *place > start && *place < i64::MAX as u64;
    let mut place =
        Some(u64::from_le_bytes(bytes(input, start, "the place of the table of chunks")?)).filter(usable);
    if place.is_none() && input.length >= start + 16 {
        let last = bytes(input, input.length - 8, "the place of the table of chunks")?;
        place = Some(u64::from_le_bytes(last)).filter(usable);
    }
    let table = place.and_then(|place| {
        let head: [u8; 8] = bytes(input, place, "the table of chunks").ok()?;
        // Each chunk begins with a whole record, so that this bounds what the table takes.
        let chunks = u64::from(u32_at(&head, 4));
        (chunks.saturating_mul(record.max(1)) <= input.length - start).then_some(place)
    });
    let Some(at) = table else {
        return match (place, laz.uses_variable_size_chunks()) {
            // The decoder would read the damaged table.
            (Some(at), _) if at < input.length => {
                Err(malformed(at, "the table of chunks does not fit the file"))
            }
            (_, true) => Err(malformed(start, "chunks of different sizes need a table, which is missing")),
            _ => Ok(None),
        };
    };
    let mut reader = &mut input.reader;
    let damaged = |_| malformed(at, "the table of chunks ends early");
    reader.seek(SeekFrom::Start(at)).map_err(damaged)?;
    let table = ChunkTable::read(&mut reader, laz.uses_variable_size_chunks()).map_err(damaged)?;
    if laz.uses_variable_size_chunks()
        && table.as_ref().iter().any(|entry| entry.point_count > u64::from(u32::MAX))
    {
        return Err(malformed(at, "a chunk is to hold more points than a chunk can"));
    }
    Ok(Some((table, at)))
}

/// Checks that chunks of `size` points hold all points and no chunk is too many.
fn check_count(table: &ChunkTable, size: u64, points: u64, at: u64) -> Result<(), Error> {
    let chunks = table.len() as u64;
    if points.div_ceil(size) == chunks {
        return Ok(());
    }
    let what = format!("{points} points are promised, but there are {chunks} chunks of {size}");
    Err(malformed(at, what))
}
