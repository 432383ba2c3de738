//! Measures the registration of six views of one body.
//!
//! ```sh
//! RAYON_NUM_THREADS=1 cargo run --release -p measurements --bin many_views -- [--given]
//! ```
//! With `--given` only the runs from given initial poses. The body is a smooth closed surface given by a formula; the views have no point in common, and overlap by some 40 % with each neighbour, and are displaced by 5 to 10
//! degrees and 2 % of the diameter. Errors are root mean square distances from the true place over all points, in diameters.

#[path = "../../../sdm-register/tests/all/bodies/mod.rs"]
mod bodies;

use bodies::SixViews;
use footpoint::no_progress;
use sdm_register::Pose;
use sdm_register::views::{View, ViewsOptions, register_views, register_views_from};
use std::time::Instant;

fn main() -> Result<(), sdm_register::Error> {
    let with_search = !std::env::args().any(|argument| argument == "--given");
    println!(
        "{:>7} {:>8} {:>8} {:>8} {:>10} {:>10} {:>6} {:>8}  status",
        "points", "noise", "degrees", "start", "before", "after", "steps", "seconds"
    );
    for (count, noise, degrees) in [
        (2000, 0.0, 5.0),
        (5000, 0.0, 5.0),
        (5000, 0.0, 10.0),
        (10_000, 0.0, 10.0),
        (20_000, 0.0, 10.0),
        (5000, 1e-4, 10.0),
        (5000, 1e-3, 10.0),
    ] {
        let six = SixViews::seeing(1.5, count, noise, f64::to_radians(degrees), 1);
        for normals in [false, true] {
            let mut views = Vec::new();
            for (points, given) in six.points.iter().zip(&six.normals) {
                views.push(if normals { View::with_normals(points, given)? } else { View::new(points) });
            }
            let options = ViewsOptions::default().with_oriented(normals);
            for start in [true, false].into_iter().filter(|&start| start || with_search) {
                let clock = Instant::now();
                let report = if start {
                    register_views(&views, &six.initial, &options, &no_progress)?
                } else {
                    register_views_from(&views, &options, &no_progress)?
                };
                let seconds = clock.elapsed().as_secs_f64();
                let poses: Vec<Pose<3>> = report.views.iter().map(|view| view.pose).collect();
                println!(
                    "{count:>7} {noise:>8.0e} {degrees:>8} {:>8} {:>10.2e} {:>10.2e} {:>6} {seconds:>8.3}  {}{}",
                    if start { "given" } else { "none" },
                    six.error(&six.initial),
                    six.error(&poses),
                    report.history.len(),
                    report.status,
                    if normals { ", with normals" } else { "" },
                );
            }
        }
    }
    Ok(())
}
