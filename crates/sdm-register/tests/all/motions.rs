//! Poses and rotations against numbers worked out by hand, and the limits of what is taken for a motion.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use sdm_register::{Displacement, Error, Pose, rotation};

fn turn(axis: Vector3<f64>, degrees: f64) -> Matrix3<f64> {
    rotation::from_axis_angle(&axis, degrees.to_radians()).unwrap()
}

fn is_refused<T>(result: Result<T, Error>) -> bool {
    matches!(result, Err(Error::NotAMotion { .. }))
}

#[test]
fn quaternions_have_a_positive_first_component_at_every_angle() {
    let (sine, cosine) = (0.6, 0.8);
    for axis in
        [Vector3::new(sine, 0.0, cosine), Vector3::new(0.0, -cosine, sine), Vector3::x(), -Vector3::z()]
    {
        for degrees in [10.0f64, 100.0, 170.0, 190.0, 230.0, 300.0, 350.0, 370.0] {
            // [cos φ/2, a sin φ/2] or its opposite.
            let half = degrees.to_radians() * 0.5;
            let sign = half.cos().signum();
            let vector = axis * (half.sin() * sign);
            let expected = [half.cos() * sign, vector.x, vector.y, vector.z];
            let found = rotation::to_quaternion(&turn(axis, degrees));
            assert!(found[0] >= 0.0, "{degrees} {found:?}");
            for (a, b) in found.iter().zip(expected) {
                assert!((a - b).abs() < 1e-14, "{degrees} {found:?} {expected:?}");
            }
            let pose = Pose::new(turn(axis, degrees), Vector3::zeros());
            assert_eq!(pose.quaternion(), found);
        }
    }
}

#[test]
fn a_matrix_from_a_file_becomes_a_rotation_to_the_last_digit() {
    // Errors of up to 1e-7 per number: one step of the iteration would leave some 1e-14.
    for seed in 1..20 {
        let error =
            Matrix3::from_fn(|i, j| 1e-7 * (f64::from(seed) * (7.0 * i as f64 + 3.0 * j as f64 + 1.0)).sin());
        let exact = turn(Vector3::new(1.0, f64::from(seed), -2.0), 17.0 * f64::from(seed));
        let found = Pose::<3>::from_linear(&(exact + error), &Vector3::zeros()).unwrap().rotation;
        let deviation = (found.tr_mul(&found) - Matrix3::identity()).norm();
        assert!(deviation < 2e-15, "{seed}: {deviation:e}");
        assert!((found - exact).norm() <= 1.5 * error.norm(), "{seed}");
    }
}

#[test]
fn many_small_turns_stay_a_rotation() {
    let step =
        Displacement { rotation: turn(Vector3::new(1.0, -2.0, 0.7), 0.37), ..Displacement::<3>::identity() };
    let mut pose = Pose::<3>::identity();
    let mut followed = Pose::<3>::identity();
    let small = Pose::new(step.rotation, Vector3::zeros());
    for _ in 0..100_000 {
        pose = pose.then(&step);
        followed = followed.followed_by(&small);
    }
    for rotation in [pose.rotation, followed.rotation] {
        assert!((rotation.tr_mul(&rotation) - Matrix3::identity()).norm() < 2e-15);
    }
}

#[test]
fn scales_within_a_millionth_of_one_are_one() {
    let scale = |s: f64| Pose::<3>::from_linear(&(Matrix3::identity() * s), &Vector3::zeros()).unwrap().scale;
    for s in [1.0 - 0.9e-6, 1.0 + 0.9e-6] {
        assert_eq!(scale(s).to_bits(), 1.0f64.to_bits());
    }
    for s in [1.0 - 1.1e-6, 1.0 + 1.1e-6, 0.5, 1e-3, 25.4] {
        assert!((scale(s) / s - 1.0).abs() < 4e-15, "{s}");
    }
    for s in [0.0, f64::NAN, f64::INFINITY] {
        assert!(is_refused(Pose::<3>::from_linear(&(Matrix3::identity() * s), &Vector3::zeros())));
    }
}

#[test]
fn the_last_row_of_a_matrix_must_be_that_of_a_motion() {
    let plane = [[0.6, -0.8, 3.0], [0.8, 0.6, 4.0], [0.0, 0.0, 1.0]];
    let space = [[0.6, -0.8, 0.0, 3.0], [0.8, 0.6, 0.0, 4.0], [0.0, 0.0, 1.0, 5.0], [0.0, 0.0, 0.0, 1.0]];
    assert_eq!(Pose::<2>::from_row_major(&plane).unwrap().translation(), Vector2::new(3.0, 4.0));
    assert_eq!(Pose::<3>::from_row_major(&space).unwrap().translation(), Vector3::new(3.0, 4.0, 5.0));
    for change in [1e-3, -1e-3, 2e-6, -2e-6, 0.5e-6, -0.5e-6, f64::NAN, f64::INFINITY] {
        let refused = change.is_nan() || change.abs() > 1e-6;
        for column in 0..3 {
            let mut rows = plane;
            rows[2][column] += change;
            assert_eq!(is_refused(Pose::<2>::from_row_major(&rows)), refused, "{column} {change}");
        }
        for column in 0..4 {
            let mut rows = space;
            rows[3][column] += change;
            assert_eq!(is_refused(Pose::<3>::from_row_major(&rows)), refused, "{column} {change}");
        }
    }
    // Deviations of different signs do not cancel.
    let mut rows = plane;
    rows[2] = [0.1, -0.1, 1.0];
    assert!(is_refused(Pose::<2>::from_row_major(&rows)));
}

#[test]
fn poses_that_are_no_motion_are_not_finite() {
    let pose = Pose::new(Matrix2::identity(), Vector2::new(1.0, 2.0));
    assert!(pose.is_finite());
    for scale in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(!Pose { scale, ..pose }.is_finite(), "{scale}");
    }
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut rotation = pose.rotation;
        rotation[(1, 0)] = bad;
        assert!(!Pose { rotation, ..pose }.is_finite());
        assert!(!Pose { source_origin: Vector2::new(0.0, bad), ..pose }.is_finite());
        assert!(!Pose { target_origin: Vector2::new(bad, 0.0), ..pose }.is_finite());
    }
}
