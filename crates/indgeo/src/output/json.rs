//! JSON with one array per column.

use super::number;
use super::table::{Cell, Table};
use crate::threads;
use std::io::{self, Write};

/// `{"points":N,"columns":["x",…],"x":[…],…}`; `null` stands for a value that is not finite.
pub(super) fn write(out: &mut dyn Write, table: &Table<'_>) -> io::Result<()> {
    let names = table.layout.names();
    write!(out, "{{\"points\":{},\"columns\":[\"{}\"]", table.points.len(), names.join("\",\""))?;
    for (column, name) in table.layout.0.iter().zip(names) {
        write!(out, ",\n\"{name}\":[")?;
        threads::write_rows(out, table.points.len(), |rows, bytes| {
            for row in rows {
                if row > 0 {
                    bytes.push(b',');
                }
                match column.cell(&table.points[row], &table.feet[row]) {
                    Cell::Number(value) if value.is_finite() => number::append(bytes, value),
                    Cell::Index(Some(index)) => bytes.extend(index.to_string().as_bytes()),
                    Cell::Number(_) | Cell::Index(None) => bytes.extend(b"null"),
                    Cell::Status(status) => {
                        bytes.push(b'"');
                        bytes.extend(status.name().as_bytes());
                        bytes.push(b'"');
                    }
                }
            }
        })?;
        out.write_all(b"]")?;
    }
    out.write_all(b"}\n")
}
