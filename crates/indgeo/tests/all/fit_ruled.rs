//! `indgeo fit-ruled` as a user runs it.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::{Bench, CUBE, SQUARE};
use serde_json::Value;
use std::f64::consts::TAU;

/// Points at `(a, h)`, angle and height from 0 to 1, scattered.
fn scattered(count: usize, place: impl Fn(f64, f64) -> [f64; 3]) -> String {
    let at = |k: usize| {
        let (a, h) = ((k as f64 * 0.618_033_988_75).fract() * TAU, (k as f64 + 0.5) / count as f64);
        let [x, y, z] = place(a, h);
        format!("{x} {y} {z}\n")
    };
    (0..count).map(at).collect()
}

/// A tube with a waist.
fn vase(count: usize) -> String {
    scattered(count, |a, h| {
        let r = 5.0 - 2.0 * (std::f64::consts::PI * h).sin();
        [r * a.cos(), r * a.sin(), 12.0 * h]
    })
}

fn net(bench: &Bench, name: &str) -> Vec<Vec<[f64; 3]>> {
    let surface: Value = serde_json::from_str(&bench.text(name)).unwrap();
    assert_eq!(surface["degree_v"], 1);
    serde_json::from_value(surface["control_points"].clone()).unwrap()
}

#[test]
fn a_hyperboloid_is_one_ruled_surface() {
    let bench = Bench::new();
    let text = scattered(2000, |a, h| {
        let z = 2.0 * h - 1.0;
        [a.cos() - z * a.sin(), a.sin() + z * a.cos(), 2.0 * z]
    });
    bench.put("hyperboloid.xyz", text);
    let run = bench.run("fit-ruled hyperboloid.xyz -o h.json --controls 24x2 --json report.json");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    assert!(run.stdout.contains("2 sections of 24"), "{}", run.stdout);
    let report: Value = serde_json::from_str(&bench.text("report.json")).unwrap();
    let results = &report["results"];
    assert!(results["rms"].as_f64().unwrap() < 1e-4, "{results}");
    assert_eq!(results["folds"]["folded"], serde_json::json!([]));
    // Normals turn along its rulings, by 90 degrees between z = ±1 where the slopes were equal.
    assert!(results["developability"]["max_angle"].as_f64().unwrap() > 0.5, "{results}");
    assert_eq!((&results["base"], net(&bench, "h.json")[0].len()), (&"cylinder".into(), 2));
}

#[test]
fn layers_are_added_until_the_tolerance_holds_and_stay_level() {
    let bench = Bench::new();
    bench.put("vase.xyz", vase(1500));
    let run = bench
        .run("fit-ruled vase.xyz -o layers.json --controls 12x3 --tolerance 0.005 --level=0,0,1 --max-iterations 40 --json -");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let results = &run.report()["results"];
    assert_eq!(results["within_tolerance"], true, "{results}");
    assert!(results["max"].as_f64().unwrap() <= 0.005 && results["runs"].as_u64().unwrap() > 1);
    let net = net(&bench, "layers.json");
    assert!(net[0].len() > 2, "one ruled surface cannot follow this waist so closely");
    for j in 0..net[0].len() {
        let spread = net.iter().map(|row| (row[j][2] - net[0][j][2]).abs()).fold(0.0, f64::max);
        assert!(spread < 1e-9, "section {j}: {spread}");
    }
    // The inspection agrees.
    let run = bench.run("inspect layers.json vase.xyz --tolerance 0.00501");
    assert_eq!(run.code, 0, "{}", run.stdout);
    // The result is a start again, and what is out of reach is said.
    let run = bench.run("fit-ruled vase.xyz --init layers.json --tolerance 1e-6 --json -");
    assert_eq!(run.code, 1, "{}", run.stdout);
    assert_eq!(run.report()["status"], "out_of_tolerance");
}

