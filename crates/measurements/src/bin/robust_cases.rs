//! Registers clouds with outliers and with parts that the model does not have, from many starts.
//!
//! `cargo run --release -p measurements --bin robust_cases -- [--every K] [--only NAME] [--bad]`. Models,
//! clouds and starts are made here: the surface of the registration cases (`fixtures/register-cases`), parts of it, a scanned
//! blade as a mesh. Starts are displaced by 5 to 60 degrees and up to 5 % of the diameter. Per case: share of the starts that
//! succeed; error against the optimum over the true inliers; steps; milliseconds. Errors are root mean square displacements of
//! the inliers as a share of the diameter; success is an error against the truth of at most 1.5 times that of the optimum, or
//! 1e-4. `--bad` prints the starts that fail.

#[path = "../../../sdm-register/tests/all/common/mod.rs"]
mod common;

use common::{Random, distance, model};
use distance_field::{DistanceField, MeshField, SurfaceField};
use mesh_core::TriangleMesh;
use nalgebra::{Matrix3, Point3, Vector3};
use nurbs_core::{BsplineSurface, Direction, Interval, ParametricSurface};
use sdm_register::{Outliers, Pose, RegisterOptions, Source, register, rotation};
use std::error::Error;
use std::time::Instant;

struct Trial {
    name: &'static str,
    field: Box<dyn DistanceField<3>>,
    points: Vec<Vector3<f64>>,
    inliers: usize,
    diameter: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let value = |name: &str| arguments.iter().position(|a| a == name).and_then(|i| arguments.get(i + 1));
    let every: usize = value("--every").map_or(Ok(1), |text| text.parse())?;
    let bad = arguments.iter().any(|a| a == "--bad");
    println!(
        "{:14} {:>9} {:>9} {:>9} {:>9} {:>6} {:>6} {:>7}",
        "case", "success", "optimum", "median", "largest", "steps", "most", "ms"
    );
    for trial in trials()? {
        if value("--only").is_some_and(|only| only != trial.name) {
            continue;
        }
        run(&trial, every, bad)?;
    }
    Ok(())
}

fn run(trial: &Trial, every: usize, bad: bool) -> Result<(), Box<dyn Error>> {
    let truth = Pose::identity();
    let inliers = &trial.points[..trial.inliers];
    let options = RegisterOptions::default();
    let plain = options.with_outliers(Outliers::None);
    let optimum = register(trial.field.as_ref(), &Source::new(inliers), &truth, &plain)?.pose;
    let error = |pose: &Pose<3>, to: &Pose<3>| distance(inliers, pose, to) / trial.diameter;
    let best = error(&optimum, &truth);
    let limit = (1.5 * best).max(1e-4);
    let (mut errors, mut steps, mut seconds, mut good) = (Vec::new(), Vec::new(), 0.0, 0);
    for (degrees, start) in starts(trial).into_iter().step_by(every) {
        let clock = Instant::now();
        let report = register(trial.field.as_ref(), &Source::new(&trial.points), &start, &options)?;
        seconds += clock.elapsed().as_secs_f64();
        let found = error(&report.pose, &truth);
        good += usize::from(found <= limit);
        if bad && (found.is_nan() || found > limit || every > 50) {
            println!("  {degrees}°: {report}, error {found:.2e}, limit {:?}", report.limit);
        }
        errors.push(error(&report.pose, &optimum));
        steps.push(report.iterations);
    }
    errors.sort_by(f64::total_cmp);
    steps.sort_unstable();
    let n = errors.len();
    println!(
        "{:14} {:>9} {best:>9.2e} {:>9.2e} {:>9.2e} {:>6} {:>6} {:>7.1}",
        trial.name,
        format!("{good}/{n}"),
        errors[n / 2],
        errors[n - 1],
        steps[n / 2],
        steps[n - 1],
        seconds * 1e3 / n as f64
    );
    Ok(())
}

/// 13 starts for each angle.
fn starts(trial: &Trial) -> Vec<(f64, Pose<3>)> {
    let mut random = Random::new(99);
    let centre = trial.points.iter().sum::<Vector3<f64>>() / trial.points.len() as f64;
    let angles = [5.0, 10.0, 15.0, 20.0, 30.0, 40.0, 50.0, 60.0f64];
    let mut start = |degrees: f64| {
        let axis = random.vector().normalize() * degrees.to_radians();
        let shift = random.vector().normalize() * (0.05 * trial.diameter * random.uniform());
        let turn: Matrix3<f64> = rotation::exponential::<3>(&axis).0;
        Pose { scale: 1.0, rotation: turn, source_origin: centre, target_origin: centre + shift }
    };
    angles.iter().flat_map(|&degrees| [degrees; 13]).map(|degrees| (degrees, start(degrees))).collect()
}

