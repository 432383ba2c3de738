//! Scans of thin walls: measured on the face that their normals tell, and what is said where nothing can be told.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::{Bench, SEGMENT, SEGMENT_3, rows};
use serde_json::Value;

/// A closed sheet of 100 × 60 × 0.5, its top at z = 0.
const SHEET: &str = "OFF\n8 6 0\n0 0 -0.5\n100 0 -0.5\n100 60 -0.5\n0 60 -0.5\n0 0 0\n100 0 0\n100 60 0\n0 60 0\n\
4 3 2 1 0\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n";

/// Points of its top; two of them lie nearer to the bottom.
const TOP: &str = "x,y,z,nx,ny,nz\n20,30,0.02,0,0,1\n40,30,-0.05,0,0,1\n50,30,-0.46,0,0,1\n55,25,-0.48,0,0,1\n\
60,30,-0.1,0,0,1\n80,30,0.03,0,0,1\n";

/// The same sheet as six bilinear surfaces, their normals outwards.
fn faces() -> String {
    let face = |corners: [[f64; 3]; 4]| {
        let [a, b, c, d] = corners.map(|corner| format!("{corner:?}"));
        format!(
            "{{\"kind\":\"surface\",\"degree_u\":1,\"degree_v\":1,\"knots_u\":[0,0,1,1],\"knots_v\":[0,0,1,1],\
             \"control_points\":[[{a},{b}],[{c},{d}]],\"weights\":null}}"
        )
    };
    let at = |x: f64, y: f64, z: f64| [100.0 * x, 60.0 * y, 0.5 * z - 0.5];
    let shapes = [
        [at(0., 0., 1.), at(0., 1., 1.), at(1., 0., 1.), at(1., 1., 1.)],
        [at(0., 0., 0.), at(1., 0., 0.), at(0., 1., 0.), at(1., 1., 0.)],
        [at(0., 0., 0.), at(0., 0., 1.), at(1., 0., 0.), at(1., 0., 1.)].map(|p| p),
        [at(0., 1., 0.), at(1., 1., 0.), at(0., 1., 1.), at(1., 1., 1.)].map(|p| p),
        [at(0., 0., 0.), at(0., 1., 0.), at(0., 0., 1.), at(0., 1., 1.)].map(|p| p),
        [at(1., 0., 0.), at(1., 0., 1.), at(1., 1., 0.), at(1., 1., 1.)].map(|p| p),
    ];
    // Whatever the order of the corners, the normal points away from the middle.
    let outwards = |[a, b, c, d]: [[f64; 3]; 4]| {
        let edge = |to: [f64; 3]| [to[0] - a[0], to[1] - a[1], to[2] - a[2]];
        let (u, v) = (edge(c), edge(b));
        let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let out: f64 = (0..3).map(|i| normal[i] * (a[i] + d[i] - [100.0, 60.0, -0.5][i])).sum();
        if out > 0.0 { [a, b, c, d] } else { [a, c, b, d] }
    };
    let shapes = shapes.map(|corners| face(outwards(corners))).join(",");
    format!("{{\"kind\":\"model\",\"shapes\":[{shapes}]}}")
}

fn bench() -> Bench {
    let bench = Bench::new();
    bench.put("sheet.off", SHEET);
    bench.put("faces.json", faces());
    bench.put("scan.csv", TOP);
    bench
}

fn column(bench: &Bench, name: &str) -> Vec<String> {
    let text = bench.text("out.csv");
    let place = text.lines().next().unwrap().split(',').position(|other| other == name).unwrap();
    rows(&text).iter().map(|row| row[place].clone()).collect()
}

fn distances(bench: &Bench) -> Vec<f64> {
    column(bench, "distance").iter().map(|cell| cell.parse().unwrap_or(f64::NAN)).collect()
}

fn assert_near(found: &[f64], expected: &[f64], what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-9 || a.is_nan() && b.is_nan();
    assert!(found.iter().zip(expected).all(near), "{what}: {found:?}");
}

