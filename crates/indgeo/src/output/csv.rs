//! Comma-separated values.

use super::number;
use super::table::{Cell, Table};
use crate::threads;
use std::io::{self, Write};

/// A header line and one line per point; a cell without a value is empty.
pub(super) fn write(out: &mut dyn Write, table: &Table<'_>) -> io::Result<()> {
    writeln!(out, "{}", table.layout.names().join(","))?;
    let points = table.layout.0.iter().filter(|column| matches!(column, super::Column::Point(_))).count();
    threads::write_rows(out, table.points.len(), |rows, bytes| {
        for row in rows {
            for (place, cell) in table.cells(row).enumerate() {
                if place > 0 {
                    bytes.push(b',');
                }
                match cell {
                    // The coordinates of the point are given back as read, whatever they are.
                    Cell::Number(value) if place < points || value.is_finite() => {
                        number::append(bytes, value);
                    }
                    Cell::Index(Some(index)) => bytes.extend(index.to_string().as_bytes()),
                    Cell::Number(_) | Cell::Index(None) => {}
                    Cell::Status(status) => bytes.extend(status.name().as_bytes()),
                }
            }
            bytes.push(b'\n');
        }
    })
}
