//! `indgeo demo`: real data, real results.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::{Bench, fixture, rows};

#[test]
fn shows_the_thread() {
    let bench = Bench::new();
    let run = bench.run("demo --json report.json");
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{}", run.stdout);
    for name in ["deviations.csv", "deviations.ply", "deviations.svg"] {
        assert!(run.stdout.contains(name) && bench.path("indgeo-demo").join(name).is_file(), "{name}");
    }
    let report: serde_json::Value = serde_json::from_str(&bench.text("report.json")).unwrap();
    assert_eq!((&report["command"], &report["status"]), (&"demo".into(), &"done".into()));
    assert_eq!(report["inputs"][1]["points_read"], 8565);
    assert_eq!(report["results"]["points"], 8565);
    // What the scan shows of the bolt: all of the thread within a few tenths of its nominal surface.
    let text = bench.text("indgeo-demo/deviations.csv");
    let inside: Vec<f64> = rows(&text)
        .iter()
        .filter(|row| row[7] == "0" && row[10] == "converged")
        .map(|row| row[6].parse().unwrap())
        .collect();
    assert!(inside.len() > 4500, "{}", inside.len());
    assert!(inside.iter().all(|distance| distance.abs() < 0.5));
    let rms = (inside.iter().map(|d| d * d).sum::<f64>() / inside.len() as f64).sqrt();
    assert!((0.02..0.12).contains(&rms), "{rms}");
}

#[test]
fn the_picture_is_whole_and_explains_itself() {
    let bench = Bench::new();
    assert_eq!(bench.run("demo --out here --quiet").code, 0);
    let svg = bench.text("here/deviations.svg");
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
    for words in ["M12", "Signed distance, mm", "position along the axis, mm", "std dev", "black: nominal"] {
        assert!(svg.contains(words), "{words}");
    }
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    assert!(svg.len() < 800_000, "{}", svg.len());
}

#[test]
fn says_where_it_looked_for_data() {
    let bench = Bench::new();
    let run = bench.run("demo --data nowhere");
    assert_eq!((run.code, bench.files().len()), (2, 0));
    assert!(run.stderr.contains("are not in nowhere; run this in a checkout"), "{}", run.stderr);
    assert_eq!(bench.run(&format!("demo --quiet --data {}", fixture(""))).code, 0);
}
