//! A scan read, described and written in another format.
//!
//! ```sh
//! cargo run -p industrial-geometry --example read_write
//! ```

use industrial_geometry::io::{ReadOptions, WriteOptions, read, read_cloud, write_cloud};

/// Reads a PLY file and writes its points as CSV.
pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scan = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/scans/stud-bolt.ply");
    let loaded = read_cloud(scan, &ReadOptions::default())?;
    println!("{}", loaded.report);

    let path = std::env::temp_dir().join(format!("indgeo-example-{}.csv", std::process::id()));
    let written = write_cloud(&path, &loaded.content, &WriteOptions::default())?;
    println!("{}: {written:?}", path.display());

    let again = read(&path, &ReadOptions::default())?;
    println!("{}", again.report);
    assert_eq!(again.report.points, loaded.report.points);
    std::fs::remove_file(&path)?;
    Ok(())
}
