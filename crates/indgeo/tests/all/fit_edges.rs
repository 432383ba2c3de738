//! Surfaces within given boundary curves, surfaces that continue their neighbours, and pages of fits.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::Bench;
use crate::common::known::{P, cloud, number, results};
use serde_json::Value;
use std::fmt::Write as _;

fn wave(x: f64, y: f64) -> f64 {
    0.4 * (1.1 * x).sin() * (0.8 * y).cos()
}

/// Random points of the wave over a rectangle.
fn points(count: usize, x: [f64; 2], y: [f64; 2]) -> String {
    cloud(count, 5, move |next: &mut dyn FnMut() -> f64| {
        let (a, b) = (x[0] + (x[1] - x[0]) * next(), y[0] + (y[1] - y[0]) * next());
        [a, b, wave(a, b)]
    })
}

/// A cubic Bézier curve near the wave between two places.
fn curve([a, b]: [[f64; 2]; 2]) -> String {
    let mut text = String::new();
    for k in 0..4 {
        let t = f64::from(k) / 3.0;
        let (x, y) = (a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t);
        let _ = write!(text, "{}[{x},{y},{}]", if k > 0 { "," } else { "" }, wave(x, y));
    }
    format!("{{\"kind\":\"curve\",\"degree\":3,\"knots\":[0,0,0,0,1,1,1,1],\"control_points\":[{text}]}}")
}

/// A biquadratic Bézier patch whose control points are places of the wave over a rectangle.
fn patch(x: [f64; 2], y: [f64; 2]) -> String {
    let places = (0..9).map(|k| {
        let (a, b) =
            (x[0] + (x[1] - x[0]) * f64::from(k / 3) / 2.0, y[0] + (y[1] - y[0]) * f64::from(k % 3) / 2.0);
        format!("[{a},{b},{}]", wave(a, b))
    });
    let rows: Vec<String> = places.collect();
    let rows: Vec<String> = rows.chunks(3).map(|row| format!("[{}]", row.join(","))).collect();
    format!(
        "{{\"kind\":\"surface\",\"degree_u\":2,\"degree_v\":2,\"knots_u\":[0,0,0,1,1,1],\"knots_v\":[0,0,0,1,1,1],\"control_points\":[{}]}}",
        rows.join(",")
    )
}

/// Values of the B-spline basis by the recursion of Cox and de Boor, and its first derivative.
fn basis(knots: &[f64], degree: usize, i: usize, t: f64) -> [f64; 2] {
    if degree == 0 {
        let last = t == knots[knots.len() - 1] && knots[i] < knots[i + 1] && knots[i + 1] == t;
        return [f64::from(u8::from(knots[i] <= t && t < knots[i + 1] || last)), 0.0];
    }
    let part = |low: f64, high: f64, value: [f64; 2], rising: bool| {
        if high <= low {
            return [0.0; 2];
        }
        let (share, slope) =
            if rising { ((t - low) / (high - low), 1.0) } else { ((high - t) / (high - low), -1.0) };
        [share * value[0], share * value[1] + slope / (high - low) * value[0]]
    };
    let a = part(knots[i], knots[i + degree], basis(knots, degree - 1, i, t), true);
    let b = part(knots[i + 1], knots[i + degree + 1], basis(knots, degree - 1, i + 1, t), false);
    [a[0] + b[0], a[1] + b[1]]
}

struct Surface {
    degrees: [usize; 2],
    knots: [Vec<f64>; 2],
    net: Vec<Vec<P>>,
}

impl Surface {
    fn of(text: &str) -> Self {
        let file: Value = serde_json::from_str(text).unwrap();
        let numbers =
            |v: &Value| v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect::<Vec<_>>();
        let degree = |name: &str| usize::try_from(file[name].as_u64().unwrap()).unwrap();
        let place = |v: &Value| <P>::try_from(numbers(v)).unwrap();
        let net = file["control_points"].as_array().unwrap();
        Self {
            degrees: [degree("degree_u"), degree("degree_v")],
            knots: [numbers(&file["knots_u"]), numbers(&file["knots_v"])],
            net: net.iter().map(|row| row.as_array().unwrap().iter().map(place).collect()).collect(),
        }
    }

