//! The summary of a registration.

use super::results::RegistrationResults;
use crate::commands::inspect::summary::write_inspection;
use crate::report::summary::{plain, write_end};
use crate::report::wording::counted;
use crate::report::{Report, Results};
use industrial_geometry::inspection::{Rounding, percent_of_share};
use std::fmt::Write;

impl Results for RegistrationResults {
    fn summarise(&self, text: &mut String, report: &Report) -> std::fmt::Result {
        let found = self;
        let motion = &found.transform;
        writeln!(
            text,
            "{} after {}: {} of {} used",
            motion.status,
            counted(motion.iterations, "step"),
            motion.points_used,
            counted(motion.points, "point")
        )?;
        writeln!(
            text,
            "  distance  rms {}  (at the start {})",
            plain(motion.rms),
            plain(motion.initial_rms)
        )?;
        let [x, y, z] = motion.translation.map(plain);
        writeln!(
            text,
            "  motion    turned by {:.4} degrees, moved by ({x}, {y}, {z})",
            motion.rotation.angle.to_degrees()
        )?;
        if motion.scale != 1.0 {
            writeln!(text, "  scale     {}", motion.scale)?;
        }
        for free in &motion.free_motions {
            writeln!(text, "  not fixed {free}")?;
        }
        let chosen = &found.starts[found.best_start];
        writeln!(
            text,
            "  start     {} of {} ({}), {} of the points near the model",
            found.best_start + 1,
            found.starts.len(),
            chosen.origin,
            percent_of_share(chosen.share_near, Rounding::Down)
        )?;
        if let Some(inspection) = &found.inspection {
            return write_inspection(text, report, &inspection.found);
        }
        write_end(text, report)
    }
}
