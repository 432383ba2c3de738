//! Registrations of clouds to exact surfaces, meshes and clouds.

#![allow(missing_docs, reason = "criterion's macros make public items")]

#[path = "../tests/all/bodies/mod.rs"]
mod bodies;

use bodies::{Bumpy, Random};
use criterion::{Criterion, criterion_group, criterion_main};
use distance_field::{CloudField, DistanceField, SurfaceField};
use nalgebra::{Point3, Rotation3, Vector3};
use nurbs_core::{BsplineSurface, KnotVector, ParametricSurface};
use sdm_register::{Pose, RegisterOptions, Source, register};
use std::hint::black_box;

fn away() -> Pose<3> {
    let turn = Rotation3::from_scaled_axis(Vector3::new(0.1, -0.1, 0.08));
    Pose::new(turn.into_inner(), Vector3::new(0.03, -0.02, 0.04))
}

/// A wavy bicubic surface over the unit square.
fn wavy() -> Option<BsplineSurface> {
    let knots = KnotVector::uniform_clamped(3, 8).ok()?;
    let height = |i: usize, j: usize| 0.25 * ((2 * i + 3 * j) as f64 * 1.3).sin();
    let net = (0..64).map(|k| Vector3::new((k / 8) as f64, (k % 8) as f64, height(k / 8, k % 8)) / 7.0);
    BsplineSurface::new(knots.clone(), knots, net.collect(), None).ok()
}

fn bench_field(criterion: &mut Criterion, name: &str, field: &dyn DistanceField<3>, points: &[Vector3<f64>]) {
    let options = RegisterOptions::default();
    criterion.bench_function(name, |b| {
        b.iter(|| register(field, &Source::new(black_box(points)), &Pose::identity(), &options));
    });
}

fn surfaces(criterion: &mut Criterion) {
    let Some((surface, field)) = wavy().and_then(|s| SurfaceField::new(&s).ok().map(|field| (s, field)))
    else {
        return;
    };
    for (name, count) in [("register/surface, 5000", 5000), ("register/surface, 100 000", 100_000)] {
        let mut random = Random(1);
        let points: Vec<_> = (0..count)
            .map(|_| {
                let x = surface.point(0.05 + 0.9 * random.unit(), 0.05 + 0.9 * random.unit());
                away().apply(&(x + random.vector() * 1e-3))
            })
            .collect();
        bench_field(criterion, name, &field, &points);
    }
}

fn clouds(criterion: &mut Criterion) {
    let mut random = Random(2);
    let (target, _) = Bumpy::new().view(None, 40_000, &mut random);
    let (source, _) = Bumpy::new().view(None, 40_000, &mut random);
    let target: Vec<Point3<f64>> = target.into_iter().map(Point3::from).collect();
    let source: Vec<_> = source.iter().map(|x| away().apply(x)).collect();
    criterion.bench_function("register/field of a cloud, 40 000", |b| {
        b.iter(|| CloudField::new(black_box(&target), None).is_ok());
    });
    if let Ok(field) = CloudField::new(&target, None) {
        bench_field(criterion, "register/cloud, 40 000", &field, &source);
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10);
    targets = surfaces, clouds
}
criterion_main!(benches);
