//! Projections: certified, fast, from previous answers, all feet, inversion, preparation, local iterations.
//!
//! Identifiers are `group/shape-set`.
#![allow(missing_docs, reason = "criterion's macros make undocumented functions")]
#![allow(clippy::expect_used, reason = "the shapes are known to be valid")]

mod support;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use footpoint::local::{LocalOptions, Method, project_curve, project_surface};
use footpoint::{CurveProjector, Mode, ProjectionOptions, SurfaceFootpoint, SurfaceProjector, UpdateOptions};
use nurbs_core::nalgebra::{SVector, Vector2, Vector3};
use nurbs_core::{BsplineCurve, ParametricCurve};
use std::hint::black_box;
use std::time::Duration;
use support::{COUNT, Shape, circle, cubic_2d, curve_sets, helix, surfaces};

/// Points of a batch.
const BATCH: usize = 8192;

/// How far points of batches have moved, as a share of the diagonal of the shape.
const SHIFTS: [(&str, f64); 2] = [("1e-3", 1e-3), ("1e-2", 1e-2)];

fn group<'a>(c: &'a mut Criterion, name: &str, elements: usize) -> BenchmarkGroup<'a, WallTime> {
    let mut group = c.benchmark_group(name);
    group.throughput(Throughput::Elements(elements as u64));
    group
}

fn searches(c: &mut Criterion) {
    for (name, mode) in [("certified", Mode::Certified), ("fast", Mode::Fast)] {
        let options = ProjectionOptions::default().with_mode(mode);
        let mut group = group(c, name, COUNT);
        for shape in surfaces() {
            let projector = SurfaceProjector::new(&shape.surface);
            for (set, points) in shape.sets() {
                group.bench_function(format!("{}-{set}", shape.name), |b| {
                    b.iter(|| {
                        points.iter().for_each(|x| {
                            let _ = black_box(projector.project_with(x, &options));
                        });
                    });
                });
            }
        }
        curve_searches(&mut group, "cubic-2d", &cubic_2d(), None, &options);
        curve_searches(&mut group, "circle", &circle(), Some(Vector2::zeros()), &options);
        curve_searches(&mut group, "helix", &helix(), None, &options);
    }
}

fn curve_searches<const D: usize>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    name: &str,
    curve: &BsplineCurve<D>,
    centre: Option<SVector<f64, D>>,
    options: &ProjectionOptions,
) {
    let projector = CurveProjector::new(curve);
    for (set, points) in curve_sets(curve, centre) {
        group.bench_function(format!("{name}-{set}"), |b| {
            b.iter(|| {
                points.iter().for_each(|x| {
                    let _ = black_box(projector.project_with(x, options));
                });
            });
        });
    }
}

/// Points of a shape, their feet, and the same points shifted by a share of its size.
fn moved(
    shape: &Shape,
    projector: &SurfaceProjector,
    share: f64,
) -> (Vec<Vector3<f64>>, Vec<SurfaceFootpoint>) {
    let shift = Vector3::new(0.6, 0.5, -0.4).normalize() * (share * shape.size());
    (0..BATCH)
        .map(|i| {
            let start = shape.parameters(i);
            let foot = projector.project_from(&Vector3::zeros(), 0, start);
            let foot = SurfaceFootpoint { parameter: start, ..foot };
            (nurbs_core::ParametricSurface::point(&shape.surface, start[0], start[1]) + shift, foot)
        })
        .unzip()
}

