//! Frames and models of NURBS surfaces.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests may panic")]

use crate::common::{Numbers, check_frame, global_frame, taylor_order, wavy};
use distance_field::{DistanceField, ErrorTerm, Hint, Search, SurfaceField};
use footpoint::Status;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use nurbs_core::{BsplineSurface, Frame, Interval, KnotVector, ParametricSurface, Plane, Sphere, Torus};

fn near(surface: &BsplineSurface, u: f64, v: f64, distance: f64) -> Vector3<f64> {
    let jet = surface.jet(u, v);
    jet.point + jet.unit_normal().unwrap() * distance
}

#[test]
fn taylor_models_have_the_third_order_inside() {
    let (surface, mut numbers) = (wavy(), Numbers::new(3));
    let field = SurfaceField::new(&surface).unwrap();
    let mut orders = Vec::new();
    for i in 0..40 {
        let (u, v) = (0.5 + 0.35 * numbers.next(), 0.5 + 0.35 * numbers.next());
        let x = near(&surface, u, v, 0.2 * numbers.next());
        let frame = global_frame(&field, &x);
        check_frame(&frame, &x, 1e-8);
        assert!(!frame.on_boundary && frame.tangent_dimension == 2, "{frame:?}");
        orders.extend(taylor_order(&field, &x, 0.01, i));
    }
    assert!(orders.len() >= 30);
    let least = orders.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(least >= 2.9, "{orders:?}");
}

#[test]
fn edges_are_curves_and_corners_points() {
    let (surface, mut numbers) = (wavy(), Numbers::new(5));
    let field = SurfaceField::new(&surface).unwrap();
    let mut orders = Vec::new();
    for i in 0..20 {
        let t = 0.5 + 0.3 * numbers.next();
        let jet = surface.jet(0.0, t);
        let outwards = -jet.du.normalize();
        let x = jet.point + outwards * (0.1 + 0.05 * numbers.next()) + Vector3::z() * (0.1 * numbers.next());
        let frame = global_frame(&field, &x);
        check_frame(&frame, &x, 1e-7);
        assert!(frame.on_boundary && frame.tangent_dimension == 1, "{frame:?}");
        orders.extend(taylor_order(&field, &x, 0.01, i));
    }
    assert!(orders.len() >= 10 && orders.iter().all(|o| *o >= 2.9), "{orders:?}");
    let corner = surface.point(1.0, 1.0);
    let x = corner + Vector3::new(0.4, 0.5, 0.1);
    let frame = global_frame(&field, &x);
    check_frame(&frame, &x, 1e-8);
    assert!(frame.on_boundary && frame.tangent_dimension == 0);
    let model = field.quadratic(&x, ErrorTerm::Taylor);
    let y = x + Vector3::new(0.01, -0.02, 0.015);
    assert!((model.value(&y) - field.distance(&y).powi(2)).abs() < 1e-12);
}

#[test]
fn the_normal_is_continuous_through_the_surface() {
    let surface = wavy();
    let field = SurfaceField::new(&surface).unwrap();
    let normal = surface.jet(0.4, 0.6).unit_normal().unwrap();
    for distance in [-1e-3, -1e-12, 0.0, 1e-12, 1e-3] {
        let frame = global_frame(&field, &near(&surface, 0.4, 0.6, distance));
        assert!((frame.normal() - normal).norm() < 1e-7, "{distance}");
        assert!((frame.distance - distance).abs() < 1e-14, "{distance}");
    }
}

#[test]
fn limits_of_the_model() {
    let (surface, x) = (wavy(), Vector3::new(0.1, 0.0, 0.0));
    let field = SurfaceField::new(&surface).unwrap();
    let on = surface.point(0.3, 0.7);
    let model = field.quadratic(&on, ErrorTerm::Taylor);
    assert!(model.weights.xy().norm() < 1e-12 && model.weights.z == 1.0);
    // A sphere bends everywhere: far away all directions count alike.
    let sphere = SurfaceField::new(&Sphere::new(Frame::WORLD, 0.5).unwrap().to_nurbs().unwrap()).unwrap();
    let far = (x + Vector3::new(0.3, 0.4, 0.5)).normalize() * 1e6;
    let model = sphere.quadratic(&far, ErrorTerm::SquaredDistance);
    assert!((model.weights - Vector3::repeat(1.0)).norm() < 1e-5);
}

