//! `indgeo contour` as a user runs it.

use crate::common::Bench;
use serde_json::Value;
use std::fmt::Write;

/// A binary PGM of a function of the pixel, x to the right and y downwards from the middle of the upper left pixel.
fn pgm(width: usize, height: usize, value: impl Fn(f64, f64) -> f64) -> Vec<u8> {
    let mut out = format!("P5\n{width} {height}\n255\n").into_bytes();
    for row in 0..height {
        for column in 0..width {
            let value = value(column as f64, row as f64).round().clamp(0.0, 255.0);
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a byte")]
            out.push(value as u8);
        }
    }
    out
}

/// An edge one pixel wide at a distance.
fn edge(distance: f64) -> f64 {
    255.0 * (0.5 - distance).clamp(0.0, 1.0)
}

/// A ring about (40, 30) from the top left, radii 20 and 10, and a disc at (85, 20) of radius 8.
fn ring() -> Vec<u8> {
    pgm(110, 70, |x, y| {
        let r = (x - 39.5).hypot(y - 29.5);
        edge((r - 20.0).max(10.0 - r).min((x - 84.5).hypot(y - 19.5) - 8.0))
    })
}

fn contour(bench: &Bench, arguments: &str, code: i32) -> Value {
    let run = bench.run(&format!("contour {arguments} --json -"));
    assert_eq!(run.code, code, "{arguments}: {} {}", run.stderr, run.stdout);
    run.report()
}

/// All control points of the curves of a model.
fn control_points(json: &str) -> Vec<[f64; 2]> {
    fn collect(value: &Value, out: &mut Vec<[f64; 2]>) {
        match value {
            Value::Object(map) => {
                if let Some(points) = map.get("control_points") {
                    out.extend(serde_json::from_value::<Vec<[f64; 2]>>(points.clone()).unwrap());
                }
                map.values().for_each(|value| collect(value, out));
            }
            Value::Array(all) => all.iter().for_each(|value| collect(value, out)),
            _ => {}
        }
    }
    let mut out = Vec::new();
    collect(&serde_json::from_str(json).unwrap(), &mut out);
    out
}

