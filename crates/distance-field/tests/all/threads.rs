//! The same bits whatever the number of threads.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests may panic")]

use crate::common::{Numbers, sphere_mesh, wavy};
use distance_field::{
    CloudField, CurveField, D2Tree, D2TreeOptions, DistanceField, Hint, MeshField, Search, SurfaceField,
};
use nalgebra::SVector;
use nurbs_core::{Frame, Sphere};

fn check<const D: usize, F: DistanceField<D>>(build: impl Fn() -> F + Sync + Send) {
    let mut numbers = Numbers::new(41);
    let points: Vec<SVector<f64, D>> = (0..5000).map(|_| numbers.vector()).collect();
    let moved: Vec<SVector<f64, D>> = points.iter().map(|x| x + numbers.vector() * 1e-3).collect();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let field = build();
            let first = field.frames(&points, Search::Global, &[]);
            let hints: Vec<Hint> = first.iter().map(|frame| frame.hint).collect();
            let mut all = first;
            for search in [Search::Global, Search::Local, Search::OneStep] {
                all.extend(field.frames(&moved, search, &hints));
            }
            all
        })
    };
    let (one, three) = (run(1), run(3));
    assert!(one.iter().zip(&three).all(|(a, b)| a == b));
    assert_eq!(one.len(), 20_000);
}

#[test]
fn frames_do_not_depend_on_the_number_of_threads() {
    check(|| SurfaceField::new(&wavy()).unwrap());
    check(|| CurveField::new(&wavy().iso_curve_u(0.4).unwrap()).unwrap());
    check(|| MeshField::new(&sphere_mesh(10, 0.8)).unwrap());
    check(|| CloudField::new(sphere_mesh(12, 0.8).vertices(), None).unwrap());
    check(|| {
        let sphere = SurfaceField::new(&Sphere::new(Frame::WORLD, 0.8).unwrap().to_nurbs().unwrap()).unwrap();
        D2Tree::new(sphere, &D2TreeOptions::default().with_tolerance(1e-3).with_max_depth(4)).unwrap()
    });
}
