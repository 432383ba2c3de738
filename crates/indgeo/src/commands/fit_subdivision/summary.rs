//! The summary of a fit of a subdivision surface.

use super::job::SubdivisionResults;
use crate::fits::summary::{write_coverage, write_distances};
use crate::report::summary::write_end;
use crate::report::wording::counted;
use crate::report::{Report, Results};
use std::fmt::Write;

impl Results for SubdivisionResults {
    fn summarise(&self, text: &mut String, report: &Report) -> std::fmt::Result {
        let found = self;
        writeln!(
            text,
            "control mesh of {} vertices ({} irregular) and {} triangles, {}, after {} ({})",
            found.vertices,
            found.irregular,
            found.triangles,
            found.start,
            counted(found.fit.iterations, "iteration"),
            found.fit.status
        )?;
        write_distances(text, &found.fit)?;
        write_coverage(text, found.coverage.as_ref())?;
        match found.folded_edges.limit {
            0 => {}
            count => writeln!(text, "  folds     at {} of the limit surface", counted(count, "edge"))?,
        }
        write_end(text, report)
    }
}
