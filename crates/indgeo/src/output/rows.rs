//! What the writers of results ask of a table.

use industrial_geometry::io::write_number;
use industrial_geometry::mesh::TextField;

/// The column of names.
pub(crate) const NAME: &str = "name";

/// The content of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Cell {
    /// A coordinate of the input, given back as read, whatever it is.
    Given(f64),
    /// A number; NaN where there is none.
    Number(f64),
    /// An index, if there is one.
    Index(Option<u32>),
    /// One of a few names, and its number in binary files.
    Name(&'static str, u8),
    /// A channel of a colour.
    Byte(u8),
}

/// A table with one row per point.
pub(crate) trait Rows: Sync {
    /// The names in the header.
    fn names(&self) -> Vec<&'static str>;
    /// Number of rows.
    fn count(&self) -> usize;
    /// A cell; cells of a column are all of one kind.
    fn cell(&self, row: usize, column: usize) -> Cell;
    /// Names of the points, which are the last column, called [`NAME`].
    fn point_names(&self) -> Option<&TextField> {
        None
    }
    /// Triangles over the points, kept in formats that can hold them.
    fn triangles(&self) -> &[[u32; 3]];
    /// What a reader of a binary file should know.
    fn comments(&self) -> Vec<String>;
}

/// Appends a number as text that reads back to the same bits.
pub(super) fn append_number(bytes: &mut Vec<u8>, value: f64) {
    // Writing to memory cannot fail.
    let _ = write_number(bytes, value);
}

/// The value of a cell in binary files: little endian, −1 for no index.
pub(super) fn append_cell(bytes: &mut Vec<u8>, cell: Cell) {
    match cell {
        Cell::Given(value) | Cell::Number(value) => bytes.extend(value.to_le_bytes()),
        Cell::Index(index) => {
            let index = index.and_then(|index| i32::try_from(index).ok()).unwrap_or(-1);
            bytes.extend(index.to_le_bytes());
        }
        Cell::Name(_, code) => bytes.push(code),
        Cell::Byte(value) => bytes.push(value),
    }
}
