//! STEP files as models of `info`, `project`, `inspect` and `register`.

use crate::common::{Bench, rows};
use serde_json::Value;

const BRACKET: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/cad/nema-17-bracket.step");
const TABLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/cad/nema-17-bracket.csv");

/// Points of the table with the distance that belongs to each, signed where the side is known.
fn table() -> Vec<([f64; 3], f64, f64)> {
    let text = std::fs::read_to_string(TABLE).unwrap();
    let number = |cells: &[String], i: usize| cells[i].parse::<f64>().unwrap();
    rows(&text)
        .iter()
        .map(|cells| {
            let side = number(cells, 10);
            let sign = if side == 0.0 { 1.0 } else { side };
            ([0, 1, 2].map(|i| number(cells, i)), sign * number(cells, 3), number(cells, 4))
        })
        .collect()
}

fn bench_with_points() -> Bench {
    let bench = Bench::new();
    std::fs::copy(BRACKET, bench.path("bracket.step")).unwrap();
    let text: String = table().iter().map(|([x, y, z], _, _)| format!("{x} {y} {z}\n")).collect();
    bench.put("points.xyz", &text);
    bench
}

#[test]
fn info_tells_units_faces_and_tolerances() {
    let bench = bench_with_points();
    let run = bench.run("info bracket.step --json -");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let report: Value = serde_json::from_str(&run.stdout).unwrap();
    let fact = &report["results"][0];
    assert_eq!(fact["kind"], "cad", "{}", run.stdout);
    assert_eq!((&fact["unit"], &fact["faces"]), (&Value::from("mm"), &Value::from(42)));
    assert!(fact["edge_tolerance_max"].as_f64().unwrap() <= 1.1e-7 + 1e-6);
    assert!(fact["not_read"].as_array().unwrap().is_empty());
}

#[test]
fn distances_are_those_from_the_trimmed_faces() {
    let bench = bench_with_points();
    let run = bench.run("project bracket.step points.xyz -o out.csv --json r.json");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let text = bench.text("out.csv");
    assert_eq!(text.lines().next(), Some("x,y,z,foot_x,foot_y,foot_z,distance,shape,u,v,status,lower_bound"));
    for (cells, (_, expected, uncertainty)) in rows(&text).iter().zip(table()) {
        let distance: f64 = cells[6].parse().unwrap();
        let allowed = (2.0 * uncertainty).max(7.4e-6);
        assert!((distance.abs() - expected.abs()).abs() <= allowed, "{cells:?} {expected}");
        assert!(expected.abs() <= allowed || (distance > 0.0) == (expected > 0.0), "{cells:?} {expected}");
    }
    let report: Value = serde_json::from_str(&bench.text("r.json")).unwrap();
    assert_eq!(report["model"]["unit"], "mm");
    assert_eq!(report["inputs"][0]["format"], "step");
}

#[test]
fn inspection_reports_each_face() {
    let bench = bench_with_points();
    let run = bench.run("inspect bracket.step points.xyz --tolerance 0.5 --json r.json --report r.html");
    assert_eq!(run.code, 1, "{}{}", run.stdout, run.stderr);
    let report: Value = serde_json::from_str(&bench.text("r.json")).unwrap();
    let within = table().iter().filter(|(_, d, _)| d.abs() <= 0.5).count();
    assert!(report.to_string().contains('#'), "faces are called by their numbers");
    assert!(within > 0 && bench.text("r.html").contains("<html"));
}

#[test]
fn a_scan_in_inches_is_pointed_out() {
    let bench = bench_with_points();
    // A scan of the part: points near it only.
    let near = table().into_iter().filter(|(_, d, _)| d.abs() < 1.0);
    let text: String =
        near.map(|([x, y, z], _, _)| format!("{} {} {}\n", x / 25.4, y / 25.4, z / 25.4)).collect();
    bench.put("inches.xyz", &text);
    let run = bench.run("project bracket.step inches.xyz -o out.csv");
    assert!(run.stderr.contains("25.4"), "{}", run.stderr);
}

#[test]
fn damaged_files_say_what_is_wrong() {
    let bench = bench_with_points();
    let text = std::fs::read_to_string(BRACKET).unwrap();
    bench.put("cut.step", &text[..text.len() / 3]);
    let run = bench.run("project cut.step points.xyz -o out.csv");
    assert_eq!(run.code, 2, "{}", run.stdout);
    assert!(run.stderr.contains("cut.step"), "{}", run.stderr);
    assert!(!bench.path("out.csv").exists());
}

#[test]
fn faces_are_chosen_by_number() {
    let bench = bench_with_points();
    bench.put("one.xyz", "0 0 0\n100 50 20\n");
    let all = bench.run("project bracket.step one.xyz -o all.csv");
    assert_eq!(all.code, 0, "{}", all.stderr);
    let one = bench.run("project bracket.step one.xyz -o one.csv --faces #1085");
    assert_eq!(one.code, 0, "{}", one.stderr);
    let distance =
        |name: &str| rows(&bench.text(name)).iter().map(|c| c[6].parse::<f64>().unwrap().abs()).sum::<f64>();
    assert!(distance("one.csv") > distance("all.csv"));
    let wrong = bench.run("project bracket.step one.xyz -o no.csv --faces #3");
    assert_eq!(wrong.code, 2);
    assert!(wrong.stderr.contains("#3"), "{}", wrong.stderr);
    let unit = bench.run("project bracket.step one.xyz -o no.csv --unit inch");
    assert!(unit.code == 2 && unit.stderr.contains("mm"), "{}", unit.stderr);
}
