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
    assert_eq!(
        text.lines().next(),
        Some("x,y,z,foot_x,foot_y,foot_z,distance,shape,u,v,status,lower_bound,on,side,entity")
    );
    let model = std::fs::read_to_string(BRACKET).unwrap();
    for (cells, (_, expected, uncertainty)) in rows(&text).iter().zip(table()) {
        // What the foot lies on is called by its number in the file.
        let kind = if cells[12] == "face" { "ADVANCED_FACE" } else { "EDGE_CURVE" };
        let record =
            model.split(';').find(|r| r.trim_start().starts_with(&format!("#{} =", cells[14]))).unwrap();
        assert!(record.contains(kind), "{cells:?} {record}");
        if expected.abs() > 1e-3 {
            assert_eq!(cells[13], if expected > 0.0 { "outside" } else { "inside" }, "{cells:?}");
        }
        let distance: f64 = cells[6].parse().unwrap();
        let allowed = (2.0 * uncertainty).max(7.4e-6);
        assert!((distance.abs() - expected.abs()).abs() <= allowed, "{cells:?} {expected}");
        assert!(expected.abs() <= allowed || (distance > 0.0) == (expected > 0.0), "{cells:?} {expected}");
    }
    let report: Value = serde_json::from_str(&bench.text("r.json")).unwrap();
    assert_eq!(report["model"]["unit"], "mm");
    assert!(report["model"]["points_unit"].as_str().unwrap().starts_with("mm"), "{report}");
    assert_eq!(
        (&report["results"]["wide_gaps"], &report["results"]["undecided_sides"]),
        (&0.into(), &0.into())
    );
    assert!(run.stdout.contains("units     model mm; points mm"), "{}", run.stdout);
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
    let parts = report["results"]["parts"].as_array().unwrap();
    assert_eq!((parts.len(), &parts[0]["count"]), (1, &report["results"]["total"]["count"]), "{parts:?}");
    assert_eq!(parts[0]["distance"]["rms"], report["results"]["total"]["distance"]["rms"]);
    assert!(bench.text("r.html").contains("unit: mm") && bench.text("r.html").contains("taken as mm"));
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
    assert_eq!(run.stderr.matches("25.4").count(), 1, "{}", run.stderr);
    let quiet = bench.run("project bracket.step inches.xyz -o out.csv --json r.json --quiet");
    assert!(quiet.stderr.is_empty() && bench.text("r.json").contains("25.4"), "{}", quiet.stderr);
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

#[test]
fn lines_are_followed_to_the_faces() {
    let bench = bench_with_points();
    // The bracket has a plate from x = 0 to 3; beside its holes lines along x meet both of its sides.
    bench.put("line.xyz", "-2 19 30\n5.5 19 30\n1 19 30\n-2 900 30\n");
    let run =
        bench.run("inspect bracket.step line.xyz --tolerance 9 --along 1,0,0 -o line.csv --json r.json");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let text = bench.text("line.csv");
    let rows = rows(&text);
    let near: Vec<f64> = rows[..3].iter().map(|cells| cells[9].parse().unwrap()).collect();
    assert!((near[0] - 2.0).abs() < 1e-12 && near[1] > 0.0 && near[2] < 0.0, "{near:?}");
    assert_eq!(rows[3].last().map(String::as_str), Some("no_hit"), "{text}");
    // The foot lies on the line, and on the model.
    for cells in &rows[..3] {
        assert!(
            cells[4] == cells[1] && cells[5] == cells[2] && cells[6].parse::<f64>().unwrap().abs() == 1.0,
            "{cells:?}"
        );
    }
}

#[test]
fn models_come_from_standard_input_too() {
    let bench = bench_with_points();
    let text = std::fs::read(BRACKET).unwrap();
    let info = bench.run_with("info - --json -", &text);
    assert_eq!(info.code, 0, "{}", info.stderr);
    let report: Value = serde_json::from_str(&info.stdout).unwrap();
    assert_eq!((&report["results"][0]["kind"], &report["results"][0]["faces"]), (&"cad".into(), &42.into()));
    let piped = bench.run_with("project - points.xyz -o piped.csv", &text);
    assert_eq!(piped.code, 0, "{}", piped.stderr);
    let read = bench.run("project bracket.step points.xyz -o read.csv");
    assert_eq!(read.code, 0, "{}", read.stderr);
    assert_eq!(bench.text("piped.csv"), bench.text("read.csv"));
    let broken = bench.run_with("info -", &text[..text.len() / 2]);
    assert!(broken.code == 2 && broken.stderr.contains("standard input"), "{}", broken.stderr);
}

