//! Writing tables.

use std::io::{self, Write};

use mesh_core::TextField;

use crate::shape::{Keeps, Shape};
use crate::write_number;

const KEEPS: Keeps = Keeps {
    normals: true,
    colours: true,
    opacity: true,
    scalars: true,
    texts: true,
    triangles: false,
    plane: true,
};

/// Writes a header line and rows separated by commas.
pub(crate) fn write_csv(out: &mut dyn Write, shape: Shape<'_>, warnings: &mut Vec<String>) -> io::Result<()> {
    shape.warn_of_loss(KEEPS, warnings);
    let (names, texts) = names(shape, warnings);
    writeln!(out, "{}", names.join(","))?;
    write_rows(out, shape, &texts, ",")
}

/// Writes rows separated by blanks, under a comment with the names where there is more than coordinates.
pub(crate) fn write_xyz(out: &mut dyn Write, shape: Shape<'_>, warnings: &mut Vec<String>) -> io::Result<()> {
    shape.warn_of_loss(KEEPS, warnings);
    let (names, texts) = names(shape, warnings);
    if !shape.attributes().is_empty() || shape.positions().is_empty() {
        writeln!(out, "# {}", names.join(" "))?;
    }
    write_rows(out, shape, &texts, " ")
}

/// Writes more rows of a table, which has no texts.
pub(crate) fn write_more(out: &mut dyn Write, shape: Shape<'_>, is_csv: bool) -> io::Result<()> {
    write_rows(out, shape, &[], if is_csv { "," } else { " " })
}

/// Writes the count of all points and rows x y z \[intensity\] \[r g b\].
pub(crate) fn write_pts(
    out: &mut dyn Write,
    shape: Shape<'_>,
    count: usize,
    warnings: &mut Vec<String>,
) -> io::Result<()> {
    let attributes = shape.attributes();
    shape.warn_of_loss(
        Keeps { normals: false, opacity: false, texts: false, plane: false, ..KEEPS },
        warnings,
    );
    let lost: Vec<_> = (attributes.scalars().iter())
        .filter(|field| field.name != "intensity")
        .map(|field| format!("scalar {:?}", field.name))
        .collect();
    if !lost.is_empty() {
        warnings.push(format!("the format cannot hold and lost: {}", lost.join(", ")));
    }
    writeln!(out, "{count}")?;
    write_more_pts(out, shape)
}

/// Writes more rows of points.
pub(crate) fn write_more_pts(out: &mut dyn Write, shape: Shape<'_>) -> io::Result<()> {
    let intensity = shape.attributes().scalar("intensity");
    for (index, point) in shape.positions().iter().enumerate() {
        write_numbers(out, point.coords.as_slice(), " ", true)?;
        if let Some(values) = intensity {
            write_numbers(out, &values[index..=index], " ", false)?;
        }
        if let Some([r, g, b, _]) = shape.colours().and_then(|colours| colours.rgba(index)) {
            write!(out, " {r} {g} {b}")?;
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}

/// The names of all columns, and the texts among them.
fn names<'a>(shape: Shape<'a>, warnings: &mut Vec<String>) -> (Vec<String>, Vec<&'a TextField>) {
    let normals = if shape.normals().is_some() { ["nx", "ny", "nz"].as_slice() } else { &[] };
    let colours = match shape.colours() {
        Some(colours) if colours.has_alpha() => ["r", "g", "b", "a"].as_slice(),
        Some(_) => &["r", "g", "b"],
        None => &[],
    };
    let fixed = shape.axes().iter().chain(normals).chain(colours).map(|&name| name.to_owned());
    let mut all: Vec<String> = fixed.chain(shape.scalar_names(warnings)).collect();
    let texts = shape.texts(&all);
    all.extend(texts.iter().map(|(name, _)| name.clone()));
    (all, texts.into_iter().map(|(_, field)| field).collect())
}

fn write_rows(
    out: &mut dyn Write,
    shape: Shape<'_>,
    texts: &[&TextField],
    separator: &str,
) -> io::Result<()> {
    for (index, point) in shape.positions().iter().enumerate() {
        write_numbers(out, &point.coords.as_slice()[..shape.cloud.dimension()], separator, true)?;
        if let Some(normal) = shape.normals().and_then(|normals| normals.get(index)) {
            write_numbers(out, normal.as_slice(), separator, false)?;
        }
        if let Some((colours, rgba)) =
            shape.colours().and_then(|colours| Some((colours, colours.rgba(index)?)))
        {
            for channel in &rgba[..if colours.has_alpha() { 4 } else { 3 }] {
                write!(out, "{separator}{channel}")?;
            }
        }
        for field in shape.attributes().scalars() {
            write_numbers(out, &field.values[index..=index], separator, false)?;
        }
        for field in texts {
            out.write_all(separator.as_bytes())?;
            write_text(out, field.get(index).unwrap_or_default(), separator == ",")?;
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}

/// Writes a text as a field: in quotes, which are doubled within, where it could be taken for something else. Ends of
/// lines become blanks.
///
/// # Errors
/// Those of `out`.
pub fn write_text(out: &mut dyn Write, text: &str, commas: bool) -> io::Result<()> {
    let special =
        |letter: char| matches!(letter, ',' | ';' | '"' | '|' | '#' | '%' | '/') || letter.is_control();
    let blank = |letter: char| letter.is_whitespace();
    let quotes = text.contains(special)
        || text.starts_with(blank)
        || text.ends_with(blank)
        || !commas && (text.is_empty() || text.contains(blank));
    if !quotes {
        return out.write_all(text.as_bytes());
    }
    let plain = text.replace(|letter: char| letter.is_control(), " ").replace('"', "\"\"");
    write!(out, "\"{plain}\"")
}

fn write_numbers(out: &mut dyn Write, values: &[f64], separator: &str, first: bool) -> io::Result<()> {
    for (place, &value) in values.iter().enumerate() {
        if !(first && place == 0) {
            out.write_all(separator.as_bytes())?;
        }
        write_number(out, value)?;
    }
    Ok(())
}
