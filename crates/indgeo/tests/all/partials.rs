//! Partial results of tiles and ranges, merged: the same to the byte as one run, or refused.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::{Bench, SQUARE};
use std::fs;

/// How points are measured and judged in all tests.
const OPTIONS: &str = "-t 0.05 --max-distance 1.5 --worst 7 --picture 150";

/// A binary PLY of points `from..to` of a cloud near the square, with a NaN now and then.
fn ply(from: u32, to: u32) -> Vec<u8> {
    let header = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\nend_header\n",
        to - from
    );
    let mut bytes = header.into_bytes();
    for i in from..to {
        let [x, y, z] = point(i);
        [x, y, z].iter().for_each(|value| bytes.extend(value.to_le_bytes()));
    }
    bytes
}

fn point(i: u32) -> [f64; 3] {
    let share = |step: f64| (f64::from(i) * step).fract();
    let z = if i % 53 == 7 { f64::NAN } else { 0.2 * share(0.732_050_8) - 0.1 };
    [2.0 * share(0.618_033_988), 2.0 * share(0.414_213_5), z]
}

/// The same as text with a name for each point.
fn csv(from: u32, to: u32) -> String {
    let rows = (from..to).map(|i| {
        let [x, y, z] = point(i);
        format!("P{i},{x},{y},{z}\n")
    });
    std::iter::once("name,x,y,z\n".to_owned()).chain(rows).collect()
}

/// What one run and what a merge printed and wrote, byte for byte.
fn outcome(bench: &Bench, arguments: &str) -> (i32, String, String, Vec<u8>, Vec<u8>) {
    let run = bench.run(&format!("{arguments} --no-timings --json report.json --report page.html"));
    assert!(run.code < 2, "{arguments}: {}", run.stderr);
    (run.code, run.stdout, run.stderr, bench.read("report.json"), bench.read("page.html"))
}

fn refused(bench: &Bench, arguments: &str) -> String {
    let before = bench.files();
    let run = bench.run(&format!("{arguments} --report refused.html"));
    assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{arguments}");
    assert_eq!(bench.files(), before, "{arguments}");
    run.stderr
}

#[test]
fn tiles_in_any_order_give_the_report_of_one_run() {
    let bench = Bench::new();
    bench.put("square.json", SQUARE);
    fs::create_dir(bench.path("tiles")).unwrap();
    // The second of the formats is read as a whole, and gives the worst points names.
    bench.put("tiles/a.ply", ply(0, 400));
    bench.put("tiles/b.csv", csv(400, 700));
    bench.put("tiles/c.ply", ply(700, 1000));
    bench.put("pose.json", "{\"matrix\": [[1, 0, 0, 0.01], [0, 1, 0, 0], [0, 0, 1, 0.02], [0, 0, 0, 1]]}");
    let options = format!("{OPTIONS} --transform pose.json --min-share 0.3");
    let whole = outcome(&bench, &format!("inspect square.json tiles {options}"));
    assert_eq!(
        whole,
        outcome(&bench, &format!("inspect square.json tiles/c.ply tiles/a.ply tiles/b.csv {options}"))
    );
    for (tile, name) in [("a.ply", "1"), ("b.csv", "2"), ("c.ply", "3")] {
        let run =
            bench.run(&format!("inspect square.json tiles/{tile} {options} --partial {name}.part.json"));
        assert_eq!(run.code, 0, "{}", run.stderr);
    }
    assert_eq!(
        whole,
        outcome(&bench, "merge 3.part.json 1.part.json 2.part.json --tiles tiles --threads 1")
            .with_threads(&whole)
    );
    assert_eq!(whole.0, 0);
    let text = String::from_utf8(whole.3).unwrap();
    let report: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(report["results"]["points"], 1000);
    assert_eq!(report["inputs"].as_array().unwrap().len(), 4);
    assert!(text.contains("\"name\": \"P"), "no worst point has a name");

    // A missing tile, one too many, one twice.
    let error = refused(&bench, "merge 1.part.json 3.part.json --tiles tiles");
    assert!(error.contains("tiles/b.csv: there is no partial result of this file"), "{error}");
    let error = refused(&bench, "merge 1.part.json 3.part.json --tiles tiles/a.ply");
    assert!(
        error.contains("3.part.json: the partial result is of tiles/c.ply, which --tiles does not name"),
        "{error}"
    );
    let error = refused(&bench, "merge 1.part.json 1.part.json");
    assert!(
        error.contains("1.part.json: points 0..400 of tiles/a.ply are in 1.part.json already"),
        "{error}"
    );
    // A copy of a tile under another name is the same tile.
    bench.put("copy.ply", ply(0, 400));
    assert_eq!(
        bench.run(&format!("inspect square.json copy.ply {options} --partial copy.part.json")).code,
        0
    );
    let error = refused(&bench, "merge 1.part.json copy.part.json");
    assert!(error.contains("these points are in copy.part.json already"), "{error}");
}

