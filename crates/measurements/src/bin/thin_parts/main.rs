//! What `indgeo register` calls the end of registrations of thin parts that begin far off.
//!
//! `cargo build --release --bin indgeo`, then `cargo run --release -p measurements --bin thin_parts [-- [INDGEO]]`.
//! Plates, shells, brackets and blades with a thickness of 0.3 to 3 % of their size, each with an outline that no motion carries into itself,
//! as meshes; 1500 points of their upper side, with a noise of 0 to 0.1 % of the size. Three tables: without a deviation, from starts 90 to
//! 180 degrees off; badly made parts (bent and twisted by up to a share of the size) from starts 5 to 15 degrees off, which are found with
//! a warning at most; the same without a start.
//!
//! A pose is right if the points lie within 0.3 % of the size of their true places; or within one and a half thicknesses, if they fit about as
//! well as there, since from one side of a plate nothing tells its thickness. `wrong, 0` is what must not be; `right, 1` is a doubt that need not be. With the environment variable
//! `TELL` every such run is described.

#[path = "../../../../indgeo/tests/all/common/sheets.rs"]
mod sheets;

use serde_json::Value;
use sheets::{KINDS, Part, Point, Random, SIZE, centre, sum, times, turned, warped};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// Thicknesses and noise as shares of the size.
const THICKNESSES: [f64; 3] = [0.003, 0.01, 0.03];
const NOISE: [f64; 3] = [0.0, 3e-4, 1e-3];
const POINTS: usize = 1500;
/// Starts far off, and near: degrees and axis.
const FAR: [(f64, Point); 10] = [
    (90.0, [0.0, 0.0, 1.0]),
    (90.0, [1.0, 0.0, 0.0]),
    (90.0, [0.0, 1.0, 0.0]),
    (135.0, [1.0, 1.0, 0.0]),
    (175.0, [1.0, 0.0, 0.0]),
    (175.0, [0.0, 1.0, 0.0]),
    (175.0, [0.0, 0.0, 1.0]),
    (180.0, [1.0, -1.0, 0.3]),
    (110.0, [1.0, 2.0, 3.0]),
    (150.0, [-1.0, 0.5, 1.0]),
];
const NEAR: [(f64, Point); 3] = [(5.0, [1.0, 2.0, 3.0]), (10.0, [1.0, 0.0, -1.0]), (15.0, [0.0, 1.0, 0.5])];

#[derive(Clone, Copy, Default)]
struct Tally {
    /// Right and wrong, with exit status 0 and 1.
    right: [usize; 2],
    wrong: [usize; 2],
}

/// What is run.
#[derive(Clone, Copy)]
struct Setting<'a> {
    kind: &'a str,
    thickness: f64,
    noise: f64,
    warp: f64,
    has_normals: bool,
    start: (f64, Point),
    options: &'a str,
}

