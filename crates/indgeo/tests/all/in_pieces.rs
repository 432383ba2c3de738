//! Clouds that are read and written piece by piece: the same bytes as in memory, which is how standard input is read.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::{Bench, SQUARE, fixture};
use serde_json::Value;

/// Points of more than one piece, near the square of side 2; some are not finite.
const MANY: u32 = 300_000;

fn point(i: u32) -> [f64; 3] {
    let share = |step: f64| (f64::from(i) * step).fract();
    let z = if i % 997 == 13 { f64::NAN } else { 0.2 * share(0.732_050_8) - 0.1 };
    [2.0 * share(0.618_033_988), 2.0 * share(0.414_213_5), z]
}

/// Binary PLY, with normals that lean to all sides.
fn ply(count: u32) -> Vec<u8> {
    let names = ["x", "y", "z", "nx", "ny", "nz"].map(|name| format!("property double {name}\n")).concat();
    let head = format!("ply\nformat binary_little_endian 1.0\nelement vertex {count}\n{names}end_header\n");
    let mut bytes = head.into_bytes();
    for i in 0..count {
        let normal = [(f64::from(i) * 0.3).sin(), 0.2, (f64::from(i) * 0.7).cos()];
        point(i).iter().chain(&normal).for_each(|value| bytes.extend(value.to_le_bytes()));
    }
    bytes
}

fn xyz(count: u32) -> String {
    (0..count)
        .map(|i| {
            let [x, y, z] = point(i);
            format!("{x} {y} {z}\n")
        })
        .collect()
}

fn bench(count: u32) -> Bench {
    let bench = Bench::new();
    bench.put("square.json", SQUARE);
    bench.put("mesh.off", "OFF\n4 2 0\n0 0 0\n2 0 0\n2 2 0\n0 2 0\n3 0 1 2\n3 0 2 3\n");
    bench.put("scan.ply", ply(count));
    bench.put("scan.xyz", xyz(count));
    bench
}

/// Runs the command with the points as a file and as standard input; results and files must be the same.
fn compare(bench: &Bench, command: &str, points: &str, options: &str, files: &[&str]) {
    let input = bench.read(points);
    let outcome = |name: &str, input: &[u8]| {
        let arguments = command.replace("POINTS", name) + " " + options + " --no-timings --json report.json";
        let run = bench.run_with(&arguments, input);
        assert!(run.code < 2, "{arguments}: {}", run.stderr);
        let report: Value = serde_json::from_str(&bench.text("report.json")).unwrap();
        let mut read = report["inputs"][1].clone();
        read["path"] = Value::Null;
        let stderr = run.stderr.replace(&format!("{name}: "), "").replace("standard input: ", "");
        let warnings = report["warnings"].as_array().unwrap().len();
        let written: Vec<Vec<u8>> = files.iter().map(|file| bench.read(file)).collect();
        (
            run.code,
            run.stdout,
            stderr,
            warnings,
            read,
            report["results"].clone(),
            report["outputs"].clone(),
            written,
        )
    };
    let (whole, pieces) = (outcome("-", &input), outcome(points, b""));
    assert!(whole.7 == pieces.7, "{command} {points} {options}: the files differ");
    assert_eq!((whole.0, whole.1, whole.2), (pieces.0, pieces.1, pieces.2), "{command} {points} {options}");
    assert_eq!(
        (whole.3, whole.4, whole.5, whole.6),
        (pieces.3, pieces.4, pieces.5, pieces.6),
        "{command} {points} {options}"
    );
}

#[test]
fn clouds_of_several_pieces_have_the_bytes_of_a_run_in_memory() {
    let bench = bench(MANY);
    for options in ["-o out.ply", "-o out.csv --drop-non-finite"] {
        let file = if options.contains("ply") { "out.ply" } else { "out.csv" };
        compare(&bench, "project mesh.off POINTS", "scan.ply", options, &[file]);
        compare(&bench, "inspect mesh.off POINTS -t 0.05", "scan.ply", options, &[file]);
    }
    compare(&bench, "inspect mesh.off POINTS -t 0.05", "scan.xyz", "-o out.ply", &["out.ply"]);
}

