//! Tables of numbers: XYZ, CSV, PTS and their relatives.

mod layout;
mod meaning;
mod write;

use self::layout::{Layout, Separator};
use crate::columns::{Column, Kind, assemble};
use crate::number;
use crate::parsed::Parsed;
use crate::source::{Source, quoted};
use crate::{Error, Format, not_points};

pub(crate) use self::layout::{format_of_row, looks_like_header, looks_like_row};
pub(crate) use self::write::{write_csv, write_pts, write_xyz};

/// Reads one point per line. The meaning of the columns follows from the names in a header line, else from the
/// number of columns and their values; what was assumed is told in the warnings.
pub(crate) fn read(source: Source<'_>) -> Result<Parsed, Error> {
    let layout = Layout::detect(source)?;
    let mut warnings = Vec::new();
    let (values, width) = read_rows(source, &layout, &mut warnings)?;
    let rows = values.len() / width;
    if let Some(promised) = layout.promised
        && promised != rows as u64
    {
        warnings.push(format!("the first line says {promised} points, but the file holds {rows}"));
    }
    let names = match &layout.names {
        Some(names) => names.clone(),
        None => meaning::guess(&values, width, layout.promised.is_some(), &mut warnings)?,
    };
    for &place in &layout.texts {
        warnings.push(format!("not read: the column {:?}, which holds text", names[place]));
    }
    let columns = (names.into_iter().enumerate())
        .filter(|(place, _)| !layout.texts.contains(place))
        .map(|(place, name)| Column {
            name,
            kind: Kind::Text,
            values: values.iter().skip(place).step_by(width).copied().collect(),
        })
        .collect();
    drop(values);
    let cloud = assemble(columns, &mut warnings).map_err(not_points)?;
    let format = match (layout.promised, layout.separator) {
        (Some(_), _) => Format::Pts,
        (None, Separator::Blank) => Format::Xyz,
        (None, Separator::Byte(_)) => Format::Csv,
    };
    Ok(Parsed { format, cloud, triangles: None, warnings })
}

/// The numbers of all rows one after another, and the number of columns.
fn read_rows(
    source: Source<'_>,
    layout: &Layout,
    warnings: &mut Vec<String>,
) -> Result<(Vec<f64>, usize), Error> {
    let mut width = layout.names.as_ref().map(Vec::len);
    let mut values = Vec::with_capacity(source.data.len().saturating_sub(layout.data) / 10);
    let mut empty = 0usize;
    for (at, line) in source.lines_from(layout.data) {
        if layout::is_comment(line) {
            continue;
        }
        let before = values.len();
        layout.separator.numbers(source, (at, line), &layout.texts, &mut values, &mut empty)?;
        // A separator at the end of a line may close the last field or open an empty one.
        if width == Some(values.len() - before + 1) && layout.separator.ends(line) {
            values.push(f64::NAN);
            empty += 1;
        }
        let found = values.len() - before;
        let expected = *width.get_or_insert(found);
        if found != expected {
            // Several PTS scans in one file: each begins with its count.
            if layout.promised.is_some() && found == 1 && number::parse_count(line.trim_ascii()).is_some() {
                values.truncate(before);
                continue;
            }
            if expected < 2 {
                break;
            }
            return Err(source.line_error(
                at,
                format!("{} has {found} columns where {expected} are expected", quoted(line.trim_ascii())),
                "every line must have as many as the first; correct the line, or turn it into a comment with #",
            ));
        }
    }
    if empty > 0 {
        warnings.push(format!("{empty} empty fields were read as NaN"));
    }
    let width = width.unwrap_or(3);
    if values.is_empty() && layout.promised.is_some_and(|promised| promised > 0) {
        let what = "the file ends after the number of points";
        return Err(source.line_error(layout.data, what, "the file is truncated, export it again"));
    }
    if width < 2 {
        return Err(source.line_error(
            layout.data,
            "the lines hold one number each, but a point has two or three coordinates",
            "give a file with a point per line; PTX has to be converted to PTS, PLY or XYZ first",
        ));
    }
    Ok((values, width))
}
