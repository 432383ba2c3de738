//! What a segmentation says to a person.

use super::SegmentationResults;
use crate::report::Report;
use crate::summary::{plain, write_end};
use crate::wording::counted;
use std::fmt::Write;

pub(crate) fn write(text: &mut String, report: &Report, found: &SegmentationResults) -> std::fmt::Result {
    writeln!(
        text,
        "{} in {}, noise {}, spacing {}",
        counted(found.primitives.len(), "region"),
        counted(found.points, "point"),
        plain(found.sigma),
        plain(found.spacing)
    )?;
    for (name, count) in &found.types {
        writeln!(text, "  {name:<9} {count}")?;
    }
    if found.unlabelled > 0 {
        writeln!(text, "  none      {}", counted(found.unlabelled, "point"))?;
    }
    write_end(text, report)
}