#[test]
fn all_models_and_options_have_the_bytes_of_a_run_in_memory() {
    let bench = bench(3000);
    bench.put("pose.json", "{\"matrix\": [[1, 0, 0, 0.01], [0, 1, 0, 0], [0, 0, 1, 0.02], [0, 0, 0, 1]]}");
    for points in ["scan.ply", "scan.xyz"] {
        for out in ["out.ply", "out.csv"] {
            compare(&bench, "project square.json POINTS", points, &format!("-o {out}"), &[out]);
            compare(
                &bench,
                "inspect square.json POINTS -t 0.05",
                points,
                &format!("-o {out} --transform pose.json"),
                &[out],
            );
        }
    }
    compare(
        &bench,
        "project square.json POINTS",
        "scan.ply",
        "-o out.ply --max-angle 60 --mode fast",
        &["out.ply"],
    );
    compare(&bench, "inspect mesh.off POINTS -t 0.05", "scan.ply", "-o out.csv --along normal", &["out.csv"]);
    // The page names the file of the points.
    let page = "-t 0.05 --transform pose.json --picture 500 --report page.html";
    assert_eq!(bench.run(&format!("inspect square.json scan.ply {page}")).code, 1);
    let pieces = bench.text("page.html").replace("scan.ply", "-");
    assert_eq!(bench.run_with(&format!("inspect square.json - {page}"), &bench.read("scan.ply")).code, 1);
    assert!(pieces == bench.text("page.html"), "the pages differ");
    // Other formats are written as a whole.
    compare(
        &bench,
        "inspect mesh.off POINTS -t 0.05",
        "scan.ply",
        "-o out.las --drop-non-finite",
        &["out.las"],
    );
}

#[test]
fn several_files_have_a_row_per_point() {
    let bench = bench(3000);
    bench.put("other.xyz", xyz(500));
    let run = bench.run("inspect mesh.off scan.ply other.xyz -t 0.05 -o both.csv --quiet");
    assert!(run.code < 2, "{}", run.stderr);
    let alone = |name: &str| {
        assert!(bench.run(&format!("inspect mesh.off {name} -t 0.05 -o one.csv --quiet")).code < 2);
        bench.text("one.csv")
    };
    // By their paths: other.xyz before scan.ply.
    let (first, second) = (alone("other.xyz"), alone("scan.ply"));
    assert_eq!(bench.text("both.csv"), first + second.split_once('\n').unwrap().1);
}

#[test]
fn nothing_half_written_stays_behind() {
    let bench = bench(200);
    let good = bench.read("scan.ply");
    bench.put("nan.xyz", "nan 0 0\n1 nan 0\n2 0 nan\n");
    bench.put("late.xyz", xyz(200) + "1 2\n");
    bench.put("short.ply", &good[..good.len() - 7]);
    let before = bench.files();
    for (points, what) in [
        ("nan.xyz", "no point has finite"),
        ("late.xyz", "2 columns"),
        ("short.ply", "truncated"),
        ("none.ply", "check the path"),
    ] {
        for command in ["project mesh.off", "inspect mesh.off -t 1"] {
            let run = bench.run(&format!("{command} {points} -o out.csv"));
            assert!(run.code == 2 && run.stderr.contains(what), "{command} {points}: {}", run.stderr);
            assert_eq!(bench.files(), before, "{command} {points}");
        }
    }
    for command in [
        "project mesh.off scan.xyz --max-angle 60 -o out.csv",
        "inspect mesh.off scan.xyz -t 1 --along normal -o out.csv",
    ] {
        let run = bench.run(command);
        assert!(
            run.code == 2 && run.stderr.contains("scan.xyz: the points have no normals"),
            "{}",
            run.stderr
        );
        assert_eq!(bench.files(), before);
    }
}

