//! Runs the projectors on cases with known distances and counts wrong answers.
//!
//! `ground_truth DIR` reads every `NAME.json` (a curve or surface) in DIR with its `NAME.SET.q` (query points) and
//! `NAME.SET.gt` (`u v distance …` per point), and prints per set: wrong answers (distance more than 1e-6 above the
//! true one, parameter outside the domain, or distance that is not that of the reported point), the largest
//! certified gap, and microseconds per query and of the slowest query, one thread.

use footpoint::{CurveProjector, Mode, ProjectionOptions, SurfaceProjector};
use nalgebra::{SVector, Vector3};
use nurbs_core::{BsplineCurve, BsplineSurface, ParametricCurve, ParametricSurface};
use std::error::Error;
use std::path::Path;
use std::time::Instant;

/// What one answer looks like to the judge.
struct Answer {
    distance: f64,
    bound: f64,
    consistent: bool,
    seconds: f64,
    /// Seconds of a local iteration from a start half a percent of the domain away.
    warm: f64,
    note: String,
}

fn main() -> Result<(), Box<dyn Error>> {
    let dir = std::env::args().nth(1).ok_or("usage: ground_truth DIR")?;
    let mut shapes: Vec<_> = std::fs::read_dir(&dir)?.filter_map(|e| Some(e.ok()?.path())).collect();
    shapes.sort();
    println!(
        "{:22} {:>6} {:>6} {:>9} {:>9} {:>9} {:>9} {:>8} {:>8}",
        "set", "points", "wrong", "gap", "certified", "slowest", "fast", "misses", "warm"
    );
    for path in shapes.iter().filter(|p| p.extension().is_some_and(|e| e == "json")) {
        let json: serde_json::Value = serde_json::from_slice(&std::fs::read(path)?)?;
        let stem = path.file_stem().and_then(|s| s.to_str()).unwrap_or_default().to_owned();
        if json["kind"] == "surface" {
            let surface: BsplineSurface = serde_json::from_value(json)?;
            let start = Instant::now();
            let projector = SurfaceProjector::new(&surface);
            let build = start.elapsed().as_secs_f64() * 1e6;
            let patches = projector.patch_count();
            let feet: Vec<_> = (0..1 << 17)
                .map(|i| {
                    let [u, v] = [0.5 + 0.49 * f64::from(i).sin(), 0.5 + 0.49 * f64::from(3 * i).cos()];
                    projector.project_from(&surface.point(u, v), 0, [u, v])
                })
                .collect();
            let shift = Vector3::repeat(2e-3 * size(surface.control_points()));
            let moved: Vec<_> = feet.iter().map(|f| f.point + shift).collect();
            let start = Instant::now();
            let updated = projector.update_many(&moved, &feet)?;
            let update = start.elapsed().as_secs_f64() * 1e9 / updated.len() as f64;
            println!("{stem}: {update:.0} ns per warm start in batches");
            println!(
                "{stem}: {patches} patches, {:.1} µs and {} bytes each",
                build / patches as f64,
                projector.memory() / patches
            );
            let size = size(surface.control_points());
            run(&dir, &stem, size, |x: &Vector3<f64>, mode| {
                let options = ProjectionOptions::default().with_mode(mode);
                let start = Instant::now();
                let foot = projector.project_with(x, &options)?;
                let seconds = start.elapsed().as_secs_f64();
                let [u, v] = foot.parameter;
                let near =
                    [u + 0.005 * surface.domain()[0].length(), v - 0.005 * surface.domain()[1].length()];
                let start = Instant::now();
                let warm = projector.project_from(x, 0, near);
                let warm = start.elapsed().as_secs_f64().max(0.0 * warm.distance);
                let inside = surface.domain()[0].contains(u) && surface.domain()[1].contains(v);
                let gap = ((surface.point(u, v) - x).norm() - foot.distance).abs();
                Ok(Answer {
                    distance: foot.distance,
                    bound: foot.lower_bound,
                    consistent: inside && gap <= 1e-9 * size,
                    seconds,
                    warm,
                    note: format!("{foot} {:?} {:?}", foot.location, foot.multiplicity),
                })
            })?;
        } else if json["control_points"][0].as_array().map(Vec::len) == Some(2) {
            curve::<2>(&dir, &stem, serde_json::from_value(json)?)?;
        } else {
            curve::<3>(&dir, &stem, serde_json::from_value(json)?)?;
        }
    }
    Ok(())
}

