//! Points with their parameters.

use super::rows::{Cell, Rows};
use super::table::status_cell;
use industrial_geometry::footpoint::SurfaceFootpoint;
use industrial_geometry::mesh::TextField;
use industrial_geometry::mesh::nalgebra::Point3;

/// Points and their parameters on a base surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ParameterTable<'a> {
    /// The points as read.
    pub(crate) points: &'a [Point3<f64>],
    /// Their names.
    pub(crate) point_names: Option<&'a TextField>,
    /// One footpoint per point.
    pub(crate) feet: &'a [SurfaceFootpoint],
    /// For each point whether it counts for a fit.
    pub(crate) counts: &'a [bool],
}

impl Rows for ParameterTable<'_> {
    fn names(&self) -> Vec<&'static str> {
        vec!["x", "y", "z", "u", "v", "distance", "used", "status"]
    }

    fn count(&self) -> usize {
        self.points.len()
    }

    fn cell(&self, row: usize, column: usize) -> Cell {
        let foot = &self.feet[row];
        let number = |value: f64| Cell::Number(if foot.status.is_converged() { value } else { f64::NAN });
        match column {
            0..=2 => Cell::Given(self.points[row][column]),
            3 | 4 => number(foot.parameter[column - 3]),
            5 => number(foot.signed_distance),
            6 => Cell::Byte(u8::from(self.counts[row])),
            _ => status_cell(foot.status),
        }
    }

    fn point_names(&self) -> Option<&TextField> {
        self.point_names
    }

    fn triangles(&self) -> &[[u32; 3]] {
        &[]
    }

    fn comments(&self) -> Vec<String> {
        vec![format!("parameters by indgeo {}", env!("CARGO_PKG_VERSION")), super::table::status_comment()]
    }
}
