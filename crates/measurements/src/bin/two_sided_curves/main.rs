//! Curves fitted to points of known curves in no order, judged from both sides by code that shares nothing with the fit.
//!
//! `cargo run --release -p measurements --bin two_sided_curves [-- SEEDS [LARGEST [KIND]]]`. Noise of 0 to 1 % of the size, 0 to 5 % outliers (then with a
//! robust kernel), 150 to 100,000 points. A run is right if the fitted curve is nowhere further from the true one or the points of it, and the true one
//! nowhere further from the fitted one, than three spacings of the points or three standard deviations of the noise (between neighbours that happen to be
//! further apart, than that); it is said if the report does not claim that curve and points cover each other. What must not be is a wrong
//! curve that is not said to be so: the program then ends with 1. With the environment variable `TELL` every run that is not right is described.

mod judge;
mod truths;

use distance_field::Kernel;
use judge::Spline;
use nalgebra::Vector2;
use sdm_fit::curve::{CurveOptions, CurvePart, fit_curves};
use sdm_fit::{FitOptions, Robust};
use std::process::ExitCode;
use std::time::Instant;
use truths::{Truth, all};

#[derive(Clone, Copy, Default)]
struct Tally {
    right: usize,
    said: usize,
    wrong: usize,
    needless: usize,
}

/// What is fitted.
#[derive(Clone, Copy)]
struct Setting {
    count: usize,
    /// Standard deviation as a share of the size.
    noise: f64,
    /// Share of the points.
    outliers: f64,
}

fn main() -> ExitCode {
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
        for count in [150, 600, 3000, 20_000, 100_000].into_iter().filter(|c| *c <= largest) {
            for noise in [0.0, 0.003, 0.01] {
                for outliers in [0.0, 0.05] {
                    let (tally, worst, seconds) = runs(truth, Setting { count, noise, outliers }, seeds);
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
    ExitCode::from(u8::from(total.wrong > 0))
}

fn spline(part: &CurvePart<2>) -> Spline {
    let curve = &part.fit.curve;
    Spline {
        degree: curve.degree(),
        knots: curve.knots().as_slice().to_vec(),
        controls: curve.control_points().to_vec(),
    }
}

/// Fits with several seeds: how they ended, the largest distance in units of what is allowed, and the time.
fn runs(truth: &Truth, setting: Setting, seeds: u64) -> (Tally, f64, f64) {
    let Setting { count, noise, outliers } = setting;
    let sigma = noise * truth.size() / 2.0_f64.sqrt();
    let robust =
        if outliers > 0.0 { Robust::Kernel { kernel: Kernel::Tukey, abs_scale: None } } else { Robust::None };
    let options = CurveOptions::default().with_fit(FitOptions::default().with_robust(robust));
    let mut tally = Tally::default();
    let (mut worst, mut seconds) = (0.0_f64, 0.0);
    for seed in 1..=seeds {
        let (points, strange) = truth.sample(count, sigma, outliers, seed * 7919 + count as u64);
        let own: Vec<Vector2<f64>> =
            points.iter().zip(&strange).filter(|(_, strange)| !**strange).map(|(p, _)| *p).collect();
        let clock = Instant::now();
        let fitted = fit_curves(&points, &options);
        seconds += clock.elapsed().as_secs_f64();
        let (fine, claimed, report) = match &fitted {
            Ok(parts) => {
                let splines: Vec<Spline> = parts.iter().map(spline).collect();
                let apart = judge::distance(truth, &own, sigma, &splines);
                let off = apart.most() / apart.allowed;
                worst = worst.max(off);
                let claimed = parts.iter().all(|p| p.fit.report.covered && p.fit.report.is_converged());
                let reports: Vec<String> = parts.iter().map(|p| p.fit.report.to_string()).collect();
                (off <= 1.0, claimed, format!("{apart}: {}", reports.join("; ")))
            }
            Err(error) => (false, false, error.to_string()),
        };
        match (fine, claimed) {
            (true, true) => tally.right += 1,
            (true, false) => {
                tally.right += 1;
                tally.needless += 1;
            }
            (false, false) => tally.said += 1,
            (false, true) => tally.wrong += 1,
        }
        if !(fine && claimed) && std::env::var_os("TELL").is_some() {
            let word = if fine {
                "needless"
            } else if claimed {
                "WRONG"
            } else {
                "said"
            };
            println!("    {} {count} {noise} {outliers} seed {seed}: {word}, {report}", truth.name);
        }
    }
    (tally, worst, seconds)
}
