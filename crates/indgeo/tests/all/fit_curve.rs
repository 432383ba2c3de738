//! `indgeo fit-curve` as a user runs it.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common;
use crate::common::{Bench, fixture};
use serde_json::Value;
use std::f64::consts::TAU;

/// Points of an ellipse in a scattered order.
fn ellipse(count: usize) -> String {
    let at = |k: usize| TAU * (k * 37 % count) as f64 / count as f64;
    (0..count).map(|k| format!("{} {}\n", 3.0 * at(k).cos(), at(k).sin())).collect()
}

fn json(bench: &Bench, name: &str) -> Value {
    serde_json::from_str(&bench.text(name)).unwrap()
}

#[test]
fn a_cloud_becomes_a_curve_within_tolerance() {
    let bench = Bench::new();
    bench.put("points.xyz", ellipse(200));
    let run = bench.run(
        "fit-curve points.xyz -o curve.json --tolerance 1e-3 --points-out feet.csv --report history.csv \
         --evolution evolution.svg --json report.json",
    );
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    assert!(run.stdout.contains("closed curve") && run.stdout.contains("reached"), "{}", run.stdout);
    let curve = json(&bench, "curve.json");
    assert_eq!(
        (&curve["kind"], &curve["dim"], &curve["periodic"]),
        (&"curve".into(), &2.into(), &true.into())
    );
    let report = json(&bench, "report.json");
    assert_eq!((&report["command"], &report["status"]), (&"fit-curve".into(), &"done".into()));
    let results = &report["results"];
    assert_eq!((&results["closed"], &results["within_tolerance"]), (&true.into(), &true.into()));
    assert!(results["max"].as_f64().unwrap() <= 1e-3 && results["control_points"].as_u64().unwrap() <= 16);
    let feet = bench.text("feet.csv");
    assert_eq!(feet.lines().next().unwrap(), "x,y,foot_x,foot_y,distance,t");
    assert_eq!(feet.lines().count(), 201);
    let iterations = results["history"].as_array().unwrap().len();
    assert_eq!(bench.text("history.csv").lines().count(), iterations + 1);
    assert!(
        bench.text("evolution.svg").starts_with("<svg") && bench.text("evolution.svg").contains("polyline")
    );
    // The projection onto the curve agrees.
    let run = bench.run("project curve.json points.xyz -o again.csv");
    assert_eq!(run.code, 0, "{}", run.stderr);

    let run = bench.run("fit-curve points.xyz -o exact.json --rational --json -");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.report()["results"]["max"].as_f64().unwrap() < 1e-9);
    assert!(json(&bench, "exact.json")["weights"].is_array());
}

#[test]
fn space_curves_in_any_order_and_starts_from_a_file() {
    let bench = Bench::new();
    let cases = fixture("fit-cases");
    for order in ["ordered", "shuffled"] {
        let run = bench
            .run(&format!("fit-curve {cases}/b_open3d_{order}.xyz --control-points 24 -o b.json --json -"));
        assert_eq!(run.code, 0, "{}", run.stderr);
        let results = &run.report()["results"];
        assert!(results["rms"].as_f64().unwrap() <= 0.0135 && results["closed"] == false, "{results}");
    }
    let command = format!("fit-curve {cases}/a1_rect.xyz --init {cases}/a1_init_uneven.json --json -");
    let rms = |run: &common::Run, iteration: usize| {
        // A fit that ended before stays where it is.
        let report = run.report();
        let history = report["results"]["history"].as_array().unwrap();
        history[(iteration - 1).min(history.len() - 1)]["rms"].as_f64().unwrap()
    };
    let sdm = bench.run(&command);
    assert_eq!(sdm.code, 0, "{}", sdm.stderr);
    assert!(rms(&sdm, 20) <= 0.001 && rms(&sdm, 45) <= 1e-6);
    let pdm = bench.run(&format!("{command} --term pdm --step-control none --smoothing continuation"));
    assert!(pdm.code == 1 && rms(&pdm, 20) >= 0.02, "{}", pdm.code);
    let tdm = bench.run(&format!("{command} --term tdm --step-control none --smoothing continuation"));
    assert!(tdm.code == 1 && tdm.report()["results"]["status"] == "diverged");
}

