//! `indgeo fit-surface` as a user runs it.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::{Bench, SQUARE};
use serde_json::Value;
use std::f64::consts::TAU;

/// A tube with a waist, `count` points.
fn tube(count: usize) -> String {
    let at = |k: usize| {
        let (a, h) = ((k as f64 * 0.618_033_988_75).fract() * TAU, (k as f64 + 0.5) / count as f64);
        let r = 5.0 - 2.0 * (std::f64::consts::PI * h).sin();
        format!("{} {} {}\n", r * a.cos(), r * a.sin(), 12.0 * h)
    };
    (0..count).map(at).collect()
}

#[test]
fn a_tube_is_fitted_to_a_tolerance() {
    let bench = Bench::new();
    bench.put("tube.xyz", tube(1500));
    let run = bench
        .run("fit-surface tube.xyz -o tube.json --control-points 8x6 --tolerance 0.01 --json report.json");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let report: Value = serde_json::from_str(&bench.text("report.json")).unwrap();
    assert_eq!((&report["command"], &report["status"]), (&"fit-surface".into(), &"done".into()));
    let results = &report["results"];
    assert_eq!((&results["base"], &results["within_tolerance"]), (&"cylinder".into(), &true.into()));
    assert!(results["max"].as_f64().unwrap() <= 0.01 && results["history"].is_array());
    let surface: Value = serde_json::from_str(&bench.text("tube.json")).unwrap();
    assert_eq!((&surface["kind"], &surface["periodic_u"]), (&"surface".into(), &true.into()));
    // The inspection agrees.
    let run = bench.run("inspect tube.json tube.xyz --tolerance 0.0101");
    assert_eq!(run.code, 0, "{}", run.stdout);
    // The surface is a start again.
    let run = bench.run("fit-surface tube.xyz --init tube.json --json -");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let again: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(again["results"]["control_points"], results["control_points"]);
    assert!(again["results"]["base"].is_null());
    // With more control points than it has, if asked.
    let run = bench.run("fit-surface tube.xyz --init tube.json --control-points 30x28 --json -");
    let finer: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(finer["results"]["control_points"], serde_json::json!([30, 28]));
}

#[test]
fn a_cylinder_is_exact_with_weights() {
    let bench = Bench::new();
    let point = |k: usize| ((k as f64 * 0.618_033_988_75).fract() * TAU, (k as f64 + 0.5) / 500.0);
    let line = |(a, h): (f64, f64)| format!("{} {} {}\n", 5.0 * a.cos(), 5.0 * a.sin(), 12.0 * h);
    bench.put("cylinder.xyz", (0..500).map(point).map(line).collect::<String>());
    let run = bench.run("fit-surface cylinder.xyz -o cylinder.json --rational --tolerance 1e-8 --json -");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let surface: Value = serde_json::from_str(&bench.text("cylinder.json")).unwrap();
    assert!(surface["weights"].is_array());
}

#[test]
fn the_kind_of_surface_is_decided_with_a_reason() {
    let bench = Bench::new();
    bench.put("tube.xyz", tube(1500));
    let half: String = tube(3000).lines().filter(|l| !l.contains(" -")).map(|l| format!("{l}\n")).collect();
    bench.put("half.xyz", half);
    for (command, base, why, loops) in [
        ("fit-surface tube.xyz --control-points 10x8 --json -", "cylinder", "layers close around an axis", 0),
        ("fit-surface tube.xyz --control-points 10x8 --shape cylinder --json -", "cylinder", "asked for", 0),
        // It is narrower at its waist: a patch with four corners has parts without data there, which a loop leaves out.
        ("fit-surface half.xyz --control-points 8x8 --json -", "plane", "height field", 1),
    ] {
        let run = bench.run(command);
        let results = &run.report()["results"];
        let said = run.stderr.contains("without data");
        assert_eq!(run.code, i32::from(said), "{command}: {}{}", run.stdout, run.stderr);
        assert!(!said || loops == 1, "{command}: {}", run.stderr);
        assert_eq!(results["trim_loops"], if said { 0 } else { loops }, "{command}: {results}");
        assert_eq!(results["base"], base, "{results}");
        let start = &results["start"];
        assert!(start["why"].as_str().unwrap().contains(why), "{start}");
        let [least_squares, rms] = [&start["least_squares_rms"], &results["rms"]];
        assert!(rms.as_f64().unwrap() <= least_squares.as_f64().unwrap(), "{results}");
    }
}

