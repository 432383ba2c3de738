//! Frames of clouds in the plane.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests may panic")]

use crate::common::{Numbers, check_frame};
use distance_field::{DistanceField, Error, Hint, PlanarCloudField, PrincipalFrame, Search};
use footpoint::Status;
use nalgebra::{Point2, Vector2};
use std::f64::consts::TAU;

fn global(field: &PlanarCloudField, x: Vector2<f64>) -> PrincipalFrame<2> {
    field.frame(&x, Search::Global, &Hint::NONE)
}

fn circle(count: u32, radius: f64, turn: f64) -> Vec<Point2<f64>> {
    let at = |i: u32| turn * f64::from(i) / f64::from(count);
    (0..count).map(|i| Point2::new(radius * at(i).cos(), radius * at(i).sin())).collect()
}

#[test]
fn a_dense_cloud_stands_for_its_curve() {
    let field = PlanarCloudField::new(&circle(300, 2.0, TAU), None).unwrap();
    assert_eq!(field.end_count(), 0);
    let mut numbers = Numbers::new(3);
    for _ in 0..300 {
        let direction = numbers.direction::<2>();
        let distance = 0.8 * numbers.next();
        let x = direction * (2.0 + distance);
        let frame = global(&field, x);
        check_frame(&frame, &x, 1e-4);
        assert!((frame.distance.abs() - distance.abs()).abs() < 1e-6, "{distance} {frame:?}");
        assert!((frame.foot - direction * 2.0).norm() < 1e-4, "{frame:?}");
        assert!((frame.curvatures[0].abs() - 0.5).abs() < 2e-3, "{frame:?}");
    }
}

#[test]
fn normals_tell_the_side() {
    let points = circle(100, 1.0, TAU);
    let inwards: Vec<Vector2<f64>> = points.iter().map(|p| -p.coords * 2.0).collect();
    let field = PlanarCloudField::new(&points, Some(&inwards)).unwrap();
    let mut numbers = Numbers::new(5);
    for _ in 0..100 {
        let (direction, distance) = (numbers.direction::<2>(), 0.5 * numbers.next());
        let frame = global(&field, direction * (1.0 - distance));
        assert!((frame.distance - distance).abs() < 1e-4 && frame.curvatures[0] > 0.9, "{frame:?}");
    }
    assert!(matches!(PlanarCloudField::new(&points, Some(&inwards[1..])), Err(Error::Mesh(_))));
}

#[test]
fn ends_and_gaps_are_found_and_feet_stay_there() {
    // Half a circle with a gap: four ends.
    let mut points = circle(200, 1.0, 0.5 * TAU);
    points.drain(80..120);
    let field = PlanarCloudField::new(&points, None).unwrap();
    assert_eq!(field.end_count(), 4);
    let below = global(&field, Vector2::new(1.0, -3.0));
    assert!(below.on_boundary && below.status == Status::OnBoundary);
    assert!((below.foot - Vector2::new(1.0, 0.0)).norm() < 0.02, "{below:?}");
    assert!(!global(&field, Vector2::new(0.9, 0.9)).on_boundary);
}

#[test]
fn what_is_no_curve_is_points() {
    // A square filled with points, two points, one point that stands many times.
    let filled: Vec<Point2<f64>> =
        (0..400u16).map(|i| Point2::new(f64::from(i % 20), f64::from(i / 20))).collect();
    let field = PlanarCloudField::new(&filled, None).unwrap();
    let x = Vector2::new(7.3, 8.4);
    let frame = global(&field, x);
    assert_eq!(frame.foot, Vector2::new(7.0, 8.0));
    assert!((frame.distance - 0.5).abs() < 1e-12 && frame.tangent_dimension == 0);
    for few in [&[Point2::new(1.0, 2.0); 7][..], &[Point2::new(1.0, 2.0), Point2::new(2.0, 2.0)]] {
        let frame = global(&PlanarCloudField::new(few, None).unwrap(), Vector2::new(1.0, 0.0));
        assert!((frame.distance - 2.0).abs() < 1e-12 && frame.on_boundary, "{frame:?}");
    }
}

#[test]
fn numbers_that_are_none_are_said() {
    assert!(matches!(PlanarCloudField::new(&[], None), Err(Error::NoPoints { count: 0 })));
    let nan = Point2::new(f64::NAN, 1.0);
    assert!(matches!(PlanarCloudField::new(&[nan], None), Err(Error::NoPoints { count: 1 })));
    let mut points = circle(50, 1.0, TAU);
    points[7] = nan;
    let field = PlanarCloudField::new(&points, None).unwrap();
    assert!(global(&field, Vector2::new(0.3, 0.2)).is_finite());
    assert_eq!(global(&field, Vector2::new(f64::NAN, 0.0)).status, Status::InvalidPoint);
    for scale in [1e-60, 1e60] {
        let scaled: Vec<_> = circle(50, scale, TAU);
        let frame = global(&PlanarCloudField::new(&scaled, None).unwrap(), Vector2::new(0.0, 1.5 * scale));
        assert!((frame.distance.abs() / scale - 0.5).abs() < 1e-3, "{frame:?}");
    }
}
