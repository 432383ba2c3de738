//! `cargo xtask bench`: runs every criterion benchmark and writes `docs/benchmarks.md`.
//!
//! A benchmark joins the report by existing: a criterion identifier `group/name` is a row `name` in the table
//! `group`. What a group is about is told in [`GROUPS`]. Times are taken per element of the declared throughput.

mod memory;

use crate::{Failure, workspace};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::SystemTime;

/// The benchmark that all others are divided by: one jet (point and five derivatives) of a bicubic polynomial surface.
const UNIT: &str = "jet/bicubic/single";

/// Where the report goes, from the workspace root.
const REPORT: &str = "docs/benchmarks.md";

/// Titles and explanations of the groups, in the order of the report; groups that are not listed follow by name.
const GROUPS: &[(&str, &str, &str)] = &[
    (
        "jet",
        "Surface jets, one at a time",
        "Point and the five derivatives to the second order at one `(u, v)`, the search for the span included. `scalar-loop` \
         is the same written by hand for one degree, without any abstraction; with `known-span` nothing is searched.",
    ),
    (
        "curve-jet",
        "Curve jets, one at a time",
        "Point, first and second derivative at one `t`, the search for the span included.",
    ),
    (
        "batch",
        "Many parameters at once",
        "Per point, in batches: sorting by patch, evaluation in the widest vectors that the processor has, and writing the \
         results in the given order are all included. `4096-on-20x20` are 4096 parameters, spread evenly and unsorted, on a \
         net of 20 x 20 control points.",
    ),
    (
        "cloud",
        "Clouds",
        "Per query, or per point of a cloud of a million points on a wavy surface in no order; queries are ten spacings away \
         from it. `batch` is on all threads.",
    ),
    (
        "mesh",
        "Closest points on meshes",
        "Per query, on a mesh of that many triangles; queries are off the surface by a hundredth of its size. `batch` is on \
         all threads.",
    ),
    (
        "certified",
        "Projection with a certificate",
        "Per point, one at a time, as `shape-set`: points on the shape, near it (up to 1 % of its diagonal), at middle distance \
         (5 to 25 %), far (1.5 to 4 diagonals), beyond its boundary, and at centres, on axes and at poles (singular).",
    ),
    ("fast", "Projection without a certificate", "The same points with `Mode::Fast`."),
    (
        "warm",
        "From a previous answer, one at a time",
        "`project_from`: points of the shape that have moved by 1e-3 and 1e-2 of its diagonal.",
    ),
    (
        "warm-batch",
        "From previous answers, many at once",
        "`update_in_place` on 8192 points, evenly spread and unsorted, moved as above, on one thread, per point; copying the previous answers is included.",
    ),
    ("one-step-batch", "One step from previous answers", "The same with one local step per point."),
    ("inversion", "Inversion", "`invert` of points on the shape, certified."),
    (
        "all-feet",
        "All feet",
        "`feet_within` 1.5 times the least distance, points at middle distance, certified.",
    ),
    ("preparation", "Preparation of a projector", "Per Bézier piece, once for each shape."),
    (
        "local",
        "Local iterations on any parametric shape",
        "From starts a hundredth of the domain away to full convergence (1e-12), with all safeguards.",
    ),
    (
        "frames",
        "Distance fields: principal frames",
        "Per query: foot, axes and principal curvatures, what a step of a registration or a fit asks of a shape for each point; on \
         all threads.",
    ),
    (
        "models",
        "Distance fields: quadratic models",
        "Per query: the quadratic model of the squared distance, from frames.",
    ),
    (
        "register",
        "Registration",
        "Per registration of that many points from 10 degrees away, with the default settings; and the preparation of a cloud as a \
         shape to register to.",
    ),
    ("start", "Coarse start", "Per search without an initial pose, and its preparation for a model."),
    ("views", "Many views", "Per registration of all views, without initial poses."),
    (
        "curve-fit",
        "Fits of curves",
        "Per point and iteration, a projection onto the curve and its share of the normal equations, of their solution and of all \
         preparations included: `points-controls-term`, all terms in the same loop.",
    ),
    ("surface-fit", "Fits of surfaces", "The same for surfaces, closed in one direction, on all threads."),
    (
        "multilevel",
        "Multilevel B-splines",
        "Per datum, a wavy height field approximated within a thousandth; on all threads.",
    ),
    (
        "hidden-points",
        "Hidden points",
        "Per point of a lobed vase, seen from one side: the convex hull of all points with exact predicates included.",
    ),
    (
        "parameters",
        "From a cloud to parameters",
        "Per point of a lobed vase with noise, from no order at all to a base surface and the footpoints on it, on all threads.",
    ),
];

