//! Files as people have them, through the program: names, paths, outputs that collide, models of other programs.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use serde_json::Value;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: impl AsRef<OsStr>) -> PathBuf {
        self.0.path().join(name.as_ref())
    }

    fn write(&self, name: impl AsRef<OsStr>, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, content).unwrap();
        path
    }

    fn read(&self, name: &str) -> String {
        String::from_utf8(std::fs::read(self.path(name)).unwrap()).unwrap()
    }

    fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).unwrap()
    }

    /// Runs the program in the folder.
    fn run<S: AsRef<OsStr>>(&self, arguments: &[S]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_indgeo"));
        command.current_dir(self.0.path()).args(arguments).output().unwrap()
    }

    fn code<S: AsRef<OsStr>>(&self, arguments: &[S]) -> i32 {
        self.run(arguments).status.code().unwrap()
    }
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

const SURFACE: &str = r#"{"kind":"surface","degree_u":1,"degree_v":1,"knots_u":[0,0,1,1],"knots_v":[0,0,1,1],
    "control_points":[[[0,0,0],[0,1,0]],[[1,0,0],[1,1,0]]]}"#;
const NAMED: &str = "name;x;y;z\nbore 1;0,1;0,2;0,9\n\"bore 2, left\";0,2;0,1;-0,8\n";

/// A prism over a polygon, binary STL; the sides begin at `z`, the base at 0.
fn prism(outline: &[[f32; 2]], height: f32, z: f32) -> Vec<u8> {
    let n = outline.len();
    let p = |i: usize, z: f32| [outline[i % n][0], outline[i % n][1], z];
    let mut triangles = Vec::new();
    for i in 1..n - 1 {
        triangles.push([p(0, 0.0), p(i + 1, 0.0), p(i, 0.0)]);
        triangles.push([p(0, height), p(i, height), p(i + 1, height)]);
    }
    for i in 0..n {
        triangles.push([p(i, z), p(i + 1, z), p(i + 1, height)]);
        triangles.push([p(i, z), p(i + 1, height), p(i, height)]);
    }
    let mut data = vec![b' '; 80];
    data.extend(u32::try_from(triangles.len()).unwrap().to_le_bytes());
    for corners in triangles {
        data.extend([0; 12]);
        corners.iter().flatten().for_each(|value| data.extend(value.to_le_bytes()));
        data.extend([0; 2]);
    }
    data
}

fn column(csv: &str, name: &str) -> Vec<f64> {
    let mut lines = csv.lines();
    let place = lines.next().unwrap().split(',').position(|column| column == name).unwrap();
    lines.map(|line| line.split(',').nth(place).unwrap().parse().unwrap()).collect()
}

#[test]
fn solids_with_rounding_beside_zero_have_sides() {
    let dir = Folder::new();
    dir.write("box.stl", prism(&[[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]], 2.0, -2.5e-16));
    dir.write("points.xyz", "2 1.5 -0.25\n2 1.5 0.25\n4.5 1.5 0\n2 1.5 1.5\n-0.1 1.5 0\n0.1 1.5 1\n");
    let info = stdout(&dir.run(&["info", "box.stl"]));
    assert!(
        info.contains("is closed             yes") && info.contains("volume                24"),
        "{info}"
    );
    assert_eq!(dir.code(&["project", "box.stl", "points.xyz", "-o", "a.csv"]), 0);
    for (found, right) in
        column(&dir.read("a.csv"), "distance").iter().zip([0.25, -0.25, 0.5, -0.5, 0.1, -0.1])
    {
        assert!((found - right).abs() < 1e-12, "{found} {right}");
    }
    // Points before the sharp edge of a wedge lie outside, on whatever face the nearest point is.
    let tip = 20f32.to_radians();
    dir.write(
        "wedge.stl",
        prism(&[[0.0, 0.0], [3.0 * tip.cos(), -3.0 * tip.sin()], [3.0, 0.0]], 2.0, 2.5e-16),
    );
    let before: String = (0..7).map(|i| format!("-0.2 0 {}\n", 0.25 * f64::from(i))).collect();
    dir.write("edge.xyz", before);
    assert_eq!(dir.code(&["inspect", "wedge.stl", "edge.xyz", "-t", "1", "-o", "b.csv"]), 0);
    for distance in column(&dir.read("b.csv"), "distance") {
        assert!((distance - 0.2).abs() < 1e-7, "{distance}");
    }
}