    /// The point and the unit normal at shares of the domain.
    fn at(&self, shares: [f64; 2]) -> [P; 2] {
        let t = [0, 1].map(|d| {
            let k = &self.knots[d];
            let (a, b) = (k[self.degrees[d]], k[k.len() - 1 - self.degrees[d]]);
            a + (b - a) * shares[d]
        });
        let mut jet = [[0.0; 3]; 3];
        for (i, row) in self.net.iter().enumerate() {
            let [u, du] = basis(&self.knots[0], self.degrees[0], i, t[0]);
            for (j, p) in row.iter().enumerate() {
                let [v, dv] = basis(&self.knots[1], self.degrees[1], j, t[1]);
                for c in 0..3 {
                    jet[0][c] += u * v * p[c];
                    jet[1][c] += du * v * p[c];
                    jet[2][c] += u * dv * p[c];
                }
            }
        }
        let [a, b] = [jet[1], jet[2]];
        let n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        let size = n.iter().map(|x| x * x).sum::<f64>().sqrt();
        [jet[0], n.map(|x| x / size)]
    }
}

fn apart(a: P, b: P) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

const CORNERS: [[f64; 2]; 4] = [[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [0.0, 2.0]];

fn boundary() -> String {
    // In no order, and some the other way round.
    let [a, b, c, d] = CORNERS;
    format!(
        "{{\"kind\":\"model\",\"shapes\":[{},{},{},{}]}}",
        curve([a, b]),
        curve([c, d]),
        curve([a, d]),
        curve([c, b])
    )
}

#[test]
fn a_surface_has_exactly_its_boundary_curves() {
    let bench = Bench::new();
    bench.put("scan.xyz", points(2500, [0.05, 2.95], [0.05, 1.95]));
    bench.put("curves.json", boundary());
    let whole = bench.run("fit-surface scan.xyz --boundary curves.json -o s.json --json -");
    let file = Surface::of(&bench.text("s.json"));
    let found = results(&whole);
    // The boundary curves are near the wave, not on it, which the points are.
    assert!(number(&found["rms"]) < 0.05, "{found}");
    assert!(number(&found["edges"]["boundary_gap"]) < 1e-9, "{found}");
    let [a, b, c, d] = CORNERS;
    for k in 0..=20 {
        let t = f64::from(k) / 20.0;
        let sides = [([t, 0.0], [a, b]), ([t, 1.0], [d, c]), ([0.0, t], [a, d]), ([1.0, t], [b, c])];
        for (shares, [from, to]) in sides {
            // A Bézier curve with control points evenly apart in x and y.
            let bernstein =
                [(1.0 - t).powi(3), 3.0 * t * (1.0 - t).powi(2), 3.0 * t * t * (1.0 - t), t.powi(3)];
            let mut place = [0.0; 3];
            for (k, w) in bernstein.into_iter().enumerate() {
                let s = k as f64 / 3.0;
                let (x, y) = (from[0] + (to[0] - from[0]) * s, from[1] + (to[1] - from[1]) * s);
                for (slot, value) in place.iter_mut().zip([x, y, wave(x, y)]) {
                    *slot += w * value;
                }
            }
            assert!(apart(file.at(shares)[0], place) < 1e-12, "{shares:?}");
        }
    }
    // The base surface that parameters are taken from has it, too.
    let run = bench.run("parameterize scan.xyz --boundary curves.json -o base.json --params uv.csv --json -");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let base = Surface::of(&bench.text("base.json"));
    for k in 0..=20 {
        let t = f64::from(k) / 20.0;
        for shares in [[t, 0.0], [t, 1.0], [0.0, t], [1.0, t]] {
            assert!(apart(base.at(shares)[0], file.at(shares)[0]) < 1e-12);
        }
    }
    assert!(number(&results(&run)["rms"]) < 0.05);
    assert_eq!(bench.text("uv.csv").lines().count(), 2501);
}

#[test]
fn surfaces_continue_their_neighbours() {
    let bench = Bench::new();
    bench.put("scan.xyz", points(2500, [0.0, 3.0], [0.0, 2.0]));
    bench.put("left.json", patch([-2.0, 0.0], [0.0, 2.0]));
    bench.put("right.json", patch([3.0, 5.0], [0.0, 2.0]));
    let edges = |text: &str| Surface::of(&bench.text(text));
    let (left, right) = (edges("left.json"), edges("right.json"));
    for (continuity, is_smooth) in [("g0", false), ("g1", true)] {
        let run = bench.run(&format!(
            "fit-surface scan.xyz --join left.json --join right.json --continuity {continuity} -o s.json --json -"
        ));
        assert!(run.code <= 1, "{}", run.stderr);
        let found = results(&run);
        let joins = found["edges"]["joins"].as_array().unwrap();
        assert_eq!(joins.len(), 2);
        assert!(joins.iter().all(|join| number(&join["gap"]) < 1e-9), "{found}");
        let made = edges("s.json");
        // By an evaluation of its own: the places of each edge are on a side, with the normals of the neighbour if asked for.
        for (neighbour, at, join) in [(&left, 1.0, &joins[0]), (&right, 0.0, &joins[1])] {
            let mut angle = 0.0f64;
            for k in 0..=10 {
                let [place, normal] = neighbour.at([at, f64::from(k) / 10.0]);
                let end = f64::from(u8::from(join["side"].as_str().unwrap().ends_with("end")));
                let in_u = join["side"].as_str().unwrap().starts_with('u');
                let shares = |t: f64| if in_u { [end, t] } else { [t, end] };
                // The side has the parameter of the edge, up to its direction.
                let candidates = [f64::from(k) / 10.0, 1.0 - f64::from(k) / 10.0].map(|t| made.at(shares(t)));
                let [own, other] = candidates
                    .into_iter()
                    .min_by(|a, b| apart(a[0], place).total_cmp(&apart(b[0], place)))
                    .unwrap();
                assert!(apart(own, place) < 1e-9);
                let cosine: f64 = (0..3).map(|c| other[c] * normal[c]).sum();
                angle = angle.max(1.0 - cosine.abs());
            }
            assert_eq!(angle < 1e-12, is_smooth, "{angle}");
        }
    }
    let run = bench.run("fit-surface scan.xyz --join curves.json -o t.json");
    assert_eq!(run.code, 2);
    bench.put("curves.json", boundary());
    let run = bench.run("fit-surface scan.xyz --join curves.json -o t.json");
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("holds 0 surfaces"), "{}", run.stderr);
    let run = bench.run("fit-surface scan.xyz --boundary left.json -o t.json");
    assert!(run.code == 2 && run.stderr.contains("this file holds 0"), "{}", run.stderr);
    assert!(!bench.files().contains(&"t.json".to_owned()));
}

