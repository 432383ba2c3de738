//! Local projection onto curves, through the public interface.

#![allow(clippy::unwrap_used, reason = "a set-up that fails must fail the test")]

use crate::local_common::{Moved, circle, cubic_curve, roof};
use footpoint::local::{LocalOptions, Method, Start, invert_curve, iterate_curve, project_curve};
use footpoint::{Error, Location, Status};
use nalgebra::{Vector2, Vector3};
use nurbs_core::{BsplineCurve, CurveFn, CurveJet, Interval, KnotVector, ParametricCurve};
use proptest::prelude::*;

fn options(method: Method) -> LocalOptions {
    LocalOptions::default().with_method(method)
}

/// Nearest of many samples: parameter and distance.
fn brute_force<const D: usize>(
    curve: &dyn ParametricCurve<D>,
    x: &nalgebra::SVector<f64, D>,
    n: usize,
) -> (f64, f64) {
    (0..=n)
        .map(|i| curve.domain().lerp(i as f64 / n as f64))
        .map(|t| (t, (curve.point(t) - x).norm()))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap()
}

/// The Karush-Kuhn-Tucker conditions by one-sided differences of the distance, independent of the library.
fn is_local_minimum(curve: &dyn ParametricCurve<2>, x: &Vector2<f64>, t: f64) -> bool {
    let domain = curve.domain();
    let distance = |t: f64| (curve.point(t) - x).norm();
    let here = distance(t);
    [1e-3, 1e-4].iter().all(|h| {
        let h = h * domain.length();
        [t - h, t + h].iter().all(|&s| !domain.contains(s) || distance(s) >= here * (1.0 - 1e-13) - 1e-12)
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(96) })]

    #[test]
    fn feet_are_local_minima_and_never_farther_than_the_start(
        x in 0.0..600.0, y in -50.0..350.0, t0 in 0.0..1.0, m in 0..5usize,
    ) {
        let curve = cubic_curve();
        let x = Vector2::new(x, y);
        let options = options(Method::ALL[m]).with_max_iterations(1000);
        let foot = project_curve(&curve, &x, t0, &options);
        // Linear convergence may be slow: the first order method's rate is κd, which nears 1.
        let linear = Method::ALL[m] == Method::FirstOrder;
        prop_assert!(foot.status.is_converged() || linear && foot.status == Status::MaxIterations, "{foot}");
        prop_assert!((0.0..=1.0).contains(&foot.parameter));
        let minimal = is_local_minimum(&curve, &x, foot.parameter);
        prop_assert!(minimal || !foot.status.is_converged(), "{foot}");
        prop_assert!(foot.distance <= (curve.point(t0) - x).norm() * (1.0 + 1e-13));
        prop_assert_eq!(foot.distance, (curve.point(foot.parameter) - x).norm());
        prop_assert!(!foot.status.is_converged() || (foot.status == Status::OnBoundary) == (foot.location == Location::Edge));
    }

    #[test]
    fn a_good_start_gives_the_nearest_point(x in 0.0..600.0, y in -50.0..350.0) {
        let curve = cubic_curve();
        let x = Vector2::new(x, y);
        let (t0, sampled) = brute_force(&curve, &x, 400);
        let foot = project_curve(&curve, &x, t0, &LocalOptions::default());
        prop_assert!(foot.status.is_converged());
        prop_assert!(foot.distance <= sampled);
        let (_, fine) = brute_force(&curve, &x, 20_000);
        prop_assert!(foot.distance <= fine && fine - foot.distance < 0.05, "{} {fine}", foot.distance);
    }

    #[test]
    fn rigid_motions_and_affine_parameters_change_nothing(
        x in 0.0..600.0, y in -50.0..350.0, t0 in 0.05..0.95, angle in -3.0..3.0, shift in -1e3..1e3,
        origin in -2.0..2.0, rate in 0.1..10.0, m in 0..5usize,
    ) {
        let curve = cubic_curve();
        let moved = Moved { curve: &curve, angle, shift: Vector2::new(shift, -0.5 * shift), origin, rate };
        let x = Vector2::new(x, y);
        // Unbounded steps: every one must be the same, not only the end.
        let options = options(Method::ALL[m]).with_max_iterations(3);
        let a = iterate_curve(&curve, &x, t0, &options);
        let b = iterate_curve(&moved, &(moved.turn(&x) + moved.shift), (t0 - origin) / rate, &options);
        let Some((first, second)) = a.steps.first().zip(b.steps.first()) else { return Ok(()) };
        prop_assert!((first.delta - rate * second.delta).abs() <= 1e-9 * (1.0 + first.delta.abs()));
        prop_assert!((first.angle - second.angle).abs() < 1e-9);
    }

    #[test]
    fn inversion_recovers_parameters(t in 0.0..=1.0, m in 0..5usize) {
        let curve = cubic_curve();
        let x = curve.point(t);
        let start = Start::NearestSample(20);
        let found = invert_curve(&curve, &x, start, 1e-9, &options(Method::ALL[m])).unwrap();
        prop_assert!((found.parameter - t).abs() < 1e-11, "{} {t}", found.parameter);
    }

    #[test]
    fn circles_are_exact_from_every_start(angle in 0.0..std::f64::consts::TAU, r in 0.05..4.0_f64, t0 in 0.0..4.0) {
        let curve = circle();
        let x = Vector2::new(angle.cos(), angle.sin()) * r;
        let foot = project_curve(&curve, &x, t0, &LocalOptions::default());
        prop_assert!(foot.status.is_converged());
        prop_assert!((foot.distance - (r - 1.0).abs()).abs() < 1e-13, "{foot}");
        prop_assert!((foot.point - x / r).norm() < 1e-7);
        prop_assert_ne!(foot.status, Status::OnBoundary);
    }
}

