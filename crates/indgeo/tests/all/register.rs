//! `indgeo register` as a user runs it.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::{Bench, SQUARE, fixture};
use serde_json::Value;

fn json(bench: &Bench, name: &str) -> Value {
    serde_json::from_str(&bench.text(name)).unwrap()
}

/// Largest difference of two matrices.
fn difference(a: &Value, b: &Value) -> f64 {
    let entry = |m: &Value, i: usize, j: usize| m[i][j].as_f64().unwrap();
    (0..16).map(|k| (entry(a, k / 4, k % 4) - entry(b, k / 4, k % 4)).abs()).fold(0.0, f64::max)
}

#[test]
fn a_displaced_cloud_comes_back() {
    let bench = Bench::new();
    let (model, case) = (fixture("register-cases/cad.json"), fixture("register-cases/cad_zero"));
    let run = bench.run(&format!(
        "register {model} {case}/source.ply -o moved.ply --transform pose.json --start global --json report.json"
    ));
    assert_eq!(run.code, 0, "{}", run.stderr);
    let pose = json(&bench, "pose.json");
    let truth: Value =
        serde_json::from_str(&std::fs::read_to_string(format!("{case}/case.json")).unwrap()).unwrap();
    assert!(difference(&pose["matrix"], &truth["T_gt"]) < 1e-12, "{pose}");
    assert_eq!(pose["status"], "converged");
    assert!(pose["rms"].as_f64().unwrap() < 1e-12 && pose["covariance"]["rows"].is_array());
    let report = json(&bench, "report.json");
    assert_eq!((&report["command"], &report["status"]), (&"register".into(), &"done".into()));
    assert_eq!(report["results"]["matrix"], pose["matrix"]);

    // The moved points lie on the model: both ways to move them agree.
    let run = bench.run(&format!("inspect {model} moved.ply --tolerance 1e-9"));
    assert_eq!(run.code, 0, "{}", run.stdout);
    let run = bench.run(&format!("inspect {model} {case}/source.ply --tolerance 1e-9 --transform pose.json"));
    assert_eq!(run.code, 0, "{}", run.stdout);
}

#[test]
fn every_start_of_a_list_is_reported() {
    let bench = Bench::new();
    let (model, case) = (fixture("register-cases/cad.json"), fixture("register-cases/cad_zero"));
    let truth: Value =
        serde_json::from_str(&std::fs::read_to_string(format!("{case}/case.json")).unwrap()).unwrap();
    bench.put("starts.json", serde_json::json!([truth["T_gt"], { "matrix": truth["T_gt"] }]).to_string());
    let run = bench.run(&format!("register {model} {case}/source.ply --init starts.json --json -"));
    assert_eq!(run.code, 0, "{}", run.stderr);
    let report: Value = serde_json::from_str(&run.stdout).unwrap();
    let starts = report["results"]["starts"].as_array().unwrap();
    assert_eq!(starts.len(), 2);
    for start in starts {
        assert_eq!((&start["origin"], &start["status"]), (&"init".into(), &"converged".into()));
        assert!(start["seconds"].as_f64().unwrap() >= 0.0 && start["iterations"].as_u64().unwrap() < 5);
    }
}

#[test]
fn motions_that_the_model_does_not_fix_are_named() {
    let bench = Bench::new();
    bench.put("model.json", SQUARE);
    let points: String = (0..25)
        .map(|k| format!("{} {} 0.25\n", 0.5 + 0.2 * f64::from(k % 5), 0.5 + 0.2 * f64::from(k / 5)))
        .collect();
    bench.put("points.xyz", &points);
    let run = bench.run("register model.json points.xyz --transform pose.json --start given");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let pose = json(&bench, "pose.json");
    assert_eq!(pose["free_motions"].as_array().unwrap().len(), 3, "{pose}");
    assert!((pose["translation"][2].as_f64().unwrap() + 0.25).abs() < 1e-12);
    assert!(pose["translation"][0].as_f64().unwrap().abs() < 1e-9);
    assert!(run.stdout.contains("not fixed"), "{}", run.stdout);
}

#[test]
fn bad_input_says_what_and_what_to_do() {
    let bench = Bench::new();
    bench.put("model.json", SQUARE);
    bench.put("two.xyz", "0 0 0\n1 0 0\n");
    bench.put("points.xyz", "0 0 1\n1 0 1\n0 1 1\n1 1 1\n");
    bench.put("start.json", "[[1, 2], [3, 4]]");
    for (arguments, message) in [
        ("register model.json points.xyz", "nothing would be written"),
        ("register model.json two.xyz -o moved.ply", "2 of 2 points can be used"),
        ("register model.json points.xyz -o points.xyz", "overwrite an input"),
        ("register model.json points.xyz -o moved.ply --init start.json", "start.json: entry 0"),
        ("register model.json points.xyz -o moved.ply --overlap 0.5", "--outliers trimmed"),
        ("register model.json points.xyz -o moved.ply --method symmetric", "no normals"),
    ] {
        let run = bench.run(arguments);
        assert_eq!(run.code, 2, "{arguments}: {}", run.stdout);
        assert!(run.stderr.contains(message), "{arguments}: {}", run.stderr);
    }
    assert!(!bench.files().contains(&"moved.ply".to_owned()));
}