#[test]
fn info_names_the_tolerances_and_their_faces() {
    let bench = bench_with_points();
    let text = std::fs::read_to_string(BRACKET).unwrap();
    let records = "
#90001=SHAPE_ASPECT('hole','',#7,.T.);
#90002=GEOMETRIC_ITEM_SPECIFIC_USAGE('','',#90001,#8,#1085);
#90003=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));
#90004=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(0.2),#90003);
#90005=DATUM('','',#7,.F.,'A');
#90006=DATUM_REFERENCE(1,#90005);
#90007=PARALLELISM_TOLERANCE('Parallelism.1','',#90004,#90001,(#90006));
";
    let end = text.rfind("ENDSEC").unwrap();
    bench.put("pmi.step", format!("{}{records}{}", &text[..end], &text[end..]));
    let run = bench.run("info pmi.step");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stdout.contains("#90007 parallelism \"Parallelism.1\" 0.2 to A: #1085"), "{}", run.stdout);
    let run = bench.run("info pmi.step --json -");
    let report: Value = serde_json::from_str(&run.stdout).unwrap();
    let stated = &report["results"][0]["tolerances"];
    assert_eq!(stated.as_array().map(Vec::len), Some(1), "{stated}");
    assert_eq!(
        (&stated[0]["value"], &stated[0]["datums"][0], &stated[0]["faces"][0]),
        (&0.2.into(), &"A".into(), &"#1085".into())
    );
}

#[test]
fn each_part_has_its_own_deviations() {
    let bench = Bench::new();
    let three = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../fixtures/cad/00000050_80d90bfdd2e74e709956122a_step_000.step"
    );
    std::fs::copy(three, bench.path("three.step")).unwrap();
    // Points of the triangles of all parts lie within the chord tolerance of them.
    let made = bench.run("convert three.step points.ply --chord 1e-5");
    assert_eq!(made.code, 0, "{}", made.stderr);
    let run = bench.run("inspect three.step points.ply --tolerance 2e-5 --json r.json --report r.html");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let report: Value = serde_json::from_str(&bench.text("r.json")).unwrap();
    let parts = report["results"]["parts"].as_array().unwrap();
    assert_eq!(parts.len(), 3);
    let count: u64 = parts.iter().map(|part| part["count"].as_u64().unwrap()).sum();
    assert_eq!(Some(count), report["results"]["total"]["count"].as_u64());
    assert_eq!(run.stdout.matches("  part      ").count(), 3, "{}", run.stdout);
    assert!(bench.text("r.html").contains("id=\"parts\""));
}

#[test]
fn a_point_that_is_far_beyond_all_numbers_is_no_reason_to_pass() {
    let bench = Bench::new();
    std::fs::copy(BRACKET, bench.path("bracket.step")).unwrap();
    for (far, outcome) in [("1e200 0 0", "over"), ("1.7e308 1.7e308 1.7e308", "not_converged")] {
        bench.put("points.xyz", format!("0 20.5 49\n{far}\n"));
        let run = bench.run("inspect bracket.step points.xyz -t 0.1 --json r.json");
        assert!(run.code == 1 && run.stdout.contains("FAIL: 1 of 2"), "{outcome}: {}", run.stdout);
    }
    let run = bench.run("project bracket.step points.xyz -o out.csv");
    assert!(run.code == 1 && run.stderr.contains("1 of 2 points did not converge"), "{}", run.stderr);
    // Cut off in the middle: where.
    let bytes = std::fs::read(BRACKET).unwrap();
    bench.put("cut.step", &bytes[..bytes.len() / 3]);
    let run = bench.run("info cut.step");
    let is_told = run.stderr.contains("cut.step:") && run.stderr.contains("truncated");
    assert!(run.code == 2 && is_told, "{}", run.stderr);
}
