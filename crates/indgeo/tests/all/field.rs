//! `indgeo field` as a user runs it.

use crate::common::{Bench, CUBE, fixture};
use serde_json::Value;

/// Shape and values of an NPY file.
fn npy(bytes: &[u8]) -> (Vec<usize>, Vec<f64>) {
    assert!(bytes.starts_with(b"\x93NUMPY\x01\x00"));
    let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = std::str::from_utf8(&bytes[10..10 + length]).unwrap();
    assert!(header.contains("'<f8'") && header.contains("'fortran_order': False"), "{header}");
    let shape = header.split('(').nth(1).unwrap().split(')').next().unwrap();
    let shape =
        shape.split(',').map(str::trim).filter(|part| !part.is_empty()).map(|part| part.parse().unwrap());
    let values = bytes[10 + length..].chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap()));
    (shape.collect(), values.collect())
}

fn field(bench: &Bench, arguments: &str) -> (Vec<usize>, Vec<f64>, Value) {
    let run = bench.run(&format!("field {arguments} -o out.npy --json -"));
    assert_eq!(run.code, 0, "{arguments}: {}", run.stderr);
    let (shape, values) = npy(&bench.read("out.npy"));
    (shape, values, run.report())
}

#[test]
fn ways_around_obstacles_are_exact() {
    let bench = Bench::new();
    let scene = fixture("field-cases/scene_aligned.json");
    let (shape, values, report) =
        field(&bench, &format!("{scene} --grid 129x129 --path 0.05,0.95 --picture s.svg"));
    assert_eq!(shape, [129, 129]);
    let text = std::fs::read_to_string(fixture("field-cases/scene_aligned.exact129.txt")).unwrap();
    let right: Vec<f64> = text.lines().map(|line| line.trim().parse().unwrap()).collect();
    assert_eq!(values.len(), right.len());
    for (node, (value, right)) in values.iter().zip(&right).enumerate() {
        assert!((value - right).abs() < 1e-13, "node {node}: {value}, {right}");
    }
    let results = &report["results"];
    assert_eq!(results["blocked"], right.iter().filter(|value| **value < 0.0).count());
    // The six targets of the scene, and the one of the command line.
    let paths = results["paths"].as_array().unwrap();
    assert_eq!(paths.len(), 7);
    for path in paths {
        let points: Vec<[f64; 2]> = serde_json::from_value(path["points"].clone()).unwrap();
        let sum: f64 = points.windows(2).map(|p| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1])).sum();
        assert!((sum - path["length"].as_f64().unwrap()).abs() < 1e-14, "{path}");
        assert_eq!(
            (points[0], *points.last().unwrap()),
            ([0.125, 0.1875], serde_json::from_value(path["target"].clone()).unwrap())
        );
    }
    assert!(bench.text("s.svg").contains("data:image/png;base64,iVBORw0KGgo"));

    // From node to node the error is of first order, and obstacles stay what they are.
    let mut errors = Vec::new();
    for grid in [129, 257] {
        let (_, exact, _) = field(&bench, &format!("{scene} --grid {grid}x{grid}"));
        for method in ["zhao", "fmm"] {
            let (_, values, report) =
                field(&bench, &format!("{scene} --grid {grid}x{grid} --method {method}"));
            assert_eq!(report["results"]["method"], method);
            let off = values.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            errors.push(off);
        }
    }
    assert!(errors[0] < 0.03 && (errors[0] - errors[1]).abs() < 1e-9, "{errors:?}");
    assert!(errors[2] < 0.75 * errors[0], "{errors:?}");
}

