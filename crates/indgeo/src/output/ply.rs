//! PLY with the results as properties of the vertices.

use super::rows::{Cell, Rows};
use crate::threads;
use std::io::{self, Write};

/// Binary little endian: doubles for numbers, `int` for indices (−1 for none), `uchar` for names and colours.
///
/// The triangles of the input are kept, so that a viewer shows the scan as it was.
pub(super) fn write(out: &mut dyn Write, table: &dyn Rows) -> io::Result<()> {
    let names = table.names();
    write_header(out, table, &names)?;
    threads::write_rows(out, table.count(), |rows, bytes| {
        for row in rows {
            for column in 0..names.len() {
                match table.cell(row, column) {
                    Cell::Given(value) | Cell::Number(value) => bytes.extend(value.to_le_bytes()),
                    Cell::Index(index) => {
                        let index = index.and_then(|index| i32::try_from(index).ok()).unwrap_or(-1);
                        bytes.extend(index.to_le_bytes());
                    }
                    Cell::Name(_, code) => bytes.push(code),
                    Cell::Byte(value) => bytes.push(value),
                }
            }
        }
    })?;
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

fn write_header(out: &mut dyn Write, table: &dyn Rows, names: &[&str]) -> io::Result<()> {
    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    for comment in table.comments() {
        writeln!(out, "comment {comment}")?;
    }
    writeln!(out, "element vertex {}", table.count())?;
    for (column, name) in names.iter().enumerate() {
        // Without rows there is nothing that a wrong kind could spoil.
        let kind = match (table.count() > 0).then(|| table.cell(0, column)) {
            Some(Cell::Index(_)) => "int",
            Some(Cell::Name(..) | Cell::Byte(_)) => "uchar",
            _ => "double",
        };
        writeln!(out, "property {kind} {name}")?;
    }
    if !table.triangles().is_empty() {
        writeln!(out, "element face {}\nproperty list uchar uint vertex_indices", table.triangles().len())?;
    }
    out.write_all(b"end_header\n")
}