/// The report says how many threads were asked for, which is all that may differ.
trait WithThreads {
    fn with_threads(self, like: &Self) -> Self;
}

impl WithThreads for (i32, String, String, Vec<u8>, Vec<u8>) {
    fn with_threads(mut self, like: &Self) -> Self {
        let text = String::from_utf8(self.3).unwrap();
        assert_eq!(text.matches("\"threads\": 1").count(), 1);
        self.3 = text.replace("\"threads\": 1", "\"threads\": null").into_bytes();
        assert_eq!(self.3.len(), like.3.len());
        self
    }
}

#[test]
fn ranges_of_a_file_give_the_report_of_one_run() {
    let bench = Bench::new();
    bench.put("square.json", SQUARE);
    bench.put("scan.ply", ply(0, 1000));
    bench.put("scan.csv", csv(0, 1000));
    for (from, to) in [("scan.ply", "scan.las"), ("scan.ply", "scan.laz"), ("scan.ply", "scan.e57")] {
        // LAS has no NaN, and E57 leaves such points out.
        bench.put("finite.ply", ply(8, 59));
        let from = if from == "scan.ply" && to != "scan.e57" { "finite.ply" } else { from };
        assert_eq!(bench.run(&format!("convert {from} {to}")).code, 0);
    }
    for (file, cuts) in [
        ("scan.ply", vec![0, 333, 334, 1000]),
        ("scan.csv", vec![0, 500, 1000]),
        ("scan.e57", vec![0, 970, 981]),
        ("scan.las", vec![0, 20, 51]),
        ("scan.laz", vec![0, 20, 51]),
    ] {
        for extra in ["", "--drop-non-finite"] {
            let whole = outcome(&bench, &format!("inspect square.json {file} {OPTIONS} {extra}"));
            let mut partials = String::new();
            for (number, pair) in cuts.windows(2).enumerate().rev() {
                let range = format!("--points {}..{} --partial {number}.json", pair[0], pair[1]);
                let run = bench.run(&format!("inspect square.json {file} {OPTIONS} {extra} {range}"));
                assert_eq!(run.code, 0, "{}", run.stderr);
                partials += &format!(" {number}.json");
            }
            assert_eq!(whole, outcome(&bench, &format!("merge{partials}")), "{file} {extra}");
        }
    }
    let error = refused(&bench, "merge 0.json");
    assert!(error.contains("0.json: points 20..51 of scan.laz are in no partial result"), "{error}");
    let error = refused(&bench, "merge 1.json");
    assert!(error.contains("1.json: points 0..20 of scan.laz are in no partial result"), "{error}");
    assert_eq!(
        bench
            .run(&format!(
                "inspect square.json scan.laz {OPTIONS} --drop-non-finite --points 10..51 --partial 2.json"
            ))
            .code,
        0
    );
    let error = refused(&bench, "merge 0.json 2.json");
    assert!(error.contains("2.json: points 10..20 of scan.laz are in 0.json already"), "{error}");
    for (range, what) in [
        ("0..52", "holds 51 points"),
        ("5..5", "A below B"),
        ("a..b", "A below B"),
        ("60..70", "holds 51 points"),
    ] {
        let run =
            bench.run(&format!("inspect square.json scan.laz {OPTIONS} --points {range} --partial x.json"));
        assert_eq!(run.code, 2);
        assert!(run.stderr.contains(what), "{}", run.stderr);
    }
    assert!(!bench.path("x.json").exists());
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let bench = Bench::new();
    bench.put("square.json", SQUARE);
    bench.put("a.ply", ply(0, 100));
    bench.put("b.ply", ply(100, 200));
    let make = |arguments: &str| {
        let run = bench.run(arguments);
        assert_eq!(run.code, 0, "{arguments}: {}", run.stderr);
    };
    make("inspect square.json a.ply -t 0.05 --partial a.json");
    make("inspect square.json b.ply -t 0.06 --partial b.json");
    let error = refused(&bench, "merge a.json b.json");
    assert!(
        error.contains("b.json: the partial result was made with --lower=-0.06, otherwise than a.json"),
        "{error}"
    );
    bench.put("moved.json", "{\"matrix\": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.5], [0, 0, 0, 1]]}");
    make("inspect square.json b.ply -t 0.05 --transform moved.json --partial b.json");
    let error = refused(&bench, "merge a.json b.json");
    assert!(error.contains("b.json: the points were moved by another motion"), "{error}");
    bench.put("other.json", SQUARE.replace("2.0", "2.5").replace('2', "3"));
    bench.put("mesh.off", "OFF\n4 2 0\n0 0 0\n2 0 0\n2 2 0\n0 2 0\n3 0 1 2\n3 0 2 3\n");
    make("inspect mesh.off b.ply -t 0.05 --partial b.json");
    let error = refused(&bench, "merge a.json b.json");
    assert!(
        error.contains("b.json: the partial result is of another model (mesh.off) than a.json"),
        "{error}"
    );

    make("inspect square.json b.ply -t 0.05 --partial b.json");
    let error = refused(&bench, "merge a.json b.json --model mesh.off");
    assert!(error.contains("mesh.off: this is not the model that a.json was measured from"), "{error}");
    fs::rename(bench.path("square.json"), bench.path("elsewhere.json")).unwrap();
    let error = refused(&bench, "merge a.json b.json");
    assert!(error.contains("square.json"), "{error}");
    assert!(bench.run("merge a.json b.json --model elsewhere.json").code < 2);

    // Damage, and files that are something else.
    let good = bench.text("b.json");
    for damaged in [
        good.replacen("\"points\":1", "\"points\":2", 1),
        good[..good.len() / 2].to_owned(),
        String::new(),
        "{}".to_owned(),
    ] {
        bench.put("b.json", damaged);
        let error = refused(&bench, "merge a.json b.json --model elsewhere.json");
        assert!(error.contains("b.json:") && error.contains("damaged"), "{error}");
    }
    bench.put("b.json", good.replacen(concat!("indgeo ", env!("CARGO_PKG_VERSION")), "indgeo 0.0.1", 1));
    let error = refused(&bench, "merge a.json b.json --model elsewhere.json");
    assert!(error.contains("was made by indgeo 0.0.1"), "{error}");
    let error = refused(&bench, "merge a.json missing.json");
    assert!(error.contains("missing.json"), "{error}");
}

