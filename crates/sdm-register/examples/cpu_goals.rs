//! Measures the time of registrations against the goals of the project.
//!
//! ```sh
//! RAYON_NUM_THREADS=1 cargo run --release -p sdm-register --features serde --example cpu_goals
//! ```
//! Prints seconds of all (field and registration), of the registration alone, and the ratio of the whole to the goal: below 1 it
//! is reached. Run it on one thread, so that wall time is CPU time; the case of a million points is meant for two.

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
use std::time::Instant;

type Outcome = Result<(), Box<dyn Error>>;

fn main() -> Outcome {
    println!("{:44} {:>8} {:>8} {:>8} {:>6}  result", "case", "seconds", "register", "goal", "ratio");
    surface("100,000 points, exact surface, noise 1e-3", 100_000, 2.2e-3, 0.77)?;
    surface("1,000,000 points, exact surface, noise 1e-3", 1_000_000, 2.2e-3, 6.0)?;
    clouds("two clouds of 40,000 points", 40_000, 0.24)?;
    for count in [2000, 5000] {
        views(&format!("six views of {count} points"), count, 1.0)?;
    }
    Ok(())
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
    let clock = Instant::now();
    let field = SurfaceField::new(&surface)?;
    let built = clock.elapsed().as_secs_f64();
    let report = register(&field, &Source::new(&points), &Pose::identity(), &RegisterOptions::default())?;
    let all = clock.elapsed().as_secs_f64();
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
        let clock = Instant::now();
        let field = CloudField::new(&target, normals)?;
        let built = clock.elapsed().as_secs_f64();
        let report = register(&field, &Source::new(&moved), &Pose::identity(), &RegisterOptions::default())?;
        let all = clock.elapsed().as_secs_f64();
        let error = distance(&moved, &report.pose, &away(10.0).inverse()) / field.bounding_box().diagonal();
        line(&format!("{name}{with}"), all, all - built, goal, &format!("{report}, error {error:.1e}"));
    }
    Ok(())
}

fn views(name: &str, count: usize, goal: f64) -> Outcome {
    let six = SixViews::seeing(1.5, count, 0.0, 10f64.to_radians(), 1);
    let views: Vec<View> = six.points.iter().map(|points| View::new(points)).collect();
    let clock = Instant::now();
    let report = register_views(&views, &six.initial, &ViewsOptions::default(), &no_progress)?;
    let all = clock.elapsed().as_secs_f64();
    let poses: Vec<Pose<3>> = report.views.iter().map(|view| view.pose).collect();
    line(name, all, all, goal, &format!("{report}, error {:.1e} (goal 5e-6)", six.error(&poses)));
    Ok(())
}
