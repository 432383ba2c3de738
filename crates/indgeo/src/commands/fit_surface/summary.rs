//! The summary of a fit of a surface.

use super::job::SurfaceResults;
use crate::fits::summary::{write_coverage, write_distances, write_folds};
use crate::report::summary::{plain, write_end};
use crate::report::wording::counted;
use crate::report::{Report, Results};
use std::fmt::Write;

impl Results for SurfaceResults {
    fn summarise(&self, text: &mut String, report: &Report) -> std::fmt::Result {
        let results = self;
        let fit = &results.fit;
        let insertions = results.runs.saturating_sub(1);
        writeln!(
            text,
            "{} × {} control points after {} ({}), {}",
            results.control_points[0],
            results.control_points[1],
            counted(fit.iterations, "iteration"),
            fit.status,
            counted(insertions, "change of the knots")
        )?;
        let start = results.base.map_or("the surface given", |base| base.name());
        match &results.start {
            Some(from) => writeln!(text, "  start     {start}: {}", from.why)?,
            None => writeln!(text, "  start     {start}")?,
        }
        if let Some((base, least_squares)) =
            results.start.as_ref().and_then(|from| from.base_rms.zip(from.least_squares_rms))
        {
            writeln!(
                text,
                "            rms {} from the base surface, {} from the least squares surface",
                plain(base),
                plain(least_squares)
            )?;
        }
        write_distances(text, fit)?;
        write_coverage(text, results.coverage.as_ref())?;
        if let Some(edges) = &results.edges {
            if let Some(gap) = edges.boundary_gap {
                writeln!(text, "  boundary  up to {} from the curves", plain(gap))?;
            }
            for join in &edges.joins {
                writeln!(
                    text,
                    "  joined    {}: gap {}, angle {} rad, at {}",
                    join.file.display(),
                    plain(join.gap),
                    plain(join.angle),
                    join.side
                )?;
            }
        }
        write_folds(text, &results.folds)?;
        write_end(text, report)
    }
}
