//! The summary of a fit of curves.

use super::results::CurveResults;
use crate::report::summary::{plain, write_end};
use crate::report::wording::counted;
use crate::report::{Report, Results};
use industrial_geometry::fit::CurveCoverage;
use industrial_geometry::inspection::{Rounding, percent_of_share};
use std::fmt::Write;

impl Results for CurveResults {
    fn summarise(&self, text: &mut String, report: &Report) -> std::fmt::Result {
        let (found, parts) = (&self.fitted, self.parts.len());
        let kind = if found.closed { "closed" } else { "open" };
        let kind = if parts > 1 { format!("{parts} curves") } else { format!("{kind} curve") };
        writeln!(
            text,
            "{kind} of degree {} with {} after {} ({})",
            found.degree,
            counted(found.controls, "control point"),
            counted(found.iterations, "iteration"),
            found.status
        )?;
        writeln!(
            text,
            "  distance  rms {}  max {} at point {} (from 0)",
            plain(found.rms),
            plain(found.max),
            found.max_index
        )?;
        write_curve_coverage(text, &found.coverage)?;
        if found.used + found.dropped < found.points {
            writeln!(text, "  left out  {}", counted(found.points - found.dropped - found.used, "outlier"))?;
        }
        if let (Some(share), Some(reached)) = (found.share_within, found.reached) {
            let verdict = if reached { "reached" } else { "NOT reached" };
            let share = percent_of_share(share, Rounding::Down);
            writeln!(text, "  tolerance {verdict}: {share} of the points within")?;
        }
        for join in &self.joins {
            writeln!(
                text,
                "  joined    {}: gap {}, angle {} rad",
                join.file.display(),
                plain(join.gap),
                plain(join.angle)
            )?;
        }
        if !found.crossings.is_empty() {
            writeln!(text, "  crossings {} (the curve crosses itself)", found.crossings.len())?;
        }
        write_end(text, report)
    }
}

fn write_curve_coverage(text: &mut String, found: &CurveCoverage) -> std::fmt::Result {
    writeln!(
        text,
        "  curve     to the points: rms {}  max {} ({:.1} spacings)",
        plain(found.rms),
        plain(found.max),
        found.max_in_spacings
    )?;
    if found.is_complete() {
        return writeln!(text, "  length    {}, none of it without data", plain(found.length));
    }
    let share = percent_of_share(found.length_without_data / found.length, Rounding::Up);
    writeln!(text, "  length    {}, {share} of it without data", plain(found.length))
}
