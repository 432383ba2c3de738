//! JSON with one array per column.

use super::rows::{Cell, NAME, Rows, append_number};
use crate::runtime::threads;
use std::io::{self, Write};

/// `{"points":N,"columns":["x",…],"x":[…],…}`; `null` stands for a value that is not finite.
pub(super) fn write(out: &mut dyn Write, table: &dyn Rows) -> io::Result<()> {
    let names = table.names();
    let labels = table.point_names();
    let columns: Vec<&str> = names.iter().copied().chain(labels.map(|_| NAME)).collect();
    write!(out, "{{\"points\":{},\"columns\":[\"{}\"]", table.count(), columns.join("\",\""))?;
    for (column, name) in names.iter().enumerate() {
        write!(out, ",\n\"{name}\":[")?;
        threads::write_rows(out, table.count(), |rows, bytes| {
            for row in rows {
                if row > 0 {
                    bytes.push(b',');
                }
                match table.cell(row, column) {
                    Cell::Given(value) | Cell::Number(value) if value.is_finite() => {
                        append_number(bytes, value);
                    }
                    Cell::Index(Some(index)) => bytes.extend(index.to_string().as_bytes()),
                    Cell::Given(_) | Cell::Number(_) | Cell::Index(None) => bytes.extend(b"null"),
                    Cell::Name(name, _) => {
                        bytes.push(b'"');
                        bytes.extend(name.as_bytes());
                        bytes.push(b'"');
                    }
                    Cell::Byte(value) => bytes.extend(value.to_string().as_bytes()),
                }
            }
        })?;
        out.write_all(b"]")?;
    }
    if let Some(labels) = labels {
        write!(out, ",\n\"{NAME}\":")?;
        serde_json::to_writer(&mut *out, &labels.iter().collect::<Vec<&str>>())?;
    }
    out.write_all(b"}\n")
}
