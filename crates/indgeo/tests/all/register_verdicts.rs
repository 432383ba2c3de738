//! What `indgeo register` calls the end of a registration, on data that does not belong together, and on data that does.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::inputs::{cube_points, lines};
use crate::common::{Bench, SQUARE};
use serde_json::Value;
use std::fmt::Write as _;

/// A patch of degree 2 over [0, 2] × [0, 1] with a bump and a twist: the net, and a point of it.
const NET: [[[f64; 3]; 3]; 3] = [
    [[0.0, 0.0, 0.0], [0.0, 0.5, 0.5], [0.0, 1.0, -0.2]],
    [[1.0, 0.0, 0.6], [1.0, 0.5, -0.5], [1.0, 1.0, 0.3]],
    [[2.0, 0.0, -0.3], [2.0, 0.5, 0.7], [2.0, 1.0, 0.4]],
];

fn patch() -> String {
    let knots = "[0,0,0,1,1,1]";
    format!(
        r#"{{"kind":"surface","degree_u":2,"degree_v":2,"knots_u":{knots},"knots_v":{knots},"control_points":{NET:?},"weights":null}}"#
    )
}

fn on_patch(u: f64, v: f64) -> [f64; 3] {
    let basis = |t: f64| [(1.0 - t) * (1.0 - t), 2.0 * t * (1.0 - t), t * t];
    let (b, c) = (basis(u), basis(v));
    [0, 1, 2].map(|k| (0..9).map(|i| b[i / 3] * c[i % 3] * NET[i / 3][i % 3][k]).sum())
}

/// Numbers in [0, 1) that look random, always the same.
fn unit(k: usize) -> f64 {
    (k as f64 * 0.618_033_988_749_895 + (k as f64 * k as f64 * 1e-3).sin().abs()).fract()
}

/// A turn about z by an angle in degrees, after growth about the origin, then a shift.
fn turned([x, y, z]: [f64; 3], degrees: f64, scale: f64, shift: [f64; 3]) -> [f64; 3] {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let moved = [cosine * x - sine * y, sine * x + cosine * y, z];
    [0, 1, 2].map(|k| scale * moved[k] + shift[k])
}

fn registered(bench: &Bench, arguments: &str) -> (i32, Value, String) {
    let run = bench.run(&format!("register {arguments} --json report.json --transform pose.json"));
    let report = std::fs::read_to_string(bench.path("report.json")).unwrap_or_default();
    let report: Value = serde_json::from_str(&report).unwrap_or(Value::Null);
    (run.code, report["results"].clone(), run.stdout + &run.stderr)
}

#[test]
fn points_that_have_nothing_to_do_with_the_model_are_no_result() {
    let bench = Bench::new();
    bench.put("patch.json", patch());
    bench.put("plane.json", SQUARE);
    let random = (0..1000).map(|k| [2.2 * unit(3 * k) - 0.1, unit(3 * k + 1), unit(3 * k + 2) - 0.3]);
    bench.put("random.xyz", lines(random));
    let sphere = |radius: f64| {
        (0..200).map(move |k| {
            let (z, a) = (2.0 * unit(2 * k) - 1.0, std::f64::consts::TAU * unit(2 * k + 1));
            let r = (1.0 - z * z).sqrt();
            [r * a.cos(), r * a.sin(), z].map(|c| c * radius)
        })
    };
    bench.put("sphere.xyz", lines(sphere(1.0)));
    bench.put("large.xyz", lines(sphere(10.0)));
    for arguments in [
        "patch.json random.xyz",
        "patch.json sphere.xyz",
        "patch.json large.xyz",
        "plane.json large.xyz",
        "patch.json random.xyz --scale",
        "plane.json large.xyz --scale",
        "patch.json random.xyz --outliers none",
    ] {
        let (code, results, said) = registered(&bench, arguments);
        assert_eq!(code, 1, "{arguments}: {said}");
        assert!(results["support"]["share"].is_number(), "{arguments}: {results}");
        if results["support"]["doubt"].is_string() {
            assert!(said.contains("not to be trusted") && said.contains("% of the points count"), "{said}");
        }
    }
}