/// Points of a part of the surface with noise, and outliers in a box around it that is a tenth larger on every side.
fn cloud(
    surface: &BsplineSurface,
    [low, high]: [f64; 2],
    count: usize,
    outliers: usize,
    noise: f64,
    random: &mut Random,
) -> Vec<Vector3<f64>> {
    let mut points: Vec<Vector3<f64>> = (0..count)
        .map(|_| {
            let u = low + (high - low) * random.uniform();
            let jet = surface.jet(u, 0.03 + 0.94 * random.uniform());
            jet.point + random.vector() * noise
        })
        .collect();
    let bounds = surface.control_box();
    let margin = 0.1 * bounds.diagonal();
    for _ in 0..outliers {
        let side = bounds.max - bounds.min + Vector3::repeat(2.0 * margin);
        let inside = Vector3::new(random.uniform(), random.uniform(), random.uniform());
        points.push(bounds.min - Vector3::repeat(margin) + inside.component_mul(&side));
    }
    points
}

fn trials() -> Result<Vec<Trial>, Box<dyn Error>> {
    let surface = model();
    let diameter = surface.control_box().diagonal();
    let noise = 1e-3 * diameter;
    let mut random = Random::new(7);
    let mut out = Vec::new();
    for (name, outliers) in [("outliers 20 %", 1250), ("outliers 35 %", 2692), ("outliers 50 %", 5000)] {
        let points = cloud(&surface, [0.03, 0.97], 5000, outliers, noise, &mut random);
        out.push(Trial {
            name,
            field: Box::new(SurfaceField::new(&surface)?),
            points,
            inliers: 5000,
            diameter,
        });
    }
    // The model ends in the middle: the second half of the scan has no counterpart.
    for (name, end, part) in [("half model", 0.5, [0.03, 0.97]), ("overlap 50 %", 0.65, [0.33, 0.97])] {
        let half = surface.trimmed(Direction::U, Interval::new(0.0, end)?)?;
        let mut points = cloud(&surface, [part[0], end], 3000, 0, noise, &mut random);
        points.extend(cloud(&surface, [end, part[1]], 3000, 0, noise, &mut random));
        out.push(Trial { name, field: Box::new(SurfaceField::new(&half)?), points, inliers: 3000, diameter });
    }
    let (blade, points) = blade()?;
    let (inliers, size) = (points.len(), blade.bounding_box().diagonal());
    let mut with_outliers = points.clone();
    let bounds = blade.bounding_box();
    for _ in 0..inliers {
        let inside = Vector3::new(random.uniform(), random.uniform(), random.uniform());
        with_outliers.push(bounds.min + (bounds.max - bounds.min).component_mul(&inside));
    }
    let (field, again) = (Box::new(blade), Box::new(self::blade()?.0));
    out.push(Trial { name: "blade", field, points, inliers, diameter: size });
    out.push(Trial { name: "blade, 50 %", field: again, points: with_outliers, inliers, diameter: size });
    Ok(out)
}

/// A mesh and points of it.
type Scanned = (MeshField, Vec<Vector3<f64>>);

/// A scanned blade as a mesh, and points on its triangles with noise.
fn blade() -> Result<Scanned, Box<dyn Error>> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/scans/engine-blade.ply");
    let bytes = std::fs::read(path)?;
    let end = b"end_header\n";
    let start = bytes.windows(end.len()).position(|w| w == end).ok_or("no header")? + end.len();
    let (vertices, faces) = (21_795, 43_586);
    let number = |k: usize| f64::from_le_bytes(bytes[start + 8 * k..][..8].try_into().unwrap_or_default());
    let positions: Vec<Point3<f64>> =
        (0..vertices).map(|i| Point3::new(number(3 * i), number(3 * i + 1), number(3 * i + 2))).collect();
    let list = start + 24 * vertices;
    let index = |f: usize, k: usize| {
        i32::from_le_bytes(bytes[list + 13 * f + 1 + 4 * k..][..4].try_into().unwrap_or_default())
            .unsigned_abs()
    };
    let triangles: Vec<[u32; 3]> = (0..faces).map(|f| [index(f, 0), index(f, 1), index(f, 2)]).collect();
    let mesh = TriangleMesh::new(positions, triangles)?;
    let mut random = Random::new(3);
    let size = mesh.bounding_box().map_or(1.0, |bounds| bounds.diagonal());
    let points = (0..3000)
        .filter_map(|i| {
            let [a, b, c] = mesh.corners(i * 14)?;
            let (s, t) = (random.uniform(), random.uniform());
            let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
            Some(a.coords + (b - a) * s + (c - a) * t + random.vector() * (5e-4 * size))
        })
        .collect();
    Ok((MeshField::new(&mesh)?, points))
}
