//! `indgeo segment` as a user runs it.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::Bench;
use serde_json::Value;

/// A quarter of a cylinder of radius 5 about the z axis, and a plane beside it, 600 and 400 points on grids.
fn cloud() -> String {
    let mut text = String::new();
    for i in 0..600 {
        let a = std::f64::consts::FRAC_PI_2 * f64::from(i % 20) / 19.0;
        text += &format!("{} {} {}\n", 5.0 * a.cos(), 5.0 * a.sin(), 0.4 * f64::from(i / 20));
    }
    for i in 0..400 {
        text += &format!("{} {} -3\n", 0.4 * f64::from(i % 20), 0.4 * f64::from(i / 20));
    }
    text
}

#[test]
fn labels_types_and_parameters_of_a_cloud() {
    let bench = Bench::new();
    bench.put("scan.xyz", cloud());
    let run = bench.run("segment scan.xyz -o labels.csv --json r.json");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let labels = bench.text("labels.csv");
    assert!(
        labels.starts_with("x,y,z,label\n5,0,0,0\n") && labels.lines().count() == 1001,
        "{}",
        &labels[..60]
    );
    let report: Value = serde_json::from_str(&bench.text("r.json")).unwrap();
    let primitives = report["results"]["primitives"].as_array().unwrap();
    assert_eq!(primitives.len(), 2);
    assert!(primitives[0]["type"] == "cylinder" && primitives[1]["type"] == "plane");
    assert_eq!((&primitives[0]["support"], &primitives[1]["support"]), (&600.into(), &400.into()));
    assert!((primitives[0]["radius"].as_f64().unwrap() - 5.0).abs() < 1e-6);
    assert_eq!(primitives[0]["parameters"]["radius"], primitives[0]["radius"]);
    // Again as PLY, which other commands read, with the label as a whole number.
    let run = bench.run("segment scan.xyz -o labels.ply");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let ply = bench.text("labels.ply");
    assert!(ply.contains("element vertex 1000\n") && ply.contains("property int label\n"));
    let run = bench.run("info labels.ply");
    assert_eq!(run.code, 0, "{}", run.stderr);
}

#[test]
fn what_cannot_be_segmented_is_refused() {
    let bench = Bench::new();
    bench.put("three.xyz", "0 0 0\n1 0 0\n0 1 0\n");
    bench.put("line.xyz", (0..50).map(|i| format!("{i} {i} 0\n")).collect::<String>());
    bench.put("scan.xyz", cloud());
    for (command, says) in [
        ("segment three.xyz -o o.csv", "3 points are too few"),
        ("segment line.xyz -o o.csv", "on a line"),
        ("segment scan.xyz -o o.csv --sigma 0", "--sigma"),
        ("segment scan.xyz -o o.csv --min-points 2", "--min-points"),
        ("segment scan.xyz -o o.stl", "PLY or CSV"),
        ("segment scan.xyz -o o.csv --picture p.svg", "triangles"),
        ("segment scan.xyz", "nothing would be written"),
    ] {
        let run = bench.run(command);
        assert!(run.code == 2 && run.stderr.contains(says), "{command}: {} {}", run.code, run.stderr);
    }
}