#[test]
fn a_scan_is_judged_by_the_face_it_was_scanned_from() {
    let bench = bench();
    let right = [0.02, -0.05, -0.46, -0.48, -0.10, 0.03];
    for model in ["sheet.off", "faces.json"] {
        let run = |options: &str| {
            bench.run(&format!("inspect {model} scan.csv -t 0.12 -o out.csv --json - {options}"))
        };
        for options in ["--along normal", "--max-angle 60", "--max-angle 90", "--along 0,0,1 --max-angle 90"]
        {
            let found = run(options);
            assert_eq!(found.code, 1, "{model} {options}: {}", found.stderr);
            assert_near(&distances(&bench), &right, &format!("{model} {options}"));
            assert!(column(&bench, "normal_z").iter().all(|z| z.parse::<f64>() == Ok(1.0)));
            let results = &found.report()["results"];
            assert_eq!((&results["total"]["under"], &results["restricted"]), (&2.into(), &2.into()));
            assert!(results["options"]["max_angle"].is_number());
        }
        // Without the option, and where sides mean nothing, the nearest face counts.
        for options in ["", "--along normal --max-angle 180", "--max-angle 180", "--along 0,0,1"] {
            assert_eq!(run(options).code, 0, "{model} {options}");
            assert_near(&distances(&bench), &[0.02, -0.05, -0.04, -0.02, -0.10, 0.03], options);
        }
    }
}

#[test]
fn below_the_back_a_point_is_still_measured_from_the_front() {
    let bench = bench();
    bench.put(
        "scan.csv",
        "x,y,z,nx,ny,nz\n50,30,-0.6,0,0,1\n50,30,-0.6,0,0,-2\n0.1,30,-0.3,0,0,1\n-0.1,30,-0.3,0,0,1\n",
    );
    for model in ["sheet.off", "faces.json"] {
        bench.run(&format!("inspect {model} scan.csv -t 0.12 --max-angle 45 -o out.csv"));
        let expected = [-0.6, 0.1, -0.3, -0.1f64.hypot(0.3)];
        assert_near(&distances(&bench), &expected, model);
    }
}

#[test]
fn points_without_a_normal_or_a_foot_are_told_apart() {
    let bench = bench();
    let top = TOP.lines().take(2).collect::<Vec<_>>().join("\n");
    bench.put("scan.csv", format!("{top}\n20,20,0.01,0,0,0\n20,25,0.01,nan,0,1\nnan,0,0,0,0,1\n"));
    for (model, options) in [
        ("sheet.off", "--max-angle 45"),
        ("faces.json", "--max-angle 45"),
        ("sheet.off", "--along normal"),
        ("faces.json", "--along 0,0,1 --max-angle 10"),
    ] {
        let run = bench.run(&format!("inspect {model} scan.csv -t 0.12 {options} -o out.csv --json -"));
        assert_eq!(run.code, 0, "{model} {options}: {}", run.stderr);
        assert_eq!(
            column(&bench, "result"),
            ["within", "no_normal", "no_normal", "invalid_point"],
            "{model}"
        );
        assert!(
            run.stderr.contains("2 of 4 points have a normal that is zero or not finite"),
            "{}",
            run.stderr
        );
        assert_eq!(run.report()["results"]["verdict"]["judged"], 1);
    }
    // Nothing faces sideways at 45 degrees upwards: the points count as out of tolerance.
    bench.put("scan.csv", "x,y,z,nx,ny,nz\n20,30,0.02,0,1,1\n20,30,0.02,0,0,1\n");
    for (model, options) in [
        ("sheet.off", "--max-angle 30"),
        ("faces.json", "--max-angle 30"),
        ("sheet.off", "--along 0,0,1 --max-angle 30"),
        ("faces.json", "--along 0,0,1 --max-angle 30"),
    ] {
        let run =
            bench.run(&format!("inspect {model} scan.csv -t 0.12 {options} -o out.csv --report page.html"));
        assert_eq!(run.code, 1, "{model} {options}");
        assert_eq!(column(&bench, "result"), ["no_matching_foot", "within"], "{model} {options}");
        assert!(run.stdout.starts_with("FAIL: 1 of 2 points within"), "{}", run.stdout);
        assert!(run.stdout.contains("not within 1 no_matching_foot"), "{}", run.stdout);
        assert!(run.stderr.contains("have no foot on the model with a normal that agrees"), "{}", run.stderr);
        assert!(bench.text("page.html").contains("no foot with a matching normal"));
        let share = "--min-share 0.5";
        assert_eq!(bench.run(&format!("inspect {model} scan.csv -t 0.12 {options} {share}")).code, 0);
    }
    // A crossing that agrees, but farther away than points that are used.
    bench.put("scan.csv", "x,y,z,nx,ny,nz\n20,30,-0.45,0,0,1\n");
    for model in ["sheet.off", "faces.json"] {
        let options = "--along normal --max-distance 0.3 -o out.csv";
        assert_eq!(bench.run(&format!("inspect {model} scan.csv -t 0.12 {options}")).code, 1);
        assert_eq!(column(&bench, "result"), ["beyond_max_distance"], "{model}");
    }
}

