//! Runs the program as a user does.

#![allow(dead_code, clippy::unwrap_used, reason = "not every test uses everything")]

pub(crate) mod inputs;
pub(crate) mod known;
pub(crate) mod schema;
pub(crate) mod sheets;

use serde_json::Value;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;

/// What a run left behind.
pub(crate) struct Run {
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Run {
    /// The report on standard output.
    pub(crate) fn report(&self) -> Value {
        serde_json::from_str(&self.stdout).unwrap()
    }
}

/// A folder of its own in which the program runs.
pub(crate) struct Bench {
    pub(crate) dir: TempDir,
}

impl Bench {
    pub(crate) fn new() -> Self {
        Self { dir: tempfile::tempdir().unwrap() }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    /// Puts a file into the folder.
    pub(crate) fn put(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).unwrap();
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap()
    }

    pub(crate) fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    /// Names of all files in the folder, sorted.
    pub(crate) fn files(&self) -> Vec<String> {
        let entries = fs::read_dir(self.dir.path()).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Runs the program with arguments separated by blanks.
    pub(crate) fn run(&self, arguments: &str) -> Run {
        self.run_with(arguments, b"")
    }

    /// The same with something on its standard input.
    pub(crate) fn run_with(&self, arguments: &str, input: &[u8]) -> Run {
        let mut child = Command::new(env!("CARGO_BIN_EXE_indgeo"))
            .args(arguments.split_whitespace())
            .current_dir(self.dir.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // A program that does not read it has closed the pipe by now.
        let _ = child.stdin.take().unwrap().write_all(input);
        let output = child.wait_with_output().unwrap();
        let run = Run {
            code: output.status.code().unwrap(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        };
        self.check_reports(arguments, &run);
        run
    }

    /// Every report that was asked for must be as its schema says.
    fn check_reports(&self, arguments: &str, run: &Run) {
        let mut words = arguments.split_whitespace();
        while let Some(word) = words.next() {
            let file = match word.strip_prefix("--json=") {
                Some(file) => file,
                None if word == "--json" => words.next().unwrap_or_default(),
                None => continue,
            };
            let text = match file {
                "-" => run.stdout.clone(),
                file => fs::read_to_string(self.path(file)).unwrap_or_default(),
            };
            // Without a command line that was understood there is no report.
            match serde_json::from_str::<Value>(&text) {
                Ok(report) if report.get("command").is_some() => self.check_report(&report, run.code),
                _ => assert_eq!(run.code, 2, "no report of `{arguments}`: {}", run.stderr),
            }
        }
    }

    /// The report of a command that ended with this exit status must be as its schema says.
    pub(crate) fn check_report(&self, report: &Value, code: i32) {
        let command = report["command"].as_str().unwrap();
        assert_eq!(schema::violations(&schema::of(command), report), Vec::<String>::new(), "{command}");
        assert_eq!(report["exit_code"], code, "{command}");
        let expected = match report["status"].as_str().unwrap() {
            "done" => 0,
            "error" => 2,
            "cancelled" => 130,
            _ => 1,
        };
        assert_eq!(code, expected, "{command}: {}", report["status"]);
        for input in report["inputs"].as_array().unwrap() {
            let count = |name: &str| input[name].as_u64().unwrap();
            assert!(count("points_dropped") + count("points_used") <= count("points_read"), "{input}");
        }
    }
}

/// A file below `fixtures/`.
pub(crate) fn fixture(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures").join(name).to_str().unwrap().to_owned()
}

/// The square [0, 2] × [0, 2] in the plane z = 0, its normal upwards.
pub(crate) const SQUARE: &str = r#"{"kind":"surface","name":"square","degree_u":1,"degree_v":1,"knots_u":[0,0,1,1],
"knots_v":[0,0,1,1],"control_points":[[[0,0,0],[0,2,0]],[[2,0,0],[2,2,0]]],"weights":null}"#;

/// The segment from (0, 0) to (4, 0) in the plane.
pub(crate) const SEGMENT: &str =
    r#"{"kind":"curve","dim":2,"degree":1,"knots":[0,0,1,1],"control_points":[[0,0],[4,0]],"weights":null}"#;

/// The segment from (0, 0, 10) to (4, 0, 10) in space.
pub(crate) const SEGMENT_3: &str = r#"{"kind":"curve","dim":3,"degree":1,"knots":[0,0,1,1],"control_points":[[0,0,10],[4,0,10]],"weights":null}"#;

/// The unit cube, closed, its normals outwards.
pub(crate) const CUBE: &str = "OFF\n8 6 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n\
4 3 2 1 0\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n";

/// The cells of a CSV file, without its header.
pub(crate) fn rows(csv: &str) -> Vec<Vec<String>> {
    csv.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

/// Whether cells are the expected ones, numbers up to rounding.
pub(crate) fn same(cells: &[String], expected: &[&str]) -> bool {
    let alike = |cell: &str, expected: &str| match (cell.parse::<f64>(), expected.parse::<f64>()) {
        (Ok(a), Ok(b)) => (a - b).abs() <= 1e-12 * b.abs().max(1.0),
        _ => cell == expected,
    };
    cells.len() == expected.len() && cells.iter().zip(expected).all(|(cell, expected)| alike(cell, expected))
}
