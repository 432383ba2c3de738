//! The numbers of LAS records besides the coordinates (LAS 1.4 R15, tables 6 to 20).

use super::extra::Extra;
use crate::number_type::NumberType;

/// Degrees per unit of the scan angle of formats 6 to 10.
pub(super) const ANGLE: f64 = 0.006;

/// A number of each record, and its values so far.
#[derive(Debug)]
pub(super) struct Field {
    pub(super) name: String,
    at: usize,
    number: NumberType,
    /// Shift and mask of a number that is a few bits of a byte.
    bits: Option<(u8, u8)>,
    scaling: Option<(f64, f64)>,
    no_data: Option<f64>,
    /// Zeros before the first value that is another number: most files leave most fields empty.
    zeros: usize,
    values: Vec<f64>,
}

impl Field {
    fn new(name: &str, at: usize, number: NumberType) -> Self {
        let name = name.to_owned();
        Self { name, at, number, bits: None, scaling: None, no_data: None, zeros: 0, values: Vec::new() }
    }

    fn bits(name: &str, at: usize, shift: u8, mask: u8) -> Self {
        Self { bits: Some((shift, mask)), ..Self::new(name, at, NumberType::U8) }
    }

    pub(super) fn of_record(&self, record: &[u8]) -> f64 {
        let bytes = &record[self.at..self.at + self.number.size()];
        if let (Some((shift, mask)), [byte]) = (self.bits, bytes) {
            return f64::from((byte >> shift) & mask);
        }
        let value = self.number.decode::<true>(bytes);
        if self.no_data == Some(value) {
            return f64::NAN;
        }
        self.scaling.map_or(value, |(scale, offset)| value * scale + offset)
    }

    /// Appends the number of a record.
    pub(super) fn push(&mut self, record: &[u8]) {
        let value = self.of_record(record);
        if self.values.is_empty() && value == 0.0 {
            self.zeros += 1;
            return;
        }
        if self.values.is_empty() {
            self.values.resize(self.zeros, 0.0);
        }
        self.values.push(value);
    }

    /// Whether its numbers are integers that doubles may not hold.
    pub(super) const fn is_wide(&self) -> bool {
        matches!(self.number, NumberType::I64 | NumberType::U64)
    }

    /// The values, unless all are 0.
    pub(super) fn into_values(self) -> Option<Vec<f64>> {
        (!self.values.is_empty()).then_some(self.values)
    }
}

/// What the records of a point format hold.
#[derive(Debug, Clone, Copy)]
pub(super) struct Format {
    pub(super) format: ::las::point::Format,
    /// Bytes of a record.
    pub(super) length: usize,
}

impl Format {
    /// Where the three channels of the colour begin.
    pub(super) const fn colour(self) -> Option<usize> {
        match (self.format.has_color, self.format.is_extended, self.format.has_gps_time) {
            (false, ..) => None,
            (true, true, _) => Some(30),
            (true, false, true) => Some(28),
            (true, false, false) => Some(20),
        }
    }

    /// Where the extra bytes begin.
    pub(super) fn extra(self) -> usize {
        self.length.saturating_sub(usize::from(self.format.extra_bytes))
    }

    /// All fields but coordinates, colours and waveforms.
    pub(super) fn fields(self, extras: Vec<Extra>) -> Vec<Field> {
        use NumberType::{F64, I8, I16, U8, U16};
        let mut fields = vec![Field::new("intensity", 12, U16)];
        if self.format.is_extended {
            fields.extend([
                Field::bits("return_number", 14, 0, 15),
                Field::bits("number_of_returns", 14, 4, 15),
                Field::bits("synthetic", 15, 0, 1),
                Field::bits("key_point", 15, 1, 1),
                Field::bits("withheld", 15, 2, 1),
                Field::bits("overlap", 15, 3, 1),
                Field::bits("scanner_channel", 15, 4, 3),
                Field::bits("scan_direction_flag", 15, 6, 1),
                Field::bits("edge_of_flight_line", 15, 7, 1),
                Field::new("classification", 16, U8),
                Field::new("user_data", 17, U8),
                Field { scaling: Some((ANGLE, 0.0)), ..Field::new("scan_angle", 18, I16) },
                Field::new("point_source_id", 20, U16),
                Field::new("gps_time", 22, F64),
            ]);
            if self.format.has_nir {
                fields.push(Field::new("nir", 36, U16));
            }
        } else {
            fields.extend([
                Field::bits("return_number", 14, 0, 7),
                Field::bits("number_of_returns", 14, 3, 7),
                Field::bits("scan_direction_flag", 14, 6, 1),
                Field::bits("edge_of_flight_line", 14, 7, 1),
                Field::bits("classification", 15, 0, 31),
                Field::bits("synthetic", 15, 5, 1),
                Field::bits("key_point", 15, 6, 1),
                Field::bits("withheld", 15, 7, 1),
                Field::new("scan_angle", 16, I8),
                Field::new("user_data", 17, U8),
                Field::new("point_source_id", 18, U16),
            ]);
            if self.format.has_gps_time {
                fields.push(Field::new("gps_time", 20, F64));
            }
        }
        let start = self.extra();
        fields.extend(extras.into_iter().map(|extra| Field {
            scaling: extra.scaling,
            no_data: extra.no_data,
            ..Field::new(&extra.name, start + extra.at, extra.number)
        }));
        fields
    }
}
