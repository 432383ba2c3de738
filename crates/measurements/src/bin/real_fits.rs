//! Curves and surfaces fitted to real data, which come without parameters.
//!
//! ```sh
//! cargo run --release -p measurements --bin real_fits
//! ```
//! Sections of an airfoil as measured, sections of a scanned blade across its axis (points where edges of its mesh cross a plane, in no
//! order), the outline of a horse in an image (where its opacity passes one half), and one side of the blade. Each is fitted once as the
//! data ask for, and once to a tolerance, with knots inserted where it is exceeded and removed where they carry nothing. Printed are
//! the number of points and control points (with a tolerance the most there were, too), root mean square and largest orthogonal
//! distance, share of the points within the tolerance, crossings (cells that fold, for surfaces), iterations and seconds.

use industrial_geometry::distance_field::{Grid, LevelSetField};
use industrial_geometry::fit::curve::{CurveOptions, fit_curve};
use industrial_geometry::fit::{BaseShape, SurfaceOptions, fit_cloud};
use industrial_geometry::io::{self, Content, ReadOptions};
use industrial_geometry::mesh::nalgebra::{Vector2, Vector3};
use industrial_geometry::mesh::{TriangleMesh, sample_uniform};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

type Outcome<T> = Result<T, Box<dyn Error>>;

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures").join(name)
}

/// Rows of two numbers.
fn airfoil() -> Outcome<Vec<Vector2<f64>>> {
    let text = std::fs::read_to_string(fixture("scans/airfoil-0.csv"))?;
    let row = |line: &str| -> Outcome<Vector2<f64>> {
        let (x, y) = line.split_once(',').ok_or("a row of two numbers")?;
        Ok(Vector2::new(x.trim().parse()?, y.trim().parse()?))
    };
    text.lines().map(row).collect()
}

fn blade() -> Outcome<TriangleMesh> {
    match io::read(fixture("scans/engine-blade.ply"), &ReadOptions::default())?.content {
        Content::Mesh(mesh) => Ok(mesh),
        _ => Err("the blade is a mesh".into()),
    }
}

fn corners(mesh: &TriangleMesh, triangle: &[u32; 3]) -> [Vector3<f64>; 3] {
    triangle.map(|corner| mesh.vertices()[corner as usize].coords)
}

/// Where edges of a mesh cross a plane across z.
fn section(mesh: &TriangleMesh, height: f64) -> Vec<Vector2<f64>> {
    let mut found = Vec::new();
    for triangle in mesh.triangles() {
        let corners = corners(mesh, triangle);
        for (a, b) in [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (corners[i], corners[j])) {
            // Each edge belongs to two triangles, in opposite directions.
            if a.z < height && height <= b.z {
                let p = a + (b - a) * ((height - a.z) / (b.z - a.z));
                found.push(Vector2::new(p.x, p.y));
            }
        }
    }
    found
}

/// The longest contour of an image's opacity, in pixels, y upwards.
fn silhouette(name: &str) -> Outcome<Vec<Vector2<f64>>> {
    let file = std::io::BufReader::new(std::fs::File::open(fixture(name))?);
    let mut reader = png::Decoder::new(file).read_info()?;
    let mut pixels = vec![0; reader.output_buffer_size().ok_or("an image that fits into memory")?];
    let image = reader.next_frame(&mut pixels)?;
    let (width, height) = (image.width as usize, image.height as usize);
    let channels = image.line_size / width;
    // Dark shapes on white or transparent ground: how dark a pixel is, with a border of ground around the image.
    let dark = |x: usize, y: usize| -> f64 {
        if x == 0 || y == 0 || x > width || y > height {
            return 0.0;
        }
        let at = ((height - y) * width + x - 1) * channels;
        let opacity = if channels % 2 == 0 { f64::from(pixels[at + channels - 1]) / 255.0 } else { 1.0 };
        opacity * (1.0 - f64::from(pixels[at]) / 255.0)
    };
    let counts = [width + 2, height + 2];
    let values = (0..counts[0] * counts[1]).map(|k| 0.5 - dark(k / counts[1], k % counts[1])).collect();
    let field = LevelSetField::<2>::new(&Grid::new(Vector2::zeros(), Vector2::repeat(1.0), counts, values)?)?;
    let longest = field.contours().iter().max_by(|a, b| a.length().total_cmp(&b.length()));
    Ok(longest.ok_or("an image with a shape in it")?.vertices().iter().map(|p| p.coords).collect())
}

