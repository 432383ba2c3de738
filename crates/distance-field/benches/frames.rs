//! Principal frames per query, by shape and by the way the foot is found.
//!
//! Identifiers are `frames/shape/search`. The queries lie within 2 % of the diagonal of the shapes; warm searches start
//! from the feet before a motion by 0.1 %.
#![allow(missing_docs, reason = "criterion's macros make undocumented functions")]
#![allow(clippy::expect_used, reason = "the shapes are known to be valid")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use distance_field::{
    AnalyticField, CloudField, CurveField, D2Tree, D2TreeOptions, DistanceField, ErrorTerm, Hint, MeshField,
    MeshOptions, Search, SurfaceField,
};
use mesh_core::TriangleMesh;
use nalgebra::{Point3, SVector, Vector3};
use nurbs_core::{
    BsplineCurve, BsplineSurface, Frame, KnotVector, ParametricCurve, ParametricSurface, TessellationOptions,
    Torus,
};
use std::hint::black_box;

const COUNT: usize = 16384;

fn spread(i: usize, step: f64) -> f64 {
    (i as f64 * step).fract()
}

/// An open wavy bicubic surface of 20 x 12 control points.
fn surface() -> BsplineSurface {
    let knots = |n| KnotVector::uniform_clamped(3, n).expect("valid knots");
    let net = (0..20 * 12)
        .map(|k| (f64::from(k / 12) / 19.0, f64::from(k % 12) / 11.0))
        .map(|(x, y)| Vector3::new(2.0 * x - 1.0, 1.2 * y - 0.6, 0.1 * (6.0 * x).sin() * (5.0 * y).cos()))
        .collect();
    BsplineSurface::new(knots(20), knots(12), net, None).expect("valid surface")
}

fn near_surface() -> Vec<Vector3<f64>> {
    let surface = surface();
    (0..COUNT)
        .map(|i| {
            let jet = surface.jet(spread(i, 0.618_033_988_749_895), spread(i, 0.754_877_666_246_693));
            jet.point + jet.unit_normal().unwrap_or_default() * 0.08 * (spread(i, 0.569_840_291) - 0.5)
        })
        .collect()
}

fn measure<const D: usize, F: DistanceField<D>>(
    c: &mut Criterion,
    name: &str,
    field: &F,
    points: &[SVector<f64, D>],
    searches: &[(&str, Search)],
) {
    let hints: Vec<Hint> = field.frames(points, Search::Global, &[]).iter().map(|f| f.hint).collect();
    let shift = SVector::<f64, D>::repeat(1e-3 * field.bounding_box().diagonal());
    let moved: Vec<SVector<f64, D>> = points.iter().map(|x| x + shift).collect();
    let mut group = c.benchmark_group("frames");
    group.throughput(Throughput::Elements(points.len() as u64));
    for (label, search) in searches {
        let hints = if *search == Search::Global { &[] } else { hints.as_slice() };
        group.bench_function(format!("{name}/{label}"), |b| {
            b.iter(|| black_box(field.frames(black_box(&moved), *search, hints)));
        });
    }
    group.finish();
}

const ALL: [(&str, Search); 3] =
    [("global", Search::Global), ("local", Search::Local), ("one-step", Search::OneStep)];
const ONE: [(&str, Search); 1] = [("global", Search::Global)];

fn shapes(c: &mut Criterion) {
    let points = near_surface();
    let surface = surface();
    let field = SurfaceField::new(&surface).expect("valid surface");
    measure(c, "bicubic", &field, &points, &ALL);
    let options = D2TreeOptions::default().with_tolerance(1e-4).with_margin(0.05);
    let tree = D2Tree::new(field, &options).expect("valid options");
    measure(c, "bicubic-d2-tree", &tree, &points, &ONE);

    let grid = surface.tessellate(&TessellationOptions::new(1e-3)).expect("finite surface");
    let vertices: Vec<Point3<f64>> = grid.vertices.iter().copied().map(Point3::from).collect();
    let mesh = TriangleMesh::new(vertices.clone(), grid.triangles).expect("valid mesh");
    let field = MeshField::with_options(&mesh, &MeshOptions::default()).expect("valid mesh");
    measure(c, "mesh", &field, &points, &ONE);
    let dense: Vec<Point3<f64>> = (0..40_000)
        .map(|k| Point3::from(surface.point(f64::from(k / 200) / 199.0, f64::from(k % 200) / 199.0)))
        .collect();
    let field = CloudField::new(&dense, None).expect("valid cloud");
    measure(c, "cloud", &field, &points, &ONE);

    let torus = Torus::new(Frame::WORLD, 1.0, 0.4).expect("valid torus");
    let field = AnalyticField::new(torus).expect("finite torus");
    measure(c, "torus-closed-form", &field, &points, &ONE);

    let net = (0..20u8).map(|i| Vector3::new(f64::from(i) * 0.1, (0.7 * f64::from(i)).sin() * 0.3, 0.0));
    let knots = KnotVector::uniform_clamped(3, 20).expect("valid knots");
    let curve = BsplineCurve::new(knots, net.collect(), None).expect("valid curve");
    let points: Vec<Vector3<f64>> = (0..COUNT)
        .map(|i| curve.point(spread(i, 0.618_033_988_749_895)) + Vector3::new(0.0, 0.01, 0.02))
        .collect();
    measure(c, "cubic-curve", &CurveField::new(&curve).expect("valid curve"), &points, &ALL);
}

fn models(c: &mut Criterion) {
    let field = SurfaceField::new(&surface()).expect("valid surface");
    let frames = field.frames(&near_surface(), Search::Global, &[]);
    let mut group = c.benchmark_group("models");
    group.throughput(Throughput::Elements(frames.len() as u64));
    for term in ErrorTerm::ALL {
        group.bench_function(term.name(), |b| {
            b.iter(|| {
                for frame in &frames {
                    black_box(term.model(frame));
                }
            });
        });
    }
    group.finish();
}

criterion_group!(benches, shapes, models);
criterion_main!(benches);
