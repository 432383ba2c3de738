//! Fits of surfaces judged by shapes that are known, in both directions: every point near the surface, every part of it near the shape.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::Bench;
use crate::common::known::{P, Surface, chance, cloud, normal, number, outside, results};
use serde_json::Value;
use std::f64::consts::TAU;

#[test]
fn points_that_the_surface_does_not_meet_are_no_success() {
    let bench = Bench::new();
    // A tube with a bottom, which is 5 % of the points.
    let tube = |next: &mut dyn FnMut() -> f64| {
        let (a, z) = (TAU * next(), 60.0 * next());
        [20.0 * a.cos(), 20.0 * a.sin(), z]
    };
    let bottom = |next: &mut dyn FnMut() -> f64| {
        let (a, r) = (TAU * next(), 18.0 * next().sqrt());
        [r * a.cos(), r * a.sin(), 0.0]
    };
    bench.put("vase.xyz", cloud(6000, 1, tube) + &cloud(400, 2, bottom));
    let run = bench.run("fit-surface vase.xyz -o s.json --tolerance 1 --max-control-points 400 --json -");
    let found = results(&run);
    let surface = Surface::read(&bench, "s.json");
    // The middle of the bottom is met, or its points are outside of the tolerance.
    let nearest = surface.farthest(|p| if p[0].hypot(p[1]) < 10.0 && p[2].abs() < 1.0 { 1.0 } else { 0.0 });
    if nearest == 0.0 {
        assert_eq!(run.code, 1, "{}", run.stderr);
        assert!(number(&found["max"]) > 5.0 && number(&found["share_within"]) < 0.99, "{found}");
        assert_eq!(run.report()["status"], "out_of_tolerance");
    }
    // One point far away: outside as well.
    bench.put("stray.xyz", cloud(3000, 1, tube) + "300 0 0\n");
    let run = bench.run("fit-surface stray.xyz -o s.json --tolerance 0.5 --json -");
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert!((number(&results(&run)["max"]) - 280.0).abs() < 5.0 && results(&run)["max_index"] == 3000);
    // Unless it is an outlier by the option.
    let run =
        bench.run("fit-surface stray.xyz -o s.json --control-points 12x8 --outliers automatic --json -");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
}

