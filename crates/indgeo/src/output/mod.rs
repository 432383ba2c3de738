//! Results in files: one row per point, in the order of the input.

pub(crate) mod cad;
mod cloud;
mod columns;
mod csv;
mod deviations;
pub(crate) mod html;
mod json;
mod parameters;
pub(crate) mod partials;
mod pieces;
mod ply;
mod rows;
pub(crate) mod staging;
mod table;

pub(crate) use deviations::{DeviationTable, Measured};
pub(crate) use parameters::ParameterTable;
pub(crate) use pieces::{Sink, is_written_in_pieces, write_in_pieces};
pub(crate) use rows::{NAME, Rows};
pub(crate) use table::{Layout, Table};

use crate::error::Error;
use crate::files;
use crate::runtime::memory;
use clap::ValueEnum;
use industrial_geometry::io;
use std::path::Path;

/// The formats of results, by extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// A header line, then one line per point
    Csv,
    /// Binary little endian
    Ply,
    /// One array per column
    Json,
    /// LAS 1.4: columns as extra bytes, coordinates rounded to a grid
    Las,
    /// LAS, compressed
    Laz,
    /// E57: columns as an extension
    E57,
    /// Binary glTF: points or triangles with normals and colours, no other columns
    Glb,
    /// One array after the other, for callers from another language
    #[value(skip)]
    Columns,
}

impl Format {
    /// Whether a viewer shows the colours of the rows.
    pub(crate) fn has_colours(self) -> bool {
        !matches!(self, Self::Csv | Self::Json | Self::Columns)
    }

    /// The format that was asked for, or that of the extension; CSV on standard output.
    pub(crate) fn of(path: &Path, asked: Option<Self>) -> Result<Self, Error> {
        if let Some(format) = asked.or_else(|| files::is_stream(path).then_some(Self::Csv)) {
            return Ok(format);
        }
        match files::extension(path).as_str() {
            "csv" => Ok(Self::Csv),
            "ply" => Ok(Self::Ply),
            "json" => Ok(Self::Json),
            "las" => Ok(Self::Las),
            "laz" => Ok(Self::Laz),
            "e57" => Ok(Self::E57),
            "glb" => Ok(Self::Glb),
            "columns" if memory::is_memory(path) => Ok(Self::Columns),
            "" => Err(Error::content(path, "the name has no extension", ADVICE)),
            other => Err(Error::content(path, format!("results are not written as `.{other}`"), ADVICE)),
        }
    }
}

const ADVICE: &str = "choose .csv, .ply, .json, .las, .laz, .e57 or .glb, or add --format";

/// A result that was written.
#[derive(Debug)]
pub(crate) struct Written {
    /// Size in bytes.
    pub(crate) bytes: u64,
    /// What the format could not hold.
    pub(crate) warnings: Vec<String>,
}

/// Writes the table; a file appears whole or not at all.
pub(crate) fn write(path: &Path, format: Format, table: &dyn Rows) -> Result<Written, Error> {
    let mut warnings = Vec::new();
    let bytes = files::write(path, |out| {
        let format = match format {
            Format::Csv => return csv::write(out, table),
            Format::Ply => return ply::write(out, table),
            Format::Json => return json::write(out, table),
            Format::Columns => return columns::write(out, table),
            Format::Las => io::Format::Las,
            Format::Laz => io::Format::Laz,
            Format::E57 => io::Format::E57,
            Format::Glb => io::Format::Glb,
        };
        warnings = cloud::write(out, format, table)?;
        Ok(())
    })?;
    let name = |warning: String| format!("{}: {warning}", path.display());
    Ok(Written { bytes, warnings: warnings.into_iter().map(name).collect() })
}
