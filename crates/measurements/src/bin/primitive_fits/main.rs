//! Fits of primitives against an independent minimiser with many starts.
//!
//! `cargo run --release -p measurements --bin primitive_fits [SEEDS]`. Pieces of 10 to 360 degrees around and across, noise of 0 to
//! 1e-2 of the radius, up to 45 % outliers in a box around the piece. A fit is wrong if it says `converged` and its rms is more than
//! a part in 1e9 (and 1e-13 of the size, which is rounding) above the lowest that is known; among outliers, if it says so and
//! does not find the shape. Milliseconds are CPU time of a fit.

mod reference;
mod scenes;

use nalgebra::Vector3;
use reference::lowest;
use scenes::{KINDS, Kind, Piece, Random, Scene, scene};
use sdm_fit::Error;
use sdm_fit::primitive::{
    PrimitiveFit, PrimitiveOptions, PrimitiveOutliers, PrimitiveStatus, fit_circle, fit_circle_in_space,
    fit_cone, fit_cylinder, fit_line, fit_plane, fit_sphere, fit_torus,
};
use std::f64::consts::TAU;

/// What is looked at in a fit.
struct Answer {
    status: PrimitiveStatus,
    rms: f64,
    residuals: Vec<f64>,
    conditioning: f64,
    miss: f64,
    solutions: usize,
}

fn answer<S, const D: usize>(fit: PrimitiveFit<S, D>) -> Answer {
    Answer {
        status: fit.status,
        rms: fit.rms,
        residuals: fit.residuals,
        conditioning: fit.conditioning,
        miss: fit.miss_probability,
        solutions: fit.solutions,
    }
}

fn fitted(kind: Kind, points: &[Vector3<f64>], options: &PrimitiveOptions) -> Result<Answer, Error> {
    match kind {
        Kind::Line => fit_line(points, options).map(answer),
        Kind::Plane => fit_plane(points, options).map(answer),
        Kind::Circle => fit_circle(&points.iter().map(|p| p.xy()).collect::<Vec<_>>(), options).map(answer),
        Kind::CircleInSpace => fit_circle_in_space(points, options).map(answer),
        Kind::Sphere => fit_sphere(points, options).map(answer),
        Kind::Cylinder => fit_cylinder(points, options).map(answer),
        Kind::Cone => fit_cone(points, options).map(answer),
        Kind::Torus => fit_torus(points, options).map(answer),
    }
}

/// CPU seconds of this process; wall time where the system does not tell.
fn seconds() -> f64 {
    let ticks = std::fs::read_to_string("/proc/self/stat").ok().and_then(|text| {
        let mut fields = text.rsplit(')').next()?.split_whitespace().skip(11);
        Some(fields.next()?.parse::<f64>().ok()? + fields.next()?.parse::<f64>().ok()?)
    });
    let since = || std::time::UNIX_EPOCH.elapsed().map_or(0.0, |t| t.as_secs_f64());
    ticks.map_or_else(since, |ticks| ticks / 100.0)
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let seeds: u64 = arguments.next().and_then(|a| a.parse().ok()).unwrap_or(4);
    let only = arguments.next();
    let chosen =
        |kind: &Kind| only.as_ref().is_none_or(|name| format!("{kind:?}").eq_ignore_ascii_case(name));
    println!(
        "least squares      fits converged ambiguous boundary doubtful other errors  wrong  ms, full  ms, pieces"
    );
    for kind in KINDS.into_iter().filter(chosen) {
        pieces(kind, seeds);
    }
    println!("\namong outliers      fits converged doubtful other errors  found  wrong  ms");
    for kind in KINDS.into_iter().filter(chosen) {
        for share in [0.0, 0.2, 0.45] {
            among_outliers(kind, share, seeds);
        }
    }
    if only.is_none() {
        println!("\nspecial clouds");
        special();
    }
}

