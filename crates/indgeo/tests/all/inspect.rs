//! `indgeo inspect`: verdicts, files, messages.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common;
use crate::common::schema::violations;
use crate::common::{Bench, CUBE, SEGMENT, SEGMENT_3, SQUARE, rows, same};
use serde_json::Value;

fn bench() -> Bench {
    let bench = Bench::new();
    bench.put("model.json", SQUARE);
    bench.put("points.xyz", "0.5 1 0.03\n1 0.25 -0.0625\n1 1 0.2\n3 1 0\n1 1 9\nnan 0 0\n");
    bench
}

fn schema() -> Value {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/schema/inspect.schema.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

#[test]
fn the_verdict_is_the_exit_status() {
    let bench = bench();
    let base = "inspect model.json points.xyz --max-distance 5 --json -";
    for (options, code, within) in [
        ("--tolerance 0.1", 1, 2),
        ("--tolerance 1", 0, 4),
        ("--tolerance 0.1 --min-share 0.5", 0, 2),
        ("--tolerance 0.1 --min-share 0.51", 1, 2),
        ("--lower -0.05 --upper 0.25", 1, 2),
        ("--tolerance 0.25 --drop-beyond-boundary", 0, 3),
        ("--tolerance 0.1 --upper 0.2 --drop-beyond-boundary", 0, 3),
    ] {
        let run = bench.run(&format!("{base} {options}"));
        assert_eq!(run.code, code, "{options}: {}", run.stderr);
        let report = run.report();
        assert_eq!(violations(&schema(), &report), Vec::<String>::new(), "{options}");
        assert_eq!(report["status"], if code == 0 { "done" } else { "out_of_tolerance" });
        assert_eq!(report["results"]["verdict"]["within"], within, "{options}");
        assert_eq!(report["results"]["verdict"]["pass"], code == 0);
        assert_eq!(report["results"]["outcomes"]["beyond_max_distance"], 1);
        assert_eq!(report["results"]["outcomes"]["invalid_point"], 1);
        assert_eq!(report["results"]["points"], 6);
    }
}

#[test]
fn a_person_reads_the_verdict_too() {
    let bench = bench();
    let run = bench.run("inspect model.json points.xyz --tolerance 0.1 --max-distance 5");
    assert_eq!(run.code, 1);
    assert!(run.stdout.starts_with("FAIL: 2 of 4 points within -0.1 to 0.1 (50.00 %"), "{}", run.stdout);
    assert!(run.stdout.contains("not used  1 beyond_max_distance, 1 invalid_point"), "{}", run.stdout);
    assert!(run.stderr.contains("1 of 6 points has a coordinate that is NaN"), "{}", run.stderr);
    let help = bench.run("inspect --help");
    assert!(help.stdout.contains("Examples:\n  indgeo inspect"), "{}", help.stdout);
}

#[test]
fn files_per_point() {
    let bench = bench();
    let run = bench.run("inspect model.json points.xyz -t 0.1 --max-distance 5 -o out.csv --quiet");
    assert_eq!((run.code, run.stdout.as_str(), run.stderr.as_str()), (1, "", ""));
    let text = bench.text("out.csv");
    let header = "x,y,z,foot_x,foot_y,foot_z,normal_x,normal_y,normal_z,distance,shape,u,v,location,result";
    assert_eq!(text.lines().next(), Some(header));
    let cells = rows(&text);
    let first = [
        "0.5", "1", "0.03", "0.5", "1", "0", "0", "0", "1", "0.03", "0", "0.25", "0.5", "interior", "within",
    ];
    assert!(same(&cells[0], &first), "{text}");
    let results: Vec<&str> = cells.iter().map(|row| row[14].as_str()).collect();
    assert_eq!(results, ["within", "within", "over", "over", "beyond_max_distance", "invalid_point"]);
    assert_eq!(cells[3][13], "edge");

    assert_eq!(bench.run("inspect model.json points.xyz -t 0.1 -o out.ply").code, 1);
    let ply = bench.read("out.ply");
    let end = ply.windows(11).position(|window| window == b"end_header\n").unwrap() + 11;
    let header = String::from_utf8(ply[..end].to_vec()).unwrap();
    for line in [
        "comment result: 0 within, 1 over, 2 under, 3 beyond_max_distance",
        "property double distance",
        "property uchar red",
        "property int shape",
    ] {
        assert!(header.contains(line), "{header}");
    }
    // Twelve doubles, an index, two names, three channels.
    assert_eq!(ply.len() - end, 6 * (12 * 8 + 4 + 2 + 3));
    assert_eq!(bench.run("inspect model.json points.xyz -t 0.1 -o out.json").code, 1);
    let json: Value = serde_json::from_str(&bench.text("out.json")).unwrap();
    assert_eq!((&json["points"], &json["result"][2]), (&6.into(), &"over".into()));
}

#[test]
fn meshes_directions_and_normals() {
    let bench = Bench::new();
    bench.put("cube.off", CUBE);
    bench.put("points.csv", "x,y,z,nx,ny,nz\n0.5,0.5,1.25,0,0,1\n0.5,0.5,0.75,0,0.6,0.8\n0.5,0.5,3,1,0,0\n");
    let run = |options: &str| bench.run(&format!("inspect cube.off points.csv -t 0.5 -o out.csv {options}"));
    let distances =
        || -> Vec<String> { rows(&bench.text("out.csv")).iter().map(|row| row[9].clone()).collect() };
    assert_eq!(run("").code, 1);
    assert_eq!(distances(), ["0.25", "-0.25", "2"]);
    assert!(
        bench.text("out.csv").lines().next().unwrap().contains("distance,shape,triangle,location,result")
    );
    assert_eq!(run("--along normal").code, 0);
    let found = distances();
    assert_eq!((found[0].as_str(), found[2].as_str()), ("0.25", ""));
    assert!((found[1].parse::<f64>().unwrap() + 0.3125).abs() < 1e-15);
    for along in ["--along 0,0,-2", "--direction 0,0,1"] {
        assert_eq!(run(along).code, 1);
        assert_eq!(distances(), ["0.25", "-0.25", "2"], "{along}");
    }
    bench.put("move.json", "{\"matrix\": [[1,0,0,0],[0,1,0,0],[0,0,1,-0.25],[0,0,0,1]]}");
    let moved = run("--transform move.json --json -");
    assert_eq!(distances(), ["0", "-0.5", "1.75"]);
    assert_eq!(violations(&schema(), &moved.report()), Vec::<String>::new());
    assert_eq!(moved.report()["options"]["transform"][2][3], -0.25);
}

#[test]
fn bad_input_and_usage() {
    let bench = bench();
    bench.put("plane.json", SEGMENT);
    bench.put("curve.json", SEGMENT_3);
    bench.put("scan.csv", "x,y,z\n0,0,1\n");
    bench.put("bad.json", "{\"matrix\": [[1,0,0,0],[0,1,0,0],[0,0,-1,0],[0,0,0,1]]}");
    let before = bench.files();
    for (arguments, part) in [
        ("model.json points.xyz", "--tolerance"),
        ("model.json points.xyz --lower -1", "--tolerance <T>"),
        (
            "model.json points.xyz -t 0",
            "invalid value '0' for '--tolerance <T>': it must be a positive length",
        ),
        ("model.json points.xyz -t nan", "'--tolerance <T>': it must be a positive length"),
        ("model.json points.xyz --lower 1 --upper -1", "lower limit must be below"),
        ("model.json points.xyz -t 1 --min-share 2", "--min-share <SHARE>': it must be a share from 0 to 1"),
        ("model.json points.xyz -t 1 --max-distance=-1", "--max-distance <D>': it must be a positive length"),
        ("model.json points.xyz -t 1 --along up", "choose shortest, normal"),
        ("model.json points.xyz -t 1 --along 0,0,0", "a direction X,Y,Z that is not zero"),
        ("model.json points.xyz -t 1 --direction 1,2", "three numbers"),
        ("model.json points.xyz -t 1 --along normal", "the points have no normals; use --along shortest"),
        ("model.json points.xyz -t 1 --transform bad.json", "reflection"),
        ("model.json points.xyz -t 1 --transform points.xyz", "points.xyz: line 1"),
        ("model.json points.xyz -t 1 --report page.pdf", "choose a name that ends in .html"),
        ("model.json points.xyz -t 1 -o out.txt", "choose .csv, .ply, .json"),
        ("model.json scan.csv -t 1 -o scan.csv", "this would overwrite an input"),
        ("plane.json points.xyz -t 1", "the model lies in the plane, but point"),
        ("curve.json points.xyz -t 1 --along 0,0,1", "along the shortest lines only"),
        ("model.json nowhere.xyz -t 1", "check the path"),
    ] {
        let run = bench.run(&format!("inspect {arguments}"));
        assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{arguments}: {}", run.stderr);
        assert!(run.stderr.contains(part), "{arguments}: {}", run.stderr);
    }
    assert_eq!(bench.files(), before);
}

#[test]
fn same_bits_for_any_number_of_threads() {
    let bench = Bench::new();
    let scan = common::fixture("scans/stud-bolt.ply");
    let model = common::fixture("demo/stud-bolt-model.json");
    let run = |threads: u8| {
        let files = format!("-o out{threads}.csv --report page{threads}.html");
        bench.run(&format!("inspect {model} {scan} -t 0.1 --quiet --threads {threads} {files}"));
        (bench.read(&format!("out{threads}.csv")), bench.read(&format!("page{threads}.html")))
    };
    assert!(run(1) == run(3));
}

#[test]
fn the_page_is_self_contained_and_escapes_names() {
    let bench = Bench::new();
    let odd = "a&b<i>'.json";
    bench.put(odd, SQUARE.replace("\"square\"", "\"</script><b>x\""));
    bench.put("points.xyz", "0.5 1 0.03\n1 1 0.2\n");
    let run = bench.run(&format!("inspect {odd} points.xyz -t 0.1 --report page.html --json report.json"));
    assert_eq!(run.code, 1, "{}", run.stderr);
    let page = bench.text("page.html");
    assert!(page.contains("a&amp;b&lt;i&gt;&#39;.json") && !page.contains("<i>"));
    assert!(page.contains("&lt;/script&gt;&lt;b&gt;x"));
    for asking in ["src=", "href=", "url(", "@import", "fetch(\"", "{{"] {
        let ours = page.replace(include_str!("../../../inspection/assets/three.min.js"), "");
        assert!(!ours.contains(asking), "{asking}");
    }
    assert!(page.contains("default-src 'none'"));
    // The report in the page is the one in the file.
    let start = page.find("id=\"report\">").unwrap() + 12;
    let json = &page[start..start + page[start..].find("</script>").unwrap()];
    let inside: Value = serde_json::from_str(json).unwrap();
    let report: Value = serde_json::from_str(&bench.text("report.json")).unwrap();
    for (name, value) in inside.as_object().unwrap() {
        assert_eq!(*value, report["results"][name], "{name}");
    }
}

#[test]
fn profiles_and_curves() {
    let bench = Bench::new();
    bench.put("plane.json", SEGMENT);
    bench.put("curve.json", SEGMENT_3);
    bench.put("flat.xyz", "1 0.25\n2 -0.5\n5 0\n");
    let run =
        bench.run("inspect plane.json flat.xyz -t 0.3 -o out.csv --report page.html --json report.json");
    assert_eq!(run.code, 1, "{}", run.stderr);
    let text = bench.text("out.csv");
    let header = "x,y,foot_x,foot_y,normal_x,normal_y,distance,shape,t,location,result";
    assert_eq!(text.lines().next(), Some(header));
    let cells = rows(&text);
    // Positive on the left of the curve; beyond its end the distance is that of the end.
    let expected = [
        ["1", "0.25", "1", "0", "0", "1", "0.25", "0", "0.25", "interior", "within"],
        ["2", "-0.5", "2", "0", "0", "1", "-0.5", "0", "0.5", "interior", "under"],
        ["5", "0", "4", "0", "0", "1", "1", "0", "1", "edge", "over"],
    ];
    for (row, expected) in cells.iter().zip(expected) {
        assert!(same(row, &expected), "{row:?} {expected:?}");
    }
    let report: Value = serde_json::from_str(&bench.text("report.json")).unwrap();
    assert_eq!(violations(&schema(), &report), Vec::<String>::new());
    assert_eq!((&report["model"]["dimension"], &report["model"]["signed"]), (&2.into(), &true.into()));
    assert_eq!(report["results"]["shapes"][0]["kind"], "curve");
    assert!(bench.text("page.html").contains("</html>"));

    bench.put("space.xyz", "1 0.3 10.4\n2 0 10\n");
    let run = bench.run("inspect curve.json space.xyz -t 0.6 -o out.csv --json -");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let cells = rows(&bench.text("out.csv"));
    assert!(same(&cells[0][9..12], &["0.5", "0", "0.25"]), "{cells:?}");
    assert_eq!(run.report()["model"]["signed"], false);
}