#[test]
fn points_by_all_methods() {
    let bench = Bench::new();
    bench.put("points.xyz", "0.2 0.3\n0.8 0.6\n");
    let right = |i: usize, j: usize| {
        let (x, y) = (i as f64 / 64.0, j as f64 / 64.0);
        (x - 0.2).hypot(y - 0.3).min((x - 0.8).hypot(y - 0.6))
    };
    for (method, tolerance) in
        [("exact", 1e-15), ("tsai", 1e-15), ("zhao", 0.02), ("fmm", 0.02), ("fmm2", 0.004)]
    {
        let (shape, values, _) =
            field(&bench, &format!("points.xyz --grid 65x65 --box 0,0,1,1 --method {method}"));
        assert_eq!(shape, [65, 65]);
        let off = (0..65 * 65).map(|k| (values[k] - right(k / 65, k % 65)).abs()).fold(0.0, f64::max);
        assert!(off <= tolerance, "{method}: {off}");
    }
}

#[test]
fn solids_have_an_inside_with_and_without_a_hole() {
    let bench = Bench::new();
    bench.put("cube.off", CUBE);
    // Without one of its faces.
    let lines: Vec<&str> = CUBE.lines().collect();
    bench.put("open.off", lines[..lines.len() - 1].join("\n").replacen("8 6", "8 5", 1));
    let (shape, closed, _) = field(&bench, "cube.off --grid 9x9x9 --signed");
    assert_eq!(shape, [9, 9, 9]);
    let middle = closed[(4 * 9 + 4) * 9 + 4];
    assert!(middle < 0.0 && closed[0] > 0.0);
    let (_, carried, report) = field(&bench, "cube.off --grid 9x9x9 --signed --method tsai");
    assert!(closed.iter().zip(&carried).all(|(a, b)| (a - b).abs() < 1e-12));
    assert_eq!(report["results"]["elements"], 12);
    let (_, holed, _) = field(&bench, "open.off --grid 9x9x9 --signed");
    assert!(holed[(4 * 9 + 4) * 9 + 4] < 0.0 && holed[0] > 0.0);
    let run = bench.run("field cube.off -o cube.vti --grid 5x6x7");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(String::from_utf8_lossy(&bench.read("cube.vti")).contains("WholeExtent=\"0 4 0 5 0 6\""));
}

#[test]
fn signs_are_those_of_the_body_and_not_of_its_triangles() {
    let bench = Bench::new();
    let grid = "--grid 9x9x9 --box=-0.5,-0.5,-0.5,1.5,1.5,1.5 --signed";
    bench.put("cube.off", CUBE);
    let (_, right, _) = field(&bench, &format!("cube.off {grid}"));
    let lines: Vec<&str> = CUBE.lines().collect();
    let (head, faces) = lines.split_at(10);
    let turned = |line: &str| {
        let corners: Vec<&str> = line.split(' ').skip(1).collect();
        format!("4 {}", corners.into_iter().rev().collect::<Vec<_>>().join(" "))
    };
    // Inside out, and with one face turned.
    let all: Vec<String> = faces.iter().map(|line| turned(line)).collect();
    let one: Vec<String> = faces
        .iter()
        .enumerate()
        .map(|(k, line)| if k == 2 { turned(line) } else { (*line).to_owned() })
        .collect();
    for (faces, warning) in [(all, ""), (one, "2 triangles turned")] {
        bench.put("other.off", format!("{}\n{}\n", head.join("\n"), faces.join("\n")));
        for method in ["exact", "fmm2"] {
            let (_, found, report) = field(&bench, &format!("other.off {grid} --method {method}"));
            assert!(found.iter().zip(&right).all(|(a, b)| (*a < 0.0) == (*b < 0.0)), "{method}");
            assert_eq!(report["warnings"].to_string().contains("turned"), !warning.is_empty());
            assert!(report["warnings"].to_string().contains(warning), "{report}");
        }
    }
    // Where two cubes overlap, faces of one lie within the other, and both sides of them are inside.
    let vertices: Vec<String> = lines[2..10].iter().map(|line| format!("{line}\n")).collect();
    let shifted = lines[2..10].iter().map(|line| {
        let (x, rest) = line.split_once(' ').unwrap();
        format!("{} {rest}\n", x.parse::<f64>().unwrap() + 0.5)
    });
    let later = faces.iter().map(|line| {
        let corners = line.split(' ').skip(1).map(|k| (k.parse::<u32>().unwrap() + 8).to_string());
        format!("4 {}\n", corners.collect::<Vec<_>>().join(" "))
    });
    let text: String = std::iter::once("OFF\n16 12 0\n".to_owned())
        .chain(vertices)
        .chain(shifted)
        .chain(faces.iter().map(|line| format!("{line}\n")))
        .chain(later)
        .collect();
    bench.put("two.off", text);
    let (_, found, _) = field(&bench, "two.off --grid 31x3x3 --box=-0.5,-0.5,-0.5,2.5,1.5,1.5 --signed");
    // Along the middle line x runs by tenths from -0.5; nodes on faces are left out.
    for i in (0..31).filter(|i| ![5, 10, 15, 20].contains(i)) {
        let value = found[(i * 3 + 1) * 3 + 1];
        assert_eq!(value < 0.0, (5..=20).contains(&i), "{i}: {value}");
    }
    assert!((found[(9 * 3 + 1) * 3 + 1] + 0.1).abs() < 1e-12, "{}", found[(9 * 3 + 1) * 3 + 1]);

    // A sheet has no inside, whatever the method.
    bench.put("sheet.off", "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0.2\n3 0 1 2\n3 0 2 3\n");
    for method in ["exact", "zhao"] {
        let run = bench.run(&format!("field sheet.off -o sheet.npy --grid 5x5x5 --signed --method {method}"));
        assert!(run.code == 2 && run.stderr.contains("surrounds nothing"), "{} {}", run.code, run.stderr);
    }
    assert_eq!(bench.run("field sheet.off -o sheet.npy --grid 5x5x5").code, 0);
}

