//! What the user should know of points that could not be judged by a measured deviation.

use super::Job;
use crate::report::Report;
use industrial_geometry::inspection::{Inspection, Outcome};

impl Job<'_> {
    /// What the cloud is called: its file, or the first of its files and how many more there are.
    pub(super) fn cloud(&self) -> String {
        let first = self.points.iter().min();
        let name = first.map(|path| path.display().to_string()).unwrap_or_default();
        match self.points.len() {
            0 | 1 => name,
            2 => format!("{name} and 1 more file"),
            count => format!("{name} and {} more files", count - 1),
        }
    }
}

/// Says what a verdict rests on where that is less than a measured deviation per point.
pub(super) fn warn_of_unproven(report: &mut Report, job: &Job<'_>, found: &Inspection) {
    let count = |outcome: Outcome| found.outcomes.get(outcome.name()).copied().unwrap_or(0);
    let (points, path) = (found.points, job.cloud());
    let mut warn = |count: u64, text: &str| {
        if count > 0 {
            report.warnings.push(format!("{path}: {count} of {points} points {text}"));
        }
    };
    warn(
        count(Outcome::NoNormal),
        "have a normal that is zero or not finite (no_normal); they are counted, not judged",
    );
    warn(
        count(Outcome::NoMatchingFoot),
        "have no foot on the model with a normal that agrees (no_matching_foot); they count as out of tolerance",
    );
    warn(
        count(Outcome::Undecided),
        "are undecided: what is proven about their deviations reaches across a limit; they count as not within",
    );
    warn(count(Outcome::NotConverged), "have no footpoint (not_converged); they count as out of tolerance");
    let turned = found.restricted + count(Outcome::NoMatchingFoot);
    if 2 * turned > found.verdict.judged {
        warn(
            turned,
            "have normals that point away from that of the nearest place of the model; turn them if they point inwards, or \
             give --max-angle 180 if their sides mean nothing",
        );
    }
}
