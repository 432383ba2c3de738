//! A command that is told to stop leaves nothing half-written behind, and its report says so.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::fixture;
use crate::common::inputs::bench;
use serde_json::Value;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Waits until the program answers signals itself.
fn wait_for_handler(child: &Child) {
    let asked = Instant::now();
    // The mask of caught signals; bit 1 is that of SIGINT.
    let caught = |status: &str| {
        let mask = status.lines().find_map(|line| line.strip_prefix("SigCgt:"))?;
        u64::from_str_radix(mask.trim(), 16).ok()
    };
    while asked.elapsed() < Duration::from_secs(20) {
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
        if caught(&status).is_some_and(|mask| mask & 2 != 0) {
            // The command itself begins right after.
            std::thread::sleep(Duration::from_millis(100));
            return;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Every command that waits for an input, or works for a while, is told to stop.
#[test]
fn an_interrupt_is_reported_by_every_command() {
    let bench = bench();
    let pipe = |path: &Path| assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
    pipe(&bench.path("pipe.xyz"));
    for folder in ["data", "data/scans", "data/demo"] {
        std::fs::create_dir(bench.path(folder)).unwrap();
    }
    for file in ["scans/stud-bolt.ply", "demo/stud-bolt-placement.json"] {
        std::fs::copy(fixture(file), bench.path("data").join(file)).unwrap();
    }
    pipe(&bench.path("data/demo/stud-bolt-model.json"));
    let cases = [
        ("project", "model.json - -o out.csv", 1),
        ("inspect", "model.json - -t 1 -o out.csv --report out.html", 1),
        ("register", "cube.off - -o out.ply --transform out.json", 1),
        ("register-views", "left.xyz pipe.xyz -o out", 1),
        ("fit-curve", "- -o out.json", 0),
        ("parameterize", "- -o out.json", 0),
        ("fit-surface", "- -o out.json", 0),
        ("fit-ruled", "- -o out.json", 0),
        ("fit-subdivision", "- -o out.obj", 0),
        ("convert", "- out.ply", 0),
        ("info", "points.xyz -", 1),
        ("demo", "--data data --out out", 0),
        ("selftest", "", 0),
    ];
    for (number, (command, arguments, inputs)) in cases.into_iter().enumerate() {
        let signal = ["INT", "TERM", "HUP"][number % 3];
        let child = Command::new(env!("CARGO_BIN_EXE_indgeo"))
            .arg(command)
            .args(arguments.split_whitespace())
            .args(["--json", "report.json"])
            .current_dir(bench.path(""))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        wait_for_handler(&child);
        let kill = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status();
        assert!(kill.unwrap().success());
        // Standard input stays open: it is the signal that ends the program.
        let mut child = child;
        let input = child.stdin.take();
        let output = child.wait_with_output().unwrap();
        drop(input);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(130), "{command}: {stderr}");
        assert!(stderr.contains("interrupted: "), "{command}: {stderr}");
        let report: Value = serde_json::from_str(&bench.text("report.json")).unwrap();
        bench.check_report(&report, 130);
        assert_eq!((&report["command"], &report["status"]), (&command.into(), &"cancelled".into()));
        assert_eq!(report["inputs"].as_array().unwrap().len(), inputs, "{command}");
        assert_eq!(report["outputs"], serde_json::json!([]), "{command}");
        assert!(report["results"].is_null(), "{command}");
        std::fs::remove_file(bench.path("report.json")).unwrap();
        let left: Vec<String> = bench
            .files()
            .into_iter()
            .filter(|name| name.starts_with("out.") || name.contains(".tmp"))
            .collect();
        assert_eq!(left, Vec::<String>::new(), "{command}");
    }
}