#[test]
fn grids_are_described() {
    let bench = Bench::new();
    bench.put("cube.off", CUBE);
    bench.put(
        "walled.json",
        "{\"domain\":[0,1],\"source\":[0.1,0.1],\"polys\":[[[0.5,-1],[0.6,-1],[0.6,2],[0.5,2]]]}",
    );
    assert_eq!(bench.run("field cube.off -o cube.vti --grid 5x6x7 --signed").code, 0);
    // Nodes behind the wall cannot be reached.
    assert_eq!(bench.run("field walled.json -o walled.npy --grid 21x21").code, 0);
    let run = bench.run("info cube.vti walled.npy --json -");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let files = &run.report()["results"];
    let [cube, walled] = [&files[0], &files[1]];
    assert_eq!((&cube["kind"], &cube["format"]), (&"grid".into(), &"vti".into()), "{cube}");
    assert_eq!(cube["nodes"], serde_json::json!([5, 6, 7]));
    let least = cube["values"]["min"].as_f64().unwrap();
    assert!(
        least < 0.0 && cube["negative"].as_u64().unwrap() > 0 && cube["box"]["min"][0].is_f64(),
        "{cube}"
    );
    assert!(walled["non_finite"].as_u64().unwrap() > 50 && walled["box"].is_null(), "{walled}");
    let run = bench.run("info cube.vti");
    assert!(run.stdout.contains("5, 6, 7"), "{}", run.stdout);
    bench.put("cut.vti", &bench.read("cube.vti")[..500]);
    let run = bench.run("info cut.vti");
    assert!(run.code == 2 && run.stderr.contains("the file ends"), "{} {}", run.code, run.stderr);
}

