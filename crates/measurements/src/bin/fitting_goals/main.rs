//! The goals of fitting, and what comes out: curves and surfaces by point, tangent and squared distance minimisation.
//!
//! `cargo run --release -p measurements --bin fitting_goals [-- curves | surfaces]`. Each line names the goal first. The rectangle (a1),
//! the noisy shape (a2), the bean (a3), the curve in space (b) and the trunk of a bunny (c) are in `fixtures/fit-cases`; the vase (d) is
//! made here, so that its true shape is known.

mod curves;
mod surfaces;

use distance_field::ErrorTerm;
use measurements::cases::Outcome;
use sdm_fit::{FitReport, StepControl};

/// What is put side by side; everything else is the same.
const METHODS: [(&str, ErrorTerm, StepControl); 4] = [
    ("PDM", ErrorTerm::Point, StepControl::None),
    ("TDM", ErrorTerm::Tangent, StepControl::None),
    ("TDM + Armijo", ErrorTerm::Tangent, StepControl::Armijo),
    ("SDM", ErrorTerm::SquaredDistance, StepControl::Armijo),
];

fn main() -> Outcome<()> {
    let part = std::env::args().nth(1);
    if part.as_deref() != Some("surfaces") {
        curves::all()?;
    }
    if part.as_deref() != Some("curves") {
        surfaces::all()?;
    }
    Ok(())
}

/// Root mean square distances after some iterations; of the last one where there were less.
fn courses(name: &str, report: &FitReport, shown: &[usize]) -> String {
    let at = |k: usize| report.history.get(k - 1).or(report.history.last()).map_or(f64::NAN, |step| step.rms);
    let cells: Vec<String> = shown.iter().map(|&k| format!("{:>10.2e}", at(k))).collect();
    format!("  {name:13}{}  {} after {}", cells.concat(), report.status, report.history.len())
}

fn header(shown: &[usize]) -> String {
    let cells: Vec<String> = shown.iter().map(|k| format!("{k:>10}")).collect();
    format!("  {:13}{}  end", "iteration", cells.concat())
}

/// Whether a number is what it should be.
fn verdict(what: &str, value: f64, goal: f64) {
    let is = if value <= goal { "reached" } else { "MISSED" };
    println!("  {what}: {value:.3e}, goal {goal:.1e}: {is}");
}
