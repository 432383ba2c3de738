//! Fits of surfaces to what is hardly a surface: volumes, curves, outliers, wild coordinates, noise, very many pieces.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::Bench;
use crate::common::known::{Surface, cloud, normal, number, results};
use serde_json::Value;
use std::f64::consts::TAU;

#[test]
fn volumes_and_curves_are_no_surfaces() {
    let bench = Bench::new();
    bench.put(
        "block.xyz",
        (0..1000).map(|k| format!("{} {} {}\n", k % 10, k / 10 % 10, k / 100)).collect::<String>(),
    );
    bench.put(
        "ball.xyz",
        cloud(3000, 51, |next| {
            loop {
                let p = [0; 3].map(|_| 2.0 * next() - 1.0);
                if p.iter().map(|c| c * c).sum::<f64>() < 1.0 {
                    return p;
                }
            }
        }),
    );
    bench.put(
        "line.xyz",
        cloud(500, 52, |next| {
            let t = next();
            [t, 2.0 * t + 1.0, 3.0 * t]
        }),
    );
    bench.put(
        "circle.xyz",
        cloud(500, 53, |next| {
            let a = TAU * next();
            [a.cos(), a.sin(), 0.5]
        }),
    );
    for (name, message) in [("block", "volume"), ("ball", "volume"), ("line", "line"), ("circle", "curve")] {
        for options in ["", "--shape sphere", "--tolerance 0.5"] {
            let run = bench.run(&format!("fit-surface {name}.xyz -o s.json {options}"));
            assert!(run.code == 1 || run.code == 2, "{name} {options}: {}{}", run.stdout, run.stderr);
            assert!(
                run.code == 1 || run.stderr.contains(message) || run.stderr.contains("curve"),
                "{}",
                run.stderr
            );
        }
        let run = bench.run(&format!("fit-ruled {name}.xyz -o s.json"));
        assert!(run.code == 1 || run.code == 2, "{name}: {}{}", run.stdout, run.stderr);
    }
}

#[test]
fn outliers_are_recognised_before_they_bend_the_surface() {
    let bench = Bench::new();
    for (count, outliers) in [(400, 4), (600, 30), (5000, 250)] {
        let mut number_of = 0;
        bench.put(
            "sheet.xyz",
            cloud(count + outliers, 61, |next| {
                number_of += 1;
                let (x, y) = (10.0 * next(), 10.0 * next());
                let off = if number_of > count { 1.5 + 2.5 * next() } else { 0.0 };
                [x, y, 0.02 * (x - 5.0).powi(2) + off]
            }),
        );
        let run = bench.run("fit-surface sheet.xyz -o s.json --outliers automatic --json -");
        assert_eq!(run.code, 0, "{count}: {}{}", run.stdout, run.stderr);
        let far = Surface::read(&bench, "s.json").farthest(|[x, _, z]| (z - 0.02 * (x - 5.0).powi(2)).abs());
        assert!(far < 0.02, "{count}: {far}");
    }
}

#[test]
fn corners_of_points_without_noise_are_no_outliers() {
    let bench = Bench::new();
    let mut number_of = 0;
    bench.put(
        "corner.xyz",
        cloud(1260, 67, |next| {
            number_of += 1;
            if number_of > 1200 {
                return [12.0 * next() - 6.0, 12.0 * next() - 6.0, 4.0 * next() - 1.0];
            }
            let (u, v) = (next(), next());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let (x, y) = (10.0 * u - 5.0, 10.0 * v - 5.0);
            [x, y, 0.03 * (x * x + 0.5 * y * y)]
        }),
    );
    let run = bench.run("fit-surface corner.xyz -o s.json --outliers automatic --json -");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let found = results(&run);
    // A triangle of the area 50, a little more for its curvature; its corners are where the fewest points are.
    let area = number(&found["coverage"]["area"]);
    assert!((49.0..54.0).contains(&area) && number(&found["rms"]) < 1e-3, "{area} {}", found["rms"]);
}

