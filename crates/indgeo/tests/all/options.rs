//! Options mean the same for every command, and errors name them as they are typed.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::inputs::{bench, cube_points, lines};
use serde_json::Value;

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
        (
            "fit-surface sheet.xyz -o s.json --control-points 2x2",
            ["--control-points is 2, it must be more than the degree", "--help"],
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
fn the_help_of_every_command_says_its_exit_status() {
    let bench = bench();
    let run = bench.run("--help");
    let commands = run.stdout.split("Commands:").nth(1).unwrap().split("Options:").next().unwrap();
    let names: Vec<&str> = commands
        .lines()
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|name| *name != "help")
        .collect();
    assert!(names.len() > 12, "{names:?}");
    for name in names {
        let help = bench.run(&format!("{name} --help")).stdout;
        for part in ["xit status 0", "2:", "130"] {
            assert!(help.contains(part), "{name}: {part} is missing in\n{help}");
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
fn only_rigid_motions_are_applied() {
    let bench = bench();
    let matrix =
        |x: &str, y: &str, z: &str| format!("{{\"matrix\": [[{x}, 0], [{y}, 0], [{z}, 0.5], [0, 0, 0, 1]]}}");
    for (name, content, message) in [
        (
            "shear.json",
            matrix("1, 0.05, 0", "0, 1, 0", "0, 0, 1"),
            "it stretches by 1.025312 in one direction and by 0.975312",
        ),
        (
            "stretch.json",
            matrix("1, 0, 0", "0, 1, 0", "0, 0, 1.01"),
            "the lengths 1.000000, 1.000000, 1.010000",
        ),
        ("scale.json", matrix("2, 0, 0", "0, 2, 0", "0, 0, 2"), "it scales by 2.000000"),
        ("mirror.json", matrix("-1, 0, 0", "0, 1, 0", "0, 0, 1"), "a reflection"),
        ("flat.json", matrix("1, 0, 0", "0, 1, 0", "0, 0, 0"), "singular"),
    ] {
        bench.put(name, content);
        let run = bench.run(&format!("inspect model.json points.xyz -t 1 --transform {name} -o out.csv"));
        assert!(run.code == 2 && run.stderr.contains(message), "{name}: {} {}", run.code, run.stderr);
        assert!(!bench.path("out.csv").exists());
    }
    bench.put("turn.json", matrix("0, -1, 0", "1, 0, 0", "0, 0, 1"));
    assert_eq!(bench.run("inspect model.json points.xyz -t 9 --transform turn.json").code, 0);
    // What `register --scale` writes may scale.
    let half = lines(cube_points().map(|p| p.map(|c| 0.5 * c + 0.1)));
    bench.put("half.xyz", half);
    let run = bench.run("register cube.off half.xyz --scale --start given --transform pose.json");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let run = bench.run("inspect cube.off half.xyz -t 1e-6 --transform pose.json");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
}

#[test]
fn results_go_to_standard_output() {
    let bench = bench();
    for (arguments, file) in [
        ("project model.json points.xyz", "out.csv"),
        ("inspect model.json points.xyz -t 1", "out.csv"),
        ("register cube.off around.xyz", "out.csv"),
        ("register cube.off ball.off --start given --max-iterations 5", "out.obj"),
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
