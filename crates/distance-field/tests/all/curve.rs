//! Frames and models of NURBS curves in the plane and in space.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests may panic")]

use crate::common::{Numbers, check_frame, global_frame, taylor_order};
use distance_field::{CurveField, DistanceField, ErrorTerm, Hint, Search};
use footpoint::Status;
use nalgebra::{Rotation2, SVector, Vector2, Vector3};
use nurbs_core::{BsplineCurve, Circle, KnotVector, ParametricCurve};

fn wave() -> BsplineCurve<2> {
    let points = (0..9u8).map(|i| {
        let x = f64::from(i) * 0.25 - 1.0;
        Vector2::new(x, 0.3 * (3.0 * x).sin())
    });
    BsplineCurve::new(KnotVector::uniform_clamped(3, 9).unwrap(), points.collect(), None).unwrap()
}

fn coil() -> BsplineCurve<3> {
    let points = (0..14u8).map(|i| {
        let t = 0.6 * f64::from(i);
        Vector3::new(t.cos(), t.sin(), 0.2 * t)
    });
    BsplineCurve::new(KnotVector::uniform_clamped(4, 14).unwrap(), points.collect(), None).unwrap()
}

fn orders<const D: usize>(curve: &BsplineCurve<D>, reach: f64) -> Vec<f64> {
    let (field, mut numbers) = (CurveField::new(curve).unwrap(), Numbers::new(7));
    let mut orders = Vec::new();
    for i in 0..30 {
        let jet = curve.jet(curve.domain().lerp(0.5 + 0.4 * numbers.next()));
        let tangent = jet.unit_tangent().unwrap();
        let out = numbers.direction::<D>();
        let x = jet.point + (out - tangent * tangent.dot(&out)) * reach * (0.5 + 0.4 * numbers.next());
        let frame = global_frame(&field, &x);
        check_frame(&frame, &x, 1e-8);
        assert_eq!((frame.tangent_dimension, frame.on_boundary), (1, false));
        orders.extend(taylor_order(&field, &x, 0.01, i));
    }
    orders
}

#[test]
fn taylor_models_have_the_third_order() {
    for orders in [orders(&wave(), 0.2), orders(&coil(), 0.3)] {
        assert!(orders.len() >= 20 && orders.iter().all(|order| *order >= 2.9), "{orders:?}");
    }
}

#[test]
fn ends_are_points() {
    let field = CurveField::new(&coil()).unwrap();
    let x = Vector3::new(1.2, -0.5, -0.2);
    let frame = global_frame(&field, &x);
    check_frame(&frame, &x, 1e-14);
    assert_eq!((frame.tangent_dimension, frame.on_boundary, frame.status), (0, true, Status::OnBoundary));
    let model = field.quadratic(&x, ErrorTerm::Taylor);
    let y = x + Vector3::new(0.03, -0.02, -0.05);
    assert!((model.value(&y) - field.distance(&y).powi(2)).abs() < 1e-13);
}

#[test]
fn the_plane_has_two_sides() {
    let curve = wave();
    let field = CurveField::new(&curve).unwrap();
    let jet = curve.jet(0.4);
    let left = Vector2::new(-jet.d1.y, jet.d1.x).normalize();
    for distance in [-0.1, -1e-13, 0.0, 1e-13, 0.1] {
        let frame = global_frame(&field, &(jet.point + left * distance));
        assert!((frame.distance - distance).abs() < 1e-12, "{distance} {frame:?}");
        assert!((frame.normal() - left).norm() < 1e-6);
    }
    // A square: its corners hold the foot, outside is on the right.
    let corners = [[0., 0.], [1., 0.], [1., 1.], [0., 1.], [0., 0.]].map(Vector2::from).to_vec();
    let square =
        BsplineCurve::new(KnotVector::new(1, vec![0., 0., 1., 2., 3., 4., 4.]).unwrap(), corners, None)
            .unwrap();
    let field = CurveField::new(&square).unwrap();
    for (x, distance, tangent_dimension) in [
        ([1.3, 1.4], -0.5, 0),
        ([-0.3, -0.4], -0.5, 0),
        ([1.001, -5.0], -(25.0f64 + 1e-6).sqrt(), 0),
        ([5.0, -0.001], -(16.0f64 + 1e-6).sqrt(), 0),
        ([0.4, 0.1], 0.1, 1),
        ([0.5, 1.25], -0.25, 1),
    ] {
        let frame = global_frame(&field, &Vector2::from(x));
        assert!((frame.distance - distance).abs() < 1e-12, "{x:?} {frame:?}");
        assert_eq!((frame.tangent_dimension, frame.on_boundary), (tangent_dimension, false), "{x:?}");
    }
}