#[test]
fn points_of_the_plane_find_their_curve() {
    let bench = Bench::new();
    bench.put(
        "profile.json",
        r#"{"kind":"curve","dim":2,"degree":2,"knots":[0,0,0,1,1,1],"control_points":[[0,0],[1,3],[4,0]],"weights":null}"#,
    );
    let (sine, cosine) = 0.1f64.sin_cos();
    let place = |t: f64| [2.0 * t * (1.0 - t) + 4.0 * t * t, 6.0 * t * (1.0 - t)];
    let mut text = String::from("x,y,label\n");
    for i in 0..60 {
        let [x, y] = place(0.02 + 0.016 * f64::from(i));
        // The inverse of a turn by 0.1 and a shift by (0.2, -0.1).
        let (a, b) = (x - 0.2, y + 0.1);
        text += &format!("{},{},{i}\n", cosine * a + sine * b, cosine * b - sine * a);
    }
    bench.put("points.csv", text);
    let run =
        bench.run("register profile.json points.csv -o moved.csv --transform pose.json --json report.json");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let pose = json(&bench, "pose.json");
    let truth =
        serde_json::json!([[cosine, -sine, 0, 0.2], [sine, cosine, 0, -0.1], [0, 0, 1, 0], [0, 0, 0, 1]]);
    assert!(difference(&pose["matrix"], &truth) < 1e-12, "{pose}");
    assert_eq!(pose["covariance"]["rows"].as_array().unwrap().len(), 3);
    assert_eq!(json(&bench, "report.json")["model"]["dimension"], 2);
    // Two columns and the label are kept, and the moved points lie on the curve.
    assert!(bench.text("moved.csv").starts_with("x,y,label\n"), "{}", bench.text("moved.csv"));
    for arguments in ["moved.csv", "points.csv --transform pose.json"] {
        let run = bench.run(&format!("inspect profile.json {arguments} -t 1e-9"));
        assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    }
    let run = bench.run("register profile.json points.csv -o moved.csv --lock tz");
    assert!(run.code == 2 && run.stderr.contains("no effect in the plane"), "{}", run.stderr);
    let run = bench.run("register profile.json points.csv --transform pose.json --start global");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(difference(&json(&bench, "pose.json")["matrix"], &truth) < 1e-12);
}

/// Points of a closed curve without symmetries, from an angle on, moved by a rotation about the origin and a shift; two columns.
fn bean(count: u32, first: f64, turn: f64, shift: [f64; 2]) -> String {
    let at = |i: u32| first + std::f64::consts::TAU * f64::from(i) / f64::from(count);
    let point = |angle: f64| {
        let radius = 10.0 + 3.0 * angle.cos() + 1.5 * (2.0 * angle + 0.4).sin() + 0.7 * (3.0 * angle).cos();
        let (x, y) = (radius * angle.cos(), radius * angle.sin());
        let (sine, cosine) = turn.sin_cos();
        format!("{} {}\n", cosine * x - sine * y + shift[0], sine * x + cosine * y + shift[1])
    };
    (0..count).map(|i| point(at(i))).collect()
}

#[test]
fn clouds_of_two_columns_are_registered_to_each_other() {
    let bench = Bench::new();
    bench.put("model.xyz", bean(900, 0.0, 0.0, [0.0, 0.0]));
    for turn in [0.05f64, 1.9, 3.1, -2.2] {
        bench.put("scan.xyz", bean(700, 0.002, turn, [40.0, -7.0]));
        let run =
            bench.run("register model.xyz scan.xyz -o moved.xyz --transform pose.json --json report.json");
        assert_eq!(run.code, 0, "{turn}: {}", run.stderr);
        let (pose, report) = (json(&bench, "pose.json"), json(&bench, "report.json"));
        let entry = |i: usize, j: usize| pose["matrix"][i][j].as_f64().unwrap();
        let (sine, cosine) = turn.sin_cos();
        let shift = [-(cosine * 40.0 - sine * 7.0), sine * 40.0 + cosine * 7.0];
        for ([i, j], right) in
            [([0, 0], cosine), ([1, 0], -sine), ([0, 3], shift[0]), ([1, 3], shift[1]), ([2, 2], 1.0)]
        {
            assert!((entry(i, j) - right).abs() < 1e-4 * right.abs().max(1.0), "{turn}: {pose}");
        }
        assert_eq!((&report["model"]["kind"], &report["model"]["dimension"]), (&"cloud".into(), &2.into()));
        assert!(bench.text("moved.xyz").lines().all(|line| line.split(' ').count() == 2));
    }
}

