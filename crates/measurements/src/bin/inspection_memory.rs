//! Measures the largest resident memory of `indgeo inspect` on a generated cloud: binary PLY, three doubles a point.
//!
//! `cargo run --release -p measurements --bin inspection_memory -- [POINTS]`; Linux only, since it reads the mark that
//! the kernel keeps of a process (`VmHWM` in `/proc`). The program is built by cargo first.

#![allow(clippy::print_stdout, reason = "a measuring program prints")]

use std::fs::{self, File};
use std::io::{BufWriter, Error, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Points of a cloud near the unit torus tube, in an order that jumps about.
fn write_cloud(path: &Path, count: u64) -> Result<(), Error> {
    let mut out = BufWriter::new(File::create(path)?);
    write!(out, "ply\nformat binary_little_endian 1.0\nelement vertex {count}\n")?;
    write!(out, "property double x\nproperty double y\nproperty double z\nend_header\n")?;
    let share = |i: u64, step: f64| (i as f64 * step).fract();
    for i in 0..count {
        let z = 0.2 * share(i, 0.732_050_807_568_877) - 0.1;
        for value in [2.0 * share(i, 0.618_033_988_749_895), 2.0 * share(i, 0.414_213_562_373_095), z] {
            out.write_all(&value.to_le_bytes())?;
        }
    }
    out.flush()
}

/// Runs the program; its largest resident memory in bytes.
fn peak(program: &Path, folder: &Path, arguments: &[&str]) -> Result<u64, Error> {
    let mut child = Command::new(program)
        .args(arguments)
        .current_dir(folder)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()?;
    let mut peak = 0;
    loop {
        let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
        let mark = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kilobytes = mark.and_then(|mark| mark.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok());
        peak = peak.max(1024 * kilobytes.unwrap_or(0));
        if let Some(status) = child.try_wait()? {
            return match status.code() {
                Some(0 | 1) => Ok(peak),
                _ => Err(Error::other(format!("{arguments:?}: {status}"))),
            };
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn main() -> Result<(), Error> {
    let count: u64 = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(10_000_000);
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let built = Command::new(cargo)
        .args(["build", "--release", "--quiet", "--package", "indgeo", "--bin", "indgeo"])
        .current_dir(&root)
        .status()?;
    if !built.success() {
        return Err(Error::other("the program could not be built"));
    }
    // Beside this program.
    let own = std::env::current_exe()?;
    let program = own.parent().map(|folder| folder.join("indgeo"));
    let program = program.ok_or_else(|| Error::other("the program is not where cargo puts it"))?;
    let folder = std::env::temp_dir().join(format!("indgeo-memory-{}", std::process::id()));
    fs::create_dir_all(&folder)?;
    let measured = measure(&program, &folder, count);
    fs::remove_dir_all(&folder)?;
    measured
}

fn measure(program: &Path, folder: &Path, count: u64) -> Result<(), Error> {
    fs::write(folder.join("mesh.off"), "OFF\n4 2 0\n0 0 0\n2 0 0\n2 2 0\n0 2 0\n3 0 1 2\n3 0 2 3\n")?;
    let square = r#"{"kind":"surface","degree_u":1,"degree_v":1,"knots_u":[0,0,1,1],"knots_v":[0,0,1,1],
        "control_points":[[[0,0,0],[0,2,0]],[[2,0,0],[2,2,0]]],"weights":null}"#;
    fs::write(folder.join("surface.json"), square)?;
    write_cloud(&folder.join("cloud.ply"), count)?;
    let size = fs::metadata(folder.join("cloud.ply"))?.len();
    println!(
        "{count} points, file of {:.1} bytes a point; largest resident memory, bytes a point:",
        size as f64 / count as f64
    );
    for model in ["mesh.off", "surface.json"] {
        for options in [&[][..], &["-o", "out.ply"], &["-o", "out.csv"], &["--report", "page.html"]] {
            let arguments: Vec<&str> = ["inspect", model, "cloud.ply", "-t", "0.05"]
                .into_iter()
                .chain(options.iter().copied())
                .collect();
            let bytes = peak(program, folder, &arguments)?;
            println!("{model:<13} {:<18} {:>6.1}", options.join(" "), bytes as f64 / count as f64);
        }
    }
    Ok(())
}
