//! `indgeo convert`: the same points, triangles or shapes in another format.

use super::Outcome;
use crate::error::Error;
use crate::files;
use crate::report::{Input, Output, Report, Results, Timings};
use crate::wording::{counted, not_finite};
use industrial_geometry::io::{Format, ReadOptions, WriteOptions};
use serde::Serialize;
use std::path::PathBuf;

/// Write points, triangles or NURBS in another format
///
/// Normals, colours, intensity, names and other values per point are kept where the format can hold them; what it cannot
/// hold is told.
#[derive(Debug, clap::Args)]
#[command(after_long_help = AFTER_HELP)]
pub(crate) struct Args {
    /// File to read, its format recognised by content first; `-` is standard input
    pub(crate) input: PathBuf,
    /// File to write: .ply, .xyz, .csv, .pts, .obj, .stl, .off, .pcd, or .json for NURBS; `-` is standard output (CSV, OBJ for triangles,
    /// JSON for NURBS)
    pub(crate) output: PathBuf,
    /// Format of OUTPUT, whatever its extension: ply, xyz, csv, pts, obj, stl, off, pcd or json
    #[arg(long, value_name = "FORMAT", value_parser = files::parse_format)]
    format: Option<Format>,
    /// Leave out points with a coordinate that is NaN or infinite, and the triangles that use them
    #[arg(long)]
    drop_non_finite: bool,
    /// Take commas in the numbers of tables as decimal signs, where the file leaves that open
    #[arg(long)]
    decimal_comma: bool,
    /// Write PLY as text instead of binary
    #[arg(long)]
    ascii: bool,
}

const AFTER_HELP: &str = "\
Doubles are written with full precision in every format but binary STL and PCD colours, which are single by definition.

Examples:
  indgeo convert scan.pcd scan.ply
  indgeo convert scan.ply scan.csv --drop-non-finite
  indgeo convert part.stl part.off
  gzip -dc scan.ply.gz | indgeo convert - - --format xyz | head";

/// What was written.
#[derive(Debug, Serialize)]
pub(crate) struct ConvertResults {
    /// Its format, by its usual extension.
    pub(crate) format: &'static str,
    /// Points or vertices.
    pub(crate) points: usize,
    /// Triangles.
    pub(crate) triangles: usize,
    /// Curves and surfaces.
    pub(crate) shapes: usize,
}

/// Runs the command.
pub(crate) fn run(args: &Args, report: &mut Report) -> Result<Outcome, Error> {
    files::check_writable(&args.output, &[&args.input])?;
    let mut timings = Timings::default();
    let options = ReadOptions::default()
        .with_drop_non_finite(args.drop_non_finite)
        .with_decimal_comma(args.decimal_comma);
    let loaded = Timings::measure(&mut timings.read, || files::read(&args.input, &options))?;
    report.add_input(Input::new("file", &args.input, &loaded.report));
    let options = WriteOptions { format: args.format, ascii: args.ascii };
    let written = Timings::measure(&mut timings.write, || {
        files::write_content(&args.output, &loaded.content, &options)
    })?;
    report.timings = timings;
    let all = [(&args.input, &loaded.report.warnings), (&args.output, &written.warnings)];
    for (path, warnings) in all {
        report.warnings.extend(warnings.iter().map(|warning| format!("{}: {warning}", path.display())));
    }
    if loaded.report.non_finite > 0 {
        let fate =
            if loaded.report.dropped > 0 { "left out" } else { "kept (--drop-non-finite leaves them out)" };
        let read = &loaded.report;
        report.warnings.push(not_finite(&args.input, read.non_finite, read.points, fate));
    }
    report.results = Some(Results::Converted(ConvertResults {
        format: written.format.extension(),
        points: written.points,
        triangles: written.triangles,
        shapes: written.shapes,
    }));
    report.add_output(Output {
        path: args.output.clone(),
        bytes: written.bytes,
        content: loaded.content.describe(),
    });
    let summary = format!(
        "{}: {} as {}, {}",
        args.output.display(),
        loaded.content.describe(),
        written.format,
        counted(written.bytes, "byte")
    );
    Ok(Outcome::new(summary, true))
}
