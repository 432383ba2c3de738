//! The summary of a command for a person.

use super::wording::counted;
use super::{ModelSummary, Report};
use std::fmt::Write;

impl Report {
    /// The summary of the results; empty where a command has none.
    pub(crate) fn summary(&self) -> String {
        let mut text = String::new();
        if let Some(results) = &self.results {
            // Writing to memory cannot fail.
            let _ = results.summarise(&mut text, self);
        }
        text
    }
}

/// Writes units, times and files, the end of every summary.
pub(crate) fn write_end(text: &mut String, report: &Report) -> std::fmt::Result {
    if let Some(ModelSummary { unit: Some(unit), points_unit: Some(of_points), .. }) = &report.model {
        writeln!(text, "  units     model {unit}; points {of_points}")?;
    }
    let timings = &report.timings;
    if !report.no_timings {
        writeln!(
            text,
            "  seconds   read {:.3}  build {:.3}  compute {:.3}  write {:.3}",
            timings.read, timings.build, timings.compute, timings.write
        )?;
    }
    for output in &report.outputs {
        writeln!(text, "  wrote     {} ({})", output.path.display(), counted(output.bytes, "byte"))?;
    }
    Ok(())
}

/// A name behind what it names.
pub(crate) fn quoted(name: Option<&str>) -> String {
    name.map(|name| format!(" \"{name}\"")).unwrap_or_default()
}

/// A number with six decimals, or with an exponent where these would hide it.
pub(crate) fn plain(value: f64) -> String {
    let size = value.abs();
    if size >= 1e9 || (size < 1e-3 && size > 0.0) { format!("{value:.6e}") } else { format!("{value:.6}") }
}
