//! Whether primitives end in the lowest minimum or say that they may not, and what their reports hold.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use nalgebra::{Vector2, Vector3};
use sdm_fit::primitive::{
    PrimitiveOptions, PrimitiveOutliers, PrimitiveStatus, fit_circle_in_space, fit_cone, fit_cylinder,
    fit_line, fit_plane, fit_sphere, fit_torus,
};
use std::f64::consts::TAU;

fn points(name: &str) -> Vec<Vector3<f64>> {
    let path = format!("{}/../../fixtures/primitives/{name}", env!("CARGO_MANIFEST_DIR"));
    let line = |line: &str| {
        let mut numbers = line.split_whitespace().map(|x| x.parse::<f64>().unwrap());
        Vector3::from_fn(|_, _| numbers.next().unwrap())
    };
    std::fs::read_to_string(path).unwrap().lines().map(line).collect()
}

/// Numbers in [0, 1), the same everywhere.
fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / (1u64 << 31) as f64
    }
}

fn ring(major: f64, minor: f64, turn: f64, tube: f64, seed: u64) -> Vec<Vector3<f64>> {
    let mut next = numbers(seed);
    let point = |_| {
        let (a, b) = (turn * next(), tube * next());
        let out = major + minor * b.cos();
        Vector3::new(out * a.cos(), minor * b.sin(), out * a.sin())
    };
    (0..200).map(point).collect()
}

const TUKEY: PrimitiveOutliers = PrimitiveOutliers::Tukey { abs_scale: None };

#[test]
fn the_exact_torus_of_a_short_piece() {
    let found = fit_torus(&points("torus_45_degrees.xyz"), &PrimitiveOptions::default()).unwrap();
    assert!(found.is_converged() && found.rms < 1e-13, "{found}");
    let elements = found.elements;
    assert!(
        (elements.radius.unwrap() - 1.0).abs() < 1e-11
            && (elements.minor_radius.unwrap() - 0.9).abs() < 1e-11
    );
    assert!(found.miss_probability == 0.0 && found.solutions == 1);
}

#[test]
fn short_pieces_of_tori_are_found_again() {
    for (k, turn, tube) in [(1, 0.8, 0.8), (2, 0.35, 1.6), (3, 1.6, 0.35), (4, TAU, 0.8)] {
        let found = fit_torus(&ring(1.0, 0.7, turn, tube, k), &PrimitiveOptions::default()).unwrap();
        assert!(found.is_converged() && found.rms < 1e-13, "{turn} {tube}: {found}");
        assert!((found.shape.minor_radius() - 0.7).abs() < 1e-9, "{turn} {tube}");
    }
}

#[test]
fn a_torus_among_outliers() {
    let cloud = points("torus_outliers.xyz");
    for outliers in [TUKEY, PrimitiveOutliers::Trimmed { outliers: 0.45 }] {
        let found = fit_torus(&cloud, &PrimitiveOptions::default().with_outliers(outliers)).unwrap();
        assert!(found.is_converged() && found.used == 110, "{outliers:?}: {found}");
        assert!(found.rms < 1.1e-3 && found.miss_probability < 0.05);
        assert!((found.shape.major_radius() - 1.0).abs() < 1e-3);
        assert!((found.shape.minor_radius() - 0.3).abs() < 1e-3);
    }
}

#[test]
fn exact_points_among_outliers_converge() {
    let mut next = numbers(9);
    let mut cloud = ring(1.0, 0.4, TAU, TAU, 5);
    cloud.truncate(140);
    cloud.extend((0..60).map(|_| Vector3::new(next() - 0.5, next() - 0.5, next() - 0.5) * 3.0));
    for shift in [0.0, 1e5] {
        let moved: Vec<_> = cloud.iter().map(|p| p + Vector3::repeat(shift)).collect();
        let found = fit_torus(&moved, &PrimitiveOptions::default().with_outliers(TUKEY)).unwrap();
        assert!(found.is_converged() && found.used >= 140 && found.used < 145, "{found}");
        assert!((found.shape.minor_radius() - 0.4).abs() < 1e-8);
    }
}

#[test]
fn nothing_to_tell_apart_is_doubtful() {
    // A robust fit finds no shape in points that are everywhere.
    let mut next = numbers(4);
    let cloud: Vec<_> = (0..200).map(|_| Vector3::new(next(), next(), next())).collect();
    let options = PrimitiveOptions::default().with_outliers(TUKEY);
    let cylinder = fit_cylinder(&cloud, &options).unwrap();
    assert!(!cylinder.is_converged(), "{cylinder}");
    assert!(!fit_torus(&cloud, &options).unwrap().is_converged());
    assert_eq!(fit_sphere(&cloud, &options).unwrap().status, PrimitiveStatus::Doubtful);
    // Few outliers, or none, on a sphere with noise are not.
    let ball: Vec<_> =
        cloud.iter().map(|p| (p - Vector3::repeat(0.5)).normalize() * (1.0 + 0.01 * p.x)).collect();
    assert!(fit_sphere(&ball, &options).unwrap().is_converged());
}