#[test]
fn hessians_are_those_of_the_squared_distance() {
    let surface = wavy();
    let field = SurfaceField::new(&surface).unwrap();
    for (u, v, d) in [(0.3, 0.4, 0.2), (0.7, 0.55, -0.3)] {
        let x = near(&surface, u, v, d);
        let hessian = field.quadratic(&x, ErrorTerm::Taylor).hessian();
        let h = 1e-3;
        let square = |a: f64, b: f64, i: usize, j: usize| {
            let mut y = x;
            y[i] += a * h;
            y[j] += b * h;
            field.distance(&y).powi(2)
        };
        for i in 0..3 {
            for j in 0..3 {
                let difference = (square(1., 1., i, j) - square(1., -1., i, j) - square(-1., 1., i, j)
                    + square(-1., -1., i, j))
                    / (4.0 * h * h);
                assert!((difference - hessian[(i, j)]).abs() < 1e-4, "{i}{j} {difference} {hessian}");
            }
        }
    }
}

#[test]
fn poles_have_the_curvatures_of_the_sphere() {
    for (surface, name) in [
        (Sphere::new(Frame::WORLD, 2.0).unwrap().to_nurbs().unwrap(), "whole"),
        (
            Sphere::new(Frame::WORLD, 2.0)
                .unwrap()
                .with_domain(
                    Interval::new(0.0, std::f64::consts::TAU).unwrap(),
                    Interval::new(0.2, std::f64::consts::FRAC_PI_2).unwrap(),
                )
                .unwrap()
                .to_nurbs()
                .unwrap(),
            "cap",
        ),
    ] {
        let field = SurfaceField::new(&surface).unwrap();
        for offset in [0.0, 1e-13, 1e-10, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-2] {
            for height in [3.0, 1.2] {
                let x = Vector3::new(offset, 0.3 * offset, height);
                let frame = global_frame(&field, &x);
                check_frame(&frame, &x, 3e-8);
                assert_eq!(frame.tangent_dimension, 2, "{name} {offset}");
                assert!(!frame.on_boundary);
                let error = (frame.curvatures.xy().map(|k| k + 0.5)).norm();
                assert!(error < 1e-4, "{name}, {offset} beside the pole: {:?}", frame.curvatures);
            }
        }
    }
}

#[test]
fn seams_are_not_ends_and_kinks_hold_the_foot() {
    let torus = Torus::new(Frame::WORLD, 3.0, 1.0).unwrap().to_nurbs().unwrap();
    let field = SurfaceField::new(&torus).unwrap();
    let x = Vector3::new(4.5, 0.0, 0.0);
    let frame = global_frame(&field, &x);
    check_frame(&frame, &x, 1e-8);
    assert!(!frame.on_boundary && frame.tangent_dimension == 2 && (frame.distance - 0.5).abs() < 1e-13);
    // A roof: degree 1 in u with its ridge at u = 1/2.
    let knots = KnotVector::new(1, vec![0.0, 0.0, 0.5, 1.0, 1.0]).unwrap();
    let line = KnotVector::bezier(1, Interval::UNIT).unwrap();
    let points = [[-1., 0., 0.], [-1., 1., 0.], [0., 0., 1.], [0., 1., 1.], [1., 0., 0.], [1., 1., 0.]];
    let roof = BsplineSurface::new(knots, line, points.map(Vector3::from).to_vec(), None).unwrap();
    let field = SurfaceField::new(&roof).unwrap();
    let x = Vector3::new(0.05, 0.5, 2.0);
    let frame = global_frame(&field, &x);
    check_frame(&frame, &x, 1e-8);
    assert!(!frame.on_boundary && frame.tangent_dimension == 1, "{frame:?}");
    assert!((frame.axes.column(0).y.abs() - 1.0).abs() < 1e-14);
}

#[test]
fn warm_searches_agree_with_the_global_one() {
    let (surface, mut numbers) = (wavy(), Numbers::new(9));
    let field = SurfaceField::for_model(&[
        surface.clone(),
        surface.translated(&Vector3::new(0.0, 0.0, 1.5)).unwrap(),
    ])
    .unwrap();
    let mut points: Vec<Vector3<f64>> = (0..3000)
        .map(|_| {
            let (u, v) = (0.5 + 0.52 * numbers.next(), 0.5 + 0.52 * numbers.next());
            near(&surface, u.clamp(0.0, 1.0), v.clamp(0.0, 1.0), 0.2 * numbers.next())
                + if u > 0.5 { Vector3::z() * 1.5 } else { Vector3::zeros() }
        })
        .collect();
    let before = field.frames(&points, Search::Global, &[]);
    let mut hints: Vec<Hint> = before.iter().map(|f| f.hint).collect();
    for x in &mut points {
        *x += numbers.vector() * 0.002;
    }
    points[17].y = f64::NAN;
    hints[19] = Hint::NONE;
    let global = field.frames(&points, Search::Global, &[]);
    let local = field.frames(&points, Search::Local, &hints);
    let step = field.frames(&points, Search::OneStep, &hints);
    let mut one_step_error = 0.0f64;
    for i in 0..points.len() {
        if i == 17 {
            for frame in [&global[i], &local[i], &step[i]] {
                assert_eq!(frame.status, Status::InvalidPoint);
                assert!(!frame.is_finite());
            }
            continue;
        }
        check_frame(&local[i], &points[i], 1e-8);
        let single = field.frame(&points[i], Search::Local, &hints[i]);
        assert!((local[i].foot - single.foot).norm() < 1e-8, "{i} {:?} {single:?}", local[i]);
        assert!(local[i].distance.abs() + 1e-12 >= global[i].distance.abs());
        assert!(
            (local[i].distance - global[i].distance).abs() < 1e-9
                || (global[i].foot - before[i].foot).norm() > 0.05
        );
        let gap = (step[i].foot - local[i].foot).norm();
        one_step_error = one_step_error.max(gap);
        let again = field.frame(&points[i], Search::OneStep, &hints[i]);
        assert!((again.foot - step[i].foot).norm() < 1e-8);
    }
    assert!(one_step_error < 1e-4 && one_step_error > 0.0, "{one_step_error}");
}

