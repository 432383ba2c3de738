//! One rule for every command: what its exit status means, and that its report says the same.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::{Bench, CUBE, SQUARE, fixture};
use serde_json::Value;
use std::f64::consts::TAU;
use std::fmt::Write;

/// Points that look random, always the same, in the unit cube.
fn random(count: usize) -> impl Iterator<Item = [f64; 3]> {
    let share = |i: usize, step: f64| (i as f64 * step).fract();
    (0..count).map(move |i| [share(i, 0.819_172_513), share(i, 0.671_043_607), share(i, 0.549_700_478)])
}

fn lines(points: impl Iterator<Item = [f64; 3]>) -> String {
    points.fold(String::new(), |mut text, [x, y, z]| {
        writeln!(text, "{x} {y} {z}").unwrap();
        text
    })
}

/// A wavy sheet over [0, 3] × [0, 2], from `from` to `to` in x.
fn sheet(from: f64, to: f64, count: usize) -> impl Iterator<Item = [f64; 3]> {
    let at = move |[x, y, _]: [f64; 3]| {
        let (x, y) = (from + (to - from) * x, 2.0 * y);
        [x, y, 0.3 * (2.0 * x).sin() * (1.5 * y + 0.3 * x).cos() + 0.1 * x * x]
    };
    random(count).map(at)
}

/// A vase that is closed around its axis.
fn vase(count: usize) -> impl Iterator<Item = [f64; 3]> {
    random(count).map(|[a, h, _]| {
        let (a, h) = (TAU * a, h);
        let r = 3.0 + 0.6 * (4.0 * h).sin() + 0.4 * (3.0 * a).cos();
        [r * a.cos(), r * a.sin(), 10.0 * h]
    })
}

/// A folder with an input of every kind.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.put("model.json", SQUARE);
    bench.put("cube.off", CUBE);
    bench.put("points.xyz", "0.5 1 0.03\n1 0.25 -0.0625\n1 1 0.2\n");
    let circle = (0..60).map(|i| f64::from(i) * TAU / 60.0).map(|a| [2.0 * a.cos(), a.sin(), 0.0]);
    bench.put("ring.xyz", lines(circle));
    bench.put("sheet.xyz", lines(sheet(0.0, 3.0, 900)));
    bench.put("vase.xyz", lines(vase(3000)));
    bench.put("left.xyz", lines(sheet(0.0, 2.0, 2500)));
    bench.put("right.xyz", lines(sheet(1.0, 3.0, 2500)));
    bench.put("far.xyz", lines(sheet(0.0, 2.0, 2500).map(|[x, y, z]| [x + 50.0, y, z])));
    bench.put("strip.xyz", lines(random(300).map(|[x, y, _]| [3.0 * x, 2.0 * y, 0.4 * x * (1.0 - y)])));
    bench.put("ball.off", ball());
    // Off the cube, all around it.
    bench.put("around.xyz", lines(cube_points().map(|p| p.map(|c| c + 0.02))));
    bench
}

/// Points on the six sides of the unit cube.
fn cube_points() -> impl Iterator<Item = [f64; 3]> {
    random(600).enumerate().map(|(i, mut p)| {
        p[i % 3] = f64::from(u8::from(i % 2 == 0));
        p
    })
}

