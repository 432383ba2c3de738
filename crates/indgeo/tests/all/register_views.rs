//! `indgeo register-views` as a user runs it.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common;
use crate::common::Bench;
use industrial_geometry::mesh::nalgebra::{Rotation3, Vector3};
use serde_json::Value;
use std::fmt::Write;

/// Numbers in [0, 1) that look random, always the same.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 ^ (self.0 >> 29)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A smooth closed body without symmetry, some 2 in diameter.
fn body(d: &Vector3<f64>) -> Vector3<f64> {
    let radius = 1.0
        + 0.16 * (2.1 * d.x + 1.3 * d.y + 0.4).sin()
        + 0.11 * (3.2 * d.z - 2.0 * d.x + 1.1).sin()
        + 0.07 * (4.0 * d.y + 2.5 * d.z + 2.0).sin();
    (d * radius).component_mul(&Vector3::new(1.0, 0.8, 0.65))
}

/// The motions that take the views to where they belong: a turn and a shift each, the first is the identity.
fn truth(view: usize) -> (Rotation3<f64>, Vector3<f64>) {
    let k = view as f64;
    (Rotation3::from_scaled_axis(Vector3::new(0.03, -0.05, 0.04) * k), Vector3::new(0.02, -0.03, 0.01) * k)
}

/// Three views from directions 70 degrees apart, each moved away by the inverse of its motion.
fn view(index: usize, count: usize) -> Vec<Vector3<f64>> {
    let mut random = Random(7 + index as u64);
    let angle = 70f64.to_radians() * index as f64;
    let towards = Vector3::new(angle.cos(), angle.sin(), 0.3).normalize();
    let (turn, shift) = truth(index);
    let mut points = Vec::new();
    while points.len() < count {
        let d = Vector3::from_fn(|_, _| 2.0 * random.unit() - 1.0);
        let length = d.norm();
        if length > 0.1 && length < 1.0 && d.dot(&towards) > 0.1 * length {
            points.push(turn.inverse() * (body(&(d / length)) - shift));
        }
    }
    points
}

fn put_views(bench: &Bench) {
    let mut csv = String::from("x,y,z,intensity\n");
    for (i, p) in view(0, 2500).iter().enumerate() {
        writeln!(csv, "{},{},{},{}", p.x, p.y, p.z, i % 7).unwrap();
    }
    bench.put("a.csv", csv);
    for (name, index) in [("b.xyz", 1), ("c.xyz", 2)] {
        let text: String = view(index, 2500).iter().map(|p| format!("{} {} {}\n", p.x, p.y, p.z)).collect();
        bench.put(name, text);
    }
}

fn json(bench: &Bench, name: &str) -> Value {
    serde_json::from_str(&bench.text(name)).unwrap()
}

/// Largest entry of the difference between the matrix found and the motion that is true.
fn difference(found: &Value, view: usize) -> f64 {
    let (turn, shift) = truth(view);
    let entry = |i: usize, j: usize| found["matrix"][i][j].as_f64().unwrap();
    let all = (0..3).flat_map(|i| (0..4).map(move |j| (i, j)));
    all.map(|(i, j)| (entry(i, j) - if j < 3 { turn[(i, j)] } else { shift[i] }).abs()).fold(0.0, f64::max)
}

#[test]
fn displaced_views_find_each_other() {
    let bench = Bench::new();
    put_views(&bench);
    let run = bench.run("register-views a.csv b.xyz c.xyz -o aligned --json report.json");
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{}", run.stdout);
    let poses = json(&bench, "aligned/poses.json");
    assert_eq!((&poses["status"], &poses["start"]), (&"converged".into(), &"given".into()));
    for view in 0..3 {
        assert!(difference(&poses["views"][view], view) < 1e-4, "{view}: {}", poses["views"][view]);
        assert_eq!(poses["views"][view]["points"], 2500);
        assert_eq!(poses["views"][view]["covariance"]["rows"].as_array().unwrap().len(), 6);
    }
    assert_eq!(poses["components"], serde_json::json!([[0, 1, 2]]));
    let pairs = poses["pairs"].as_array().unwrap();
    assert!(pairs.len() >= 2);
    for pair in pairs.iter().filter(|pair| pair["count"].as_u64().unwrap() > 500) {
        let [before, after] = ["rms_before", "rms_after"].map(|name| pair[name].as_f64().unwrap());
        assert!(after < 0.02 * before, "{pair}");
    }
    let report = json(&bench, "report.json");
    assert_eq!((&report["command"], &report["status"]), (&"register-views".into(), &"done".into()));
    assert_eq!(report["results"]["views"], poses["views"]);
    assert_eq!(report["outputs"].as_array().unwrap().len(), 4);
    assert_eq!(report["inputs"][2]["role"], "view");

    // Files keep their names, formats and columns; points are where the matrix says.
    let moved = bench.text("aligned/a.csv");
    assert!(moved.starts_with("x,y,z,intensity\n") && moved.lines().count() == 2501, "{}", &moved[..80]);
    let number = |line: &str, k: usize| line.split([' ', ',']).nth(k).unwrap().parse::<f64>().unwrap();
    let (before, after) = (bench.text("c.xyz"), bench.text("aligned/c.xyz"));
    for (x, y) in before.lines().zip(after.lines()).step_by(100) {
        let row = |i: usize| {
            let entry = |j: usize| poses["views"][2]["matrix"][i][j].as_f64().unwrap();
            entry(0) * number(x, 0) + entry(1) * number(x, 1) + entry(2) * number(x, 2) + entry(3)
        };
        assert!((0..3).all(|i| (row(i) - number(y, i)).abs() < 1e-12), "{x} {y}");
    }

    // Begun from its own result it stays there.
    let again = "register-views a.csv b.xyz c.xyz -o again --init aligned/poses.json --quiet --threads 1";
    assert_eq!(bench.run(again).code, 0);
    let second = json(&bench, "again/poses.json");
    assert_eq!(second["start"], "init");
    for view in 0..3 {
        assert!(difference(&second["views"][view], view) < 1e-4);
    }
}