#[test]
fn normals_that_point_inwards_are_noticed() {
    let bench = bench();
    bench.put("scan.csv", TOP.replace("0,0,1\n", "0,0,-1\n"));
    let run = bench.run("inspect sheet.off scan.csv -t 0.12 --along normal");
    assert_eq!(run.code, 1);
    assert!(
        run.stderr.contains("turn them if they point inwards, or give --max-angle 180"),
        "{}",
        run.stderr
    );
}

#[test]
fn what_has_no_normals_refuses_the_option() {
    let bench = bench();
    bench.put("plane.json", SEGMENT);
    bench.put("curve.json", SEGMENT_3);
    bench.put("flat.csv", "x,y,z,nx,ny,nz\n1,0.1,0,0,1,0\n2,0.1,0,0,1,0\n3,0.2,0,0,1,0\n");
    bench.put("bare.csv", "x,y,z\n1,0.1,0\n2,0.1,0\n3,0.3,0\n");
    bench.put("torn.off", SHEET.replace("4 4 5 6 7", "4 7 6 5 4"));
    let before = bench.files();
    for (arguments, part) in [
        ("inspect sheet.off bare.csv -t 1 --max-angle 60", "the points have no normals"),
        ("inspect plane.json flat.csv -t 1 --max-angle 60", "curves have no normals"),
        ("inspect curve.json flat.csv -t 1 --max-angle 60", "curves have no normals"),
        ("inspect torn.off scan.csv -t 1 --max-angle 60", "disagree on the side of their normals"),
        ("inspect sheet.off scan.csv -t 1 --max-angle 0", "above 0, at most 180"),
        ("inspect sheet.off scan.csv -t 1 --max-angle 181", "above 0, at most 180"),
        ("inspect sheet.off scan.csv -t 1 --max-angle nan", "above 0, at most 180"),
        ("project sheet.off bare.csv -o out.csv --max-angle 60", "the points have no normals"),
        (
            "project curve.json flat.csv -o out.csv --max-angle 60",
            "the model has curves, which have no normals",
        ),
        ("project torn.off scan.csv -o out.csv --max-angle 60", "disagree on the side of their normals"),
        ("register sheet.off bare.csv -o out.ply --max-angle 60", "the points have no normals"),
        (
            "register curve.json flat.csv -o out.ply --max-angle 60",
            "the model has curves, which have no normals",
        ),
        ("register bare.csv flat.csv -o out.ply --max-angle 60", "the model is a cloud without normals"),
        ("register torn.off scan.csv -o out.ply --max-angle 60", "disagree on the side of their normals"),
    ] {
        let run = bench.run(arguments);
        assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{arguments}: {}", run.stderr);
        assert!(run.stderr.contains(part), "{arguments}: {}", run.stderr);
    }
    assert_eq!(bench.files(), before);
    // Along normals of a mesh that has no sides, the nearest crossing in either sense counts, as without the option.
    assert_eq!(bench.run("inspect torn.off scan.csv -t 0.12 --along normal").code, 0);
}

