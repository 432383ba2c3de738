//! PLY with the results as properties of the vertices.

use super::rows::{Cell, NAME, Rows, append_cell};
use crate::runtime::threads;
use std::io::{self, Write};

/// Binary little endian: doubles for numbers, `int` for indices (−1 for none), `uchar` for names of states and colours, a list of
/// bytes for the name of a point.
///
/// The triangles of the input are kept, so that a viewer shows the scan as it was.
pub(super) fn write(out: &mut dyn Write, table: &dyn Rows) -> io::Result<()> {
    let is_long = table.point_names().is_some_and(|labels| labels.iter().any(|name| name.len() > 255));
    write_header(out, table, table.count(), is_long)?;
    write_rows(out, table, is_long)?;
    let triangles = table.triangles();
    threads::write_rows(out, triangles.len(), |rows, bytes| {
        for corners in &triangles[rows] {
            bytes.push(3);
            for corner in corners {
                bytes.extend(corner.to_le_bytes());
            }
        }
    })
}

/// The vertices of some points, or of all; `is_long` says that names may be longer than 255 bytes.
pub(super) fn write_rows(out: &mut dyn Write, table: &dyn Rows, is_long: bool) -> io::Result<()> {
    let names = table.names();
    let labels = table.point_names();
    threads::write_rows(out, table.count(), |rows, bytes| {
        for row in rows {
            for column in 0..names.len() {
                append_cell(bytes, table.cell(row, column));
            }
            if let Some(name) = labels.map(|labels| labels.get(row).unwrap_or_default()) {
                let length = u32::try_from(name.len()).unwrap_or(u32::MAX).to_le_bytes();
                bytes.extend(if is_long { &length } else { &length[..1] });
                bytes.extend(name.as_bytes());
            }
        }
    })
}

/// The header of a table with `count` rows in all, of which `table` has the first.
pub(super) fn write_header(
    out: &mut dyn Write,
    table: &dyn Rows,
    count: usize,
    is_long: bool,
) -> io::Result<()> {
    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    for comment in table.comments() {
        writeln!(out, "comment {comment}")?;
    }
    writeln!(out, "element vertex {count}")?;
    for (column, name) in table.names().iter().enumerate() {
        // Without rows there is nothing that a wrong kind could spoil.
        let kind = match (table.count() > 0).then(|| table.cell(0, column)) {
            Some(Cell::Index(_)) => "int",
            Some(Cell::Name(..) | Cell::Byte(_)) => "uchar",
            _ => "double",
        };
        writeln!(out, "property {kind} {name}")?;
    }
    if table.point_names().is_some() {
        writeln!(out, "property list {} uchar {NAME}", if is_long { "uint" } else { "uchar" })?;
    }
    if !table.triangles().is_empty() {
        writeln!(out, "element face {}\nproperty list uchar uint vertex_indices", table.triangles().len())?;
    }
    out.write_all(b"end_header\n")
}
