//! Registrations of thin parts that begin far off: a scan that ends tilted through a sheet is doubted, a part that was made badly is not.

use crate::common::Bench;
use crate::common::sheets::{Part, Point, Random, SIZE, centre, sum, times, turned, warped};
use serde_json::Value;
use std::fmt::Write as _;

/// What is registered.
struct Scan {
    kind: &'static str,
    thickness: f64,
    noise: f64,
    warp: f64,
    degrees: f64,
    axis: Point,
}

/// Puts part and scan into a folder; the true places of the points.
fn put(bench: &Bench, scan: &Scan) -> Vec<Point> {
    let part = Part::new(scan.kind, scan.thickness);
    bench.put("part.off", part.to_off());
    let mut random = Random(5);
    let (points, normals) = part.scan(600, &mut random);
    let middle = centre(&points);
    let noisy = |(x, normal): (&Point, &Point)| {
        let off = [random.gauss(), random.gauss(), random.gauss()];
        sum(warped(*x, *normal, middle, scan.warp), times(off, SIZE * scan.noise))
    };
    let truth: Vec<Point> = points.iter().zip(&normals).map(noisy).collect();
    let mut text = String::from("x,y,z\n");
    for x in &truth {
        let [x, y, z] = sum(turned(sum(*x, times(middle, -1.0)), scan.axis, scan.degrees), middle);
        let _ = writeln!(text, "{x},{y},{z}");
    }
    bench.put("scan.csv", text);
    truth
}

/// Exit status, results and what was said, and how far the points are from where they belong, as a share of the size.
fn registered(bench: &Bench, truth: &[Point], options: &str) -> (i32, Value, String, f64) {
    let run = bench.run(&format!("register part.off scan.csv --json report.json -o moved.csv {options}"));
    let report: Value = serde_json::from_str(&bench.text("report.json")).unwrap();
    let moved = crate::common::rows(&bench.text("moved.csv"));
    let squares = moved.iter().zip(truth).map(|(row, x)| {
        let at = |k: usize| row[k].parse::<f64>().unwrap();
        (0..3).map(|k| (at(k) - x[k]).powi(2)).sum::<f64>()
    });
    let error = (squares.sum::<f64>() / truth.len() as f64).sqrt() / SIZE;
    (run.code, report["results"].clone(), run.stdout + &run.stderr, error)
}

#[test]
fn ends_tilted_through_a_sheet_are_doubted() {
    let bench = Bench::new();
    for (kind, thickness, noise, degrees, axis) in [
        ("plate", 0.03, 0.0, 175.0, [1.0, 0.0, 0.0]),
        ("bracket", 0.01, 1e-3, 180.0, [1.0, -1.0, 0.3]),
        ("blade", 0.03, 1e-3, 180.0, [1.0, -1.0, 0.3]),
    ] {
        let truth = put(&bench, &Scan { kind, thickness, noise, warp: 0.0, degrees, axis });
        let (code, results, said, error) = registered(&bench, &truth, "--start given");
        if error > 5e-3 + 1.2 * thickness {
            assert_eq!((code, &results["status"]), (1, &"doubtful".into()), "{kind}: {error} {said}");
            assert!(said.contains("not to be trusted"), "{kind}: {said}");
            if results["support"]["doubt"] == "elsewhere" {
                assert!(said.contains("in another position, turned by"), "{kind}: {said}");
            }
        }
        // Without a given start the right place is found, up to the thickness, which one side does not tell.
        let (code, _, said, error) = registered(&bench, &truth, "");
        assert!(code == 0 && error < 2e-3 + 1.2 * thickness, "{kind}: {code} {error} {said}");
    }
}

#[test]
fn parts_that_were_made_badly_are_found_with_a_warning() {
    let bench = Bench::new();
    for (kind, warp) in [("plate", 0.05), ("shell", 0.05)] {
        let scan = Scan { kind, thickness: 0.01, noise: 3e-4, warp, degrees: 4.0, axis: [1.0, 2.0, 3.0] };
        let truth = put(&bench, &scan);
        let (code, results, said, error) = registered(&bench, &truth, "--start given");
        assert!(code == 0 && error < 0.6 * warp, "{kind}: {code} {error} {said}");
        assert!(results["support"]["relative_rms"].as_f64().unwrap() > 0.006, "{results}");
        assert!(said.contains("by much more than its own noise"), "{kind}: {said}");
    }
}
