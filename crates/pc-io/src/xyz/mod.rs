//! Tables of numbers: XYZ, CSV, PTS and their relatives.

mod fields;
mod layout;
mod meaning;
mod names;
mod notation;
pub(crate) mod pieces;
mod rows;
mod write;

use self::fields::Separator;
use self::layout::Layout;
use self::rows::Rows;
use crate::columns::{Column, Kind, assemble};
use crate::parsed::Parsed;
use crate::source::Source;
use crate::wording::counted;
use crate::{Error, Format, ReadOptions, not_points};

pub(crate) use self::layout::{format_of_row, looks_like_header, looks_like_row};
pub(crate) use self::names::is_label;
pub use self::write::write_text;
pub(crate) use self::write::{write_csv, write_more, write_more_pts, write_pts, write_xyz};

/// Reads one point per line. The meaning of the columns follows from the names in a header line, else from the
/// number of columns and their values; what was assumed is told in the warnings.
pub(crate) fn read(source: Source<'_>, options: &ReadOptions) -> Result<Parsed, Error> {
    let (layout, rows) = read_rows(source, options)?;
    let mut warnings = layout.notes.clone();
    let count = rows.values.len() / rows.width;
    let nothing =
        |place: usize| rows.values.iter().skip(place).step_by(rows.width).all(|value| value.is_nan());
    let blanks = layout.blanks.iter().filter(|&&place| place < rows.width && nothing(place)).count();
    let empty = rows.empty.saturating_sub(blanks * count);
    if empty > 0 {
        warnings.push(format!("read as NaN: {}", counted(empty, "empty field")));
    }
    if rows.values.is_empty() && layout.promised.is_some_and(|promised| promised > 0) {
        let what = "the file ends after the number of points";
        return Err(source.line_error(layout.data, what, "the file is truncated, export it again"));
    }
    if rows.width < 2 {
        return Err(source.line_error(
            layout.data,
            "the lines hold one number each, but a point has two or three coordinates",
            "give a file with a point per line",
        ));
    }
    if let Some(promised) = layout.promised
        && promised != count as u64
    {
        warnings.push(format!("the first line says {promised} points, but the file holds {count}"));
    }
    let names = match &layout.names {
        Some(names) => names.clone(),
        None => meaning::guess(&rows, &layout, &mut warnings),
    };
    let format = match (layout.promised, layout.separator) {
        (Some(_), _) => Format::Pts,
        (None, Separator::Blank) => Format::Xyz,
        (None, Separator::Byte(_)) => Format::Csv,
    };
    let cloud = assemble_rows(names, rows, &layout, &mut warnings)?;
    Ok(Parsed::cloud(format, cloud, warnings))
}

/// The rows, and how they are laid out: as the first lines suggest, or, if that fails further down, as all of them do.
fn read_rows(source: Source<'_>, options: &ReadOptions) -> Result<(Layout, Rows), Error> {
    let first = Layout::detect(source, options.decimal_comma, false)?;
    match rows::read(source, &first) {
        Ok(rows) => Ok((first, rows)),
        Err(error) => match Layout::detect(source, options.decimal_comma, true) {
            Ok(layout) if layout != first => Ok((layout.clone(), rows::read(source, &layout)?)),
            Ok(_) => Err(error),
            Err(other) => Err(other),
        },
    }
}

fn assemble_rows(
    names: Vec<String>,
    rows: Rows,
    layout: &Layout,
    warnings: &mut Vec<String>,
) -> Result<mesh_core::PointCloud, Error> {
    let Rows { values, width, texts, .. } = rows;
    let mut columns = Vec::new();
    for (place, name) in names.iter().enumerate().filter(|(place, _)| !layout.texts.contains(place)) {
        let column = values.iter().skip(place).step_by(width).copied();
        // Separators at the ends of all lines make a column of nothing.
        if name.is_empty() && column.clone().all(f64::is_nan) {
            continue;
        }
        let name = if name.is_empty() { format!("column_{}", place + 1) } else { name.clone() };
        columns.push(Column { name, kind: Kind::Text, values: column.collect() });
    }
    drop(values);
    let cloud = assemble(columns, warnings).map_err(not_points)?;
    let mut attributes = cloud.attributes().clone();
    for (field, &place) in texts.into_iter().zip(&layout.texts).filter(|(_, place)| **place < names.len()) {
        let name =
            if names[place].is_empty() { format!("column_{}", place + 1) } else { names[place].clone() };
        let field = field.with_name(name);
        if layout.label == Some(place) {
            attributes.set_names(Some(field));
        } else {
            attributes.push_text(field);
        }
    }
    cloud.with_attributes(attributes).map_err(Error::shape)
}
