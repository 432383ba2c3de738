//! Measures the time of registrations against the goals of the project.
//!
//! ```sh
//! RAYON_NUM_THREADS=1 cargo run --release -p sdm-register --features serde --example cpu_goals [-- clouds]
//! ```
//! An argument chooses the cases whose names contain it.
//!
//! Prints CPU seconds of all (field and registration), of the registration alone, and the ratio of the whole to the goal: below 1
//! it is reached. CPU time is that of all threads of the process, from `/proc` (Linux), in steps of 10 ms; it counts the same
//! whatever else the machine does, but for the caches.

#[path = "../tests/bodies/mod.rs"]
mod bodies;
#[path = "../tests/common/mod.rs"]
mod common;

use bodies::{Bumpy, SixViews};
use common::{Random, distance, model};
use distance_field::{CloudField, DistanceField, SurfaceField};
use footpoint::no_progress;
use nalgebra::{Matrix3, Point3, Vector3};
use nurbs_core::ParametricSurface;
use sdm_register::views::{View, ViewsOptions, register_views};
use sdm_register::{Pose, RegisterOptions, Source, register, rotation};
use std::error::Error;

/// Ticks of the clock in `/proc` per second.
const TICKS: f64 = 100.0;

/// CPU seconds of the process so far; NaN where there is no `/proc`.
fn cpu() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The name of the program, in parentheses, may hold blanks; user and system time are the 12th and 13th number after it.
    let numbers = text.rsplit(')').next().unwrap_or_default().split_whitespace().skip(11).take(2);
    let ticks: Vec<f64> = numbers.filter_map(|number| number.parse().ok()).collect();
    if ticks.len() == 2 { (ticks[0] + ticks[1]) / TICKS } else { f64::NAN }
}

type Outcome = Result<(), Box<dyn Error>>;
/// Runs and prints what is called so.
type Case<'a> = &'a dyn Fn(&str) -> Outcome;

fn main() -> Outcome {
    println!("{:44} {:>8} {:>8} {:>8} {:>6}  result", "case", "seconds", "register", "goal", "ratio");
    let chosen = std::env::args().nth(1).unwrap_or_default();
    let cases: [(&str, Case<'_>); 5] = [
        ("100,000 points, exact surface, noise 1e-3", &|name| surface(name, 100_000, 2.2e-3, 0.77)),
        ("1,000,000 points, exact surface, noise 1e-3", &|name| surface(name, 1_000_000, 2.2e-3, 6.0)),
        ("two clouds of 40,000 points", &|name| clouds(name, 40_000, 0.24)),
        ("six views of 2000 points", &|name| views(name, 2000, 1.0)),
        ("six views of 5000 points", &|name| views(name, 5000, 1.0)),
    ];
    cases.iter().filter(|(name, _)| name.contains(&chosen)).try_for_each(|(name, run)| run(name))
}

fn line(name: &str, all: f64, alone: f64, goal: f64, result: &str) {
    println!("{name:44} {all:8.3} {alone:8.3} {goal:8.2} {:6.2}  {result}", all / goal);
}

fn away(degrees: f64) -> Pose<3> {
    let turn: Matrix3<f64> =
        rotation::exponential::<3>(&(Vector3::new(0.6, -0.64, 0.48) * degrees.to_radians())).0;
    Pose::new(turn, Vector3::new(0.03, -0.02, 0.04))
}

fn surface(name: &str, count: usize, noise: f64, goal: f64) -> Outcome {
    let (surface, mut random) = (model(), Random::new(1));
    let points: Vec<_> = (0..count)
        .map(|_| {
            let x = surface.point(0.03 + 0.94 * random.uniform(), 0.03 + 0.94 * random.uniform());
            away(10.0).apply(&(x + random.vector() * noise))
        })
        .collect();
    let clock = cpu();
    let field = SurfaceField::new(&surface)?;
    let built = cpu() - clock;
    let report = register(&field, &Source::new(&points), &Pose::identity(), &RegisterOptions::default())?;
    let all = cpu() - clock;
    line(name, all, all - built, goal, &report.to_string());
    Ok(())
}

fn clouds(name: &str, count: usize, goal: f64) -> Outcome {
    let mut random = bodies::Random(5);
    let body = Bumpy::new();
    let (target, normals) = body.view(None, count, &mut random);
    let (source, _) = body.view(None, count, &mut random);
    let moved: Vec<_> = source.iter().map(|x| away(10.0).apply(x)).collect();
    let target: Vec<Point3<f64>> = target.into_iter().map(Point3::from).collect();
    for (with, normals) in [("", None), (" with normals", Some(normals.as_slice()))] {
        let clock = cpu();
        let field = CloudField::new(&target, normals)?;
        let built = cpu() - clock;
        let report = register(&field, &Source::new(&moved), &Pose::identity(), &RegisterOptions::default())?;
        let all = cpu() - clock;
        let error = distance(&moved, &report.pose, &away(10.0).inverse()) / field.bounding_box().diagonal();
        line(&format!("{name}{with}"), all, all - built, goal, &format!("{report}, error {error:.1e}"));
    }
    Ok(())
}

fn views(name: &str, count: usize, goal: f64) -> Outcome {
    let six = SixViews::seeing(1.5, count, 0.0, 10f64.to_radians(), 1);
    let views: Vec<View> = six.points.iter().map(|points| View::new(points)).collect();
    let clock = cpu();
    let report = register_views(&views, &six.initial, &ViewsOptions::default(), &no_progress)?;
    let all = cpu() - clock;
    let poses: Vec<Pose<3>> = report.views.iter().map(|view| view.pose).collect();
    line(name, all, all, goal, &format!("{report}, error {:.1e} (goal 5e-6)", six.error(&poses)));
    Ok(())
}
