//! Surfaces fitted by `indgeo fit-surface` to points of known surfaces in no order, judged from both sides by code that shares nothing with it.
//!
//! `cargo build --release --bin indgeo`, then `cargo run --release -p measurements --bin two_sided_surfaces [-- SEEDS [LARGEST [KIND [INDGEO]]]]`.
//! Noise of 0 to 1 % of the size, 0 to 5 % outliers (then with `--outliers automatic`), 500 to 20,000 points, on height fields, a roof, tubes, cones, and
//! on pieces whose outline is no rectangle. A run is right if the surface, as far as its file says that it goes, is nowhere further from the true one,
//! and the true one nowhere further from it, than three spacings of the points or three standard deviations of the noise; it is said if the
//! program does not end with 0. What must not be is a wrong surface and the exit status 0: the program then ends with 1. With the
//! environment variable `TELL` every run that is not right is described.

mod judge;
mod truths;

use judge::Spline;
use nalgebra::Vector3;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::Instant;
use truths::{Truth, all};

#[derive(Clone, Copy, Default)]
struct Tally {
    right: usize,
    said: usize,
    wrong: usize,
    needless: usize,
}

impl Tally {
    fn add(&mut self, other: &Self) {
        self.right += other.right;
        self.said += other.said;
        self.wrong += other.wrong;
        self.needless += other.needless;
    }
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
    let seeds: u64 = arguments.next().and_then(|a| a.parse().ok()).unwrap_or(2);
    let largest: usize = arguments.next().and_then(|a| a.parse().ok()).unwrap_or(20_000);
    let kind = arguments.next();
    let beside = || Some(std::env::current_exe().ok()?.with_file_name("indgeo"));
    let Some(program) = arguments.next().map(PathBuf::from).or_else(beside).filter(|path| path.is_file())
    else {
        eprintln!(
            "there is no program `indgeo` beside this one: build it, or name it as the fourth argument"
        );
        return ExitCode::from(2);
    };
    let folder = std::env::temp_dir().join(format!("two-sided-surfaces-{}", std::process::id()));
    if let Err(error) = std::fs::create_dir_all(&folder) {
        eprintln!("{}: {error}", folder.display());
        return ExitCode::from(2);
    }
    let mut total = Tally::default();
    println!(
        "{:10} {:>6} {:>6} {:>5}  right  said  WRONG  (needless)  worst      s",
        "surface", "points", "noise", "outl."
    );
    for truth in all().iter().filter(|t| kind.as_ref().is_none_or(|k| t.name.contains(k.as_str()))) {
        for count in [500, 2000, 20_000].into_iter().filter(|c| *c <= largest) {
            for noise in [0.0, 0.003, 0.01] {
                for outliers in [0.0, 0.05] {
                    let setting = Setting { count, noise, outliers };
                    let (tally, worst, seconds) = runs(truth, setting, seeds, &program, &folder);
                    println!(
                        "{:10} {count:6} {:5.1}% {:4.0}%  {:5} {:5} {:6} {:11} {worst:6.2} {seconds:6.2}",
                        truth.name,
                        100.0 * noise,
                        100.0 * outliers,
                        tally.right,
                        tally.said,
                        tally.wrong,
                        tally.needless
                    );
                    total.add(&tally);
                }
            }
        }
    }
    // What is left there is of no use to anybody.
    let _ = std::fs::remove_dir_all(&folder);
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

/// Fits with several seeds: how they ended, the largest distance in units of what is allowed, and the time.
fn runs(truth: &Truth, setting: Setting, seeds: u64, program: &Path, folder: &Path) -> (Tally, f64, f64) {
    let Setting { count, noise, outliers } = setting;
    let sigma = noise * truth.size() / 3.0_f64.sqrt();
    let mut tally = Tally::default();
    let (mut worst, mut seconds) = (0.0_f64, 0.0);
    for seed in 1..=seeds {
        let (points, strange) = truth.sample(count, sigma, outliers, seed * 7919 + count as u64);
        let own: Vec<Vector3<f64>> =
            points.iter().zip(&strange).filter(|(_, strange)| !**strange).map(|(p, _)| *p).collect();
        let clock = Instant::now();
        let (claimed, fitted, told) = fitted(&points, outliers > 0.0, program, folder);
        seconds += clock.elapsed().as_secs_f64();
        let (fine, about) = match &fitted {
            Some(fitted) => {
                let [there, back, allowed] = judge::distance(truth, &own, sigma, fitted);
                worst = worst.max(there.max(back) / allowed);
                (
                    there.max(back) <= allowed,
                    format!("surface {there:.3} off, truth {back:.3} off, of {allowed:.3}"),
                )
            }
            None => (false, "no surface".to_owned()),
        };
        let word = match (fine, claimed) {
            (true, true) => "right",
            (true, false) => "needless",
            (false, false) => "said",
            (false, true) => "WRONG",
        };
        tally.add(&Tally {
            right: usize::from(fine),
            needless: usize::from(fine && !claimed),
            said: usize::from(!fine && !claimed),
            wrong: usize::from(!fine && claimed),
        });
        if word != "right" && std::env::var_os("TELL").is_some() {
            println!("    {} {count} {noise} {outliers} seed {seed}: {word}, {about}; {told}", truth.name);
        }
    }
    (tally, worst, seconds)
}

/// What the program makes of points: whether it ends with 0, the surface, and what it says.
fn fitted(
    points: &[Vector3<f64>],
    outliers: bool,
    program: &Path,
    folder: &Path,
) -> (bool, Option<Spline>, String) {
    let (cloud, surface) = (folder.join("points.xyz"), folder.join("surface.json"));
    let mut text = String::new();
    for p in points {
        // Writing to memory cannot fail.
        let _ = writeln!(text, "{} {} {}", p.x, p.y, p.z);
    }
    let _ = std::fs::remove_file(&surface);
    if let Err(error) = std::fs::write(&cloud, text) {
        return (false, None, error.to_string());
    }
    let mut command = Command::new(program);
    command.arg("fit-surface").arg(&cloud).arg("-o").arg(&surface);
    if outliers {
        command.args(["--outliers", "automatic"]);
    }
    match command.output() {
        Ok(output) => {
            let said = [output.stdout, output.stderr].concat();
            let said = String::from_utf8_lossy(&said).split_whitespace().collect::<Vec<_>>().join(" ");
            let found = std::fs::read_to_string(&surface).ok().and_then(|text| Spline::read(&text));
            (output.status.success(), found, said)
        }
        Err(error) => (false, None, error.to_string()),
    }
}