#[test]
fn second_order_methods_converge_with_order_two() {
    // Order from three successive errors: log(e2/e1) / log(e1/e0).
    let curve = cubic_curve();
    let x = Vector2::new(332.0, 200.0);
    let exact = 0.622_341_923_826_841;
    for (method, low, high) in [
        (Method::FirstOrder, 0.9, 1.1),
        (Method::SecondOrder, 1.8, 2.2),
        (Method::SecondOrderTaylor, 1.8, 2.2),
        (Method::PrincipalCircle, 1.8, 2.2),
        (Method::Newton, 1.8, 2.2),
    ] {
        let trace = iterate_curve(&curve, &x, exact + 2e-3, &options(method).with_max_iterations(4));
        let errors: Vec<f64> = trace.steps.iter().map(|s| (s.parameter - exact).abs()).collect();
        let order = (errors[2] / errors[1]).ln() / (errors[1] / errors[0]).ln();
        assert!((low..high).contains(&order), "{method:?}: {order}, {errors:?}");
    }
}

#[test]
fn inversion_by_equation_5_has_order_three() {
    let curve = cubic_curve();
    let x = curve.point(0.37);
    let trace = iterate_curve(&curve, &x, 0.38, &options(Method::SecondOrderTaylor).with_max_iterations(3));
    let errors: Vec<f64> = trace.steps.iter().map(|s| (s.parameter - 0.37).abs()).collect();
    let order = (errors[2] / errors[1]).ln() / (errors[1] / errors[0]).ln();
    assert!((2.7..3.3).contains(&order), "{order}, {errors:?}");
}

#[test]
fn kinks_are_crossed_or_kept() {
    let curve = roof();
    for method in Method::ALL {
        // Above the ridge the kink itself is nearest, from both sides.
        for t0 in [0.2, 1.0, 1.9] {
            let foot = project_curve(&curve, &Vector2::new(1.1, 2.0), t0, &options(method));
            assert_eq!((foot.parameter, foot.status), (1.0, Status::Converged), "{method:?} from {t0}");
        }
        // The foot lies on the other piece.
        let foot = project_curve(&curve, &Vector2::new(2.0, 0.0), 0.1, &options(method));
        assert!(
            (foot.parameter - 1.5).abs() < 1e-12 && foot.status == Status::Converged,
            "{method:?} {foot}"
        );
        let foot = project_curve(&curve, &Vector2::new(0.0, 0.0), 1.9, &options(method));
        assert!(
            (foot.parameter - 0.5).abs() < 1e-12 && foot.status == Status::Converged,
            "{method:?} {foot}"
        );
    }
    // From below the kink is a maximum of the distance, and must be left.
    let foot = project_curve(&curve, &Vector2::new(1.0, -1.0), 1.0, &LocalOptions::default());
    assert!((foot.distance - 0.5_f64.sqrt()).abs() < 1e-12, "{foot}");
}

#[test]
fn jumps_of_the_second_derivative_do_not_cycle() {
    // A quadratic spline with strongly different curvatures: feet near and on its knots.
    let knots = KnotVector::new(2, vec![0., 0., 0., 1., 2., 3., 3., 3.]).unwrap();
    let points = [[0., 0.], [1., 0.], [3., 5.], [3.2, 0.], [9., 0.]].map(Vector2::from).to_vec();
    let curve = BsplineCurve::new(knots, points, None).unwrap();
    for knot in [1.0, 2.0] {
        let jet = curve.jet(knot);
        let normal = Vector2::new(-jet.d1.y, jet.d1.x).normalize();
        for distance in [-0.6, -0.1, 0.05, 0.3] {
            let x = jet.point + normal * distance;
            for method in Method::ALL {
                let foot = project_curve(&curve, &x, knot + 0.3, &options(method).with_max_iterations(500));
                assert!(foot.status.is_converged(), "{method:?} {knot} {distance}: {foot}");
                assert!(foot.distance <= distance.abs() + 1e-12);
            }
        }
    }
}