#[test]
fn curves_continue_their_neighbours() {
    let bench = Bench::new();
    let section = |low: f64, high: f64| {
        (0..=100).map(|k| low + (high - low) * f64::from(k) / 100.0).fold(String::new(), |mut text, x| {
            let _ = writeln!(text, "{x} {}", wave(x, 0.3));
            text
        })
    };
    bench.put("gap.xyz", section(1.0, 4.0));
    bench.put("left.json", line([0.0, 0.1], [0.97, wave(0.97, 0.3)]));
    bench.put("right.json", line([5.0, -0.2], [4.03, wave(4.03, 0.3)]));
    for (continuity, is_smooth) in [("g0", false), ("g1", true)] {
        let run = bench.run(&format!(
            "fit-curve gap.xyz --join left.json --join right.json --continuity {continuity} -o c.json --json -"
        ));
        assert_eq!(run.code, 0, "{}", run.stderr);
        let joins = &results(&run)["joins"];
        let file: Value = serde_json::from_str(&bench.text("c.json")).unwrap();
        let net = file["control_points"].as_array().unwrap();
        let place = |k: usize| [0, 1].map(|c| net[k][c].as_f64().unwrap());
        let last = net.len() - 1;
        // Ends and tangents of a clamped curve are those of its control polygon.
        let mut ends = [[place(0), place(1)], [place(last), place(last - 1)]];
        ends.sort_by(|a, b| a[0][0].total_cmp(&b[0][0]));
        for (k, ([end, next], from)) in ends.into_iter().zip([[0.0, 0.1], [5.0, -0.2]]).enumerate() {
            let given = [[0.97, wave(0.97, 0.3)], [4.03, wave(4.03, 0.3)]][k];
            assert!((end[0] - given[0]).hypot(end[1] - given[1]) < 1e-12);
            let (a, b) = ([given[0] - from[0], given[1] - from[1]], [next[0] - end[0], next[1] - end[1]]);
            let sine = (a[0] * b[1] - a[1] * b[0]) / (a[0].hypot(a[1]) * b[0].hypot(b[1]));
            assert!(a[0] * b[0] + a[1] * b[1] > 0.0);
            assert_eq!(sine.abs() < 1e-10, is_smooth, "{sine}");
            assert!((number(&joins[k]["angle"]).sin().abs() - sine.abs()).abs() < 1e-9);
        }
    }
    let run = bench.run("fit-curve gap.xyz --join left.json --join left.json --join left.json -o d.json");
    assert!(run.code == 2 && run.stderr.contains("two ends"), "{}", run.stderr);
}