#[test]
fn names_of_points_come_back() {
    let dir = Folder::new();
    dir.write("model.json", SURFACE);
    dir.write("named.csv", NAMED);
    assert_eq!(
        dir.code(&["project", "model.json", "named.csv", "-o", "p.csv", "--json", "p.report.json"]),
        0
    );
    let lines: Vec<String> = dir.read("p.csv").lines().map(str::to_owned).collect();
    assert!(lines[0].ends_with(",status,lower_bound,name"), "{}", lines[0]);
    assert!(lines[1].ends_with(",bore 1") && lines[2].ends_with(",\"bore 2, left\""), "{lines:?}");
    let report = dir.json("p.report.json");
    assert_eq!(report["results"]["worst"]["name"], "bore 1");
    assert_eq!(report["results"]["columns"].as_array().unwrap().last().unwrap(), "name");
    assert_eq!(dir.code(&["project", "model.json", "named.csv", "-o", "p.json"]), 0);
    assert_eq!(dir.json("p.json")["name"], serde_json::json!(["bore 1", "bore 2, left"]));
    let inspect = [
        "inspect",
        "model.json",
        "named.csv",
        "-t",
        "1",
        "-o",
        "i.ply",
        "--json",
        "i.report.json",
        "--report",
        "i.html",
    ];
    let output = dir.run(&inspect);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stdout(&output).contains("at point 0 (from 0) \"bore 1\""), "{}", stdout(&output));
    assert_eq!(dir.json("i.report.json")["results"]["worst"][1]["name"], "bore 2, left");
    assert!(dir.read("i.html").contains("bore 2, left"));
    // What was written is read again with its names, and converted.
    assert_eq!(dir.code(&["convert", "i.ply", "back.csv"]), 0);
    let back = dir.read("back.csv");
    assert!(back.lines().next().unwrap().ends_with(",name") && back.contains("\"bore 2, left\""), "{back}");
    assert_eq!(dir.code(&["convert", "named.csv", "named.xyz"]), 0);
    assert_eq!(
        dir.read("named.xyz"),
        "# x y z name\n0.1 0.2 0.9 \"bore 1\"\n0.2 0.1 -0.8 \"bore 2, left\"\n"
    );
    // Points without names have the columns they always had.
    dir.write("plain.xyz", "0.1 0.2 0.9\n");
    assert_eq!(dir.code(&["project", "model.json", "plain.xyz", "-o", "q.csv"]), 0);
    assert!(dir.read("q.csv").lines().next().unwrap().ends_with(",status,lower_bound"));
}

#[test]
fn decimal_commas_between_blanks_need_an_option() {
    let dir = Folder::new();
    dir.write("a.xyz", "1,5 2,25 3,0\n2,5 3,25 -4,125\n");
    let output = dir.run(&["info", "a.xyz"]);
    assert!(
        output.status.code() == Some(2) && stderr(&output).contains("--decimal-comma"),
        "{}",
        stderr(&output)
    );
    assert_eq!(dir.code(&["info", "a.xyz", "--decimal-comma"]), 0);
    assert_eq!(dir.code(&["convert", "a.xyz", "b.csv", "--decimal-comma"]), 0);
    assert_eq!(dir.read("b.csv"), "x,y,z\n1.5,2.25,3\n2.5,3.25,-4.125\n");
}

