//! The points of E57 scans as columns.

use ::e57::{PointCloud as Description, RecordValue};
use mesh_core::{Attributes, Colours, PointCloud};
use nalgebra::{Point3, Vector3};

use super::Pose;
use super::layout::{Layout, Role};
use crate::Error;
use crate::columns::{ROUNDED_COLOURS, free_name, to_byte};
use crate::piece::Piece;
use crate::scans::Scan;
use crate::wording::counted;

/// Columns of the points read so far.
#[derive(Debug, Default)]
pub(super) struct Points {
    positions: Vec<Point3<f64>>,
    /// Normals and colours of the points from the first that has them on; those before have none.
    normals: Vec<Vector3<f64>>,
    colours: Vec<[u8; 3]>,
    /// NaN where a scan does not have the scalar.
    scalars: Vec<(String, Vec<f64>)>,
    /// Points that the scanner marks as not measured, which are left out.
    invalid: usize,
    /// Colours that are marked as none, which are black.
    colourless: usize,
    /// Whether colours were rounded to 8 bits.
    rounded: bool,
    /// The place of the scalar of each role, in the points of one scan.
    places: Vec<Option<usize>>,
}

/// Normal of a point of a scan without normals.
const NO_NORMAL: [f64; 3] = [f64::NAN; 3];

impl Points {
    pub(super) fn new(layout: &Layout) -> Self {
        let mut points = Self::default();
        for role in &layout.roles {
            let place = match role {
                Role::Scalar(name) => {
                    points.scalars.push((name.clone(), Vec::new()));
                    Some(points.scalars.len() - 1)
                }
                _ => None,
            };
            points.places.push(place);
        }
        points
    }

    pub(super) const fn len(&self) -> usize {
        self.positions.len()
    }

    /// Appends a point, moved by the pose, unless it is marked as not measured.
    pub(super) fn push(
        &mut self,
        values: &[RecordValue],
        scan: &Description,
        layout: &Layout,
        pose: Option<&Pose>,
    ) -> Result<(), Error> {
        let mut cartesian = [0.0; 3];
        let mut spherical = [0.0; 3];
        let mut states = [0.0; 2];
        let mut colour = [0u8; 3];
        let mut is_coloured = true;
        let mut normal = Vector3::from(NO_NORMAL);
        let number = |place: usize| {
            let value = values.get(place).zip(scan.prototype.get(place));
            value.map_or(Ok(f64::NAN), |(value, record)| {
                value.to_f64(&record.data_type).map_err(|error| super::refused(&error))
            })
        };
        for (place, role) in layout.roles.iter().enumerate() {
            let value = number(place)?;
            match role {
                Role::Cartesian(axis) => cartesian[*axis] = value,
                Role::Spherical(axis) => spherical[*axis] = value,
                Role::CartesianState if layout.is_cartesian => states[0] = value,
                Role::SphericalState if !layout.is_cartesian => states[1] = value,
                Role::Normal(axis) => normal[*axis] = value,
                Role::ColourState => is_coloured = value == 0.0,
                Role::Colour(channel, low, high) => {
                    let scaled = (value - low) / (high - low) * 255.0;
                    self.rounded |= (scaled - scaled.round()).abs() > 1e-3;
                    colour[*channel] = to_byte(scaled.round());
                }
                _ => {}
            }
        }
        if states != [0.0; 2] {
            self.invalid += 1;
            return Ok(());
        }
        if !layout.is_cartesian {
            let [range, azimuth, elevation] = spherical;
            let flat = range * elevation.cos();
            cartesian = [flat * azimuth.cos(), flat * azimuth.sin(), range * elevation.sin()];
        }
        let point = Vector3::from(cartesian);
        let moved = pose.map_or(point, |pose| pose.rotation * point + pose.translation);
        self.positions.push(Point3::from(moved));
        if layout.has_normals {
            self.normals.push(pose.map_or(normal, |pose| pose.rotation * normal));
        }
        if layout.has_colours {
            self.colourless += usize::from(!is_coloured);
            self.colours.push(if is_coloured { colour } else { [0; 3] });
        }
        for place in 0..layout.roles.len() {
            if let Some(scalar) = self.places[place] {
                self.scalars[scalar].1.push(number(place)?);
            }
        }
        for (place, role) in layout.roles.iter().enumerate() {
            if let Role::ScalarState(name) = role
                && number(place)? != 0.0
                && let Some((_, values)) = self.scalars.iter_mut().find(|(other, _)| other == name)
                && let Some(last) = values.last_mut()
            {
                *last = f64::NAN;
            }
        }
        Ok(())
    }