#[test]
fn every_status_is_reached() {
    let curve = cubic_curve();
    let x = Vector2::new(332.0, 200.0);
    let default = LocalOptions::default();
    let foot = project_curve(&curve, &x, 0.5, &default);
    assert_eq!((foot.status, foot.location), (Status::Converged, Location::Interior));
    let foot = project_curve(&curve, &Vector2::new(50.0, -90.0), 0.1, &default);
    assert_eq!((foot.status, foot.location, foot.parameter), (Status::OnBoundary, Location::Edge, 0.0));
    let few = default.with_max_iterations(1);
    assert_eq!(project_curve(&curve, &x, 0.3, &few).status, Status::MaxIterations);
    // A coarse parameter rule ends the iteration before the residual is normal.
    let coarse = default.with_parameter_tolerance(0.5);
    assert_eq!(project_curve(&curve, &x, 0.3, &coarse).status, Status::Stalled);
    let point = Vector2::new(f64::NAN, 1.0);
    assert_eq!(project_curve(&curve, &point, 0.3, &default).status, Status::InvalidPoint);
    assert_eq!(iterate_curve(&curve, &point, 0.3, &default).status, Status::InvalidPoint);
    let broken = CurveFn::new(Interval::UNIT, |t: f64| CurveJet {
        point: Vector2::new(t, if t > 0.5 { f64::NAN } else { 0.0 }),
        d1: Vector2::new(1.0, 0.0),
        d2: Vector2::zeros(),
    });
    assert_eq!(project_curve(&broken, &Vector2::new(0.2, 1.0), 0.7, &default).status, Status::Diverged);
    // A safeguarded iteration keeps out of the part without values, and cannot reach its foot.
    let foot = project_curve(&broken, &Vector2::new(0.9, 1.0), 0.1, &default);
    assert_eq!(foot.status, Status::Stalled);
    assert!(foot.distance.is_finite());
    let runaway = iterate_curve(&broken, &Vector2::new(0.9, 1.0), 0.1, &default);
    assert_eq!(runaway.status, Status::Diverged);
}

#[test]
fn equation_5_stops_at_false_fixed_points_only_without_safeguards() {
    // c = (t, t²/2 + t³): choose x so that the foot q on the circle at t = 0.5 has q − c parallel to c''.
    let curve = CurveFn::new(Interval::new(-2.0, 2.0).unwrap(), |t: f64| CurveJet {
        point: Vector2::new(t, 0.5 * t * t + t * t * t),
        d1: Vector2::new(1.0, t + 3.0 * t * t),
        d2: Vector2::new(0.0, 1.0 + 6.0 * t),
    });
    let jet = curve.jet(0.5);
    let curvature = jet.d2.y / jet.d1.norm().powi(3);
    let centre = jet.point + Vector2::new(-jet.d1.y, jet.d1.x) / (jet.d1.norm() * curvature);
    // The second intersection of the circle with the vertical line through c(0.5).
    let q = Vector2::new(jet.point.x, 2.0 * centre.y - jet.point.y);
    let x = centre + (q - centre) * 1.5;
    let trace = iterate_curve(&curve, &x, 0.5, &options(Method::SecondOrderTaylor));
    assert_eq!(trace.status, Status::Stalled, "{trace:?}");
    assert!((trace.parameter - 0.5).abs() < 1e-9);
    let foot = project_curve(&curve, &x, 0.5, &options(Method::SecondOrderTaylor));
    assert!(foot.status.is_converged() && foot.distance < trace.distance, "{foot}");
}

#[test]
fn singular_and_stationary_starts_are_left() {
    // A cusp: c' = 0 in the middle.
    let points = [[0., 0.], [2., 2.], [0., 2.], [2., 0.]].map(Vector2::from).to_vec();
    let cusp = BsplineCurve::bezier(points, None).unwrap();
    assert!(cusp.jet(0.5).d1.norm() < 1e-15);
    let foot = project_curve(&cusp, &Vector2::new(0.3, 0.5), 0.5, &LocalOptions::default());
    assert!(foot.status.is_converged() && is_local_minimum(&cusp, &Vector2::new(0.3, 0.5), foot.parameter));
    assert!(foot.distance < (cusp.point(0.5) - Vector2::new(0.3, 0.5)).norm());
    // A doubled end point: c' = 0 at the end.
    let points = [[0., 0.], [0., 0.], [1., 1.], [2., 0.]].map(Vector2::from).to_vec();
    let doubled = BsplineCurve::bezier(points, None).unwrap();
    let foot = project_curve(&doubled, &Vector2::new(1.0, 0.9), 0.0, &LocalOptions::default());
    assert!(foot.status == Status::Converged && foot.distance < 0.5, "{foot}");
    let foot = project_curve(&doubled, &Vector2::new(-1.0, -1.0), 0.0, &LocalOptions::default());
    assert_eq!((foot.status, foot.parameter), (Status::OnBoundary, 0.0));
    // The far side of a circle is a maximum.
    let foot = project_curve(&circle(), &Vector2::new(0.0, 0.5), 3.0, &LocalOptions::default());
    assert!((foot.distance - 0.5).abs() < 1e-13, "{foot}");
    // Its centre is as near to every point: any answer is right.
    let foot = project_curve(&circle(), &Vector2::zeros(), 1.3, &LocalOptions::default());
    assert!(foot.status == Status::Converged && (foot.distance - 1.0).abs() < 1e-13);
}

