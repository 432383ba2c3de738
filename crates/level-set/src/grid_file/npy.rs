//! NPY, versions 1 to 3.

use super::GridFile;
use crate::Error;
use crate::error::check_size;

const NAME: &str = "NPY";

pub(super) fn is_npy(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x93NUMPY")
}

pub(super) fn read(bytes: &[u8]) -> Result<GridFile, Error> {
    let ended = || Error::malformed(NAME, bytes.len(), "the file ends within its header");
    let version = *bytes.get(6).ok_or_else(ended)?;
    let (first, length) = match version {
        1 => (10, bytes.get(8..10).ok_or_else(ended)?),
        2 | 3 => (12, bytes.get(8..12).ok_or_else(ended)?),
        _ => return Err(Error::malformed(NAME, 6, format!("version {version} is not known"))),
    };
    let length = length.iter().rev().fold(0usize, |length, &byte| length << 8 | usize::from(byte));
    let header = bytes.get(first..).and_then(|rest| rest.get(..length)).ok_or_else(ended)?;
    let header = String::from_utf8_lossy(header);
    let after = |key: &str| {
        let at = header.find(&format!("'{key}'"))?;
        Some(header[at..].split_once(':')?.1.trim_start())
    };
    let missing = |key: &str| Error::malformed(NAME, first, format!("the header has no `{key}`"));
    let kind = after("descr").and_then(|text| text.strip_prefix('\'')?.split('\'').next());
    let kind = kind.ok_or_else(|| missing("descr"))?;
    let is_fortran = after("fortran_order").ok_or_else(|| missing("fortran_order"))?.starts_with("True");
    let shape = after("shape").and_then(|text| text.strip_prefix('(')?.split(')').next());
    let shape = shape.ok_or_else(|| missing("shape"))?;
    let counts: Option<Vec<u64>> = shape
        .split(',')
        .map(str::trim)
        .filter(|part| !part.is_empty())
        .map(|part| part.parse().ok())
        .collect();
    let counts = counts.filter(|counts| (2..=3).contains(&counts.len()) && !counts.contains(&0));
    let counts = counts.ok_or_else(|| {
        Error::malformed(
            NAME,
            first,
            format!("the shape is ({shape}): two or three axes are needed, none of them empty"),
        )
    })?;
    let nodes =
        check_size(&counts, || format!("{} values", shape.trim_end_matches(',').replace(", ", " x ")))?;
    let number = number_of(kind).ok_or_else(|| {
        Error::malformed(NAME, first, format!("numbers of the type `{kind}` are not read; save as float64"))
    })?;
    let body = &bytes[first + length..];
    let needed = nodes.saturating_mul(number.size);
    if body.len() < needed {
        let what = format!("the file ends: {needed} bytes of values are needed, {} are there", body.len());
        return Err(Error::malformed(NAME, bytes.len(), what));
    }
    let values: Vec<f64> =
        body.chunks_exact(number.size).take(nodes).map(|part| number.value(part)).collect();
    let counts: Vec<usize> =
        counts.iter().map(|&count| usize::try_from(count).unwrap_or(usize::MAX)).collect();
    let values = if is_fortran { first_axis_fastest(&counts, &values) } else { values };
    Ok(GridFile { counts, place: None, values })
}

/// Values with the first axis running fastest in the order of a grid.
pub(super) fn first_axis_fastest(counts: &[usize], values: &[f64]) -> Vec<f64> {
    (0..values.len())
        .map(|node| {
            let (mut rest, mut place, mut stride) = (node, 0, values.len());
            for &count in counts.iter().rev() {
                stride /= count;
                place += rest % count * stride;
                rest /= count;
            }
            values[place]
        })
        .collect()
}

/// How a number is stored.
struct Number {
    size: usize,
    is_big_endian: bool,
    kind: u8,
}

fn number_of(descr: &str) -> Option<Number> {
    let [order, kind, size] = *descr.as_bytes() else { return None };
    let size = usize::from(size.checked_sub(b'0')?);
    let is_known = matches!((kind, size), (b'f', 4 | 8) | (b'i' | b'u', 1 | 2 | 4 | 8) | (b'b', 1));
    (is_known && matches!(order, b'<' | b'>' | b'|' | b'=')).then_some(Number {
        size,
        is_big_endian: order == b'>',
        kind,
    })
}

impl Number {
    fn value(&self, part: &[u8]) -> f64 {
        let join = |bits: u64, byte: &u8| bits << 8 | u64::from(*byte);
        let bits =
            if self.is_big_endian { part.iter().fold(0, join) } else { part.iter().rev().fold(0, join) };
        match (self.kind, self.size) {
            (b'f', 8) => f64::from_bits(bits),
            (b'f', _) => f64::from(f32::from_bits(u32::try_from(bits).unwrap_or(0))),
            (b'i', size) => {
                let unused = 64 - 8 * size;
                ((bits << unused).cast_signed() >> unused) as f64
            }
            _ => bits as f64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(header: &str, body: &[u8]) -> Vec<u8> {
        let length = u16::try_from(header.len()).unwrap();
        [b"\x93NUMPY\x01\x00", &length.to_le_bytes()[..], header.as_bytes(), body].concat()
    }

    #[test]
    fn numbers_and_orders_are_read() {
        let doubles: Vec<u8> = (0..6).flat_map(|k| f64::from(k).to_le_bytes()).collect();
        let c = file("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }\n", &doubles);
        assert_eq!(read(&c).unwrap().values, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        let f = file("{'descr': '<f8', 'fortran_order': True, 'shape': (2, 3), }\n", &doubles);
        assert_eq!(read(&f).unwrap().values, [0.0, 2.0, 4.0, 1.0, 3.0, 5.0]);
        let shorts: Vec<u8> = [-2i16, 300].iter().flat_map(|k| k.to_be_bytes()).collect();
        let big = file("{'descr': '>i2', 'fortran_order': False, 'shape': (1, 1, 2), }", &shorts);
        assert_eq!(read(&big).unwrap().values, [-2.0, 300.0]);
        let longs: Vec<u8> = [-5i64, 1 << 40].iter().flat_map(|k| k.to_le_bytes()).collect();
        let whole = file("{'descr': '<i8', 'fortran_order': False, 'shape': (2, 1), }", &longs);
        assert_eq!(read(&whole).unwrap().values, [-5.0, f64::from(1u32 << 20) * f64::from(1u32 << 20)]);
        let mask = file("{'descr': '|b1', 'fortran_order': False, 'shape': (1, 2), }", &[0, 1]);
        assert_eq!(read(&mask).unwrap().values, [0.0, 1.0]);
    }

    #[test]
    fn broken_files_are_refused() {
        let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }";
        let whole = file(header, &[0; 48]);
        for length in 6..whole.len() {
            assert!(matches!(read(&whole[..length]), Err(Error::Malformed { .. })), "{length}");
        }
        for (header, what) in [
            ("{'descr': '<f8', 'fortran_order': False, 'shape': (6,), }", "two or three axes"),
            ("{'descr': '<c8', 'fortran_order': False, 'shape': (2, 3), }", "type `<c8`"),
            ("{'descr': '<f8', 'fortran_order': False, 'shape': (99999, 99999, 99999), }", "bytes"),
            ("{'fortran_order': False, 'shape': (2, 3), }", "no `descr`"),
        ] {
            let error = read(&file(header, &[0; 48])).unwrap_err().to_string();
            assert!(error.contains(what), "{error}");
        }
    }
}