#[test]
fn projection_takes_the_same_option() {
    let bench = bench();
    bench.put("scan.csv", format!("{TOP}1,1,1,0,0,0\n2,2,0.1,0,1,1\n"));
    for model in ["sheet.off", "faces.json"] {
        let run = bench.run(&format!("project {model} scan.csv -o out.csv --max-angle 30 --json -"));
        assert_eq!(run.code, 1, "{model}: {}", run.stderr);
        let nan = f64::NAN;
        assert_near(&distances(&bench), &[0.02, -0.05, -0.46, -0.48, -0.10, 0.03, nan, nan], model);
        assert_eq!(column(&bench, "status")[6..], ["no_normal", "no_matching_foot"]);
        let status = &run.report()["results"]["status"];
        assert_eq!((&status["no_normal"], &status["no_matching_foot"]), (&1.into(), &1.into()));
        assert_eq!(bench.run(&format!("project {model} scan.csv -o out.ply --max-angle 30")).code, 1);
        let header = String::from_utf8_lossy(&bench.read("out.ply")[..600]).into_owned();
        assert!(header.contains("no_matching_foot"), "{header}");
    }
    let run = bench.run("project sheet.off scan.csv -o out.csv --max-angle 180");
    assert_eq!(run.code, 0, "{}", run.stderr);
}

/// The top of a sheet, shifted beyond the middle of the wall: points are drawn to the bottom unless normals are looked at.
#[test]
fn registration_takes_the_same_option() {
    let bench = bench();
    let mut scan = String::from("x,y,z,nx,ny,nz\n");
    let mut state = 7u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    // Sides, too, so that the position is determined.
    for _ in 0..400 {
        let (x, y, z) = (100.0 * next(), 60.0 * next(), 0.5 * next() - 0.5);
        scan.push_str(&format!("{x},{y},-0.2,0,0,1\n{x},0,{},0,-1,0\n0,{y},{},-1,0,0\n", z - 0.2, z - 0.2));
        scan.push_str(&format!("{x},{y},-0.2,0,0,0\n"));
    }
    bench.put("scan.csv", scan);
    let options = "--start given --outliers none --transform t.json";
    let run = bench.run(&format!("register sheet.off scan.csv {options} --max-angle 60"));
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    assert!(run.stderr.contains("400 points have a normal that is zero or not finite"), "{}", run.stderr);
    let motion: Value = serde_json::from_str(&bench.text("t.json")).unwrap();
    let shift = motion["matrix"][2][3].as_f64().unwrap();
    assert!((shift - 0.2).abs() < 1e-6, "{motion}");
}

#[test]
fn a_cad_sheet_is_judged_by_the_face_it_was_scanned_from() {
    let bench = bench();
    assert_eq!(bench.run("convert faces.json sheet.step --unit mm").code, 0);
    let right = [0.02, -0.05, -0.46, -0.48, -0.10, 0.03];
    let found = bench.run("inspect sheet.step scan.csv -t 0.12 -o out.csv --json - --max-angle 60");
    assert_eq!(found.code, 1, "{}", found.stderr);
    assert_near(&distances(&bench), &right, "inspect");
    assert!(column(&bench, "normal_z").iter().all(|z| z.parse::<f64>() == Ok(1.0)));
    let results = &found.report()["results"];
    assert_eq!((&results["total"]["under"], &results["restricted"]), (&2.into(), &2.into()));
    assert_eq!(bench.run("inspect sheet.step scan.csv -t 0.12 -o out.csv").code, 0);
    let run = bench.run("project sheet.step scan.csv -o out.csv --max-angle 60");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert_near(&distances(&bench), &right, "project");
    // Beside the sheet the front ends at its edge; no face looks into a slanting direction.
    bench.put(
        "scan.csv",
        "x,y,z,nx,ny,nz\n-0.1,30,-0.3,0,0,1\n50,30,-0.6,0,0,-2\n50,30,0.1,1,1,1\n50,30,0.1,0,0,0\n",
    );
    let run = bench.run("project sheet.step scan.csv -o out.csv --max-angle 45");
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert_near(&distances(&bench), &[-0.1f64.hypot(0.3), 0.1, f64::NAN, f64::NAN], "beside");
    assert_eq!(column(&bench, "status")[2..], ["no_matching_foot", "no_normal"]);
}
