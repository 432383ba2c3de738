//! The extra bytes of LAS records, as their descriptions tell (LAS 1.4 R15, table 24).

use crate::number_type::NumberType;
use crate::source::decode_name;

/// Bytes of one description.
pub(super) const DESCRIPTION: usize = 192;
/// The user and number of the record that holds the descriptions.
pub(super) const USER: &str = "LASF_Spec";
pub(super) const RECORD: u16 = 4;
/// Number of the type of doubles.
pub(super) const DOUBLE: u8 = 10;
/// Bytes without a description that are kept one by one; more are some program's own business.
const MOST_UNDESCRIBED: usize = 64;

const TYPES: [NumberType; 10] = [
    NumberType::U8,
    NumberType::I8,
    NumberType::U16,
    NumberType::I16,
    NumberType::U32,
    NumberType::I32,
    NumberType::U64,
    NumberType::I64,
    NumberType::F32,
    NumberType::F64,
];

/// A number among the extra bytes of each record.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Extra {
    pub(super) name: String,
    /// Where it begins, from the first extra byte on.
    pub(super) at: usize,
    pub(super) number: NumberType,
    /// Factor and summand, where the description has them.
    pub(super) scaling: Option<(f64, f64)>,
    /// The number that stands for none.
    pub(super) no_data: Option<f64>,
}

/// Whether an options byte says that a part of the description counts.
const fn has(options: u8, bit: u8) -> bool {
    options & (1 << bit) != 0
}

/// The numbers that descriptions tell of in `available` extra bytes; what does not fit is told.
pub(super) fn describe(data: &[u8], available: usize, warnings: &mut Vec<String>) -> Vec<Extra> {
    let mut extras: Vec<Extra> = Vec::new();
    let mut at = 0;
    for text in data.chunks_exact(DESCRIPTION) {
        let (kind, options) = (usize::from(text[2]), text[3]);
        let name = text[4..36].split(|&byte| byte == 0).next().unwrap_or_default();
        let name = decode_name(name.trim_ascii()).into_owned();
        let name = if name.is_empty() { format!("extra_bytes_{at}") } else { name };
        // Types 11 to 30 are pairs and triples, which only older files have.
        let (size, count) = match kind {
            0 => (usize::from(options), 0),
            1..=30 => (TYPES[(kind - 1) % 10].size(), 1 + (kind - 1) / 10),
            _ => {
                warnings.push(format!(
                    "extra bytes of the unknown type {kind} ({name:?}) and those behind them are not read"
                ));
                return extras;
            }
        };
        let width = size * count.max(1);
        if at + width > available {
            warnings
                .push(format!("the extra bytes {name:?} lie behind the end of the records and are not read"));
            return extras;
        }
        for place in 0..count {
            let number = TYPES[(kind - 1) % 10];
            let double =
                |from: usize| NumberType::F64.decode::<true>(&text[from + 8 * place..from + 8 * place + 8]);
            let raw = match number {
                NumberType::F32 | NumberType::F64 => NumberType::F64,
                NumberType::I8 | NumberType::I16 | NumberType::I32 | NumberType::I64 => NumberType::I64,
                _ => NumberType::U64,
            };
            let no_data = raw.decode::<true>(&text[40 + 8 * place..48 + 8 * place]);
            let scale = if has(options, 3) { double(112) } else { 1.0 };
            let offset = if has(options, 4) { double(136) } else { 0.0 };
            let is_scaled = kind != 0 && (has(options, 3) || has(options, 4));
            extras.push(Extra {
                name: if count > 1 { format!("{name}_{place}") } else { name.clone() },
                at: at + place * size,
                number,
                scaling: is_scaled.then_some((scale, offset)),
                no_data: has(options, 0).then_some(no_data),
            });
        }
        if kind == 0 && width > 0 {
            warnings.push(format!("not read: {width} extra bytes {name:?} without a type"));
        }
        at += width;
    }
    let left = available - at;
    if left > MOST_UNDESCRIBED {
        warnings.push(format!("not read: {left} extra bytes without a description"));
    } else {
        extras.extend((at..available).map(|at| Extra {
            name: format!("extra_bytes_{at}"),
            at,
            number: NumberType::U8,
            scaling: None,
            no_data: None,
        }));
    }
    extras
}

/// The description of a double.
pub(super) fn description(name: &str) -> [u8; DESCRIPTION] {
    let mut text = [0; DESCRIPTION];
    text[2] = DOUBLE;
    for (to, from) in text[4..36].iter_mut().zip(name.bytes()) {
        *to = from;
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn describes_scaled_numbers_and_what_is_left() {
        let mut scaled = description("height");
        scaled[2] = 4;
        scaled[3] = 0b11001;
        scaled[40..48].copy_from_slice(&(-32768i64).to_le_bytes());
        scaled[112..120].copy_from_slice(&0.01f64.to_le_bytes());
        scaled[136..144].copy_from_slice(&250.0f64.to_le_bytes());
        let mut warnings = Vec::new();
        let found = describe(&[scaled, description("q")].concat(), 11, &mut warnings);
        assert_eq!(found.len(), 3);
        assert_eq!(
            (found[0].at, found[0].scaling, found[0].no_data),
            (0, Some((0.01, 250.0)), Some(-32768.0))
        );
        assert_eq!((found[1].name.as_str(), found[1].at, found[1].number), ("q", 2, NumberType::F64));
        assert_eq!((found[2].name.as_str(), found[2].at), ("extra_bytes_10", 10));
        assert!(warnings.is_empty());
        assert!(describe(&description("q"), 7, &mut warnings).is_empty());
        assert!(warnings[0].contains("behind the end"), "{warnings:?}");
    }
}
