//! Points close to exact rational quadrics: the foot is one, and is said to be one.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

use footpoint::{
    CurveProjector, Mode, ProjectionOptions, Status, SurfaceProjector, UpdateOptions, no_progress,
};
use nalgebra::{Vector2, Vector3};
use nurbs_core::{
    BsplineSurface, Circle, Cone, Cylinder, Frame, Interval, ParametricCurve, ParametricSurface, Sphere,
    Torus,
};

/// Points per shape, distance and mode; the environment may ask for more.
fn count() -> usize {
    std::env::var("NEAR_RATIONAL_POINTS").ok().and_then(|n| n.parse().ok()).unwrap_or(400)
}

fn unit(i: usize, step: f64) -> f64 {
    (0.5 + i as f64 * step).fract()
}

/// Quadrics about the given point with the given radius, each in an oblique frame.
fn quadrics(centre: Vector3<f64>, r: f64) -> Vec<(&'static str, BsplineSurface)> {
    let frame = Frame::new(centre, Vector3::new(1.0, 2.0, 3.0), Vector3::new(-1.0, 1.0, 0.5)).unwrap();
    let heights = Interval::new(-r, 1.5 * r).unwrap();
    vec![
        ("sphere", Sphere::new(frame, r).unwrap().to_nurbs().unwrap()),
        ("cylinder", Cylinder::new(frame, r, heights).unwrap().to_nurbs().unwrap()),
        ("cone", Cone::new(frame, 1.2 * r, 0.3 * r, 2.0 * r).unwrap().to_nurbs().unwrap()),
        ("torus", Torus::new(frame, r, 0.4 * r).unwrap().to_nurbs().unwrap()),
    ]
}

/// Points within a few `sigma` of a surface, and how far from it they are by construction.
fn near(surface: &BsplineSurface, sigma: f64) -> Vec<(Vector3<f64>, f64)> {
    let [du, dv] = surface.domain();
    let places = (0..count()).filter_map(|i| {
        let jet = surface.jet(du.lerp(unit(i, 0.754_877_666)), dv.lerp(unit(i, 0.569_840_291)));
        let offset = sigma * (4.0 * unit(i, 0.430_159_709) - 2.0);
        Some((jet.point + jet.unit_normal()? * offset, offset))
    });
    places.collect()
}

fn no_point_stalls(centre: Vector3<f64>, r: f64) {
    let rounding = 1e-15 * (centre.norm() + 10.0 * r);
    for (name, surface) in quadrics(centre, r) {
        let projector = SurfaceProjector::new(&surface);
        for sigma in [1e-6, 1e-5, 1e-4, 1e-3, 1e-2] {
            let (points, offsets): (Vec<_>, Vec<_>) = near(&surface, sigma * r).into_iter().unzip();
            for mode in [Mode::Certified, Mode::Fast, Mode::Local] {
                let options = ProjectionOptions::default().with_mode(mode);
                let feet = projector.project_many(&points, &options, &no_progress).unwrap();
                let mut bad = [0; 2];
                for (foot, offset) in feet.iter().zip(&offsets) {
                    let good = matches!(foot.status, Status::Converged | Status::OnBoundary);
                    bad[0] += usize::from(!good);
                    bad[1] += usize::from((foot.signed_distance.abs() - offset.abs()).abs() > 4.0 * rounding);
                }
                assert_eq!(bad, [0, 0], "{name} of radius {r} at {centre:?}, {sigma}, {mode:?}");
            }
        }
    }
}

#[test]
fn no_point_near_a_rational_quadric_stalls() {
    no_point_stalls(Vector3::zeros(), 1.0);
    no_point_stalls(Vector3::new(12.0, -7.0, 3.0), 25.0);
}

#[test]
fn nor_does_it_far_from_the_origin_and_in_other_units() {
    no_point_stalls(Vector3::new(6e5, -7e5, 4e5), 1.0);
    no_point_stalls(Vector3::zeros(), 1e6);
    no_point_stalls(Vector3::zeros(), 1e-6);
}

#[test]
fn nor_does_a_point_near_a_rational_circle() {
    for r in [1.0, 1e6, 1e-6] {
        let circle = Circle::new(Vector2::new(0.3, -0.2) * r, r).unwrap().to_nurbs().unwrap();
        let projector = CurveProjector::new(&circle);
        for sigma in [1e-6, 1e-4, 1e-2] {
            for i in 0..count() {
                let jet = circle.jet(circle.domain().lerp(unit(i, 0.754_877_666)));
                let normal = Vector2::new(-jet.d1.y, jet.d1.x).normalize();
                let x = jet.point + normal * (sigma * r * (4.0 * unit(i, 0.430_159_709) - 2.0));
                for mode in [Mode::Certified, Mode::Fast, Mode::Local] {
                    let options = ProjectionOptions::default().with_mode(mode);
                    let foot = projector.project_with(&x, &options).unwrap();
                    assert!(foot.status.is_converged(), "{i} {sigma} {mode:?}: {foot}");
                }
            }
        }
    }
}

#[test]
fn what_is_not_yet_a_foot_is_not_said_to_be_one() {
    for (name, surface) in quadrics(Vector3::zeros(), 1.0) {
        let projector = SurfaceProjector::new(&surface);
        let points: Vec<_> = near(&surface, 1e-3).into_iter().map(|p| p.0).collect();
        let feet = projector.project_all(&points);
        // One step from a twentieth of the domain beside.
        let [du, dv] = surface.domain();
        let mut beside = feet.clone();
        for foot in &mut beside {
            let [u, v] = foot.parameter;
            foot.parameter = [
                du.lerp(0.05 + 0.9 * (u - du.start()) / du.length()),
                dv.lerp(0.05 + 0.9 * (v - dv.start()) / dv.length()),
            ];
        }
        projector.update_in_place(&points, &mut beside, &UpdateOptions::default().with_max_steps(1)).unwrap();
        for ((x, foot), exact) in points.iter().zip(&beside).zip(&feet) {
            let jet = surface.jet(foot.parameter[0], foot.parameter[1]);
            let residual = x - jet.point;
            let normal = jet.unit_normal().unwrap();
            let along = (residual - normal * residual.dot(&normal)).norm();
            let edge = foot.status == Status::OnBoundary;
            if along > 1e-6 && foot.distance > exact.distance * 1.01 && !edge {
                assert!(!foot.status.is_converged(), "{name}: {foot}, {along:e} beside");
            }
        }
    }
}