    /// Takes the points of `other` over, which is empty then.
    pub(super) fn append(&mut self, other: &mut Self) {
        let (before, count) = (self.positions.len(), other.positions.len());
        self.positions.append(&mut other.positions);
        if !other.normals.is_empty() || !self.normals.is_empty() {
            self.normals.resize(before, Vector3::from(NO_NORMAL));
            self.normals.append(&mut other.normals);
            self.normals.resize(before + count, Vector3::from(NO_NORMAL));
        }
        if !other.colours.is_empty() || !self.colours.is_empty() {
            self.colours.resize(before, [0; 3]);
            self.colours.append(&mut other.colours);
            self.colours.resize(before + count, [0; 3]);
        }
        for (name, values) in &mut other.scalars {
            let place =
                self.scalars.iter().position(|(own, own_values)| own == name && own_values.len() <= before);
            let place = place.unwrap_or_else(|| {
                self.scalars.push((name.clone(), Vec::new()));
                self.scalars.len() - 1
            });
            let own = &mut self.scalars[place].1;
            own.resize(before, f64::NAN);
            own.append(values);
        }
        for (_, values) in &mut self.scalars {
            values.resize(before + count, f64::NAN);
        }
        self.take_doubts(other);
    }

    /// Takes the positions and normals, and forgets the rest; points without a normal get one of NaN if `has_normals` says so.
    pub(super) fn take_piece(&mut self, has_normals: bool) -> Piece {
        self.colours.clear();
        self.scalars.iter_mut().for_each(|(_, values)| values.clear());
        let positions = std::mem::take(&mut self.positions);
        let mut normals = std::mem::take(&mut self.normals);
        normals.resize(positions.len(), Vector3::from(NO_NORMAL));
        Piece { positions, normals: has_normals.then_some(normals) }
    }

    /// Takes the number of points that were left out since it was asked for.
    pub(super) fn take_invalid(&mut self) -> usize {
        std::mem::take(&mut self.invalid)
    }

    /// Says what was left out or changed.
    pub(super) fn warn(&self, warnings: &mut Vec<String>) {
        super::warn_of_invalid(self.invalid, warnings);
        if self.colourless > 0 {
            let points = counted(self.colourless, "point");
            warnings.push(format!("black: {points} whose colour is marked as not measured"));
        }
        if self.rounded {
            warnings.push(ROUNDED_COLOURS.to_owned());
        }
    }

    /// Takes over what is to be said of others, who say nothing any more.
    pub(super) fn take_doubts(&mut self, other: &mut Self) {
        self.invalid += std::mem::take(&mut other.invalid);
        self.colourless += std::mem::take(&mut other.colourless);
        self.rounded |= std::mem::take(&mut other.rounded);
    }

    /// The points as a cloud; `scans` are those they are from, whose numbers become a scalar where there are several.
    pub(super) fn into_cloud(
        self,
        scans: &[Scan],
        is_one_of_several: bool,
        warnings: &mut Vec<String>,
    ) -> Result<PointCloud, Error> {
        if self.positions.is_empty() && self.invalid == 0 {
            return Ok(super::nothing());
        }
        self.warn(warnings);
        let mut attributes = Attributes::default();
        if !self.normals.is_empty() {
            attributes.set_normals(Some(self.normals));
        }
        if !self.colours.is_empty() {
            attributes.set_colours(Some(Colours::Rgb(self.colours)));
        }
        for (name, values) in self.scalars {
            let name = free_name(&attributes, name, warnings);
            attributes.push_scalar(name, values).map_err(Error::shape)?;
        }
        if is_one_of_several {
            let numbers = scans.iter().flat_map(|scan| std::iter::repeat_n(scan.number as f64, scan.points));
            let name = free_name(&attributes, "scan".to_owned(), warnings);
            attributes.push_scalar(name, numbers.collect()).map_err(Error::shape)?;
        }
        PointCloud::new(self.positions).with_attributes(attributes).map_err(Error::shape)
    }
}
