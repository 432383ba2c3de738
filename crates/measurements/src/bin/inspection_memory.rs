//! Measures the largest resident memory of `indgeo inspect` on a generated cloud: binary PLY with three doubles a point, and LAS.
//!
//! `cargo run --release -p measurements --bin inspection_memory -- [POINTS [PROGRAM]]`; Linux only, since it reads the mark that
//! the kernel keeps of a process (`VmHWM` in `/proc`). Without PROGRAM the program is built by cargo first.

#![allow(clippy::print_stdout, reason = "a measuring program prints")]

use std::fs::{self, File};
use std::io::{BufWriter, Error, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Coordinates of a point near a square, in an order that jumps about.
fn point(i: u64) -> [f64; 3] {
    let share = |step: f64| (i as f64 * step).fract();
    let z = 0.2 * share(0.732_050_807_568_877) - 0.1;
    [2.0 * share(0.618_033_988_749_895), 2.0 * share(0.414_213_562_373_095), z]
}

/// The cloud as LAS 1.2 with points of format 0, in steps of 1e-6.
#[expect(clippy::cast_possible_truncation, reason = "coordinates are at most 2 million steps")]
fn write_las(path: &Path, count: u64) -> Result<(), Error> {
    let number = u32::try_from(count).map_err(Error::other)?;
    let mut header = vec![0u8; 227];
    header[..4].copy_from_slice(b"LASF");
    (header[24], header[25]) = (1, 2);
    header[94..96].copy_from_slice(&227u16.to_le_bytes());
    header[96..100].copy_from_slice(&227u32.to_le_bytes());
    header[105..107].copy_from_slice(&20u16.to_le_bytes());
    header[107..111].copy_from_slice(&number.to_le_bytes());
    header[111..115].copy_from_slice(&number.to_le_bytes());
    let places = [131, 139, 147]
        .map(|at| (at, 1e-6))
        .into_iter()
        .chain([179, 195].map(|at| (at, 2.0)))
        .chain([(211, 0.1), (219, -0.1)]);
    for (at, value) in places {
        header[at..at + 8].copy_from_slice(&f64::to_le_bytes(value));
    }
    let mut out = BufWriter::new(File::create(path)?);
    out.write_all(&header)?;
    for i in 0..count {
        let mut record = [0u8; 20];
        for (axis, value) in point(i).into_iter().enumerate() {
            record[4 * axis..4 * axis + 4].copy_from_slice(&((value * 1e6).round() as i32).to_le_bytes());
        }
        out.write_all(&record)?;
    }
    out.flush()
}

/// The cloud as binary PLY.
fn write_cloud(path: &Path, count: u64) -> Result<(), Error> {
    let mut out = BufWriter::new(File::create(path)?);
    write!(out, "ply\nformat binary_little_endian 1.0\nelement vertex {count}\n")?;
    write!(out, "property double x\nproperty double y\nproperty double z\nend_header\n")?;
    for value in (0..count).flat_map(point) {
        out.write_all(&value.to_le_bytes())?;
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

/// Builds the program; its path, beside this one.
fn build() -> Result<PathBuf, Error> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let built = Command::new(cargo)
        .args(["build", "--release", "--quiet", "--package", "indgeo", "--bin", "indgeo"])
        .current_dir(&root)
        .status()?;
    if !built.success() {
        return Err(Error::other("the program could not be built"));
    }
    let own = std::env::current_exe()?;
    let program = own.parent().map(|folder| folder.join("indgeo"));
    program.ok_or_else(|| Error::other("the program is not where cargo puts it"))
}

fn main() -> Result<(), Error> {
    let count: u64 = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(10_000_000);
    let program = match std::env::args_os().nth(2) {
        Some(program) => program.into(),
        None => build()?,
    };
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
    write_las(&folder.join("cloud.las"), count)?;
    println!("{count} points; largest resident memory");
    let page = ["--report", "page.html"];
    for (model, cloud, options) in [
        ("mesh.off", "cloud.ply", &[][..]),
        ("mesh.off", "cloud.las", &[]),
        ("mesh.off", "cloud.ply", &page),
        ("mesh.off", "cloud.las", &page),
        ("mesh.off", "cloud.ply", &["-o", "out.ply"]),
        ("mesh.off", "cloud.ply", &["-o", "out.csv"]),
        ("surface.json", "cloud.ply", &[]),
        ("surface.json", "cloud.ply", &page),
        ("surface.json", "cloud.ply", &["-o", "out.ply"]),
    ] {
        // Rows of so many points are files of tens of gigabytes.
        if options.contains(&"-o") && count > 20_000_000 {
            continue;
        }
        let mut arguments = vec!["inspect", model, cloud, "-t", "0.05", "--json", "report.json"];
        arguments.extend(options);
        let began = Instant::now();
        let bytes = peak(program, folder, &arguments)?;
        let seconds = began.elapsed().as_secs_f64();
        let accounted = accounted(&folder.join("report.json"))?;
        if accounted != count {
            return Err(Error::other(format!("{accounted} points are accounted for")));
        }
        println!(
            "{model:<13} {cloud} {:<18} {:>7.1} MB {:>6.1} bytes a point {seconds:>7.1} s",
            options.join(" "),
            bytes as f64 * 1e-6,
            bytes as f64 / count as f64
        );
    }
    Ok(())
}

/// Points that a report has judged or refused.
fn accounted(report: &Path) -> Result<u64, Error> {
    let text = fs::read_to_string(report)?;
    let outcomes = text.split("\"outcomes\": {").nth(1).and_then(|rest| rest.split('}').next());
    let outcomes = outcomes.ok_or_else(|| Error::other("the report has no outcomes"))?;
    let counts = outcomes.split(',').filter_map(|entry| entry.split(':').nth(1)?.trim().parse::<u64>().ok());
    Ok(counts.sum())
}
