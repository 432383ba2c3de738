//! Measures the coarse start: how often it finds the pose from random positions, how exactly and how fast.
//!
//! ```sh
//! cargo run --release -p measurements --bin coarse_start -- [--trials N] [CASE…]
//! ```
//! A CASE is a folder with `source.ply` and a `case.json` that names the model, the true pose `T_ref` or `T_gt` and the number of
//! points that belong to the model (`core_mask`). Without one the bunny and some synthetic shapes are tried.

mod cases;

use cases::{Case, Generator};
use industrial_geometry::footpoint::no_progress;
use industrial_geometry::register::Pose;
use industrial_geometry::register::start::{
    CoarseStart, OrientedPoints, StartMethod, StartOptions, StartStatus,
};
use std::error::Error;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1).peekable();
    let mut trials = 20;
    if arguments.next_if_eq("--trials").is_some() {
        trials = arguments.next().ok_or("--trials needs a number")?.parse()?;
    }
    let folders: Vec<String> = arguments.collect();
    let cases: Vec<Case> = if folders.is_empty() {
        cases::built_in()?
    } else {
        folders.iter().map(|folder| cases::read(folder.as_ref())).collect::<Result<_, _>>()?
    };
    println!(
        "{:<30} {:>15} {:>6} {:>6} {:>6} {:>9} {:>9} {:>7} {:>7} {:>8}",
        "case", "method", "first", "any", "found", "median", "worst", "rounds", "seconds", "prepare"
    );
    for case in &cases {
        for method in [StartMethod::PrincipalAxes, StartMethod::PointPairs, StartMethod::Automatic] {
            measure(case, method, trials)?;
        }
    }
    Ok(())
}

fn measure(case: &Case, method: StartMethod, trials: usize) -> Result<(), Box<dyn Error>> {
    let options = StartOptions::default().with_method(method);
    let clock = Instant::now();
    let start = CoarseStart::new(&case.model, &options)?;
    let prepare = clock.elapsed().as_secs_f64();
    let mut random = Generator::new(17);
    let (mut first, mut any, mut sure, mut rounds, mut seconds) = (0, 0, 0, 0, 0.0);
    let mut errors = Vec::new();
    for _ in 0..trials {
        let (points, normals, core) = case.cloud(&mut random);
        let motion = random.motion();
        let moved: Vec<_> = points.iter().map(|x| motion.apply(x)).collect();
        let turned: Vec<_> = normals.iter().map(|n| motion.rotate(n)).collect();
        let cloud = OrientedPoints::new(&moved, &turned)?;
        let clock = Instant::now();
        let report = start.search(&cloud, &no_progress)?;
        seconds += clock.elapsed().as_secs_f64();
        rounds += report.rounds;
        sure += usize::from(report.status == StartStatus::Found);
        let error = |pose: &Pose<3>| {
            let sum: f64 = (0..core)
                .map(|i| (pose.apply(&moved[i]) - case.truth.apply(&points[i])).norm_squared())
                .sum();
            (sum / core as f64).sqrt() / case.diameter
        };
        let all: Vec<f64> = report.candidates.iter().map(|candidate| error(&candidate.pose)).collect();
        first += usize::from(all.first().is_some_and(|&e| e < 0.03));
        any += usize::from(all.iter().any(|&e| e < 0.03));
        errors.push(all.first().copied().unwrap_or(f64::INFINITY));
    }
    errors.sort_by(f64::total_cmp);
    println!(
        "{:<30} {:>15} {:>6} {:>6} {:>6} {:>9.2e} {:>9.2e} {:>7.1} {:>7.3} {:>8.3}",
        case.name,
        method.name(),
        format!("{first}/{trials}"),
        format!("{any}/{trials}"),
        format!("{sure}/{trials}"),
        errors[errors.len() / 2],
        errors[errors.len() - 1],
        rounds as f64 / trials as f64,
        seconds / trials as f64,
        prepare
    );
    Ok(())
}
