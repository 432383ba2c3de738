//! Surfaces fitted to a cloud by all error terms, side by side: distances, folds and seconds per iteration.
//!
//! `cargo run --release -p measurements --bin surface_cases -- CLOUD.xyz [CONTROLS_U CONTROLS_V [ITERATIONS [quick]]]`
//!
//! With `quick`, squared distance minimisation only.

use distance_field::ErrorTerm;
use measurements::cases;
use sdm_fit::{BaseShape, NetSize, Smoothing, SurfaceOptions, fit_surface, initial_surface};
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let path = arguments.first().ok_or("name a file of points")?;
    let number = |k: usize, default: usize| arguments.get(k).and_then(|a| a.parse().ok()).unwrap_or(default);
    let (controls, iterations) = ([number(1, 30), number(2, 30)], number(3, 20));
    let points = cases::points::<3>(path)?;
    println!("{path}: {} points, {controls:?} control points", points.len());
    let clock = Instant::now();
    let size = NetSize { controls, ..NetSize::default() };
    let start = initial_surface(&points, BaseShape::Auto, size)?;
    println!("start over a {} in {:.2} s", start.base, clock.elapsed().as_secs_f64());
    let terms = [ErrorTerm::SquaredDistance, ErrorTerm::Tangent, ErrorTerm::Point];
    let terms = if arguments.len() > 4 { &terms[..1] } else { &terms[..] };
    for smoothing in [Smoothing::default(), Smoothing::CONTINUATION] {
        for &term in terms {
            let mut options = SurfaceOptions::default();
            options.fit =
                options.fit.with_term(term).with_smoothing(smoothing).with_max_iterations(iterations);
            let clock = Instant::now();
            let found = fit_surface(&points, start.surface.clone(), &options)?;
            let seconds = clock.elapsed().as_secs_f64();
            let steps = found.report.fit.history.len().max(1) as f64;
            println!(
                "{term:?} {}; λ {:.1e}; {:.3} s per iteration",
                found.report,
                found.report.fit.lambda,
                seconds / steps
            );
            for step in found.report.fit.history.iter().filter(|s| s.iteration <= 3 || s.iteration % 5 == 0) {
                println!("{}", cases::step_line(step));
            }
        }
    }
    Ok(())
}
