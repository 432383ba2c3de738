//! The compression of PCD files: LZF.

use crate::{Error, Place};

/// A back reference of three bytes stands for 264 bytes at most.
const LARGEST_RATIO: usize = 88;

/// Unpacks `packed`, which stands at `offset` in the file, to exactly `size` bytes.
///
/// A control byte below 32 announces that many literal bytes and one more. Otherwise its upper three bits are the
/// length of a back reference less two (7: another byte is added), its lower five the high bits of the distance less one.
pub(super) fn unpack(packed: &[u8], size: usize, offset: usize) -> Result<Vec<u8>, Error> {
    let damaged = |at: usize, what: String| {
        Error::malformed(
            Place::Byte(offset + at),
            what,
            "the compressed data are damaged, export the file again",
        )
    };
    if size > packed.len().saturating_mul(LARGEST_RATIO) {
        return Err(damaged(
            0,
            format!("{} packed bytes cannot hold the {size} bytes promised", packed.len()),
        ));
    }
    let mut out = Vec::with_capacity(size);
    let mut at = 0;
    let ends = |at: usize| damaged(at, "the compressed data end too early".to_owned());
    while let Some(&control) = packed.get(at) {
        let start = at;
        at += 1;
        if control < 32 {
            let length = usize::from(control) + 1;
            let literal = packed.get(at..at + length).ok_or_else(|| ends(start))?;
            out.extend_from_slice(literal);
            at += length;
        } else {
            let mut length = usize::from(control >> 5) + 2;
            if length == 9 {
                length += usize::from(*packed.get(at).ok_or_else(|| ends(start))?);
                at += 1;
            }
            let low = *packed.get(at).ok_or_else(|| ends(start))?;
            at += 1;
            let distance = (usize::from(control & 31) << 8 | usize::from(low)) + 1;
            let from = out.len().checked_sub(distance).ok_or_else(|| {
                damaged(
                    start,
                    format!("a back reference of {distance} bytes reaches beyond the {} unpacked", out.len()),
                )
            })?;
            // The reference may overlap what it produces.
            for place in from..from + length {
                out.push(out[place]);
            }
        }
        if out.len() > size {
            return Err(damaged(start, format!("the data unpack to more than the {size} bytes promised")));
        }
    }
    if out.len() < size {
        return Err(damaged(
            packed.len(),
            format!("the data unpack to {} bytes where {size} are promised", out.len()),
        ));
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unpacks_literals_and_references() {
        // "abc", then 3 bytes from 3 back, then 9 + 4 bytes from 1 back.
        let packed = [2, b'a', b'b', b'c', 0x20, 2, 0xe0, 4, 0];
        assert_eq!(unpack(&packed, 19, 0).unwrap(), b"abcabcccccccccccccc");
    }

    #[test]
    fn refuses_damage() {
        for (packed, size) in [
            (&[2u8, b'a'][..], 3),    // ends within a literal
            (&[0, b'a', 0x20], 4),    // ends within a reference
            (&[0, b'a', 0x20, 5], 4), // reaches before the beginning
            (&[0, b'a'], 2),          // too short
            (&[1, b'a', b'b'], 1),    // too long
            (&[0, b'a'], 1_000_000_000_000),
        ] {
            assert!(unpack(packed, size, 0).is_err(), "{packed:?}");
        }
    }
}