#[test]
fn subdivision_surfaces_of_fields() {
    let bench = Bench::new();
    bench.put("cube.off", CUBE);
    assert_eq!(bench.run("field cube.off -o cube.vti --grid 17x17x17 --signed").code, 0);
    let run = bench.run(
        "fit-subdivision cube.vti -o control.obj --vertices 60 --max-iterations 4 --tolerance 0.2 --json -",
    );
    assert!(run.code < 2, "{}{}", run.stdout, run.stderr);
    let results = &run.report()["results"];
    assert_eq!(results["start"], "coarsened", "{results}");
    let [before, after] = ["initial_rms", "rms"].map(|key| results[key].as_f64().unwrap());
    assert!(after < 0.7 * before && after < 0.1, "{before} {after}");
    assert!(bench.text("control.obj").lines().filter(|line| line.starts_with("v ")).count() >= 50);
}

#[test]
fn points_that_are_left_out_are_told() {
    let bench = Bench::new();
    bench.put("points.csv", "x,y,z\n0,0,0\n1,0,0\n0,1,0\nnan,0,0\n");
    let run = bench.run("field points.csv -o f.npy --grid 5x5x5");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("1 of 4 points"), "{}", run.stderr);
    bench.put("huge.csv", "x,y,z\n0,0,0\n1e200,0,0\n0,1e200,0\n");
    let run = bench.run("field huge.csv -o f.npy --grid 5x5x5");
    assert!(run.code == 2 && run.stderr.contains("too large"), "{} {}", run.code, run.stderr);
    bench.put("cube.off", CUBE);
    let run = bench.run("geodesic cube.off --from 0 --metric feature --w 1e300 -o d.csv");
    assert!(run.code == 2 && run.stderr.contains("--w is 1e300,"), "{} {}", run.code, run.stderr);
}

#[test]
fn what_does_not_serve_is_refused() {
    let bench = Bench::new();
    bench.put("points.xyz", "0.2 0.3\n0.8 0.6\n");
    bench.put("one.xyz", "0.2 0.3\n");
    bench.put("inside.json", "{\"domain\":[0,1],\"source\":[0.5,0.5],\"polys\":[[[0,0],[1,0],[1,1],[0,1]]]}");
    bench.put("flat.json", "{\"domain\":[0,1],\"source\":[0.5,0.5],\"polys\":[[[0,0],[1,0]]]}");
    bench.put(
        "walled.json",
        "{\"domain\":[0,1],\"source\":[0.1,0.1],\"polys\":[[[0.5,-1],[0.6,-1],[0.6,2],[0.5,2]]]}",
    );
    for (arguments, part) in [
        ("points.xyz -o f.npy --grid 5x5x5", "--grid has 3 counts, but the shape lies in 2 dimensions"),
        ("points.xyz -o f.npy --grid 1x5", "counts of at least 2"),
        ("points.xyz -o f.npy --box 0,0,0,1", "has no extent"),
        ("points.xyz -o f.npy --box 0,0,1", "four or six"),
        ("points.xyz -o f.npy --signed", "no inside"),
        ("points.xyz -o f.npy --path 1,1", "give a scene"),
        ("points.xyz -o f.txt", "choose .npy or .vti"),
        ("points.xyz -o f.npy --grid 100000x100000", "bytes"),
        ("points.xyz", "nothing would be written"),
        ("one.xyz -o f.npy", "--box"),
        ("inside.json -o f.npy", "inside of obstacle 0"),
        ("flat.json -o f.npy", "no area"),
        ("walled.json -o f.npy --method tsai", "obstacles"),
        ("none.xyz -o f.npy", "check the path"),
    ] {
        let run = bench.run(&format!("field {arguments}"));
        assert!(run.code == 2 && run.stderr.contains(part), "{arguments}: {} {}", run.code, run.stderr);
    }
    // A wall across the whole domain: what lies behind it is infinite, and said so.
    let run = bench.run("field walled.json -o f.npy --grid 21x21 --path 0.9,0.9 --json -");
    assert_eq!(run.code, 1, "{}", run.stderr);
    let report = run.report();
    assert_eq!(
        (&report["results"]["paths"][0]["length"], &report["status"]),
        (&Value::Null, &"not_proven".into())
    );
    assert!(run.stderr.contains("no way leads to 189 of 441 nodes"), "{}", run.stderr);
}
