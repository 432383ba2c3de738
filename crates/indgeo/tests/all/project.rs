//! What `indgeo project` writes for each kind of model.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common;
use crate::common::{Bench, CUBE, SEGMENT, SEGMENT_3, SQUARE, rows, same};
use serde_json::Value;

/// Whether a row is the expected one, followed by a lower bound.
fn but_for_the_bound(cells: &[String], expected: &[&str]) -> bool {
    let Some((bound, cells)) = cells.split_last() else { return false };
    same(cells, expected) && bound.parse::<f64>().is_ok_and(|bound| bound >= 0.0)
}

#[test]
fn surfaces_have_signed_distances() {
    let bench = Bench::new();
    bench.put("model.json", SQUARE);
    bench.put("points.xyz", "0.5 1 3\n1 0.25 -0.125\n3 1 0\n3 3 0\n");
    let run = bench.run("project model.json points.xyz -o out.csv");
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{}", run.stdout);
    assert!(run.stdout.contains("4 points projected onto 1 shape (1 Bézier piece)"), "{}", run.stdout);
    let text = bench.text("out.csv");
    assert_eq!(text.lines().next(), Some("x,y,z,foot_x,foot_y,foot_z,distance,shape,u,v,status,lower_bound"));
    let rows = rows(&text);
    assert!(
        but_for_the_bound(
            &rows[0],
            &["0.5", "1", "3", "0.5", "1", "0", "3", "0", "0.25", "0.5", "converged"]
        ),
        "{text}"
    );
    assert!(
        but_for_the_bound(
            &rows[1],
            &["1", "0.25", "-0.125", "1", "0.25", "0", "-0.125", "0", "0.5", "0.125", "converged"]
        ),
        "{text}"
    );
    assert!(same(&rows[2][3..9], &["2", "1", "0", "1", "0", "1"]), "{text}");
    assert_eq!(rows[2][10], "on_boundary");
    assert!((rows[3][6].parse::<f64>().unwrap() - 2f64.sqrt()).abs() < 1e-15);
}

#[test]
fn one_plane_curve_has_the_columns_of_the_contract() {
    let bench = Bench::new();
    bench.put("model.json", SEGMENT);
    // The extension is of no known format: two columns of numbers are recognised by content.
    bench.put("points.q", "1 2\n-3 4\n");
    let run = bench.run("project model.json points.q -o out.csv");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let text = bench.text("out.csv");
    assert!(text.starts_with("x,y,foot_x,foot_y,distance,t,status,lower_bound\n"), "{text}");
    assert!(but_for_the_bound(&rows(&text)[0], &["1", "2", "1", "0", "2", "0.25", "converged"]), "{text}");
    assert!(but_for_the_bound(&rows(&text)[1], &["-3", "4", "0", "0", "5", "0", "on_boundary"]), "{text}");
    // Points of three columns do, as long as they lie in the plane.
    bench.put("flat.xyz", "1 2 0\n-3 4 0\n");
    assert_eq!(bench.run("project model.json flat.xyz -o flat.csv").code, 0);
    assert_eq!(bench.read("flat.csv"), bench.read("out.csv"));
}

#[test]
fn several_plane_curves_say_which() {
    let bench = Bench::new();
    let other = SEGMENT.replace("[[0,0],[4,0]]", "[[0,10],[4,10]]");
    bench.put("model.json", format!("{{\"kind\":\"model\",\"shapes\":[{SEGMENT},{other}]}}"));
    bench.put("points.csv", "x,y\n1,2\n2,9\n");
    let run = bench.run("project model.json points.csv -o out.csv");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let text = bench.text("out.csv");
    assert!(text.starts_with("x,y,foot_x,foot_y,distance,shape,t,status,lower_bound\n"), "{text}");
    assert!(
        but_for_the_bound(&rows(&text)[1], &["2", "9", "2", "10", "1", "1", "0.5", "converged"]),
        "{text}"
    );
}

#[test]
fn curves_in_space_have_no_sign() {
    let bench = Bench::new();
    bench.put("model.json", SEGMENT_3);
    bench.put("points.xyz", "1 0 7\n");
    assert_eq!(bench.run("project model.json points.xyz -o out.csv").code, 0);
    let text = bench.text("out.csv");
    assert!(text.starts_with("x,y,z,foot_x,foot_y,foot_z,distance,shape,t,status,lower_bound\n"), "{text}");
    assert!(
        but_for_the_bound(&rows(&text)[0][3..], &["1", "0", "10", "3", "0", "0.25", "converged"]),
        "{text}"
    );
}

#[test]
fn in_a_mixed_model_the_nearest_shape_wins() {
    let bench = Bench::new();
    bench.put("model.json", format!("{{\"kind\":\"model\",\"shapes\":[{SEGMENT_3},{SQUARE}]}}"));
    bench.put("points.xyz", "1 0 9\n1 1 -2\n");
    let run = bench.run("project model.json points.xyz -o out.csv --json -");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let rows = rows(&bench.text("out.csv"));
    assert!(but_for_the_bound(&rows[0][6..], &["1", "0", "0.25", "", "converged"]), "{rows:?}");
    assert!(but_for_the_bound(&rows[1][6..], &["-2", "1", "0.5", "0.5", "converged"]), "{rows:?}");
    let report = run.report();
    assert_eq!(report["results"]["shapes"][0]["kind"], "curve");
    assert_eq!(report["results"]["shapes"][1]["name"], "square");
}

