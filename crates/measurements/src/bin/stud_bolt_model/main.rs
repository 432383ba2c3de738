//! Makes the nominal model of the stud bolt that `indgeo demo` compares with its scan.
//!
//! The nominal geometry is a thread M12 × 1.75 with the basic profile of ISO 68-1 and a shank of diameter 12 mm on the same axis, at
//! their nominal sizes. Only the *placement* (axis and axial phase of the thread, and the hand) is taken from the scan, by a robust
//! least squares fit, as a best-fit alignment does. What differs in size or form therefore stays visible.
//!
//! ```sh
//! cargo run --release -p measurements --bin stud_bolt_model
//! ```
//! writes `fixtures/demo/stud-bolt-model.json` and `fixtures/demo/stud-bolt-placement.json`.

mod fit;
mod nominal;

use fit::Placement;
use industrial_geometry::io::{self, Model, ReadOptions, WriteOptions};
use nominal::{DIAMETER, PITCH};
use std::error::Error;
use std::path::Path;

/// Where the thread is complete, in mm along the axis from the centroid of the scan (read off a plot of radius over height).
const THREAD: [f64; 2] = [-10.7, 8.3];
/// Where the shank is, likewise; it goes on beyond the end of the scan.
const SHANK: [f64; 2] = [-26.0, -14.7];

fn main() -> Result<(), Box<dyn Error>> {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures");
    let scan = io::read_cloud(fixtures.join("scans/stud-bolt.ply"), &ReadOptions::default())?;
    let (placement, rms) = fit::place(scan.content.positions(), THREAD)?;

    let mut model = Model::default();
    model.push(
        nominal::thread(&placement, THREAD)?,
        Some("thread M12 x 1.75-LH (ISO 68-1 basic profile)".into()),
    );
    model.push(nominal::shank(&placement, SHANK)?, Some("shank, diameter 12".into()));
    let demo = fixtures.join("demo");
    let written = io::write_model(demo.join("stud-bolt-model.json"), &model, &WriteOptions::default())?;
    println!("{written}");

    let placement_file = demo.join("stud-bolt-placement.json");
    std::fs::write(&placement_file, describe(&placement, rms)?)?;
    println!(
        "placed the thread with an rms of {rms:.4} mm (radial, trimmed by weights); {}",
        placement_file.display()
    );
    Ok(())
}

/// The placement as JSON: what a program needs to unroll the bolt.
fn describe(placement: &Placement, rms: f64) -> Result<String, serde_json::Error> {
    let vector = |v: &nalgebra::Vector3<f64>| [v.x, v.y, v.z];
    let value = serde_json::json!({
        "unit": "mm",
        "origin": vector(&placement.origin),
        "axis": vector(&placement.axis),
        "reference": vector(&placement.e1),
        "pitch": PITCH,
        "turn": PITCH * placement.hand,
        "phase": placement.phase,
        "profile": nominal::PROFILE.map(|(x, r)| [x * PITCH, r()]),
        "diameter": DIAMETER,
        "thread": THREAD,
        "shank": SHANK,
        "fit_rms": rms,
    });
    Ok(serde_json::to_string_pretty(&value)? + "\n")
}
