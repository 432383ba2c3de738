//! Fits of surfaces judged by shapes that are known, in both directions: every point near the surface, every part of it near the shape.
//! What is measured here shares nothing with the fits: the surfaces are read as JSON and evaluated by de Boor's recursion.

use crate::common::{Bench, Run};
use serde_json::Value;
use std::f64::consts::TAU;

type P = [f64; 3];

/// A B-spline or NURBS surface as it is in the file.
struct Surface {
    degrees: [usize; 2],
    knots: [Vec<f64>; 2],
    net: Vec<Vec<[f64; 4]>>,
}

impl Surface {
    fn read(bench: &Bench, name: &str) -> Self {
        let json: Value = serde_json::from_str(&bench.text(name)).unwrap();
        let numbers = |value: &Value| -> Vec<f64> { serde_json::from_value(value.clone()).unwrap() };
        let net: Vec<Vec<P>> = serde_json::from_value(json["control_points"].clone()).unwrap();
        let weights: Option<Vec<Vec<f64>>> = serde_json::from_value(json["weights"].clone()).unwrap();
        let weight = |i: usize, j: usize| weights.as_ref().map_or(1.0, |w| w[i][j]);
        let point = |(i, row): (usize, &Vec<P>)| {
            row.iter().enumerate().map(|(j, p)| (weight(i, j), p)).map(|(w, p)| [w * p[0], w * p[1], w * p[2], w]).collect()
        };
        Self {
            degrees: ["degree_u", "degree_v"].map(|key| usize::try_from(json[key].as_u64().unwrap()).unwrap()),
            knots: [numbers(&json["knots_u"]), numbers(&json["knots_v"])],
            net: net.iter().enumerate().map(point).collect(),
        }
    }

    fn de_boor(degree: usize, knots: &[f64], points: &[[f64; 4]], t: f64) -> [f64; 4] {
        let last = knots.len() - degree - 2;
        let span = (degree..=last).rev().find(|&k| knots[k] <= t && knots[k] < knots[k + 1]).unwrap_or(degree);
        let mut d: Vec<[f64; 4]> = (0..=degree).map(|j| points[j + span - degree]).collect();
        for r in 1..=degree {
            for j in (r..=degree).rev() {
                let (a, b) = (knots[j + span - degree], knots[j + 1 + span - r]);
                let share = (t - a) / (b - a);
                d[j] = std::array::from_fn(|c| d[j - 1][c] * (1.0 - share) + d[j][c] * share);
            }
        }
        d[degree]
    }

    /// The point at shares of the domain.
    fn at(&self, shares: [f64; 2]) -> P {
        let [u, v] = [0, 1].map(|d| {
            let (p, k) = (self.degrees[d], &self.knots[d]);
            let (a, b) = (k[p], k[k.len() - 1 - p]);
            a + (b - a) * shares[d].clamp(0.0, 1.0 - 1e-12)
        });
        let row: Vec<[f64; 4]> =
            self.net.iter().map(|row| Self::de_boor(self.degrees[1], &self.knots[1], row, v)).collect();
        let h = Self::de_boor(self.degrees[0], &self.knots[0], &row, u);
        [h[0] / h[3], h[1] / h[3], h[2] / h[3]]
    }

    /// Largest distance of the surface from a shape, of samples all over it, the edges included.
    fn farthest(&self, distance: impl Fn(P) -> f64) -> f64 {
        let n = 120;
        let at = |k: usize| self.at([(k / (n + 1)) as f64 / n as f64, (k % (n + 1)) as f64 / n as f64]);
        (0..(n + 1) * (n + 1)).map(at).map(distance).fold(0.0, f64::max)
    }
}

