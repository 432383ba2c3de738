//! STEP and IGES files that `convert` and the fits write.

use crate::common::{Bench, SEGMENT, SQUARE, fixture, rows};

#[test]
fn nurbs_become_cad_files_with_name_and_unit() {
    let bench = Bench::new();
    bench.put("square.json", SQUARE);
    let run = bench.run("convert square.json square.step --unit inch --json -");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let report = run.report();
    assert_eq!((&report["results"]["format"], &report["results"]["shapes"]), (&"step".into(), &1.into()));
    assert_eq!(report["warnings"].as_array().unwrap().len(), 0);
    let text = bench.text("square.step");
    for part in [
        "ISO-10303-21;",
        "PRODUCT('square','square'",
        "ADVANCED_FACE('square'",
        "'INCH'",
        "END-ISO-10303-21;",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    // Without a unit it is said; a name that is typed wins.
    let run = bench.run("convert square.json square.igs --name plate");
    assert!(run.code == 0 && run.stderr.contains("written as mm; --unit"), "{}", run.stderr);
    let text = bench.text("square.igs");
    assert!(text.contains("5Hplate") && text.contains("2HMM"), "{text}");
    // From IGES to STEP nothing but the format changes.
    let run = bench.run("convert square.igs again.step --json -");
    assert_eq!((run.code, run.report()["inputs"][0]["format"].as_str()), (0, Some("igs")), "{}", run.stderr);
    assert!(bench.text("again.step").contains("PRODUCT('plate','plate'"));
    // The format may be named, and go to standard output.
    let run = bench.run("convert square.json - --format step --unit m");
    assert!(run.code == 0 && run.stdout.starts_with("ISO-10303-21;"), "{}", run.stderr);
    let again = bench.run("convert square.json - --format step --unit m");
    assert_eq!(run.stdout, again.stdout);
    // Curves in the plane lie in z = 0.
    bench.put("segment.json", SEGMENT);
    let run = bench.run("convert segment.json segment.stp --unit mm");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(bench.text("segment.stp").contains("CARTESIAN_POINT('',(4.,0.,0.))"));
}

#[test]
fn what_has_no_effect_or_cannot_be_is_refused() {
    let bench = Bench::new();
    bench.put("square.json", SQUARE);
    bench.put("cloud.xyz", "0 0 0\n1 0 0\n0 1 0\n");
    assert_eq!(bench.run("convert square.json square.igs --unit mm").code, 0);
    let cases = [
        ("convert square.json other.json --unit mm", "--unit has no effect"),
        ("convert square.json other.json --name x", "--name has no effect"),
        ("convert square.json other.step --unit furlong", "choose mm, cm"),
        ("convert cloud.xyz other.step", "fit a surface first"),
        ("convert square.igs other.step --unit m", "state no unit; this one is in mm"),
        ("fit-surface cloud.xyz -o other.json --unit mm", "--unit has no effect"),
        ("fit-curve cloud.xyz --points-out f.csv --name x", "--name has no effect without -o"),
    ];
    for (arguments, what) in cases {
        let run = bench.run(arguments);
        assert!(run.code == 2 && run.stderr.contains(what), "{arguments}: {} {}", run.code, run.stderr);
    }
    assert_eq!(bench.files(), ["cloud.xyz", "square.igs", "square.json"]);
    // A damaged file is named with line and entity.
    let damaged = bench.text("square.igs").replacen("128,", "12x,", 1);
    bench.put("damaged.igs", damaged);
    let run = bench.run("convert damaged.igs other.step");
    assert!(
        run.code == 2 && run.stderr.contains("damaged.igs:") && run.stderr.contains("entity"),
        "{}",
        run.stderr
    );
}

#[test]
fn faces_that_are_not_read_are_no_success() {
    let bench = Bench::new();
    let arcs = fixture("cad/example-arcs.iges");
    let run = bench.run(&format!("convert {arcs} arcs.step --json -"));
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert_eq!(run.report()["outputs"][0]["content"], "3 curves");
    // The arc becomes an entity of a type that does not exist.
    let text = std::fs::read_to_string(&arcs).unwrap();
    let text =
        text.replace("     100       ", "     199       ").replace("100,0.,0.,0.,19.8", "199,0.,0.,0.,19.8");
    bench.put("odd.igs", text);
    let run = bench.run("convert odd.igs odd.step --json report.json");
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert!(
        run.stderr.contains("type 199") && run.stdout.contains("not read: 1 shape"),
        "{}{}",
        run.stderr,
        run.stdout
    );
}

#[test]
fn fits_are_written_as_cad_files() {
    let bench = Bench::new();
    let wave: String = (0..400)
        .map(|k| {
            let (x, y) = (f64::from(k % 20) / 2.0, f64::from(k / 20) / 2.0);
            format!("{x} {y} {}\n", (0.5 * x).sin() + 0.1 * y)
        })
        .collect();
    bench.put("wave.xyz", wave);
    for (out, mark) in [("wave.step", "ADVANCED_FACE('hill'"), ("wave.igs", "4Hhill")] {
        let run =
            bench.run(&format!("fit-surface wave.xyz -o {out} --control-points 6x6 --unit mm --name hill"));
        assert!(run.code <= 1, "{}", run.stderr);
        assert!(bench.text(out).contains(mark), "{out}");
    }
    // What is written as JSON and converted is the same.
    let run = bench.run("fit-surface wave.xyz -o wave.json --control-points 6x6 --name hill");
    assert!(run.code <= 1, "{}", run.stderr);
    assert!(bench.text("wave.json").contains("\"hill\""));
    assert_eq!(bench.run("convert wave.json again.step --unit mm --name hill").code, 0);
    assert_eq!(bench.text("again.step"), bench.text("wave.step"));
    let run = bench.run("fit-ruled wave.xyz -o ruled.step --control-points 6x2 --unit mm");
    assert!(run.code <= 1 && bench.text("ruled.step").contains("PRODUCT('ruled'"), "{}", run.stderr);
    let line: String = (0..60).map(|k| format!("{} {} 0\n", k, f64::from(k * k) * 0.01)).collect();
    bench.put("line.xyz", line);
    let run = bench.run("fit-curve line.xyz -o line.stp --unit mm");
    assert!(run.code <= 1 && bench.text("line.stp").contains("GEOMETRIC_CURVE_SET('line'"), "{}", run.stderr);
}

#[test]
fn cad_models_become_closed_meshes() {
    let bench = Bench::new();
    let part = fixture("cad/nema-17-bracket.step");
    for name in ["part.stl", "part.ply", "part.obj", "part.off"] {
        let run = bench.run(&format!("convert {part} {name} --chord 0.02 --json -"));
        assert_eq!(run.code, 0, "{}", run.stderr);
        let report = run.report();
        assert_eq!(report["results"]["chord"], 0.02);
        assert!(report["results"]["triangles"].as_u64().unwrap() > 1000);
        assert!(report["warnings"][0].as_str().unwrap().contains("coordinates are in mm"), "{report}");
    }
    // Every vertex of the mesh lies on the part, every point of the part within the tolerance of the mesh.
    assert_eq!(bench.run(&format!("project {part} part.ply -o feet.csv")).code, 0);
    let far = rows(&bench.text("feet.csv"))
        .iter()
        .map(|row| row[6].parse::<f64>().unwrap().abs())
        .fold(0.0, f64::max);
    assert!(far < 1e-6, "{far}");
    let info = bench.run("info part.ply --json -");
    assert!(info.report().to_string().contains("\"is_closed\":true"), "{}", info.stdout);
    let run = bench.run(&format!("convert {part} part.json"));
    assert!(run.code == 2 && run.stderr.contains("choose step, igs, or stl"), "{}", run.stderr);
    let run = bench.run(&format!("convert {part} part.igs --chord 1"));
    assert!(run.code == 2 && run.stderr.contains("--chord has no effect"), "{}", run.stderr);
    assert!(!bench.path("part.igs").exists() && !bench.path("part.json").exists());
}

#[test]
fn what_was_written_is_a_model_and_a_start_of_fits() {
    let bench = Bench::new();
    let points: String = (0..900)
        .map(|k| {
            let (x, y) = (f64::from(k % 30) / 3.0, f64::from(k / 30) / 3.0);
            format!("{x} {y} {}\n", 0.3 * (0.5 * x).sin())
        })
        .collect();
    bench.put("points.xyz", &points);
    let run = |arguments: &str| {
        let run = bench.run(arguments);
        assert_eq!(run.code, 0, "{arguments}: {}{}", run.stdout, run.stderr);
        run
    };
    run("fit-surface points.xyz -o surface.step --tolerance 0.01 --unit mm");
    run("fit-surface points.xyz --init surface.step -o again.step --unit mm");
    run("fit-surface --model surface.step -o model.step --unit mm");
    // A cylinder over a wave is ruled.
    run("fit-ruled surface.step -o ruled.igs --tolerance 0.02 --unit mm");
    let line: String =
        (0..80).map(|k| format!("{} {} 1\n", f64::from(k) * 0.1, (f64::from(k) * 0.1).sin())).collect();
    bench.put("line.xyz", &line);
    run("fit-curve line.xyz -o curve.step --unit mm");
    run("fit-curve line.xyz --init curve.step -o curve2.step --unit mm");
    run("fit-curve --model curve.step -o curve3.igs --unit mm");
}
