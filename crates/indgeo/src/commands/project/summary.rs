//! The summary of a projection.

use super::results::ProjectionResults;
use crate::report::summary::{plain, quoted, write_end};
use crate::report::wording::counted;
use crate::report::{Report, Results};
use industrial_geometry::inspection::{Rounding, percent};
use std::fmt::Write;

impl Results for ProjectionResults {
    fn summarise(&self, text: &mut String, report: &Report) -> std::fmt::Result {
        let results = self;
        if let Some(model) = &report.model {
            let piece = match model.kind {
                "mesh" => "triangle",
                "cad" => "face",
                "level_set" => "crossing",
                _ => "Bézier piece",
            };
            writeln!(
                text,
                "{} projected onto {} ({})",
                counted(results.points, "point"),
                counted(model.shapes, "shape"),
                counted(model.patches, piece)
            )?;
        }
        let counts = |counts: Vec<(&str, usize)>| {
            let parts: Vec<String> = counts.iter().map(|(name, count)| format!("{count} {name}")).collect();
            parts.join(", ")
        };
        writeln!(
            text,
            "  status    {}",
            counts(results.status.iter().map(|(&name, &n)| (name, n)).collect())
        )?;
        if let Some(distance) = &results.distance {
            let [min, max] = [distance.min, distance.max].map(plain);
            let [mean, rms] = [distance.mean, distance.rms].map(plain);
            let median = plain(distance.quantile(0.5).unwrap_or(f64::NAN));
            writeln!(text, "  distance  min {min}  max {max}  mean {mean}  rms {rms}  median {median}")?;
        }
        if let Some(worst) = &results.worst {
            let name = quoted(worst.name.as_deref());
            writeln!(text, "  worst     {} at point {} (from 0){name}", plain(worst.distance), worst.index)?;
        }
        if let Some(gap) = results.largest_gap {
            let wide = results.wide_gaps.map_or_else(String::new, |wide| {
                let share = percent(wide as u64, results.points as u64, Rounding::Up);
                format!("; by more than 1e-7 of its diagonal at {wide} points ({share})")
            });
            writeln!(text, "  certified no point of the model is nearer by more than {gap:.1e}{wide}")?;
        } else if report.model.as_ref().is_some_and(|model| model.kind != "mesh") {
            let mode = report.options.as_ref().map_or("", |options| options.mode);
            let what = match mode {
                "certified" => "each foot is found from the crossings next to its point",
                "local" => "each foot is the local minimum next to a nearby sample",
                _ => "each foot is the best of several local minima",
            };
            writeln!(text, "  proven    none: in mode {mode} {what}; another point may be nearer")?;
        }
        write_end(text, report)
    }
}
