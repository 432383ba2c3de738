//! Tables that are written piece by piece, as they come.

use super::rows::Rows;
use super::{Format, Written, csv, ply};
use crate::error::Error;
use crate::files;
use std::io;
use std::path::Path;

/// Takes the next rows of a table.
pub(crate) type Sink<'a> = dyn FnMut(&dyn Rows) -> Result<(), Error> + 'a;

/// Whether a format is one of rows that follow each other.
pub(crate) fn is_written_in_pieces(format: Format) -> bool {
    matches!(format, Format::Csv | Format::Ply)
}

/// Writes a table of `count` rows without names and triangles, which `fill` hands over piece by piece: the same bytes as those of
/// the whole table. The file appears whole or not at all; an error of `fill` comes back.
pub(crate) fn write_in_pieces(
    path: &Path,
    format: Format,
    count: usize,
    fill: impl FnOnce(&mut Sink<'_>) -> Result<(), Error>,
) -> Result<Written, Error> {
    let mut failed = None;
    let written = files::write(path, |out| {
        let mut is_first = true;
        let mut sink = |table: &dyn Rows| {
            let mut write = || {
                match format {
                    Format::Ply if is_first => ply::write_header(out, table, count, false)?,
                    Format::Csv if is_first => csv::write_header(out, table)?,
                    _ => {}
                }
                is_first = false;
                match format {
                    Format::Ply => ply::write_rows(out, table, false),
                    _ => csv::write_rows(out, table),
                }
            };
            write().map_err(|source| Error::write(path, source))
        };
        fill(&mut sink).map_err(|error| {
            failed = Some(error);
            io::Error::other("the rows could not be made")
        })
    });
    match (failed, written) {
        (Some(error), _) | (None, Err(error)) => Err(error),
        (None, Ok(bytes)) => Ok(Written { bytes, warnings: Vec::new() }),
    }
}