#[test]
fn tiles_that_cannot_be_measured_are_named() {
    let bench = Bench::new();
    bench.put("square.json", SQUARE);
    fs::create_dir(bench.path("empty")).unwrap();
    bench.put("empty/readme.txt.bak", "nothing");
    bench.put("a.ply", ply(0, 100));
    bench.put("c.ply", ply(200, 300));
    bench.put("nan.xyz", "nan 0 0\n0 nan 0\n");
    let mut damaged = ply(100, 200);
    damaged.truncate(900);
    bench.put("b.ply", damaged);
    for (arguments, what) in [
        ("inspect square.json empty -t 1", "empty: the folder holds no scans"),
        ("merge a.json --tiles empty", "empty: the folder holds no scans"),
        ("inspect square.json a.ply b.ply -t 1", "b.ply"),
        ("inspect square.json b.ply -t 1 --partial p.json", "b.ply"),
        ("inspect square.json a.ply ./a.ply -t 1", "a.ply: the file is named twice"),
        ("inspect square.json a.ply b.ply -t 1 --partial p.json", "--partial takes one file of points"),
        ("inspect square.json a.ply b.ply -t 1 --points 0..5", "is for one file of points"),
        (
            "inspect square.json a.ply c.ply -t 1 -o out.las",
            "out.las: deviations per point of several files are written as CSV or PLY",
        ),
        ("inspect square.json a.ply -t 1 --partial a.ply", "this would overwrite an input"),
        ("inspect missing.json a.ply -t 1 --partial p.json", "missing.json"),
        ("inspect square.json nan.xyz -t 1 --partial p.json", "nan.xyz: no point has finite coordinates"),
        (
            "inspect square.json a.ply nan.xyz -t 1 --report p.html",
            "nan.xyz: no point has finite coordinates",
        ),
        ("register square.json nan.xyz --partial p.json", "nan.xyz: no point has finite coordinates"),
    ] {
        let before = bench.files();
        let run = bench.run(arguments);
        assert_eq!(run.code, 2, "{arguments}");
        assert!(run.stderr.contains(what), "{arguments}: {}", run.stderr);
        assert_eq!(bench.files(), before, "{arguments}");
    }
    let run = bench.run_with("inspect square.json - -t 1 --partial p.json", b"0 0 0\n");
    assert!(run.code == 2 && run.stderr.contains("-:"), "{}", run.stderr);
}

