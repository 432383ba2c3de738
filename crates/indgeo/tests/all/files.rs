//! `indgeo convert` and `indgeo info`.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::{Bench, CUBE, SEGMENT, SQUARE, fixture};

#[test]
fn points_survive_a_round_trip() {
    let bench = Bench::new();
    let text = "x,y,z,intensity\n0.1,1e-300,-3,7\n0.30000000000000004,-0,123456789.12345679,nan\n";
    bench.put("scan.csv", text);
    for step in ["scan.csv scan.ply", "scan.ply scan.pcd", "scan.pcd text.ply --ascii", "text.ply back.csv"] {
        let run = bench.run(&format!("convert {step}"));
        assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{step}");
    }
    assert!(bench.text("text.ply").starts_with("ply\nformat ascii 1.0\n"));
    let report = bench.run("info back.csv --json -").report();
    assert_eq!(report["results"][0]["attributes"], serde_json::json!(["intensity"]));
    let numbers = |name: &str| -> Vec<u64> {
        let text = bench.text(name);
        let cells = text.lines().skip(1).flat_map(|line| line.split(','));
        cells.map(|cell| cell.parse::<f64>().unwrap().to_bits()).collect()
    };
    assert_eq!(numbers("scan.csv"), numbers("back.csv"));
}

#[test]
fn what_a_format_cannot_hold_is_told() {
    let bench = Bench::new();
    bench.put("cube.off", CUBE);
    let run = bench.run("convert cube.off cube.csv --json -");
    assert_eq!(run.code, 0);
    assert!(run.stderr.contains("12 triangles"), "{}", run.stderr);
    assert_eq!(run.report()["outputs"][0]["bytes"], bench.read("cube.csv").len());
    bench.put("model.json", SQUARE);
    let run = bench.run("convert cube.off cube.json");
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("choose ply, stl, obj, off or glb"), "{}", run.stderr);
    assert!(!bench.path("cube.json").exists());
}

#[test]
fn points_are_dropped_on_request_only() {
    let bench = Bench::new();
    bench.put("scan.xyz", "0 0 1\nnan 0 1\n");
    let run = bench.run("convert scan.xyz kept.csv");
    assert!(run.code == 0 && run.stderr.contains("kept"), "{}", run.stderr);
    assert_eq!(bench.text("kept.csv").lines().count(), 3);
    assert_eq!(bench.run("convert scan.xyz dropped.csv --drop-non-finite").code, 0);
    assert_eq!(bench.text("dropped.csv").lines().count(), 2);
}

#[test]
fn info_describes_every_kind_of_file() {
    let bench = Bench::new();
    bench.put("cube.off", CUBE);
    bench.put("model.json", format!("{{\"kind\":\"model\",\"shapes\":[{SQUARE},{SEGMENT}]}}"));
    bench.put("points.csv", "x,y\n1,2\n4,6\n");
    let run = bench.run("info cube.off model.json points.csv --json -");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let report = run.report();
    let [cube, model, points] = [0, 1, 2].map(|index| &report["results"][index]);
    assert_eq!(
        (&cube["kind"], &cube["is_solid"], &cube["volume"]),
        (&"mesh".into(), &true.into(), &1.0.into())
    );
    assert_eq!((&cube["area"], &cube["triangles"]), (&6.0.into(), &12.into()));
    assert_eq!(model["shapes"][0]["degree"], serde_json::json!([1, 1]));
    assert_eq!(model["shapes"][1]["dimension"], 2);
    assert_eq!((&points["dimension"], &points["bounding_box"]["diagonal"]), (&2.into(), &5.0.into()));

    let run = bench.run("info model.json");
    assert!(run.stdout.starts_with("model.json\n  format"), "{}", run.stdout);
    assert!(run.stdout.contains("shape 0 \"square\"\n    kind                surface\n"), "{}", run.stdout);
    let scan = fixture("scans/stud-bolt.ply");
    assert!(bench.run(&format!("info {scan}")).stdout.contains("triangles             16957"));
}

#[test]
fn standard_input_is_a_file_called_dash() {
    let bench = Bench::new();
    bench.put("model.json", SQUARE);
    let run = bench.run_with("info - --json -", b"1 2 3\n4 5 6\n");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert_eq!(run.report()["results"][0]["points"], 2);
    for arguments in ["project model.json - -o feet.csv", "convert - scan.ply"] {
        assert_eq!(bench.run_with(arguments, b"1 1 3\n").code, 0, "{arguments}");
    }
    assert!(bench.text("feet.csv").contains("\n1,1,3,1,1,0,3,"), "{}", bench.text("feet.csv"));
    assert_eq!(bench.run_with("project - scan.ply -o again.csv", SQUARE.as_bytes()).code, 0);
    assert_eq!(bench.text("again.csv"), bench.text("feet.csv"));
    let run = bench.run_with("project model.json - -o feet.csv", b"1 1 3\n1 one 3\n");
    assert!(run.code == 2 && run.stderr.starts_with("error: standard input:2: "), "{}", run.stderr);
}

#[test]
fn results_can_be_read_again() {
    let bench = Bench::new();
    bench.put("model.json", SQUARE);
    bench.put("scan.xyz", "1 1 3\n0.1 0.2 -0.3\n9 9 9\n");
    for (from, to) in [("scan.xyz", "a.csv"), ("a.csv", "b.ply"), ("b.ply", "c.csv")] {
        let run = bench.run(&format!("project model.json {from} -o {to}"));
        assert_eq!(run.code, 0, "{from}: {}", run.stderr);
    }
    assert_eq!(bench.text("a.csv"), bench.text("c.csv"));
    // The last cell of a point without answer is empty.
    bench.put("curve.json", SEGMENT);
    bench.put("profile.csv", "1,2\nnan,3\n");
    for (from, to) in [("profile.csv", "d.csv"), ("d.csv", "e.csv")] {
        assert_eq!(bench.run(&format!("project curve.json {from} -o {to}")).code, 0, "{from}");
    }
    assert_eq!(
        bench.text("d.csv"),
        "x,y,foot_x,foot_y,distance,t,status,lower_bound\n1,2,1,0,2,0.25,converged,1.9999998497\nnan,3,,,,,invalid_point,\n"
    );
    assert_eq!(bench.text("d.csv"), bench.text("e.csv"));
    let run = bench.run("info a.csv");
    for name in ["foot_x, foot_y, foot_z, distance, shape, u, v", "lower_bound", "status"] {
        assert!(run.stdout.contains(name), "{name}: {}", run.stdout);
    }
}