/// Numbers from 0 to 1 that look like chance (splitmix64).
fn chance(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn cloud(count: usize, seed: u64, mut place: impl FnMut(&mut dyn FnMut() -> f64) -> P) -> String {
    let mut next = chance(seed);
    (0..count).map(|_| place(&mut next)).map(|[x, y, z]| format!("{x} {y} {z}\n")).collect()
}

/// A number with the normal distribution.
fn normal(next: &mut dyn FnMut() -> f64) -> f64 {
    (-2.0 * (1.0 - next()).ln()).sqrt() * (TAU * next()).cos()
}

/// How far a number is outside of a range.
fn outside(x: f64, low: f64, high: f64) -> f64 {
    (low - x).max(x - high).max(0.0)
}

fn results(run: &Run) -> Value {
    run.report()["results"].clone()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

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
    let run = bench.run("fit-surface vase.xyz -o s.json --tolerance 1 --json -");
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
    let run = bench.run("fit-surface stray.xyz -o s.json --control-points 12x8 --outliers automatic --json -");
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
        let off = |[x, y, z]: P| {
            (x.hypot(y) - 3.0 - 0.5 * (0.6 * z).sin()).abs().max(outside(z, 0.0, 10.0))
        };
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
fn parts_without_data_are_told() {
    let bench = Bench::new();
    // An L: a quarter of the square is without points.
    bench.put(
        "l.xyz",
        cloud(3000, 5, |next| loop {
            let (x, y) = (next() * 4.0, next() * 4.0);
            if x < 2.0 || y < 2.0 {
                return [x, y, 0.2 * x.sin()];
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
        let moved = moved.map(|(a, b)| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f64::max)).fold(0.0, f64::max);
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
        assert!(number(&results(&run)["rms"]) < 1e-9, "{closed}: {}", run.stdout.len());
    }
}

#[test]
fn a_hyperbolic_paraboloid_is_an_exact_ruled_surface() {
    let bench = Bench::new();
    bench.put("hypar.xyz", cloud(1500, 21, |next| {
        let (x, y) = (2.0 * next() - 1.0, 2.0 * next() - 1.0);
        [x, y, 0.5 * x * y]
    }));
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
        let off = |[x, y, z]: P| (x * x + y * y - waist * waist - 0.25 * z * z).abs().max(outside(z, -2.0, 2.0) - 0.2);
        let far = Surface::read(&bench, "h.json").farthest(off);
        assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
        assert!(far < 2e-3 && number(&results(&run)["rms"]) < 1e-3, "{far}");
        assert_eq!(results(&run)["folds"]["folded"], serde_json::json!([]));
    }
}

#[test]
fn cones_are_tubes() {
    let bench = Bench::new();
    bench.put("cone.xyz", cloud(3000, 41, |next| {
        let (a, h) = (TAU * next(), next());
        let r = 2.0 - 0.8 * h;
        [r * a.cos(), r * a.sin(), h]
    }));
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

#[test]
fn volumes_and_curves_are_no_surfaces() {
    let bench = Bench::new();
    bench.put("block.xyz", (0..1000).map(|k| format!("{} {} {}\n", k % 10, k / 10 % 10, k / 100)).collect::<String>());
    bench.put("ball.xyz", cloud(3000, 51, |next| loop {
        let p = [0; 3].map(|_| 2.0 * next() - 1.0);
        if p.iter().map(|c| c * c).sum::<f64>() < 1.0 {
            return p;
        }
    }));
    bench.put("line.xyz", cloud(500, 52, |next| {
        let t = next();
        [t, 2.0 * t + 1.0, 3.0 * t]
    }));
    bench.put("circle.xyz", cloud(500, 53, |next| {
        let a = TAU * next();
        [a.cos(), a.sin(), 0.5]
    }));
    for (name, message) in [("block", "volume"), ("ball", "volume"), ("line", "line"), ("circle", "curve")] {
        for options in ["", "--shape sphere", "--tolerance 0.5"] {
            let run = bench.run(&format!("fit-surface {name}.xyz -o s.json {options}"));
            assert!(run.code == 1 || run.code == 2, "{name} {options}: {}{}", run.stdout, run.stderr);
            assert!(run.code == 1 || run.stderr.contains(message) || run.stderr.contains("curve"), "{}", run.stderr);
        }
        let run = bench.run(&format!("fit-ruled {name}.xyz -o s.json"));
        assert!(run.code == 1 || run.code == 2, "{name}: {}{}", run.stdout, run.stderr);
    }
}

#[test]
fn outliers_are_recognised_before_they_bend_the_surface() {
    let bench = Bench::new();
    for (count, outliers) in [(400, 4), (600, 30), (5000, 250)] {
        let mut number_of = 0;
        bench.put(
            "sheet.xyz",
            cloud(count + outliers, 61, |next| {
                number_of += 1;
                let (x, y) = (10.0 * next(), 10.0 * next());
                let off = if number_of > count { 1.5 + 2.5 * next() } else { 0.0 };
                [x, y, 0.02 * (x - 5.0).powi(2) + off]
            }),
        );
        let run = bench.run("fit-surface sheet.xyz -o s.json --outliers automatic --json -");
        assert_eq!(run.code, 0, "{count}: {}{}", run.stdout, run.stderr);
        let far = Surface::read(&bench, "s.json").farthest(|[x, _, z]| (z - 0.02 * (x - 5.0).powi(2)).abs());
        assert!(far < 0.02, "{count}: {far}");
    }
}

#[test]
fn smoothing_acts() {
    let bench = Bench::new();
    bench.put("sheet.xyz", cloud(4000, 71, |next| {
        let (x, y) = (10.0 * next(), 10.0 * next());
        [x, y, (0.7 * x).sin() + 0.1 * normal(next)]
    }));
    let mut last = 0.0;
    let mut bytes = Vec::new();
    for smoothing in ["1e-5", "1e-3", "1e-1"] {
        let run = bench.run(&format!(
            "fit-surface sheet.xyz -o s.json --control-points 15x15 --smoothing {smoothing} --json -"
        ));
        let found = results(&run);
        // The distance of the surface that is written grows with it, and its λ is the one that was asked for, if it was kept.
        let rms = number(&found["rms"]);
        assert!(rms >= last, "{smoothing}: {rms} after {last}");
        last = rms;
        assert!(!bytes.contains(&bench.text("s.json")), "{smoothing}");
        bytes.push(bench.text("s.json"));
    }
}

#[test]
fn one_wild_point_neither_hangs_nor_decides() {
    let bench = Bench::new();
    let sheet = cloud(600, 81, |next| {
        let (x, y) = (3.0 * next(), 2.0 * next());
        [x, y, 0.2 * x * y]
    });
    for wild in ["1e300 0 0", "0 0 -1e160", "1e308 1e308 -1e308"] {
        bench.put("wild.xyz", format!("{sheet}{wild}\n"));
        for command in [
            "fit-surface wild.xyz -o s.json --control-points 6x6 --max-iterations 5 --json -",
            "fit-ruled wild.xyz -o s.json --control-points 6x2 --max-iterations 5 --json -",
        ] {
            let run = bench.run(command);
            assert_eq!(run.code, 1, "{command}: {}{}", run.stdout, run.stderr);
            let found = results(&run);
            assert!(number(&found["max"]) > 1e159, "{}", found["max"]);
            assert_eq!(found["max_index"], 600);
        }
        let off = Surface::read(&bench, "s.json").farthest(|[x, y, z]| (z - 0.2 * x * y).abs());
        assert!(off < 0.2, "{off}");
    }
    let tiny = cloud(600, 81, |next| [3e-160 * next(), 2e-160 * next(), 1e-161 * next()]);
    bench.put("tiny.xyz", tiny);
    for command in ["fit-surface", "fit-ruled", "parameterize"] {
        let out = if command == "parameterize" { "--base" } else { "-o" };
        let run = bench.run(&format!("{command} tiny.xyz {out} s.json"));
        assert_eq!(run.code, 2, "{command}: {}{}", run.stdout, run.stderr);
        assert!(run.stderr.contains("e-160") || run.stderr.contains("e-161"), "{}", run.stderr);
    }
}

#[test]
fn many_control_points_are_taken_where_there_is_something_to_follow() {
    let bench = Bench::new();
    bench.put("waves.xyz", cloud(8000, 91, |next| {
        let (x, y) = (10.0 * next(), 10.0 * next());
        [x, y, 0.5 * (2.0 * x).sin() * (2.0 * y).cos() + 0.02 * normal(next)]
    }));
    let run = bench.run("fit-surface waves.xyz -o s.json --json -");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    assert!(number(&results(&run)["rms"]) < 0.024, "{}", results(&run)["rms"]);
    // Noise alone asks for no more than to begin with.
    bench.put("noise.xyz", cloud(8000, 92, |next| [10.0 * next(), 10.0 * next(), 0.15 * normal(next)]));
    let run = bench.run("fit-surface noise.xyz -o s.json --json -");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    assert_eq!(results(&run)["control_points"], serde_json::json!([12, 12]));
}
