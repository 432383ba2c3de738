//! Writing OFF.

use std::io::{self, Write};

use crate::shape::{Keeps, Shape};
use crate::write_number;

const KEEPS: Keeps = Keeps {
    normals: true,
    colours: true,
    opacity: true,
    scalars: false,
    texts: false,
    triangles: true,
    plane: false,
};

/// Writes `OFF`, `NOFF`, `COFF` or `CNOFF`; colours as integers.
pub(crate) fn write(out: &mut dyn Write, shape: Shape<'_>, warnings: &mut Vec<String>) -> io::Result<()> {
    shape.warn_of_loss(KEEPS, warnings);
    let colours = if shape.colours().is_some() { "C" } else { "" };
    let normals = if shape.normals().is_some() { "N" } else { "" };
    write!(out, "{colours}{normals}OFF\n{} {} 0\n", shape.positions().len(), shape.triangles.len())?;
    for (index, point) in shape.positions().iter().enumerate() {
        let normal = shape.normals().and_then(|normals| normals.get(index));
        let numbers = point.iter().chain(normal.iter().flat_map(|normal| normal.iter()));
        for (place, &value) in numbers.enumerate() {
            out.write_all(if place == 0 { b"" } else { b" " })?;
            write_number(out, value)?;
        }
        if let Some((colours, rgba)) =
            shape.colours().and_then(|colours| Some((colours, colours.rgba(index)?)))
        {
            for channel in &rgba[..if colours.has_alpha() { 4 } else { 3 }] {
                write!(out, " {channel}")?;
            }
        }
        out.write_all(b"\n")?;
    }
    for [a, b, c] in shape.triangles {
        writeln!(out, "3 {a} {b} {c}")?;
    }
    Ok(())
}
