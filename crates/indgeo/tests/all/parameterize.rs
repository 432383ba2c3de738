//! `indgeo parameterize` as a user runs it.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::{Bench, fixture};
use std::f64::consts::TAU;

/// A vase of which a share goes around, in no order.
fn vase(share: f64) -> String {
    let line = |i: u32| {
        let (a, h) =
            (TAU * share * (f64::from(i) * 0.754_877_666).fract(), (f64::from(i) * 0.569_840_291).fract());
        let r = 3.0 + 0.6 * (4.0 * h).sin() + 0.4 * (3.0 * a).cos();
        format!("{} {} {}\n", r * a.cos(), r * a.sin(), 10.0 * h)
    };
    (0..3000).map(line).collect()
}

#[test]
fn a_vase_gets_parameters_and_a_surface() {
    let bench = Bench::new();
    bench.put("scan.xyz", vase(1.0) + "nan 0 0\n");
    let run = bench.run(
        "parameterize scan.xyz -o base.json --params uv.csv --fit fitted.json --control-points 16,12 --json report.json",
    );
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    assert!(
        run.stdout.contains("a cylinder of") && run.stderr.contains("1 of 3001 points has"),
        "{}{}",
        run.stdout,
        run.stderr
    );
    let report: serde_json::Value = serde_json::from_str(&bench.text("report.json")).unwrap();
    let results = &report["results"];
    assert_eq!((&report["command"], &results["status"]), (&"parameterize".into(), &"converged".into()));
    assert_eq!(results["defects"]["crossovers"], 0);
    let fit = &results["fit"];
    assert!(fit["rms"].as_f64().unwrap() < 0.01, "{results}");
    assert!(fit["rms"].as_f64().unwrap() <= fit["least_squares"]["rms"].as_f64().unwrap(), "{fit}");
    assert_eq!((&fit["defects"]["crossovers"], &fit["finish"]["outcome"]), (&0.into(), &"finished".into()));
    assert!(run.stdout.contains("finish    finished: rms "), "{}", run.stdout);
    assert!(
        results["times"].as_array().unwrap().len() >= 5
            && results["curve_history"].as_array().unwrap().len() >= 2
    );
    let csv = bench.text("uv.csv");
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("x,y,z,u,v,distance,used,status"));
    assert_eq!(csv.lines().count(), 3002);
    assert!(lines.next().unwrap().ends_with(",1,converged"));
    assert!(csv.lines().last().unwrap().ends_with(",,,,0,invalid_point"), "{:?}", csv.lines().last());
    // Other commands read the surfaces.
    let run = bench.run("inspect fitted.json scan.xyz --tolerance 0.1 --json -");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let base = bench.text("base.json");
    assert!(base.contains("\"periodic_u\""));
}

#[test]
fn the_finish_can_be_left_out() {
    let bench = Bench::new();
    bench.put("scan.xyz", vase(1.0));
    let run = bench.run("parameterize scan.xyz --fit fitted.json --control-points 12,9 --no-finish --json -");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let fit = &run.report()["results"]["fit"];
    assert!(fit["finish"].is_null() && fit["rms"] == fit["least_squares"]["rms"], "{fit}");
}

/// Flanks of a thread lie steeper than a right angle to each other, which is no fold.
#[test]
fn the_thread_of_a_bolt_is_fitted_without_folds() {
    let bench = Bench::new();
    let scan = fixture("scans/stud-bolt.ply");
    let run = bench.run(&format!("parameterize {scan} --fit bolt.json --control-points 20,60 --json -"));
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let fit = &run.report()["results"]["fit"];
    let [before, after] = [&fit["least_squares"]["rms"], &fit["rms"]].map(|rms| rms.as_f64().unwrap());
    assert!(after < 0.5 * before && after < 0.05 && fit["defects"]["crossovers"] == 0, "{fit}");
}

#[test]
fn a_real_scan_of_a_bolt() {
    let bench = Bench::new();
    let scan = fixture("scans/stud-bolt.ply");
    let run = bench.run(&format!("parameterize {scan} -o base.json --json -"));
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let report = run.report();
    assert_eq!(report["results"]["shape"]["shape"], "cylinder");
    assert!(report["results"]["unique"].as_f64().unwrap() > 0.99);
}

/// A thinned mesh with hardly a vertex where it is flat: points on its triangles take part, parameters are those of its vertices.
#[test]
fn a_thinned_mesh_of_a_blade_gets_a_base_surface_without_folds() {
    let bench = Bench::new();
    let scan = fixture("scans/engine-blade.ply");
    let run = bench.run(&format!(
        "parameterize {scan} -o base.json --params uv.csv --fit blade.json --no-finish --json report.json"
    ));
    // The platform is finer than the base surface: it is done, but not near everywhere, and says so.
    assert!(run.code < 2, "{}{}", run.stdout, run.stderr);
    assert!(
        run.stderr.contains("points on the wide ones are taken besides the 21795 vertices"),
        "{}",
        run.stderr
    );
    let report: serde_json::Value = serde_json::from_str(&bench.text("report.json")).unwrap();
    let results = &report["results"];
    assert_eq!(
        (&results["defects"]["self_loops"], &results["defects"]["crossovers"]),
        (&0.into(), &0.into())
    );
    assert_eq!(results["fit"]["defects"]["crossovers"], 0, "{}", results["fit"]);
    let added = results["points_added"].as_u64().unwrap();
    assert!(added > 5000 && results["points"].as_u64().unwrap() == 21795 + added, "{added}");
    assert_eq!(bench.text("uv.csv").lines().count(), 21796);
    assert_eq!(run.code == 0, results["status"] == "converged");
    assert!(run.code == 0 || run.stderr.contains("farther than they are from each other"), "{}", run.stderr);
}

#[test]
fn bad_input_says_what_and_what_to_do() {
    let bench = Bench::new();
    bench.put("half.xyz", vase(0.5));
    bench.put("scan.xyz", vase(1.0));
    bench.put("few.xyz", vase(1.0).lines().take(10).map(|l| format!("{l}\n")).collect::<String>());
    for (arguments, message) in [
        ("parameterize scan.xyz", "nothing would be written"),
        ("parameterize few.xyz -o base.json", "at least 100 are needed"),
        ("parameterize half.xyz -o base.json --shape cylinder", "not a cylinder"),
        ("parameterize scan.xyz -o base.json --shape cylinder --axis 1,0,0", "fits, around which they close"),
        ("parameterize scan.xyz -o base.json --axis 0,0,0", "not all zero"),
        ("parameterize scan.xyz -o base.json --grid 3,3", "from 4 to 2000"),
        ("parameterize scan.xyz -o base.stl", "NURBS JSON"),
        ("parameterize scan.xyz --params uv.txt", "choose .csv"),
        ("parameterize scan.xyz -o scan.xyz", "overwrite an input"),
        ("parameterize scan.xyz -o base.json --control-points 9,9", "--fit"),
    ] {
        let run = bench.run(arguments);
        assert_eq!(run.code, 2, "{arguments}: {}{}", run.stdout, run.stderr);
        assert!(run.stderr.contains(message), "{arguments}: {}", run.stderr);
    }
    assert!(!bench.files().contains(&"base.json".to_owned()));
}
