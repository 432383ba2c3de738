//! Binary PLY of points alone, whose rows have all the same size and can be read piece by piece.

use nalgebra::{Point3, Vector3};

use super::header::{self, Encoding};
use crate::columns::{Kind, point_columns};
use crate::number_type::{NumberType, Strided};
use crate::piece::Piece;
use crate::source::Source;

/// Bytes of a file among which its header must be.
pub(crate) const HEAD: u64 = 1 << 16;

/// The rows of the points of a file.
pub(crate) struct PointRows {
    /// Where they begin, and how many there are.
    pub(crate) start: u64,
    pub(crate) count: u64,
    /// Bytes of a row.
    pub(crate) stride: usize,
    /// Places in a row and types of x, y and z.
    positions: [(usize, NumberType); 3],
    normals: Option<[(usize, NumberType); 3]>,
    little_endian: bool,
    /// The header, in which the number of points is left out.
    header: [Vec<u8>; 2],
}

impl PointRows {
    /// A file of these rows alone.
    pub(crate) fn file_of(&self, rows: &[u8]) -> Vec<u8> {
        let count = (rows.len() / self.stride).to_string();
        let [before, after] = &self.header;
        [before, count.as_bytes(), after, rows].concat()
    }

    /// The rows of a file of `length` bytes that begins with `head`; `None` where it has to be read as a whole: text, lists,
    /// triangles, points in the plane, anything to be told about, and everything that is wrong.
    pub(crate) fn of(head: &[u8], length: u64) -> Option<Self> {
        let header = header::read(Source { data: head }).ok()?;
        let little_endian = match header.encoding {
            Encoding::Ascii => return None,
            Encoding::LittleEndian => true,
            Encoding::BigEndian => false,
        };
        let [element] = header.elements.as_slice() else { return None };
        if element.has_list() {
            return None;
        }
        let stride = element.min_row_size(header.encoding);
        let start = header.end as u64;
        let end = start.checked_add(element.count.checked_mul(stride as u64)?)?;
        // The end of a line may follow; what it is made of is looked at in memory.
        if stride == 0 || end != length {
            return None;
        }
        let kinds = element.properties.iter().map(|property| property.value.kind());
        let named = element.properties.iter().map(|property| property.name.as_str()).zip(kinds);
        let wide = |number: NumberType| matches!(number, NumberType::I64 | NumberType::U64);
        if element.properties.iter().any(|property| wide(property.value)) {
            return None;
        }
        let (positions, normals) = point_columns(&named.collect::<Vec<(&str, Kind)>>())?;
        let header = split_at_count(head.get(..header.end)?)?;
        let place = |column: usize| {
            let before = element.properties[..column].iter().map(|property| property.value.size()).sum();
            (before, element.properties[column].value)
        };
        Some(Self {
            start,
            count: element.count,
            stride,
            positions: positions.map(place),
            normals: normals.map(|normals| normals.map(place)),
            little_endian,
            header,
        })
    }

    /// The points of whole rows.
    pub(crate) fn piece(&self, rows: &[u8]) -> Piece {
        let triples = |places: [(usize, NumberType); 3]| {
            let [x, y, z] = places.map(|(offset, number)| {
                let mut values = Vec::with_capacity(rows.len() / self.stride);
                let (stride, little_endian) = (self.stride, self.little_endian);
                Strided { rows, stride, offset, number, little_endian }.append_to(&mut values);
                values
            });
            x.into_iter().zip(y).zip(z).map(|((x, y), z)| [x, y, z])
        };
        Piece {
            positions: triples(self.positions).map(Point3::from).collect(),
            normals: self.normals.map(|normals| triples(normals).map(Vector3::from).collect()),
        }
    }
}

/// A header in two parts, with the number of points between them.
fn split_at_count(header: &[u8]) -> Option<[Vec<u8>; 2]> {
    let lines = Source { data: header }.lines_from(0);
    let (at, line) = lines.into_iter().find(|(_, line)| {
        let mut words = crate::source::words(line);
        words.next() == Some(b"element") && words.next() == Some(b"vertex")
    })?;
    let end = line.trim_ascii_end().len();
    let digits = line[..end].iter().rev().take_while(|byte| byte.is_ascii_digit()).count();
    let (start, end) = (at + end - digits, at + end);
    (digits > 0).then(|| [header[..start].to_vec(), header[end..].to_vec()])
}
