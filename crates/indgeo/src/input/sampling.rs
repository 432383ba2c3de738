//! Clouds of which fits and registrations use a part, because they are too large.

use crate::error::Error;
use crate::files;
use crate::report::Report;
use crate::runtime::memory;
use industrial_geometry::io::{self, Content, Loaded, ReadOptions};
use std::path::Path;

/// Most points that are used, if nothing else is said.
pub(crate) const MOST: u32 = 4_000_000;

/// Reads a file of points; of one that holds more than `most` and can be read piece by piece an even sample, the same every time,
/// which a warning states.
pub(crate) fn read(path: &Path, most: u32, report: &mut Report) -> Result<Loaded<Content>, Error> {
    let options = ReadOptions::default();
    let is_file = !files::is_stream(path) && !memory::is_memory(path);
    let sample = if is_file { io::read_sample(path, &options, most as usize)? } else { None };
    let Some(sample) = sample else { return files::read(path, &options) };
    report.warnings.push(format!(
        "{}: of {} points an even sample of {most} is used, and what is said holds for these (--sample)",
        path.display(),
        sample.report.points
    ));
    Ok(sample)
}