#[test]
fn closed_meshes_have_an_inside_open_ones_not() {
    let bench = Bench::new();
    bench.put("cube.off", CUBE);
    bench.put("points.xyz", "0.5 0.5 0.875\n0.5 0.5 3\n");
    assert_eq!(bench.run("project cube.off points.xyz -o out.csv").code, 0);
    let text = bench.text("out.csv");
    assert!(
        text.starts_with("x,y,z,foot_x,foot_y,foot_z,distance,shape,triangle,status,lower_bound\n"),
        "{text}"
    );
    let cells = rows(&text);
    assert!(same(&cells[0][3..8], &["0.5", "0.5", "1", "-0.125", "0"]), "{text}");
    assert_eq!(cells[1][6], "2");

    let open = CUBE.replace("8 6 0", "8 5 0").replace("4 3 0 4 7\n", "");
    bench.put("open.off", open);
    assert_eq!(bench.run("project open.off points.xyz -o open.csv").code, 0);
    assert_eq!(rows(&bench.text("open.csv"))[0][6], "0.125");
}

#[test]
fn all_formats_hold_the_same_numbers() {
    let bench = Bench::new();
    bench.put("model.json", SQUARE);
    bench.put("points.xyz", "0.1 0.2 0.3333333333333333\n1e-7 1e17 -5e-324\nnan 0 0\n");
    for out in ["out.csv", "out.ply", "out.json"] {
        assert_eq!(bench.run(&format!("project model.json points.xyz -o {out}")).code, 0);
    }
    let json: Value = serde_json::from_slice(&bench.read("out.json")).unwrap();
    assert_eq!(json["points"], 3);
    assert_eq!(json["status"], serde_json::json!(["converged", "on_boundary", "invalid_point"]));
    assert!(json["x"][2].is_null() && json["distance"][2].is_null() && json["shape"][2].is_null());

    // Read back by ourselves: the vertices of the PLY and the rows of the CSV.
    assert_eq!(bench.run("convert out.ply back.csv").code, 0);
    let (direct, back) = (rows(&bench.text("out.csv")), rows(&bench.text("back.csv")));
    for (row, (direct, back)) in direct.iter().zip(&back).enumerate() {
        for column in 0..7 {
            let number = |text: &str| if text.is_empty() { f64::NAN } else { text.parse::<f64>().unwrap() };
            let name = json["columns"][column].as_str().unwrap();
            let (a, b) = (number(&direct[column]), number(&back[column]));
            assert!(a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan(), "{name} of row {row}");
            assert!(
                json[name][row].as_f64().is_none_or(|c| c.to_bits() == a.to_bits()),
                "{name} of row {row}"
            );
        }
    }
}

#[test]
fn triangles_of_the_points_stay_in_ply() {
    let bench = Bench::new();
    bench.put("model.json", SQUARE);
    bench.put("cube.off", CUBE);
    assert_eq!(bench.run("project model.json cube.off -o out.ply").code, 0);
    let report = bench.run("info out.ply --json -").report();
    let fact = &report["results"][0];
    assert_eq!(
        (&fact["points"], &fact["triangles"], &fact["is_solid"]),
        (&8.into(), &12.into(), &true.into())
    );
    let names = ["foot_x", "foot_y", "foot_z", "distance", "shape", "u", "v", "status", "lower_bound"];
    assert_eq!(fact["attributes"], serde_json::json!(names));
}

#[test]
fn threads_do_not_change_a_bit() {
    let bench = Bench::new();
    let model = common::fixture("demo/stud-bolt-model.json");
    let scan = common::fixture("scans/stud-bolt.ply");
    for (threads, out) in [(1, "one"), (2, "two"), (3, "three")] {
        for extension in ["csv", "ply", "json"] {
            let run = bench
                .run(&format!("project {model} {scan} -o {out}.{extension} --threads {threads} --quiet"));
            assert_eq!((run.code, run.stdout.as_str(), run.stderr.as_str()), (0, "", ""));
        }
    }
    for extension in ["csv", "ply", "json"] {
        let read = |name: &str| bench.read(&format!("{name}.{extension}"));
        assert!(read("one") == read("two") && read("one") == read("three"), "{extension}");
    }
}

#[test]
fn every_mode_answers_near_the_surface() {
    let bench = Bench::new();
    bench.put("model.json", SQUARE);
    bench.put("points.xyz", "0.5 1 0.01\n1.5 0.25 -0.01\n");
    for mode in ["certified", "fast", "local"] {
        let run = bench.run(&format!("project model.json points.xyz -o out.csv --mode {mode} --json -"));
        let report = run.report();
        assert_eq!((run.code, &report["options"]["mode"]), (0, &mode.into()));
        assert_eq!(report["results"]["largest_gap"].is_null(), mode != "certified");
        let rows = rows(&bench.text("out.csv"));
        assert!((rows[0][6].parse::<f64>().unwrap() - 0.01).abs() < 1e-12, "{mode}");
        assert!((rows[1][6].parse::<f64>().unwrap() + 0.01).abs() < 1e-12, "{mode}");
    }
}