#[test]
fn scales_from_a_thousandth_to_a_thousand_come_back() {
    let bench = Bench::new();
    bench.put("patch.json", patch());
    for (scale, part) in
        [(1.5, 1.0), (2.0, 0.7), (3.0, 1.0), (25.4, 1.0), (1e3, 0.7), (1e-3, 1.0), (0.04, 0.7), (1.0, 1.0)]
    {
        let points =
            (0..800).map(|k| on_patch(0.02 + 0.96 * part * unit(2 * k), 0.02 + 0.96 * unit(2 * k + 1)));
        bench.put(
            "scan.xyz",
            lines(points.map(|x| turned(x, 15.0, scale, [0.02 * scale, 0.05 * scale, 0.0]))),
        );
        let (code, results, said) = registered(&bench, "patch.json scan.xyz --scale");
        assert_eq!(code, 0, "{scale} {part}: {said}");
        let found = results["scale"].as_f64().unwrap();
        assert!((found * scale - 1.0).abs() < 1e-10, "{scale} {part}: {found}");
    }
}

#[test]
fn a_scan_in_another_unit_is_found_from_any_rotation() {
    let bench = Bench::new();
    bench.put("patch.json", patch());
    for (scale, degrees) in [(25.4, 140.0), (0.001, 200.0)] {
        let points = (0..800).map(|k| on_patch(0.02 + 0.96 * unit(2 * k), 0.02 + 0.96 * unit(2 * k + 1)));
        let shift = [7.0 * scale, -3.0 * scale, scale];
        bench.put("scan.xyz", lines(points.map(|x| turned(x, degrees, scale, shift))));
        let (code, results, said) = registered(&bench, "patch.json scan.xyz --scale");
        assert_eq!(code, 0, "{scale}: {said}");
        let found = results["scale"].as_f64().unwrap();
        assert!((found * scale - 1.0).abs() < 1e-9, "{scale}: {found}");
    }
}

/// An L-shaped room seen from above.
fn room(count: usize, noise: f64, seed: usize) -> Vec<[f64; 3]> {
    let corners = [[0.0, 0.0], [6.0, 0.0], [6.0, 3.0], [4.0, 3.0], [4.0, 5.0], [0.0, 5.0], [0.0, 0.0]];
    (0..count)
        .map(|k| {
            let wall = (k + seed) % 6;
            let t = unit(7 * k + seed);
            let at = |axis: usize| corners[wall][axis] + t * (corners[wall + 1][axis] - corners[wall][axis]);
            let off = |i: usize| noise * (unit(11 * k + seed + i) - 0.5);
            [at(0) + off(1), at(1) + off(2), 0.0]
        })
        .collect()
}

#[test]
fn flat_clouds_are_underdetermined() {
    let bench = Bench::new();
    let tilt = |[x, y, z]: [f64; 3]| [0.8 * x - 0.6 * z + 3.0, y, 0.6 * x + 0.8 * z - 1.0];
    for (count, noise, is_tilted) in [(250, 0.0, false), (400, 0.003, false), (400, 0.003, true)] {
        let place = |x: [f64; 3]| if is_tilted { tilt(x) } else { x };
        bench.put("a.xyz", lines(room(count, noise, 1).into_iter().map(place)));
        let b = room(count, noise, 5).into_iter().map(|x| turned(x, -12.0, 1.0, [-0.4, 0.3, 0.0]));
        bench.put("b.xyz", lines(b.map(place)));
        for options in ["", " --start given", " --method point", " --outliers none"] {
            let (code, results, said) = registered(&bench, &format!("a.xyz b.xyz{options}"));
            assert_eq!((code, &results["status"]), (1, &"underdetermined".into()), "{options}: {said}");
            assert!(said.contains("lie in a plane each"), "{said}");
        }
    }
}

