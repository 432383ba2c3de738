//! Speed and accuracy of the d²-tree against exact footpoints, on one thread.
//!
//! `RAYON_NUM_THREADS=1 cargo run --release -p measurements --bin d2_tree`
#![allow(clippy::expect_used, reason = "the shapes are known to be valid")]

use distance_field::{D2Tree, D2TreeOptions, DistanceField, Hint, PrincipalFrame, Search, SurfaceField};
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, KnotVector, ParametricSurface};
use std::hint::black_box;
use std::time::Instant;

const COUNT: usize = 100_000;
const ROUNDS: usize = 7;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let knots = |n| KnotVector::uniform_clamped(3, n);
    let net = (0..20 * 12)
        .map(|k| (f64::from(k / 12) / 19.0, f64::from(k % 12) / 11.0))
        .map(|(x, y)| Vector3::new(2.0 * x - 1.0, 1.2 * y - 0.6, 0.1 * (6.0 * x).sin() * (5.0 * y).cos()))
        .collect();
    let surface = BsplineSurface::new(knots(20)?, knots(12)?, net, None)?;
    let field = SurfaceField::new(&surface)?;
    let diagonal = field.bounding_box().diagonal();

    let spread = |i: usize, step: f64| (i as f64 * step).fract();
    let near: Vec<Vector3<f64>> = (0..COUNT)
        .map(|i| {
            let jet = surface.jet(spread(i, 0.618_033_988_749_895), spread(i, 0.754_877_666_246_693));
            jet.point + jet.unit_normal().unwrap_or_default() * 0.08 * (spread(i, 0.569_840_291) - 0.5)
        })
        .collect();
    let hints: Vec<Hint> = field.frames(&near, Search::Global, &[]).iter().map(|f| f.hint).collect();
    let moved: Vec<Vector3<f64>> = near.iter().map(|x| x.add_scalar(1e-3 * diagonal)).collect();

    println!("bicubic surface, 20 x 12 control points, {COUNT} queries within 2 % of the diagonal");
    let (global, exact) = time(&field, &moved, Search::Global, &[]);
    println!("exact, global       {global:8.0} ns");
    println!("exact, local        {:8.0} ns", time(&field, &moved, Search::Local, &hints).0);
    println!("exact, one step     {:8.0} ns", time(&field, &moved, Search::OneStep, &hints).0);
    println!("tolerance   build     leaves   memory  open share  query   largest  99 %  (errors / diagonal)");
    for tolerance in [1e-2, 3e-3, 1e-3] {
        let start = Instant::now();
        let options = D2TreeOptions::default().with_tolerance(tolerance).with_margin(0.05);
        let tree = D2Tree::new(field.clone(), &options)?;
        let (build, report) = (start.elapsed().as_secs_f64(), *tree.report());
        let (query, frames) = time(&tree, &moved, Search::Global, &[]);
        let mut errors: Vec<f64> = frames
            .iter()
            .zip(&exact)
            .map(|(a, b)| (a.distance.abs() - b.distance.abs()).abs() / diagonal)
            .collect();
        errors.sort_by(f64::total_cmp);
        println!(
            "{tolerance:8.0e} {build:7.2} s {:10} {:5.1} MB {:9.3} {query:8.0} ns {:9.1e} {:8.1e}",
            report.leaves,
            report.memory as f64 / 1e6,
            report.open_share,
            errors[COUNT - 1],
            errors[COUNT * 99 / 100],
        );
    }
    Ok(())
}

/// The least time per query over several rounds, and the frames.
fn time<F: DistanceField<3>>(
    field: &F,
    points: &[Vector3<f64>],
    search: Search,
    hints: &[Hint],
) -> (f64, Vec<PrincipalFrame<3>>) {
    let mut least = f64::INFINITY;
    let mut frames = Vec::new();
    for _ in 0..ROUNDS {
        let start = Instant::now();
        frames = black_box(field.frames(black_box(points), search, hints));
        least = least.min(start.elapsed().as_secs_f64());
    }
    (1e9 * least / points.len() as f64, frames)
}