#[test]
fn large_files_are_converted_and_described_with_the_bytes_of_the_whole() {
    let bench = Bench::new();
    // Just large enough to be read in pieces.
    bench.put("large.ply", ply(710_000));
    assert!(bench.read("large.ply").len() > 32 << 20);
    let input = bench.read("large.ply");
    for (name, options) in [("out.ply", ""), ("out.pts", "--drop-non-finite")] {
        let run = bench.run(&format!("convert large.ply {name} {options} --json report.json --quiet"));
        assert_eq!(run.code, 0, "{}", run.stderr);
        let (pieces, report) = (bench.read(name), bench.text("report.json"));
        let run = bench.run_with(&format!("convert - {name} {options} --json report.json --quiet"), &input);
        assert_eq!(run.code, 0, "{}", run.stderr);
        assert!(pieces == bench.read(name), "{name}");
        let results = |text: &str| serde_json::from_str::<Value>(text).unwrap()["results"].clone();
        assert_eq!(results(&report), results(&bench.text("report.json")));
    }
    let facts = |name: &str, input: &[u8]| {
        let run = bench.run_with(&format!("info {name} --json -"), input);
        assert_eq!(run.code, 0, "{}", run.stderr);
        let mut fact = run.report()["results"][0].clone();
        fact["path"] = Value::Null;
        fact
    };
    assert_eq!(facts("large.ply", b""), facts("-", &input));
}

#[test]
fn samples_of_large_clouds_are_stated() {
    let bench = bench(3000);
    let run = bench.run("register mesh.off scan.ply --transform pose.json --sample 500 --start given");
    assert!(run.code < 2, "{}", run.stderr);
    let stated =
        "scan.ply: of 3000 points an even sample of 500 is used, and what is said holds for these (--sample)";
    assert!(run.stderr.contains(stated), "{}", run.stderr);
    let pose: Value = serde_json::from_str(&bench.text("pose.json")).unwrap();
    assert_eq!(pose["points"], 500);
    let run = bench.run("fit-surface scan.ply -o fit.json --sample 700 --control-points 4x4");
    assert!(run.code < 2 && run.stderr.contains("even sample of 700"), "{}", run.stderr);
    // The moved points are all of them.
    let run = bench.run("register mesh.off scan.ply -o moved.xyz --sample 500 --start given");
    assert!(run.code < 2 && !run.stderr.contains("sample"), "{}", run.stderr);
    assert_eq!(bench.text("moved.xyz").lines().filter(|line| !line.starts_with('#')).count(), 3000);
}

#[test]
fn a_mistaken_unit_is_told_before_a_scan_of_several_pieces_is_measured() {
    let bench = Bench::new();
    // 25.4 times as large as the part of 74 mm, in rows from one end to the other: no piece alone tells.
    let count = 150_000u32;
    let mut scan = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {count}\nproperty double x\nproperty double y\nproperty double z\nend_header\n"
    )
    .into_bytes();
    for i in 0..count {
        let x = 1880.0 * f64::from(i) / f64::from(count);
        for value in [x, f64::from(i % 7), f64::from(i % 11)] {
            scan.extend(value.to_le_bytes());
        }
    }
    bench.put("scan.ply", scan);
    bench.put("part.step", std::fs::read(fixture("cad/nema-17-bracket.step")).unwrap());
    let run = bench.run("inspect part.step scan.ply -t 1");
    let told: Vec<&str> = run.stderr.lines().filter(|line| line.contains("near the 25.4")).collect();
    assert!(run.code == 1 && told.len() == 1 && told[0].contains("the scan 1880"), "{}", run.stderr);
    // Nothing is printed where nobody reads, and the report has it.
    let run = bench.run("inspect part.step scan.ply -t 1 --quiet --json -");
    assert!(run.report()["warnings"][0].as_str().unwrap().contains("near the 25.4"), "{}", run.stdout);
}
