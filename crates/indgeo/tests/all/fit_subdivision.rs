//! `indgeo fit-subdivision` as a user runs it.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::{Bench, CUBE, fixture};
use serde_json::Value;

#[test]
fn a_body_from_a_coarsened_mesh() {
    let bench = Bench::new();
    let bunny = fixture("mesh/bunny.obj");
    let run = bench.run(&format!(
        "fit-subdivision {bunny} -o control.obj --vertices 200 --limit limit.ply --levels 1 --max-iterations 8 --json report.json"
    ));
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let report: Value = serde_json::from_str(&bench.text("report.json")).unwrap();
    let results = &report["results"];
    assert_eq!((&results["start"], report["outputs"].as_array().unwrap().len()), (&"coarsened".into(), 2));
    let vertices = results["vertices"].as_u64().unwrap();
    assert!((200..260).contains(&vertices), "{results}");
    let fit = &results;
    let [before, after] = ["initial_rms", "rms"].map(|key| fit[key].as_f64().unwrap());
    assert!(after < 0.3 * before, "{before} {after}");
    // The limit surface is as near to the mesh as the report says, but for its triangles.
    let run = bench.run(&format!("project limit.ply {bunny} -o feet.csv --json -"));
    assert_eq!(run.code, 0, "{}", run.stderr);
    let rms = run.report()["results"]["distance"]["rms"].as_f64().unwrap();
    assert!(rms < 2.0 * after, "{rms} {after}");
    // Control meshes are starts; tolerances that do not hold are said.
    let run = bench.run(&format!(
        "fit-subdivision {bunny} --init control.obj --max-iterations 2 --tolerance 1e-9 --term tangent --json -"
    ));
    assert_eq!(run.code, 1, "{}{}", run.stdout, run.stderr);
    let again = run.report();
    assert_eq!((&again["status"], &again["results"]["start"]), (&"out_of_tolerance".into(), &"given".into()));
    assert!(again["results"]["initial_rms"].as_f64().unwrap() < 1.5 * after, "{}", again["results"]);
}

#[test]
fn a_cloud_needs_a_control_mesh() {
    let bench = Bench::new();
    let ball = |k: i32| {
        let (a, z) = (f64::from(k) * 2.399_963, f64::from(2 * k + 1) / 400.0 - 1.0);
        let r = (1.0 - z * z).sqrt();
        format!("{} {} {z}\n", r * a.cos(), r * a.sin())
    };
    bench.put("ball.xyz", (0..400).map(ball).collect::<String>());
    bench.put(
        "octahedron.off",
        "OFF\n6 8 0\n1 0 0\n0 1 0\n-1 0 0\n0 -1 0\n0 0 1\n0 0 -1\n3 0 1 4\n3 1 2 4\n3 2 3 4\n\
                                 3 3 0 4\n3 1 0 5\n3 2 1 5\n3 3 2 5\n3 0 3 5\n",
    );
    let run = bench.run("fit-subdivision ball.xyz --init octahedron.off -o control.off --tolerance 0.05");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    assert!(
        run.stdout.contains("reached") && run.stdout.contains("6 vertices (6 irregular)"),
        "{}",
        run.stdout
    );
    assert!(bench.text("control.off").starts_with("OFF"));
}

#[test]
fn bad_input_and_usage() {
    let bench = Bench::new();
    bench.put("cube.off", CUBE);
    bench.put("points.xyz", "0 0 0\n1 0 0\n0 1 0\n0 0 1\n");
    bench.put("fan.off", "OFF\n5 3 0\n0 0 0\n1 0 0\n0 1 0\n0 -1 0\n0 0 1\n3 0 1 2\n3 0 1 3\n3 0 1 4\n");
    bench.put("nan.off", "OFF\n3 1 0\nnan 0 0\nnan 0 0\nnan 1 0\n3 0 1 2\n");
    for (command, message) in [
        ("fit-subdivision cube.off", "nothing would be written"),
        ("fit-subdivision points.xyz -o out.obj", "--init"),
        ("fit-subdivision fan.off -o out.obj", "manifold"),
        ("fit-subdivision nan.off -o out.obj", "nan.off"),
        ("fit-subdivision cube.off -o out.obj --vertices 3", "from 4"),
        ("fit-subdivision cube.off -o out.obj --tolerance 0", "positive length"),
        ("fit-subdivision cube.off -o cube.off", "overwrite"),
        ("fit-subdivision cube.off -o out.obj --limit out.obj", "two results"),
        ("fit-subdivision cube.off -o out.obj --init points.xyz", "no triangles"),
        ("fit-subdivision cube.off -o out.xyz --levels 2", "--limit"),
        ("fit-subdivision missing.ply -o out.obj", "missing.ply"),
    ] {
        let run = bench.run(command);
        assert_eq!(run.code, 2, "{command}: {}{}", run.stdout, run.stderr);
        assert!(run.stderr.contains(message), "{command}: {}", run.stderr);
    }
}
