//! Bad input: exit status 2, a message that says where and what to do, and nothing left behind.

use crate::common::{Bench, SEGMENT, SEGMENT_3, SQUARE};

/// Runs a command that must fail and returns its message. The folder must look as before.
fn failure(bench: &Bench, arguments: &str) -> String {
    let before = bench.files();
    let run = bench.run(arguments);
    assert_eq!(run.code, 2, "{arguments}: {}", run.stderr);
    assert_eq!(run.stdout, "", "{arguments}");
    assert!(run.stderr.starts_with("error: "), "{arguments}: {}", run.stderr);
    assert_eq!(bench.files(), before, "{arguments}");
    run.stderr
}

fn bench() -> Bench {
    let bench = Bench::new();
    bench.put("model.json", SQUARE);
    bench.put("points.xyz", "0 0 1\n1 1 1\n");
    bench
}

#[test]
fn missing_and_unreadable_files() {
    let bench = bench();
    let message = failure(&bench, "project model.json nowhere.xyz -o out.csv");
    assert!(message.starts_with("error: nowhere.xyz: cannot read: "), "{message}");
    assert!(message.ends_with("; check the path\n"), "{message}");
    let message = failure(&bench, "project model.json . -o out.csv");
    assert!(message.contains("this is a folder, name a file in it"), "{message}");
}

#[test]
fn outputs_that_cannot_be_written() {
    let bench = bench();
    let message = failure(&bench, "project model.json points.xyz -o no/such/folder/out.csv");
    assert!(message.ends_with("; create the folder first\n"), "{message}");
    let message = failure(&bench, "project model.json points.xyz -o out.txt");
    assert_eq!(
        message,
        "error: out.txt: results are not written as `.txt`; choose .csv, .ply, .json, .las, .laz, .e57 or .glb, or add --format\n"
    );
    let message = failure(&bench, "project model.json points.xyz -o out");
    assert!(message.contains("the name has no extension"), "{message}");
    assert!(failure(&bench, "convert points.xyz out.docx").contains("out.docx"));

    bench.put("scan.csv", "x,y,z\n0,0,1\n");
    let message = failure(&bench, "project model.json scan.csv -o scan.csv");
    assert!(message.contains("this would overwrite an input; choose another name"), "{message}");
    assert_eq!(bench.text("scan.csv"), "x,y,z\n0,0,1\n");

    // The report is an output too.
    for (report, part) in
        [("scan.csv", "an input"), ("model.json", "an input"), ("./out.csv", "the output as well")]
    {
        let message = failure(&bench, &format!("project model.json scan.csv -o out.csv --json {report}"));
        assert!(message.contains(part), "{message}");
    }
    assert!(failure(&bench, "info scan.csv --json scan.csv").contains("this would overwrite an input"));
    assert_eq!(bench.text("scan.csv"), "x,y,z\n0,0,1\n");
    let message = failure(&bench, "project - - -o out.csv");
    assert!(message.contains("standard input (`-`) is named twice"), "{message}");

    std::fs::create_dir(bench.path("out.csv")).unwrap_or_default();
    let message = failure(&bench, "project model.json points.xyz -o out.csv");
    assert!(message.contains("this is a folder"), "{message}");
}

#[cfg(unix)]
#[test]
fn folders_without_permission() {
    use std::fs;
    use std::os::unix::fs::PermissionsExt;
    let bench = bench();
    let folder = bench.path("locked");
    fs::create_dir(&folder).unwrap_or_default();
    let _ = fs::set_permissions(&folder, fs::Permissions::from_mode(0o555));
    // The administrator may write anywhere; then there is nothing to be seen here.
    if fs::write(folder.join("probe"), "").is_err() {
        let message = failure(&bench, "project model.json points.xyz -o locked/out.csv");
        assert!(message.ends_with("; choose a folder you may write to\n"), "{message}");
    }
    let _ = fs::set_permissions(&folder, fs::Permissions::from_mode(0o755));
}

#[test]
fn damaged_files_are_named_with_their_line() {
    let bench = bench();
    bench.put("bad.xyz", "0 0 1\n1 one 1\n");
    let message = failure(&bench, "project model.json bad.xyz -o out.csv");
    assert!(message.starts_with("error: bad.xyz:2: "), "{message}");
    assert!(message.contains("; "), "{message}");

    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 1000000000000\n\
                  property double x\nproperty double y\nproperty double z\nend_header\n";
    bench.put("short.ply", format!("{header}12345678"));
    let message = failure(&bench, "project model.json short.ply -o out.csv");
    assert!(message.contains("short.ply") && message.contains("truncated"), "{message}");

    bench.put("knots.json", SQUARE.replace("\"knots_u\":[0,0,1,1]", "\"knots_u\":[0,0,1,-1]"));
    let message = failure(&bench, "project knots.json points.xyz -o out.csv");
    assert!(message.starts_with("error: knots.json:"), "{message}");
    assert!(message.contains("knot 3 is smaller than its predecessor"), "{message}");
}

