//! `indgeo geodesic` and `indgeo morphology` as a user runs them.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::Bench;
use serde_json::Value;

/// Two squares of side 1 that meet at a right angle along x = 1, 8 × 8 cells each, as OBJ.
fn corner() -> String {
    let n = 8u32;
    let mut text = String::new();
    let place = |i: u32| f64::from(i) / f64::from(n);
    for i in 0..=2 * n {
        for j in 0..=n {
            let (x, z) = if i <= n { (place(i), 0.0) } else { (1.0, place(i - n)) };
            text += &format!("v {x} {} {z}\n", place(j));
        }
    }
    for i in 0..2 * n {
        for j in 0..n {
            let [a, b, c, d] = [0, n + 1, n + 2, 1].map(|k| i * (n + 1) + j + k + 1);
            text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
        }
    }
    text
}

fn json(bench: &Bench, name: &str) -> Value {
    serde_json::from_str(&bench.text(name)).unwrap()
}

/// The last column of a CSV file.
fn last_column(bench: &Bench, name: &str) -> Vec<f64> {
    bench.text(name).lines().skip(1).map(|line| line.rsplit(',').next().unwrap().parse().unwrap()).collect()
}

#[test]
fn distances_and_curves_on_a_mesh() {
    let bench = Bench::new();
    bench.put("corner.obj", corner());
    let run =
        bench.run("geodesic corner.obj --from 0 --to 1,1,1 --to 152 -o d.csv --picture d.svg --json r.json");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(bench.text("d.csv").starts_with("vertex,x,y,z,distance\n0,0,0,0,0\n"));
    let found = last_column(&bench, "d.csv");
    assert!(found.len() == 17 * 9 && (found[152] - 5.0f64.sqrt()).abs() < 1e-12, "{}", found[152]);
    let report = json(&bench, "r.json");
    let paths = report["results"]["paths"].as_array().unwrap();
    for path in paths {
        assert!((path["length"].as_f64().unwrap() - 5.0f64.sqrt()).abs() < 1e-12, "{path}");
        assert!(path["is_geodesic"] == true && path["points"].as_array().unwrap().len() > 8);
    }
    assert!(paths.len() == 2 && bench.text("d.svg").contains("data:image/png;base64,iVBORw0KGgo"));
    let run = bench.run("geodesic corner.obj --from 0 --picture d.png -q");
    assert!(run.code == 0 && bench.read("d.png").starts_with(b"\x89PNG"), "{}", run.stderr);
    // A point within a triangle, and its distances to the corners of the square.
    let run = bench.run("geodesic corner.obj --from 0.3,0.41,0 -o p.csv");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let found = last_column(&bench, "p.csv");
    assert!(found.len() == 17 * 9 && (found[0] - 0.3f64.hypot(0.41)).abs() < 1e-12);
    // Feature sensitive: over the edge it costs π/2 w more.
    let run = bench.run("geodesic corner.obj --from 4 --metric feature --w 0.5 -o f.ply --json f.json");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let most = json(&bench, "f.json")["results"]["max"].as_f64().unwrap();
    let right = (2.0 + std::f64::consts::FRAC_PI_4).hypot(0.5);
    assert!((most - right).abs() < 0.02, "{most} {right}");
    let run = bench.run("info f.ply");
    assert!(run.stdout.contains("distance"), "{}", run.stdout);
}

#[test]
fn a_curve_on_a_surface() {
    let bench = Bench::new();
    bench.put(
        "square.json",
        r#"{"kind":"surface","degree_u":1,"degree_v":1,"knots_u":[0,0,1,1],"knots_v":[0,0,1,1],
        "control_points":[[[0,0,0],[0,2,0]],[[3,0,0],[3,2,0]]],"weights":null}"#,
    );
    let run = bench.run("geodesic square.json --from 0,0 --to 1,1 -o c.csv --json r.json");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let path = &json(&bench, "r.json")["results"]["paths"][0];
    assert!((path["length"].as_f64().unwrap() - 13.0f64.sqrt()).abs() < 1e-12, "{path}");
    assert!(bench.text("c.csv").starts_with("u,v,x,y,z\n0,0,0,0,0\n"));
}

