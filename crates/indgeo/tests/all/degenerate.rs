//! Odd but ordinary input: points that are not finite, duplicates, models without extent, enormous coordinates.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::{Bench, CUBE, SEGMENT, SQUARE, rows};

#[test]
fn points_that_are_not_finite_keep_their_row() {
    let bench = Bench::new();
    bench.put("model.json", SQUARE);
    bench.put("points.xyz", "1 1 1\nnan 1 1\n1 -inf 1\n0 0 2\n");
    let run = bench.run("project model.json points.xyz -o out.csv --json report.json");
    assert_eq!(run.code, 0);
    assert!(run.stderr.starts_with("warning: points.xyz: 2 of 4 points have a coordinate"), "{}", run.stderr);
    assert!(run.stderr.contains("--drop-non-finite"), "{}", run.stderr);
    let text = bench.text("out.csv");
    assert_eq!(rows(&text)[1].join(","), "nan,1,1,,,,,,,,invalid_point,");
    assert_eq!(rows(&text)[2].join(","), "1,-inf,1,,,,,,,,invalid_point,");
    assert_eq!(rows(&text).len(), 4);
    let report: serde_json::Value = serde_json::from_str(&bench.text("report.json")).unwrap();
    assert_eq!(report["results"]["status"]["invalid_point"], 2);
    assert_eq!(report["results"]["distance"]["count"], 2);
    assert_eq!(report["inputs"][1]["non_finite"], 2);

    let run = bench.run("project model.json points.xyz -o dropped.csv --drop-non-finite --json -");
    assert_eq!(run.code, 0);
    assert_eq!(run.report()["inputs"][1]["points_dropped"], 2);
    let kept: Vec<&str> = text.lines().filter(|line| !line.contains("invalid")).collect();
    assert_eq!(bench.text("dropped.csv").lines().collect::<Vec<_>>(), kept);
}

#[test]
fn in_plane_and_on_meshes_too() {
    let bench = Bench::new();
    bench.put("curve.json", SEGMENT);
    bench.put("points.csv", "x,y\n1,1\nnan,1\n");
    assert_eq!(bench.run("project curve.json points.csv -o out.csv").code, 0);
    assert_eq!(rows(&bench.text("out.csv"))[1].join(","), "nan,1,,,,,invalid_point,");
    bench.put("cube.off", CUBE);
    bench.put("points.xyz", "1 1 2\nnan 1 0\n");
    assert_eq!(bench.run("project cube.off points.xyz -o mesh.csv").code, 0);
    assert_eq!(rows(&bench.text("mesh.csv"))[1].join(","), "nan,1,0,,,,,,,invalid_point,");
}

#[test]
fn models_without_extent_have_a_closest_point() {
    let bench = Bench::new();
    let point =
        SQUARE.replace("[[[0,0,0],[0,2,0]],[[2,0,0],[2,2,0]]]", "[[[1,1,1],[1,1,1]],[[1,1,1],[1,1,1]]]");
    bench.put("point.json", point);
    bench.put("curve.json", SEGMENT.replace("[[0,0],[4,0]]", "[[1,1],[1,1]]"));
    bench.put("points.xyz", "1 1 4\n1 1 1\n");
    bench.put("plane.csv", "x,y\n1,3\n");
    let run = bench.run("project point.json points.xyz -o out.csv");
    // Whether a point satisfies the conditions of a minimum is no question there; that the answer is right is.
    assert!(run.code == 0 || run.code == 1, "{}", run.stderr);
    let cells = rows(&bench.text("out.csv"));
    assert_eq!(cells[0][3..6], ["1", "1", "1"]);
    assert_eq!(cells[0][6].parse::<f64>().unwrap().abs(), 3.0);
    assert_eq!(cells[1][6].parse::<f64>().unwrap().abs(), 0.0);
    let run = bench.run("project curve.json plane.csv -o curve.csv");
    assert!(run.code == 0 || run.code == 1, "{}", run.stderr);
    assert_eq!(rows(&bench.text("curve.csv"))[0][2..5], ["1", "1", "2"]);
}

#[test]
fn georeferenced_coordinates_lose_nothing() {
    let bench = Bench::new();
    let far = SQUARE.replace("[0,2,0]", "[4500000,5400002,0]");
    let far = far.replace("[[0,0,0]", "[[4500000,5400000,0]");
    let far = far.replace("[[2,0,0],[2,2,0]]", "[[4500002,5400000,0],[4500002,5400002,0]]");
    bench.put("model.json", far);
    bench.put("points.xyz", "4500001 5400001 0.001\n4500001 5400001 0.001\n");
    let run = bench.run("project model.json points.xyz -o out.csv");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let cells = rows(&bench.text("out.csv"));
    assert_eq!(cells[0], cells[1]);
    assert!((cells[0][6].parse::<f64>().unwrap() - 0.001).abs() < 1e-12, "{:?}", cells[0]);
}

#[test]
fn enormous_coordinates_end_in_a_status() {
    let bench = Bench::new();
    bench.put("model.json", SQUARE);
    bench.put("cube.off", CUBE);
    bench.put("points.xyz", "1e140 0 0\n0 1e140 0\n1 1 1\n");
    for model in ["model.json", "cube.off"] {
        let run = bench.run(&format!("project {model} points.xyz -o out.csv"));
        assert!(run.code == 0 || run.code == 1, "{model}: {}", run.stderr);
        let cells = rows(&bench.text("out.csv"));
        assert_eq!((cells.len(), cells[0][0].as_str()), (3, "1e140"), "{model}");
        assert!(cells[2].last().unwrap() != "diverged", "{model}");
    }
}
