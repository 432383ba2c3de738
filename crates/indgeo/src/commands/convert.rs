//! `indgeo convert`: the same points, triangles or shapes in another format.

use super::Outcome;
use crate::error::Error;
use crate::files;
use crate::report::{Input, Output, Report, Timings};
use industrial_geometry::io::{self, ReadOptions, WriteOptions};
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
    /// File to write: .ply, .xyz, .csv, .pts, .obj, .stl, .off, .pcd, or .json for NURBS
    pub(crate) output: PathBuf,
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
  indgeo convert part.stl part.off";

/// Runs the command.
pub(crate) fn run(args: &Args, report: &mut Report) -> Result<Outcome, Error> {
    files::check_writable(&args.output, &[&args.input])?;
    let mut timings = Timings::default();
    let options = ReadOptions::default()
        .with_drop_non_finite(args.drop_non_finite)
        .with_decimal_comma(args.decimal_comma);
    let loaded = Timings::measure(&mut timings.read, || files::read(&args.input, &options))?;
    report.inputs.push(Input::new("file", &args.input, &loaded.report));
    let options = WriteOptions::default().with_ascii(args.ascii);
    let written =
        Timings::measure(&mut timings.write, || io::write(&args.output, &loaded.content, &options))?;
    report.timings = timings;
    let all = [(&args.input, &loaded.report.warnings), (&args.output, &written.warnings)];
    for (path, warnings) in all {
        report.warnings.extend(warnings.iter().map(|warning| format!("{}: {warning}", path.display())));
    }
    if loaded.report.non_finite > 0 {
        let fate =
            if loaded.report.dropped > 0 { "left out" } else { "kept (--drop-non-finite leaves them out)" };
        report.warnings.push(format!(
            "{}: {} points have a coordinate that is NaN or infinite; they were {fate}",
            args.input.display(),
            loaded.report.non_finite
        ));
    }
    report.outputs.push(Output {
        path: args.output.clone(),
        bytes: written.bytes,
        content: loaded.content.describe(),
    });
    let summary = format!(
        "{}: {} as {}, {} bytes",
        args.output.display(),
        loaded.content.describe(),
        written.format,
        written.bytes
    );
    Ok(Outcome::new(summary, true))
}
