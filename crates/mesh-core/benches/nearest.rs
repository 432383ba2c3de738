//! Nearest neighbours, normals and closest points on meshes.
//!
//! Identifiers are `group/name…`; times are per point, on all threads where the name says `batch`.
#![allow(missing_docs, reason = "criterion's macros make undocumented functions")]
#![allow(clippy::expect_used, reason = "the shapes are known to be valid")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use mesh_core::nalgebra::{Point3, Vector3};
use mesh_core::{CloudIndex, MeshProjector, NormalOptions, TriangleMesh, estimate_normals};
use std::hint::black_box;

/// Points of the clouds.
const COUNT: usize = 1_000_000;
/// Queries per iteration.
const QUERIES: usize = 10_000;

/// The fractional parts of multiples of an irrational number: spread evenly, in no order.
fn spread(i: usize, step: f64) -> f64 {
    (i as f64 * step).fract()
}

/// Points on a wavy surface over the unit square.
fn surface(count: usize, height: f64) -> Vec<Point3<f64>> {
    (0..count)
        .map(|i| (spread(i, 0.754_877_666_246_693), spread(i, 0.569_840_290_998_053)))
        .map(|(x, y)| Point3::new(x, y, 0.1 * (9.0 * x).sin() * (7.0 * y).cos() + height))
        .collect()
}

/// The wavy surface as a mesh of `2 n²` triangles.
fn mesh(n: u32) -> TriangleMesh {
    let at = |i: u32, j: u32| i * (n + 1) + j;
    let vertices = (0..(n + 1) * (n + 1))
        .map(|k| (f64::from(k / (n + 1)) / f64::from(n), f64::from(k % (n + 1)) / f64::from(n)))
        .map(|(x, y)| Point3::new(x, y, 0.1 * (9.0 * x).sin() * (7.0 * y).cos()))
        .collect();
    let triangles = (0..n * n)
        .map(|k| (k / n, k % n))
        .flat_map(|(i, j)| {
            [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
        })
        .collect();
    TriangleMesh::new(vertices, triangles).expect("valid mesh")
}

fn nearest(c: &mut Criterion) {
    let points = surface(COUNT, 0.0);
    let index = CloudIndex::new(&points).expect("few points");
    let queries: Vec<_> = surface(QUERIES, 0.01).iter().map(|p| p + Vector3::repeat(1e-4)).collect();
    let mut group = c.benchmark_group("cloud");
    group.sample_size(10).throughput(Throughput::Elements(QUERIES as u64));
    group.bench_function("1e6-points/nearest", |b| {
        b.iter(|| {
            for x in &queries {
                black_box(index.nearest(x));
            }
        });
    });
    group.bench_function("1e6-points/16-nearest", |b| {
        b.iter(|| {
            for x in &queries {
                black_box(index.nearest_n(x, 16));
            }
        });
    });
    group.bench_function("1e6-points/nearest-batch", |b| b.iter(|| black_box(index.nearest_many(&queries))));
    group.throughput(Throughput::Elements(COUNT as u64));
    group.bench_function("1e6-points/build", |b| b.iter(|| black_box(CloudIndex::new(&points))));
    let options = NormalOptions::default();
    group.bench_function("1e6-points/normals-batch", |b| {
        b.iter(|| black_box(estimate_normals(&points, &options)));
    });
    group.finish();
}

fn closest(c: &mut Criterion) {
    let mut group = c.benchmark_group("mesh");
    group.sample_size(10).throughput(Throughput::Elements(QUERIES as u64));
    for n in [100u32, 500] {
        let mesh = mesh(n);
        let projector = MeshProjector::new(&mesh).expect("valid mesh");
        let queries = surface(QUERIES, 0.01);
        let name = format!("{}-triangles", mesh.triangles().len());
        group.bench_function(format!("{name}/closest"), |b| {
            b.iter(|| {
                for x in &queries {
                    let _ = black_box(projector.project(x));
                }
            });
        });
        group.bench_function(format!("{name}/closest-batch"), |b| {
            b.iter(|| black_box(projector.project_many(&queries)));
        });
    }
    group.finish();
}

criterion_group!(benches, nearest, closest);
criterion_main!(benches);