/// Runs the command.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    let (mut quick, mut report_only) = (false, false);
    for argument in arguments {
        match argument.as_str() {
            "--quick" => quick = true,
            "--report-only" => report_only = true,
            other => return Err(Failure::Usage(format!("bench does not know `{other}`"))),
        }
    }
    let root = workspace::root();
    let since = if report_only { SystemTime::UNIX_EPOCH } else { SystemTime::now() };
    let metadata = metadata(&root)?;
    if !report_only {
        for (package, bench) in bench_targets(&metadata) {
            run_bench(&root, &package, &bench, quick)?;
        }
    }
    let target = PathBuf::from(metadata["target_directory"].as_str().unwrap_or("target"));
    let mut times = BTreeMap::new();
    collect(&target.join("criterion"), since, &mut times)?;
    let memory = memory::per_piece().map_err(|error| Failure::Failed(error.to_string()))?;
    let text = report(&times, &memory, &processor(), quick).map_err(Failure::Failed)?;
    std::fs::write(root.join(REPORT), text)
        .map_err(|error| Failure::Failed(format!("{REPORT} cannot be written: {error}")))?;
    println!("{} benchmarks written to {REPORT}", times.len());
    Ok(())
}

fn metadata(root: &Path) -> Result<Value, Failure> {
    let output = cargo(root)
        .args(["metadata", "--no-deps", "--format-version", "1"])
        .output()
        .map_err(|error| Failure::Failed(format!("cargo metadata did not start: {error}")))?;
    if !output.status.success() {
        let message = String::from_utf8_lossy(&output.stderr);
        return Err(Failure::Failed(format!("cargo metadata failed: {}", message.trim())));
    }
    serde_json::from_slice(&output.stdout).map_err(|error| {
        Failure::Failed(format!("cargo metadata printed something that is not JSON: {error}"))
    })
}

fn cargo(root: &Path) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root);
    command
}

/// Package and name of every bench target, in the order of the packages.
fn bench_targets(metadata: &Value) -> Vec<(String, String)> {
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let mut found = Vec::new();
    for package in list(&metadata["packages"]) {
        for target in list(&package["targets"]) {
            if list(&target["kind"]).iter().any(|kind| kind == "bench")
                && let (Some(package), Some(target)) = (package["name"].as_str(), target["name"].as_str())
            {
                found.push((package.to_owned(), target.to_owned()));
            }
        }
    }
    found
}

fn run_bench(root: &Path, package: &str, bench: &str, quick: bool) -> Result<(), Failure> {
    println!("{package}: {bench}");
    let mut command = cargo(root);
    // With the features of the whole workspace, so that all benchmarks share one build of the dependencies.
    command.args(["bench", "--workspace", "--bench", bench, "--"]);
    if quick {
        command.arg("--quick");
    }
    let status =
        command.status().map_err(|error| Failure::Failed(format!("cargo bench did not start: {error}")))?;
    if status.success() {
        Ok(())
    } else {
        Err(Failure::Failed(format!("the benchmark `{bench}` of {package} failed")))
    }
}

/// Nanoseconds per element by identifier, of all results below `folder` that are not older than `since`.
fn collect(folder: &Path, since: SystemTime, times: &mut BTreeMap<String, f64>) -> Result<(), Failure> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Ok(()) };
    for path in entries.flatten().map(|entry| entry.path()).filter(|path| path.is_dir()) {
        if path.file_name().is_some_and(|name| name == "new") {
            let sample = path.join("sample.json");
            let changed = std::fs::metadata(&sample).and_then(|data| data.modified());
            if changed.is_ok_and(|changed| changed >= since) {
                let (benchmark, sample) = (read(&path.join("benchmark.json"))?, read(&sample)?);
                let (id, time) = time_per_element(&benchmark, &sample).ok_or_else(|| {
                    Failure::Failed(format!("{}: not the files that criterion 0.8 writes", path.display()))
                })?;
                times.insert(id, time);
            }
        } else {
            collect(&path, since, times)?;
        }
    }
    Ok(())
}

