//! Writing OBJ.

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

/// Writes vertices, colours as fractions behind them, normals, and triangles.
pub(crate) fn write(out: &mut dyn Write, shape: Shape<'_>, warnings: &mut Vec<String>) -> io::Result<()> {
    shape.warn_of_loss(KEEPS, warnings);
    for (index, point) in shape.positions().iter().enumerate() {
        write_vector(out, "v", point.coords.as_slice())?;
        if let Some((colours, rgba)) =
            shape.colours().and_then(|colours| Some((colours, colours.rgba(index)?)))
        {
            for &channel in &rgba[..if colours.has_alpha() { 4 } else { 3 }] {
                out.write_all(b" ")?;
                write_number(out, f64::from(channel) / 255.0)?;
            }
        }
        out.write_all(b"\n")?;
    }
    for normal in shape.normals().unwrap_or_default() {
        write_vector(out, "vn", normal.as_slice())?;
        out.write_all(b"\n")?;
    }
    for triangle in shape.triangles {
        let [a, b, c] = triangle.map(|index| u64::from(index) + 1);
        if shape.normals().is_some() {
            writeln!(out, "f {a}//{a} {b}//{b} {c}//{c}")?;
        } else {
            writeln!(out, "f {a} {b} {c}")?;
        }
    }
    Ok(())
}

fn write_vector(out: &mut dyn Write, keyword: &str, values: &[f64]) -> io::Result<()> {
    out.write_all(keyword.as_bytes())?;
    for &value in values {
        out.write_all(b" ")?;
        write_number(out, value)?;
    }
    Ok(())
}
