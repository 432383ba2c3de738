//! Surfaces that end where their data end, and fits to models: outlines, meshes and STEP files of pieces of surfaces.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::Bench;
use crate::common::known::{P, cloud, number, results};
use serde_json::Value;
use std::f64::consts::{PI, TAU};

fn dished(x: f64, y: f64) -> P {
    [x, y, 0.03 * (x * x + 0.5 * y * y)]
}

/// Area of the triangles of an OBJ file, and its vertices.
fn triangles(text: &str) -> (f64, Vec<P>) {
    let mut vertices: Vec<P> = Vec::new();
    let mut area = 0.0;
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.first() {
            Some(&"v") => vertices.push([1, 2, 3].map(|k| words[k].parse().unwrap())),
            Some(&"f") => {
                let corner = |k: usize| words[k].split('/').next().unwrap().parse::<usize>().unwrap() - 1;
                let [a, b, c] = [1, 2, 3].map(|k| vertices[corner(k)]);
                let (u, v) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
                let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
                area += 0.5 * n.iter().map(|x| x * x).sum::<f64>().sqrt();
            }
            _ => {}
        }
    }
    (area, vertices)
}

#[test]
fn discs_and_angles_end_where_their_points_do() {
    let bench = Bench::new();
    let disc = |next: &mut dyn FnMut() -> f64| {
        let (a, r) = (TAU * next(), 5.0 * next().sqrt());
        dished(r * a.cos(), r * a.sin())
    };
    let angle = |next: &mut dyn FnMut() -> f64| {
        let (mut x, mut y) = (10.0 * next() - 5.0, 10.0 * next() - 5.0);
        while x > -1.0 && y > -1.0 {
            (x, y) = (10.0 * next() - 5.0, 10.0 * next() - 5.0);
        }
        dished(x, y)
    };
    // Distance of a place beyond the outline, in the plane; area in the plane.
    let beyond_disc = |p: P| (p[0].hypot(p[1]) - 5.0).max(0.0);
    let beyond_angle = |p: P| (p[0].abs().max(p[1].abs()) - 5.0).max((p[0] + 1.0).min(p[1] + 1.0)).max(0.0);
    let cases: [(String, &dyn Fn(P) -> f64, f64); 2] = [
        (cloud(2500, 3, disc), &beyond_disc, PI * 25.0),
        (cloud(2500, 4, angle), &beyond_angle, 100.0 - 36.0),
    ];
    for (points, beyond, flat) in cases {
        bench.put("points.xyz", points);
        let run = bench.run("fit-surface points.xyz -o s.json --json -");
        assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
        let found = results(&run);
        assert_eq!(found["trim_loops"], 1, "{found}");
        let area = number(&found["coverage"]["area"]);
        // The dish is two per cent larger than the plane; random points end about half a spacing, .1, before the outline.
        assert!(area > 0.9 * flat && area < 1.06 * flat, "{area} {flat}");
        let file: Value = serde_json::from_str(&bench.text("s.json")).unwrap();
        assert!(file["trim"][0].as_array().unwrap().len() > 3);
        // Triangles end there, too, and have the same area.
        assert_eq!(bench.run("convert s.json s.obj --chord 0.01").code, 0);
        let (triangulated, vertices) = triangles(&bench.text("s.obj"));
        assert!((triangulated / area - 1.0).abs() < 0.02, "{triangulated} {area}");
        let far = vertices.iter().map(|p| beyond(*p)).fold(0.0, f64::max);
        assert!(far < 0.4, "{far}");
        let off = vertices.iter().map(|p| (dished(p[0], p[1])[2] - p[2]).abs()).fold(0.0, f64::max);
        assert!(off < 0.02, "{off}");
        // And so does the face of a STEP file: nothing of it is nearer to a place far beyond.
        assert_eq!(bench.run("convert s.json s.step --unit mm").code, 0);
        assert!(bench.text("s.step").contains("FACE_BOUND"));
        let info = bench.run("info s.step");
        assert_eq!(info.code, 0, "{}", info.stderr);
        bench.put("corner.xyz", "4.9 4.9 1.08045\n");
        let run = bench.run("project s.step corner.xyz -o feet.csv --json -");
        assert_eq!(run.code, 0, "{}", run.stderr);
        assert!(number(&results(&run)["max"]) > 1.0, "{}", results(&run));
        // What takes the whole surface says so.
        let run = bench.run("project s.json corner.xyz -o feet.csv");
        assert!(run.stderr.contains("trim"), "{}", run.stderr);
    }
    // Loops that cannot be are refused with the place.
    let mut file: Value = serde_json::from_str(&bench.text("s.json")).unwrap();
    file["trim"] = serde_json::json!([[[0.0, 0.0], [7.0, 0.0], [1.0, 1.0]]]);
    bench.put("bad.json", file.to_string());
    let run = bench.run("info bad.json");
    assert!(run.code == 2 && run.stderr.contains("trim") && run.stderr.contains("domain"), "{}", run.stderr);
}

#[test]
fn a_mesh_is_a_model_for_a_surface_of_few_control_points() {
    let bench = Bench::new();
    // A saddle of 24 x 24 cells, two triangles each.
    let n = 24;
    let at = |k: usize| -1.0 + 2.0 * k as f64 / n as f64;
    let mut text = String::new();
    for i in 0..=n {
        for j in 0..=n {
            let (x, y) = (2.0 * at(i), at(j));
            text += &format!("v {x} {y} {}\n", 0.3 * x * x - 0.4 * y * y);
        }
    }
    let number_of = |i: usize, j: usize| i * (n + 1) + j + 1;
    for i in 0..n {
        for j in 0..n {
            let [a, b] = [number_of(i, j), number_of(i + 1, j)];
            text += &format!("f {a} {b} {}\nf {a} {} {}\n", b + 1, b + 1, a + 1);
        }
    }
    bench.put("saddle.obj", text);
    let run =
        bench.run("fit-surface --model saddle.obj -o s.json --degrees 3x3 --control-points 5x8 --json -");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let found = results(&run);
    assert_eq!(found["folds"]["folded"].as_array().map_or(0, Vec::len), 0, "{found}");
    assert_eq!(found["control_points"], serde_json::json!([5, 8]));
    // Triangles of that size leave the saddle by 1e-3.
    assert!(number(&found["rms"]) < 5e-3, "{found}");
    let surface = crate::common::known::Surface::read(&bench, "s.json");
    let off = surface.farthest(|p| (p[2] - 0.3 * p[0] * p[0] + 0.4 * p[1] * p[1]).abs());
    assert!(off < 0.02, "{off}");
    // Points and a model at once make no sense.
    assert_eq!(bench.run("fit-surface saddle.obj --model saddle.obj -o s.json").code, 2);
    assert_eq!(bench.run("fit-surface -o s.json").code, 2);
}
