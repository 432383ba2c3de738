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

/// A sheet of `2 n` by `n` cells that is bent by a right angle along its middle, as OBJ.
fn bent(n: u32) -> String {
    let place = |i: u32| f64::from(i) / f64::from(n);
    let mut text = String::new();
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

#[test]
fn a_patch_gets_parameters_in_both_metrics() {
    let bench = Bench::new();
    bench.put("bent.obj", bent(4) + "v 9 9 9\n");
    let run = bench.run("parameterize bent.obj --metric euclidean --params plain.csv --json plain.json");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("1 vertex without a row"), "{}", run.stderr);
    let rows = |name: &str| -> Vec<Vec<f64>> {
        let text = bench.text(name);
        assert!(text.starts_with("vertex,x,y,z,u,v\n"));
        text.lines().skip(1).map(|line| line.split(',').map(|n| n.parse().unwrap()).collect()).collect()
    };
    let plain = rows("plain.csv");
    assert_eq!(plain.len(), 45);
    for row in &plain {
        // Unrolled it is a rectangle.
        assert!(
            (row[4] - 0.5 * (row[1] + row[3])).abs() < 1e-12 && (row[5] - row[2]).abs() < 1e-12,
            "{row:?}"
        );
    }
    let options = "--metric feature --w 0.5 --params bent.csv --picture bent.svg --json bent.json";
    let run = bench.run(&format!("parameterize bent.obj {options}"));
    assert_eq!(run.code, 0, "{}", run.stderr);
    let bent = rows("bent.csv");
    // The five vertices of the edge have a place on either side.
    assert_eq!(bent.len(), 50);
    let on_edge: Vec<f64> =
        bent.iter().filter(|row| row[1] == 1.0 && row[3] == 0.0).map(|row| row[4]).collect();
    assert!(on_edge.len() == 10 && on_edge.iter().all(|u| (u - 0.5).abs() > 0.1), "{on_edge:?}");
    assert!(bench.text("bent.svg").contains("data:image/png;base64,"));
    let schema = crate::common::schema::of("parameterize");
    for name in ["plain.json", "bent.json"] {
        let report: serde_json::Value = serde_json::from_str(&bench.text(name)).unwrap();
        assert_eq!(crate::common::schema::violations(&schema, &report), Vec::<String>::new());
        assert_eq!((&report["results"]["folded"], &report["results"]["unused"]), (&0.into(), &1.into()));
    }
    let run = bench.run("parameterize bent.obj --metric feature --w 0.5 --domain disc --params disc.ply");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(bench.read("disc.ply").starts_with(b"ply"));
}

#[test]
fn patches_that_cannot_be_laid_out_are_refused() {
    let bench = Bench::new();
    bench.put("bent.obj", bent(3));
    bench.put("tetra.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    bench.put("points.xyz", "0 0 0\n1 0 0\n0 1 0\n");
    for (arguments, what) in [
        ("tetra.obj --metric euclidean", "0 boundary curve(s)"),
        ("points.xyz --metric euclidean", "points without triangles"),
        ("bent.obj --metric feature", "--w LENGTH"),
        ("bent.obj --metric feature --w -1", "w is -1"),
        ("bent.obj --metric euclidean --corners 0,1,2,5", "vertex 5"),
        ("bent.obj --metric euclidean --corners 0,1,2", "four vertices"),
        ("bent.obj --metric euclidean --shape plane", "cannot be used with"),
        ("bent.obj --metric euclidean --domain disc --corners 0,1,2,3", "no corners"),
        ("bent.obj --w 2", "--metric"),
    ] {
        let run = bench.run(&format!("parameterize {arguments} --params uv.csv"));
        assert!(run.code == 2 && run.stderr.contains(what), "{arguments}: {} {}", run.code, run.stderr);
        assert!(!bench.path("uv.csv").exists(), "{arguments}");
    }
}
