//! A cloud from parameters to a fitted surface, with what each step achieves and how long it takes:
//! `cargo run --release -p measurements --bin pipeline -- POINTS.xyz [N_U N_V] [SHAPE]`.

use cloud_param::{
    FitOptions, ParameteriseOptions, Shape, SurfaceDefects, finish_fit, finish_options, fit_parameters,
    parameterise,
};
use nalgebra::Vector3;
use std::error::Error;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let path = arguments.first().ok_or("give a file of points")?;
    let number = |k: usize| arguments.get(k).and_then(|a| a.parse().ok()).unwrap_or(30);
    let shape = match arguments.last().map(String::as_str) {
        Some("cylinder") => Shape::Cylinder,
        Some("plane") => Shape::Plane,
        Some("sphere") => Shape::Sphere,
        _ => Shape::Auto,
    };
    let text = std::fs::read_to_string(path)?;
    let row = |line: &str| -> Option<Vector3<f64>> {
        let mut numbers = line.split([' ', ',', '\t']).filter(|w| !w.is_empty()).map(|w| w.parse().ok());
        Some(Vector3::new(numbers.next()??, numbers.next()??, numbers.next()??))
    };
    let points: Vec<Vector3<f64>> = text.lines().filter_map(row).collect();
    let began = Instant::now();
    let found = parameterise(&points, &ParameteriseOptions::default().with_shape(shape))?;
    let seconds = began.elapsed().as_secs_f64();
    let r = &found.report;
    println!(
        "{r}\n  {:.2} s: {:?}",
        seconds,
        r.times.iter().map(|t| (t.stage.name(), (t.seconds * 1e3).round())).collect::<Vec<_>>()
    );
    println!("  shape: {:?}", r.shape);
    println!(
        "  axis {:?} {:?} coverage {:.3} normals along {:.3}",
        r.axis.origin,
        r.axis.direction.as_slice(),
        r.axis.coverage.mean(),
        r.axis.normals_along
    );
    println!(
        "  views {} seen {:.4} layers {:?} radial {} strays {} beyond {} unique {:.4} unsupported {:.4} spacing {:.4} max {:.4}",
        r.views,
        r.seen,
        r.layers,
        r.radial_layers,
        r.strays,
        r.beyond_ends,
        r.unique,
        r.unsupported,
        r.spacing,
        r.max
    );
    for step in &r.curve_history {
        println!("  curves  rms {:.5} samples {} loops {}", step.rms, step.samples, step.self_loops);
    }
    for step in &r.refine_history {
        println!("  surface rms {:.5} {:?}", step.rms, step.defects);
    }
    let began = Instant::now();
    let options = FitOptions { control_points: [number(1), number(2)], ..FitOptions::default() };
    let fit = fit_parameters(&points, &found.base, &found.feet, &found.counts, &options)?;
    println!(
        "  fit {:?}: rms {:?} max {:.4}, {} points, {:.2} s, {:?}",
        options.control_points,
        fit.history,
        fit.max,
        fit.used,
        began.elapsed().as_secs_f64(),
        SurfaceDefects::of(&fit.surface, None)
    );
    let began = Instant::now();
    let (done, report) = finish_fit(&points, &found.counts, fit, &finish_options(points.len()))?;
    println!(
        "  sdm {}: rms {:.5?} {:?}, max {:.4}, moved back {:.4}, {:.2} s: {}",
        report.outcome.name(),
        report.rms,
        report.defects,
        done.max,
        report.moved_back,
        began.elapsed().as_secs_f64(),
        report.minimisation
    );
    for step in &report.minimisation.fit.history {
        println!(
            "    {} λ {:.1e} rms {:.5} cost {:.4e} moved {:.1e} factor {} feet {}",
            step.iteration,
            step.lambda,
            step.rms,
            step.cost,
            step.displacement,
            step.factor,
            step.evaluations
        );
    }
    Ok(())
}