#[test]
fn models_of_other_programs_are_projected_onto() {
    let dir = Folder::new();
    let patch = "v 0 0 0\nv 0 2 1\nv 0 4 1\nv 0 6 0\nv 2 0 1\nv 2 2 2\nv 2 4 2\nv 2 6 1\nv 4 0 1\nv 4 2 2\nv 4 4 2\nv 4 6 1\n\
        v 6 0 0\nv 6 2 1\nv 6 4 1\nv 6 6 0\ncstype bspline\ndeg 3 3\nsurf 0 1 0 1 1 5 9 13 2 6 10 14 3 7 11 15 4 8 12 16\n\
        parm u 0 0 0 0 1 1 1 1\nparm v 0 0 0 0 1 1 1 1\nend\n";
    dir.write("patch.obj", patch);
    dir.write("points.xyz", "3 3 3\n1 1 0\n");
    let output = dir.run(&["project", "patch.obj", "points.xyz", "-o", "a.csv"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let found = dir.read("a.csv");
    for (name, right) in [("distance", [1.5, 0.745_411]), ("u", [0.5, 0.125_556]), ("v", [0.5, 0.125_556])] {
        for (value, right) in column(&found, name).iter().zip(right) {
            assert!((value.abs() - right).abs() < 1e-6, "{name}: {value}");
        }
    }
    dir.write(
        "circle.json",
        r#"{"shape":{"type":"curve","count":1,"data":[{"type":"spline","rational":true,"dimension":2,"degree":2,
        "knotvector":[0,0,0,1,1,1],"control_points":{"points":[[1,0],[1,1],[0,1]],"weights":[1,0.7071067811865476,1]}}]}}"#,
    );
    dir.write("plane.xyz", "0.5 0.5\n2 2\n");
    assert_eq!(dir.code(&["project", "circle.json", "plane.xyz", "-o", "b.csv"]), 0);
    for (value, right) in column(&dir.read("b.csv"), "distance").iter().zip([0.292_893, 1.828_427]) {
        assert!((value.abs() - right).abs() < 1e-6, "{value}");
    }
    // As NURBS JSON they are the same.
    assert_eq!(dir.code(&["convert", "patch.obj", "patch.json"]), 0);
    assert_eq!(dir.code(&["project", "patch.json", "points.xyz", "-o", "c.csv"]), 0);
    assert_eq!(dir.read("c.csv"), found);
}

#[test]
fn info_tells_of_all_files_that_it_can_read() {
    let dir = Folder::new();
    dir.write("a.xyz", "1 2 3\n");
    dir.write("c.xyz", "4 5 6\n");
    let output = dir.run(&["info", "a.xyz", "bad.xyz", "c.xyz", "--json", "r.json"]);
    assert_eq!(output.status.code(), Some(2));
    let (out, err) = (stdout(&output), stderr(&output));
    assert!(out.contains("a.xyz") && out.contains("c.xyz"), "{out}");
    assert!(err.contains("error: bad.xyz: cannot read"), "{err}");
    let report = dir.json("r.json");
    assert_eq!((&report["status"], &report["exit_code"]), (&"error".into(), &2.into()));
    let results = report["results"].as_array().unwrap();
    assert_eq!((&results[0]["points"], &results[2]["points"]), (&1.into(), &1.into()));
    assert!(results[1]["error"].as_str().unwrap().contains("bad.xyz"));
    let output = dir.run(&["info", "bad.xyz", "worse.xyz"]);
    assert_eq!((output.status.code(), stderr(&output).matches("error: ").count()), (Some(2), 2));
}

