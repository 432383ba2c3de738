//! `cargo xtask compare`: fits of curves by FITPACK (scipy) beside ours, with the same number of control points.
//!
//! The script `xtask/compare/fitpack.py` fits the clouds of `fixtures/fit-cases` and measures orthogonal distances; `PYTHON` names the
//! interpreter, in which scipy must be installed. `cargo xtask compare readers` compares coordinates of files instead, `cargo xtask compare cad`
//! CAD files, and `cargo xtask compare registration` registrations by `Open3D` beside ours.

mod cad;
mod readers;
mod registration;

use crate::{Failure, workspace};
use nalgebra::SVector;
use pc_io::ReadOptions;
use sdm_fit::curve::{CurveOptions, CurveReport, fit_curve};
use std::process::Command;
use std::time::Instant;

/// What to do where the script does not run.
const INSTALL: &str =
    "install scipy (`python3 -m venv venv && venv/bin/pip install scipy`) and set PYTHON=venv/bin/python";

/// Runs the command.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    if arguments.first().is_some_and(|argument| argument == "readers") && arguments.len() <= 2 {
        return readers::run(arguments.get(1));
    }
    if arguments.first().is_some_and(|argument| argument == "registration") && arguments.len() <= 2 {
        return registration::run(arguments.get(1));
    }
    if arguments == ["cad"] {
        return cad::run();
    }
    if let Some(argument) = arguments.first() {
        return Err(Failure::Usage(format!("`{argument}` is not understood")));
    }
    let theirs = fitpack()?;
    println!(
        "| cloud | control points | FITPACK rms | ours rms | FITPACK s | ours s |\n|---|---|---|---|---|---|"
    );
    for line in theirs.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [name, controls, rms, seconds] = words[..] else {
            return Err(Failure::Failed(format!("the script printed `{line}`, which is not understood")));
        };
        let count = controls.parse().map_err(|_| Failure::Failed(format!("`{controls}` is no number")))?;
        let clock = Instant::now();
        let ours = if name.starts_with("b_") { fitted::<3>(name, count) } else { fitted::<2>(name, count) }?;
        println!(
            "| {name} | {controls} | {rms} | {:.6e} | {seconds} | {:.4} |",
            ours.rms,
            clock.elapsed().as_secs_f64()
        );
    }
    Ok(())
}

fn fitpack() -> Result<String, Failure> {
    let root = workspace::root();
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let mut command = Command::new(&python);
    command.arg(root.join("xtask/compare/fitpack.py")).arg(root.join("fixtures/fit-cases"));
    let output = command.output().map_err(|error| {
        Failure::Failed(format!("{} did not start: {error}; {INSTALL}", python.to_string_lossy()))
    })?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        let last = said.trim_end().lines().last().unwrap_or_default();
        return Err(Failure::Failed(format!("the script failed: {last}; {INSTALL}")));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

fn fitted<const D: usize>(name: &str, controls: usize) -> Result<CurveReport, Failure> {
    let path = workspace::root().join("fixtures/fit-cases").join(name);
    let failed = |error: &dyn std::fmt::Display| Failure::Failed(format!("{name}: {error}"));
    let cloud = pc_io::read_cloud(&path, &ReadOptions::default()).map_err(|error| failed(&error))?.content;
    let points: Vec<SVector<f64, D>> =
        cloud.positions().iter().map(|p| SVector::from_fn(|c, _| p[c])).collect();
    let options = CurveOptions::default().with_controls(Some(controls));
    Ok(fit_curve(&points, None, &options).map_err(|error| failed(&error))?.report)
}
