//! Numbers as bytes.

use crate::columns::Kind;

/// The type of a number in a binary file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NumberType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl NumberType {
    /// Size in bytes.
    pub(crate) const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// How a column of such numbers can be a colour.
    pub(crate) const fn kind(self) -> Kind {
        match self {
            Self::U8 => Kind::Byte,
            Self::F32 | Self::F64 => Kind::Float,
            _ => Kind::Integer,
        }
    }

    /// The number in `bytes`, which has the size of the type.
    #[inline(always)]
    pub(crate) fn decode<const LITTLE: bool>(self, bytes: &[u8]) -> f64 {
        macro_rules! number {
            ($kind:ty) => {{
                let mut array = [0; size_of::<$kind>()];
                array.copy_from_slice(bytes);
                if LITTLE { <$kind>::from_le_bytes(array) } else { <$kind>::from_be_bytes(array) }
            }};
        }
        match self {
            Self::I8 => f64::from(number!(i8)),
            Self::U8 => f64::from(number!(u8)),
            Self::I16 => f64::from(number!(i16)),
            Self::U16 => f64::from(number!(u16)),
            Self::I32 => f64::from(number!(i32)),
            Self::U32 => f64::from(number!(u32)),
            Self::I64 => number!(i64) as f64,
            Self::U64 => number!(u64) as f64,
            Self::F32 => f64::from(number!(f32)),
            Self::F64 => number!(f64),
        }
    }
}

/// The same number in every row of a table of bytes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Strided<'a> {
    /// Whole rows.
    pub(crate) rows: &'a [u8],
    /// Bytes per row.
    pub(crate) stride: usize,
    /// Where in the row the number begins.
    pub(crate) offset: usize,
    pub(crate) number: NumberType,
    pub(crate) little_endian: bool,
}

impl Strided<'_> {
    /// Appends the numbers of all rows.
    pub(crate) fn append_to(self, values: &mut Vec<f64>) {
        // The type is a constant in each branch, so that the loops are tight.
        macro_rules! column {
            ($($case:ident),*) => {
                match (self.number, self.little_endian) {
                    $(
                        (NumberType::$case, true) => values.extend(self.decoded::<true>(NumberType::$case)),
                        (NumberType::$case, false) => values.extend(self.decoded::<false>(NumberType::$case)),
                    )*
                }
            };
        }
        column!(I8, U8, I16, U16, I32, U32, I64, U64, F32, F64);
    }

    #[inline(always)]
    fn decoded<const LITTLE: bool>(self, number: NumberType) -> impl Iterator<Item = f64> {
        let cell = self.offset..self.offset + number.size();
        self.rows.chunks_exact(self.stride).map(move |row| number.decode::<LITTLE>(&row[cell.clone()]))
    }
}

/// Tells of integers that a double cannot hold.
pub(crate) fn warn_of_wide(name: &str, kind: Kind, values: &[f64], warnings: &mut Vec<String>) {
    const EXACT: f64 = 9_007_199_254_740_992.0;
    if kind == Kind::Integer && values.iter().any(|value| value.abs() >= EXACT) {
        warnings.push(format!("integers of {name:?} above 2^53 lost their last digits"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decodes_both_byte_orders() {
        let rows = [[0, 1, 2], [0, 255, 254]].concat();
        for (little_endian, expected) in [(true, [513.0, -257.0]), (false, [258.0, -2.0])] {
            let mut values = Vec::new();
            let column =
                Strided { rows: &rows, stride: 3, offset: 1, number: NumberType::I16, little_endian };
            column.append_to(&mut values);
            assert_eq!(values, expected);
        }
    }
}
