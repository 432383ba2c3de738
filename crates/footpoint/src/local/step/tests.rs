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

/// Every step on surfaces.
const SURFACE_STEPS: [fn(&SurfaceJet, &Vector3<f64>) -> Option<[f64; 2]>; 5] = [
    first_order_surface,
    second_order_surface,
    second_order_taylor_surface,
    principal_circle_surface,
    newton_surface,
];

/// A regular point with two different curvatures.
fn saddle() -> SurfaceJet {
    SurfaceJet {
        point: Vector3::new(0.2, -0.1, 0.4),
        du: Vector3::new(1.5, 0.0, 0.0),
        dv: Vector3::new(0.0, 0.8, 0.0),
        duu: Vector3::new(0.3, 0.1, 1.9),
        duv: Vector3::new(0.0, 0.2, 0.6),
        dvv: Vector3::new(-0.2, 0.0, -0.7),
    }
}

#[test]
fn where_the_hessian_is_not_positive_definite_newtons_step_is_the_principal_circle_step() {
    // Beyond the centre of a sphere both curvatures of the distance are negative, and the determinant is positive.
    let jet = sphere(0.4, 0.3);
    let negative = jet.point * -2.0 + (jet.du * 0.02 - jet.dv * 0.05);
    // Beyond one of the two centres of a saddle only one of them is, in u or in v.
    let saddle = saddle();
    let normal = Vector3::z();
    let in_u = saddle.point + normal * 3.0 + Vector3::new(0.1, -0.2, 0.0);
    let in_v = saddle.point - normal * 3.0 + Vector3::new(0.1, -0.2, 0.0);
    // Or in none of them, but between.
    let flat = Vector3::zeros();
    let twisted = SurfaceJet { duu: flat, dvv: flat, duv: normal, ..saddle };
    for (jet, x, signs) in [
        (jet, negative, [-1.0, -1.0]),
        (saddle, in_u, [-1.0, 1.0]),
        (saddle, in_v, [1.0, -1.0]),
        (twisted, in_u, [1.0, 1.0]),
    ] {
        let w = x - jet.point;
        let diagonal = [jet.du.norm_squared() - w.dot(&jet.duu), jet.dv.norm_squared() - w.dot(&jet.dvv)];
        assert!((0..2).all(|d| diagonal[d] * signs[d] > 0.0), "{diagonal:?}");
        let step = newton_surface(&jet, &x).unwrap();
        assert_eq!(step, principal_circle_surface(&jet, &x).unwrap());
        // Newton's own step would climb.
        assert!(w.dot(&(jet.du * step[0] + jet.dv * step[1])) > 0.0, "{step:?}");
    }
}

#[test]
fn steps_at_a_pole_have_their_length_in_both_directions() {
    let (along, bend) = (Vector3::new(0.0, 2.0, 0.0), Vector3::new(0.0, 0.0, 1.0));
    let zero = Vector3::zeros();
    let in_v = SurfaceJet { point: zero, du: zero, dv: along, duu: zero, duv: bend, dvv: zero };
    let in_u = SurfaceJet { point: zero, du: along, dv: zero, duu: zero, duv: bend, dvv: zero };
    let x = Vector3::new(7.0, 3.0, -1.0);
    for step in SURFACE_STEPS {
        // The component 3 of x along the line, at the speed 2.
        assert_eq!((step(&in_v, &x), step(&in_u, &x)), (Some([0.0, 1.5]), Some([1.5, 0.0])));
    }
}

