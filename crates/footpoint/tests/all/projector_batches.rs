//! Many points at once, threads, cancelling, inversion, and input that is not a point.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

use crate::projector_support::config;
use crate::projector_support::random::regular_surface;
use crate::projector_support::shapes::{parabola, plane_curve, query, rectangle, surface};
use footpoint::{
    CurveFootpoint, CurveProjector, Error, Mode, ProjectionOptions, Status, SurfaceFootpoint,
    SurfaceProjector, no_progress,
};
use nalgebra::{SVector, Vector2, Vector3};
use nurbs_core::{Frame, ParametricCurve, ParametricSurface, Torus};
use proptest::prelude::*;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

fn with_threads<R: Send>(threads: usize, run: impl FnOnce() -> R + Send) -> R {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run)
}

/// All numbers of an answer, bit by bit, NaN included.
fn bits(foot: &SurfaceFootpoint) -> ([u64; 8], String) {
    let [u, v] = foot.parameter;
    let p = foot.point;
    let numbers = [u, v, p.x, p.y, p.z, foot.distance, foot.signed_distance, foot.lower_bound];
    let words = format!(
        "{} {} {:?} {:?} {}",
        foot.shape, foot.status, foot.location, foot.multiplicity, foot.iterations
    );
    (numbers.map(f64::to_bits), words)
}

fn curve_bits<const D: usize>(foot: &CurveFootpoint<D>) -> (Vec<u64>, String) {
    let mut numbers = vec![foot.parameter.to_bits(), foot.distance.to_bits(), foot.lower_bound.to_bits()];
    numbers.extend(foot.point.iter().map(|c| c.to_bits()));
    let words = format!(
        "{} {} {:?} {:?} {}",
        foot.shape, foot.status, foot.location, foot.multiplicity, foot.iterations
    );
    (numbers, words)
}

/// Points of a spiral through the box [-6, 6]³, in no particular order of parameters: more than one task.
fn many<const D: usize>(count: usize) -> Vec<SVector<f64, D>> {
    let step = [0.754_877_666, 0.569_840_291, 0.430_159_709];
    let coordinate = |i: usize, d: usize| 12.0 * (0.5 + i as f64 * step[d]).fract() - 6.0;
    (0..count).map(|i| SVector::from_fn(|d, _| coordinate(i, d))).collect()
}

