//! Results in files: one row per point, in the order of the input.

mod csv;
mod deviations;
mod json;
mod parameters;
mod ply;
mod rows;
mod table;

pub(crate) use deviations::{DeviationTable, Measured};
pub(crate) use parameters::ParameterTable;
pub(crate) use rows::{NAME, Rows};
pub(crate) use table::{Layout, Table};

use crate::error::Error;
use crate::files;
use clap::ValueEnum;
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
}

impl Format {
    /// The format that was asked for, or that of the extension; CSV on standard output.
    pub(crate) fn of(path: &Path, asked: Option<Self>) -> Result<Self, Error> {
        if let Some(format) = asked.or_else(|| files::is_stream(path).then_some(Self::Csv)) {
            return Ok(format);
        }
        match files::extension(path).as_str() {
            "csv" => Ok(Self::Csv),
            "ply" => Ok(Self::Ply),
            "json" => Ok(Self::Json),
            "" => Err(Error::content(path, "the name has no extension", ADVICE)),
            other => Err(Error::content(path, format!("results are not written as `.{other}`"), ADVICE)),
        }
    }
}

const ADVICE: &str = "choose .csv, .ply or .json, or add --format";

/// Writes the table; a file appears whole or not at all. Returns its size in bytes.
pub(crate) fn write(path: &Path, format: Format, table: &dyn Rows) -> Result<u64, Error> {
    files::write(path, |out| match format {
        Format::Csv => csv::write(out, table),
        Format::Ply => ply::write(out, table),
        Format::Json => json::write(out, table),
    })
}