/// Least squares over all points of pieces.
fn pieces(kind: Kind, seeds: u64) {
    let angles = [10u32, 20, 45, 90, 180, 360];
    let (mut counts, mut wrong, mut times) = ([0usize; 7], Vec::new(), [(0.0, 0usize); 2]);
    for seed in 0..seeds {
        for turn in angles {
            for across in angles {
                // One angle alone describes what has no second direction.
                if matches!(kind, Kind::Line | Kind::Circle | Kind::CircleInSpace | Kind::Sphere)
                    && across != 360
                {
                    continue;
                }
                for noise in [0.0, 1e-4, 1e-2] {
                    let piece = Piece {
                        turn: f64::from(turn),
                        across: f64::from(across),
                        noise,
                        outliers: 0.0,
                        count: 200,
                    };
                    let scene = scene(kind, piece, seed * 1000 + u64::from(turn) * 37 + u64::from(across));
                    let start = seconds();
                    let found = fitted(kind, &scene.points, &PrimitiveOptions::default());
                    let full = usize::from(turn < 360 || across < 360);
                    times[full].0 += seconds() - start;
                    times[full].1 += 1;
                    count(&mut counts, &found);
                    let Ok(found) = found else { continue };
                    if found.status != PrimitiveStatus::Converged {
                        continue;
                    }
                    let least = lowest(&scene, 10, seed);
                    if found.rms > least * (1.0 + 1e-9) + 1e-13 * scene.size {
                        wrong.push(format!(
                            "  {turn} x {across} degrees, noise {noise:e}, seed {seed}: rms {:.6e}, known {least:.6e}, \
                             conditioning {:.1e}, miss {:.1e}",
                            found.rms, found.conditioning, found.miss
                        ));
                    }
                }
            }
        }
    }
    let [full, part] = times.map(|(t, n)| 1e3 * t / n.max(1) as f64);
    let [fits, converged, ambiguous, boundary, doubtful, other, errors] = counts;
    println!(
        "{:16} {fits:6} {converged:9} {ambiguous:9} {boundary:8} {doubtful:8} {other:5} {errors:6} {:6} {full:9.2} {part:11.2}",
        format!("{kind:?}"),
        wrong.len()
    );
    wrong.iter().take(12).for_each(|line| println!("{line}"));
}

fn count(counts: &mut [usize; 7], found: &Result<Answer, Error>) {
    counts[0] += 1;
    let place = match found.as_ref().map(|f| f.status) {
        Ok(PrimitiveStatus::Converged) => 1,
        Ok(PrimitiveStatus::Ambiguous) => 2,
        Ok(PrimitiveStatus::OnBoundary) => 3,
        Ok(PrimitiveStatus::Doubtful) => 4,
        Ok(_) => 5,
        Err(_) => 6,
    };
    counts[place] += 1;
}

/// Whether the points on the shape are as near to the one found as noise lets them be.
fn is_found(scene: &Scene, found: &Answer, noise: f64) -> bool {
    let sum: f64 = found.residuals[..scene.inliers].iter().map(|r| r * r).sum();
    (sum / scene.inliers as f64).sqrt() <= 2.0 * noise + 1e-9 * scene.size
}

fn among_outliers(kind: Kind, share: f64, seeds: u64) {
    let (mut counts, mut good, mut wrong, mut time) = ([0usize; 7], 0, Vec::new(), 0.0);
    for seed in 0..2 * seeds {
        for (turn, across) in [(90u32, 90u32), (180, 180), (360, 360)] {
            for noise in [0.0, 1e-3, 1e-2] {
                let piece = Piece {
                    turn: f64::from(turn),
                    across: f64::from(across),
                    noise,
                    outliers: share,
                    count: 200,
                };
                let scene = scene(kind, piece, seed * 977 + u64::from(turn));
                for outliers in [
                    PrimitiveOutliers::Tukey { abs_scale: None },
                    PrimitiveOutliers::Trimmed { outliers: 1.0 - scene.inliers as f64 / 200.0 },
                ] {
                    let start = seconds();
                    let found =
                        fitted(kind, &scene.points, &PrimitiveOptions::default().with_outliers(outliers));
                    time += seconds() - start;
                    count(&mut counts, &found);
                    let Ok(found) = found else { continue };
                    // Circles and lines in space have noise in two directions.
                    let right = is_found(&scene, &found, 1.5 * noise);
                    good += usize::from(right);
                    if !right && found.status == PrimitiveStatus::Converged {
                        wrong.push(format!(
                            "  {turn} x {across} degrees, noise {noise:e}, seed {seed}, {outliers:?}: rms {:.3e}, miss {:.1e}",
                            found.rms, found.miss
                        ));
                    }
                }
            }
        }
    }
    let [fits, converged, ambiguous, boundary, doubtful, other, errors] = counts;
    println!(
        "{:13} {:3.0} % {fits:5} {converged:9} {doubtful:8} {:5} {errors:6} {good:6} {:6} {:5.1}",
        format!("{kind:?}"),
        100.0 * share,
        ambiguous + boundary + other,
        wrong.len(),
        1e3 * time / fits as f64
    );
    wrong.iter().take(8).for_each(|line| println!("{line}"));
}

