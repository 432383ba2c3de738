//! Writing a report: for a person, and as JSON.

use super::{Outcome, Report};
use crate::common::Common;
use crate::error::Error;
use crate::files;
use industrial_geometry::io::AtomicFile;
use std::io::Write;
use std::path::Path;

/// Prints warnings and the summary. A broken pipe is not an error.
///
/// `is_taken` says that a result was written to standard output, where nothing else may stand then.
///
/// # Errors
/// If standard output cannot be written for another reason, such as a full disk.
pub(crate) fn print(
    common: &Common,
    is_taken: bool,
    outcome: &Outcome,
    warnings: &[String],
) -> Result<(), Error> {
    if common.quiet {
        return Ok(());
    }
    let mut stderr = std::io::stderr().lock();
    for warning in warnings {
        let _ = writeln!(stderr, "warning: {warning}");
    }
    if !is_taken && !common.json.as_deref().is_some_and(files::is_stream) {
        let mut stdout = std::io::stdout().lock();
        let written = writeln!(stdout, "{}", outcome.summary.trim_end()).and_then(|()| stdout.flush());
        if let Err(source) = written
            && source.kind() != std::io::ErrorKind::BrokenPipe
        {
            return Err(Error::write(Path::new("standard output"), source));
        }
    }
    Ok(())
}

/// Writes the report to a file or, called `-`, to standard output.
pub(crate) fn write_report(path: &Path, report: &Report) -> Result<(), Error> {
    let failed = |source: std::io::Error| Error::write(path, source);
    let mut text = serde_json::to_string_pretty(report).map_err(|error| failed(error.into()))?;
    text.push('\n');
    if files::is_stream(path) {
        return std::io::stdout().write_all(text.as_bytes()).map_err(failed);
    }
    let mut file = AtomicFile::create(path)?;
    file.write_all(text.as_bytes()).map_err(failed)?;
    file.commit()?;
    Ok(())
}