fn read(path: &Path) -> Result<Value, Failure> {
    let failed = |error: String| Failure::Failed(format!("{}: {error}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|error| failed(error.to_string()))?;
    serde_json::from_str(&text).map_err(|error| failed(error.to_string()))
}

/// The shortest time per iteration among the samples, divided by the number of elements. The work is the same in every
/// sample, so that whatever is longer was disturbed by other programs; medians of a busy machine differ by half.
fn time_per_element(benchmark: &Value, sample: &Value) -> Option<(String, f64)> {
    let id = benchmark["full_id"].as_str()?.to_owned();
    let (times, iterations) = (sample["times"].as_array()?, sample["iters"].as_array()?);
    let per_iteration = times.iter().zip(iterations).filter_map(|(t, n)| Some(t.as_f64()? / n.as_f64()?));
    let time = per_iteration.reduce(f64::min)?;
    let elements = benchmark["throughput"]["Elements"].as_f64().unwrap_or(1.0);
    Some((id, time / elements))
}

/// What the operating system says about the processor, if it does.
fn processor() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let field = |name: &str| {
        let line = info.lines().find(|line| line.starts_with(name))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    };
    let name = field("model name").unwrap_or_else(|| std::env::consts::ARCH.to_owned());
    let has = |flag: &str| field("flags").is_some_and(|flags| flags.split(' ').any(|f| f == flag));
    let vectors = if has("avx512f") {
        ", AVX-512"
    } else if has("avx2") {
        ", AVX2"
    } else {
        ""
    };
    match (field("cpu family"), field("model\t")) {
        (Some(family), Some(model)) => format!("{name} (family {family}, model {model}{vectors})"),
        _ => format!("{name}{vectors}"),
    }
}

fn report(
    times: &BTreeMap<String, f64>,
    memory: &[(&str, usize)],
    processor: &str,
    quick: bool,
) -> Result<String, String> {
    let unit =
        *times.get(UNIT).ok_or_else(|| format!("there is no result of `{UNIT}`, the unit of the report"))?;
    let mut text = format!(
        "# Benchmarks\n\nMade by `cargo xtask bench{}`; do not edit.\n\nAll numbers are ratios of times: 1 is one jet of a \
         bicubic polynomial B-spline surface (point and five derivatives, `{UNIT}`),\nwhich took {unit:.0} ns here. Rows with \
         several elements are per element. Fastest samples of one thread, default build flags\n(no `target-cpu`; vector instructions \
         are chosen at run time).\n\nMachine: {processor}.\n",
        if quick { " --quick" } else { "" },
    );
    let mut groups: BTreeMap<&str, Vec<(&str, f64)>> = BTreeMap::new();
    for (id, time) in times {
        let (group, name) = id.split_once('/').unwrap_or((id, ""));
        groups.entry(group).or_default().push((name, time / unit));
    }
    let known = GROUPS.iter().map(|(group, ..)| *group);
    let others = groups.keys().copied().filter(|group| !GROUPS.iter().any(|(name, ..)| name == group));
    for group in known.chain(others) {
        let Some(rows) = groups.get(group) else { continue };
        let listed = GROUPS.iter().find(|(name, ..)| *name == group);
        let (title, about) = listed.map_or((group, ""), |(_, title, about)| (*title, *about));
        let _ = writeln!(text, "\n## {title}\n");
        if !about.is_empty() {
            let _ = writeln!(text, "{about}\n");
        }
        let _ = writeln!(text, "| {group} | ratio |\n|---|---:|");
        for (name, ratio) in rows {
            let _ = writeln!(text, "| {name} | {} |", three_digits(*ratio));
        }
    }
    let _ = writeln!(text, "\n## Memory of a projector\n\n| shape | bytes per piece |\n|---|---:|");
    for (name, bytes) in memory {
        let _ = writeln!(text, "| {name} | {bytes} |");
    }
    Ok(text)
}

/// Three significant digits, more before the point where there are more.
fn three_digits(x: f64) -> String {
    let decimals = if x >= 100.0 {
        0
    } else if x >= 10.0 {
        1
    } else if x >= 1.0 {
        2
    } else {
        3
    };
    format!("{x:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn times_are_per_element() {
        let benchmark = json!({ "full_id": "jet/bicubic/single", "throughput": { "Elements": 1024 } });
        let sample = json!({ "times": [90000.0, 40960.0, 22000.0], "iters": [1.0, 2.0, 1.0] });
        assert_eq!(time_per_element(&benchmark, &sample), Some((UNIT.to_owned(), 20.0)));
        let benchmark = json!({ "full_id": "a/b", "throughput": null });
        assert_eq!(time_per_element(&benchmark, &sample), Some(("a/b".to_owned(), 20480.0)));
        assert_eq!(time_per_element(&json!({}), &sample), None);
    }

    #[test]
    fn bench_targets_of_all_packages_are_found() {
        let metadata = json!({ "packages": [
            { "name": "a", "targets": [{ "name": "a", "kind": ["lib"] }, { "name": "jets", "kind": ["bench"] }] },
            { "name": "b", "targets": [{ "name": "feet", "kind": ["bench"] }] },
        ]});
        let found = bench_targets(&metadata);
        assert_eq!(found, [("a".into(), "jets".into()), ("b".into(), "feet".into())]);
    }

    #[test]
    fn report_shows_ratios_only_and_unlisted_groups_last() {
        let times = [(UNIT, 40.0), ("batch/x", 10.0), ("aardvark/y", 4000.0)];
        let times = times.map(|(id, time)| (id.to_owned(), time)).into();
        let text = report(&times, &[("a shape", 123)], "a processor", true).unwrap();
        assert!(text.ends_with("| a shape | 123 |\n"), "{text}");
        assert!(text.contains("cargo xtask bench --quick") && text.contains("took 40 ns"), "{text}");
        assert!(text.contains("| bicubic/single | 1.00 |") && text.contains("| x | 0.250 |"), "{text}");
        assert!(text.contains("| y | 100 |"), "{text}");
        assert!(text.find("| x |").unwrap() < text.find("| y |").unwrap());
        assert!(report(&BTreeMap::new(), &[], "", false).unwrap_err().contains(UNIT));
    }
}