#[test]
fn models_move_with_the_shape() {
    let surface = wavy();
    let field = SurfaceField::new(&surface).unwrap();
    let motion = Isometry3::from_parts(
        Translation3::new(3e5, -2e5, 4e5),
        UnitQuaternion::from_scaled_axis(Vector3::new(0.4, -1.1, 0.3)),
    );
    let moved = SurfaceField::new(&surface.moved(&motion).unwrap()).unwrap();
    let scale = 1e-3;
    let scaled = SurfaceField::new(&surface.scaled(scale, &Vector3::zeros()).unwrap()).unwrap();
    let reversed = SurfaceField::new(&surface.transposed().unwrap()).unwrap();
    let mut numbers = Numbers::new(12);
    for _ in 0..50 {
        let x = near(&surface, 0.5 + 0.5 * numbers.next(), 0.5 + 0.5 * numbers.next(), 0.3 * numbers.next());
        let matrix = field.quadratic(&x, ErrorTerm::Taylor).matrix();
        let turn = motion.rotation.to_rotation_matrix().into_inner();
        let other = moved.quadratic(&(motion * nalgebra::Point3::from(x)).coords, ErrorTerm::Taylor).matrix();
        assert!((turn * matrix * turn.transpose() - other).norm() < 1e-7, "{matrix} {other}");
        let other = scaled.quadratic(&(x * scale), ErrorTerm::Taylor).matrix();
        assert!((matrix - other).norm() < 1e-9);
        let other = reversed.quadratic(&x, ErrorTerm::Taylor).matrix();
        assert!((matrix - other).norm() < 1e-9);
        let sum = reversed.distance(&x) - field.distance(&x);
        assert!(sum.abs() < 1e-12);
    }
}

#[test]
fn degenerate_surfaces_and_queries_do_no_harm() {
    let line = KnotVector::bezier(1, Interval::UNIT).unwrap();
    for points in [
        [[0.0; 3]; 4],
        [[0., 0., 0.], [1., 0., 0.], [0., 0., 0.], [1., 0., 0.]],
        [[0., 0., 0.], [1., 0., 0.], [2., 0., 0.], [3., 0., 0.]],
    ] {
        let surface =
            BsplineSurface::new(line.clone(), line.clone(), points.map(Vector3::from).to_vec(), None)
                .unwrap();
        let field = SurfaceField::new(&surface).unwrap();
        let x = Vector3::new(0.5, 1.0, 2.0);
        for search in [Search::Global, Search::Local, Search::OneStep] {
            let frame = field.frame(&x, search, &Hint { element: 0, parameter: [0.3, 0.4], ..Hint::NONE });
            check_frame(&frame, &x, 3e-8);
            for x in [Vector3::repeat(f64::NAN), Vector3::new(f64::INFINITY, 0.0, 0.0)] {
                let frame =
                    field.frame(&x, search, &Hint { element: 0, parameter: [f64::NAN, 0.4], ..Hint::NONE });
                assert!(frame.status == Status::InvalidPoint && !frame.is_finite());
            }
        }
    }
    assert!(SurfaceField::for_model(&[]).is_err());
    let plane = Plane::new(Frame::WORLD, Interval::UNIT, Interval::UNIT).to_nurbs().unwrap();
    let field = SurfaceField::new(&plane).unwrap();
    assert!((field.distance(&Vector3::new(0.5, 0.5, -2.0)) - 2.0).abs() < 1e-15);
    assert!(global_frame(&field, &Vector3::new(0.5, 0.5, -2.0)).distance < 0.0);
}