/// A box of triangles, 2 × 3 × 4 around (100, 0, 0).
const BOX: &str = "OFF\n8 12 0\n99 -1.5 -2\n101 -1.5 -2\n101 1.5 -2\n99 1.5 -2\n99 -1.5 2\n101 -1.5 2\n101 1.5 2\n99 1.5 2\n\
    3 0 2 1\n3 0 3 2\n3 4 5 6\n3 4 6 7\n3 0 1 5\n3 0 5 4\n3 1 2 6\n3 1 6 5\n3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 4 7\n";

/// Points on the box, turned about z by 0.02 and shifted, as text.
fn scan_of_box(from: u32, to: u32) -> String {
    let point = |i: u32| {
        let share = |step: f64| (f64::from(i) * step).fract() - 0.5;
        let (a, b) = (share(0.618_033_988), share(0.414_213_5));
        let side = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        let [x, y, z] = match i % 3 {
            0 => [side, 3.0 * a, 4.0 * b],
            1 => [2.0 * a, 1.5 * side, 4.0 * b],
            _ => [2.0 * a, 3.0 * b, 2.0 * side],
        };
        let (sin, cos) = 0.02f64.sin_cos();
        format!("{} {} {}\n", 100.0 + cos * x - sin * y + 0.03, sin * x + cos * y - 0.02, z + 0.01)
    };
    (from..to).map(point).collect()
}