#[test]
fn steep_and_slanted_ends_belong_to_the_surface() {
    use std::f64::consts::{PI, TAU};
    let bench = Bench::new();
    let half = cloud(1500, 68, |next| {
        let (a, height) = (PI * next(), 8.0 * next());
        [3.0 * a.cos(), 3.0 * a.sin(), height]
    });
    let slanted = cloud(2000, 69, |next| {
        // As many for each area.
        loop {
            let (a, height) = (TAU * next(), 9.0 * next());
            if height <= 7.0 + 2.0 * a.cos() {
                return [2.0 * a.cos(), 2.0 * a.sin(), height];
            }
        }
    });
    for (points, expected, is_trimmed) in [(half, 24.0 * PI, false), (slanted, 28.0 * PI, true)] {
        bench.put("tube.xyz", points);
        let run = bench.run("fit-surface tube.xyz -o s.json --json -");
        assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
        let found = results(&run);
        let area = number(&found["coverage"]["area"]);
        assert!((area - expected).abs() < 0.06 * expected, "{area} of {expected}");
        assert!(number(&found["max"]) < 0.05, "{}", found["max"]);
        assert_eq!(bench.text("s.json").contains("\"trim\""), is_trimmed);
    }
}

#[test]
fn smoothing_acts() {
    let bench = Bench::new();
    bench.put(
        "sheet.xyz",
        cloud(4000, 71, |next| {
            let (x, y) = (10.0 * next(), 10.0 * next());
            [x, y, (0.7 * x).sin() + 0.1 * normal(next)]
        }),
    );
    let mut last = 0.0;
    let mut bytes = Vec::new();
    for smoothing in ["1e-5", "1e-3", "1e-1"] {
        let run = bench.run(&format!(
            "fit-surface sheet.xyz -o s.json --control-points 15x15 --smoothing {smoothing} --json -"
        ));
        let found = results(&run);
        // The distance of the surface that is written grows with it, and its λ is the one that was asked for, if it was kept.
        let rms = number(&found["rms"]);
        assert!(rms >= last, "{smoothing}: {rms} after {last}");
        last = rms;
        assert!(!bytes.contains(&bench.text("s.json")), "{smoothing}");
        bytes.push(bench.text("s.json"));
    }
}

#[test]
fn one_wild_point_neither_hangs_nor_decides() {
    let bench = Bench::new();
    let sheet = cloud(600, 81, |next| {
        let (x, y) = (3.0 * next(), 2.0 * next());
        [x, y, 0.2 * x * y]
    });
    for wild in ["1e300 0 0", "0 0 -1e160", "1e308 1e308 -1e308"] {
        bench.put("wild.xyz", format!("{sheet}{wild}\n"));
        for command in [
            "fit-surface wild.xyz -o s.json --control-points 6x6 --max-iterations 5 --json -",
            "fit-ruled wild.xyz -o s.json --control-points 6x2 --max-iterations 5 --json -",
        ] {
            let run = bench.run(command);
            assert_eq!(run.code, 1, "{command}: {}{}", run.stdout, run.stderr);
            let found = results(&run);
            assert!(number(&found["max"]) > 1e159, "{}", found["max"]);
            assert_eq!(found["max_index"], 600);
        }
        let off = Surface::read(&bench, "s.json").farthest(|[x, y, z]| (z - 0.2 * x * y).abs());
        assert!(off < 0.2, "{off}");
    }
    let tiny = cloud(600, 81, |next| [3e-160 * next(), 2e-160 * next(), 1e-161 * next()]);
    bench.put("tiny.xyz", tiny);
    for command in ["fit-surface", "fit-ruled", "parameterize"] {
        let run = bench.run(&format!("{command} tiny.xyz -o s.json"));
        assert_eq!(run.code, 2, "{command}: {}{}", run.stdout, run.stderr);
        assert!(run.stderr.contains("e-160") || run.stderr.contains("e-161"), "{}", run.stderr);
    }
}

#[test]
fn many_control_points_are_taken_where_there_is_something_to_follow() {
    let bench = Bench::new();
    bench.put(
        "waves.xyz",
        cloud(8000, 91, |next| {
            let (x, y) = (10.0 * next(), 10.0 * next());
            [x, y, 0.5 * (2.0 * x).sin() * (2.0 * y).cos() + 0.02 * normal(next)]
        }),
    );
    let run = bench.run("fit-surface waves.xyz -o s.json --json -");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    assert!(number(&results(&run)["rms"]) < 0.024, "{}", results(&run)["rms"]);
    // Noise alone asks for no more than to begin with.
    bench.put("noise.xyz", cloud(8000, 92, |next| [10.0 * next(), 10.0 * next(), 0.15 * normal(next)]));
    let run = bench.run("fit-surface noise.xyz -o s.json --json -");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    assert_eq!(results(&run)["control_points"], serde_json::json!([12, 12]));
}