#[test]
fn what_is_not_the_kind_of_surface_is_no_success() {
    let bench = Bench::new();
    let share = |k: usize, step: f64| (k as f64 * step).fract();
    let (a, h) = (|k| TAU * share(k, 0.754_877_666), |k| share(k, 0.569_840_291));
    let cloud = |place: &dyn Fn(usize) -> [f64; 3]| -> String {
        (0..2000).map(place).map(|[x, y, z]| format!("{x} {y} {z}\n")).collect()
    };
    bench.put("tube.xyz", tube(2000));
    bench.put("half.xyz", cloud(&|k| [3.0 * (a(k) / 2.0).cos(), 3.0 * (a(k) / 2.0).sin(), 10.0 * h(k)]));
    bench.put("plane.xyz", cloud(&|k| [8.0 * h(k), a(k), 0.0]));
    bench.put("open.xyz", cloud(&|k| [3.0 * (0.75 * a(k)).cos(), 3.0 * (0.75 * a(k)).sin(), 10.0 * h(k)]));
    let chance = |k: usize| ((k as f64 * 12.9898).sin() * 43_758.545_3).fract().abs();
    bench.put("block.xyz", cloud(&|k| [a(k), 5.0 * h(k), 5.0 * chance(k)]));
    bench.put("two.xyz", tube(1000) + &cloud(&|k| [a(k) + 40.0, h(k), 0.0]));
    for (arguments, code, message) in [
        ("two.xyz", 2, "falls apart into"),
        ("two.xyz --shape cylinder", 2, "falls apart into"),
        ("half.xyz --shape cylinder", 2, "not a cylinder"),
        ("open.xyz --shape cylinder", 2, "not a cylinder"),
        ("plane.xyz --shape cylinder", 2, "not a cylinder"),
        ("open.xyz", 1, "must be looked at"),
        ("block.xyz", 2, "volume"),
        ("tube.xyz", 0, ""),
    ] {
        // What is no success need not come to rest.
        let most = if code == 0 { 40 } else { 6 };
        let run = bench.run(&format!(
            "fit-surface {arguments} -o out.json --control-points 8x8 --max-iterations {most}"
        ));
        assert_eq!(run.code, code, "{arguments}: {}{}", run.stdout, run.stderr);
        assert!(run.stderr.contains(message), "{arguments}: {}", run.stderr);
    }
}

#[test]
fn a_tolerance_out_of_reach_is_said() {
    let bench = Bench::new();
    bench.put("tube.xyz", tube(600));
    let run = bench.run(
        "fit-surface tube.xyz -o tube.json --control-points 6x5 --tolerance 1e-6 --max-control-points 40",
    );
    assert_eq!(run.code, 1, "{}{}", run.stdout, run.stderr);
    assert!(run.stdout.contains("NOT reached"), "{}", run.stdout);
    assert!(bench.text("tube.json").contains("surface"));
}

#[test]
fn bad_input_and_usage() {
    let bench = Bench::new();
    bench.put("model.json", SQUARE);
    bench.put("tube.xyz", tube(300));
    bench.put("line.xyz", (0..50).map(|k| format!("{k} {k} 0\n")).collect::<String>());
    for (command, message) in [
        ("fit-surface tube.xyz", "nothing would be written"),
        ("fit-surface model.json -o out.json", "NURBS"),
        ("fit-surface line.xyz -o out.json", "on a line"),
        ("fit-surface tube.xyz -o tube.xyz", "overwrite"),
        ("fit-surface tube.xyz -o out.json --tolerance 0", "--tolerance <T>"),
        ("fit-surface tube.xyz -o out.json --init tube.xyz", "a surface is needed"),
        ("fit-surface tube.xyz -o out.json --control-points 3by4", "30x20"),
        ("fit-surface tube.xyz -o out.json --init model.json --control-points 1x1", "at least as many"),
        ("fit-surface missing.xyz -o out.json", "missing.xyz"),
    ] {
        let run = bench.run(command);
        assert_eq!(run.code, 2, "{command}: {}{}", run.stdout, run.stderr);
        assert!(run.stderr.contains(message), "{command}: {}", run.stderr);
    }
    // Fewer points than unknowns: the smoothing decides, and that is said.
    bench.put("four.xyz", "0 0 0\n1 0 0\n0 1 0\n0 0 1\n");
    for command in ["fit-surface four.xyz -o four.json", "fit-ruled four.xyz -o four.json"] {
        let run = bench.run(command);
        assert!(run.code < 2 && run.stderr.contains("4 points for 1"), "{command}: {}", run.stderr);
        assert!(!bench.text("four.json").contains("NaN") && !bench.text("four.json").contains("null,"));
    }
}
