//! Geodesics on parametric surfaces.
#![allow(clippy::unwrap_used, reason = "tests may panic")]

use crate::shapes::text;
use feature_metric::{Error, GeodesicOptions, Metric, surface_geodesic};
use nalgebra::Vector3;
use nurbs_core::{Cylinder, Frame, Interval, Sphere, Torus};
use std::f64::consts::{FRAC_PI_2, PI};

#[test]
fn lengths_on_the_torus_are_those_of_the_reference() {
    let reference: serde_json::Value = serde_json::from_str(&text("fs_torus_reference.json")).unwrap();
    let torus = Torus::new(Frame::WORLD, 1.0, 0.4).unwrap();
    for case in reference["cases"].as_array().unwrap() {
        let pair = |name: &str| [0, 1].map(|k| case[name][k].as_f64().unwrap().rem_euclid(2.0 * PI));
        let width = case["w"].as_f64().unwrap();
        let found = surface_geodesic(
            &torus,
            pair("p"),
            pair("q"),
            Metric::Feature { width },
            &GeodesicOptions::default(),
        );
        let found = found.unwrap();
        let right = case["length"].as_f64().unwrap();
        assert!(
            (found.length - right).abs() < 1e-10 && found.is_geodesic,
            "{case} {} {}",
            found.length,
            found.error
        );
    }
}

#[test]
fn closed_forms_hold() {
    let options = GeodesicOptions { pieces: 256, ..GeodesicOptions::default() };
    for width in [0.0, 0.7] {
        let metric = Metric::Feature { width };
        // Cylinder: d² = dz² + (r² + w²) dφ², the shorter way around.
        let height = Interval::new(-1.0, 1.0).unwrap();
        let cylinder = Cylinder::new(Frame::WORLD, 0.5, height).unwrap();
        let found = surface_geodesic(&cylinder, [0.3, -0.5], [5.9, 0.8], metric, &options).unwrap();
        let right = 1.3f64.hypot((2.0 * PI - 5.6) * 0.5f64.hypot(width));
        assert!((found.length - right).abs() < 1e-9, "{} {right}", found.length);
        // Sphere: √(r² + w²) θ.
        let sphere = Sphere::new(Frame::WORLD, 2.0).unwrap();
        let found = surface_geodesic(&sphere, [0.2, -0.7], [1.9, 0.6], metric, &options).unwrap();
        let ends = [found.points[0], found.points[found.points.len() - 1]];
        let angle = ends[0].cross(&ends[1]).norm().atan2(ends[0].dot(&ends[1]));
        assert!(
            (found.length - angle * 2.0f64.hypot(width)).abs() < 1e-8,
            "{} {}",
            found.length,
            found.error
        );
    }
}

#[test]
fn rational_surfaces_serve_as_well() {
    let torus = Torus::new(Frame::WORLD, 1.0, 0.4).unwrap();
    let exact =
        surface_geodesic(&torus, [0.2, 2.0], [1.7, 0.3], Metric::Euclidean, &GeodesicOptions::default())
            .unwrap();
    let nurbs = torus.to_nurbs().unwrap();
    // The same two points: found by their footpoints on a fine grid of parameters.
    let find = |x: Vector3<f64>| {
        use nurbs_core::ParametricSurface;
        let [a, b] = nurbs.domain();
        let mut at = [0.5, 0.5];
        let mut step = 0.5;
        for _ in 0..48 {
            let candidates = (0..25u8).map(|k| {
                let offset = |k: u8| (f64::from(k) - 2.0) / 2.0 * step;
                [(at[0] + offset(k % 5)).clamp(0.0, 1.0), (at[1] + offset(k / 5)).clamp(0.0, 1.0)]
            });
            at = candidates
                .min_by(|p, q| {
                    let d = |p: &[f64; 2]| (nurbs.point(a.lerp(p[0]), b.lerp(p[1])) - x).norm();
                    d(p).total_cmp(&d(q))
                })
                .unwrap();
            step *= 0.6;
        }
        [a.lerp(at[0]), b.lerp(at[1])]
    };
    let ends = [exact.points[0], exact.points[exact.points.len() - 1]].map(find);
    let found =
        surface_geodesic(&nurbs, ends[0], ends[1], Metric::Euclidean, &GeodesicOptions::default()).unwrap();
    assert!((found.length - exact.length).abs() < 1e-7, "{} {}", found.length, exact.length);
}

#[test]
fn what_cannot_be_is_refused() {
    let sphere = Sphere::new(Frame::WORLD, 1.0).unwrap();
    let run = |from: [f64; 2], metric: Metric, pieces: usize| {
        let options = GeodesicOptions { pieces, ..GeodesicOptions::default() };
        surface_geodesic(&sphere, from, [1.0, 0.5], metric, &options)
    };
    assert!(matches!(run([0.0, 9.0], Metric::Euclidean, 1024), Err(Error::Parameters { .. })));
    assert!(matches!(run([f64::NAN, 0.0], Metric::Euclidean, 1024), Err(Error::Parameters { .. })));
    assert!(matches!(run([0.0, 0.0], Metric::Feature { width: -1.0 }, 1024), Err(Error::Option { .. })));
    assert!(matches!(run([0.0, 0.0], Metric::Euclidean, 30), Err(Error::Option { .. })));
    // The same point twice is a geodesic without length.
    let none = run([1.0, 0.5], Metric::Euclidean, 64).unwrap();
    assert!(none.length < 1e-12);
    // Over a pole the parameters have no curve: what is found is never shorter than the way, and no geodesic unless it is that.
    let high = FRAC_PI_2 - 0.2;
    let over =
        surface_geodesic(&sphere, [0.0, high], [PI, high], Metric::Euclidean, &GeodesicOptions::default());
    let over = over.unwrap();
    assert!(over.length > 0.4 - 1e-6 && (!over.is_geodesic || over.length < 0.401), "{}", over.length);
}
