//! Data without noise, exact or rounded as in a file: the cost falls to the level of rounding, and that is convergence.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use nalgebra::{SVector, Vector2, Vector3};
use sdm_fit::curve::{CurveOptions, fit_curve};
use sdm_fit::primitive::{PrimitiveOptions, PrimitiveStatus, fit_circle, fit_sphere};
use sdm_fit::{NetSize, Status, SurfaceOptions, fit_cloud};
use std::f64::consts::{PI, TAU};

/// Coordinates as they stand in a file with so many decimals.
fn rounded<const D: usize>(point: SVector<f64, D>, decimals: i32) -> SVector<f64, D> {
    let unit = 10f64.powi(decimals);
    point.map(|c| (c * unit).round() / unit)
}

/// Fits a curve to points without noise, `count` of them over `[0, 1)`, and checks that it converges, near to the points.
fn converges<const D: usize>(name: &str, count: usize, at: impl Fn(f64) -> SVector<f64, D>) {
    for decimals in [6, 12] {
        let points: Vec<_> = (0..count).map(|i| rounded(at(i as f64 / count as f64), decimals)).collect();
        let report = fit_curve(&points, None, &CurveOptions::default()).unwrap().report;
        let size = points.iter().map(|p| (p - points[0]).amax()).fold(0.0, f64::max);
        assert_eq!(report.status, Status::Converged, "{name} with {decimals} decimals: {report}");
        assert!(report.max <= 1e-5 * size, "{name} with {decimals} decimals: {report}");
    }
}

#[test]
fn curves_converge() {
    converges("ellipse", 80, |t| Vector2::new(3.0 * (TAU * t).cos(), (TAU * t).sin()));
    converges("parabola", 50, |t| Vector2::new(5.0 * t, 25.0 * t * t));
    converges("cubic", 100, |t| Vector2::new(3.0 * t, (3.0 * t - 1.5).powi(3) - 3.0 * t));
    converges("line", 50, |t| Vector2::new(5.0 * t, 10.0 * t));
    converges("arc", 200, |t| Vector2::new(5.0 * (4.0 * t).cos(), 5.0 * (4.0 * t).sin()));
    converges("wave", 300, |t| Vector2::new(TAU * t, (2.0 * TAU * t).sin()));
    let thickness = |x: f64| {
        0.6 * (0.2969 * x.sqrt() - 0.126 * x - 0.3516 * x * x + 0.2843 * x.powi(3) - 0.1036 * x.powi(4))
    };
    converges("airfoil", 200, |t| {
        let x = 0.5 * (1.0 + (TAU * t).cos());
        Vector2::new(x, if t < 0.5 { thickness(x) } else { -thickness(x) })
    });
    converges("helix", 300, |t| {
        Vector3::new(2.0 * (3.0 * PI * t).cos(), 2.0 * (3.0 * PI * t).sin(), 6.0 * t)
    });
}

#[test]
fn surfaces_converge() {
    // A bicubic graph is a cubic surface; no parameterisation by the plane is exact, since its normals are not vertical.
    let share = |i: usize, step: f64| (i as f64 * step).fract();
    let point = |i: usize| {
        let (x, y) = (3.0 * share(i, 0.819_172_513), 2.0 * share(i, 0.671_043_607));
        Vector3::new(x, y, 0.1 * x * x - 0.05 * x * y * y)
    };
    for decimals in [6, 12] {
        let points: Vec<_> = (0..800).map(|i| rounded(point(i), decimals)).collect();
        let options = SurfaceOptions::default().with_size(NetSize { degrees: [3, 3], controls: [6, 6] });
        let report = fit_cloud(&points, &options).unwrap().report;
        assert_eq!(report.fit.status, Status::Converged, "{report}");
        assert!(report.fit.max < 1e-3, "{report}");
    }
}

#[test]
fn primitives_converge() {
    let circle: Vec<_> = (0..4).map(|i| f64::from(i) * PI / 2.0).collect();
    let circle: Vec<_> = circle.iter().map(|a| Vector2::new(1.0 + 2.0 * a.cos(), 2.0 * a.sin())).collect();
    let found = fit_circle(&circle, &PrimitiveOptions::default()).unwrap();
    assert_eq!(found.status, PrimitiveStatus::Converged);
    let sphere: Vec<_> = (0..40)
        .map(|i| {
            let z = 1.0 - (f64::from(i) + 0.5) / 20.0;
            let (a, r) = (2.4 * f64::from(i), (1.0 - z * z).sqrt());
            Vector3::new(1e6 + 3.0 * r * a.cos(), 3.0 * r * a.sin(), 3.0 * z)
        })
        .collect();
    let found = fit_sphere(&sphere, &PrimitiveOptions::default()).unwrap();
    assert_eq!(found.status, PrimitiveStatus::Converged);
}
