//! `indgeo register --feature-weight` as a user runs it.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::Bench;
use crate::common::sheets::{Point, cross, dot, sum, times};
use std::fmt::Write as _;

/// The faces of a channel with thin walls, normals outwards: corners in order, along `x` the steps up and down.
fn channel() -> Vec<[Point; 4]> {
    let width = 2.8;
    let (mut faces, mut x, mut before) = (Vec::new(), 0.0, 0.0f64);
    for (to, h) in [(0.08, 1.5), (2.0, 0.08), (2.08, 1.0), (2.08, 0.0)] {
        let (low, high, w) = (before.min(h), before.max(h), width);
        faces.push(if h > before {
            [[x, w, low], [x, 0.0, low], [x, 0.0, high], [x, w, high]]
        } else {
            [[x, 0.0, low], [x, w, low], [x, w, high], [x, 0.0, high]]
        });
        if to > x {
            faces.push([[x, 0.0, h], [to, 0.0, h], [to, w, h], [x, w, h]]);
            faces.push([[x, w, 0.0], [to, w, 0.0], [to, 0.0, 0.0], [x, 0.0, 0.0]]);
            faces.push([[x, 0.0, 0.0], [to, 0.0, 0.0], [to, 0.0, h], [x, 0.0, h]]);
            faces.push([[to, w, 0.0], [x, w, 0.0], [x, w, h], [to, w, h]]);
        }
        (x, before) = (to, h);
    }
    faces
}

/// Points on the faces, 25 on a unit of area, and their normals.
fn scan(faces: &[[Point; 4]]) -> Vec<(Point, Point)> {
    let mut out = Vec::new();
    for [a, b, _, d] in faces {
        let (e, f) = (sum(*b, times(*a, -1.0)), sum(*d, times(*a, -1.0)));
        let normal = cross(e, f);
        let area = dot(normal, normal).sqrt();
        for k in (0..).map(|k| f64::from(k) + 0.5).take_while(|k| *k < (25.0 * area).round()) {
            let (u, v) = ((k * 0.754_877_666_246_692_7).fract(), (k * 0.569_840_290_998_053_3).fract());
            out.push((sum(*a, sum(times(e, u), times(f, v))), times(normal, 1.0 / area)));
        }
    }
    out
}

fn bench() -> (Bench, Vec<(Point, Point)>) {
    let bench = Bench::new();
    let faces = channel();
    let mut mesh = format!("OFF\n{} {} 0\n", 4 * faces.len(), faces.len());
    for [x, y, z] in faces.iter().flatten() {
        writeln!(mesh, "{x} {y} {z}").unwrap();
    }
    for k in (0..faces.len()).map(|k| 4 * k) {
        writeln!(mesh, "4 {} {} {} {}", k, k + 1, k + 2, k + 3).unwrap();
    }
    bench.put("channel.off", mesh);
    let points = scan(&faces);
    let mut csv = "x,y,z,nx,ny,nz\n".to_owned();
    for ([x, y, z], [a, b, c]) in &points {
        writeln!(csv, "{x},{y},{z},{a},{b},{c}").unwrap();
    }
    bench.put("scan.csv", csv);
    // Turned by 60 degrees about the direction of x through (1, 1.4, 0.4), and shifted by (2, 1, 0).
    let (s, c) = 60f64.to_radians().sin_cos();
    let place = |y: f64, z: f64| [c * y - s * z, s * y + c * z];
    let [y, z] = place(1.4, 0.4);
    bench.put(
        "start.json",
        serde_json::json!([[1, 0, 0, 2], [0, c, -s, 2.4 - y], [0, s, c, 0.4 - z], [0, 0, 0, 1]]).to_string(),
    );
    (bench, points)
}

#[test]
fn positions_and_normals_lead_where_positions_alone_do_not() {
    let (bench, points) = bench();
    let command = "register channel.off scan.csv --init start.json --max-angle 90 --transform pose.json";
    let plain = bench.run(command);
    assert_eq!(plain.code, 1, "{}{}", plain.stdout, plain.stderr);
    let run = bench.run(&format!("{command} --feature-weight 1.1 --json -"));
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let report = run.report();
    let m: [[f64; 4]; 4] = serde_json::from_value(report["results"]["matrix"].clone()).unwrap();
    // The scan lies on the model as it is.
    for (x, _) in &points {
        for (row, own) in m.iter().zip(x) {
            let moved = row[0] * x[0] + row[1] * x[1] + row[2] * x[2] + row[3];
            assert!((moved - own).abs() < 1e-9, "{m:?}");
        }
    }
}

#[test]
fn what_has_no_normals_or_no_effect_is_refused() {
    let (bench, _) = bench();
    bench.put(
        "profile.json",
        r#"{"kind":"curve","dim":2,"degree":2,"knots":[0,0,0,1,1,1],"control_points":[[0,0],[1,3],[4,0]],"weights":null}"#,
    );
    bench.put("plane.csv", "x,y\n0,0\n1,1\n2,1.4\n3,1\n4,0\n");
    for (arguments, says) in [
        ("channel.off scan.csv -o m.ply --feature-weight -1", "--feature-weight"),
        ("channel.off scan.csv -o m.ply --feature-weight nan", "--feature-weight"),
        ("channel.off scan.csv -o m.ply --feature-weight 1 --lock rx", "--lock"),
        ("profile.json plane.csv -o m.csv --feature-weight 1", "this model has none"),
    ] {
        let run = bench.run(&format!("register {arguments}"));
        assert!(run.code == 2 && run.stderr.contains(says), "{arguments}: {} {}", run.code, run.stderr);
    }
    assert!(!bench.files().iter().any(|name| name.starts_with("m.")));
}