#[test]
fn closed_curves_wrap() {
    let x = Vector2::new(2.0, -0.1);
    let foot = project_curve(&circle(), &x, 0.3, &LocalOptions::default());
    assert!(foot.parameter > 3.9 && foot.location == Location::Interior, "{foot}");
    let foot = project_curve(&circle(), &Vector2::new(2.0, 0.0), 3.7, &LocalOptions::default());
    assert_eq!((foot.parameter, foot.location, foot.status), (0.0, Location::Seam, Status::Converged));
    // A periodic spline: parameters beyond the domain wrap.
    let knots = KnotVector::uniform_periodic(3, 6).unwrap();
    let points = (0..9).map(|i| (f64::from(i) * std::f64::consts::TAU / 6.0).sin_cos());
    let ring = BsplineCurve::new(knots, points.map(|(s, c)| Vector2::new(c, s)).collect(), None).unwrap();
    for start in [-0.3, 0.7, 1.7] {
        let x = ring.point(0.97) * 1.5;
        let foot = project_curve(&ring, &x, start, &LocalOptions::default());
        assert!(
            foot.status == Status::Converged && (foot.distance - (x - ring.point(0.97)).norm()).abs() < 0.01
        );
        assert!((0.0..1.0).contains(&foot.parameter), "{foot}");
    }
}

#[test]
fn starts_and_dimensions() {
    let helix = CurveFn::new(Interval::new(0.0, 12.0).unwrap(), |t: f64| {
        let (s, c) = t.sin_cos();
        CurveJet {
            point: Vector3::new(c, s, 0.3 * t),
            d1: Vector3::new(-s, c, 0.3),
            d2: Vector3::new(-c, -s, 0.0),
        }
    });
    let dynamic: &dyn ParametricCurve<3> = &helix;
    let x = helix.point(7.3) + Vector3::new(7.3_f64.cos(), 7.3_f64.sin(), 0.0) * 0.4;
    for start in [Start::At(7.0), Start::NearestSample(40), Start::Quadrilaterals(40), Start::At(f64::NAN)] {
        let foot = project_curve(dynamic, &x, start, &LocalOptions::default());
        assert!((foot.parameter - 7.3).abs() < 1e-10, "{start:?}: {foot}");
    }
    let curve = cubic_curve();
    for start in [Start::ControlPolygon, Start::NearestSample(8), Start::Quadrilaterals(8)] {
        let foot = project_curve(&curve, &Vector2::new(381.0, 252.0), start, &LocalOptions::default());
        assert!((foot.parameter - 0.769_514_010_309_026).abs() < 1e-11, "{start:?}: {foot}");
    }
}

#[test]
fn stop_rules_and_inversion_errors() {
    let curve = cubic_curve();
    let x = Vector2::new(332.0, 200.0);
    let rough = LocalOptions::default().with_angle_tolerance(1e-3).with_optimality_tolerance(1e-2);
    let trace = iterate_curve(&curve, &x, 0.5, &rough);
    let all = iterate_curve(&curve, &x, 0.5, &LocalOptions::default());
    assert!(trace.status == Status::Converged && trace.steps.len() < all.steps.len());
    assert!(trace.steps.iter().all(|s| s.angle > 1e-3));
    let default = LocalOptions::default();
    let error = invert_curve(&curve, &x, 0.6, 1e-6, &default).unwrap_err();
    assert!(matches!(error, Error::NotOnShape { distance, .. } if distance > 1.0), "{error}");
    let error = invert_curve(&curve, &x, 0.6, f64::NAN, &default).unwrap_err();
    assert!(matches!(error, Error::Option { option: "tolerance", .. }));
    let error = invert_curve(&curve, &Vector2::new(f64::INFINITY, 0.0), 0.6, 1.0, &default).unwrap_err();
    assert_eq!(error, Error::NonFinitePoint { index: 0 });
}