#[test]
fn inputs_in_the_wrong_place() {
    let bench = bench();
    let message = failure(&bench, "project points.xyz model.json -o out.csv");
    assert!(
        message.contains("a model is needed") && message.contains("the order is MODEL POINTS"),
        "{message}"
    );
    let message = failure(&bench, "project model.json model.json -o out.csv");
    assert!(message.contains("points are needed, but this file holds NURBS"), "{message}");
}

#[test]
fn dimensions_that_do_not_fit() {
    let bench = bench();
    bench.put("plane.json", SEGMENT);
    bench.put("flat.csv", "x,y\n1,2\n");
    let message = failure(&bench, "project model.json flat.csv -o out.csv");
    assert!(message.contains("two columns only; give points of three columns"), "{message}");
    let message = failure(&bench, "project plane.json points.xyz -o out.csv");
    assert!(message.contains("point 0 (from 0) has z = 1"), "{message}");
    bench.put("mixed.json", format!("{{\"kind\":\"model\",\"shapes\":[{SEGMENT},{SEGMENT_3}]}}"));
    let message = failure(&bench, "project mixed.json points.xyz -o out.csv");
    assert!(message.contains("shapes in the plane: 1, in space: 1"), "{message}");
    bench.put("none.json", "{\"kind\":\"model\",\"shapes\":[]}");
    assert!(failure(&bench, "project none.json points.xyz -o out.csv").contains("no shapes"));
}

#[test]
fn points_that_are_none() {
    let bench = bench();
    bench.put("empty.xyz", "");
    assert!(failure(&bench, "project model.json empty.xyz -o out.csv").contains("empty"));
    bench.put("header.csv", "x,y,z\n");
    assert!(failure(&bench, "project model.json header.csv -o out.csv").contains("header.csv"));
    bench.put("nan.xyz", "nan 0 0\n0 inf 0\n");
    let message = failure(&bench, "project model.json nan.xyz -o out.csv");
    assert!(message.contains("no point has finite coordinates (2 points)"), "{message}");
    failure(&bench, "project model.json nan.xyz -o out.csv --drop-non-finite");
}

#[test]
fn usage() {
    let bench = bench();
    for (arguments, part) in [
        ("", "Usage"),
        ("project model.json", "Usage"),
        ("projct model.json points.xyz -o out.csv", "project"),
        ("project model.json points.xyz -o out.csv --threads 0", "--threads"),
        ("project model.json points.xyz -o out.csv --mode best", "certified"),
        ("project model.json points.xyz -o out.csv --relative-gap 2", "--relative-gap is 2"),
        ("project model.json points.xyz -o out.csv --relative-gap nan", "it must be a finite number"),
    ] {
        let run = bench.run(arguments);
        assert_eq!(run.code, 2, "{arguments}");
        assert!(run.stderr.contains(part), "{arguments}: {}", run.stderr);
    }
    assert_eq!(bench.files(), ["model.json", "points.xyz"]);
}

#[test]
fn an_old_result_survives_a_failure() {
    let bench = bench();
    bench.put("out.csv", "precious");
    failure(&bench, "project model.json nowhere.xyz -o out.csv");
    assert_eq!(bench.text("out.csv"), "precious");
}

/// A program that waits for its input is told to stop.
#[cfg(unix)]
#[test]
fn an_interrupt_leaves_nothing_behind() {
    use std::io::Read;
    use std::process::{Command, Stdio};
    let bench = Bench::new();
    for signal in ["INT", "TERM"] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_indgeo"))
            .args(["convert", "-", "points.csv"])
            .current_dir(bench.path(""))
            .stdin(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // Until the program has set its handler, the signal ends it at once; ask it until it answers itself.
        let asked = std::time::Instant::now();
        let status = loop {
            std::thread::sleep(std::time::Duration::from_millis(200));
            let kill = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status();
            assert!(kill.unwrap().success());
            std::thread::sleep(std::time::Duration::from_millis(100));
            if let Some(status) = child.try_wait().unwrap() {
                break status;
            }
            assert!(asked.elapsed().as_secs() < 20, "it goes on");
        };
        let mut message = String::new();
        child.stderr.take().unwrap().read_to_string(&mut message).unwrap();
        assert_eq!(
            (status.code(), message.as_str()),
            (Some(130), "interrupted: no output was written\n"),
            "{signal}"
        );
        assert_eq!(bench.files(), Vec::<String>::new());
    }
}