#[test]
fn a_circle_in_the_plane_leaves_its_turn_free() {
    let bench = Bench::new();
    let circle = |count: u32, shift: f64| -> String {
        let at = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(count);
        (0..count).map(|i| format!("{} {}\n", at(i).cos() + shift, at(i).sin() - shift)).collect()
    };
    bench.put("model.xyz", circle(500, 0.0));
    bench.put("scan.xyz", circle(300, 0.3));
    let run = bench.run("register model.xyz scan.xyz --transform pose.json");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let free = &json(&bench, "pose.json")["free_motions"];
    assert!(
        free.as_array().is_some_and(|free| free.len() == 1 && free[0].as_str().unwrap().contains("rotation")),
        "{free}"
    );
    // Points of three columns do not lie in the plane.
    bench.put("space.xyz", "0 0 1\n1 0 1\n0 1 1\n1 1 2\n");
    let run = bench.run("register model.xyz space.xyz --transform pose.json");
    assert!(run.code == 2 && run.stderr.contains("has z = 1"), "{}", run.stderr);
}

#[test]
fn the_moved_points_can_be_judged_at_once() {
    let bench = Bench::new();
    let (model, case) = (fixture("register-cases/cad.json"), fixture("register-cases/cad_noise1e-3"));
    let command = format!("register {model} {case}/source.ply --start global --inspect --json report.json");
    let run = bench.run(&format!("{command} -t 0.5 --report page.html --transform pose.json"));
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let report = json(&bench, "report.json");
    let judged = &report["results"]["inspection"];
    assert!(judged["within_tolerance"] == true && report["results"]["status"] == "converged", "{judged}");
    assert!(bench.text("page.html").contains("<html"));
    // The same as two commands one after the other.
    let run = bench
        .run(&format!("inspect {model} {case}/source.ply --transform pose.json -t 0.5 --json alone.json"));
    assert_eq!(run.code, 0, "{}", run.stderr);
    let alone = &json(&bench, "alone.json")["results"];
    let number = |value: &Value, name: &str| value[name].as_f64().unwrap();
    for name in ["rms", "max", "share_within"] {
        assert!((number(judged, name) - number(alone, name)).abs() <= 1e-12 * number(alone, name), "{name}");
    }
    // A tolerance that does not hold is no success, though the pose is right.
    let run = bench.run(&format!("{command} -t {}", 0.5 * number(alone, "max")));
    assert_eq!(run.code, 1, "{}", run.stderr);
    let report = json(&bench, "report.json");
    assert!(report["status"] == "out_of_tolerance" && report["results"]["status"] == "converged", "{report}");
    for (arguments, message) in [("--inspect", "--tolerance"), ("-t 0.1", "--inspect")] {
        let run = bench.run(&format!("register {model} {case}/source.ply -o a.ply {arguments}"));
        assert!(run.code == 2 && run.stderr.contains(message), "{arguments}: {}", run.stderr);
    }
}

#[test]
fn the_page_shows_before_and_after_and_what_the_pose_is_worth() {
    let bench = Bench::new();
    let (model, case) = (fixture("register-cases/cad.json"), fixture("register-cases/cad_noise1e-3"));
    let command =
        format!("register {model} {case}/source.ply --start global --report page.html --json report.json");
    let run = bench.run(&command);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let page = bench.text("page.html");
    assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>\n"));
    // Three views before and three after, eight corners in each of the latter, and nothing that is no number.
    assert_eq!((page.matches("<svg ").count(), page.matches("<ellipse ").count()), (6, 24));
    assert!(!page.contains("NaN") && !page.contains("inf") && page.contains("CONVERGED"));
    let start = page.find("<script type=\"application/json\" id=\"report\">").unwrap();
    let json_text = page[start..].split_once('>').unwrap().1.split_once("</script>").unwrap().0;
    let embedded: Value = serde_json::from_str(json_text).unwrap();
    let report = json(&bench, "report.json");
    assert_eq!(embedded["matrix"], report["results"]["matrix"]);
    // The whole surface was scanned, from one side.
    let coverage = &report["results"]["coverage"];
    assert!(coverage["covered"].as_f64().unwrap() > 0.95, "{coverage}");
    assert_eq!(report["results"]["free_space"], Value::Array(Vec::new()));
}