fn curve<const D: usize>(dir: &str, stem: &str, curve: BsplineCurve<D>) -> Result<(), Box<dyn Error>> {
    let projector = CurveProjector::new(&curve);
    println!(
        "{stem}: {} pieces, {} bytes each",
        projector.piece_count(),
        projector.memory() / projector.piece_count()
    );
    let size = size(curve.control_points());
    run(dir, stem, size, |x: &SVector<f64, D>, mode| {
        let options = ProjectionOptions::default().with_mode(mode);
        let start = Instant::now();
        let foot = projector.project_with(x, &options)?;
        let seconds = start.elapsed().as_secs_f64();
        let near = foot.parameter + 0.005 * curve.domain().length();
        let start = Instant::now();
        let warm = projector.project_from(x, 0, near);
        let warm = start.elapsed().as_secs_f64().max(0.0 * warm.distance);
        let gap = ((curve.point(foot.parameter) - x).norm() - foot.distance).abs();
        Ok(Answer {
            distance: foot.distance,
            bound: foot.lower_bound,
            consistent: curve.domain().contains(foot.parameter) && gap <= 1e-9 * size,
            seconds,
            warm,
            note: format!("{foot} {:?} {:?}", foot.location, foot.multiplicity),
        })
    })
}

fn size<const D: usize>(points: &[SVector<f64, D>]) -> f64 {
    let low = points.iter().fold(points[0], |a, p| a.inf(p));
    let high = points.iter().fold(points[0], |a, p| a.sup(p));
    (high - low).norm()
}

fn run<const D: usize>(
    dir: &str,
    stem: &str,
    size: f64,
    answer: impl Fn(&SVector<f64, D>, Mode) -> Result<Answer, footpoint::Error>,
) -> Result<(), Box<dyn Error>> {
    for set in ["on", "near", "mid", "far", "beyond", "singular", "paper"] {
        let queries = Path::new(dir).join(format!("{stem}.{set}.q"));
        if !queries.exists() {
            continue;
        }
        let points: Vec<SVector<f64, D>> =
            rows(&queries)?.iter().map(|row| SVector::from_iterator(row.iter().copied())).collect();
        let truths = rows(&queries.with_extension("gt"))?;
        let (mut wrong, mut fast_wrong, mut gap, mut slowest) = (0, 0, (0.0f64, 0), (0.0f64, 0));
        let mut seconds = [0.0; 3];
        for (m, mode) in [Mode::Certified, Mode::Fast].into_iter().enumerate() {
            // A first round warms the caches; the second one is timed.
            for round in 0..2 {
                for (i, (x, truth)) in points.iter().zip(&truths).enumerate() {
                    let found = answer(x, mode)?;
                    let time = found.seconds;
                    if round == 0 {
                        continue;
                    }
                    seconds[m] += time;
                    seconds[2] += 0.5 * found.warm;
                    let allowed = truth[2] * (1.0 + 1e-6) + 1e-9 * size;
                    let bad = !found.consistent || found.distance.is_nan() || found.distance > allowed;
                    if m == 1 {
                        fast_wrong += usize::from(bad);
                        continue;
                    }
                    wrong += usize::from(bad);
                    let share = (found.distance - found.bound) / found.distance.max(1e-3 * size);
                    if share > gap.0 {
                        gap = (share, i);
                    }
                    if time > slowest.0 {
                        slowest = (time, i);
                    }
                    if bad || found.bound > truth[2] * (1.0 + 1e-9) + 1e-12 * size {
                        println!(
                            "  {stem}.{set} {i}: {x:?} true {} at {} {}: {}, bound {}",
                            truth[2], truth[0], truth[1], found.note, found.bound
                        );
                    }
                }
            }
        }
        let n = points.len() as f64;
        println!(
            "{:22} {:6} {wrong:6} {:9.1e} {:9.2} {:9.1} {:9.2} {fast_wrong:8} {:8.2}   (widest gap {}, slowest {})",
            format!("{stem}.{set}"),
            points.len(),
            gap.0,
            seconds[0] * 1e6 / n,
            slowest.0 * 1e6,
            seconds[1] * 1e6 / n,
            seconds[2] * 1e6 / n,
            gap.1,
            slowest.1
        );
    }
    Ok(())
}

fn rows(path: &Path) -> Result<Vec<Vec<f64>>, Box<dyn Error>> {
    let text = std::fs::read_to_string(path)?;
    text.lines().map(|line| line.split_whitespace().map(|w| Ok(w.parse()?)).collect()).collect()
}
