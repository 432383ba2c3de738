//! `indgeo convert` from NURBS to triangles and polylines.

use crate::common::{Bench, fixture};

/// Vertices and triangles of an OBJ file.
fn obj(text: &str) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let numbers: Vec<f64> = words.take(3).map(|word| word.parse().unwrap()).collect();
                vertices.push([numbers[0], numbers[1], numbers[2]]);
            }
            Some("f") => {
                let corners: Vec<usize> =
                    words.map(|word| word.split('/').next().unwrap().parse::<usize>().unwrap() - 1).collect();
                triangles.push([corners[0], corners[1], corners[2]]);
            }
            _ => {}
        }
    }
    (vertices, triangles)
}

fn largest_distance(bench: &Bench, model: &str, points: &[[f64; 3]]) -> f64 {
    let rows: Vec<String> = points.iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
    bench.put("check.xyz", rows.concat());
    let run = bench.run(&format!("project {model} check.xyz -o check.csv --json -"));
    assert_eq!(run.code, 0, "{}", run.stderr);
    run.report()["results"]["max"].as_f64().unwrap()
}

#[test]
fn surfaces_become_triangles_within_the_chord_tolerance() {
    let bench = Bench::new();
    let model = fixture("demo/stud-bolt-model.json");
    let mut counts = Vec::new();
    for chord in [0.1, 0.02] {
        let run = bench.run(&format!("convert {model} bolt.obj --chord {chord} --json -"));
        assert_eq!(run.code, 0, "{}", run.stderr);
        let report = run.report();
        assert_eq!(report["results"]["chord"], chord);
        let (vertices, triangles) = obj(&bench.text("bolt.obj"));
        assert_eq!(report["results"]["triangles"], triangles.len());
        counts.push(triangles.len());
        assert!(largest_distance(&bench, &model, &vertices) < 1e-9);
        let inner: Vec<[f64; 3]> = (triangles.iter().step_by(7))
            .map(|corners| {
                [0, 1, 2].map(|axis| corners.iter().map(|k| vertices[*k][axis]).sum::<f64>() / 3.0)
            })
            .collect();
        let off = largest_distance(&bench, &model, &inner);
        assert!(off > 0.0 && off <= chord, "{off}");
    }
    assert!(counts[1] > counts[0]);
    for name in ["bolt.stl", "bolt.ply", "bolt.off"] {
        assert_eq!(bench.run(&format!("convert {model} {name}")).code, 0);
        let run = bench.run(&format!("info {name}"));
        assert!(run.code == 0 && run.stdout.contains("triangles"), "{}", run.stdout);
    }
}

/// A circle of radius 2 about (1, 0).
const CIRCLE: &str = r#"{"kind": "curve", "degree": 2, "knots": [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4],
    "control_points": [[3, 0], [3, 2], [1, 2], [-1, 2], [-1, 0], [-1, -2], [1, -2], [3, -2], [3, 0]],
    "weights": [1, 0.7071067811865476, 1, 0.7071067811865476, 1, 0.7071067811865476, 1, 0.7071067811865476, 1]}"#;

#[test]
fn curves_become_polylines() {
    let bench = Bench::new();
    bench.put("circle.json", CIRCLE);
    for name in ["c.svg", "c.dxf", "c.obj", "c.ply"] {
        let run = bench.run(&format!("convert circle.json {name} --chord 0.001 --json -"));
        assert_eq!(run.code, 0, "{name}: {}", run.stderr);
        assert_eq!(run.report()["results"]["polylines"], 1);
    }
    let (vertices, _) = obj(&bench.text("c.obj"));
    assert!(vertices.len() > 30);
    for (k, [x, y, z]) in vertices.iter().enumerate() {
        assert!(((x - 1.0).hypot(*y) - 2.0).abs() < 1e-12 && *z == 0.0);
        let [a, b, _] = vertices[(k + 1) % vertices.len()];
        let middle = ((x + a) / 2.0 - 1.0).hypot((y + b) / 2.0);
        assert!(2.0 - middle <= 1e-3, "{middle}");
    }
    assert!(bench.text("c.svg").contains(" Z\"/>") && bench.text("c.dxf").ends_with("EOF\n"));
}

#[test]
fn what_a_format_cannot_hold_is_refused() {
    let bench = Bench::new();
    bench.put("circle.json", CIRCLE);
    bench.put("points.xyz", "0 0 0\n1 0 0\n0 1 0\n");
    let model = fixture("demo/stud-bolt-model.json");
    for (arguments, part) in [
        ("convert circle.json c.stl".to_owned(), "choose svg, dxf, obj or ply"),
        (format!("convert {model} b.svg"), "surfaces"),
        ("convert points.xyz p.dxf".to_owned(), "holds curves only"),
        ("convert points.xyz p.ply --chord 1".to_owned(), "--chord has no effect"),
        ("convert circle.json c.json --chord 1".to_owned(), "--chord has no effect"),
        ("convert circle.json c.dxf --chord 0".to_owned(), "positive length"),
        ("convert circle.json c.dxf --chord 1e-30".to_owned(), "choose another --chord"),
    ] {
        let run = bench.run(&arguments);
        assert!(run.code == 2 && run.stderr.contains(part), "{arguments}: {} {}", run.code, run.stderr);
    }
    assert_eq!(bench.files(), ["circle.json", "points.xyz"]);
}