#[cfg(unix)]
#[test]
fn names_of_files_need_not_be_utf_8() {
    use std::os::unix::ffi::OsStrExt;
    let dir = Folder::new();
    let bad = dir.write(OsStr::from_bytes(b"bad\xff.xyz"), "0.1 0.2 0.9\n");
    dir.write("model.json", SURFACE);
    let info = dir.run(&[OsStr::new("info"), bad.as_os_str(), OsStr::new("--json"), OsStr::new("info.json")]);
    assert_eq!(info.status.code(), Some(0), "{}", stderr(&info));
    assert!(dir.json("info.json")["results"][0]["path"].as_str().unwrap().contains("bad\u{fffd}.xyz"));
    let out = dir.path(OsStr::from_bytes(b"out\xfe.csv"));
    let words = ["project", "model.json"].map(OsStr::new).into_iter().chain([bad.as_os_str()]);
    let words = words
        .chain(["-o"].map(OsStr::new))
        .chain([out.as_os_str()])
        .chain(["--json", "p.json"].map(OsStr::new));
    let output = dir.run(&words.collect::<Vec<_>>());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let report = dir.json("p.json");
    assert!(report["inputs"][1]["path"].as_str().unwrap().ends_with("bad\u{fffd}.xyz"));
    assert!(report["outputs"][0]["path"].as_str().unwrap().ends_with("out\u{fffd}.csv") && out.exists());
}

#[cfg(unix)]
#[test]
fn no_two_outputs_are_one_file() {
    let dir = Folder::new();
    dir.write("model.json", SURFACE);
    let scan = dir.write("scan.xyz", "0.1 0.2 0.9\n0.5 0.5 0.5\n0.7 0.1 0.3\n");
    std::fs::create_dir(dir.path("sub")).unwrap();
    std::os::unix::fs::symlink(dir.path("y.ply"), dir.path("link.ply")).unwrap();
    std::os::unix::fs::symlink(&scan, dir.path("scan-link.csv")).unwrap();
    std::os::unix::fs::symlink(dir.path("sub"), dir.path("folder")).unwrap();
    let refused: [&[&str]; 9] = [
        &["register", "model.json", "scan.xyz", "--transform", "y.ply", "-o", "y.ply"],
        &["register", "model.json", "scan.xyz", "--transform", "y.ply", "-o", "link.ply"],
        &["register", "model.json", "scan.xyz", "--transform", "folder/../sub/t.json", "-o", "folder/t.json"],
        &["register", "model.json", "scan.xyz", "--transform", "scan-link.csv"],
        &["inspect", "model.json", "scan.xyz", "-t", "1", "-o", "i.csv", "--report", "./i.csv"],
        &["inspect", "model.json", "scan.xyz", "-t", "1", "-o", "i.csv", "--json", "i.csv"],
        &["project", "model.json", "scan.xyz", "-o", "scan-link.csv"],
        &["parameterize", "scan.xyz", "-o", "a.json", "--params", "sub/../a.json"],
        &["convert", "scan.xyz", "scan.xyz"],
    ];
    for words in refused {
        let output = dir.run(words);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {}", stderr(&output));
        let message = stderr(&output);
        let said = ["two outputs", "overwrite an input", "the output as well"]
            .iter()
            .any(|part| message.contains(part));
        assert!(said, "{words:?}: {message}");
    }
    for name in ["y.ply", "i.csv", "a.json", "sub/t.json"] {
        assert!(!dir.path(name).exists(), "{name}");
    }
    assert_eq!(std::fs::read(&scan).unwrap(), b"0.1 0.2 0.9\n0.5 0.5 0.5\n0.7 0.1 0.3\n");
    // The report tells of the refusal.
    assert_eq!(
        dir.code(&["register", "model.json", "scan.xyz", "--transform", "y", "-o", "y", "--json", "r.json"]),
        2
    );
    assert_eq!(dir.json("r.json")["status"], "error");
    // A device may take several.
    let null = ["inspect", "model.json", "scan.xyz", "-t", "1", "--report", "/dev/null.html"];
    assert_ne!(dir.code(&null), 101);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_on_standard_output_is_an_error() {
    let dir = Folder::new();
    dir.write("a.xyz", "1 2 3\n");
    if !Path::new("/dev/full").exists() {
        return;
    }
    for words in [["info", "a.xyz"].as_slice(), &["info", "a.xyz", "--json", "-"]] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_indgeo"));
        let output = command.current_dir(dir.0.path()).args(words).stdout(full).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{words:?}");
        assert!(
            stderr(&output).contains("standard output") || stderr(&output).contains("cannot write"),
            "{}",
            stderr(&output)
        );
    }
}
