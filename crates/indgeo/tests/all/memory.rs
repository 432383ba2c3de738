//! The memory that an inspection takes.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::{Bench, SQUARE};
use std::process::{Command, Stdio};
use std::time::Duration;

/// Runs the program and returns its largest resident memory in bytes, looked at every few milliseconds.
fn peak(bench: &Bench, arguments: &str) -> u64 {
    let mut child = Command::new(env!("CARGO_BIN_EXE_indgeo"))
        .args(arguments.split_whitespace())
        .current_dir(bench.dir.path())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut peak = 0;
    loop {
        // The mark never falls, and is gone when the process is.
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
        let mark = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kilobytes = mark.and_then(|mark| mark.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok());
        peak = peak.max(1024 * kilobytes.unwrap_or(0));
        if let Some(status) = child.try_wait().unwrap() {
            assert!(status.code().is_some_and(|code| code < 2), "{arguments}: {status}");
            return peak;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// A million points near the square as binary PLY with doubles.
fn cloud(count: u32) -> Vec<u8> {
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex COUNT\nproperty double x\nproperty double y\n\
                  property double z\nend_header\n";
    let mut bytes = header.replace("COUNT", &count.to_string()).into_bytes();
    let share = |i: u32, step: f64| (f64::from(i) * step).fract();
    for i in 0..count {
        let z = 0.2 * share(i, 0.732_050_807_568_877) - 0.1;
        for value in [2.0 * share(i, 0.618_033_988_749_895), 2.0 * share(i, 0.414_213_562_373_095), z] {
            bytes.extend(value.to_le_bytes());
        }
    }
    bytes
}

/// What does not grow with the cloud (the program, its threads, rounds of points under way) is the part for one point.
#[test]
fn a_point_takes_at_most_a_hundred_bytes() {
    const COUNT: u32 = 1_000_000;
    let bench = Bench::new();
    bench.put("square.json", SQUARE);
    bench.put("mesh.off", "OFF\n4 2 0\n0 0 0\n2 0 0\n2 2 0\n0 2 0\n3 0 1 2\n3 0 2 3\n");
    bench.put("cloud.ply", cloud(COUNT));
    bench.put("few.ply", cloud(1));
    for options in ["", "-o out.ply", "-o out.ply --report page.html"] {
        let fixed = peak(&bench, &format!("inspect mesh.off few.ply -t 0.05 --threads 2 {options}"));
        let all = peak(&bench, &format!("inspect mesh.off cloud.ply -t 0.05 --threads 2 {options}"));
        // The page holds up to a million points as text, whatever the size of the cloud.
        let page = if options.contains("--report") { 45 } else { 0 };
        let limit = u64::from(COUNT) * (100 + page) + (40 << 20);
        assert!(all - fixed < limit, "{options}: {} bytes a point", (all - fixed) / u64::from(COUNT));
    }
    let all = peak(&bench, "inspect square.json cloud.ply -t 0.05 --mode fast --threads 2 -o out.ply");
    assert!(all < u64::from(COUNT) * 100 + (60 << 20), "{} bytes a point", all / u64::from(COUNT));
}