#[test]
fn regions_grow_and_stop_at_features() {
    let bench = Bench::new();
    bench.put("corner.obj", corner());
    // The first column of vertices is region 1, the last one region 2.
    let label = |i: usize| if i < 9 { 1 } else { 2 * usize::from(i >= 144) };
    bench.put("labels.txt", (0..153).map(|i| format!("{}\n", label(i))).collect::<String>());
    let count = |name: &str, label: f64| last_column(&bench, name).iter().filter(|l| **l == label).count();
    let run = bench.run(
        "morphology corner.obj --regions labels.txt --operation dilate --radius 1.3 -o out.csv --json r.json",
    );
    assert_eq!(run.code, 0, "{}", run.stderr);
    // In space they meet in the middle.
    assert_eq!((count("out.csv", 1.0), count("out.csv", 2.0)), (9 * 9, 8 * 9));
    let regions = &json(&bench, "r.json")["results"]["regions"];
    assert!(regions[0]["vertices_before"] == 9 && regions[0]["vertices_after"] == 81, "{regions}");
    // The edge costs 1.57 for w = 1: neither region comes over it.
    bench.put("one.txt", (0..153).map(|i| format!("{} ", usize::from(i < 9))).collect::<String>());
    for (options, grown) in [("", 11 * 9), ("--metric feature --w 1", 9 * 9)] {
        let run = bench.run(&format!(
            "morphology corner.obj --regions one.txt --operation dilate --radius 1.26 -o out.ply {options}"
        ));
        assert_eq!(run.code, 0, "{}", run.stderr);
        let run = bench.run("convert out.ply out.csv");
        assert_eq!(run.code, 0, "{}", run.stderr);
        assert_eq!(count("out.csv", 1.0), grown, "{options}");
        // The labels of the result are those of a next step.
        let run = bench.run("morphology out.ply --regions label --operation erode --radius 0.3 -o back.csv");
        assert_eq!(run.code, 0, "{}", run.stderr);
        assert!(count("back.csv", 1.0) < grown);
    }
}

#[test]
fn what_is_wrong_is_said() {
    let bench = Bench::new();
    bench.put("corner.obj", corner());
    bench.put("points.xyz", "0 0 0\n1 0 0\n0 1 0\n");
    bench.put("short.txt", "1 0 0\n");
    bench.put("words.txt", "0\nred\n");
    // A triangle far away.
    bench.put("parts.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf 1 2 3\nf 4 5 6\n");
    for (arguments, code, message) in [
        ("geodesic points.xyz --from 0 -o d.csv", 2, "without triangles"),
        ("geodesic corner.obj --from 999 -o d.csv", 2, "none of the 153 vertices"),
        ("geodesic corner.obj --from 0.1,0.2 -o d.csv", 2, "parameters of a surface"),
        ("geodesic corner.obj --from a,b -o d.csv", 2, "a place is a vertex"),
        ("geodesic corner.obj --from 0 -o d.stl", 2, "choose .csv or .ply"),
        ("geodesic corner.obj --from 0 -o d.csv --metric feature", 2, "add --w LENGTH"),
        ("geodesic corner.obj --from 0 -o d.csv --w 1", 2, "add --metric feature"),
        ("geodesic corner.obj --from 0 -o d.csv --metric feature --w -1", 2, "--w is -1"),
        ("geodesic corner.obj --from 0", 2, "nothing would be written"),
        ("geodesic parts.obj --from 0 --to 4 -o d.csv", 1, ""),
        (
            "morphology corner.obj --regions short.txt --operation open --radius 1 -o o.csv",
            2,
            "3 labels for 153",
        ),
        (
            "morphology corner.obj --regions words.txt --operation open --radius 1 -o o.csv",
            2,
            "line 2: `red`",
        ),
        ("morphology corner.obj --regions none.txt --operation open --radius 1 -o o.csv", 2, "none.txt"),
        ("morphology corner.obj --regions short.txt --operation open --radius 0 -o o.csv", 2, "--radius"),
    ] {
        let run = bench.run(arguments);
        assert!(run.code == code && run.stderr.contains(message), "{arguments}: {} {}", run.code, run.stderr);
    }
    assert_eq!(last_column(&bench, "d.csv").iter().filter(|d| d.is_infinite()).count(), 3);
    assert!(!bench.files().contains(&"o.csv".to_owned()));
}
