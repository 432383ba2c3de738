//! Curves fitted to points of known curves in no order, judged from both sides by code that shares nothing with the fit.
//!
//! `cargo run --release -p sdm-fit --example two_sided_curves [-- SEEDS [LARGEST [KIND]]]`. Noise of 0 to 1 % of the size, 0 to 5 % outliers (then with a
//! robust kernel), 150 to 20,000 points. A run is right if the fitted curve is nowhere further from the true one, and the true one nowhere further
//! from the fitted one, than three spacings of the points or three standard deviations of the noise (between neighbours that happen to be
//! further apart, than that); it is said if the report does not claim that curve and points cover each other. What must not be is a wrong
//! curve that is not said to be so.

mod truths;

use distance_field::Kernel;
use nalgebra::Vector2;
use nurbs_core::{BsplineCurve, ParametricCurve};
use sdm_fit::curve::{CurveOptions, fit_curves};
use sdm_fit::{FitOptions, Robust};
use std::collections::HashMap;
use std::time::Instant;
use truths::{Truth, all};

/// Samples of a fitted curve per control point.
const PER_CONTROL: usize = 60;
/// Allowed distance in spacings, and in standard deviations of the noise.
const NEAR: f64 = 3.0;

/// Points in the cells of a grid, to find the nearest one of many by looking around.
struct Cells {
    size: f64,
    cells: HashMap<[i64; 2], Vec<Vector2<f64>>>,
}

impl Cells {
    fn new(points: impl Iterator<Item = Vector2<f64>>, size: f64) -> Self {
        let mut cells: HashMap<[i64; 2], Vec<Vector2<f64>>> = HashMap::new();
        for p in points {
            cells.entry(Self::key(&p, size)).or_default().push(p);
        }
        Self { size, cells }
    }

    #[expect(clippy::cast_possible_truncation, reason = "small numbers of cells")]
    fn key(p: &Vector2<f64>, size: f64) -> [i64; 2] {
        [(p.x / size).floor() as i64, (p.y / size).floor() as i64]
    }

    /// Distance of the nearest point, or a lower bound of it beyond some cells.
    fn distance(&self, p: &Vector2<f64>) -> f64 {
        let [i, j] = Self::key(p, self.size);
        for reach in 1..40_i64 {
            let mut best = f64::INFINITY;
            for a in -reach..=reach {
                for b in -reach..=reach {
                    let found = self.cells.get(&[i + a, j + b]).into_iter().flatten();
                    best = found.map(|q| (q - p).norm()).fold(best, f64::min);
                }
            }
            if best <= self.size * reach as f64 {
                return best;
            }
        }
        39.0 * self.size
    }
}

/// Places of curves, evenly in parameter.
fn places(curves: &[BsplineCurve<2>]) -> Vec<Vector2<f64>> {
    let mut out = Vec::new();
    for curve in curves {
        let count = PER_CONTROL * curve.control_points().len().max(40);
        out.extend((0..=count).map(|k| curve.point(curve.domain().lerp(k as f64 / count as f64))));
    }
    out
}

/// Half of the widest gap that random points leave on the truth, found from the points themselves: the largest distance of a place of the
/// truth from them.
fn widest(truth: &Truth, points: &[Vector2<f64>], cell: f64) -> f64 {
    let cells = Cells::new(points.iter().copied(), cell);
    truth.pieces.iter().flatten().step_by(7).map(|p| cells.distance(p)).fold(0.0, f64::max)
}

#[derive(Clone, Copy, Default)]
struct Tally {
    right: usize,
    said: usize,
    wrong: usize,
    needless: usize,
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let seeds: u64 = arguments.next().and_then(|a| a.parse().ok()).unwrap_or(3);
    let largest: usize = arguments.next().and_then(|a| a.parse().ok()).unwrap_or(20_000);
    let kind = arguments.next();
    let mut total = Tally::default();
    println!(
        "{:14} {:>6} {:>6} {:>5}  right  said  WRONG  (needless)  worst      s",
        "curve", "points", "noise", "outl."
    );
    for truth in all().iter().filter(|t| kind.as_ref().is_none_or(|k| t.name.contains(k.as_str()))) {
        for count in [150, 600, 3000, 20_000].into_iter().filter(|c| *c <= largest) {
            for noise in [0.0, 0.003, 0.01] {
                for outliers in [0.0, 0.05] {
                    let (tally, worst, seconds) = runs(truth, count, noise, outliers, seeds);
                    println!(
                        "{:14} {count:6} {:5.1}% {:4.0}%  {:5} {:5} {:6} {:11} {worst:6.2} {seconds:6.2}",
                        truth.name,
                        100.0 * noise,
                        100.0 * outliers,
                        tally.right,
                        tally.said,
                        tally.wrong,
                        tally.needless
                    );
                    total.right += tally.right;
                    total.said += tally.said;
                    total.wrong += tally.wrong;
                    total.needless += tally.needless;
                }
            }
        }
    }
    let all = total.right + total.said + total.wrong;
    println!(
        "{all} runs: {} right ({:.2} %), {} said not to be, {} wrong and not said; of the right ones {} doubted",
        total.right,
        100.0 * total.right as f64 / all.max(1) as f64,
        total.said,
        total.wrong,
        total.needless
    );
}