#[test]
fn steps_of_a_registration_are_the_same_for_any_tiles() {
    let bench = Bench::new();
    bench.put("box.off", BOX);
    bench.put("whole.xyz", scan_of_box(0, 900));
    bench.put("a.xyz", scan_of_box(0, 500));
    bench.put("b.xyz", scan_of_box(500, 900));
    let step = |tiles: &[&str], init: &str| {
        let mut partials = String::new();
        for (number, tile) in tiles.iter().enumerate().rev() {
            let run = bench
                .run(&format!("register box.off {tile} {init} --max-distance 1 --partial sums{number}.json"));
            assert_eq!(run.code, 0, "{}", run.stderr);
            partials += &format!(" sums{number}.json");
        }
        let run = bench.run(&format!("merge {partials} --transform next.json --json step.json --no-timings"));
        assert_eq!(run.code, 0, "{}", run.stderr);
        let report: serde_json::Value = serde_json::from_str(&bench.text("step.json")).unwrap();
        (bench.text("next.json"), report["results"].clone())
    };
    let mut init = String::new();
    let mut motions = Vec::new();
    for _ in 0..8 {
        let (pose, results) = step(&["a.xyz", "b.xyz"], &init);
        // Another cut of the same points has the same step, to the bit.
        let ranges = ["whole.xyz --points 100..900", "whole.xyz --points 0..100"];
        for tiles in [&ranges[..], &["whole.xyz"][..]] {
            assert_eq!(step(tiles, &init), (pose.clone(), results.clone()));
        }
        motions.push(results["motion"].as_f64().unwrap());
        assert_eq!((&results["points_used"], &results["free"]), (&900.into(), &0.into()));
        bench.put("pose.json", &pose);
        "--init pose.json".clone_into(&mut init);
    }
    assert!(motions[0] > 1e-3 && motions[7] < 1e-12, "{motions:?}");
    // The inverse of the turn and the shift.
    let pose: serde_json::Value = serde_json::from_str(&bench.text("pose.json")).unwrap();
    let entry = |row: usize, column: usize| pose["matrix"][row][column].as_f64().unwrap();
    assert!((entry(0, 1) - 0.02f64.sin()).abs() < 1e-9 && (entry(2, 3) + 0.01).abs() < 1e-9, "{pose}");
    // The pose serves the other commands, too.
    assert_eq!(bench.run("inspect box.off whole.xyz -t 1e-8 --transform pose.json").code, 0);

    // Sums about another start, of an inspection, of nothing.
    let run = bench.run("register box.off a.xyz --max-distance 1 --partial sums1.json");
    assert_eq!(run.code, 0);
    let error = refused(&bench, "merge sums0.json sums1.json");
    assert!(error.contains("moved by another motion"), "{error}");
    let run = bench.run("inspect box.off b.xyz -t 1 --partial other.json");
    assert_eq!(run.code, 0);
    let error = refused(&bench, "merge sums1.json other.json");
    assert!(error.contains("other.json: one partial result is of an inspection"), "{error}");
    let run = bench.run("register box.off a.xyz --max-distance 1e-9 --partial sums1.json");
    assert_eq!(run.code, 0);
    let run = bench.run("merge sums1.json --transform none.json --json none.step.json");
    assert!(
        run.code == 2 && run.stderr.contains("no point of the scans lies on the model"),
        "{}",
        run.stderr
    );
    assert!(!bench.path("none.json").exists());
    // Points on one face leave three motions open.
    bench.put(
        "face.xyz",
        (0..50)
            .map(|i| format!("{} {} 2.1\n", 99.5 + 0.02 * f64::from(i), (f64::from(i) * 0.7).sin()))
            .collect::<String>(),
    );
    assert_eq!(bench.run("register box.off face.xyz --partial face.json").code, 0);
    let run = bench.run("merge face.json --json -");
    assert_eq!(
        (run.code, &run.report()["status"], &run.report()["results"]["free"]),
        (1, &"underdetermined".into(), &3.into())
    );
    for (arguments, what) in [
        ("register box.off a.xyz --partial p.json -o moved.ply", "cannot be used with"),
        ("register box.off a.xyz --points 0..5 --transform t.json", "--partial"),
        ("register a.xyz b.xyz --partial p.json", "a model is needed"),
        ("merge sums0.json --report page.html", "page.html: the sums of a step have no page"),
        ("merge other.json --transform t.json", "t.json: partial results of inspections have no pose"),
    ] {
        let run = bench.run(arguments);
        assert!(run.code == 2 && run.stderr.contains(what), "{arguments}: {}", run.stderr);
    }
}
