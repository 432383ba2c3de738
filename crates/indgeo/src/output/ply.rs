//! PLY with the results as properties of the vertices.

use super::table::{Cell, Column, Table};
use crate::threads;
use industrial_geometry::footpoint::Status;
use std::io::{self, Write};

/// The statuses in the order of their numbers in the file.
const STATUSES: [Status; 7] = [
    Status::Converged,
    Status::OnBoundary,
    Status::Stalled,
    Status::MaxIterations,
    Status::Diverged,
    Status::Cancelled,
    Status::InvalidPoint,
];

/// Binary little endian: doubles for numbers, `int` for indices (−1 for none), `uchar` for the status.
///
/// The triangles of the input are kept, so that a viewer shows the scan as it was.
pub(super) fn write(out: &mut dyn Write, table: &Table<'_>) -> io::Result<()> {
    write_header(out, table)?;
    threads::write_rows(out, table.points.len(), |rows, bytes| {
        for row in rows {
            for cell in table.cells(row) {
                match cell {
                    Cell::Number(value) => bytes.extend(value.to_le_bytes()),
                    Cell::Index(index) => {
                        let index = index.and_then(|index| i32::try_from(index).ok()).unwrap_or(-1);
                        bytes.extend(index.to_le_bytes());
                    }
                    Cell::Status(status) => bytes.push(code(status)),
                }
            }
        }
    })?;
    threads::write_rows(out, table.triangles.len(), |rows, bytes| {
        for corners in &table.triangles[rows] {
            bytes.push(3);
            for corner in corners {
                bytes.extend(corner.to_le_bytes());
            }
        }
    })
}

fn write_header(out: &mut dyn Write, table: &Table<'_>) -> io::Result<()> {
    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    writeln!(out, "comment footpoints by indgeo {}, in the unit of the input", env!("CARGO_PKG_VERSION"))?;
    let names: Vec<String> = STATUSES.iter().map(|&status| format!("{} {status}", code(status))).collect();
    writeln!(out, "comment status: {}", names.join(", "))?;
    writeln!(out, "element vertex {}", table.points.len())?;
    for column in &table.layout.0 {
        let kind = match column {
            Column::Shape | Column::Triangle => "int",
            Column::Status => "uchar",
            _ => "double",
        };
        writeln!(out, "property {kind} {}", column.name())?;
    }
    if !table.triangles.is_empty() {
        writeln!(out, "element face {}\nproperty list uchar uint vertex_indices", table.triangles.len())?;
    }
    out.write_all(b"end_header\n")
}

/// The number of a status in the file; 255 for one that is not listed.
fn code(status: Status) -> u8 {
    (0u8..).zip(STATUSES).find(|(_, other)| *other == status).map_or(u8::MAX, |(code, _)| code)
}
