//! Files of scanners through the commands: choices of scans, results in their formats, inspection piece by piece.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::{Bench, SQUARE, fixture};
use serde_json::Value;

/// Two triangles over the square [0, 2] × [0, 2].
const MESH: &str = "OFF\n4 2 0\n0 0 0\n2 0 0\n2 2 0\n0 2 0\n3 0 1 2\n3 0 2 3\n";

/// Points near the square, with normals; of every hundredth the height is not a number if `broken` says so.
fn cloud(count: u32, broken: bool) -> Vec<u8> {
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex COUNT\nproperty double x\nproperty double y\n\
                  property double z\nproperty double nx\nproperty double ny\nproperty double nz\nend_header\n";
    let mut bytes = header.replace("COUNT", &count.to_string()).into_bytes();
    let share = |i: u32, step: f64| (f64::from(i) * step).fract();
    for i in 0..count {
        let z = if broken && i % 100 == 7 { f64::NAN } else { 0.2 * share(i, 0.732_050_807_568_877) - 0.1 };
        let (x, y) = (2.0 * share(i, 0.618_033_988_749_895), 2.0 * share(i, 0.414_213_562_373_095));
        for value in [x, y, z, 0.0, 0.6, 0.8] {
            bytes.extend(value.to_le_bytes());
        }
    }
    bytes
}

fn report(bench: &Bench, name: &str) -> Value {
    serde_json::from_str(&bench.text(name)).unwrap()
}

