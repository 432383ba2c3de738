//! Writing PCD.

use std::io::{self, Write};

use mesh_core::Colours;

use crate::shape::{Keeps, Shape};

const KEEPS: Keeps = Keeps {
    normals: true,
    colours: true,
    opacity: true,
    scalars: true,
    texts: false,
    triangles: false,
    plane: true,
};

/// A field of one number, single or double precision.
struct Column<'a> {
    name: String,
    values: Box<dyn Fn(usize) -> f64 + 'a>,
    single: bool,
}

/// Writes binary PCD. A field takes single precision where that loses nothing (other programs prefer it), else double.
pub(crate) fn write(out: &mut dyn Write, shape: Shape<'_>, warnings: &mut Vec<String>) -> io::Result<()> {
    shape.warn_of_loss(KEEPS, warnings);
    let points = shape.positions().len();
    let columns = columns(shape, warnings);
    let colour = match shape.colours() {
        None => None,
        Some(Colours::Rgb(_)) => Some(("rgb", "F")),
        Some(Colours::Rgba(_)) => Some(("rgba", "U")),
    };
    let mut lines =
        [String::from("FIELDS"), String::from("SIZE"), String::from("TYPE"), String::from("COUNT")];
    let single =
        columns.iter().map(|column| (column.name.as_str(), if column.single { "4" } else { "8" }, "F"));
    for (name, size, kind) in single.chain(colour.map(|(name, kind)| (name, "4", kind))) {
        for (line, word) in lines.iter_mut().zip([name, size, kind, "1"]) {
            line.push(' ');
            line.push_str(word);
        }
    }
    writeln!(out, "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n{}", lines.join("\n"))?;
    write!(out, "WIDTH {points}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {points}\nDATA binary\n")?;
    let mut row = Vec::new();
    for index in 0..points {
        row.clear();
        for column in &columns {
            let value = (column.values)(index);
            if column.single {
                row.extend(single_of(value).to_le_bytes());
            } else {
                row.extend(value.to_le_bytes());
            }
        }
        if let Some([r, g, b, a]) = shape.colours().and_then(|colours| colours.rgba(index)) {
            // In a field of floats the highest byte stays 0, so that no colour is a NaN.
            row.extend([b, g, r, if colour == Some(("rgb", "F")) { 0 } else { a }]);
        }
        out.write_all(&row)?;
    }
    Ok(())
}

fn columns<'a>(shape: Shape<'a>, warnings: &mut Vec<String>) -> Vec<Column<'a>> {
    let points = shape.positions().len();
    let mut columns: Vec<Column<'a>> = Vec::new();
    let mut add = |names: &[&str], values: Vec<Box<dyn Fn(usize) -> f64 + 'a>>| {
        let exact = |value: f64| f64::from(single_of(value)).to_bits() == value.to_bits();
        let single = values.iter().all(|values| (0..points).all(|index| exact(values(index))));
        let named = names.iter().zip(values);
        columns.extend(named.map(|(&name, values)| Column { name: name.to_owned(), values, single }));
    };
    let positions = shape.positions();
    let axis =
        |axis: usize| -> Box<dyn Fn(usize) -> f64 + 'a> { Box::new(move |index| positions[index][axis]) };
    add(shape.axes(), (0..shape.axes().len()).map(axis).collect());
    if let Some(normals) = shape.normals() {
        let axis =
            |axis: usize| -> Box<dyn Fn(usize) -> f64 + 'a> { Box::new(move |index| normals[index][axis]) };
        add(&["normal_x", "normal_y", "normal_z"], (0..3).map(axis).collect());
    }
    for (name, field) in shape.scalar_names(warnings).iter().zip(shape.attributes().scalars()) {
        add(&[name.as_str()], vec![Box::new(move |index| field.values[index])]);
    }
    columns
}

#[expect(clippy::cast_possible_truncation, reason = "used where nothing is lost, which is tested first")]
const fn single_of(value: f64) -> f32 {
    value as f32
}