/// A straight curve in the plane.
fn line([a, b]: [f64; 2], [c, d]: [f64; 2]) -> String {
    format!(
        "{{\"kind\":\"curve\",\"degree\":1,\"knots\":[0,0,1,1],\"control_points\":[[{a},{b}],[{c},{d}]]}}"
    )
}

#[test]
fn fits_have_pages() {
    let bench = Bench::new();
    bench.put("scan.xyz", points(900, [0.0, 3.0], [0.0, 2.0]));
    let section: String = (0..120).map(|k| f64::from(k) * 0.05).fold(String::new(), |mut text, x| {
        let _ = writeln!(text, "{x} {}", wave(x, 0.3));
        text
    });
    bench.put("section.xyz", section);
    for (command, pictures) in [
        ("fit-surface scan.xyz --report page.html", "Zebra stripes"),
        ("fit-ruled scan.xyz --report page.html", "Zebra stripes"),
        ("fit-curve section.xyz --report page.html", "Curvature comb"),
    ] {
        let run = bench.run(command);
        assert!(run.code <= 1, "{}", run.stderr);
        let page = bench.text("page.html");
        let verdict = if run.code == 0 { "verdict pass" } else { "verdict fail" };
        assert!(
            page.contains(verdict) && page.contains(pictures) && page.contains("<h2>History</h2>"),
            "{command}"
        );
        // The report as it is, and nothing that is fetched.
        let json =
            page.split("id=\"report\">").nth(1).and_then(|rest| rest.split("</script>").next()).unwrap();
        let report: Value = serde_json::from_str(json).unwrap();
        assert!(number(&report["rms"]) >= 0.0);
        assert!(
            !page.contains("http://")
                || page.matches("http://").count() == page.matches("http://www.w3.org/").count()
        );
    }
    let run = bench.run("fit-surface scan.xyz --report page.txt");
    assert!(run.code == 2 && run.stderr.contains(".html"), "{}", run.stderr);
}