#[test]
fn as_many_points_as_unknowns_are_ambiguous() {
    let found = fit_cone(&points("cone_six_points.xyz"), &PrimitiveOptions::default()).unwrap();
    assert_eq!((found.status, found.redundancy), (PrimitiveStatus::Ambiguous, 0));
    assert!(found.rms < 1e-12 && found.solutions >= 2, "{found}, {} solutions", found.solutions);
    // So are the same points twice; a plane through three points is the only one.
    let twice: Vec<_> = points("cone_six_points.xyz").iter().flat_map(|p| [*p, *p]).collect();
    assert_eq!(fit_cone(&twice, &PrimitiveOptions::default()).unwrap().status, PrimitiveStatus::Ambiguous);
    let plane = fit_plane(&[Vector3::x(), Vector3::y(), Vector3::z()], &PrimitiveOptions::default()).unwrap();
    assert!(plane.is_converged() && plane.redundancy == 0 && plane.solutions == 1);
}

#[test]
fn what_is_no_ring_ends_on_the_boundary() {
    // The tube of this torus meets its axis.
    let found = fit_torus(&ring(0.6, 1.0, TAU, TAU, 7), &PrimitiveOptions::default()).unwrap();
    assert_eq!(found.status, PrimitiveStatus::OnBoundary);
    assert!(found.shape.major_radius() > found.shape.minor_radius() && found.rms < 0.25, "{found}");
}

#[test]
fn reports_hold_signed_residuals() {
    let axes = [Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y(), Vector3::z(), -Vector3::z()];
    // Alternately 0.1 outside and inside of a sphere of radius 2: opposite points alike, so that the centre stays.
    let mut cloud: Vec<_> = axes.iter().map(|a| a * if a.z == 0.0 { 2.05 } else { 1.9 }).collect();
    cloud.insert(2, Vector3::new(f64::NAN, 0.0, 0.0));
    let found = fit_sphere(&cloud, &PrimitiveOptions::default().with_worst(3)).unwrap();
    let expected = [0.05, 0.05, f64::NAN, 0.05, 0.05, -0.1, -0.1];
    assert!((found.shape.radius() - 2.0).abs() < 1e-14);
    for (r, e) in found.residuals.iter().zip(expected) {
        assert!((r - e).abs() < 1e-14 || (r.is_nan() && e.is_nan()), "{r} for {e}");
    }
    assert!((found.form_error - 0.15).abs() < 1e-14 && (found.max - 0.1).abs() < 1e-14);
    assert_eq!(found.worst.len(), 3);
    assert!(found.worst[..2].iter().all(|&i| i == 5 || i == 6) && found.redundancy == 2);

    // A plane: above is where its direction points.
    let sheet: Vec<_> = [(0.0, 0.0, 0.1), (1.0, 0.0, -0.1), (1.0, 1.0, 0.1), (0.0, 1.0, -0.1)]
        .map(|(x, y, z)| Vector3::new(x, y, z))
        .to_vec();
    let found = fit_plane(&sheet, &PrimitiveOptions::default()).unwrap();
    let up = found.elements.direction.unwrap().z.signum();
    for (r, p) in found.residuals.iter().zip(&sheet) {
        assert!((r - up * p.z).abs() < 1e-14);
    }
    assert!((found.form_error - 0.2).abs() < 1e-14);

    // A line in the plane: the left of its direction. In space, and of circles there: distances.
    let flat = [Vector2::new(0.0, 0.0), Vector2::new(1.0, 0.3), Vector2::new(2.0, 0.0)];
    let found = fit_line(&flat, &PrimitiveOptions::default()).unwrap();
    assert!((found.residuals[1] - 0.2).abs() < 1e-14 && (found.residuals[0] + 0.1).abs() < 1e-14);
    let lifted: Vec<_> = flat.iter().map(|p| p.push(0.0)).collect();
    let found = fit_line(&lifted, &PrimitiveOptions::default()).unwrap();
    assert!((found.residuals[1] - 0.2).abs() < 1e-14 && (found.residuals[0] - 0.1).abs() < 1e-14);
    assert!((found.form_error - 0.4).abs() < 1e-14);
    let hoop: Vec<_> = (0..8)
        .map(|k| f64::from(k) * std::f64::consts::FRAC_PI_4)
        .enumerate()
        .map(|(k, t)| Vector3::new(t.cos(), t.sin(), if k % 2 == 0 { 0.01 } else { -0.01 }))
        .collect();
    let found = fit_circle_in_space(&hoop, &PrimitiveOptions::default()).unwrap();
    assert!(found.residuals.iter().all(|r| (r - 0.01).abs() < 1e-9), "{:?}", found.residuals);
}