#[test]
fn components_and_holes_become_one_model() {
    let bench = Bench::new();
    bench.put("ring.pgm", ring());
    let report = contour(&bench, "ring.pgm -o out.json --picture p.png", 0);
    let results = &report["results"];
    assert_eq!((&results["components"], &results["holes"]), (&2.into(), &1.into()));
    assert_eq!(results["inside"], "bright");
    let contours = results["contours"].as_array().unwrap();
    let names: Vec<&str> = contours.iter().map(|c| c["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["contour 0", "hole 1", "contour 2"]);
    for (contour, radius) in contours.iter().zip([20.0f64, 10.0, 8.0]) {
        let found = (contour["area"].as_f64().unwrap() / std::f64::consts::PI).sqrt();
        assert!((found - radius).abs() < 0.05, "{found} {radius}");
    }
    // Upwards is upwards: the ring, at 30 from the top of 70, is about y = 40.
    let points = control_points(&bench.text("out.json"));
    let low = points.iter().map(|p| p[1]).fold(f64::INFINITY, f64::min);
    // Control polygons of closed curves surround them.
    assert!(low > 14.0 && low < 20.5, "{low}");
    // The picture has a red line where the ring ends on the right, at x = 60.
    assert!(bench.read("p.png").starts_with(b"\x89PNG"));
    // The model is one that other commands take.
    let run = bench.run("info out.json");
    assert_eq!(run.code, 0, "{}", run.stderr);
}

#[test]
fn drawings_agree_with_the_model() {
    let bench = Bench::new();
    bench.put("ring.pgm", ring());
    contour(&bench, "ring.pgm -o out.svg", 0);
    let svg = bench.text("out.svg");
    assert!(svg.contains("viewBox=\"0 0 110 70\"") && svg.matches("<path").count() == 3, "{svg}");
    let numbers: Vec<f64> = svg
        .lines()
        .find(|line| line.starts_with("<path"))
        .unwrap()
        .split(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-'))
        .filter_map(|part| part.parse().ok())
        .collect();
    // On the image, from the top: the ring is between 10 and 50.
    let ys = numbers.chunks_exact(2).map(|pair| pair[1]);
    let (low, high) = ys.fold((f64::INFINITY, 0.0f64), |(low, high), y| (low.min(y), high.max(y)));
    assert!(low > 6.0 && low < 10.5 && high > 49.5 && high < 54.0, "{low} {high}");
    contour(&bench, "ring.pgm -o out.dxf --picture p.svg", 0);
    let dxf = bench.text("out.dxf");
    assert_eq!(dxf.matches("POLYLINE").count(), 3);
    let picture = bench.text("p.svg");
    assert!(picture.contains("data:image/png;base64,iVBORw0KGgo") && picture.matches("<path").count() == 3);
}

#[test]
fn evolving_contours_keep_or_change_their_topology() {
    let bench = Bench::new();
    bench.put("ring.pgm", ring());
    let report = contour(&bench, "ring.pgm -o a.json --method chan-vese", 0);
    assert_eq!(report["results"]["components"], 2);
    assert_eq!(report["results"]["evolution"]["settled"], true);
    // A circle around the disc becomes one contour: with a fixed topology the ring is not found.
    let start = "--start 80,50,14";
    let report =
        contour(&bench, &format!("ring.pgm -o b.json --method chan-vese --topology fixed {start}"), 0);
    assert_eq!((&report["results"]["components"], &report["results"]["holes"]), (&1.into(), &0.into()));
    let report = contour(&bench, "ring.pgm -o c.json --method edges --start 85,50,3 --tolerance 0.2", 0);
    let area = report["results"]["contours"][0]["area"].as_f64().unwrap();
    assert!((area / (64.0 * std::f64::consts::PI) - 1.0).abs() < 0.15, "{area}");
}

#[test]
fn grids_in_the_plane_and_in_space() {
    let bench = Bench::new();
    bench.put(
        "circle.json",
        r#"{"kind":"curve","dim":2,"degree":2,"knots":[0,0,0,1,1,2,2,3,3,4,4,4],
"control_points":[[1,0],[1,1],[0,1],[-1,1],[-1,0],[-1,-1],[0,-1],[1,-1],[1,0]],
"weights":[1,0.7071067811865476,1,0.7071067811865476,1,0.7071067811865476,1,0.7071067811865476,1]}"#,
    );
    let run = bench.run("field circle.json -o d.npy --grid 61x61 --box -1.5,-1.5,1.5,1.5 --signed --quiet");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let report = contour(&bench, "d.npy --box -1.5,-1.5,1.5,1.5 -o out.json --tolerance 1e-5", 0);
    let area = report["results"]["contours"][0]["area"].as_f64().unwrap();
    assert!((area - std::f64::consts::PI).abs() < 5e-3, "{area}");
    bench.put("cube.off", crate::common::CUBE);
    let run = bench.run("field cube.off -o d.vti --grid 31x31x31 --signed --quiet");
    assert_eq!(run.code, 0, "{}", run.stderr);
    // Offsets by 0.1 are round at the edges.
    let report = contour(&bench, "d.vti --level 0.1 -o out.stl --tolerance 0.01", 0);
    assert_eq!(report["results"]["mesh"]["closed"], true);
    // Half as wide, the tolerance is not reached at the sharp edges of the cube, which the spline through the values does not know.
    let report = contour(&bench, "d.vti -o out.ply --tolerance 1e-9", 1);
    assert_eq!(report["status"], "out_of_tolerance");
    let run = bench.run("contour d.vti -o out.dxf");
    assert!(run.code == 2 && run.stderr.contains(".stl") && run.stderr.contains(".step"), "{}", run.stderr);
}

#[test]
fn volumes_become_surfaces_and_models() {
    let bench = Bench::new();
    bench.put("cube.off", crate::common::CUBE);
    let run = bench.run("field cube.off -o d.vti --grid 29x29x29 --box -1,-1,-1,2,2,2 --signed --quiet");
    assert_eq!(run.code, 0, "{}", run.stderr);
    // An offset of the unit cube, all of whose edges are round.
    let report = contour(&bench, "d.vti --level 0.6 -o ball.json --tolerance 0.02", 0);
    let surface = &report["results"]["surface"];
    assert!(surface["kind"] == "sphere" && surface["folds"] == 0, "{surface}");
    let points = "0.5,0.5,1.7\n2.4,0.5,0.5\n0.5,-0.3,0.5\n";
    bench.put("p.csv", format!("x,y,z\n{points}"));
    let run = bench.run("project ball.json p.csv -o feet.csv --quiet");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let column = |name: &str| -> Vec<f64> {
        let text = bench.text(name);
        let place = text.lines().next().unwrap().split(',').position(|c| c == "distance").unwrap();
        text.lines().skip(1).map(|line| line.split(',').nth(place).unwrap().parse().unwrap()).collect()
    };
    for (found, right) in column("feet.csv").iter().zip([0.1f64, 0.8, 0.3]) {
        assert!((found.abs() - right).abs() < 0.02, "{found} {right}");
    }
    // Without a level, the cube itself; there is no proof that its feet are the nearest.
    let run = bench.run("project d.vti p.csv -o feet.csv --mode fast --json -");
    assert_eq!((run.code, &run.report()["model"]["kind"]), (0, &"level_set".into()), "{}", run.stderr);
    for (found, right) in column("feet.csv").iter().zip([0.7, 1.4, 0.3]) {
        assert!((found - right).abs() < 0.01, "{found} {right}");
    }
    let run = bench.run("project d.vti p.csv -o feet.csv");
    assert!(run.code == 1 && run.stderr.contains("--mode fast"), "{} {}", run.code, run.stderr);
    let run = bench.run("inspect d.vti p.csv -t 1");
    assert!(run.code == 2 && run.stderr.contains("indgeo contour"), "{}", run.stderr);
    // Two parts.
    bench.put("a.csv", "x,y,z\n0,0,0\n3,0,0\n");
    let run = bench.run("field a.csv -o two.vti --grid 41x21x21 --box -1,-1,-1,4,1,1 --quiet");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let run = bench.run("contour two.vti --level 0.5 -o two.json");
    assert!(
        run.code == 2 && run.stderr.contains("2 parts") && !bench.path("two.json").exists(),
        "{}",
        run.stderr
    );
}

#[test]
fn noise_is_followed_within_the_tolerance() {
    // A disc in noise, which leaves necks, cusps and bulbs of less than a pixel.
    let noise = |x: f64, y: f64| ((x * 12.9898 + y * 78.233).sin() * 43_758.545_3).fract();
    let step = |r: f64| 120.0 + 60.0 * (6.0 - 0.3 * r).tanh();
    let disc = |x: f64, y: f64| step((x - 40.0).hypot(y - 40.0)) + 300.0 * noise(x, y);
    let bench = Bench::new();
    bench.put("disc.pgm", pgm(80, 80, disc));
    let report = contour(&bench, "disc.pgm -o disc.json --level 120", 0);
    assert!(report["results"]["contours"].as_array().unwrap().len() > 9);
}

#[test]
fn images_are_sources_of_fields() {
    let bench = Bench::new();
    bench.put("ring.pgm", ring());
    let run = bench.run("field ring.pgm -o d.npy --grid 111x71 --signed --json -");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let bytes = bench.read("d.npy");
    let value = |i: usize, j: usize| {
        let at = 128 + 8 * (i * 71 + j);
        f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap())
    };
    // The box is the image, nodes are a pixel apart, y points upwards: the middle of the ring is at (40, 40).
    assert!((value(40, 40) - 10.0).abs() < 0.1 && (value(55, 40) + 5.0).abs() < 0.1);
    assert!((value(70, 40) - 10.0).abs() < 0.1 && (value(85, 50) + 8.0).abs() < 0.1);
}

#[test]
fn bad_images_and_grids_are_refused() {
    let bench = Bench::new();
    let whole = ring();
    let mut npy =
        b"\x93NUMPY\x01\x00\x46\x00{'descr': '<f8', 'fortran_order': False, 'shape': (4, 4), }          \n"
            .to_vec();
    npy.extend((0..16).flat_map(|k| if k == 5 { f64::NAN } else { f64::from(k) }.to_le_bytes()));
    bench.put("flat.pgm", pgm(20, 20, |_, _| 7.0));
    bench.put("one.pgm", pgm(1, 1, |_, _| 7.0));
    bench.put("short.pgm", &whole[..whole.len() / 2]);
    bench.put("short.png", b"\x89PNG\r\n\x1a\n\x00\x00\x00\x0dIHDR\x00\x00");
    bench.put("huge.pgm", "P5 99999999 99999999 255\n");
    bench.put("nan.npy", npy);
    bench.put("text.txt", "hello");
    bench.put("ring.pgm", whole);
    for (arguments, what) in [
        ("flat.pgm -o o.json", "no contrast"),
        ("one.pgm -o o.json", "1 x 1 pixels are too few"),
        ("short.pgm -o o.json", "the file ends"),
        ("short.png -o o.json", "PNG"),
        ("huge.pgm -o o.json", "79999998400000008 bytes"),
        ("nan.npy -o o.json", "value 5 (from 0) is NaN"),
        ("text.txt -o o.json", "no image (PNG, PGM) and no grid"),
        ("ring.pgm -o o.json --level 300", "the level 300 is not between"),
        ("ring.pgm -o o.json --min-area 1e6", "lower --min-area"),
        ("ring.pgm -o o.stl", "choose .json, .svg, .dxf"),
        ("ring.pgm -o o.json --topology fixed", "--topology fixed has no effect"),
        ("ring.pgm -o o.json --start 1,2,3", "--start has no effect"),
        ("ring.pgm -o o.json --method edges --level 3", "--level has no effect"),
        ("ring.pgm -o o.json --method chan-vese --start 500,500,3", "the level set is empty"),
        ("ring.pgm -o o.json --smooth 1000", "option smoothing is 1000"),
        ("ring.pgm -o o.json --picture p.gif", "choose .svg or .png"),
        ("ring.pgm", "nothing would be written"),
    ] {
        let run = bench.run(&format!("contour {arguments}"));
        assert!(run.code == 2 && run.stderr.contains(what), "{arguments}: {} {}", run.code, run.stderr);
        assert!(!bench.path("o.json").exists() && !bench.path("o.stl").exists(), "{arguments}");
    }
    // A tolerance that is not reached: the curves are written, and the status says so.
    let report = contour(&bench, "ring.pgm -o o.json --control-points 6 --tolerance 1e-6", 1);
    assert_eq!(report["status"], "out_of_tolerance");
    assert!(bench.path("o.json").exists());
    let mut names = String::new();
    write!(names, "{:?}", bench.files()).unwrap();
    assert!(!names.contains("tmp"), "{names}");
}

#[test]
fn meshes_are_made_anew_and_fields_are_models() {
    let bench = Bench::new();
    bench.put("cube.off", crate::common::CUBE);
    let run = bench.run("convert cube.off anew.stl --grid 24 --json -");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let report = run.report();
    let chord = report["results"]["chord"].as_f64().unwrap();
    assert!(chord < 0.02 && report["results"]["triangles"].as_u64().unwrap() > 1000, "{report}");
    let run = bench.run("convert cube.off anew.stl --grid 3");
    assert!(run.code == 2 && run.stderr.contains("8 to 2000"), "{}", run.stderr);
    bench.put("points.xyz", "0 0 0\n1 0 0\n");
    let run = bench.run("convert points.xyz o.ply --grid 20");
    assert!(run.code == 2 && run.stderr.contains("none of 2 points has a normal"), "{}", run.stderr);
    bench.put("line.csv", "x,y\n0,0\n1,0\n2,1\n");
    let run = bench.run("convert line.csv o.ply --grid 20");
    assert!(run.code == 2 && run.stderr.contains("--grid has no effect"), "{}", run.stderr);

    // Points on a box, moved by (0.05, -0.04, 0.03): its signed field brings them back.
    let mut box_ = String::from("OFF\n8 6 0\n");
    for k in 0..8u32 {
        let at = |bit: u32, size: f64| if k >> bit & 1 == 1 { size } else { 0.0 };
        writeln!(box_, "{} {} {}", at(2, 1.0), at(1, 1.4), at(0, 0.7)).unwrap();
    }
    box_ += "4 0 1 3 2\n4 4 6 7 5\n4 0 4 5 1\n4 2 3 7 6\n4 0 2 6 4\n4 1 5 7 3\n";
    bench.put("box.off", box_);
    let run = bench.run("field box.off -o box.vti --grid 41x51x33 --signed --quiet");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let mut scan = String::new();
    for k in 0..900u32 {
        let share = |step: f64| (f64::from(k) * step + 0.5).fract();
        let (u, v) = (share(0.754_877_666), share(0.569_840_291));
        let (u, v) = (0.15 + 0.7 * u, 0.15 + 0.7 * v);
        let side = f64::from(k / 3 % 2);
        let p = match k % 3 {
            0 => [side, 1.4 * u, 0.7 * v],
            1 => [u, 1.4 * side, 0.7 * v],
            _ => [u, 1.4 * v, 0.7 * side],
        };
        writeln!(scan, "{} {} {}", p[0] + 0.05, p[1] - 0.04, p[2] + 0.03).unwrap();
    }
    bench.put("scan.xyz", scan);
    let run = bench.run("register box.vti scan.xyz -o moved.xyz --start given --json -");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let report = run.report();
    assert_eq!(report["model"]["kind"], "level_set");
    let back: Vec<f64> = serde_json::from_value(report["results"]["translation"].clone()).unwrap();
    for (found, right) in back.iter().zip([-0.05, 0.04, -0.03]) {
        assert!((found - right).abs() < 1e-3, "{back:?}");
    }
    let run = bench.run("field cube.off -o cube.npy --grid 9x9x9 --signed --quiet");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let run = bench.run("register cube.npy scan.xyz -o moved.xyz");
    assert!(run.code == 2 && run.stderr.contains("does not say where its nodes lie"), "{}", run.stderr);
}