/// A sphere of triangles: an octahedron, its sides divided into 6 × 6.
fn ball() -> String {
    const SIDE: usize = 6;
    let (mut corners, mut faces) = (Vec::<[f64; 3]>::new(), Vec::new());
    let index = |corners: &mut Vec<[f64; 3]>, p: [f64; 3]| {
        let norm = p.iter().map(|c| c * c).sum::<f64>().sqrt();
        let p = p.map(|c| c / norm);
        let near = |q: &[f64; 3]| q.iter().zip(&p).all(|(a, b)| (a - b).abs() < 1e-9);
        corners.iter().position(near).unwrap_or_else(|| {
            corners.push(p);
            corners.len() - 1
        })
    };
    for octant in 0..8u8 {
        let sign = [0, 1, 2].map(|axis| if octant >> axis & 1 == 0 { 1.0 } else { -1.0 });
        let odd = octant.count_ones() % 2 == 1;
        for i in 0..SIDE {
            for j in 0..SIDE - i {
                let mut corner = |i: usize, j: usize| {
                    let p = [i as f64, j as f64, (SIDE - i - j) as f64];
                    index(&mut corners, [p[0] * sign[0], p[1] * sign[1], p[2] * sign[2]])
                };
                let mut add =
                    |a: usize, b: usize, c: usize| faces.push(if odd { [a, c, b] } else { [a, b, c] });
                let [a, b, c] = [corner(i, j), corner(i + 1, j), corner(i, j + 1)];
                add(a, b, c);
                if i + j + 2 <= SIDE {
                    let d = corner(i + 1, j + 1);
                    add(b, d, c);
                }
            }
        }
    }
    let mut text = format!("OFF\n{} {} 0\n", corners.len(), faces.len());
    text.push_str(&lines(corners.into_iter()));
    for [a, b, c] in faces {
        writeln!(text, "3 {a} {b} {c}").unwrap();
    }
    text
}

