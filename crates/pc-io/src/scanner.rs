//! The binary formats of scanners, whose decoders are other crates and optional: LAS, LAZ and E57.

use std::io::{self, Write};

use crate::shape::Shape;
use crate::{Error, Format, Place};
#[cfg(any(feature = "las", feature = "e57"))]
use crate::{ReadOptions, foreign::Input, parsed::Parsed, piece::Taker};

/// Bytes that tell these formats from others.
#[cfg(any(feature = "las", feature = "e57"))]
pub(crate) const MAGIC: usize = 8;

/// The format that the first bytes of a file tell, among those that are built in.
pub(crate) fn by_magic(head: &[u8]) -> Option<Format> {
    let format = if head.starts_with(b"LASF") {
        Format::Las
    } else if head.starts_with(b"ASTM-E57") {
        Format::E57
    } else {
        return None;
    };
    is_built(format).then_some(format)
}

/// Whether the decoder of a format is built in.
pub(crate) const fn is_built(format: Format) -> bool {
    (matches!(format, Format::Las | Format::Laz) && cfg!(feature = "las"))
        || (matches!(format, Format::E57) && cfg!(feature = "e57"))
}

/// Says that a decoder is not built in.
pub(crate) fn not_built(format: Format) -> Error {
    let feature = if format == Format::E57 { "e57" } else { "las" };
    let what = format!("this program was built without {format}");
    let advice = format!("build it with the feature `{feature}`, or convert the file to PLY or XYZ first");
    Error::unsupported(Place::Whole, what, advice)
}

/// Reads a file of one of these formats.
#[cfg(any(feature = "las", feature = "e57"))]
pub(crate) fn read(format: Format, input: Input, options: &ReadOptions) -> Result<Parsed, Error> {
    let _ = options;
    match format {
        #[cfg(feature = "las")]
        Format::Las | Format::Laz => crate::las::read(input),
        #[cfg(feature = "e57")]
        Format::E57 => crate::e57::read(input, options),
        _ => Err(not_built(format)),
    }
}

/// Reads a file of one of these formats piece by piece; what is left for the report.
#[cfg(any(feature = "las", feature = "e57"))]
pub(crate) fn read_pieces<E>(
    format: Format,
    input: Input,
    options: &ReadOptions,
    limit: usize,
    taker: &mut Taker<'_, E>,
) -> Result<Parsed, Error> {
    let _ = options;
    match format {
        #[cfg(feature = "las")]
        Format::Las | Format::Laz => crate::las::read_pieces(input, limit, taker),
        #[cfg(feature = "e57")]
        Format::E57 => crate::e57::read_pieces(input, options, limit, taker),
        _ => Err(not_built(format)),
    }
}

/// Writes one of these formats, which must be built in.
pub(crate) fn write(
    out: &mut dyn Write,
    format: Format,
    shape: Shape<'_>,
    warnings: &mut Vec<String>,
) -> io::Result<()> {
    match format {
        #[cfg(feature = "las")]
        Format::Las | Format::Laz => crate::las::write(out, shape, format == Format::Laz, warnings),
        #[cfg(feature = "e57")]
        Format::E57 => crate::e57::write(out, shape, warnings),
        _ => {
            let _ = (out, shape, warnings);
            Err(io::Error::other(not_built(format)))
        }
    }
}