#[test]
fn a_tilt_that_is_locked_is_said() {
    let bench = Bench::new();
    bench.put("patch.json", patch());
    let on: Vec<_> = (0..800).map(|k| on_patch(unit(2 * k), unit(2 * k + 1))).collect();
    bench.put("scan.xyz", lines(on.iter().map(|x| turned(*x, 8.0, 1.0, [0.0, 0.0, 0.1]))));
    let (code, results, said) = registered(&bench, "patch.json scan.xyz --lock rx,ry,rz");
    assert_eq!((code, &results["status"]), (1, &"doubtful".into()), "{said}");
    assert_eq!(results["support"]["doubt"], "locks");
    assert!(said.contains("lock less"), "{said}");
    bench.put("scan.xyz", lines(on.iter().map(|x| turned(*x, 4.0, 1.0, [0.0, 0.0, 0.1]))));
    let (code, _, said) = registered(&bench, "patch.json scan.xyz --lock rx,ry,rz");
    assert!(code == 0 && said.contains("by much more than its noise"), "{code} {said}");
    // A shift alone can be made.
    bench.put("scan.xyz", lines(on.iter().map(|x| turned(*x, 0.0, 1.0, [0.02, -0.01, 0.1]))));
    let (code, _, said) = registered(&bench, "patch.json scan.xyz --lock rx,ry,rz");
    assert_eq!(code, 0, "{said}");
}

#[test]
fn poses_that_a_cube_does_not_tell_apart_are_listed_and_the_nearest_is_taken() {
    let bench = crate::common::inputs::bench();
    let (sine, cosine) = 0.3f64.sin_cos();
    let about = |[x, y, z]: [f64; 3]| {
        let (x, y) = (x - 0.5, y - 0.5);
        [cosine * x - sine * y + 0.6, sine * x + cosine * y + 0.4, z + 0.05]
    };
    bench.put("scan.xyz", lines(cube_points().map(about)));
    for start in ["given", "auto", "global"] {
        let (code, results, said) = registered(&bench, &format!("cube.off scan.xyz --start {start}"));
        assert_eq!(code, 0, "{start}: {said}");
        let poses = results["equivalent_poses"].as_array().unwrap();
        assert_eq!(poses.len(), 24, "{start}");
        assert_eq!(poses[0], results["matrix"], "{start}");
        // Turned back by 0.3, not by that and quarters of a turn.
        assert!((results["rotation"]["angle"].as_f64().unwrap() - 0.3).abs() < 1e-3, "{start}: {results}");
        assert!(said.contains("24 positions"), "{said}");
    }
}

#[test]
fn a_model_of_one_point_is_named_at_once() {
    let bench = Bench::new();
    let mut text = String::new();
    for _ in 0..60_000 {
        writeln!(text, "1 2 3").unwrap();
    }
    bench.put("same.xyz", &text);
    bench.put("points.xyz", lines(cube_points()));
    let began = std::time::Instant::now();
    let (code, _, said) = registered(&bench, "same.xyz points.xyz");
    assert!(code == 2 && said.contains("same.xyz") && said.contains("are the same"), "{code} {said}");
    assert!(began.elapsed().as_secs() < 20);
    // One point apart from all others.
    bench.put("same.xyz", text + "1 2 4\n");
    let (code, _, said) = registered(&bench, "same.xyz points.xyz");
    assert!(code == 1 || code == 2, "{code} {said}");
    assert!(began.elapsed().as_secs() < 60);
}

