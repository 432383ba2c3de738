//! The two large fits that the crate is measured by, from a cloud without parameters to the surface.
//!
//! `cargo run --release -p measurements --bin large_surfaces [-- sheet|tube]`
//!
//! - `sheet`: 64,000 noisy points of an open wavy sheet, 55 × 55 control points; goal 3 s on two cores.
//! - `tube`: 1,000,000 noisy points of a lobed tube, 100 × 100 control points, closed in u; goal 60 s and 4 GB on two cores.
//!
//! Prints the time of the whole fit by the clock and of all threads (CPU), the largest memory of the process so far, iterations,
//! and the distances. The CPU time counts the same whatever else the machine does, but for the caches; both it and the memory
//! come from `/proc` (Linux).

use measurements::cases::{cpu, step_line};
use nalgebra::Vector3;
use sdm_fit::{NetSize, SurfaceOptions, fit_cloud};
use std::f64::consts::TAU;
use std::time::Instant;

/// Standard deviation of the noise.
const NOISE: f64 = 0.002;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let asked = std::env::args().nth(1);
    let wants = |name: &str| asked.as_deref().is_none_or(|a| a == name);
    if wants("sheet") {
        fit("sheet", &cloud(64_000, sheet), [55, 55], 3.0)?;
    }
    if wants("tube") {
        fit("tube", &cloud(1_000_000, tube), [100, 100], 60.0)?;
    }
    Ok(())
}

fn fit(
    name: &str,
    points: &[Vector3<f64>],
    controls: [usize; 2],
    goal: f64,
) -> Result<(), Box<dyn std::error::Error>> {
    let options = SurfaceOptions::default().with_size(NetSize { controls, ..NetSize::default() });
    let (clock, before) = (Instant::now(), cpu());
    let found = fit_cloud(points, &options)?;
    let (seconds, used) = (clock.elapsed().as_secs_f64(), cpu() - before);
    let base = found.report.base.map_or_else(String::new, |base| format!(" over a {base}"));
    println!("{name}: {} points{base}", points.len());
    println!("    {} (noise {NOISE})", found.report);
    println!("    {seconds:.2} s by the clock, {used:.2} s of CPU, goal {goal} s; {:.2} GB", peak());
    for step in &found.report.fit.history {
        println!("{}", step_line(step));
    }
    Ok(())
}

/// Points of a surface given over the unit square, in no order, with noise.
fn cloud(count: usize, surface: impl Fn(f64, f64) -> Vector3<f64>) -> Vec<Vector3<f64>> {
    let mut noise = Noise(11);
    let mut point = || {
        let (s, t) = (noise.uniform(), noise.uniform());
        surface(s, t) + Vector3::from_fn(|_, _| NOISE * noise.normal())
    };
    (0..count).map(|_| point()).collect()
}

fn sheet(s: f64, t: f64) -> Vector3<f64> {
    let (x, y) = (10.0 * s, 8.0 * t);
    Vector3::new(x, y, 0.5 * (1.3 * x + 0.4 * y).sin() + 0.4 * (1.7 * y).cos() + 0.05 * (4.0 * x).sin())
}

fn tube(s: f64, t: f64) -> Vector3<f64> {
    let a = TAU * s;
    let r = 2.0 + 0.3 * (3.0 * a).sin() * t + 0.2 * (9.0 * t).cos() + 0.02 * (12.0 * a + 20.0 * t).sin();
    Vector3::new(r * a.cos(), r * a.sin(), 12.0 * t)
}

/// Pseudorandom numbers, the same everywhere.
struct Noise(u64);

impl Noise {
    /// Uniform in `[0, 1)`.
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / (1u64 << 31) as f64
    }

    /// Approximately normally distributed with variance 1.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// Largest resident memory of the process so far in GB; NaN where there is no `/proc`.
fn peak() -> f64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
    kilobytes.map_or(f64::NAN, |k| k / 1e6)
}
