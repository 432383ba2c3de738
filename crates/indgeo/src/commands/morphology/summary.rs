//! The summary of operations on regions.

use super::job::MorphologyResults;
use crate::report::summary::write_end;
use crate::report::wording::counted;
use crate::report::{Report, Results};
use std::fmt::Write;

impl Results for MorphologyResults {
    fn summarise(&self, text: &mut String, report: &Report) -> std::fmt::Result {
        let found = self;
        writeln!(
            text,
            "{} by {} in the {} metric: {}",
            found.operation,
            found.radius,
            found.metric,
            counted(found.regions.len(), "region")
        )?;
        for region in &found.regions {
            writeln!(
                text,
                "  region    {}: {} before, {} after",
                region.label,
                counted(region.vertices_before, "vertex"),
                region.vertices_after
            )?;
        }
        write_end(text, report)
    }
}