#[test]
fn circles_have_their_curvature_everywhere() {
    let circle = Circle::<2>::new(Vector2::new(1e6, -2e6), 2.0).unwrap().to_nurbs().unwrap();
    let field = CurveField::new(&circle).unwrap();
    for i in 0..24u8 {
        let (sine, cosine) = (f64::from(i) * std::f64::consts::TAU / 24.0).sin_cos();
        let x = Vector2::new(1e6, -2e6) + Vector2::new(cosine, sine) * 3.0;
        let frame = global_frame(&field, &x);
        assert!((frame.distance + 1.0).abs() < 1e-8, "{frame:?}");
        assert!((frame.curvatures[0] - 0.5).abs() < 1e-8);
        assert!(!frame.on_boundary);
    }
}

#[test]
fn warm_searches_agree_with_the_global_one() {
    fn check<const D: usize>(curve: &BsplineCurve<D>) {
        let (field, mut numbers) = (CurveField::new(curve).unwrap(), Numbers::new(11));
        let mut points: Vec<SVector<f64, D>> = (0..400)
            .map(|_| curve.point(curve.domain().lerp(0.5 + 0.5 * numbers.next())) + numbers.vector() * 0.05)
            .collect();
        let hints: Vec<Hint> = field.frames(&points, Search::Global, &[]).iter().map(|f| f.hint).collect();
        for x in &mut points {
            *x += numbers.vector() * 0.001;
        }
        let global = field.frames(&points, Search::Global, &[]);
        let local = field.frames(&points, Search::Local, &hints);
        let step = field.frames(&points, Search::OneStep, &hints);
        for i in 0..points.len() {
            assert!((local[i].foot - global[i].foot).norm() < 1e-7);
            assert!((step[i].foot - local[i].foot).norm() < 1e-4);
            assert!(step[i].is_finite());
        }
        points[3][0] = f64::NAN;
        for search in [Search::Global, Search::Local, Search::OneStep] {
            assert_eq!(field.frames(&points, search, &hints)[3].status, Status::InvalidPoint);
        }
    }
    check(&wave());
    check(&coil());
}

#[test]
fn models_turn_with_the_curve_and_do_not_depend_on_its_parameter() {
    let curve = wave();
    let (field, turn) = (CurveField::new(&curve).unwrap(), Rotation2::new(1.1));
    let turned =
        CurveField::new(&curve.transformed(turn.matrix(), &Vector2::new(3.0, 4.0)).unwrap()).unwrap();
    let reversed = CurveField::new(&curve.reversed().unwrap()).unwrap();
    let mut numbers = Numbers::new(2);
    for _ in 0..40 {
        let x = numbers.vector::<2>();
        let matrix = field.quadratic(&x, ErrorTerm::Taylor).matrix();
        let other = turned.quadratic(&(turn * x + Vector2::new(3.0, 4.0)), ErrorTerm::Taylor).matrix();
        assert!((turn.matrix() * matrix * turn.matrix().transpose() - other).norm() < 1e-6);
        assert!((matrix - reversed.quadratic(&x, ErrorTerm::Taylor).matrix()).norm() < 1e-6);
        let (one, two) = (global_frame(&field, &x), global_frame(&reversed, &x));
        assert!((one.distance + two.distance).abs() < 1e-10, "{one:?} {two:?}");
    }
}

#[test]
fn curves_without_length_do_no_harm() {
    let point = BsplineCurve::bezier(vec![Vector3::new(1.0, 2.0, 3.0); 3], None).unwrap();
    let field = CurveField::new(&point).unwrap();
    let x = Vector3::new(1.0, 2.0, 5.0);
    for search in [Search::Global, Search::Local, Search::OneStep] {
        let frame = field.frame(&x, search, &Hint { element: 0, parameter: [0.5, 0.0], ..Hint::NONE });
        check_frame(&frame, &x, 1e-12);
        assert!((frame.distance - 2.0).abs() < 1e-14);
        assert!(field.frame(&Vector3::new(1.0, 2.0, 3.0), search, &Hint::NONE).is_finite());
    }
    assert!(CurveField::<2>::for_model(&[]).is_err());
}
