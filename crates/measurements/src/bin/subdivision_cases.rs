//! A Loop subdivision surface fitted to the vertices of a mesh by point, tangent and squared distance minimisation, side by side.
//!
//! `cargo run --release -p measurements --bin subdivision_cases [-- VERTICES [ITERATIONS]]`
//!
//! The mesh is `fixtures/mesh/bunny.obj` (1839 vertices); the control mesh is the same, coarsened to the given number of vertices
//! (200). Prints the root mean square distance, as a share of the diagonal of the body, after each iteration.

use distance_field::ErrorTerm;
use mesh_core::TriangleMesh;
use nalgebra::{Point3, Vector3};
use sdm_fit::Target;
use sdm_fit::subdivision::{coarsened, fit_subdivision, subdivision_options};
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let number = |k: usize, default: usize| std::env::args().nth(k).map_or(Ok(default), |a| a.parse());
    let (vertices, iterations) = (number(1, 200)?, number(2, 20)?);
    let bunny = read(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/mesh/bunny.obj"))?;
    let diagonal = bunny.bounding_box().map_or(1.0, |bounds| bounds.diagonal());
    let points: Vec<Vector3<f64>> = bunny.vertices().iter().map(|p| p.coords).collect();
    let control = coarsened(&bunny, vertices)?;
    println!("{} points, {} control points", points.len(), control.vertices().len());
    let target = Target::Points { points: &points, weights: None };
    let mut columns = Vec::new();
    for term in [ErrorTerm::Point, ErrorTerm::Tangent, ErrorTerm::SquaredDistance] {
        let options =
            subdivision_options().with_term(term).with_max_iterations(iterations).with_cost_tolerance(0.0);
        let clock = Instant::now();
        let found = fit_subdivision(target, &control, &options)?;
        let steps = found.report.history.len().max(1) as f64;
        println!("{term}: {}, {:.3} s per iteration", found.report, clock.elapsed().as_secs_f64() / steps);
        columns.push(found.report.history);
    }
    println!("iteration      point    tangent    squared");
    for k in 0..columns.iter().map(Vec::len).max().unwrap_or(0) {
        let cell = |history: &Vec<sdm_fit::FitStep>| {
            history.get(k).map_or_else(String::new, |step| format!("{:.3e}", step.rms / diagonal))
        };
        let cells: Vec<String> = columns.iter().map(cell).collect();
        println!("{:9} {:>10} {:>10} {:>10}", k + 1, cells[0], cells[1], cells[2]);
    }
    Ok(())
}

fn read(path: &str) -> Result<TriangleMesh, Box<dyn std::error::Error>> {
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    for line in std::fs::read_to_string(path)?.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        if let ["v", x, y, z] = words[..] {
            corners.push(Point3::new(x.parse()?, y.parse()?, z.parse()?));
        } else if let ["f", a, b, c] = words[..] {
            let index =
                |w: &str| w.split('/').next().unwrap_or(w).parse::<u32>().map(|k| k.saturating_sub(1));
            triangles.push([index(a)?, index(b)?, index(c)?]);
        }
    }
    Ok(TriangleMesh::new(corners, triangles)?)
}
