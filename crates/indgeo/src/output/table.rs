//! The columns of a result and what stands in them.

use super::rows::{Cell, Rows};
use crate::input::target::{Foot, Target};
use industrial_geometry::footpoint::Status;
use industrial_geometry::mesh::TextField;
use industrial_geometry::mesh::nalgebra::Point3;

/// A column. The names are a contract that other programs rely on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Column {
    /// Coordinate of the point as read.
    Point(u8),
    /// Coordinate of the footpoint.
    Foot(u8),
    /// Distance, with a sign where the model gives one.
    Distance,
    /// Index of the shape in the model.
    Shape,
    /// First parameter on a surface; in a model with curves too, `t` on these.
    U,
    /// Second parameter on a surface.
    V,
    /// Parameter on a curve.
    T,
    /// Index of the triangle.
    Triangle,
    /// How the projection ended.
    Status,
    /// What is proven: no point of the model is nearer.
    LowerBound,
    /// What of a CAD model the footpoint lies on.
    On,
    /// Side of a CAD model on which the point lies.
    Side,
    /// Number of the face or edge in the file of a CAD model.
    Entity,
}

impl Column {
    /// The name in the header.
    fn name(self) -> &'static str {
        match self {
            Self::Point(0) => "x",
            Self::Point(1) => "y",
            Self::Point(_) => "z",
            Self::Foot(0) => "foot_x",
            Self::Foot(1) => "foot_y",
            Self::Foot(_) => "foot_z",
            Self::Distance => "distance",
            Self::Shape => "shape",
            Self::U => "u",
            Self::V => "v",
            Self::T => "t",
            Self::Triangle => "triangle",
            Self::Status => "status",
            Self::LowerBound => "lower_bound",
            Self::On => "on",
            Self::Side => "side",
            Self::Entity => "entity",
        }
    }

    /// The cell of a row.
    fn cell(self, point: &Point3<f64>, foot: &Foot) -> Cell {
        let index = |value: u32| Cell::Index((value != u32::MAX).then_some(value));
        match self {
            Self::Point(axis) => Cell::Given(point[usize::from(axis)]),
            Self::Foot(axis) => Cell::Number(foot.point[usize::from(axis)]),
            Self::Distance => Cell::Number(foot.distance),
            Self::Shape => index(foot.shape),
            Self::U | Self::T => Cell::Number(foot.parameter[0]),
            Self::V => Cell::Number(foot.parameter[1]),
            Self::Triangle => index(foot.triangle),
            Self::Status => status_cell(foot.status),
            Self::LowerBound => Cell::Number(foot.lower_bound),
            Self::On => named(foot.location, &PLACES),
            Self::Side => named(foot.side, &SIDES),
            Self::Entity => index(foot.entity),
        }
    }
}

/// Which columns a kind of model has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Layout(Vec<Column>);

impl Layout {
    /// The columns for a model of `shapes` shapes.
    pub(crate) fn of(target: &Target, shapes: usize) -> Self {
        let dimension = if target.is_planar() { 2 } else { 3 };
        let mut columns: Vec<Column> = (0..dimension).map(Column::Point).collect();
        columns.extend((0..dimension).map(Column::Foot));
        columns.push(Column::Distance);
        let rest: &[Column] = match target {
            // A single curve in the plane has no index.
            Target::Plane(_) if shapes == 1 => &[Column::T],
            Target::Plane(_) | Target::Space { surfaces: None, .. } => &[Column::Shape, Column::T],
            Target::Space { .. } | Target::Cad(_) => &[Column::Shape, Column::U, Column::V],
            Target::Mesh(_) => &[Column::Shape, Column::Triangle],
            Target::LevelSet(_) => &[],
        };
        columns.extend(rest);
        columns.extend([Column::Status, Column::LowerBound]);
        if matches!(target, Target::Cad(_)) {
            columns.extend([Column::On, Column::Side, Column::Entity]);
        }
        Self(columns)
    }

    /// The names in the header.
    pub(crate) fn names(&self) -> Vec<&'static str> {
        self.0.iter().map(|column| column.name()).collect()
    }
}

/// Points, their footpoints, and the columns to be written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Table<'a> {
    /// The columns.
    pub(crate) layout: &'a Layout,
    /// The points as read.
    pub(crate) points: &'a [Point3<f64>],
    /// Their names.
    pub(crate) point_names: Option<&'a TextField>,
    /// One footpoint per point.
    pub(crate) feet: &'a [Foot],
    /// Triangles over the points, kept in formats that can hold them.
    pub(crate) triangles: &'a [[u32; 3]],
}

/// The statuses in the order of their numbers in binary files.
const STATUSES: [Status; 10] = [
    Status::Converged,
    Status::OnBoundary,
    Status::Stalled,
    Status::MaxIterations,
    Status::Diverged,
    Status::Cancelled,
    Status::InvalidPoint,
    Status::Uncertified,
    Status::NoMatchingFoot,
    Status::NoNormal,
];

/// What a footpoint on a CAD model lies on, in the order of the numbers in binary files.
const PLACES: [&str; 4] = ["none", "face", "edge", "vertex"];
/// Sides of a CAD model, in the order of their numbers.
const SIDES: [&str; 4] = ["none", "outside", "inside", "undecided"];

/// One of a few names with its number.
fn named(name: &'static str, of: &[&str]) -> Cell {
    Cell::Name(name, (0u8..).zip(of).find(|(_, other)| **other == name).map_or(0, |(code, _)| code))
}

/// The number of a status in the file; 255 for one that is not listed.
fn code(status: Status) -> u8 {
    (0u8..).zip(STATUSES).find(|(_, other)| *other == status).map_or(u8::MAX, |(code, _)| code)
}

/// A status with its number.
pub(super) fn status_cell(status: Status) -> Cell {
    Cell::Name(status.name(), code(status))
}

/// What the numbers of statuses in binary files mean.
pub(super) fn status_comment() -> String {
    let names: Vec<String> = STATUSES.iter().map(|&status| format!("{} {status}", code(status))).collect();
    format!("status: {}", names.join(", "))
}

impl Rows for Table<'_> {
    fn names(&self) -> Vec<&'static str> {
        self.layout.names()
    }

    fn count(&self) -> usize {
        self.points.len()
    }

    fn cell(&self, row: usize, column: usize) -> Cell {
        self.layout.0[column].cell(&self.points[row], &self.feet[row])
    }

    fn point_names(&self) -> Option<&TextField> {
        self.point_names
    }

    fn triangles(&self) -> &[[u32; 3]] {
        self.triangles
    }

    fn comments(&self) -> Vec<String> {
        vec![
            format!("footpoints by indgeo {}, in the unit of the input", env!("CARGO_PKG_VERSION")),
            status_comment(),
        ]
        .into_iter()
        .chain(self.layout.0.contains(&Column::On).then(|| {
            let list = |names: &[&str]| {
                let numbered: Vec<String> =
                    names.iter().enumerate().map(|(k, name)| format!("{k} {name}")).collect();
                numbered.join(", ")
            };
            format!("on: {}; side: {}", list(&PLACES), list(&SIDES))
        }))
        .collect()
    }
}