#[test]
fn steps_do_not_depend_on_the_angle_between_the_parameter_lines() {
    let jet = saddle();
    // (u, v) = A (a, b): the same surface with skew parameter lines.
    let [[p, q], [r, s]] = [[1.0, 0.7], [-0.4, 1.3]];
    let skew = SurfaceJet {
        point: jet.point,
        du: jet.du * p + jet.dv * r,
        dv: jet.du * q + jet.dv * s,
        duu: jet.duu * (p * p) + jet.duv * (2.0 * p * r) + jet.dvv * (r * r),
        duv: jet.duu * (p * q) + jet.duv * (p * s + q * r) + jet.dvv * (r * s),
        dvv: jet.duu * (q * q) + jet.duv * (2.0 * q * s) + jet.dvv * (s * s),
    };
    for w in [Vector3::new(0.3, 0.2, 0.1), Vector3::new(-0.1, 0.25, -0.2), Vector3::new(0.2, -0.3, 0.9)] {
        let x = jet.point + w;
        for step in SURFACE_STEPS {
            let (plain, other) = (step(&jet, &x).unwrap(), step(&skew, &x).unwrap());
            let back = [p * other[0] + q * other[1], r * other[0] + s * other[1]];
            assert!((0..2).all(|d| (back[d] - plain[d]).abs() < 1e-12), "{back:?} {plain:?}");
        }
    }
}

#[test]
fn a_point_on_the_normal_needs_no_step() {
    let jet = SurfaceJet { point: Vector3::zeros(), ..saddle() };
    for height in [0.1, -0.2, 5.0, -7.0] {
        for step in SURFACE_STEPS {
            assert_eq!(step(&jet, &Vector3::new(0.0, 0.0, height)).map(|s| s.map(f64::abs)), Some([0.0; 2]));
        }
    }
}

#[test]
fn far_beyond_the_centre_the_chord_is_the_diameter() {
    // A circle of radius 0.5 at (0, 0), run through with the speed 4; x is 2.5 beyond, beside the axis by next to nothing.
    let jet = CurveJet { point: Vector2::zeros(), d1: Vector2::new(4.0, 0.0), d2: Vector2::new(0.0, 32.0) };
    for offset in [1e-3, 1e-9, -1e-9, 1e-30] {
        let x = Vector2::new(offset, 2.5);
        let step = second_order_curve(&jet, &x).unwrap();
        assert!((step - 0.25_f64.copysign(offset)).abs() < 1e-6, "{offset}: {step}");
        // Eq. (5): the foot (L / h, 2 r) in the frame of c', c'' has no part along c' worth the name.
        let taylor = second_order_taylor_curve(&jet, &x).unwrap();
        assert!((taylor - offset / (4.0 * 4.0)).abs() < 1e-6 * offset.abs(), "{offset}: {taylor}");
    }
    // With a curve that speeds up the second term of eq. (5) counts: Δt = L/(h|c'|) − ⟨c',c''⟩/|c'|⁴ · L²/(h(h+m)), and with
    // L²/(h(h+m)) = |q|²/2 = 1/2.
    let speeding = CurveJet { d2: Vector2::new(8.0, 32.0), ..jet };
    let taylor = second_order_taylor_curve(&speeding, &Vector2::new(1e-9, 2.5)).unwrap();
    assert!((taylor + 8.0 * 4.0 / 256.0 * 0.5).abs() < 1e-8, "{taylor}");
}

#[test]
fn derivatives_whose_squares_are_no_normal_numbers_count_as_none() {
    let tiny = 1e-160;
    let jet = CurveJet { point: Vector2::zeros(), d1: Vector2::new(tiny, 0.0), d2: Vector2::zeros() };
    for step in [first_order_curve, second_order_curve, principal_circle_curve, newton_curve] {
        assert_eq!(step(&jet, &Vector2::new(1.0, 1.0)), None);
    }
    let (u, v) = (Vector3::new(tiny, 0.0, 0.0), Vector3::new(0.0, tiny, 0.0));
    let zero = Vector3::zeros();
    let jet = SurfaceJet { point: zero, du: u, dv: v, duu: zero, duv: zero, dvv: zero };
    for step in SURFACE_STEPS {
        assert_eq!(step(&jet, &Vector3::new(1.0, 1.0, 1.0)), None);
    }
}