fn check_surface(
    surface: &nurbs_core::BsplineSurface,
    points: &[Vector3<f64>],
    mode: Mode,
) -> Result<(), TestCaseError> {
    let projector = SurfaceProjector::new(surface);
    let options = ProjectionOptions::default().with_mode(mode);
    let run =
        |threads| with_threads(threads, || projector.project_many(points, &options, &no_progress).unwrap());
    let (one, two) = (run(1), run(2));
    prop_assert_eq!(one.len(), points.len());
    for (i, (a, b)) in one.iter().zip(&two).enumerate() {
        prop_assert_eq!(bits(a), bits(b), "point {} with one and two threads", i);
        if mode == Mode::Certified {
            let alone = projector.project(&points[i]);
            let tolerance = 1e-10 * (alone.distance + 20.0);
            prop_assert!((alone.distance - a.distance).abs() <= tolerance, "{}: {:?} {:?}", i, alone, a);
            prop_assert!(a.lower_bound <= a.distance && a.status.is_converged());
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(config(16))]

    #[test]
    fn batches_of_surfaces(surface in surface(), points in prop::collection::vec(query::<3>(), 1..40)) {
        check_surface(&surface, &points, Mode::Certified)?;
    }

    #[test]
    fn batches_of_regular_surfaces(surface in regular_surface()) {
        let points = many(1500);
        check_surface(&surface, &points, Mode::Certified)?;
        check_surface(&surface, &points, Mode::Fast)?;
        check_surface(&surface, &points, Mode::Local)?;
    }

    #[test]
    fn batches_of_curves(curve in plane_curve()) {
        let projector = CurveProjector::new(&curve);
        let points = many::<2>(1500);
        for mode in [Mode::Certified, Mode::Fast, Mode::Local] {
            let options = ProjectionOptions::default().with_mode(mode);
            let run = |threads| with_threads(threads, || projector.project_many(&points, &options, &no_progress).unwrap());
            let (one, two) = (run(1), run(2));
            for (i, (a, b)) in one.iter().zip(&two).enumerate() {
                prop_assert_eq!(curve_bits(a), curve_bits(b));
                if mode == Mode::Certified {
                    let alone = projector.project(&points[i]);
                    let tolerance = 1e-10 * (alone.distance + 20.0);
                    prop_assert!((alone.distance - a.distance).abs() <= tolerance, "{:?} {:?}", alone, a);
                }
            }
        }
    }

    #[test]
    fn inversion_of_surfaces(surface in regular_surface(), at in [0.0..=1.0, 0.0..=1.0]) {
        let domain = surface.domain();
        let [u, v] = [domain[0].lerp(at[0]), domain[1].lerp(at[1])];
        let x = surface.point(u, v);
        let foot = SurfaceProjector::new(&surface).invert(&x, 1e-9).unwrap();
        // A height field: no second parameter has the same point.
        prop_assert!((foot.parameter[0] - u).abs() < 1e-8 && (foot.parameter[1] - v).abs() < 1e-8, "{:?}", foot);
    }

    #[test]
    fn inversion_of_curves(curve in plane_curve(), at in 0.0..=1.0) {
        let x = curve.point(curve.domain().lerp(at));
        let foot = CurveProjector::new(&curve).invert(&x, 1e-9).unwrap();
        prop_assert!((curve.point(foot.parameter) - x).norm() < 1e-9, "{:?}", foot);
    }
}

#[test]
fn points_off_the_shape_are_not_inverted() {
    let projector = SurfaceProjector::new(&rectangle(2.0, 1.0, 0.0));
    let x = Vector3::new(1.0, 0.5, 1e-3);
    assert_eq!(projector.invert(&x, 2e-3).unwrap().parameter, [0.5, 0.5]);
    let error = projector.invert(&x, 1e-4).unwrap_err();
    assert_eq!(error, Error::NotOnShape { distance: 1e-3, tolerance: 1e-4 });
    assert!(error.to_string().contains("0.001") && error.to_string().contains("0.0001"), "{error}");
    let nan = Vector3::new(f64::NAN, 0.0, 0.0);
    assert_eq!(projector.invert(&nan, 1.0).unwrap_err(), Error::NonFinitePoint { index: 0 });
    let curve = CurveProjector::new(&parabola());
    assert!(matches!(curve.invert(&Vector2::new(0.0, -1.0), 0.5), Err(Error::NotOnShape { .. })));
    assert!(matches!(
        curve.invert(&Vector2::new(0.0, f64::INFINITY), 0.5),
        Err(Error::NonFinitePoint { .. })
    ));
}

#[test]
fn points_that_are_not_finite() {
    let projector = SurfaceProjector::new(&rectangle(2.0, 1.0, 0.0));
    let mut points = vec![Vector3::new(0.3, 0.4, 1.0); 6];
    points[1].x = f64::NAN;
    points[3].y = f64::INFINITY;
    points[5].z = f64::NEG_INFINITY;
    for mode in [Mode::Certified, Mode::Fast, Mode::Local] {
        let options = ProjectionOptions::default().with_mode(mode);
        let feet = projector.project_many(&points, &options, &no_progress).unwrap();
        for (i, foot) in feet.iter().enumerate() {
            if i % 2 == 1 {
                assert_eq!(foot.status, Status::InvalidPoint);
                assert!(foot.distance.is_nan() && foot.point.iter().all(|c| c.is_nan()), "{foot:?}");
                assert_eq!(
                    projector.project_with(&points[i], &options).unwrap().status,
                    Status::InvalidPoint
                );
            } else {
                assert_eq!((foot.status, foot.distance), (Status::Converged, 1.0));
            }
        }
    }
    assert_eq!(projector.project_from(&points[1], 0, [0.5, 0.5]).status, Status::InvalidPoint);
    let curve = CurveProjector::new(&parabola());
    assert_eq!(curve.project(&Vector2::new(f64::NAN, 0.0)).status, Status::InvalidPoint);
    assert!(projector.project_many(&[], &ProjectionOptions::default(), &no_progress).unwrap().is_empty());
}

#[test]
fn starts_that_do_not_exist() {
    let projector = SurfaceProjector::new(&rectangle(2.0, 1.0, 0.0));
    let x = Vector3::new(0.3, 0.4, 1.0);
    assert!(!projector.project_from(&x, 7, [0.5, 0.5]).status.is_converged());
    // Parameters outside the domain start at its border.
    for start in [[-5.0, 0.5], [0.5, 1e300], [f64::INFINITY, f64::NEG_INFINITY], [f64::NAN, 0.5]] {
        let foot = projector.project_from(&x, 0, start);
        assert!((foot.distance - 1.0).abs() < 1e-12, "{start:?}: {foot:?}");
    }
    let curve = CurveProjector::new(&parabola());
    let x = Vector2::new(0.3, -0.2);
    let best = curve.project(&x).distance;
    assert!(!curve.project_from(&x, 1, 0.5).status.is_converged());
    for start in [-5.0, 1e300, f64::NAN] {
        let foot = curve.project_from(&x, 0, start);
        assert!((foot.distance - best).abs() < 1e-12, "{start:?}: {foot:?}");
    }
}

#[test]
fn a_model_needs_shapes() {
    assert_eq!(SurfaceProjector::for_model(&[]).unwrap_err(), Error::EmptyModel);
    assert_eq!(CurveProjector::<2>::for_model(&[]).unwrap_err(), Error::EmptyModel);
}

#[test]
fn progress_counts_and_cancels() {
    let torus = Torus::new(Frame::WORLD, 3.0, 1.0).unwrap().to_nurbs().unwrap();
    let projector = SurfaceProjector::new(&torus);
    let points = many::<3>(5000);
    let options = ProjectionOptions::default();
    for threads in [1, 2] {
        let (calls, largest) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let count = |done: usize, total: usize| {
            assert_eq!(total, 5000);
            calls.fetch_add(1, Ordering::Relaxed);
            largest.fetch_max(done, Ordering::Relaxed);
            ControlFlow::Continue(())
        };
        let feet = with_threads(threads, || projector.project_many(&points, &options, &count).unwrap());
        assert!(feet.iter().all(|f| f.status.is_converged()));
        assert_eq!(largest.into_inner(), 5000);
        assert!(calls.into_inner() > 3, "called more than once, so that it can cancel");

        let stop = |done: usize, _: usize| {
            if done > 1000 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let feet = with_threads(threads, || projector.project_many(&points, &options, &stop).unwrap());
        let done = feet.iter().filter(|f| f.status.is_converged()).count();
        let cancelled = feet.iter().filter(|f| f.status == Status::Cancelled).count();
        assert_eq!((done + cancelled, feet.len()), (5000, 5000));
        assert!(done > 1000 && cancelled > 1000, "{done} done, {cancelled} cancelled");
        // What was done is what it would have been without cancelling.
        for (x, foot) in points.iter().zip(&feet).filter(|(_, f)| f.status.is_converged()) {
            assert!((projector.project(x).distance - foot.distance).abs() <= 1e-12 * (8.0 + foot.distance));
        }
    }
}

#[test]
fn answers_print_in_one_line() {
    let foot = SurfaceProjector::new(&rectangle(2.0, 1.0, 0.0)).project(&Vector3::new(0.5, 0.5, -2.0));
    let text = foot.to_string();
    assert!(
        text.contains("u = 0.25") && text.contains("distance = 2") && text.contains("converged"),
        "{text}"
    );
    let foot = CurveProjector::new(&parabola()).project(&Vector2::new(0.0, -1.0));
    assert!(foot.to_string().starts_with("t = 0.5, distance = 1, converged"), "{foot}");
}

#[test]
fn options_are_checked() {
    assert!(ProjectionOptions::default().validate().is_ok());
    for value in [-1e-9, 1.0, f64::NAN, f64::INFINITY] {
        let error = ProjectionOptions::default().with_relative_gap(value).validate().unwrap_err();
        assert!(matches!(error, Error::Option { option: "relative_gap", .. }), "{error}");
        let error = ProjectionOptions::default().with_size_gap(value).validate().unwrap_err();
        assert!(matches!(error, Error::Option { option: "size_gap", .. }), "{error}");
    }
}