#[test]
fn a_plate_that_lies_the_wrong_way_round_is_turned() {
    let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 1.2], [3.2, 2.0], [0.0, 2.0]];
    let mut mesh = "OFF\n10 16 0\n".to_owned();
    for z in [0.0, 0.3] {
        for [x, y] in corners {
            writeln!(mesh, "{x} {y} {z}").unwrap();
        }
    }
    for i in 1..4 {
        writeln!(mesh, "3 0 {} {}\n3 5 {} {}", i + 1, i, i + 5, i + 6).unwrap();
    }
    for i in 0..5 {
        let next = (i + 1) % 5;
        writeln!(mesh, "3 {i} {next} {}\n3 {i} {} {}", next + 5, next + 5, i + 5).unwrap();
    }
    let bench = Bench::new();
    bench.put("plate.off", mesh);
    let on_plate = |low: f64| {
        (0..6000)
            .map(move |k| {
                let (x, y) = (low + (4.0 - low) * unit(3 * k), 2.0 * unit(3 * k + 1));
                [x, y, if k % 2 == 0 { 0.0 } else { 0.3 }]
            })
            .filter(|[x, y, _]| x + y < 5.2)
            .chain((0..1500).map(move |k| {
                let y = if k % 2 == 0 { 0.0 } else { 2.0 };
                [low + (3.2 - low) * unit(5 * k), y, 0.3 * unit(5 * k + 2)]
            }))
            .chain((0..300).map(move |k| [low, 2.0 * unit(7 * k), 0.3 * unit(7 * k + 3)]))
    };
    let turned = |[x, y, z]: [f64; 3]| [4.02 - x, 1.99 - y, z + 0.01];
    bench.put("scan.xyz", lines(on_plate(0.0).map(turned)));
    for options in ["", " --start given"] {
        let (code, results, text) = registered(&bench, &format!("plate.off scan.xyz{options}"));
        assert_eq!(code, 0, "{text}");
        assert!((results["matrix"][0][0].as_f64().unwrap() + 1.0).abs() < 1e-6, "{text}");
        // Without a start that is given it is one of the positions that are searched.
        assert_eq!(text.contains("the model nearly has a symmetry"), !options.is_empty(), "{text}");
    }
    // Of the half without the corner nothing tells which way round it is.
    let half = on_plate(0.0).filter(|[x, _, _]| *x < 2.0);
    bench.put("half.xyz", lines(half));
    let (code, results, text) = registered(&bench, "plate.off half.xyz");
    assert_eq!((code, &results["support"]["doubt"]), (1, &"rival".into()), "{text}");
    assert!(text.contains("the points fit") && text.contains("as well"), "{text}");
    assert!(!results["rival_poses"].as_array().unwrap().is_empty(), "{results}");
}

#[test]
fn the_places_of_scanners_tell_what_they_saw_through() {
    let bench = Bench::new();
    let height = |x: f64, y: f64| 0.2 * (3.0 * x).sin() * (2.2 * y).cos() + 0.1 * x * y;
    let scan = |scanner: [f64; 3], stated: [f64; 3], side: f64| {
        let mut ptx = "2500\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n".to_owned();
        writeln!(ptx, "{} {} {} 1", stated[0], stated[1], stated[2]).unwrap();
        for k in 0..2500_u32 {
            let (x, y) = (side * (f64::from(k % 50) / 24.5 - 1.0), side * (f64::from(k / 50) / 24.5 - 1.0));
            let [u, v, w] = scanner;
            writeln!(ptx, "{} {} {} 0.5", x - u, y - v, height(x, y) - w).unwrap();
        }
        ptx
    };
    bench.put("model.ptx", scan([0.0, 0.0, 3.0], [0.0, 0.0, 3.0], 1.0));
    // The second pose is a little off.
    bench.put("points.ptx", scan([0.3, 0.2, 3.0], [0.32, 0.19, 3.01], 0.8));
    let (code, results, text) = registered(&bench, "model.ptx points.ptx");
    assert_eq!(code, 0, "{text}");
    let seen = results["free_space"].as_array().unwrap();
    let scans: Vec<_> = seen.iter().map(|one| one["scan"].as_str().unwrap()).collect();
    assert_eq!(scans, ["model", "points"], "{text}");
    for one in seen {
        assert!(one["tested"].as_u64().unwrap() > 1000 && one["floating"] == 0, "{one}");
    }
}
