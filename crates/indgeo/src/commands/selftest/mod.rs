//! `indgeo selftest`: whether this program computes right on this machine.

pub(crate) mod job;

use self::job::Check;
use crate::common::Common;
use crate::error::Error;
use crate::report::{Outcome, Report, Results, Timings};
use crate::runtime::progress::Progress;
use std::fmt::Write;

/// Solve cases whose answers are known from how they were made, and show how far the results are from these
///
/// Distances with closed forms, points with constructed feet, motions that were applied and must be found again, residuals
/// that leave a pose where it is, statistics counted by hand, files that must come back bit for bit. Takes seconds, needs no
/// files (some are written to the folder for temporary files, and removed).
#[derive(Debug, clap::Args)]
#[command(after_long_help = "\
Every case prints the deviation from its certified answer and the largest one that is allowed, in the units of the case
(shapes are some units in size; counts and bits must agree).
Exit status 0: all deviations are within their bounds; 1: at least one is not; 2: bad usage; 130: interrupted.

Examples:
  indgeo selftest
  indgeo selftest --json -")]
pub(crate) struct Args {}

impl Results for Vec<Check> {}

/// Runs the command.
pub(crate) fn run(common: &Common, report: &mut Report) -> Result<Outcome, Error> {
    let progress = Progress::steps("testing", common.quiet);
    let mut timings = Timings::default();
    let checks = Timings::measure(&mut timings.compute, || {
        job::run(&|done, total| {
            // This never asks to stop.
            let _ = progress.report(done, total);
        })
    });
    drop(progress);
    report.timings = timings;
    let failed = checks.iter().filter(|check| !check.pass).count();
    let summary = table(&checks, failed, timings.compute);
    report.results = Some(Box::new(checks));
    Ok(Outcome { summary, converged: failed == 0, otherwise: "failed" })
}

fn table(checks: &[Check], failed: usize, seconds: f64) -> String {
    let width = |of: fn(&Check) -> &str| checks.iter().map(|c| of(c).chars().count()).max().unwrap_or(0);
    let (case, certified) = (width(|check| check.case), width(|check| check.certified));
    let mut text = format!("{:case$}  {:certified$}  deviation  allowed\n", "case", "certified answer");
    let mut group = "";
    // Writing to memory cannot fail.
    for check in checks {
        if check.group != group {
            group = check.group;
            let _ = writeln!(text, "-- {group}");
        }
        let _ = writeln!(
            text,
            "{:case$}  {:certified$}  {:>9}  {:>7}  {}",
            check.case,
            check.certified,
            number(check.deviation),
            number(check.bound),
            if check.pass { "ok" } else { "FAILED" }
        );
        if let Some(error) = &check.error {
            let _ = writeln!(text, "    {error}");
        }
    }
    let _ = match failed {
        0 => writeln!(text, "all {} cases are within their bounds ({seconds:.1} s)", checks.len()),
        _ => writeln!(text, "{failed} of {} cases FAILED ({seconds:.1} s)", checks.len()),
    };
    text
}

fn number(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{value:.1e}") }
}
