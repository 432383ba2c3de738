//! Files: what is written comes back bit for bit.

use super::shapes::{in_cube, wavy};
use super::{Checks, Failure};
use industrial_geometry::io::{self, Content, ReadOptions, WriteOptions};
use industrial_geometry::mesh::nalgebra::{Point3, Vector3};
use industrial_geometry::mesh::{PointCloud, TriangleMesh};
use industrial_geometry::nurbs::BsplineSurface;
use std::path::PathBuf;

pub(super) fn add(checks: &mut Checks) {
    const SAME: &str = "number of coordinates whose bits changed: 0";
    checks.add("points as PLY", SAME, 0.0, || cloud("ply"));
    checks.add("points as CSV", SAME, 0.0, || cloud("csv"));
    checks.add("points as XYZ", SAME, 0.0, || cloud("xyz"));
    checks.add("points as PCD", SAME, 0.0, || cloud("pcd"));
    checks.add("triangles as OFF", SAME, 0.0, || mesh("off"));
    checks.add("triangles as OBJ", SAME, 0.0, || mesh("obj"));
    checks.add("NURBS as JSON", SAME, 0.0, nurbs);
}

/// A name in the folder for temporary files, removed at the end.
struct Scratch(PathBuf);

impl Scratch {
    fn new(extension: &str) -> Self {
        let name = format!("indgeo-selftest-{}.{extension}", std::process::id());
        Self(std::env::temp_dir().join(name))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // Nothing is left to be done about a failure here.
        let _ = std::fs::remove_file(&self.0);
    }
}

/// Numbers of all sizes.
fn points() -> Vec<Point3<f64>> {
    let size = |i: usize| 10f64.powi(i32::try_from(i % 25).unwrap_or(0) - 12);
    (0..200).map(|i| Point3::from(in_cube(i) * size(i))).collect()
}

fn write(content: &Content, extension: &str) -> Result<Scratch, Failure> {
    let file = Scratch::new(extension);
    let _ = io::write(&file.0, content, &WriteOptions::default())?;
    Ok(file)
}

fn changed(written: &[Point3<f64>], read: &[Point3<f64>]) -> f64 {
    if written.len() != read.len() {
        return f64::INFINITY;
    }
    let pairs = written.iter().zip(read).flat_map(|(a, b)| a.iter().zip(b.iter()));
    pairs.filter(|(a, b)| a.to_bits() != b.to_bits()).count() as f64
}

fn cloud(extension: &str) -> Result<f64, Failure> {
    let file = write(&Content::Cloud(PointCloud::new(points())), extension)?;
    let read = io::read_cloud(&file.0, &ReadOptions::default())?.content;
    Ok(changed(&points(), read.positions()))
}

fn mesh(extension: &str) -> Result<f64, Failure> {
    let triangles: Vec<[u32; 3]> = (0..198).map(|i| [i, i + 1, i + 2]).collect();
    let written = TriangleMesh::new(points(), triangles.clone())?;
    let file = write(&Content::Mesh(written), extension)?;
    let read = io::read_mesh(&file.0, &ReadOptions::default())?.content;
    if read.triangles() != triangles {
        return Err("the triangles changed".into());
    }
    Ok(changed(&points(), read.vertices()))
}

fn nurbs() -> Result<f64, Failure> {
    let surface = wavy()?.scaled(1.0 / 3.0, &Vector3::new(0.1, 0.2, 0.3))?;
    let read: BsplineSurface = serde_json::from_str(&serde_json::to_string(&surface)?)?;
    let all = |surface: &BsplineSurface| -> Vec<Point3<f64>> {
        surface.control_points().iter().map(|&point| Point3::from(point)).collect()
    };
    Ok(changed(&all(&surface), &all(&read)))
}
