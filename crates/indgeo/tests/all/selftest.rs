//! `indgeo selftest` as a user runs it.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::Bench;

#[test]
fn every_case_is_within_its_bound() {
    let bench = Bench::new();
    let run = bench.run("selftest --json report.json --threads 2");
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{}", run.stdout);
    assert!(run.stdout.contains("certified answer") && run.stdout.contains("all "), "{}", run.stdout);
    let report: serde_json::Value = serde_json::from_str(&bench.text("report.json")).unwrap();
    assert_eq!((&report["command"], &report["status"]), (&"selftest".into(), &"done".into()));
    let checks = report["results"].as_array().unwrap();
    assert!(checks.len() > 30, "{}", checks.len());
    for check in checks {
        let [deviation, bound] = ["deviation", "bound"].map(|name| check[name].as_f64().unwrap());
        assert!(deviation <= bound && check["pass"] == true, "{check}");
        assert!(run.stdout.contains(check["case"].as_str().unwrap()));
    }
    assert_eq!(bench.files(), ["report.json"]);
}