#[test]
fn scans_of_a_file_begin_at_its_poses() {
    let bench = Bench::new();
    // Each scanner has a frame of its own, far from the others, and a pose that is right but for the displacement of the view.
    let mut ptx = String::new();
    for index in 0..3 {
        let (turn, shift) = (
            Rotation3::from_euler_angles(0.0, 0.0, 2.0 * index as f64),
            Vector3::new(40.0, -7.0, 3.0) * index as f64,
        );
        ptx += "2500\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
        // Points are rows: x · matrix.
        for row in 0..3 {
            writeln!(ptx, "{} {} {} 0", turn[(0, row)], turn[(1, row)], turn[(2, row)]).unwrap();
        }
        writeln!(ptx, "{} {} {} 1", shift.x, shift.y, shift.z).unwrap();
        for point in view(index, 2500) {
            let own = turn.inverse() * (point - shift);
            writeln!(ptx, "{} {} {} 0.5", own.x, own.y, own.z).unwrap();
        }
    }
    bench.put("scans.ptx", ptx);
    let run = bench.run("register-views scans.ptx -o aligned --json report.json");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let poses = json(&bench, "aligned/poses.json");
    assert_eq!((&poses["status"], &poses["start"]), (&"converged".into(), &"given".into()));
    for index in 0..3 {
        let found = &poses["views"][index];
        assert!(difference(found, index) < 1e-4, "{index}: {found}");
        assert_eq!((&found["path"], &found["scan"]), (&"scans.ptx".into(), &index.into()));
        assert!(bench.path(&format!("aligned/scans-{index}.ply")).exists());
    }
    // A file of one scan is one view, and that is too few.
    bench.put(
        "one.ptx",
        bench.text("scans.ptx").lines().take(2510).map(|line| format!("{line}\n")).collect::<String>(),
    );
    let run = bench.run("register-views one.ptx -o none");
    assert!(run.code == 2 && run.stderr.contains("there is one view only"), "{}", run.stderr);
    assert!(!bench.path("none").exists());
}

#[test]
fn views_that_do_not_overlap_are_told() {
    let bench = Bench::new();
    put_views(&bench);
    let far: String = view(1, 600).iter().map(|p| format!("{} {} {}\n", p.x + 50.0, p.y, p.z)).collect();
    bench.put("b.xyz", far);
    let run = bench.run("register-views a.csv b.xyz --start given -o out --json -");
    assert_eq!(run.code, 1, "{}", run.stderr);
    let report = run.report();
    assert_eq!(report["status"], "not_converged");
    assert_eq!(report["results"]["status"], "no_overlap");
    assert_eq!(report["results"]["components"], serde_json::json!([[0], [1]]));
}

#[test]
fn a_search_over_all_positions_is_made_where_views_lie_anyhow() {
    let bench = Bench::new();
    put_views(&bench);
    let away = |p: &Vector3<f64>| {
        let q = Rotation3::from_scaled_axis(Vector3::new(1.0, 2.0, -0.5)) * p;
        format!("{} {} {}\n", q.x + 3.0, q.y, q.z - 7.0)
    };
    bench.put("b.xyz", view(1, 2500).iter().map(away).collect::<String>());
    let run = bench.run("register-views a.csv b.xyz -o out --json -");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let results = &run.report()["results"];
    assert_eq!(results["start"], "search");
    assert!(results["rms"].as_f64().unwrap() < 1e-3, "{results}");
}

#[test]
fn bad_input_says_what_and_leaves_nothing() {
    let bench = Bench::new();
    put_views(&bench);
    bench.put("two.xyz", "0 0 0\n1 0 0\n");
    bench.put("flat.xyz", "0 0\n1 0\n1 1\n");
    bench.put("one.json", "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]");
    bench.put("model.json", common::SQUARE);
    std::fs::create_dir(bench.path("other")).unwrap();
    bench.put("other/b.xyz", bench.text("b.xyz"));
    let before = bench.files();
    for (arguments, message) in [
        ("register-views a.csv -o out", "there is one view only"),
        ("register-views a.csv b.xyz", "--out"),
        ("register-views a.csv two.xyz -o out", "two.xyz: 2 of 2 points can be used"),
        ("register-views a.csv flat.xyz -o out", "flat.xyz: the points have two columns only"),
        ("register-views a.csv model.json -o out", "model.json: a scan is needed"),
        ("register-views a.csv nowhere.ply -o out", "nowhere.ply"),
        ("register-views a.csv b.xyz -o .", "overwrite an input"),
        ("register-views a.csv b.xyz -o a.csv", "not a folder"),
        ("register-views b.xyz other/b.xyz -o out", "two views are called b.xyz"),
        ("register-views a.csv b.xyz -o out --init one.json", "1 pose for 2 views"),
        ("register-views a.csv b.xyz -o out --neighbours 1", "neighbours is 1"),
        ("register-views a.csv b.xyz -o out --json out/poses.json", "poses.json"),
    ] {
        let run = bench.run(arguments);
        assert_eq!(run.code, 2, "{arguments}: {}", run.stdout);
        assert!(run.stderr.contains(message), "{arguments}: {}", run.stderr);
        assert_eq!(bench.files(), before, "{arguments}");
    }
}