fn main() -> ExitCode {
    let beside = || Some(std::env::current_exe().ok()?.with_file_name("indgeo"));
    let given = std::env::args().nth(1).map(PathBuf::from);
    let Some(program) = given.or_else(beside).filter(|path| path.is_file()) else {
        eprintln!("there is no program `indgeo` beside this one: build it, or name it as the argument");
        return ExitCode::from(2);
    };
    let folder = std::env::temp_dir().join(format!("thin_parts-{}", std::process::id()));
    let done = std::fs::create_dir_all(&folder).map_err(|error| error.to_string()).and_then(|()| {
        table("far off, --start given", &FAR, &[0.0], "--start given", &program, &folder)?;
        table(
            "badly made by 0.5 to 3 %, --start given",
            &NEAR,
            &[5e-3, 1e-2, 3e-2],
            "--start given",
            &program,
            &folder,
        )?;
        table("badly made by 0.5 to 3 %, no start", &FAR[7..], &[5e-3, 1e-2, 3e-2], "", &program, &folder)
    });
    let _ = std::fs::remove_dir_all(&folder);
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn table(
    title: &str,
    starts: &[(f64, Point)],
    warps: &[f64],
    options: &str,
    program: &Path,
    folder: &Path,
) -> Result<(), String> {
    println!("{title}: {:>9} {:>9} {:>9} {:>9}", "right, 0", "right, 1", "wrong, 1", "wrong, 0");
    let mut total = Tally::default();
    for kind in KINDS {
        let mut tally = Tally::default();
        for thickness in THICKNESSES {
            for (k, noise) in NOISE.into_iter().enumerate() {
                for &start in starts {
                    for &warp in warps {
                        let setting =
                            Setting { kind, thickness, noise, warp, has_normals: k == 1, start, options };
                        run(&setting, program, folder, &mut tally)?;
                    }
                }
            }
        }
        println!("{kind:>width$}: {}", row(&tally), width = title.len());
        for status in [0, 1] {
            total.right[status] += tally.right[status];
            total.wrong[status] += tally.wrong[status];
        }
    }
    println!("{:>width$}: {}", "all", row(&total), width = title.len());
    Ok(())
}

fn row(tally: &Tally) -> String {
    let Tally { right, wrong } = tally;
    format!("{:>9} {:>9} {:>9} {:>9}", right[0], right[1], wrong[1], wrong[0])
}

fn run(setting: &Setting<'_>, program: &Path, folder: &Path, tally: &mut Tally) -> Result<(), String> {
    let (model, scan, pose) = (folder.join("part.off"), folder.join("scan.csv"), folder.join("pose.json"));
    let part = Part::new(setting.kind, setting.thickness);
    let put = |path: &Path, text: String| {
        std::fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
    };
    put(&model, part.to_off())?;
    let mut random = Random(7 + tally.right.iter().chain(&tally.wrong).sum::<usize>() as u64);
    let (points, normals) = part.scan(POINTS, &mut random);
    let middle = centre(&points);
    let mut truth: Vec<Point> = Vec::new();
    for (x, normal) in points.iter().zip(&normals) {
        let off = [random.gauss(), random.gauss(), random.gauss()];
        truth.push(sum(warped(*x, *normal, middle, setting.warp), times(off, SIZE * setting.noise)));
    }
    let shift = times([random.gauss(), random.gauss(), random.gauss()], 0.02 * SIZE);
    let (degrees, axis) = setting.start;
    let given: Vec<Point> = truth
        .iter()
        .map(|x| sum(sum(turned(sum(*x, times(middle, -1.0)), axis, degrees), middle), shift))
        .collect();
    let mut text = String::from(if setting.has_normals { "x,y,z,nx,ny,nz\n" } else { "x,y,z\n" });
    for ([x, y, z], normal) in given.iter().zip(&normals) {
        let [a, b, c] = turned(*normal, axis, degrees);
        let _ = if setting.has_normals {
            writeln!(text, "{x},{y},{z},{a},{b},{c}")
        } else {
            writeln!(text, "{x},{y},{z}")
        };
    }
    put(&scan, text)?;
    let output = Command::new(program)
        .args(["register".as_ref(), model.as_os_str(), scan.as_os_str()])
        .args(["--quiet".as_ref(), "--transform".as_ref(), pose.as_os_str()])
        .args(setting.options.split_whitespace())
        .output()
        .map_err(|error| format!("{}: {error}", program.display()))?;
    let text = std::fs::read_to_string(&pose).map_err(|error| {
        format!("{}: {error}: {}", pose.display(), String::from_utf8_lossy(&output.stderr))
    })?;
    let found: Value = serde_json::from_str(&text).map_err(|error| error.to_string())?;
    let at = |i: usize, j: usize| found["matrix"][i][j].as_f64().unwrap_or(f64::NAN);
    let moved = |[x, y, z]: Point| [0, 1, 2].map(|i| at(i, 0) * x + at(i, 1) * y + at(i, 2) * z + at(i, 3));
    let squares: f64 = given
        .iter()
        .zip(&truth)
        .map(|(x, y)| moved(*x).iter().zip(y).map(|(a, b)| (a - b).powi(2)).sum::<f64>())
        .sum();
    let error = (squares / POINTS as f64).sqrt() / SIZE;
    let fits = found["support"]["relative_rms"]
        .as_f64()
        .is_some_and(|rms| rms < 1e-3 + 1.5 * setting.noise + 0.5 * setting.warp);
    let near = 3e-3 + setting.noise + setting.warp;
    let is_right = error < near || fits && error < near + 1.5 * setting.thickness;
    let status = usize::from(!output.status.success());
    if is_right {
        tally.right[status] += 1;
    } else {
        tally.wrong[status] += 1;
    }
    if std::env::var_os("TELL").is_some() && is_right == (status == 1) {
        let Setting { kind, thickness, noise, warp, start, .. } = setting;
        println!(
            "  {kind} {thickness} noise {noise} warp {warp} start {start:?}: exit {status}, error {error:.4}, {}",
            found["support"]
        );
    }
    Ok(())
}
