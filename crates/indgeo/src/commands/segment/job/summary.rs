//! The summary of a segmentation.

use super::SegmentationResults;
use crate::report::summary::{plain, write_end};
use crate::report::wording::counted;
use crate::report::{Report, Results};
use std::fmt::Write;

impl Results for SegmentationResults {
    fn summarise(&self, text: &mut String, report: &Report) -> std::fmt::Result {
        let found = self;
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
}
