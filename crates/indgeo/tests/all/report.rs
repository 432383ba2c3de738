//! The machine-readable report.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::{Bench, SQUARE};

#[test]
fn a_projection_reports_what_it_was_given_did_and_found() {
    let bench = Bench::new();
    bench.put("model.json", SQUARE);
    bench.put("points.xyz", "1 1 1\n1 0.5 -3\n5 1 0\nnan 0 0\n");
    let run = bench.run("project model.json points.xyz -o out.ply --json - --threads 2");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let report = run.report();
    assert_eq!(report["command"], "project");
    assert_eq!(report["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!((&report["status"], &report["exit_code"]), (&"done".into(), &0.into()));
    let [model, points] = [&report["inputs"][0], &report["inputs"][1]];
    assert_eq!(
        (&model["role"], &model["path"], &model["shapes"]),
        (&"model".into(), &"model.json".into(), &1.into())
    );
    assert_eq!(
        (&points["points_read"], &points["non_finite"], &points["format"]),
        (&4.into(), &1.into(), &"xyz".into())
    );
    assert_eq!(
        report["model"],
        serde_json::json!({"kind": "nurbs", "dimension": 3, "shapes": 1, "patches": 1, "signed": true})
    );
    assert_eq!(
        report["options"],
        serde_json::json!({"mode": "certified", "relative_gap": 1e-7, "threads": 2})
    );
    assert_eq!(report["outputs"][0]["bytes"], bench.read("out.ply").len());
    for stage in ["read", "build", "compute", "write"] {
        assert!(
            report["timings"][stage].as_f64().is_some_and(|seconds| (0.0..60.0).contains(&seconds)),
            "{stage}"
        );
    }
    assert!(report["points_per_second"].as_f64().is_some_and(|rate| rate > 0.0));
    assert_eq!(report["warnings"].as_array().unwrap().len(), 1);

    let results = &report["results"];
    assert_eq!(results["points"], 4);
    assert_eq!(results["status"], serde_json::json!({"converged": 2, "on_boundary": 1, "invalid_point": 1}));
    assert_eq!(results["location"], serde_json::json!({"interior": 2, "edge": 1}));
    assert_eq!(results["multiplicity"], serde_json::json!({"unique": 3}));
    assert_eq!((&results["worst"]["index"], &results["worst"]["distance"]), (&1.into(), &(-3.0).into()));
    let distance = &results["distance"];
    assert_eq!(
        (&distance["count"], &distance["min"], &distance["max"]),
        (&3.into(), &(-3.0).into(), &3.0.into())
    );
    assert!((distance["rms"].as_f64().unwrap() - (19.0f64 / 3.0).sqrt()).abs() < 1e-12);
    assert!(results["largest_gap"].as_f64().is_some_and(|gap| (0.0..1e-6).contains(&gap)));
    assert_eq!(results["shapes"][0]["on_boundary"], 1);
}

#[test]
fn errors_are_reported_too() {
    let bench = Bench::new();
    bench.put("model.json", SQUARE);
    let run = bench.run("project model.json nowhere.xyz -o out.csv --json -");
    assert_eq!(run.code, 2);
    let report = run.report();
    assert_eq!((&report["status"], &report["exit_code"]), (&"error".into(), &2.into()));
    assert!(report["error"].as_str().unwrap().starts_with("nowhere.xyz: cannot read"));
    assert_eq!(run.stderr, format!("error: {}\n", report["error"].as_str().unwrap()));

    assert_eq!(bench.run("info nowhere.xyz --json report.json").code, 2);
    assert!(bench.text("report.json").contains("\"status\": \"error\""));
    let run = bench.run("info model.json --json no/such/folder/report.json");
    assert_eq!((run.code, run.stdout.as_str()), (2, ""));
    assert!(run.stderr.contains("create the folder first"), "{}", run.stderr);
}

#[test]
fn quiet_is_quiet_and_help_has_examples() {
    let bench = Bench::new();
    bench.put("model.json", SQUARE);
    bench.put("points.xyz", "1 1 1\nnan 0 0\n");
    let run = bench.run("--quiet project model.json points.xyz -o out.csv");
    assert_eq!((run.code, run.stdout.as_str(), run.stderr.as_str()), (0, "", ""));
    for command in ["", "project ", "convert ", "info ", "demo "] {
        let run = bench.run(&format!("{command}--help"));
        assert_eq!(run.code, 0);
        assert!(
            run.stdout.contains("Example") && run.stdout.contains("  indgeo "),
            "{command}: {}",
            run.stdout
        );
    }
}
