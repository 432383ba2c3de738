//! The summary of an inspection.

use super::job::InspectionResults;
use crate::report::summary::{plain, quoted, write_end};
use crate::report::wording::counted;
use crate::report::{Report, Results};
use industrial_geometry::inspection::{
    Inspection, Outcome, PartDeviations, Rounding, Tolerance, percent, percent_in_full,
};
use std::fmt::Write;

/// Parts that are listed at most.
const PARTS: usize = 20;

impl Results for InspectionResults {
    fn summarise(&self, text: &mut String, report: &Report) -> std::fmt::Result {
        write_inspection(text, report, &self.found)
    }
}

/// Writes the verdict, the counts and the distribution of an inspection.
pub(crate) fn write_inspection(text: &mut String, report: &Report, found: &Inspection) -> std::fmt::Result {
    let verdict = &found.verdict;
    let Tolerance { lower, upper } = found.options.tolerance;
    writeln!(
        text,
        "{}: {} of {} within {lower} to {upper} ({}, at least {} asked for)",
        if verdict.pass { "PASS" } else { "FAIL" },
        verdict.within,
        counted(verdict.judged, "point"),
        percent(verdict.within, verdict.judged, Rounding::Down),
        percent_in_full(verdict.min_share)
    )?;
    let total = &found.total;
    writeln!(
        text,
        "  points    {} measured: {} within, {} over, {} under",
        total.count, total.within, total.over, total.under
    )?;
    let listed = |judged: bool| {
        let chosen = Outcome::ALL.iter().filter(|o| **o != Outcome::Measured && o.is_judged() == judged);
        let counts = chosen.map(|outcome| (outcome.name(), found.outcomes.get(outcome.name())));
        let counts = counts.filter_map(|(name, count)| Some((name, count.filter(|count| **count > 0)?)));
        counts.map(|(name, count)| format!("{count} {name}")).collect::<Vec<String>>().join(", ")
    };
    for (label, counts) in [("not within", listed(true)), ("not used ", listed(false))] {
        if !counts.is_empty() {
            writeln!(text, "  {label} {counts}")?;
        }
    }
    if found.restricted > 0 {
        writeln!(
            text,
            "  normals   {} points are measured on a face that is not the nearest",
            found.restricted
        )?;
    }
    if let Some(distance) = &total.distance {
        let [min, max, mean] = [distance.min, distance.max, distance.mean].map(plain);
        let [rms, sigma] = [distance.rms, distance.standard_deviation].map(plain);
        writeln!(text, "  deviation min {min}  max {max}  mean {mean}  rms {rms}  sigma {sigma}")?;
    }
    if let Some(worst) = found.worst.first() {
        let name = quoted(worst.name.as_deref());
        writeln!(text, "  worst     {} at point {} (from 0){name}", plain(worst.distance), worst.index)?;
    }
    write_parts(text, found)?;
    write_end(text, report)
}

/// One line for each part of a CAD model that has several; of many parts those that are worst.
fn write_parts(text: &mut String, found: &Inspection) -> std::fmt::Result {
    let mut parts: Vec<_> = found.parts.iter().collect();
    if parts.len() < 2 {
        return Ok(());
    }
    let out = |part: &PartDeviations| part.deviations.over + part.deviations.under;
    parts.sort_by(|a, b| out(b).cmp(&out(a)).then(a.index.cmp(&b.index)));
    for part in parts.iter().take(PARTS) {
        let Some(distance) = &part.deviations.distance else { continue };
        let size = distance.max.abs().max(distance.min.abs());
        writeln!(
            text,
            "  part      {} \"{}\": {}, rms {}, max {}, {} out",
            part.index,
            part.name,
            counted(part.deviations.count, "point"),
            plain(distance.rms),
            plain(size),
            percent(out(part), part.deviations.count, Rounding::Up)
        )?;
    }
    match parts.len().saturating_sub(PARTS) {
        0 => Ok(()),
        more => writeln!(text, "  parts     {more} more, with fewer points out of tolerance"),
    }
}