/// A command with arguments for which it is done (0), with others for which the answer is no (1) and the status of the report then,
/// with a missing file (2), and with an option that makes no sense (2) and what the message says about it.
type Case =
    (&'static str, &'static str, &'static [(&'static str, &'static str)], &'static str, [&'static str; 2]);

const CASES: [Case; 9] = [
    (
        "project",
        "model.json points.xyz -o out.csv",
        &[],
        "model.json none.xyz -o out.csv",
        ["model.json points.xyz -o out.csv --relative-gap -1", "--relative-gap is -1"],
    ),
    (
        "inspect",
        "model.json points.xyz -t 1",
        &[("model.json points.xyz -t 0.1", "out_of_tolerance")],
        "model.json none.xyz -t 1",
        [
            "model.json points.xyz -t -0.1",
            "invalid value '-0.1' for '--tolerance <T>': it must be a positive length",
        ],
    ),
    (
        "register",
        "cube.off around.xyz -o out.xyz --start given",
        &[("cube.off around.xyz -o out.xyz --start given --max-iterations 1", "not_converged")],
        "cube.off none.xyz -o out.xyz",
        ["cube.off around.xyz -o out.xyz --max-iterations -3", "'--max-iterations <N>'"],
    ),
    (
        "register-views",
        "left.xyz right.xyz -o moved",
        &[
            ("left.xyz far.xyz -o moved --start given", "not_converged"),
            ("left.xyz right.xyz -o moved --start given --max-iterations 1", "not_converged"),
        ],
        "left.xyz none.xyz -o moved",
        [
            "left.xyz right.xyz -o moved --min-overlap -0.5",
            "for '--min-overlap <SHARE>': it must be a share from 0 to 1",
        ],
    ),
    (
        "fit-curve",
        "ring.xyz -o out.json",
        &[
            ("ring.xyz -o out.json --tolerance 1e-9 --max-control-points 6", "out_of_tolerance"),
            ("ring.xyz -o out.json --control-points 12 --max-iterations 1", "not_converged"),
        ],
        "none.xyz -o out.json",
        ["ring.xyz -o out.json --control-points 2", "--control-points is 2, it must be more than the degree"],
    ),
    (
        "fit-surface",
        "sheet.xyz -o out.json --control-points 8x8",
        &[
            (
                "sheet.xyz -o out.json --control-points 5x5 --max-control-points 25 --tolerance 1e-6",
                "out_of_tolerance",
            ),
            ("sheet.xyz -o out.json --control-points 8x8 --shape plane --max-iterations 1", "not_converged"),
        ],
        "none.xyz -o out.json",
        ["sheet.xyz -o out.json --tolerance -0.05", "'--tolerance <T>': it must be a positive length"],
    ),
    (
        "fit-ruled",
        "strip.xyz -o out.json --control-points 6x2",
        &[
            (
                "sheet.xyz -o out.json --control-points 6x2 --max-control-points 12 --tolerance 1e-6",
                "out_of_tolerance",
            ),
            ("sheet.xyz -o out.json --control-points 6x2 --max-iterations 1", "not_converged"),
        ],
        "none.xyz -o out.json",
        ["strip.xyz -o out.json --share 1.5 --tolerance 1", "'--share <SHARE>': it must be a share above 0"],
    ),
    (
        "fit-subdivision",
        "ball.off -o out.off --vertices 40",
        &[
            ("ball.off -o out.off --vertices 40 --tolerance 1e-9", "out_of_tolerance"),
            ("ball.off -o out.off --vertices 40 --max-iterations 1", "not_converged"),
        ],
        "none.off -o out.off",
        ["ball.off -o out.off --tolerance nan", "'--tolerance <T>': it must be a positive length"],
    ),
    (
        "parameterize",
        "vase.xyz -o out.json",
        &[],
        "none.xyz -o out.json",
        ["vase.xyz -o out.json --grid -3", "'--grid <NxM>'"],
    ),
];

#[test]
fn every_command_means_the_same_by_the_same_status() {
    let bench = bench();
    for (command, good, no, missing, [senseless, message]) in CASES {
        let run = |arguments: &str| {
            let run = bench.run(&format!("{command} {arguments} --json report.json --quiet"));
            let report = std::fs::read_to_string(bench.path("report.json")).unwrap_or_default();
            let _ = std::fs::remove_file(bench.path("report.json"));
            (run.code, run.stderr, serde_json::from_str::<Value>(&report).unwrap_or(Value::Null))
        };
        let (code, stderr, report) = run(good);
        assert_eq!((code, report["status"].as_str()), (0, Some("done")), "{command} {good}: {stderr}");
        for (arguments, status) in no {
            let (code, stderr, report) = run(arguments);
            assert_eq!(
                (code, report["status"].as_str()),
                (1, Some(*status)),
                "{command} {arguments}: {stderr}"
            );
            if arguments.contains("--max-iterations") {
                assert_eq!(report["results"]["status"], "max_iterations", "{command} {arguments}");
            }
        }
        let (code, stderr, report) = run(missing);
        assert_eq!((code, report["status"].as_str()), (2, Some("error")), "{command} {missing}");
        assert!(stderr.contains("none.") && stderr.contains("check the path"), "{command}: {stderr}");
        let (code, stderr, _) = run(senseless);
        assert!(code == 2 && stderr.contains(message), "{command} {senseless}: {code} {stderr}");
    }
}

#[test]
fn commands_that_have_no_answer_to_give_are_done_or_fail() {
    let bench = bench();
    for (arguments, code, status) in [
        ("convert points.xyz out.ply", 0, "done"),
        ("convert none.xyz out.ply", 2, "error"),
        ("convert points.xyz out.stl", 2, "error"),
        ("info points.xyz model.json cube.off", 0, "done"),
        ("info none.xyz", 2, "error"),
        ("demo --data none", 2, "error"),
        ("selftest", 0, "done"),
    ] {
        let run = bench.run(&format!("{arguments} --json -"));
        assert_eq!(
            (run.code, run.report()["status"].as_str()),
            (code, Some(status)),
            "{arguments}: {}",
            run.stderr
        );
    }
    for arguments in ["convert points.xyz out.ply --no-such-option", "info", "demo --mode best", "selftest x"]
    {
        assert_eq!(bench.run(arguments).code, 2, "{arguments}");
    }
}

#[test]
fn options_are_named_as_they_are_typed() {
    let bench = bench();
    for (arguments, parts) in [
        (
            "fit-curve ring.xyz -o c.json --control-points 12 --tolerance 1",
            ["--control-points <N>", "--tolerance <T>"],
        ),
        ("fit-curve ring.xyz -o c.json --max-control-points 2", ["--max-control-points is 2", "--help"]),
        (
            "fit-surface sheet.xyz -o s.json --init model.json --control-points 1x1",
            ["--control-points is 1", "--help"],
        ),
        ("register-views left.xyz right.xyz -o m --neighbours 2", ["--neighbours is 2", "--help"]),
        ("register cube.off around.xyz -o m.xyz --lock w", ["--lock <LIST>", "possible values: tx"]),
        ("convert points.xyz - --format docx", ["--format <FORMAT>", "choose ply"]),
        ("fit-curve ring.xyz -o - --json -", ["standard output (`-`) is named twice", "file"]),
        ("register-views left.xyz right.xyz -o -", ["DIR", "folder"]),
    ] {
        let run = bench.run(arguments);
        assert!(run.code == 2 && run.stdout.is_empty(), "{arguments}: {} {}", run.code, run.stdout);
        for part in parts {
            assert!(run.stderr.contains(part), "{arguments}: {}", run.stderr);
        }
    }
}

#[test]
fn a_plane_can_be_locked() {
    let bench = bench();
    for (short, long) in [("z", "tz,rx,ry"), ("x", "tx,ry,rz"), ("y,tx", "ty,rx,rz,tx")] {
        let matrices = [short, long].map(|locks| {
            let run = bench.run(&format!("register cube.off around.xyz --transform - --lock {locks}"));
            assert_eq!(run.code, 0, "{locks}: {}", run.stderr);
            serde_json::from_str::<Value>(&run.stdout).unwrap()["matrix"].clone()
        });
        assert_eq!(matrices[0], matrices[1], "{short}");
    }
    let run = bench.run("register cube.off around.xyz --transform - --lock z");
    let matrix = &serde_json::from_str::<Value>(&run.stdout).unwrap()["matrix"];
    let entry = |i: usize, j: usize| matrix[i][j].as_f64().unwrap();
    assert!(entry(2, 3) == 0.0 && entry(0, 3).abs() > 0.01 && entry(1, 3).abs() > 0.01, "{matrix}");
    assert_eq!([entry(0, 2), entry(1, 2), entry(2, 0), entry(2, 1)], [0.0; 4]);
}

#[test]
fn results_go_to_standard_output() {
    let bench = bench();
    for (arguments, file) in [
        ("project model.json points.xyz", "out.csv"),
        ("inspect model.json points.xyz -t 1", "out.csv"),
        ("register cube.off around.xyz", "out.csv"),
        ("register cube.off ball.off", "out.obj"),
        ("fit-curve ring.xyz", "out.json"),
        ("fit-surface sheet.xyz --control-points 8x8", "out.json"),
        ("fit-ruled strip.xyz --control-points 6x2", "out.json"),
        ("fit-subdivision ball.off --vertices 40", "out.obj"),
        ("parameterize vase.xyz", "out.json"),
    ] {
        let before = bench.files();
        let stream = bench.run(&format!("{arguments} -o -"));
        assert_eq!(bench.files(), before, "{arguments}");
        let filed = bench.run(&format!("{arguments} -o {file} --quiet"));
        assert_eq!(stream.code, filed.code, "{arguments}: {}", stream.stderr);
        assert!(!stream.stdout.is_empty() && stream.stdout == bench.text(file), "{arguments}");
        std::fs::remove_file(bench.path(file)).unwrap();
    }
    // The format by an option.
    let run = bench.run("project model.json points.xyz -o - --format json");
    assert_eq!(serde_json::from_str::<Value>(&run.stdout).unwrap()["points"], 3);
    assert!(bench.run("convert cube.off - --format ply --ascii").stdout.starts_with("ply\nformat ascii"));
    assert_eq!(bench.run("convert points.xyz -").stdout, "x,y,z\n0.5,1,0.03\n1,0.25,-0.0625\n1,1,0.2\n");
    // One command feeds the next.
    let moved = bench.run("register cube.off around.xyz -o - --format xyz");
    let judged = bench.run_with("inspect cube.off - -t 1e-6", moved.stdout.as_bytes());
    assert_eq!((moved.code, judged.code), (0, 0), "{}{}", moved.stderr, judged.stdout);
}

#[cfg(target_os = "linux")]
mod interrupts {
    use super::*;
    use std::path::Path;
    use std::process::{Child, Command, Stdio};
    use std::time::{Duration, Instant};

    /// Waits until the program answers signals itself.
    fn wait_for_handler(child: &Child) {
        let asked = Instant::now();
        // The mask of caught signals; bit 1 is that of SIGINT.
        let caught = |status: &str| {
            let mask = status.lines().find_map(|line| line.strip_prefix("SigCgt:"))?;
            u64::from_str_radix(mask.trim(), 16).ok()
        };
        while asked.elapsed() < Duration::from_secs(20) {
            let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
            if caught(&status).is_some_and(|mask| mask & 2 != 0) {
                // The command itself begins right after.
                std::thread::sleep(Duration::from_millis(100));
                return;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Every command that waits for an input, or works for a while, is told to stop.
    #[test]
    fn an_interrupt_is_reported_by_every_command() {
        let bench = bench();
        let pipe = |path: &Path| assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
        pipe(&bench.path("pipe.xyz"));
        for folder in ["data", "data/scans", "data/demo"] {
            std::fs::create_dir(bench.path(folder)).unwrap();
        }
        for file in ["scans/stud-bolt.ply", "demo/stud-bolt-placement.json"] {
            std::fs::copy(fixture(file), bench.path("data").join(file)).unwrap();
        }
        pipe(&bench.path("data/demo/stud-bolt-model.json"));
        let cases = [
            ("project", "model.json - -o out.csv", 1),
            ("inspect", "model.json - -t 1 -o out.csv --report out.html", 1),
            ("register", "cube.off - -o out.ply --transform out.json", 1),
            ("register-views", "left.xyz pipe.xyz -o out", 1),
            ("fit-curve", "- -o out.json", 0),
            ("parameterize", "- -o out.json", 0),
            ("fit-surface", "- -o out.json", 0),
            ("fit-ruled", "- -o out.json", 0),
            ("fit-subdivision", "- -o out.obj", 0),
            ("convert", "- out.ply", 0),
            ("info", "points.xyz -", 1),
            ("demo", "--data data --out out", 0),
            ("selftest", "", 0),
        ];
        for (number, (command, arguments, inputs)) in cases.into_iter().enumerate() {
            let signal = ["INT", "TERM", "HUP"][number % 3];
            let child = Command::new(env!("CARGO_BIN_EXE_indgeo"))
                .arg(command)
                .args(arguments.split_whitespace())
                .args(["--json", "report.json"])
                .current_dir(bench.path(""))
                .stdin(Stdio::piped())
                .stdout(Stdio::piped())
                .stderr(Stdio::piped())
                .spawn()
                .unwrap();
            wait_for_handler(&child);
            let kill = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status();
            assert!(kill.unwrap().success());
            // Standard input stays open: it is the signal that ends the program.
            let mut child = child;
            let input = child.stdin.take();
            let output = child.wait_with_output().unwrap();
            drop(input);
            let stderr = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(130), "{command}: {stderr}");
            assert!(stderr.contains("interrupted: "), "{command}: {stderr}");
            let report: Value = serde_json::from_str(&bench.text("report.json")).unwrap();
            bench.check_report(&report, 130);
            assert_eq!((&report["command"], &report["status"]), (&command.into(), &"cancelled".into()));
            assert_eq!(report["inputs"].as_array().unwrap().len(), inputs, "{command}");
            assert_eq!(report["outputs"], serde_json::json!([]), "{command}");
            assert!(report["results"].is_null(), "{command}");
            std::fs::remove_file(bench.path("report.json")).unwrap();
            let left: Vec<String> = bench
                .files()
                .into_iter()
                .filter(|name| name.starts_with("out.") || name.contains(".tmp"))
                .collect();
            assert_eq!(left, Vec::<String>::new(), "{command}");
        }
    }
}
