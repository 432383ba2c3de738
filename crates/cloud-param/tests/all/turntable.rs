//! The turntable and its axis.

use crate::common;
use cloud_param::{AxisChoice, AxisOrigin, Sharpness, Turntable, estimate_axis};
use nalgebra::{Rotation3, Vector3};

#[test]
fn turning_and_turning_back() {
    let points = common::vase(500, 0.0);
    let table = Turntable::new(&points, &Vector3::new(0.2, -0.1, 1.0)).unwrap();
    for (k, p) in points.iter().enumerate() {
        let angle = k as f64 * 0.37;
        let seen = table.turned(p, angle);
        assert!((table.turned_back(&seen, angle) - p).norm() < 1e-12);
        assert!(seen.xy().norm() <= table.radius * (1.0 + 1e-12));
        assert!(seen.z >= table.heights[0] - 1e-12 && seen.z <= table.heights[1] + 1e-12);
    }
}

#[test]
fn finds_the_axis_of_a_turned_vase() {
    let turn = Rotation3::from_euler_angles(0.7, -0.4, 1.1);
    let points: Vec<_> =
        common::vase(6000, 0.005).iter().map(|p| turn * p + Vector3::new(100.0, -50.0, 7.0)).collect();
    let truth = turn * Vector3::z();
    let axis = estimate_axis(&points, AxisChoice::Automatic).unwrap();
    assert!(axis.direction.dot(&truth).abs() > 0.999, "{axis:?}");
    assert!(axis.coverage.mean() > 0.97);
    for choice in [AxisChoice::Principal, AxisChoice::Rotation] {
        let axis = estimate_axis(&points, choice).unwrap();
        assert!(axis.direction.dot(&truth).abs() > 0.95, "{choice:?} {axis:?}");
    }
    let given = estimate_axis(&points, AxisChoice::Given(Vector3::new(0.0, 0.0, -2.0))).unwrap();
    assert_eq!((given.direction, given.origin), (-Vector3::z(), AxisOrigin::Given));
    assert!(given.coverage.mean() < axis.coverage.mean());
    assert!(estimate_axis(&points, AxisChoice::Given(Vector3::zeros())).is_err());
    assert!(estimate_axis(&points[..5], AxisChoice::Automatic).is_err());
}

#[test]
fn a_short_wide_ring_has_the_axis_it_closes_around() {
    let ring: Vec<_> =
        (0..4000).map(common::scattered).map(|[a, h]| common::vase_point(a, 0.3 * h)).collect();
    let axis = estimate_axis(&ring, AxisChoice::Automatic).unwrap();
    assert!(axis.direction.z > 0.99, "{axis:?}");
}

#[test]
fn views_show_everything_of_a_vase() {
    let points = common::vase(6000, 0.0);
    let table = Turntable::new(&points, &Vector3::z()).unwrap();
    let (views, seen) = table.views_as_needed(&points, Sharpness::default()).unwrap();
    assert!(views.len() >= 4 && seen > 0.97, "{} {seen}", views.len());
    // The first view looks along the second axis: it shows the front.
    let front = (0..points.len()).filter(|&i| views[0].visible[i]);
    let depth: f64 = front.map(|i| table.turned(&points[i], views[0].angle).y).sum();
    assert!(depth > 0.0);
}
