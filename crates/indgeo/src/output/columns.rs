//! One array after the other, for callers from another language: what is read is used where it lies.

use super::rows::{Cell, NAME, Rows, append_cell};
use crate::runtime::threads;
use serde::Serialize;
use std::io::{self, Write};
use std::ops::Range;

/// Arrays begin at multiples of this many bytes.
const ALIGNMENT: usize = 8;

/// Columns that are one matrix with a row per point.
const MATRICES: [&[&str]; 6] = [
    &["x", "y", "z"],
    &["x", "y"],
    &["foot_x", "foot_y", "foot_z"],
    &["foot_x", "foot_y"],
    &["normal_x", "normal_y", "normal_z"],
    &["u", "v"],
];

/// The first line of the file, filled up with spaces; the arrays follow in this order.
#[derive(Serialize)]
struct Header<'a> {
    /// Number of rows of every array.
    rows: usize,
    /// The arrays.
    arrays: Vec<Array<'a>>,
    /// After them the ends of the names (unsigned, 8 bytes each) and their bytes: what the column is called.
    names: Option<&'a str>,
    /// What the numbers of names of states mean.
    comments: Vec<String>,
}

/// A matrix with a row per point.
#[derive(Serialize)]
struct Array<'a> {
    /// The names of its columns.
    columns: &'a [&'static str],
    /// Kind of number, as numpy spells it.
    kind: &'static str,
}

/// Little endian: doubles for numbers, 32 bits for indices (−1 for none), a byte for names of states and colours.
pub(super) fn write(out: &mut dyn Write, table: &dyn Rows) -> io::Result<()> {
    let names = table.names();
    let arrays = arrays(&names);
    let header = Header {
        rows: table.count(),
        arrays: arrays
            .iter()
            .map(|range| Array { columns: &names[range.clone()], kind: kind(table, range.start) })
            .collect(),
        names: table.point_names().map(|_| NAME),
        comments: table.comments(),
    };
    let mut line = serde_json::to_vec(&header)?;
    line.resize((line.len() + 1).next_multiple_of(ALIGNMENT) - 1, b' ');
    line.push(b'\n');
    out.write_all(&line)?;
    for columns in arrays {
        let size = table.count() * columns.len() * size(kind(table, columns.start));
        threads::write_rows(out, table.count(), |rows, bytes| {
            for row in rows {
                columns.clone().for_each(|column| append_cell(bytes, table.cell(row, column)));
            }
        })?;
        fill_up(out, size)?;
    }
    let Some(labels) = table.point_names() else { return Ok(()) };
    let texts = || (0..table.count()).map(|row| labels.get(row).unwrap_or_default());
    let mut end = 0u64;
    for text in texts() {
        end += text.len() as u64;
        out.write_all(&end.to_le_bytes())?;
    }
    texts().try_for_each(|text| out.write_all(text.as_bytes()))
}

/// The columns of each array.
fn arrays(names: &[&str]) -> Vec<Range<usize>> {
    let mut arrays = Vec::new();
    let mut start = 0;
    while start < names.len() {
        let rest = &names[start..];
        let width = MATRICES.iter().find(|matrix| rest.starts_with(matrix)).map_or(1, |matrix| matrix.len());
        arrays.push(start..start + width);
        start += width;
    }
    arrays
}

/// Without rows there is nothing that a wrong kind could spoil.
fn kind(table: &dyn Rows, column: usize) -> &'static str {
    match (table.count() > 0).then(|| table.cell(0, column)) {
        Some(Cell::Index(_)) => "<i4",
        Some(Cell::Name(..) | Cell::Byte(_)) => "|u1",
        _ => "<f8",
    }
}

fn size(kind: &str) -> usize {
    match kind {
        "<f8" => 8,
        "<i4" => 4,
        _ => 1,
    }
}

fn fill_up(out: &mut dyn Write, size: usize) -> io::Result<()> {
    let missing = size.next_multiple_of(ALIGNMENT) - size;
    out.write_all(&[0; ALIGNMENT][..missing])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_of_a_vector_are_one_array() {
        assert_eq!(
            arrays(&["x", "y", "z", "foot_x", "foot_y", "distance", "u", "v", "t"]),
            [0..3, 3..5, 5..6, 6..8, 8..9]
        );
        assert_eq!(arrays(&["x", "y", "foot_x"]), [0..2, 2..3]);
        assert!(arrays(&[]).is_empty());
    }
}
