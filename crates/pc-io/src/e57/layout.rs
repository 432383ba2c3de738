//! What the numbers of an E57 scan mean (ASTM E2807, table 9).

use ::e57::{PointCloud, Record, RecordDataType, RecordName, RecordValue};

use crate::foreign::DAMAGED;
use crate::{Error, Place};

/// The extension that the writer puts scalars without a name of the standard into.
pub(super) const OWN: &str = "ig";
/// The extension for normals of surfaces.
pub(super) const NORMALS: &str = "nor";

/// What a number of each point is.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Role {
    /// x, y or z.
    Cartesian(usize),
    /// Range, azimuth or elevation, in metres and radians.
    Spherical(usize),
    /// 0 where the coordinates are measured.
    CartesianState,
    SphericalState,
    /// Red, green or blue, with the values that stand for black and full.
    Colour(usize, f64, f64),
    ColourState,
    Normal(usize),
    /// Anything else.
    Scalar(String),
    /// 1 where the scalar at this place of the scalars is none.
    ScalarState(&'static str),
}

/// The numbers of the points of a scan.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    pub(super) roles: Vec<Role>,
    pub(super) is_cartesian: bool,
    pub(super) has_colours: bool,
    pub(super) has_normals: bool,
}

/// The bits of a number of each point; 0 where all are the same.
fn bits(kind: &RecordDataType) -> u64 {
    match *kind {
        RecordDataType::Single { .. } => 32,
        RecordDataType::Double { .. } => 64,
        RecordDataType::ScaledInteger { min, max, .. } | RecordDataType::Integer { min, max } => {
            let range = i128::from(max) - i128::from(min);
            u64::from(i128::BITS - range.max(0).leading_zeros())
        }
    }
}

fn is_reversed(kind: &RecordDataType) -> bool {
    matches!(*kind, RecordDataType::ScaledInteger { min, max, .. } | RecordDataType::Integer { min, max } if min > max)
}

/// The values that stand for black and full of a channel: the limits of the scan, else those of the type.
fn limits(record: &Record, given: Option<(&Option<RecordValue>, &Option<RecordValue>)>) -> (f64, f64) {
    let number = |value: &RecordValue| value.to_f64(&record.data_type).ok();
    if let Some((Some(low), Some(high))) = given
        && let (Some(low), Some(high)) = (number(low), number(high))
        && low < high
    {
        return (low, high);
    }
    let found = match record.data_type {
        RecordDataType::Integer { min, max } => (min as f64, max as f64),
        RecordDataType::ScaledInteger { min, max, scale, offset } => {
            (min as f64 * scale + offset, max as f64 * scale + offset)
        }
        RecordDataType::Single { min, max } => (f64::from(min.unwrap_or(0.0)), f64::from(max.unwrap_or(1.0))),
        RecordDataType::Double { min, max } => (min.unwrap_or(0.0), max.unwrap_or(1.0)),
    };
    if found.0 < found.1 { found } else { (0.0, 255.0) }
}

impl Layout {
    /// Checks that the points of a scan can be read and that the file is large enough for them.
    pub(super) fn of(scan: &PointCloud, length: u64) -> Result<Self, Error> {
        let refuse = |what: String| Err(Error::malformed(Place::Whole, what, DAMAGED));
        if let Some(record) = scan.prototype.iter().find(|record| is_reversed(&record.data_type)) {
            return refuse(format!("the smallest {:?} is above the largest", record.name));
        }
        let bits: u64 = scan.prototype.iter().map(|record| bits(&record.data_type)).sum();
        // How many points there are cannot be seen from numbers that take no bits.
        if bits == 0 && scan.records > 0 {
            return refuse("all numbers of a scan are constant".to_owned());
        }
        let needed = scan.records.saturating_mul(bits) / 8;
        if needed > length {
            return Err(Error::Truncated {
                location: crate::Location { file: None, place: Place::Whole },
                what: "points".to_owned(),
                promised: scan.records,
                needed,
                left: length,
            });
        }
        let roles: Vec<Role> = scan.prototype.iter().map(|record| role(record, scan)).collect();
        let has = |role: Role| roles.contains(&role);
        let is_cartesian = (0..3).all(|axis| has(Role::Cartesian(axis)));
        if !is_cartesian && !(0..3).all(|axis| has(Role::Spherical(axis))) && scan.records > 0 {
            return refuse("a scan has neither cartesian nor spherical coordinates".to_owned());
        }
        let channels = roles.iter().filter(|role| matches!(role, Role::Colour(..))).count();
        let has_normals = (0..3).all(|axis| has(Role::Normal(axis)));
        Ok(Self { is_cartesian, has_colours: channels == 3, has_normals, roles })
    }
}

fn role(record: &Record, scan: &PointCloud) -> Role {
    let colour = scan.color_limits.as_ref();
    let scalar = |name: &str| Role::Scalar(name.to_owned());
    let channel = |place: usize, given| {
        let (low, high) = limits(record, given);
        Role::Colour(place, low, high)
    };
    match &record.name {
        RecordName::CartesianX => Role::Cartesian(0),
        RecordName::CartesianY => Role::Cartesian(1),
        RecordName::CartesianZ => Role::Cartesian(2),
        RecordName::CartesianInvalidState => Role::CartesianState,
        RecordName::SphericalRange => Role::Spherical(0),
        RecordName::SphericalAzimuth => Role::Spherical(1),
        RecordName::SphericalElevation => Role::Spherical(2),
        RecordName::SphericalInvalidState => Role::SphericalState,
        RecordName::ColorRed => channel(0, colour.map(|limits| (&limits.red_min, &limits.red_max))),
        RecordName::ColorGreen => channel(1, colour.map(|limits| (&limits.green_min, &limits.green_max))),
        RecordName::ColorBlue => channel(2, colour.map(|limits| (&limits.blue_min, &limits.blue_max))),
        RecordName::IsColorInvalid => Role::ColourState,
        RecordName::Intensity => scalar(INTENSITY),
        RecordName::IsIntensityInvalid => Role::ScalarState(INTENSITY),
        RecordName::RowIndex => scalar("row_index"),
        RecordName::ColumnIndex => scalar("column_index"),
        RecordName::ReturnCount => scalar("number_of_returns"),
        RecordName::ReturnIndex => scalar("return_number"),
        RecordName::TimeStamp => scalar(TIME),
        RecordName::IsTimeStampInvalid => Role::ScalarState(TIME),
        RecordName::Unknown { namespace, name } => match (namespace.as_str(), name.as_str()) {
            (NORMALS, "normalX") => Role::Normal(0),
            (NORMALS, "normalY") => Role::Normal(1),
            (NORMALS, "normalZ") => Role::Normal(2),
            (OWN, name) => scalar(name),
            (namespace, name) => Role::Scalar(format!("{namespace}_{name}")),
        },
    }
}

pub(super) const INTENSITY: &str = "intensity";
pub(super) const TIME: &str = "time_stamp";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_the_bits_of_integers() {
        let integer = |min, max| bits(&RecordDataType::Integer { min, max });
        assert_eq!([integer(0, 0), integer(0, 1), integer(0, 255), integer(-1, 255)], [0, 1, 8, 9]);
        assert_eq!(integer(i64::MIN, i64::MAX), 64);
    }
}