#[test]
fn an_inspection_in_pieces_is_that_of_the_whole() {
    let bench = Bench::new();
    bench.put("mesh.off", MESH);
    bench.put("square.json", SQUARE);
    bench.put("large.ply", cloud(300_000, false));
    bench.put("broken.ply", cloud(3000, true));
    bench.put("small.ply", cloud(3000, false));
    for name in ["small.las", "small.laz", "small.e57"] {
        assert_eq!(bench.run(&format!("convert small.ply {name}")).code, 0, "{name}");
    }
    bench.put("turn.json", r#"{"matrix":[[1,0,0,0.1],[0,1,0,0.2],[0,0,1,0.01],[0,0,0,1]]}"#);
    for (model, points, options) in [
        ("mesh.off", "large.ply", ""),
        ("square.json", "small.las", ""),
        ("square.json", "small.laz", "--transform turn.json"),
        ("square.json", "small.e57", "--max-angle 30"),
        ("square.json", "small.e57", "--along normal --max-distance 0.05"),
        ("square.json", "broken.ply", ""),
        ("square.json", "broken.ply", "--drop-non-finite --max-angle 40"),
    ] {
        let command = format!("inspect {model} {points} -t 0.05 --min-share 0.1 {options}");
        let pieces = bench.run(&format!("{command} --json a.json"));
        // A row per point needs all points in memory.
        let whole = bench.run(&format!("{command} --json b.json -o rows.csv"));
        assert_eq!((pieces.code, &pieces.stderr), (whole.code, &whole.stderr), "{command}");
        let (pieces, whole) = (report(&bench, "a.json"), report(&bench, "b.json"));
        for part in ["status", "inputs", "model", "options", "results", "warnings"] {
            assert_eq!(pieces[part], whole[part], "{command}: {part}");
        }
        assert!(pieces["results"]["points"].as_u64().unwrap() > 2000, "{command}");
    }
    // The same reasons to refuse.
    for (options, part) in [
        ("inspect square.json rows.las -t 1", "rows.las"),
        ("inspect square.json small.las -t 1 --scan 1", "does not tell scans apart"),
        ("inspect square.json small.e57 -t 1 --scan 5", "the scans are"),
    ] {
        let run = bench.run(options);
        assert!(run.code == 2 && run.stderr.contains(part), "{options}: {}", run.stderr);
    }
}

#[test]
fn results_go_into_formats_of_scanners() {
    let bench = Bench::new();
    bench.put("square.json", SQUARE);
    bench.put("points.xyz", "0.25 0.5 0.125\n1 1 -0.5\n3 1 0\n");
    for (command, column) in [
        ("project square.json points.xyz -o", "distance"),
        ("inspect square.json points.xyz -t 0.2 -o", "distance"),
    ] {
        assert!(bench.run(&format!("{command} rows.csv")).code < 2);
        let rows = bench.text("rows.csv");
        let names: Vec<&str> = rows.lines().next().unwrap().split(',').collect();
        let place = names.iter().position(|name| *name == column).unwrap();
        let expected: Vec<f64> =
            rows.lines().skip(1).map(|row| row.split(',').nth(place).unwrap().parse().unwrap()).collect();
        for name in ["rows.las", "rows.laz", "rows.e57"] {
            assert!(bench.run(&format!("{command} {name}")).code < 2, "{command} {name}");
            assert_eq!(bench.run(&format!("convert {name} back.csv")).code, 0);
            let back = bench.text("back.csv");
            let names: Vec<&str> = back.lines().next().unwrap().split(',').collect();
            assert_eq!(&names[..3], ["x", "y", "z"]);
            let place = names.iter().position(|name| *name == column).unwrap();
            let found: Vec<f64> =
                back.lines().skip(1).map(|row| row.split(',').nth(place).unwrap().parse().unwrap()).collect();
            assert_eq!(found, expected, "{command} {name}");
        }
        let run = bench.run(&format!("{command} rows.glb"));
        assert!(run.code < 2 && run.stderr.contains("cannot hold"), "{}", run.stderr);
        assert_eq!(&bench.read("rows.glb")[..4], b"glTF");
    }
}

#[test]
fn scans_are_chosen_and_listed() {
    let bench = Bench::new();
    bench.put("scans.e57", std::fs::read(fixture("formats/e57/two_scans.e57")).unwrap());
    let info = bench.run("info scans.e57 --json -").report();
    let scans = &info["results"][0]["scans"];
    assert_eq!(
        (&scans[0]["name"], &scans[1]["name"], &scans[1]["index"]),
        (&"front".into(), &"rear side".into(), &1.into())
    );
    assert_eq!(scans[1]["pose"][0][3], -4.25);
    let text = bench.run("info scans.e57").stdout;
    assert!(text.contains("scan 1 \"rear side\""), "{text}");
    for (options, points) in [("", 120), ("--scan all", 120), ("--scan front", 60), ("--scan 1", 60)] {
        let run = bench.run(&format!("convert scans.e57 out.ply {options} --json -"));
        assert_eq!(run.report()["results"]["points"], points, "{options}");
    }
    let both = bench.run("convert scans.e57 out.ply");
    assert!(both.stderr.contains("2 scans were put together, moved by their poses"), "{}", both.stderr);
    let before = bench.files();
    let run = bench.run("convert scans.e57 other.ply --scan left");
    assert!(run.code == 2 && run.stderr.contains("0 \"front\", 1 \"rear side\""), "{}", run.stderr);
    // A damaged file leaves nothing behind.
    let mut data = bench.read("scans.e57");
    data[3000] ^= 1;
    bench.put("scans.e57", data);
    for name in ["a.laz", "a.e57", "a.ply"] {
        let run = bench.run(&format!("convert scans.e57 {name}"));
        assert!(run.code == 2 && run.stderr.contains("page 2"), "{}", run.stderr);
    }
    assert_eq!(bench.files(), before);
}

#[test]
fn messages_name_all_formats() {
    let bench = Bench::new();
    bench.put("odd.bin", b"\x01\x02\x03\x04");
    let run = bench.run("convert odd.bin out.ply");
    for name in ["LAS", "LAZ", "E57", "STEP", "IGES", "PTX"] {
        assert!(run.stderr.contains(name), "{}", run.stderr);
    }
    let run = bench.run("convert odd.bin out.docx");
    assert_eq!(run.code, 2);
    bench.put("points.xyz", "1 2 3\n");
    let run = bench.run("convert points.xyz out.docx");
    for name in ["las", "laz", "e57", "glb"] {
        assert!(run.stderr.contains(name), "{}", run.stderr);
    }
}
