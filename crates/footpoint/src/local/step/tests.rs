use super::*;
use nalgebra::{Vector2, Vector3};
use nurbs_core::{CurveJet, SurfaceJet};

/// The literal construction: foot on the circle by its centre, increment by determinants.
fn literal(jet: &CurveJet<2>, x: &Vector2<f64>) -> (f64, f64) {
    let det = |a: &Vector2<f64>, b: &Vector2<f64>| a.x * b.y - a.y * b.x;
    let curvature = det(&jet.d1, &jet.d2) / jet.d1.norm().powi(3);
    let normal = Vector2::new(-jet.d1.y, jet.d1.x) / jet.d1.norm();
    let centre = jet.point + normal / curvature;
    let q = centre + (x - centre).normalize() / curvature.abs();
    let chord = q - jet.point;
    let eq_5 = det(&chord, &jet.d2) / det(&jet.d1, &jet.d2);
    let eq_7 = (2.0 * (det(&jet.d1, &chord) / det(&jet.d1, &jet.d2)).abs()).sqrt();
    (eq_5, eq_7.copysign(jet.d1.dot(&chord)))
}

#[test]
fn closed_forms_equal_the_construction() {
    let jet =
        CurveJet { point: Vector2::new(0.3, -1.0), d1: Vector2::new(2.0, 0.5), d2: Vector2::new(0.7, 3.0) };
    // Before, beside and beyond the centre of curvature, on both sides.
    for x in [[0.5, 0.2], [2.0, -3.0], [-4.0, 9.0], [6.0, 8.0], [0.31, -1.0]] {
        let x = Vector2::from(x);
        let (eq_5, eq_7) = literal(&jet, &x);
        let close = |a: Option<f64>, b: f64| (a.unwrap() - b).abs() < 1e-9 * (1.0 + b.abs());
        assert!(close(second_order_taylor_curve(&jet, &x), eq_5), "{x:?}");
        assert!(close(second_order_curve(&jet, &x), eq_7), "{x:?}");
    }
}

#[test]
fn a_straight_curve_gives_the_first_order_step() {
    let jet = CurveJet { point: Vector2::zeros(), d1: Vector2::new(3.0, 4.0), d2: Vector2::zeros() };
    let x = Vector2::new(5.0, -1.0);
    let first = first_order_curve(&jet, &x).unwrap();
    for step in [second_order_curve, second_order_taylor_curve, principal_circle_curve, newton_curve] {
        assert!((step(&jet, &x).unwrap() - first).abs() < 1e-15);
    }
}

fn sphere(u: f64, v: f64) -> SurfaceJet {
    let ((su, cu), (sv, cv)) = (u.sin_cos(), v.sin_cos());
    SurfaceJet {
        point: Vector3::new(cu * cv, su * cv, sv),
        du: Vector3::new(-su * cv, cu * cv, 0.0),
        dv: Vector3::new(-cu * sv, -su * sv, cv),
        duu: Vector3::new(-cu * cv, -su * cv, 0.0),
        duv: Vector3::new(su * sv, -cu * sv, 0.0),
        dvv: Vector3::new(-cu * cv, -su * cv, -sv),
    }
}

#[test]
fn steps_agree_to_first_order_at_a_foot() {
    // All second order steps have the same linear part where x is near the normal.
    let jet = sphere(0.4, 0.3);
    let x = jet.point * 1.7 + (jet.du * 2e-6 - jet.dv * 1e-6);
    let reference = newton_surface(&jet, &x).unwrap();
    for step in [second_order_surface, second_order_taylor_surface, principal_circle_surface] {
        let step = step(&jet, &x).unwrap();
        for k in 0..2 {
            assert!((step[k] - reference[k]).abs() < 1e-10, "{step:?} {reference:?}");
        }
    }
    // First order misses the factor 1 − dκ = 1.7.
    let first = first_order_surface(&jet, &x).unwrap();
    assert!((first[0] / reference[0] - 1.7).abs() < 1e-4);
}

#[test]
fn singular_points_use_the_regular_direction() {
    let pole = SurfaceJet { du: Vector3::zeros(), ..sphere(0.4, std::f64::consts::FRAC_PI_2) };
    let x = Vector3::new(0.5, 0.1, 2.0);
    for step in [
        first_order_surface,
        second_order_surface,
        second_order_taylor_surface,
        principal_circle_surface,
        newton_surface,
    ] {
        let [du, dv] = step(&pole, &x).unwrap();
        assert!(du == 0.0 && dv < 0.0, "{du} {dv}");
        let nothing = SurfaceJet { dv: Vector3::zeros(), ..pole };
        assert_eq!(step(&nothing, &x), None);
    }
    let cusp = CurveJet { point: Vector2::zeros(), d1: Vector2::zeros(), d2: Vector2::new(1.0, 0.0) };
    assert_eq!(newton_curve(&cusp, &Vector2::new(1.0, 1.0)), None);
    assert_eq!(second_order_curve(&cusp, &Vector2::new(1.0, 1.0)), None);
}

#[test]
fn at_the_centre_of_curvature_the_step_is_of_first_order_or_none() {
    let jet =
        CurveJet { point: Vector2::new(1.0, 0.0), d1: Vector2::new(0.0, 1.0), d2: Vector2::new(-1.0, 0.0) };
    for step in [second_order_curve, second_order_taylor_curve, principal_circle_curve, newton_curve] {
        assert_eq!(step(&jet, &Vector2::zeros()), Some(0.0));
    }
}