#[test]
fn open_ends_stop_where_the_points_do() {
    let bench = Bench::new();
    for (seed, noise) in [(3, 0.0), (4, 0.02)] {
        bench.put(
            "tube.xyz",
            cloud(4000, seed, |next| {
                let (a, z) = (TAU * next(), 10.0 * next());
                let r = 3.0 + 0.5 * (0.6 * z).sin() + noise * normal(next);
                [r * a.cos(), r * a.sin(), z]
            }),
        );
        let run = bench.run("fit-surface tube.xyz -o s.json --control-points 12x12 --json -");
        assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
        let off = |[x, y, z]: P| (x.hypot(y) - 3.0 - 0.5 * (0.6 * z).sin()).abs().max(outside(z, 0.0, 10.0));
        // Points are .22 apart.
        let far = Surface::read(&bench, "s.json").farthest(off);
        assert!(far < 0.44, "{far}");
        let coverage = &results(&run)["coverage"];
        assert!((number(&coverage["spacing"]) - 0.22).abs() < 0.06, "{coverage}");
        assert_eq!(number(&coverage["area_without_data"]), 0.0);
        assert!((number(&coverage["area_ratio"]) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn a_square_is_fitted_along_its_sides() {
    let bench = Bench::new();
    // The principal axes of a square can be any; noise of 1 %.
    bench.put(
        "sheet.xyz",
        cloud(5000, 7, |next| {
            let (x, y) = (next() * 3.0, next() * 3.0);
            [x, y, 0.3 * (2.0 * x).sin() * y.cos() + 0.03 * normal(next)]
        }),
    );
    let run = bench.run("fit-surface sheet.xyz -o s.json --control-points 12x12 --json -");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let beyond = |[x, y, _]: P| outside(x, 0.0, 3.0).max(outside(y, 0.0, 3.0));
    let surface = Surface::read(&bench, "s.json");
    let far = surface.farthest(beyond);
    assert!(far < 0.12, "{far}");
    let off = |[x, y, z]: P| (z - 0.3 * (2.0 * x).sin() * y.cos()).abs();
    let far = surface.farthest(off);
    assert!(far < 0.06, "{far}");
}

#[test]
fn surfaces_end_where_their_points_do_or_say_so() {
    let bench = Bench::new();
    // An L: a quarter of the square is without points.
    bench.put(
        "l.xyz",
        cloud(3000, 5, |next| {
            loop {
                let (x, y) = (next() * 4.0, next() * 4.0);
                if x < 2.0 || y < 2.0 {
                    return [x, y, 0.2 * x.sin()];
                }
            }
        }),
    );
    let run = bench.run("fit-surface l.xyz -o s.json --control-points 10x10 --json -");
    let far = Surface::read(&bench, "s.json").farthest(|[x, y, _]| {
        outside(x, 0.0, 2.0).min(outside(y, 0.0, 2.0)).max(outside(x, 0.0, 4.0)).max(outside(y, 0.0, 4.0))
    });
    // Either it ends where they do, or that is said.
    assert!(run.code == 1 || far < 0.25, "{far}: {}", run.stdout);
    if run.code == 1 && far > 0.5 {
        let coverage = &results(&run)["coverage"];
        assert!(number(&coverage["area_without_data"]) > 1.0, "{coverage}");
        assert!((number(&coverage["max"]) - far).abs() < 0.4, "{coverage} {far}");
        assert!(run.stderr.contains("without data"), "{}", run.stderr);
    }
}

#[test]
fn a_start_on_which_the_points_lie_is_the_result() {
    let bench = Bench::new();
    // A bicubic patch, and one that is closed in u, with points on them.
    let wave = |k: usize, j: usize| ((k * 7 + j * 3) as f64 * 0.9).sin();
    let open = |n: usize| -> Vec<f64> {
        let inner = (1..n - 3).map(|k| k as f64 / (n - 3) as f64);
        [0.0; 4].into_iter().chain(inner).chain([1.0; 4]).collect()
    };
    let patch = |closed: bool| -> Value {
        let (n, m) = (if closed { 11 } else { 7 }, 6);
        let place = |i: usize, j: usize| {
            let (a, k) = (TAU * (i % 8) as f64 / 8.0, if closed { i % 8 } else { i });
            let bump = 0.1 * wave(k, j);
            if closed {
                [(3.0 + bump) * a.cos(), (3.0 + bump) * a.sin(), j as f64 + bump]
            } else {
                [i as f64, j as f64 + 0.3 * bump, bump]
            }
        };
        let net: Vec<Vec<P>> = (0..n).map(|i| (0..m).map(|j| place(i, j)).collect()).collect();
        let knots_u = if closed { (-3..12).map(|k| f64::from(k) / 8.0).collect() } else { open(n) };
        serde_json::json!({
            "kind": "surface", "degree_u": 3, "degree_v": 3, "knots_u": knots_u, "knots_v": open(m),
            "periodic_u": closed, "control_points": net,
        })
    };
    for closed in [false, true] {
        bench.put("start.json", patch(closed).to_string());
        let surface = Surface::read(&bench, "start.json");
        let mut next = chance(11);
        let points: String = (0..3000)
            .map(|_| surface.at([next(), next()]))
            .map(|[x, y, z]| format!("{x:e} {y:e} {z:e}\n"))
            .collect();
        bench.put("points.xyz", points);
        let run = bench.run("fit-surface points.xyz --init start.json --smoothing 0 -o s.json --json -");
        assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
        let found = Surface::read(&bench, "s.json");
        let moved = found.net.iter().flatten().zip(surface.net.iter().flatten());
        let moved =
            moved.map(|(a, b)| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f64::max)).fold(0.0, f64::max);
        assert!(moved < 1e-12, "{closed}: {moved}");
        // From a start beside it the same surface is found again.
        let mut beside = patch(closed);
        for (i, row) in beside["control_points"].as_array_mut().unwrap().iter_mut().enumerate() {
            for (j, point) in row.as_array_mut().unwrap().iter_mut().enumerate() {
                let k = if closed { i % 8 } else { i };
                point[2] = (point[2].as_f64().unwrap() + 0.02 * wave(j, k)).into();
            }
        }
        bench.put("beside.json", beside.to_string());
        let run = bench.run("fit-surface points.xyz --init beside.json --smoothing 0 -o s.json --json -");
        assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
        let rms = number(&results(&run)["rms"]);
        assert!(rms < 1e-6, "{closed}: {rms}");
    }
}

#[test]
fn a_hyperbolic_paraboloid_is_an_exact_ruled_surface() {
    let bench = Bench::new();
    bench.put(
        "hypar.xyz",
        cloud(1500, 21, |next| {
            let (x, y) = (2.0 * next() - 1.0, 2.0 * next() - 1.0);
            [x, y, 0.5 * x * y]
        }),
    );
    let run = bench.run("fit-ruled hypar.xyz -o h.json --control-points 6x2 --json -");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    assert!(number(&results(&run)["rms"]) < 1e-9, "{}", results(&run));
    let far = Surface::read(&bench, "h.json").farthest(|[x, y, z]| {
        (z - 0.5 * x * y).abs().max(outside(x, -1.0, 1.0) - 0.1).max(outside(y, -1.0, 1.0) - 0.1)
    });
    assert!(far < 1e-7, "{far}");
}

#[test]
fn a_hyperboloid_of_one_sheet_is_ruled() {
    let bench = Bench::new();
    for (seed, waist) in [(31, 1.0), (32, 0.6)] {
        bench.put(
            "hyperboloid.xyz",
            cloud(5000, seed, |next| {
                let (a, z) = (TAU * next(), 2.0 * next() - 1.0);
                let (c, s) = (a.cos(), a.sin());
                [waist * c - z * s, waist * s + z * c, 2.0 * z]
            }),
        );
        let run = bench.run("fit-ruled hyperboloid.xyz -o h.json --control-points 24x2 --json -");
        let off = |[x, y, z]: P| {
            (x * x + y * y - waist * waist - 0.25 * z * z).abs().max(outside(z, -2.0, 2.0) - 0.2)
        };
        let far = Surface::read(&bench, "h.json").farthest(off);
        assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
        assert!(far < 2e-3 && number(&results(&run)["rms"]) < 1e-3, "{far}");
        assert_eq!(results(&run)["folds"]["folded"], serde_json::json!([]));
    }
}

#[test]
fn cones_are_tubes() {
    let bench = Bench::new();
    bench.put(
        "cone.xyz",
        cloud(3000, 41, |next| {
            let (a, h) = (TAU * next(), next());
            let r = 2.0 - 0.8 * h;
            [r * a.cos(), r * a.sin(), h]
        }),
    );
    let run = bench.run("fit-surface cone.xyz --rational -o s.json --json -");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    assert_eq!(results(&run)["base"], "cylinder");
    let far = Surface::read(&bench, "s.json").farthest(|[x, y, z]| (x.hypot(y) - 2.0 + 0.8 * z).abs());
    assert!(far < 1e-8, "{far}");
    let run = bench.run("fit-ruled cone.xyz --control-points 16x2 -o r.json --json -");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    assert_eq!(results(&run)["base"], "cylinder");
    assert!(number(&results(&run)["rms"]) < 1e-3, "{}", results(&run));
    // It unrolls into the plane.
    assert!(number(&results(&run)["developability"]["max_angle"]) < 0.1, "{}", results(&run));
}
