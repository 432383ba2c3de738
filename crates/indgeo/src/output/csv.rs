//! Comma-separated values.

use super::rows::{Cell, Rows, append_number};
use crate::runtime::threads;
use industrial_geometry::io::write_text;
use std::io::{self, Write};

/// A header line and one line per point; a cell without a value is empty.
pub(super) fn write(out: &mut dyn Write, table: &dyn Rows) -> io::Result<()> {
    write_header(out, table)?;
    write_rows(out, table)
}

/// The header line.
pub(super) fn write_header(out: &mut dyn Write, table: &dyn Rows) -> io::Result<()> {
    let name = if table.point_names().is_some() { ",name" } else { "" };
    writeln!(out, "{}{name}", table.names().join(","))
}

/// The lines of some points, or of all.
pub(super) fn write_rows(out: &mut dyn Write, table: &dyn Rows) -> io::Result<()> {
    let names = table.names();
    let labels = table.point_names();
    threads::write_rows(out, table.count(), |rows, bytes| {
        for row in rows {
            for column in 0..names.len() {
                if column > 0 {
                    bytes.push(b',');
                }
                match table.cell(row, column) {
                    Cell::Given(value) => append_number(bytes, value),
                    Cell::Number(value) if value.is_finite() => append_number(bytes, value),
                    Cell::Index(Some(index)) => bytes.extend(index.to_string().as_bytes()),
                    Cell::Number(_) | Cell::Index(None) => {}
                    Cell::Name(name, _) => bytes.extend(name.as_bytes()),
                    Cell::Byte(value) => bytes.extend(value.to_string().as_bytes()),
                }
            }
            if let Some(labels) = labels {
                bytes.push(b',');
                // Writing to memory cannot fail.
                let _ = write_text(bytes, labels.get(row).unwrap_or_default(), true);
            }
            bytes.push(b'\n');
        }
    })
}
