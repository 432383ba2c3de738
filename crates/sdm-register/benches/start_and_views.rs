//! Coarse starts and registrations of many views.

#![allow(missing_docs, reason = "criterion's macros make public items")]

#[path = "../tests/all/bodies/mod.rs"]
mod bodies;

use bodies::{Bumpy, Random, SixViews};
use criterion::{Criterion, criterion_group, criterion_main};
use footpoint::no_progress;
use nalgebra::Vector3;
use sdm_register::start::{CoarseStart, OrientedPoints, StartMethod, StartOptions};
use sdm_register::views::{View, ViewsOptions, register_views};
use std::hint::black_box;

fn start(criterion: &mut Criterion) {
    let (points, normals) = Bumpy::new().view(None, 20_000, &mut Random(1));
    let (Ok(model), Ok(cloud)) = (OrientedPoints::new(&points, &normals), {
        let (points, normals) = Bumpy::new().view(Some((Vector3::x(), 1.2)), 5000, &mut Random(2));
        let turn = Random(3).rotation();
        let turned = |list: &[Vector3<f64>]| list.iter().map(|x| turn * x).collect::<Vec<_>>();
        OrientedPoints::new(&turned(&points), &turned(&normals))
    }) else {
        return;
    };
    let options = StartOptions::default();
    criterion.bench_function("start/prepare", |b| b.iter(|| CoarseStart::new(black_box(&model), &options)));
    for method in [StartMethod::PrincipalAxes, StartMethod::PointPairs] {
        let Ok(start) = CoarseStart::new(&model, &options.clone().with_method(method)) else { continue };
        let name = format!("start/{}", method.name());
        criterion.bench_function(&name, |b| b.iter(|| start.search(black_box(&cloud), &no_progress)));
    }
}

fn views(criterion: &mut Criterion) {
    let six = SixViews::new(5000, 0.0, 0.1, 1);
    let views: Vec<View> = six.points.iter().map(|points| View::new(points)).collect();
    let options = ViewsOptions::default();
    criterion.bench_function("views/six of 5000 points", |b| {
        b.iter(|| register_views(black_box(&views), &six.initial, &options, &no_progress));
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10);
    targets = start, views
}
criterion_main!(benches);