fn runs(truth: &Truth, count: usize, noise: f64, outliers: f64, seeds: u64) -> (Tally, f64, f64) {
    let sigma = noise * truth.size() / 2.0_f64.sqrt();
    let spacing = truth.length() / count as f64;
    let mut tally = Tally::default();
    let (mut worst, clock) = (0.0_f64, Instant::now());
    for seed in 1..=seeds {
        let (points, strange) = truth.sample(count, sigma, outliers, seed * 7919 + count as u64);
        let robust = if outliers > 0.0 {
            Robust::Kernel { kernel: Kernel::Tukey, abs_scale: None }
        } else {
            Robust::None
        };
        let options = CurveOptions::default().with_fit(FitOptions::default().with_robust(robust));
        let own: Vec<Vector2<f64>> =
            points.iter().zip(&strange).filter(|(_, strange)| !**strange).map(|(p, _)| *p).collect();
        let cell = (0.02 * truth.size()).max(2.0 * spacing);
        let allowed = (NEAR * sigma).max(NEAR * spacing).max(widest(truth, &own, cell));
        let (off, claimed) = match fit_curves(&points, &options) {
            Ok(parts) => {
                let curves: Vec<BsplineCurve<2>> = parts.iter().map(|p| p.fit.curve.clone()).collect();
                let found = places(&curves);
                if let Some(folder) = std::env::var_os("DUMP") {
                    let text = |list: &[Vector2<f64>]| {
                        list.iter().map(|p| format!("{} {}\n", p.x, p.y)).collect::<String>()
                    };
                    let stem = format!("{}_{count}_{noise}_{outliers}_{seed}", truth.name.replace(' ', ""));
                    let folder = std::path::PathBuf::from(folder);
                    let _ = std::fs::write(folder.join(format!("{stem}.xyz")), text(&points));
                    let _ = std::fs::write(folder.join(format!("{stem}.curve")), text(&found));
                }
                let truths = Cells::new(truth.pieces.iter().flatten().copied(), cell);
                let fitted = Cells::new(found.iter().copied(), cell);
                let there = found.iter().map(|p| truths.distance(p)).fold(0.0, f64::max);
                let back = truth.pieces.iter().flatten().map(|p| fitted.distance(p)).fold(0.0, f64::max);
                let claimed = parts.iter().all(|p| p.fit.report.covered && p.fit.report.is_converged());
                if !claimed && std::env::var_os("TELL").is_some() {
                    for p in &parts {
                        println!(
                            "    {} {count} {noise} {outliers} seed {seed}: {}",
                            truth.name, p.fit.report
                        );
                    }
                }
                (there.max(back), claimed)
            }
            Err(error) => {
                if std::env::var_os("TELL").is_some() {
                    println!("    {} {count} {noise} {outliers} seed {seed}: {error}", truth.name);
                }
                (f64::INFINITY, false)
            }
        };
        let fine = off <= allowed;
        if off.is_finite() {
            worst = worst.max(off / allowed);
        }
        match (fine, claimed) {
            (true, true) => tally.right += 1,
            (true, false) => {
                tally.right += 1;
                tally.needless += 1;
            }
            (false, false) => tally.said += 1,
            (false, true) => {
                tally.wrong += 1;
                if std::env::var_os("TELL").is_some() {
                    println!(
                        "    {} {count} {noise} {outliers} seed {seed}: WRONG by {off} of {allowed}",
                        truth.name
                    );
                }
            }
        }
    }
    (tally, worst, clock.elapsed().as_secs_f64())
}
