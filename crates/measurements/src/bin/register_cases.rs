//! Registers the cases of a folder from all their starts and prints how well and how fast.
//!
//! `register_cases DIR… [--method NAME] [--outliers auto|none] [--angle MAX] [--limit TRE] [--steps] [--every K] [--inliers]`. Each
//! DIR holds `case.json` (`model`, `diam`, `core_mask`, `T_gt` and perhaps `T_ref`), `source.ply` (binary doubles) and
//! `inits.json` (start poses). Per case: share of the starts whose error is at most the limit (default 1e-4), median
//! and largest error, median and largest number of steps and of evaluations, and seconds of CPU per start. The error is
//! the root mean square of `|T x − T_ref x|` over the inliers as a share of the diameter. Where no `T_ref` is given, it is the
//! least squares pose of the inliers alone, which the noise keeps away from `T_gt`; how far is printed.

use distance_field::{ErrorTerm, SurfaceField};
use nalgebra::Vector3;
use nurbs_core::BsplineSurface;
use sdm_register::{Method, Outliers, Pose, RegisterOptions, Source, register};
use serde_json::Value;
use std::error::Error;
use std::path::Path;
use std::time::Instant;

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    let mut options = RegisterOptions::<3>::default();
    let (mut folders, mut angle, mut limit, mut steps, mut every) = (Vec::new(), 180.0, 1e-4, false, 1);
    let mut inliers_only = false;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or("a value is missing");
        match argument.as_str() {
            "--method" => options.method = method(&value()?)?,
            "--outliers" if value()? == "none" => options.outliers = Outliers::None,
            "--outliers" => options.outliers = Outliers::Automatic,
            "--angle" => angle = value()?.parse()?,
            "--limit" => limit = value()?.parse()?,
            "--every" => every = value()?.parse()?,
            "--steps" => steps = true,
            "--inliers" => inliers_only = true,
            _ => folders.push(argument),
        }
    }
    println!("case: success; error median, largest; steps median, largest; evaluations; ms per start");
    for folder in folders {
        let mut case = Case::read(Path::new(&folder))?;
        if inliers_only {
            case.points.truncate(case.inliers);
        }
        if !case.has_reference {
            let inliers = &case.points[..case.inliers];
            let plain = RegisterOptions { outliers: Outliers::None, ..RegisterOptions::default() };
            let optimum = register(&case.field, &Source::new(inliers), &case.reference, &plain)?.pose;
            println!("  least squares over the inliers: {:.2e} from the truth", case.error(&optimum));
            case.reference = optimum;
        }
        let (mut errors, mut counts, mut evaluations, mut seconds) =
            (Vec::new(), Vec::new(), Vec::new(), 0.0);
        for (degrees, start) in case.starts.iter().filter(|s| s.0 <= angle).step_by(every) {
            let clock = Instant::now();
            let report = register(&case.field, &Source::new(&case.points), start, &options)?;
            seconds += clock.elapsed().as_secs_f64();
            let error = case.error(&report.pose);
            if steps || error.is_nan() || error > limit {
                println!("  {degrees:4}°: {report}, error {error:.2e}");
            }
            if steps {
                for (i, s) in report.history.iter().enumerate() {
                    println!(
                        "    {:2} {:10} {:10} {:6} points rms {:.6e} motion {:.2e} damping {:.0e} eval {} scale {:?}",
                        i + 1,
                        s.stage,
                        s.step,
                        s.points,
                        s.rms,
                        s.motion,
                        s.damping,
                        s.evaluations,
                        s.scale
                    );
                }
            }
            errors.push(error);
            counts.push(report.iterations as f64);
            evaluations.push(report.evaluations as f64);
        }
        let n = errors.len();
        let good = errors.iter().filter(|e| **e <= limit).count();
        println!(
            "{folder}: {good} of {n}; {:.2e} {:.2e}; {} {}; {} {}; {:.1}",
            median(&mut errors),
            errors[n - 1],
            median(&mut counts),
            counts[n - 1],
            median(&mut evaluations),
            evaluations[n - 1],
            seconds * 1e3 / n as f64
        );
    }
    Ok(())
}

fn method(name: &str) -> Outcome<Method> {
    Ok(match name {
        "adaptive" => Method::Adaptive,
        "newton" => Method::Newton,
        "symmetric" => Method::Symmetric,
        "anderson_point" => Method::AndersonPoint,
        _ => Method::Term(ErrorTerm::ALL.into_iter().find(|t| t.name() == name).ok_or("no such method")?),
    })
}

/// The median; sorts.
fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

struct Case {
    field: SurfaceField,
    points: Vec<Vector3<f64>>,
    inliers: usize,
    diameter: f64,
    /// The optimum, or the truth.
    reference: Pose<3>,
    has_reference: bool,
    starts: Vec<(f64, Pose<3>)>,
}

impl Case {
    fn read(folder: &Path) -> Outcome<Self> {
        let json = |path: &Path| -> Outcome<Value> { Ok(serde_json::from_slice(&std::fs::read(path)?)?) };
        let case = json(&folder.join("case.json"))?;
        let model = folder.join(case["model"].as_str().ok_or("no model")?);
        let surface: BsplineSurface = serde_json::from_value(json(&model)?)?;
        let reference = case.get("T_ref").unwrap_or(&case["T_gt"]);
        let starts = json(&folder.join("inits.json"))?;
        let starts = starts.as_array().ok_or("no list of starts")?;
        let points = read_ply(&folder.join("source.ply"))?;
        Ok(Self {
            field: SurfaceField::new(&surface)?,
            inliers: case["core_mask"].as_u64().and_then(|n| usize::try_from(n).ok()).unwrap_or(points.len()),
            points,
            diameter: case["diam"].as_f64().ok_or("no diameter")?,
            reference: pose(reference)?,
            has_reference: case.get("T_ref").is_some(),
            starts: starts
                .iter()
                .map(|s| Ok((s["angle_deg"].as_f64().unwrap_or(0.0), pose(&s["T"])?)))
                .collect::<Outcome<_>>()?,
        })
    }

    fn error(&self, found: &Pose<3>) -> f64 {
        let inliers = &self.points[..self.inliers];
        let sum: f64 =
            inliers.iter().map(|x| (found.apply(x) - self.reference.apply(x)).norm_squared()).sum();
        (sum / inliers.len() as f64).sqrt() / self.diameter
    }
}

fn pose(rows: &Value) -> Outcome<Pose<3>> {
    let rows: [[f64; 4]; 4] = serde_json::from_value(rows.clone())?;
    Ok(Pose::<3>::from_row_major(&rows)?)
}

/// The first three of the doubles of each vertex.
fn read_ply(path: &Path) -> Outcome<Vec<Vector3<f64>>> {
    let bytes = std::fs::read(path)?;
    let end = b"end_header\n";
    let start = bytes.windows(end.len()).position(|w| w == end).ok_or("no header")? + end.len();
    let header = std::str::from_utf8(&bytes[..start])?;
    let columns = header.lines().filter(|line| line.starts_with("property double")).count();
    let doubles: Vec<f64> =
        bytes[start..].chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap_or([0; 8]))).collect();
    Ok(doubles.chunks_exact(columns.max(3)).map(|row| Vector3::new(row[0], row[1], row[2])).collect())
}
