//! The summary of a fit of a ruled surface.

use super::job::RuledResults;
use crate::fits::summary::{write_coverage, write_distances, write_folds};
use crate::report::summary::write_end;
use crate::report::wording::counted;
use crate::report::{Report, Results};
use std::fmt::Write;

impl Results for RuledResults {
    fn summarise(&self, text: &mut String, report: &Report) -> std::fmt::Result {
        let found = self;
        let (fit, [along, sections]) = (&found.fit, found.control_points);
        writeln!(
            text,
            "{sections} sections of {along} control points after {} ({}), {} fitted",
            counted(fit.iterations, "iteration"),
            fit.status,
            counted(found.runs, "surface")
        )?;
        writeln!(text, "  start     {}", found.base.map_or("the surface given", |base| base.name()))?;
        write_distances(text, fit)?;
        write_coverage(text, found.coverage.as_ref())?;
        writeln!(text, "  rulings   {}", found.developability)?;
        write_folds(text, &found.folds)?;
        write_end(text, report)
    }
}
