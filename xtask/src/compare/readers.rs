//! `cargo xtask compare readers [FOLDER]`: coordinates of files beside those that other readers find in them.
//!
//! The script `xtask/compare/readers.py` reads the files below FOLDER (the fixtures, unless one is given) by plyfile, pypcd4 and trimesh;
//! `PYTHON` names the interpreter, in which these must be installed. It fails if a coordinate differs by more than rounding.

use crate::{Failure, workspace};
use pc_io::{Content, ReadOptions};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

const INSTALL: &str = "install the readers (`python3 -m venv venv && venv/bin/pip install numpy trimesh plyfile pypcd4`) and set \
                       PYTHON=venv/bin/python";
/// Largest difference, as a part of the largest coordinate, that is rounding: of corners that were joined.
const ROUNDING: f64 = 1e-9;

/// Runs the command.
pub(crate) fn run(folder: Option<&String>) -> Result<(), Failure> {
    let folder = folder.map_or_else(|| workspace::root().join("fixtures"), PathBuf::from);
    let out = std::env::temp_dir().join(format!("compare-readers-{}", std::process::id()));
    let failed = |error: &dyn std::fmt::Display| Failure::Failed(format!("{}: {error}", out.display()));
    std::fs::create_dir_all(&out).map_err(|error| failed(&error))?;
    let result = compare(&folder, &out);
    std::fs::remove_dir_all(&out).map_err(|error| failed(&error))?;
    result
}

/// How many files came out how.
#[derive(Default)]
struct Counts {
    same: usize,
    rounded: usize,
    /// Numbers of a text that the other reader rounds to single precision.
    single: usize,
    /// Numbers that are none, of which the readers make something else each; a warning tells of them.
    doubtful: usize,
    only_ours: usize,
    only_theirs: usize,
    neither: usize,
    coordinates: usize,
    different: Vec<String>,
}

fn compare(folder: &Path, out: &Path) -> Result<(), Failure> {
    let mut counts = Counts::default();
    for line in theirs(folder, out)?.lines() {
        let found: Value = serde_json::from_str(line)
            .map_err(|error| Failure::Failed(format!("the script printed `{line}`: {error}")))?;
        let text = |field: &str| found[field].as_str().unwrap_or_default();
        let ours = pc_io::read(text("path"), &ReadOptions::default());
        match (ours, found["error"].as_str()) {
            (Err(_), Some(_)) => counts.neither += 1,
            (Ok(_), Some(_)) => counts.only_ours += 1,
            (Err(error), None) => {
                counts.only_theirs += 1;
                println!("read by {} only: {error}", text("reader"));
            }
            (Ok(ours), None) => {
                let theirs = numbers(Path::new(text("file")))?;
                let is_doubtful =
                    ours.report.warnings.iter().any(|warning| warning.contains("other characters"));
                let ours = match text("kind") {
                    "corners" => corners(&ours.content),
                    _ => points(&ours.content),
                };
                counts.coordinates += theirs.len();
                match difference(&ours, &theirs, text("kind") == "set") {
                    Some(0.0) => counts.same += 1,
                    _ if is_doubtful => counts.doubtful += 1,
                    Some(_) if is_single(&ours, &theirs) => counts.single += 1,
                    Some(gap) if gap <= ROUNDING => counts.rounded += 1,
                    gap => counts.different.push(format!(
                        "{} ({} of {}): {gap:?}",
                        text("path"),
                        ours.len(),
                        theirs.len()
                    )),
                }
            }
        }
    }
    println!(
        "{} files the same bit for bit, {} when rounded to single precision as the others do with text, {} but for corners that were \
         joined, {} with numbers that are none, {} different; {} coordinates. Read here only: {}, by the others only: {}, by neither: {}",
        counts.same,
        counts.single,
        counts.rounded,
        counts.doubtful,
        counts.different.len(),
        counts.coordinates,
        counts.only_ours,
        counts.only_theirs,
        counts.neither
    );
    if counts.different.is_empty() { Ok(()) } else { Err(Failure::Failed(counts.different.join("\n"))) }
}

fn theirs(folder: &Path, out: &Path) -> Result<String, Failure> {
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let mut command = Command::new(&python);
    command.arg(workspace::root().join("xtask/compare/readers.py")).arg(folder).arg(out);
    let output = command.output().map_err(|error| {
        Failure::Failed(format!("{} did not start: {error}; {INSTALL}", python.to_string_lossy()))
    })?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        let last = said.trim_end().lines().last().unwrap_or_default();
        return Err(Failure::Failed(format!("the script failed: {last}; {INSTALL}")));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

fn numbers(path: &Path) -> Result<Vec<f64>, Failure> {
    let data =
        std::fs::read(path).map_err(|error| Failure::Failed(format!("{}: {error}", path.display())))?;
    let number = |bytes: &[u8]| <[u8; 8]>::try_from(bytes).map(f64::from_le_bytes).unwrap_or(f64::NAN);
    Ok(data.chunks_exact(8).map(number).collect())
}

fn points(content: &Content) -> Vec<f64> {
    match content {
        Content::Cloud(cloud) => cloud.positions().iter().flat_map(|p| [p.x, p.y, p.z]).collect(),
        Content::Mesh(mesh) => mesh.vertices().iter().flat_map(|p| [p.x, p.y, p.z]).collect(),
        Content::Nurbs(_) => Vec::new(),
    }
}

fn corners(content: &Content) -> Vec<f64> {
    let Content::Mesh(mesh) = content else { return Vec::new() };
    let vertex = |index: u32| mesh.vertices()[index as usize];
    mesh.triangles().iter().flatten().map(|&index| vertex(index)).flat_map(|p| [p.x, p.y, p.z]).collect()
}

/// Whether the others are ours in single precision.
#[expect(clippy::cast_possible_truncation, reason = "this is what is asked")]
fn is_single(ours: &[f64], theirs: &[f64]) -> bool {
    ours.len() == theirs.len()
        && ours.iter().zip(theirs).all(|(a, b)| f64::from(*a as f32) == *b || a.is_nan() && b.is_nan())
}

/// The largest difference as a part of the largest number; `None` if there are more here or there. NaN equals NaN.
///
/// Of sets only those points are compared that the other reader has: it may leave out what no face uses.
fn difference(ours: &[f64], theirs: &[f64], is_set: bool) -> Option<f64> {
    if is_set {
        let bits = |numbers: &[f64]| -> BTreeSet<[u64; 3]> {
            let key = |p: &[f64]| [p[0] + 0.0, p[1] + 0.0, p[2] + 0.0].map(f64::to_bits);
            numbers.chunks_exact(3).filter(|p| p.iter().all(|value| value.is_finite())).map(key).collect()
        };
        let (ours, theirs) = (bits(ours), bits(theirs));
        return theirs.is_subset(&ours).then_some(0.0);
    }
    if ours.len() != theirs.len() {
        return None;
    }
    let largest = theirs
        .iter()
        .copied()
        .filter(|value| value.is_finite())
        .fold(f64::MIN_POSITIVE, |a, b| a.max(b.abs()));
    let gap =
        |(a, b): (&f64, &f64)| if a == b || a.is_nan() && b.is_nan() { 0.0 } else { (a - b).abs() / largest };
    let gaps = ours.iter().zip(theirs).map(gap);
    Some(gaps.fold(0.0, |most: f64, gap| if gap > most || gap.is_nan() { gap } else { most }))
}
