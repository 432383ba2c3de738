//! From clouds to parameters: height fields, hidden points, and the whole way, by the number of points.
//!
//! Identifiers are `group/points`; times are per point.
#![allow(missing_docs, reason = "criterion's macros make undocumented functions")]
#![allow(clippy::expect_used, reason = "the clouds are known to be valid")]

#[path = "../tests/all/common/mod.rs"]
mod common;

use cloud_param::{
    MultilevelOptions, ParameteriseOptions, Sharpness, View, multilevel, parameterise, visible_points,
};
use common::{scattered, vase};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use nalgebra::Vector3;
use std::hint::black_box;
use std::time::Duration;

const COUNTS: [u32; 3] = [16_384, 131_072, 1_048_576];

/// A wavy height field, refined until it meets its data within a thousandth, or no level is left.
fn height_fields(c: &mut Criterion) {
    let mut group = c.benchmark_group("multilevel");
    for count in COUNTS {
        let data: Vec<Vector3<f64>> = (0..count)
            .map(scattered)
            .map(|[x, y]| Vector3::new(x, y, (7.0 * x).sin() * (5.0 * y).cos() + 0.1 * (40.0 * x * y).sin()))
            .collect();
        group.throughput(Throughput::Elements(u64::from(count)));
        let options = MultilevelOptions::default().with_tolerance(1e-3);
        group.bench_function(BenchmarkId::from_parameter(count), |b| {
            b.iter(|| multilevel(black_box(&data), None, &options).expect("a height field"));
        });
    }
}

fn hidden_points(c: &mut Criterion) {
    let mut group = c.benchmark_group("hidden-points");
    for count in COUNTS {
        let points = vase(count, 0.0);
        group.throughput(Throughput::Elements(u64::from(count)));
        let view = View::Along(-Vector3::x());
        group.bench_function(BenchmarkId::from_parameter(count), |b| {
            b.iter(|| visible_points(black_box(&points), view, Sharpness::default()).expect("a cloud"));
        });
    }
}

fn whole_way(c: &mut Criterion) {
    let mut group = c.benchmark_group("parameters");
    for count in COUNTS {
        let points = vase(count, 0.02);
        group.throughput(Throughput::Elements(u64::from(count)));
        group.bench_function(BenchmarkId::from_parameter(count), |b| {
            b.iter(|| parameterise(black_box(&points), &ParameteriseOptions::default()).expect("a vase"));
        });
    }
}

criterion_group! {
    name = clouds;
    config = Criterion::default().sample_size(10).measurement_time(Duration::from_secs(3)).without_plots();
    targets = height_fields, hidden_points, whole_way
}
criterion_main!(clouds);
