//! Measures CAD files against tables: `trimmed_faces FOLDER… [--tables FOLDER]`
//!
//! Every STEP and IGES file of the folders is read. Beside it, or in the folder of tables, `NAME.csv` may hold points with their
//! distances (x, y, z, distance, uncertainty, kind, what the foot is on, foot, side), and `areas/NAME.csv` the areas of its faces
//! with the length and the tolerance of their edges; lengths of tables are in millimetres.

use industrial_geometry::brep::Model;
use industrial_geometry::brep::description::{Carrier, ModelDescription};
use industrial_geometry::cad::{is_step, read_iges, read_step};
use nalgebra::Vector3;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Share of the diagonal within which distances agree, where the table does not allow more.
const SAME: f64 = 1e-7;
/// Factor by which the edge tolerance may exceed that of the tables, and millimetres more.
const EDGES: [f64; 2] = [1.1, 1e-6];

fn main() -> Outcome<()> {
    let mut folders = Vec::new();
    let mut tables = None;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--tables" => tables = Some(PathBuf::from(arguments.next().ok_or("a folder is missing")?)),
            _ => folders.push(PathBuf::from(argument)),
        }
    }
    if folders.is_empty() {
        return Err("give a folder with CAD files".into());
    }
    for folder in folders {
        let mut files: Vec<PathBuf> =
            std::fs::read_dir(&folder)?.map(|entry| Ok(entry?.path())).collect::<Outcome<_>>()?;
        files.retain(|path| {
            let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
            extension.is_some_and(|e| ["step", "stp", "igs", "iges"].contains(&e.as_str()))
        });
        files.sort();
        for path in files {
            if let Err(error) = measure(&path, tables.as_deref().unwrap_or(&folder)) {
                println!("{}: {error}", path.display());
            }
        }
    }
    Ok(())
}

/// Rows of a table, their cells as text; none where there is no table.
fn table(path: &Path) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    text.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn number(row: &[String], column: usize) -> f64 {
    row.get(column).and_then(|cell| cell.parse().ok()).unwrap_or(f64::NAN)
}

fn measure(path: &Path, tables: &Path) -> Outcome<()> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let bytes = std::fs::read(path)?;
    let clock = Instant::now();
    let description = if is_step(&bytes) { read_step(&bytes)? } else { read_iges(&bytes)? };
    let read = clock.elapsed().as_secs_f64();
    let clock = Instant::now();
    let model = Model::new(&description)?;
    let built = clock.elapsed().as_secs_f64();
    let scale = model.unit().map_or(1.0, |unit| unit.metres * 1e3);
    let edges = model.parts().iter().flat_map(|part| part.edges());
    let largest = edges.map(|edge| edge.tolerance()).fold(0.0, f64::max) * scale;
    let [faces, splines, rational] = count(&description);
    println!(
        "{name}: {faces} faces, {splines} B-splines in the file ({rational} rational), {} of {} solids; unit {}, \
         largest edge tolerance {largest:.1e} mm, {} not read; read {read:.3} s, built {built:.3} s",
        model.instances().len(),
        model.parts().len(),
        model.unit().map_or("none", |unit| unit.name.as_str()),
        model.unread().len()
    );
    let areas = table(&tables.join("areas").join(format!("{name}.csv")));
    if !areas.is_empty() {
        compare_areas(&model, &areas, largest, scale);
    }
    let points = table(&tables.join(format!("{name}.csv")));
    if !points.is_empty() {
        compare_points(&model, &points, scale)?;
    }
    Ok(())
}

/// Faces of all instances, and how many of them are B-splines, and rational ones, in the file.
fn count(model: &ModelDescription) -> [usize; 3] {
    let swept = |source: u64| model.converted.iter().any(|converted| converted.face == source);
    let mut counts = [0; 3];
    for face in model.instances.iter().flat_map(|instance| &model.parts[instance.part].faces) {
        counts[0] += 1;
        if let Carrier::Nurbs(surface) = &face.carrier
            && !swept(face.source)
        {
            counts[1] += 1;
            counts[2] += usize::from(surface.weights().is_some());
        }
    }
    counts
}

fn compare_areas(model: &Model, rows: &[Vec<String>], tolerance: f64, scale: f64) {
    let mut own: Vec<f64> = Vec::new();
    for instance in model.instances() {
        let part = &model.parts()[instance.part];
        own.extend((0..part.faces().len()).map(|face| part.area(face) * scale * scale));
    }
    let told = rows.iter().map(|row| number(row, 4)).fold(0.0, f64::max);
    let faces = own.len();
    let (mut wrong, mut worst) = (0, 0.0_f64);
    // Each row takes the face whose area is next to its own.
    for row in rows {
        let area = number(row, 0);
        let off = |found: f64| (found - area).abs();
        let Some(at) = (0..own.len()).min_by(|a, b| off(own[*a]).total_cmp(&off(own[*b]))) else { break };
        if off(own[at]) > 1e-6 * area + number(row, 3) * number(row, 4) {
            wrong += 1;
            println!("    area {area} of the table, {} found", own[at]);
        } else {
            worst = worst.max(off(own[at]) / area);
            own.swap_remove(at);
        }
    }
    let is_tight = tolerance <= EDGES[0] * told + EDGES[1];
    println!(
        "  areas: {wrong} of {} wrong ({faces} faces), largest relative difference {worst:.1e}; edge tolerance of the table \
         {told:.1e} mm, ours {}",
        rows.len(),
        if is_tight { "within" } else { "LARGER" }
    );
}

fn compare_points(model: &Model, rows: &[Vec<String>], scale: f64) -> Outcome<()> {
    let diagonal = model.bounds().diagonal() * scale;
    let points: Vec<Vector3<f64>> =
        rows.iter().map(|row| Vector3::new(number(row, 0), number(row, 1), number(row, 2)) / scale).collect();
    let clock = Instant::now();
    let feet: Vec<_> = points.iter().map(|point| model.nearest(point)).collect();
    let each = clock.elapsed().as_secs_f64() / points.len() as f64;
    let (mut on_faces, mut on_edges, mut sides, mut undecided, mut sided, mut wide) = (0, 0, 0, 0, 0, 0);
    let mut largest = 0.0_f64;
    for (row, foot) in rows.iter().zip(&feet) {
        let foot = foot.as_ref().ok_or("a point has no foot")?;
        let expected = number(row, 3);
        let allowed = (2.0 * number(row, 4)).max(SAME * diagonal);
        let is_wrong = (foot.distance * scale - expected).abs() > allowed;
        let is_edge = row.get(6).is_some_and(|on| on == "edge");
        on_faces += usize::from(is_wrong && !is_edge);
        on_edges += usize::from(is_wrong && is_edge);
        largest = largest.max(foot.gap() * scale);
        wide += usize::from(foot.gap() * scale > SAME * diagonal);
        let side = number(row, 10);
        if side != 0.0 && expected > allowed {
            sided += 1;
            match foot.signed_distance() {
                None => undecided += 1,
                Some(distance) => sides += usize::from((distance > 0.0) != (side > 0.0)),
            }
        }
    }
    println!(
        "  {} points: distances wrong {on_faces} on faces, {on_edges} on edges; sides wrong {sides}, undecided {undecided} of \
         {sided}; largest gap {largest:.1e} mm, {wide} above {SAME} of the diagonal; {:.3} ms a point",
        rows.len(),
        each * 1e3
    );
    Ok(())
}
