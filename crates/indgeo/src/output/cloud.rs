//! Results as clouds, for the formats of scanners and of viewers.

use super::rows::{Cell, Rows};
use industrial_geometry::io::{Content, Format, WriteOptions, write_to};
use industrial_geometry::mesh::nalgebra::{Point3, Vector3};
use industrial_geometry::mesh::{Attributes, Colours, PointCloud, TriangleMesh};
use std::io::{self, Write};

/// Writes the points with the other columns as scalars; indices are −1 where there is none, and names of states numbers, as in
/// PLY. Returns what the format could not hold.
pub(super) fn write(out: &mut dyn Write, format: Format, table: &dyn Rows) -> io::Result<Vec<String>> {
    let content = content(table).map_err(io::Error::other)?;
    let options = WriteOptions::default().with_format(format);
    let report = write_to(out, "result", &content, &options).map_err(io::Error::other)?;
    Ok(report.warnings)
}

fn content(table: &dyn Rows) -> Result<Content, industrial_geometry::mesh::Error> {
    let names = table.names();
    let count = table.count();
    let place = |name: &str| names.iter().position(|other| *other == name);
    let number = |row: usize, column: usize| match table.cell(row, column) {
        Cell::Given(value) | Cell::Number(value) => value,
        Cell::Index(index) => index.map_or(-1.0, f64::from),
        Cell::Name(_, code) => f64::from(code),
        Cell::Byte(value) => f64::from(value),
    };
    let triple = |names: [&str; 3]| names.map(place);
    let positions = triple(["x", "y", "z"]);
    let at = |row: usize, places: [Option<usize>; 3]| {
        places.map(|place| place.map_or(0.0, |place| number(row, place)))
    };
    let is_planar = positions[2].is_none();
    let points = (0..count).map(|row| Point3::from(at(row, positions))).collect();
    let mut attributes = Attributes::default();
    let mut taken: Vec<usize> = positions.into_iter().flatten().collect();
    let normals = triple(["normal_x", "normal_y", "normal_z"]);
    if normals.iter().all(Option::is_some) {
        attributes.set_normals(Some((0..count).map(|row| Vector3::from(at(row, normals))).collect()));
        taken.extend(normals.into_iter().flatten());
    }
    let colours = triple(["red", "green", "blue"]);
    if colours.iter().all(Option::is_some) {
        let byte = |row: usize, place: Option<usize>| match place.map(|place| table.cell(row, place)) {
            Some(Cell::Byte(value)) => value,
            _ => 0,
        };
        let rows = (0..count).map(|row| colours.map(|place| byte(row, place))).collect();
        attributes.set_colours(Some(Colours::Rgb(rows)));
        taken.extend(colours.into_iter().flatten());
    }
    for (column, name) in names.iter().enumerate().filter(|(column, _)| !taken.contains(column)) {
        attributes.push_scalar(*name, (0..count).map(|row| number(row, column)).collect())?;
    }
    attributes.set_names(table.point_names().cloned());
    let cloud = PointCloud::new(points);
    let cloud = if is_planar { cloud.into_planar()? } else { cloud };
    let cloud = cloud.with_attributes(attributes)?;
    if table.triangles().is_empty() {
        return Ok(Content::Cloud(cloud));
    }
    Ok(Content::Mesh(TriangleMesh::from_cloud(cloud, table.triangles().to_vec())?))
}
