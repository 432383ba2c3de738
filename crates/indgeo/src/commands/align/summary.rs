//! The summary of an alignment by targets.

use super::job::AlignmentResults;
use crate::report::summary::{plain, write_end};
use crate::report::wording::counted;
use crate::report::{Report, Results};
use std::fmt::Write;

/// Targets that are listed with their residuals.
const LISTED_TARGETS: usize = 20;

impl Results for AlignmentResults {
    fn summarise(&self, text: &mut String, report: &Report) -> std::fmt::Result {
        let found = self;
        let surplus = match found.conditions - found.unknowns.min(found.conditions) {
            0 => "exactly determined".to_owned(),
            more => format!("{more} more than needed"),
        };
        writeln!(
            text,
            "{} after {}: {} at {}, {surplus}",
            found.status,
            counted(found.iterations, "step"),
            counted(found.conditions, "direction"),
            counted(found.targets.len(), "point")
        )?;
        write!(text, "  residual  rms {}  max {}", plain(found.rms), plain(found.max))?;
        match (found.tolerance, found.within_tolerance) {
            (Some(tolerance), Some(true)) => writeln!(text, ", within {tolerance}")?,
            (Some(tolerance), _) => writeln!(text, ", not within {tolerance}")?,
            _ => writeln!(text)?,
        }
        let [x, y, z] = found.translation.map(plain);
        writeln!(
            text,
            "  motion    turned by {:.4} degrees, moved by ({x}, {y}, {z})",
            found.rotation.angle.to_degrees()
        )?;
        for (name, target) in found.worst_first().into_iter().take(LISTED_TARGETS) {
            let along: Vec<String> = (target.directions.iter().zip(&target.residuals))
                .map(|([x, y, z], residual)| format!("{} along ({x:.4}, {y:.4}, {z:.4})", plain(*residual)))
                .collect();
            writeln!(text, "  {name}: {}", along.join(", "))?;
        }
        if found.targets.len() > LISTED_TARGETS {
            writeln!(text, "  (the {LISTED_TARGETS} targets with the largest residuals; --json has all)")?;
        }
        write_end(text, report)
    }
}