/// Clouds that leave a shape open, have several answers, or strain numbers.
fn special() {
    let mut random = Random(5);
    let mut cloud = |count: usize, f: &mut dyn FnMut(&mut Random) -> Vector3<f64>| -> Vec<Vector3<f64>> {
        (0..count).map(|_| f(&mut random)).collect()
    };
    let torus = |major: f64, minor: f64| {
        move |r: &mut Random| {
            let (a, b) = (r.between(0.0, TAU), r.between(0.0, TAU));
            let out = major + minor * b.cos();
            Vector3::new(out * a.cos(), out * a.sin(), minor * b.sin())
        }
    };
    let cone = |angle: f64| {
        move |r: &mut Random| {
            let (a, s) = (r.between(0.0, TAU), r.between(0.3, 1.3));
            let angle = angle.to_radians();
            Vector3::new(s * angle.sin() * a.cos(), s * angle.sin() * a.sin(), s * angle.cos())
        }
    };
    let plane = cloud(100, &mut |r| Vector3::new(r.even(), r.even(), 0.0));
    let noisy_plane = cloud(100, &mut |r| Vector3::new(r.even(), r.even(), 1e-3 * r.normal()));
    let noisy_line = cloud(100, &mut |r| Vector3::new(r.even(), 1e-3 * r.normal(), 0.0));
    let spindle = cloud(200, &mut torus(0.6, 1.0));
    let horn = cloud(200, &mut torus(1.0, 1.0));
    let box_cloud = cloud(200, &mut |r| Vector3::new(r.even(), r.even(), r.even()));
    let ring = cloud(200, &mut torus(1.0, 0.4));
    let moved = |points: &[Vector3<f64>], scale: f64, shift: f64| -> Vec<Vector3<f64>> {
        points.iter().map(|p| p * scale + Vector3::new(1.0, -0.5, 0.25) * shift).collect()
    };
    let mut broken = ring.clone();
    broken[3].x = f64::NAN;
    broken[7].y = f64::INFINITY;
    let doubled: Vec<_> = ring.iter().chain(&ring).copied().collect();
    let robust = PrimitiveOptions::default().with_outliers(PrimitiveOutliers::Tukey { abs_scale: None });
    let plain = PrimitiveOptions::default();
    let cases: Vec<(&str, Kind, Vec<Vector3<f64>>, PrimitiveOptions)> = vec![
        ("a plane as a cone", Kind::Cone, plane.clone(), plain),
        ("a plane as a torus", Kind::Torus, plane, plain),
        ("a noisy plane as a cone", Kind::Cone, noisy_plane.clone(), plain),
        ("a noisy plane as a torus", Kind::Torus, noisy_plane.clone(), plain),
        ("a noisy plane as a sphere", Kind::Sphere, noisy_plane, plain),
        ("a noisy line as a circle", Kind::Circle, noisy_line, plain),
        ("a spindle, r = R / 0.6", Kind::Torus, spindle, plain),
        ("a horn torus", Kind::Torus, horn, plain),
        ("half-angle 0.001 degrees", Kind::Cone, cloud(200, &mut cone(1e-3)), plain),
        ("half-angle 1 degree", Kind::Cone, cloud(200, &mut cone(1.0)), plain),
        ("half-angle 89 degrees", Kind::Cone, cloud(200, &mut cone(89.0)), plain),
        ("half-angle 89.999 degrees", Kind::Cone, cloud(200, &mut cone(89.999)), plain),
        ("points in a box as a torus", Kind::Torus, box_cloud.clone(), plain),
        ("points in a box as a torus, robust", Kind::Torus, box_cloud.clone(), robust),
        ("points in a box as a cylinder, robust", Kind::Cylinder, box_cloud, robust),
        ("7 points of a torus", Kind::Torus, ring[..7].to_vec(), plain),
        ("6 points of a torus", Kind::Torus, ring[..6].to_vec(), plain),
        ("6 points of a cone", Kind::Cone, cloud(6, &mut cone(25.0)), plain),
        ("each point of a torus twice", Kind::Torus, doubled, plain),
        ("a torus, two points not finite", Kind::Torus, broken, plain),
        ("a torus 1e6 away", Kind::Torus, moved(&ring, 1.0, 1e6), plain),
        ("a torus times 1e6", Kind::Torus, moved(&ring, 1e6, 0.0), plain),
        ("a torus times 1e-6", Kind::Torus, moved(&ring, 1e-6, 0.0), plain),
    ];
    for (name, kind, points, options) in cases {
        match fitted(kind, &points, &options) {
            Ok(found) => println!(
                "{name:38} {:13} rms {:.2e}, conditioning {:.1e}, {} solutions, miss {:.1e}",
                found.status.name(),
                found.rms,
                found.conditioning,
                found.solutions,
                found.miss
            ),
            Err(error) => println!("{name:38} error: {error}"),
        }
    }
}
