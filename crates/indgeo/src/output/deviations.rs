//! Deviations, one row per point.

use super::rows::{Cell, Rows};
use industrial_geometry::inspection::{
    Class, ColourScale, DeviationRecord, InspectionOptions, Nominal, Outcome,
};
use industrial_geometry::mesh::TextField;
use industrial_geometry::mesh::nalgebra::{Point3, Vector3};

/// Points as they were inspected, and their deviations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DeviationTable<'a> {
    /// The points.
    pub(crate) points: &'a [Point3<f64>],
    /// Their normals, where they were looked at.
    pub(crate) normals: Option<&'a [Vector3<f64>]>,
    /// Their names.
    pub(crate) point_names: Option<&'a TextField>,
    /// One deviation per point.
    pub(crate) records: &'a [DeviationRecord],
    /// Triangles over the points.
    pub(crate) triangles: &'a [[u32; 3]],
    /// The model, which knows its normals.
    pub(crate) nominal: &'a Nominal,
    /// How deviations were measured.
    pub(crate) options: &'a InspectionOptions,
    /// What the deviations are measured from.
    pub(crate) model: Measured,
    /// Whether rows end with a colour.
    pub(crate) coloured: bool,
}

/// What deviations are measured from: this decides how a place on it is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Measured {
    /// Surfaces: parameters `u, v`.
    Surfaces,
    /// Curves in space: parameter `t`.
    Curves,
    /// Curves in the plane: parameter `t`, and no z.
    Profile,
    /// A mesh: triangles.
    Mesh,
}

const COMMON: [&str; 11] =
    ["x", "y", "z", "foot_x", "foot_y", "foot_z", "normal_x", "normal_y", "normal_z", "distance", "shape"];
const ON_SURFACES: [&str; 2] = ["u", "v"];
const ON_CURVES: [&str; 1] = ["t"];
const ON_MESH: [&str; 1] = ["triangle"];
/// The columns of [`COMMON`] that are left in the plane.
const PLANE: [usize; 8] = [0, 1, 3, 4, 6, 7, 9, 10];
const LAST: [&str; 2] = ["location", "result"];
const COLOURS: [&str; 3] = ["red", "green", "blue"];
/// Names of places, in the order of their numbers in binary files.
const PLACES: [&str; 9] =
    ["none", "interior", "edge", "corner", "seam", "pole", "face", "triangle_edge", "vertex"];

impl DeviationTable<'_> {
    fn where_on_shape(&self) -> &'static [&'static str] {
        match self.model {
            Measured::Surfaces => &ON_SURFACES,
            Measured::Curves | Measured::Profile => &ON_CURVES,
            Measured::Mesh => &ON_MESH,
        }
    }

    /// The column that a table in space has in the place of a given one.
    fn in_space(&self, column: usize) -> usize {
        match self.model {
            Measured::Profile => PLANE.get(column).copied().unwrap_or(column + COMMON.len() - PLANE.len()),
            _ => column,
        }
    }

    /// `within`, `over`, `under`, or why there is no result.
    fn result(&self, record: &DeviationRecord) -> (&'static str, u8) {
        match record.class(&self.options.tolerance) {
            Some(Class::Within) => ("within", 0),
            Some(Class::Over) => ("over", 1),
            Some(Class::Under) => ("under", 2),
            None => (record.outcome.name(), number(record.outcome)),
        }
    }

    /// The normal of the model at the foot of a point.
    fn normal(&self, row: usize) -> Vector3<f64> {
        let normal = self.normals.and_then(|normals| normals.get(row));
        self.nominal.normal(&self.points[row], normal, &self.records[row], self.options)
    }
}

/// The number of a point without a result in binary files.
fn number(outcome: Outcome) -> u8 {
    (2u8..).zip(Outcome::ALL).find(|(_, other)| *other == outcome).map_or(u8::MAX, |(number, _)| number)
}

impl Rows for DeviationTable<'_> {
    fn names(&self) -> Vec<&'static str> {
        let mut names = match self.model {
            Measured::Profile => PLANE.map(|column| COMMON[column]).to_vec(),
            _ => COMMON.to_vec(),
        };
        names.extend(self.where_on_shape());
        names.extend(LAST);
        if self.coloured {
            names.extend(COLOURS);
        }
        names
    }

    fn count(&self) -> usize {
        self.points.len()
    }

    fn cell(&self, row: usize, column: usize) -> Cell {
        let (point, record) = (&self.points[row], &self.records[row]);
        let index = |value: u32| Cell::Index((value != u32::MAX).then_some(value));
        let rest = self.where_on_shape().len();
        match self.in_space(column) {
            column @ 0..3 => Cell::Given(point[column]),
            column @ 3..6 => Cell::Number(record.foot[column - 3]),
            column @ 6..9 => Cell::Number(self.normal(row)[column - 6]),
            9 => Cell::Number(record.distance),
            10 => index(record.shape()),
            11 if self.model == Measured::Mesh => index(record.triangle()),
            column @ 11.. if column < COMMON.len() + rest => Cell::Number(record.parameter[column - 11]),
            column => match column - COMMON.len() - rest {
                0 => {
                    let name = record.place.name();
                    let code = (0u8..).zip(PLACES).find(|(_, place)| *place == name);
                    Cell::Name(name, code.map_or(u8::MAX, |(code, _)| code))
                }
                1 => {
                    let (name, code) = self.result(record);
                    Cell::Name(name, code)
                }
                channel => {
                    let counts = record.outcome == Outcome::Measured;
                    let value = if counts { record.distance } else { f64::NAN };
                    Cell::Byte(ColourScale::new(self.options.tolerance).colour(value)[(channel - 2).min(2)])
                }
            },
        }
    }

    fn point_names(&self) -> Option<&TextField> {
        self.point_names
    }

    fn triangles(&self) -> &[[u32; 3]] {
        self.triangles
    }

    fn comments(&self) -> Vec<String> {
        let places: Vec<String> =
            PLACES.iter().enumerate().map(|(code, name)| format!("{code} {name}")).collect();
        let outcomes: Vec<String> = Outcome::ALL[1..]
            .iter()
            .map(|outcome| format!("{} {}", number(*outcome), outcome.name()))
            .collect();
        vec![
            format!("deviations by indgeo {}, in the unit of the input", env!("CARGO_PKG_VERSION")),
            format!("tolerance: {} to {}", self.options.tolerance.lower, self.options.tolerance.upper),
            format!("location: {}", places.join(", ")),
            format!("result: 0 within, 1 over, 2 under, {}", outcomes.join(", ")),
        ]
    }
}
