//! Polylines against brute force and closed forms.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use mesh_core::nalgebra::{Point, Point2, Point3};
use mesh_core::{Error, Polyline};
use proptest::prelude::*;

#[test]
fn a_circle_has_its_length_and_distances() {
    let count = 2000;
    let at = |i: f64| Point2::new((i / f64::from(count)).cos(), (i / f64::from(count)).sin());
    let step = std::f64::consts::TAU;
    let circle = Polyline::new((0..count).map(|i| at(step * f64::from(i))).collect(), true).unwrap();
    assert!((circle.length() - std::f64::consts::TAU).abs() < 3e-6);
    for i in 0..100 {
        let x = at(step * f64::from(i) * 17.3) * 1.7;
        let foot = circle.closest(&x).unwrap();
        assert!((foot.distance - 0.7).abs() < 2e-6);
        assert!((circle.point_at(foot.arc_length) - foot.point).norm() < 1e-12);
        assert!((circle.point_at(foot.arc_length + circle.length()) - foot.point).norm() < 1e-12);
    }
    assert_eq!(circle.segment(2000), None);
    assert_eq!(circle.segment(1999).unwrap()[1], Point2::new(1.0, 0.0));
}

#[test]
fn vertices_and_segments_are_told_apart() {
    let p = |x: f64, y: f64| Point2::new(x, y);
    let line = Polyline::new(vec![p(0.0, 0.0), p(2.0, 0.0), p(2.0, 0.0), p(2.0, 2.0)], false).unwrap();
    let corner = line.closest(&p(3.0, -1.0)).unwrap();
    assert_eq!((corner.segment, corner.vertex, corner.arc_length), (0, Some(1), 2.0));
    let within = line.closest(&p(3.0, 1.5)).unwrap();
    assert_eq!((within.segment, within.vertex, within.arc_length), (2, None, 3.5));
    let end = line.closest(&p(2.0, 9.0)).unwrap();
    assert_eq!((end.vertex, end.distance), (Some(3), 7.0));
    // Equally far from both segments: the first counts.
    assert_eq!(line.closest(&p(1.0, 1.0)).unwrap().segment, 0);
    assert_eq!((line.point_at(-1.0), line.point_at(9.0)), (p(0.0, 0.0), p(2.0, 2.0)));
    assert_eq!(line.direction(1), None);
    assert_eq!(line.cumulative_lengths(), [0.0, 2.0, 2.0, 4.0]);
}

#[test]
fn bad_input_is_an_error() {
    let p = |x: f64| Point3::new(x, 0.0, 0.0);
    assert!(matches!(Polyline::<3>::new(vec![], false), Err(Error::TooFew { count: 0, .. })));
    assert!(matches!(Polyline::new(vec![p(1.0)], true), Err(Error::TooFew { count: 1, .. })));
    assert!(matches!(
        Polyline::new(vec![p(1.0), p(f64::NAN)], true),
        Err(Error::NonFiniteVertex { index: 1 })
    ));
    let dot = Polyline::new(vec![p(1.0); 3], true).unwrap();
    assert_eq!((dot.length(), dot.closest(&p(3.0)).unwrap().distance, dot.point_at(5.0)), (0.0, 2.0, p(1.0)));
    for x in [f64::NAN, f64::INFINITY, 1e300] {
        assert!(matches!(dot.closest(&p(x)), Err(Error::NonFiniteQuery { .. })));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, rng_seed: prop::test_runner::RngSeed::Fixed(7), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn agrees_with_brute_force(vertices in prop::collection::vec(prop::array::uniform3((-4i8..5).prop_map(f64::from)), 2..80), x in prop::array::uniform3(-6.0..6.0f64), closed in any::<bool>()) {
        let line = Polyline::new(vertices.into_iter().map(Point::from).collect(), closed).unwrap();
        let x = Point3::from(x);
        let foot = line.closest(&x).unwrap();
        let best = (0..line.segment_count()).map(|i| {
            let [a, b] = line.segment(i).unwrap();
            let d = b - a;
            let t = if d.norm() > 0.0 { ((x - a).dot(&d) / d.norm_squared()).clamp(0.0, 1.0) } else { 0.0 };
            (a + d * t - x).norm()
        }).fold(f64::INFINITY, f64::min);
        prop_assert!((foot.distance - best).abs() < 1e-12);
        let [a, b] = line.segment(foot.segment).unwrap();
        prop_assert!((a + (b - a) * foot.parameter - foot.point).norm() < 1e-14);
    }
}
