//! Analytic shapes against closed forms and against their NURBS.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests may panic")]

use crate::common::{Numbers, check_frame, global_frame, taylor_order};
use distance_field::{
    AnalyticCurveField, AnalyticField, DistanceField, ErrorTerm, Hint, Search, SurfaceField,
};
use footpoint::Status;
use nalgebra::{Vector2, Vector3};
use nurbs_core::{AnalyticSurface, Circle, Cone, Cylinder, Frame, Interval, Line, Plane, Sphere, Torus};

fn shapes() -> Vec<AnalyticSurface> {
    let frame = Frame::new(Vector3::new(0.1, -0.2, 0.3), Vector3::new(0.2, 0.3, 1.0), Vector3::x()).unwrap();
    let unit = Interval::UNIT;
    vec![
        Plane::new(frame, unit, unit).into(),
        Sphere::new(frame, 0.8).unwrap().into(),
        Sphere::new(frame, 0.8).unwrap().with_domain(Interval::new(0.0, 2.0).unwrap(), unit).unwrap().into(),
        Cylinder::new(frame, 0.7, Interval::new(-0.5, 0.5).unwrap()).unwrap().into(),
        Cone::new(frame, 0.9, 0.2, 1.1).unwrap().into(),
        Cone::new(frame, 0.9, 0.0, 1.1).unwrap().into(),
        Torus::new(frame, 0.8, 0.3).unwrap().into(),
    ]
}

#[test]
fn the_same_models_as_those_of_the_nurbs() {
    let mut numbers = Numbers::new(21);
    for shape in shapes() {
        let exact = AnalyticField::new(shape).unwrap();
        let nurbs = SurfaceField::new(&shape.to_nurbs().unwrap()).unwrap();
        for i in 0..60 {
            let x = numbers.vector() * 1.5;
            let (one, other) = (global_frame(&exact, &x), global_frame(&nurbs, &x));
            check_frame(&one, &x, 1e-12);
            assert!((one.distance - other.distance).abs() < 1e-9, "{shape:?} {x} {one:?} {other:?}");
            let models = [&one, &other].map(|f| ErrorTerm::Taylor.model(f).matrix());
            let gap = (models[0] - models[1]).norm() / (1.0 + models[0].norm());
            assert!(gap < 1e-5, "{shape:?} {i} {one:?} {other:?}");
            assert_eq!(one.on_boundary, other.on_boundary, "{shape:?}");
        }
    }
}

#[test]
fn taylor_models_have_the_third_order() {
    let mut numbers = Numbers::new(4);
    for (k, shape) in shapes().into_iter().enumerate() {
        let field = AnalyticField::new(shape).unwrap();
        let (mut count, mut good) = (0, 0);
        for i in 0..25 {
            let x = numbers.vector() * 1.2;
            if let Some(order) = taylor_order(&field, &x, 2e-3, i) {
                count += 1;
                good += usize::from(order >= 2.9);
            }
        }
        // The query may lie beside the cut locus or on the border between two kinds of feet.
        assert!(good * 10 >= count * 8, "shape {k}: {good} of {count}");
    }
}

#[test]
fn an_apex_is_a_point() {
    let cone = Cone::new(Frame::WORLD, 1.0, 0.0, 1.0).unwrap();
    for frame in [
        global_frame(&AnalyticField::new(cone).unwrap(), &Vector3::new(0.1, 0.0, 2.0)),
        global_frame(&SurfaceField::new(&cone.to_nurbs().unwrap()).unwrap(), &Vector3::new(0.1, 0.0, 2.0)),
    ] {
        assert_eq!((frame.tangent_dimension, frame.on_boundary), (0, false), "{frame:?}");
        assert!((frame.distance - 1.01f64.sqrt()).abs() < 1e-12);
    }
}

#[test]
fn lines_and_circles() {
    let line = Line::new(Vector3::zeros(), Vector3::new(2.0, 0.0, 0.0)).unwrap();
    let field = AnalyticCurveField::new(line).unwrap();
    let frame = global_frame(&field, &Vector3::new(0.5, 3.0, 4.0));
    assert_eq!((frame.distance, frame.tangent_dimension, frame.curvatures[0]), (5.0, 1, 0.0));
    assert_eq!(global_frame(&field, &Vector3::new(-3.0, 4.0, 0.0)).tangent_dimension, 0);
    let circle = AnalyticCurveField::new(Circle::<2>::new(Vector2::zeros(), 2.0).unwrap()).unwrap();
    let frame = circle.frame(&Vector2::new(0.5, 0.0), Search::OneStep, &Hint::NONE);
    assert!((frame.distance - 1.5).abs() < 1e-15 && (frame.curvatures[0] - 0.5).abs() < 1e-15);
    assert!(circle.frame(&Vector2::zeros(), Search::Global, &Hint::NONE).is_finite());
    let nowhere = Vector2::new(f64::NAN, 0.0);
    assert_eq!(circle.frame(&nowhere, Search::Global, &Hint::NONE).status, Status::InvalidPoint);
}

#[test]
fn centres_and_axes_do_no_harm() {
    for shape in shapes() {
        let field = AnalyticField::new(shape).unwrap();
        for x in [Vector3::new(0.1, -0.2, 0.3), Vector3::new(0.2, -0.05, 0.8), Vector3::repeat(1e200)] {
            let frame = global_frame(&field, &x);
            assert!(frame.is_finite() || frame.status == Status::Diverged);
            let model = ErrorTerm::Taylor.model(&frame);
            assert!(model.weights.iter().all(|w| w.is_finite()));
        }
        assert!(!global_frame(&field, &Vector3::new(0.0, f64::INFINITY, 0.0)).is_finite());
    }
}