/// Points of the side of the blade that faces a direction across its axis, away from its platform and its tip.
fn side(mesh: &TriangleMesh, direction: &Vector3<f64>) -> Outcome<Vec<Vector3<f64>>> {
    let faces = |triangle: usize| -> bool {
        let [a, b, c] = corners(mesh, &mesh.triangles()[triangle]);
        let normal = (b - a).cross(&(c - a));
        normal.dot(direction) > 0.35 * normal.norm()
    };
    let samples = sample_uniform(mesh, 40_000, 1)?.into_iter();
    let inside = samples.filter(|s| (305.0..365.0).contains(&s.point.z) && faces(s.triangle));
    Ok(inside.map(|s| s.point.coords).collect())
}

fn curve(name: &str, points: &[Vector2<f64>], tolerance: Option<f64>) -> Outcome<()> {
    let clock = Instant::now();
    let fit = fit_curve(points, None, &CurveOptions::default().with_abs_tolerance(tolerance))?;
    let seconds = clock.elapsed().as_secs_f64();
    let report = &fit.report;
    let most = report.stages.iter().map(|stage| stage.controls).max().unwrap_or(report.controls);
    println!(
        "{name:22} {:6} {:>10} {:>9} {:9.2e} {:9.2e} {:>10} {:>8} {:>9} {:10} {seconds:7.2}  {}",
        points.len(),
        tolerance.map_or("-".into(), |t| t.to_string()),
        if most > report.controls {
            format!("{} ({most})", report.controls)
        } else {
            report.controls.to_string()
        },
        report.rms,
        report.max,
        report.share_within.map_or("-".into(), |share| format!("{:.1} %", 100.0 * share)),
        if report.closed { "closed" } else { "open" },
        report.crossings.len(),
        report.iterations,
        report.status,
    );
    Ok(())
}

fn surface(name: &str, points: &[Vector3<f64>], tolerance: Option<f64>) -> Outcome<()> {
    let clock = Instant::now();
    let options = SurfaceOptions::default().with_base(BaseShape::Plane).with_abs_tolerance(tolerance);
    let fit = fit_cloud(points, &options)?;
    let seconds = clock.elapsed().as_secs_f64();
    let report = &fit.report;
    let [u, v] = report.controls;
    println!(
        "{name:22} {:6} {:>10} {:>9} {:9.2e} {:9.2e} {:>10} {:>8} {:>9} {:10} {seconds:7.2}  {}",
        points.len(),
        tolerance.map_or("-".into(), |t| t.to_string()),
        format!("{u} x {v}"),
        report.fit.rms,
        report.fit.max,
        report.share_within.map_or("-".into(), |share| format!("{:.1} %", 100.0 * share)),
        "open",
        report.folds.count(),
        report.fit.history.len(),
        report.fit.status,
    );
    Ok(())
}

fn main() -> Outcome<()> {
    println!(
        "{:22} {:>6} {:>10} {:>9} {:>9} {:>9} {:>10} {:>8} {:>9} {:>10} {:>7}  end",
        "data",
        "points",
        "tolerance",
        "controls",
        "rms",
        "max",
        "within",
        "curve",
        "crossings",
        "iterations",
        "s"
    );
    let airfoil = airfoil()?;
    for tolerance in [None, Some(2e-3)] {
        curve("airfoil, chord 36", &airfoil, tolerance)?;
    }
    let blade = blade()?;
    for height in [260.0, 310.0, 345.0] {
        let section = section(&blade, height);
        for tolerance in [None, Some(0.02)] {
            curve(&format!("blade at z = {height}"), &section, tolerance)?;
        }
    }
    let horse = silhouette("images/horse.png")?;
    for tolerance in [None, Some(0.7)] {
        curve("horse, pixels", &horse, tolerance)?;
    }
    let side = side(&blade, &Vector3::new(0.56, 0.83, 0.0))?;
    for tolerance in [None, Some(0.02)] {
        surface("side of the blade", &side, tolerance)?;
    }
    Ok(())
}
