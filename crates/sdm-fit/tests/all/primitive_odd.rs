//! Primitives at the edge of what they are: cones that are nearly cylinders or planes, tori fitted to what is none.

use nalgebra::{Rotation3, Vector3};
use sdm_fit::primitive::{PrimitiveOptions, PrimitiveStatus, fit_cone, fit_cylinder, fit_plane, fit_torus};
use std::f64::consts::TAU;

/// Places in (0, 1)², evenly spread.
fn places(count: usize) -> impl Iterator<Item = (f64, f64)> {
    (0..count)
        .map(|k| ((k as f64 * 0.754_877_666_246_693).fract(), (k as f64 * 0.569_840_290_998_053).fract()))
}

/// Points on a cone with its apex at the origin and its axis along z, out to the distance `far` from the apex, turned and moved.
fn cone(half_angle: f64, near: f64, far: f64) -> Vec<Vector3<f64>> {
    let turn = Rotation3::from_scaled_axis(Vector3::new(0.3, -0.7, 0.2));
    let (sin, cos) = half_angle.sin_cos();
    let at = |(u, v): (f64, f64)| {
        let along = near + (far - near) * v;
        let (y, x) = (TAU * u).sin_cos();
        turn * Vector3::new(along * sin * x, along * sin * y, along * cos - near * cos)
            + Vector3::new(5.0, -3.0, 2.0)
    };
    places(400).map(at).collect()
}

#[test]
fn the_steepest_and_the_flattest_cones_are_found() {
    // The slender ones have radius 1 in the middle and length 2, the flat ones reach from the apex to radius 1.
    for degrees in [0.001f64, 0.01, 0.1, 1.0, 45.0, 89.0, 89.9, 89.99, 89.999] {
        let half_angle = degrees.to_radians();
        let (near, far) = if degrees < 45.0 {
            let middle = 1.0 / half_angle.sin();
            (middle - 1.0, middle + 1.0)
        } else {
            (0.0, 1.0 / half_angle.sin())
        };
        let found = fit_cone(&cone(half_angle, near, far), &PrimitiveOptions::default()).unwrap();
        if found.status == PrimitiveStatus::Converged {
            assert!(found.rms < 1e-11, "{degrees}: rms {}", found.rms);
            let [base, top] = found.shape.radii();
            let angle = (top - base).abs().atan2(found.shape.height());
            assert!((angle - half_angle).abs() < 1e-8, "{degrees}: half angle {angle}");
        } else {
            // A cone that is nearly a plane may not be found, which is said; the others are.
            assert!(degrees > 89.0, "{degrees}: {}", found.status);
        }
    }
}

#[test]
fn a_noisy_plane_is_no_better_a_torus_than_said() {
    let noise =
        |k: usize| 1e-3 * (1.0 + k as f64 * 12.9898).sin() * (43758.5453 * (k as f64 * 78.233).sin()).fract();
    let points: Vec<_> =
        places(500).enumerate().map(|(k, (u, v))| Vector3::new(3.0 * u, 2.0 * v, noise(k))).collect();
    let options = PrimitiveOptions::default();
    let plane = fit_plane(&points, &options).unwrap();
    assert_eq!(plane.status, PrimitiveStatus::Converged);
    // Every plane is the limit of tori and cylinders: a minimum among these lies no higher.
    let torus = fit_torus(&points, &options).unwrap();
    assert!(
        torus.rms <= plane.rms * (1.0 + 1e-6) || torus.status != PrimitiveStatus::Converged,
        "{}",
        torus.rms
    );
    let cylinder = fit_cylinder(&points, &options).unwrap();
    assert!(cylinder.rms <= plane.rms * (1.0 + 1e-6) || cylinder.status != PrimitiveStatus::Converged);
}

#[test]
fn the_surface_of_a_box_as_a_torus_ends_with_its_residuals() {
    let mut points = Vec::new();
    for (k, (u, v)) in places(600).enumerate() {
        let side = if k % 2 == 0 { 1.0 } else { -1.0 };
        let (u, v) = (2.0 * u - 1.0, 2.0 * v - 1.0);
        points.push(match k % 6 / 2 {
            0 => Vector3::new(side, u, v),
            1 => Vector3::new(u, side, v),
            _ => Vector3::new(u, v, side),
        });
    }
    let found = fit_torus(&points, &PrimitiveOptions::default()).unwrap();
    let largest = found.residuals.iter().fold(0.0f64, |most, r| most.max(r.abs()));
    // A box is .4 off any ring around it: the report cannot hide that.
    assert!(found.rms > 0.05 && largest > 0.1, "{} rms {} max {largest}", found.status, found.rms);
}