fn updates(c: &mut Criterion) {
    // Of one core, whatever the machine has.
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread");
    let all: Vec<_> = surfaces().into_iter().map(|s| (SurfaceProjector::new(&s.surface), s)).collect();
    for (distance, share) in SHIFTS {
        let mut single = group(c, "warm", BATCH);
        for (projector, shape) in &all {
            let (points, feet) = moved(shape, projector, share);
            single.bench_function(format!("{}-{distance}", shape.name), |b| {
                b.iter(|| {
                    for (x, foot) in points.iter().zip(&feet) {
                        black_box(projector.project_from(x, foot.shape, foot.parameter));
                    }
                });
            });
        }
        single.finish();
        for (name, steps) in [("warm-batch", 50), ("one-step-batch", 1)] {
            let mut many = group(c, name, BATCH);
            let options = UpdateOptions::default().with_max_steps(steps);
            for (projector, shape) in &all {
                let (points, feet) = moved(shape, projector, share);
                let mut updated = feet.clone();
                many.bench_function(format!("{}-{distance}", shape.name), |b| {
                    b.iter(|| {
                        updated.copy_from_slice(&feet);
                        alone
                            .install(|| projector.update_in_place(&points, &mut updated, &options))
                            .expect("as many feet as points");
                    });
                });
            }
        }
    }
    let curve = cubic_2d();
    let projector = CurveProjector::new(&curve);
    let points = &curve_sets(&curve, None)[1].1;
    let feet: Vec<_> = points.iter().map(|x| projector.project(x)).collect();
    let points: Vec<_> = points.iter().map(|x| x.add_scalar(0.5)).collect();
    group(c, "warm-batch", COUNT).bench_function("cubic-2d-1e-3", |b| {
        // Too few for more than one thread.
        b.iter(|| black_box(projector.update_many(&points, &feet)));
    });
}

fn others(c: &mut Criterion) {
    let options = ProjectionOptions::default();
    for shape in surfaces() {
        let projector = SurfaceProjector::new(&shape.surface);
        let sets = shape.sets();
        let (on, mid) = (&sets[0].1, &sets[2].1);
        group(c, "inversion", COUNT).bench_function(shape.name, |b| {
            b.iter(|| on.iter().for_each(|x| drop(black_box(projector.invert(x, 1e-6)))));
        });
        group(c, "all-feet", COUNT).bench_function(shape.name, |b| {
            b.iter(|| mid.iter().for_each(|x| drop(black_box(projector.feet_within(x, 1.5, &options)))));
        });
        group(c, "preparation", projector.patch_count()).bench_function(shape.name, |b| {
            b.iter(|| black_box(SurfaceProjector::new(&shape.surface)));
        });
    }
    let curve = cubic_2d();
    let projector = CurveProjector::new(&curve);
    let on = &curve_sets(&curve, None)[0].1;
    group(c, "inversion", COUNT).bench_function("cubic-2d", |b| {
        b.iter(|| on.iter().for_each(|x| drop(black_box(projector.invert(x, 1e-6)))));
    });
    group(c, "preparation", projector.piece_count()).bench_function("cubic-2d", |b| {
        b.iter(|| black_box(CurveProjector::new(&curve)));
    });
}

fn local(c: &mut Criterion) {
    let (curve, shapes) = (cubic_2d(), surfaces());
    let near = &curve_sets(&curve, None)[1].1;
    let shape = &shapes[0];
    let near_surface = &shape.sets()[1].1;
    let mut group = group(c, "local", COUNT);
    for (name, method) in [
        ("first-order", Method::FirstOrder),
        ("second-order", Method::SecondOrder),
        ("second-order-taylor", Method::SecondOrderTaylor),
        ("principal-circle", Method::PrincipalCircle),
        ("newton", Method::Newton),
    ] {
        let options = LocalOptions::default().with_method(method);
        let projector = CurveProjector::new(&curve);
        // Starts near the feet: a hundredth of the domain away.
        let starts: Vec<f64> =
            near.iter().map(|x| projector.project(x).parameter + 0.01 * curve.domain().length()).collect();
        group.bench_function(format!("cubic-2d-{name}"), |b| {
            b.iter(|| {
                for (x, t) in near.iter().zip(&starts) {
                    black_box(project_curve(&curve, x, *t, &options));
                }
            });
        });
        group.bench_function(format!("example-3-{name}"), |b| {
            b.iter(|| {
                for (i, x) in near_surface.iter().enumerate() {
                    black_box(project_surface(&shape.surface, x, shape.parameters(i), &options));
                }
            });
        });
    }
}

fn short() -> Criterion {
    Criterion::default()
        .sample_size(15)
        .warm_up_time(Duration::from_millis(100))
        .measurement_time(Duration::from_millis(300))
}

criterion_group! {
    name = benches;
    config = short();
    targets = searches, updates, others, local
}
criterion_main!(benches);