#[test]
fn an_offset_runs_beside_the_shape() {
    let bench = Bench::new();
    bench.put("vase.xyz", vase(2000));
    let run = bench.run("fit-surface vase.xyz -o vase.json --controls 16x12 --json -");
    assert_eq!(run.code, 0, "{}", run.stderr);
    for (radius, least, most) in [("1", 0.8, 1.2), ("-1", -1.2, -0.8)] {
        let run = bench.run(&format!(
            "fit-ruled vase.json -o axis.json --controls 20x9 --offset {radius} --json report.json"
        ));
        assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
        // Nodes of the sections lie off the surface by the radius, on the same side as it.
        let net: Vec<String> = net(&bench, "axis.json")
            .iter()
            .flat_map(|row| row[1..row.len() - 1].iter().map(|p| format!("{} {} {}\n", p[0], p[1], p[2])))
            .collect();
        bench.put("net.xyz", net.concat());
        let run = bench.run("inspect vase.json net.xyz --tolerance 2 --json inspection.json");
        assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
        let report: Value = serde_json::from_str(&bench.text("inspection.json")).unwrap();
        let mean = report["results"]["total"]["distance"]["mean"].as_f64().unwrap();
        assert!((least..most).contains(&mean), "{mean}");
    }
    // A cutter that is too large for the waist is told.
    let run = bench.run("fit-ruled vase.json -o axis.json --controls 20x9 --offset 20 --json -");
    assert!(run.stderr.contains("cut into") || run.code == 2, "{}", run.stderr);
}

#[test]
fn open_patches_find_the_direction_of_their_rulings() {
    let bench = Bench::new();
    // Curved along the short side, straight along the long one.
    let text = scattered(1500, |a, h| {
        let (x, y) = (10.0 * a / TAU, 3.0 * h);
        [x, y, 0.5 * (2.0 * y).sin()]
    });
    bench.put("wave.xyz", text);
    let run = bench.run("fit-ruled wave.xyz -o wave.json --controls 14x2 --json -");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let results = &run.report()["results"];
    assert_eq!(results["base"], "plane");
    assert!(results["rms"].as_f64().unwrap() < 0.01, "{results}");
    assert!(results["developability"]["max_angle"].as_f64().unwrap() < 0.2, "{results}");
}

#[test]
fn bad_input_and_usage() {
    let bench = Bench::new();
    bench.put("square.json", SQUARE);
    bench.put("cube.off", CUBE);
    bench.put("vase.xyz", vase(300));
    bench.put("line.xyz", (0..50).map(|k| format!("{k} {k} 0\n")).collect::<String>());
    bench.put("same.xyz", "1 2 3\n".repeat(20));
    bench.put("flat.xyz", "0 0\n1 0\n0 1\n1 1\n");
    bench.put(
        "cubic.json",
        SQUARE
            .replace("[0,0,1,1],\n\"knots_v\":[0,0,1,1]", "[0,0,1,1],\n\"knots_v\":[0,0,0,1,1,1]")
            .replace("\"degree_v\":1", "\"degree_v\":2")
            .replace(
                "[[[0,0,0],[0,2,0]],[[2,0,0],[2,2,0]]]",
                "[[[0,0,0],[0,1,0],[0,2,0]],[[2,0,0],[2,1,0],[2,2,0]]]",
            ),
    );
    for (command, message) in [
        ("fit-ruled vase.xyz", "nothing would be written"),
        ("fit-ruled line.xyz -o out.json", "on a line"),
        ("fit-ruled same.xyz -o out.json", "in one place"),
        ("fit-ruled flat.xyz -o out.json", "two columns"),
        ("fit-ruled vase.xyz -o vase.xyz", "overwrite"),
        ("fit-ruled vase.xyz -o out.json --tolerance nan", "tolerance"),
        ("fit-ruled vase.xyz -o out.json --controls 12x1", "too few for degree 1"),
        ("fit-ruled vase.xyz -o out.json --offset 1", "normals"),
        ("fit-ruled vase.xyz -o out.json --level=0,0,0", "direction"),
        (
            "fit-ruled vase.xyz -o out.json --developable -1",
            "--developable <LENGTH>': it must be a number of at least 0",
        ),
        ("fit-ruled vase.xyz -o out.json --init cubic.json", "degree in v is 2"),
        ("fit-ruled vase.xyz -o out.json --init vase.xyz", "a surface is needed"),
        ("fit-ruled missing.xyz -o out.json", "missing.xyz"),
    ] {
        let run = bench.run(command);
        assert_eq!(run.code, 2, "{command}: {}{}", run.stdout, run.stderr);
        assert!(run.stderr.contains(message), "{command}: {}", run.stderr);
    }
    bench.put("gaps.xyz", format!("{}nan 1 2\n", vase(500)));
    let run = bench.run("fit-ruled gaps.xyz --json - --controls 10x4");
    assert_eq!((run.code, &run.report()["results"]["points_dropped"]), (0, &1.into()), "{}", run.stderr);
}