#[test]
fn models_of_many_pieces_fit_into_memory() {
    let bench = Bench::new();
    // 20,000 plane patches side by side.
    let patch = |k: usize| {
        let (x, y) = ((k % 200) as f64, (k / 200) as f64);
        let net = serde_json::json!([
            [[x, y, 0.0], [x, y + 1.0, 0.0]],
            [[x + 1.0, y, 0.0], [x + 1.0, y + 1.0, 0.0]]
        ]);
        serde_json::json!({
            "kind": "surface", "degree_u": 1, "degree_v": 1, "knots_u": [0, 0, 1, 1], "knots_v": [0, 0, 1, 1],
            "control_points": net,
        })
    };
    let shapes: Vec<Value> = (0..20_000).map(patch).collect();
    bench.put("many.json", serde_json::json!({ "kind": "model", "shapes": shapes }).to_string());
    let run = bench.run("fit-ruled many.json -o r.json --control-points 4x2 --max-iterations 3 --json -");
    assert!(run.code < 2, "{}{}", run.stdout, run.stderr);
    assert!(results(&run)["points"].as_u64().unwrap() <= 300_000);
    // A polygon of 20,000 corners has a vertex, or many, that no control mesh can have.
    let n = 20_000;
    let corner = |k: usize| {
        let a = TAU * k as f64 / n as f64;
        format!("v {} {} {}\n", a.cos(), a.sin(), 0.1 * (3.0 * a).sin())
    };
    let face: String = (1..=n).map(|k| format!(" {k}")).collect();
    bench.put("polygon.obj", (0..n).map(corner).collect::<String>() + &format!("f{face}\n"));
    let run = bench.run("fit-subdivision polygon.obj -o c.obj --max-iterations 2");
    assert!((1..=2).contains(&run.code), "{}{}", run.stdout, run.stderr);
}

#[test]
fn folded_edges_of_subdivision_surfaces_are_told() {
    let bench = Bench::new();
    // A sphere as a mesh of latitudes and longitudes.
    let (rows, columns) = (24, 48);
    let mut text = String::new();
    for i in 0..=rows {
        let (sin, cos) = (std::f64::consts::PI * f64::from(i) / f64::from(rows)).sin_cos();
        let around = if i == 0 || i == rows { 1 } else { columns };
        for j in 0..around {
            let a = TAU * f64::from(j) / f64::from(columns);
            text += &format!("v {} {} {}\n", sin * a.cos(), sin * a.sin(), cos);
        }
    }
    let vertex = |i: i32, j: i32| match i {
        0 => 1,
        i if i == rows => 2 + (rows - 1) * columns,
        i => 2 + (i - 1) * columns + j.rem_euclid(columns),
    };
    for i in 0..rows {
        for j in 0..columns {
            let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
            if i > 0 {
                text += &format!("f {a} {b} {d}\n");
            }
            if i + 1 < rows {
                text += &format!("f {b} {c} {d}\n");
            }
        }
    }
    bench.put("ball.obj", text);
    let run = bench.run("fit-subdivision ball.obj -o c.obj --vertices 100 --limit l.obj --json -");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let found = results(&run);
    assert_eq!(
        (&found["folded_edges"]["limit"], &found["folded_edges_of_input"]),
        (&0.into(), &0.into()),
        "{found}"
    );
    // The area of the unit sphere.
    assert!((number(&found["coverage"]["area"]) - 2.0 * TAU).abs() < 0.1, "{}", found["coverage"]);
    assert_eq!(number(&found["coverage"]["area_without_data"]), 0.0);
}

#[test]
fn many_control_points_do_not_follow_noise() {
    let bench = Bench::new();
    // As many control points as nearly one for each point.
    bench.put(
        "sheet.xyz",
        cloud(4000, 95, |next| {
            let (x, y) = (10.0 * next(), 10.0 * next());
            [x, y, (0.5 * x).sin() + 0.15 * normal(next)]
        }),
    );
    let run = bench.run("fit-surface sheet.xyz -o s.json --control-points 56x56 --json -");
    let rms = number(&results(&run)["rms"]);
    assert!((0.14..0.155).contains(&rms), "{rms}: {}", run.stderr);
    let surface = Surface::read(&bench, "s.json");
    let mut square = 0.0;
    for k in 0..10_000 {
        let [x, _, z] = surface.at([(k / 100) as f64 / 99.0, (k % 100) as f64 / 99.0]);
        square += (z - (0.5 * x).sin()).powi(2) / 1e4;
    }
    assert!(square.sqrt() < 0.04, "{}", square.sqrt());
}
