//! Clouds that may be larger than memory, converted and described piece by piece.

use crate::error::Error;
use crate::files;
use crate::runtime::memory;
use industrial_geometry::io::{self, ReadOptions, ReadReport, WriteOptions, WriteReport};
use industrial_geometry::mesh::{Attributes, BoundingBox};
use std::fs;
use std::path::Path;

/// Points of a piece.
const PIECE: usize = 1 << 17;
/// Files up to this size, in bytes, are read as a whole, which is faster.
const SMALL: u64 = 32 << 20;

/// Whether a file is too large to be read as a whole for nothing.
fn is_large(path: &Path) -> bool {
    !files::is_stream(path)
        && !memory::is_memory(path)
        && fs::metadata(path).is_ok_and(|file| file.is_file() && file.len() > SMALL)
}

/// Converts a large file of points; `None` where it, or the output, is held in memory.
pub(crate) fn convert(
    input: &Path,
    output: &Path,
    options: &ReadOptions,
    written: &WriteOptions,
) -> Result<Option<(ReadReport, WriteReport)>, Error> {
    let is_file = !files::is_stream(output) && !memory::is_memory(output);
    if !is_large(input) || !is_file || !io::is_written_in_pieces(output, written) {
        return Ok(None);
    }
    // How many there are stands before them in some formats.
    let Some(counted) = io::read_pieces(input, options, PIECE, |_| Ok::<(), Error>(()))? else {
        return Ok(None);
    };
    let count = counted.points - counted.dropped;
    let (mut read, mut is_whole) = (None, false);
    let written = io::write_cloud_pieces(output, written, count, |write| -> Result<(), Error> {
        let mut rows = 0;
        read = io::read_cloud_pieces(input, options, PIECE, |cloud| {
            if memory::is_cancelled() {
                return Err(Error::usage("cancelled", "nothing was written"));
            }
            rows += cloud.len();
            write(&cloud)
        })?;
        if read.is_some() && rows != count {
            let what = "the file has changed while it was read";
            return Err(Error::content(input, what, "run the command again"));
        }
        is_whole = read.is_none();
        if is_whole {
            // Nothing was written, and nothing stays.
            return Err(Error::content(input, "the file is not read in pieces", "read it as a whole"));
        }
        Ok(())
    });
    if is_whole { Ok(None) } else { Ok(read.zip(Some(written?))) }
}

/// What a large file of points holds.
pub(crate) struct Described {
    pub(crate) read: ReadReport,
    /// Attributes, with the values of some points.
    pub(crate) attributes: Attributes,
    pub(crate) bounds: Option<BoundingBox>,
}

/// Describes a large file of points; `None` where it has to be read as a whole.
pub(crate) fn describe(path: &Path, options: &ReadOptions) -> Result<Option<Described>, Error> {
    if !is_large(path) {
        return Ok(None);
    }
    let (mut attributes, mut bounds): (Option<Attributes>, Option<BoundingBox>) = (None, None);
    let read = io::read_cloud_pieces(path, options, PIECE, |cloud| -> Result<(), Error> {
        if let Some(more) = cloud.bounding_box() {
            let all = bounds.get_or_insert(more);
            (all.min, all.max) = (all.min.inf(&more.min), all.max.sup(&more.max));
        }
        attributes.get_or_insert_with(|| cloud.attributes().clone());
        Ok(())
    })?;
    Ok(read.map(|read| Described { read, attributes: attributes.unwrap_or_default(), bounds }))
}
