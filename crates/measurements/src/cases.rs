//! Clouds and starts of `fixtures/fit-cases`, lines of a history, the time of the processor.

use nalgebra::{SVector, Vector2};
use nurbs_core::{BsplineCurve, KnotVector};
use sdm_fit::FitStep;
use std::error::Error;

/// Ticks of the clock in `/proc` per second.
const TICKS: f64 = 100.0;

/// What may fail in a program.
pub type Outcome<T> = Result<T, Box<dyn Error>>;

fn text(path: &str) -> Outcome<String> {
    Ok(std::fs::read_to_string(path).map_err(|error| format!("{path}: {error}"))?)
}

/// The path of a file below `fixtures`.
pub fn fixture(name: &str) -> String {
    format!("{}/../../fixtures/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// Points of a text file, the first columns of each line.
pub fn points<const D: usize>(path: &str) -> Outcome<Vec<SVector<f64, D>>> {
    let line = |line: &str| -> Outcome<SVector<f64, D>> {
        let values = line.split_whitespace().take(D).map(str::parse).collect::<Result<Vec<f64>, _>>()?;
        if values.len() < D {
            return Err(format!("{path}: `{line}` has less than {D} columns").into());
        }
        Ok(SVector::from_column_slice(&values))
    };
    text(path)?.lines().filter(|l| !l.trim().is_empty()).map(line).collect()
}

/// A curve to start from.
pub fn start(path: &str) -> Outcome<BsplineCurve<2>> {
    let value: serde_json::Value = serde_json::from_str(&text(path)?)?;
    let knots: Vec<f64> = serde_json::from_value(value["knots"].clone())?;
    let net: Vec<[f64; 2]> = serde_json::from_value(value["control_points"].clone())?;
    let net = net.into_iter().map(Vector2::from).collect();
    Ok(BsplineCurve::new(KnotVector::periodic(3, knots)?, net, None)?)
}

/// One iteration in a line.
pub fn step_line(step: &FitStep) -> String {
    format!(
        "    {:3} λ {:.1e} rms {:.6} max {:.4} cost {:.4e} moved {:.1e} factor {:.3} feet found {}",
        step.iteration,
        step.lambda,
        step.rms,
        step.max,
        step.cost,
        step.displacement,
        step.factor,
        step.evaluations
    )
}

/// CPU seconds of the process so far; NaN where there is no `/proc`.
pub fn cpu() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The name of the program, in parentheses, may hold blanks; user and system time are the 12th and 13th number after it.
    let numbers = text.rsplit(')').next().unwrap_or_default().split_whitespace().skip(11).take(2);
    let ticks: Vec<f64> = numbers.filter_map(|number| number.parse().ok()).collect();
    if ticks.len() == 2 { (ticks[0] + ticks[1]) / TICKS } else { f64::NAN }
}
