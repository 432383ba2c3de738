//! Lines about a fitted surface that several commands print.

use super::numbers::FitNumbers;
use crate::report::summary::plain;
use crate::report::wording::counted;
use industrial_geometry::fit::{Folds, SurfaceCoverage};
use industrial_geometry::inspection::{Rounding, percent_of_share};
use std::fmt::Write;

pub(crate) fn write_coverage(text: &mut String, coverage: Option<&SurfaceCoverage>) -> std::fmt::Result {
    let Some(found) = coverage else { return Ok(()) };
    writeln!(
        text,
        "  surface   to the points: rms {}  max {} ({:.1} spacings)",
        plain(found.rms),
        plain(found.max),
        found.max_in_spacings
    )?;
    let without = found.area_without_data;
    if without > 0.0 {
        let share = percent_of_share(without / found.area, Rounding::Up);
        writeln!(text, "  area      {}, {share} of it without data", plain(found.area))
    } else {
        writeln!(text, "  area      {}, none of it without data", plain(found.area))
    }
}

pub(crate) fn write_distances(text: &mut String, fit: &FitNumbers) -> std::fmt::Result {
    writeln!(text, "  distance  rms {}  max {}", plain(fit.rms), plain(fit.max))?;
    if let (Some(share), Some(holds)) = (fit.share_within, fit.within_tolerance) {
        let verdict = if holds { "reached" } else { "NOT reached" };
        let share = percent_of_share(share, Rounding::Down);
        writeln!(text, "  tolerance {verdict}: {share} of the points within")?;
    }
    Ok(())
}

pub(crate) fn write_folds(text: &mut String, folds: &Folds) -> std::fmt::Result {
    match folds.count() {
        0 => Ok(()),
        count => writeln!(text, "  folds     in {count} of {}", counted(folds.cells, "cell")),
    }
}