#[test]
fn a_start_far_away_is_searched_for_and_its_growth_kept() {
    let bench = Bench::new();
    bench.put("points.xyz", ellipse(300));
    let at = |k: usize| format!("[{},{}]", 9.0 + 0.2 * (k as f64).cos(), 7.0 + 0.2 * (k as f64).sin());
    let net: Vec<String> = (0..15).map(|k| at(k % 12)).collect();
    let knots: Vec<String> = (0..19).map(|k| k.to_string()).collect();
    let (knots, net) = (knots.join(","), net.join(","));
    bench.put(
        "far.json",
        format!(r#"{{"kind":"curve","dim":2,"degree":3,"periodic":true,"knots":[{knots}],"control_points":[{net}]}}"#),
    );
    let run =
        bench.run("fit-curve points.xyz --init far.json --search -o c.json --evolution growth.json --json -");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let results = &run.report()["results"];
    assert!(results["start"] == "contour" && results["rms"].as_f64().unwrap() < 5e-3, "{results}");
    // All curves on the way, which other commands read.
    let shapes = json(&bench, "growth.json")["shapes"].as_array().unwrap().len();
    assert!(shapes > 9, "{shapes}");
    assert_eq!(bench.run("info growth.json").code, 0);
    // What encloses nothing, or does not close, cannot be searched.
    bench.put(
        "arc.xyz",
        (0..60).map(|k| f64::from(k) / 60.0).map(|t| format!("{t} {}\n", t * t)).collect::<String>(),
    );
    bench.put(
        "helix.xyz",
        (0..60)
            .map(|k| f64::from(k) / 9.0)
            .map(|t| format!("{} {} {t}\n", t.cos(), t.sin()))
            .collect::<String>(),
    );
    for (command, message) in [
        ("fit-curve arc.xyz --search -o c.json", "enclose nothing"),
        ("fit-curve helix.xyz --search -o c.json", "curves in space"),
        ("fit-curve points.xyz --search --open -o c.json", "--open"),
    ] {
        let run = bench.run(command);
        assert!(run.code == 2 && run.stderr.contains(message), "{command}: {}", run.stderr);
    }
}

#[test]
fn what_is_not_reached_is_said() {
    let bench = Bench::new();
    let cases = fixture("fit-cases");
    let run = bench.run(&format!(
        "fit-curve {cases}/a2_noisy.xyz -o a2.json --tolerance 0.01 --max-control-points 16 --json r.json"
    ));
    assert_eq!(run.code, 1, "{}", run.stdout);
    assert!(run.stdout.contains("NOT reached"), "{}", run.stdout);
    assert_eq!(json(&bench, "r.json")["status"], "out_of_tolerance");
    assert!(bench.files().contains(&"a2.json".to_owned()));
    // The number of threads changes nothing.
    let of = |threads: u8| {
        let run = bench.run(&format!(
            "fit-curve {cases}/a2_noisy.xyz -o t{threads}.json --control-points 12 --threads {threads}"
        ));
        assert_eq!(run.code, 0, "{}", run.stderr);
        bench.text(&format!("t{threads}.json"))
    };
    assert_eq!(of(1), of(3));
}

#[test]
fn bad_input_says_what_and_what_to_do() {
    let bench = Bench::new();
    bench.put("points.xyz", ellipse(30));
    bench.put("three.xyz", "0 0\n1 0\n0 1\n");
    bench.put("line.xyz", "0 0\n1 1\n2 2\n3 3\n4 4\n5 5\n");
    bench.put("same.xyz", "1 1\n1 1\n1 1\n1 1\n1 1\n");
    for (arguments, message) in [
        ("fit-curve points.xyz", "nothing would be written"),
        ("fit-curve three.xyz -o c.json", "3 of 3 points can be used"),
        ("fit-curve same.xyz -o c.json", "1 of 5 points can be used"),
        ("fit-curve line.xyz -o c.json --closed", "on a line"),
        ("fit-curve points.xyz -o c.json --control-points 31", "at least 31 are needed"),
        ("fit-curve points.xyz -o c.json --tolerance 0", "tolerance"),
        ("fit-curve points.xyz -o c.json --smoothing much", "auto, continuation"),
        ("fit-curve points.xyz -o points.xyz", "overwrite an input"),
        ("fit-curve points.xyz -o c.json --init points.xyz", "overwrite|holds none"),
        ("fit-curve points.xyz -o c.json --report c.json", "two outputs"),
        ("fit-curve missing.xyz -o c.json", "check the path"),
    ] {
        let run = bench.run(arguments);
        assert_eq!(run.code, 2, "{arguments}: {}", run.stdout);
        assert!(message.split('|').any(|m| run.stderr.contains(m)), "{arguments}: {}", run.stderr);
    }
    assert!(!bench.files().contains(&"c.json".to_owned()));
    bench.put("gaps.xyz", format!("{}nan 1\n", ellipse(60)));
    let run = bench.run("fit-curve gaps.xyz -o gaps.json --control-points 10 --json -");
    assert_eq!((run.code, &run.report()["results"]["points_dropped"]), (0, &1.into()), "{}", run.stderr);
}

#[test]
fn curves_that_leave_their_points_are_said_to_do_so() {
    let bench = Bench::new();
    let ring = |count: usize, centre: f64, radius: f64| -> String {
        let at = |k: usize| TAU * (k * 37 % count) as f64 / count as f64;
        (0..count).map(|k| format!("{} {}\n", centre + radius * at(k).cos(), radius * at(k).sin())).collect()
    };
    // Two outlines in one file are two curves.
    bench.put("two.xyz", ring(90, 0.0, 9.0) + &ring(50, 1.0, 4.0));
    let run = bench.run("fit-curve two.xyz -o two.json --points-out feet.csv --json -");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let results = &run.report()["results"];
    assert_eq!(results["parts"].as_array().unwrap().len(), 2);
    assert_eq!((&results["covered"], &results["closed"]), (&true.into(), &true.into()));
    assert_eq!(json(&bench, "two.json")["shapes"].as_array().unwrap().len(), 2);
    assert_eq!(bench.text("feet.csv").lines().next().unwrap(), "x,y,foot_x,foot_y,distance,t,curve");
    assert!(bench.run("fit-curve two.xyz -o two.json").stdout.contains("2 curves"));
    // One through both runs where no points are, which is said with the place.
    let run = bench.run("fit-curve two.xyz -o one.json --closed --json report.json");
    assert_eq!(run.code, 1, "{}", run.stdout);
    let report = json(&bench, "report.json");
    assert_eq!(report["status"], "defective");
    let coverage = &report["results"]["coverage"];
    let parts = coverage["without_data"].as_array().unwrap();
    assert!(
        report["results"]["covered"] == false && report["results"]["parts"].as_array().unwrap().is_empty()
    );
    if let Some(first) = parts.first() {
        assert!(coverage["length_without_data"].as_f64().unwrap() > 3.0, "{coverage}");
        assert!(
            run.stderr.contains("has no points between t = ") && first["place"][0].is_number(),
            "{}",
            run.stderr
        );
    }
    // A point at the end of the world is far from the curve, and is left out if that is asked for.
    bench.put("far.xyz", ring(100, 0.0, 5.0) + "1e300 1\n");
    let run = bench.run("fit-curve far.xyz -o far.json --json -");
    assert_eq!((run.code, &run.report()["results"]["points_astray"]), (1, &1.into()), "{}", run.stderr);
    assert!(run.stderr.contains("point 100 (from 0)"), "{}", run.stderr);
    let run = bench.run("fit-curve far.xyz -o far.json --outliers automatic --json -");
    assert_eq!((run.code, &run.report()["results"]["points_used"]), (0, &100.into()), "{}", run.stderr);
    // The exact circle with as many control points as arcs need.
    let run = bench
        .run("fit-curve far.xyz -o six.json --outliers automatic --rational --control-points 6 --json -");
    assert!(run.code == 0 && run.report()["results"]["max"].as_f64().unwrap() < 1e-9, "{}", run.stderr);
    assert!(bench.run("fit-curve two.xyz -o one.json --max-gap -1").code == 2);
}

#[test]
fn a_curve_is_a_model_for_another_one() {
    let bench = Bench::new();
    bench.put(
        "model.json",
        r#"{"kind": "curve", "dim": 2, "degree": 2, "knots": [0, 0, 0, 1, 2, 3, 3, 3],
            "control_points": [[0, 0], [2, 4], [6, 4], [8, 0], [12, 2]]}"#,
    );
    let run = bench.run("fit-curve --model model.json -o c.json --control-points 9 --json -");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let report = run.report();
    let results = &report["results"];
    // As many as were asked for, or one less where the ends are held.
    assert!(results["covered"] == true && results["control_points"].as_u64().unwrap() >= 8, "{results}");
    // The curvature of the model jumps; nine control points of degree 3 leave a few hundredths.
    assert!(results["max"].as_f64().unwrap() < 0.1, "{results}");
    assert!(results["coverage"]["max"].as_f64().unwrap() < 0.1, "{results}");
    assert_eq!(bench.run("fit-curve model.json --model model.json -o c.json").code, 2);
    bench.put("points.xyz", "0 0\n1 1\n2 0\n");
    assert_eq!(bench.run("fit-curve --model points.xyz -o c.json").code, 2);
}
