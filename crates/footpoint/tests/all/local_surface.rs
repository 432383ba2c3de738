//! Local projection onto surfaces, through the public interface.

#![allow(clippy::unwrap_used, reason = "a set-up that fails must fail the test")]

use crate::local_common::{bumpy_surface, fan, roof_surface, sphere};
use footpoint::local::{LocalOptions, Method, Start, invert_surface, iterate_surface, project_surface};
use footpoint::{Error, Location, Status};
use nalgebra::Vector3;
use nurbs_core::{Interval, ParametricSurface, SurfaceFn, SurfaceJet};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, TAU};

fn options(method: Method) -> LocalOptions {
    LocalOptions::default().with_method(method)
}

fn heights() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-1.0..1.0, 30)
}

fn brute_force(surface: &dyn ParametricSurface, x: &Vector3<f64>, n: usize) -> ([f64; 2], f64) {
    let [du, dv] = surface.domain();
    (0..=n * n + 2 * n)
        .map(|k| [du.lerp((k / (n + 1)) as f64 / n as f64), dv.lerp((k % (n + 1)) as f64 / n as f64)])
        .map(|p| (p, (surface.point(p[0], p[1]) - x).norm()))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap()
}

/// No point of a small ring around the parameters is nearer.
fn is_local_minimum(surface: &dyn ParametricSurface, x: &Vector3<f64>, [u, v]: [f64; 2]) -> bool {
    let domains = surface.domain();
    let here = (surface.point(u, v) - x).norm();
    (0..32).all(|i| {
        let (s, c) = (TAU * f64::from(i) / 32.0).sin_cos();
        let p = domains[0].clamp(u + 1e-4 * domains[0].length() * c);
        let q = domains[1].clamp(v + 1e-4 * domains[1].length() * s);
        (surface.point(p, q) - x).norm() >= here * (1.0 - 1e-13) - 1e-13
    })
}

/// A step used to land 1e-33 before the bound of `u`, where no further one was long enough.
#[test]
fn a_bound_missed_by_rounding_counts_as_reached() {
    let heights = [
        0.0,
        0.016664632078468793,
        -0.2995464725267222,
        -0.8388688113465228,
        0.6595526985146105,
        0.0,
        0.4061095038828638,
        -0.3160280005376535,
        -0.3385772679539415,
        0.03835675020190689,
        0.0,
        -0.05731961605760281,
        0.8695776279813062,
        0.4279686150607804,
        -0.13794502584514207,
        0.0,
        0.44167214255100073,
        0.07766047593745576,
        0.1746009320937,
        -0.30712265053454646,
        0.0,
        0.27497644943626554,
        -0.14887656383986295,
        -0.7174221423571633,
        -0.9142948691803084,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
    ];
    let surface = bumpy_surface(&heights);
    let x = Vector3::new(-1.0839651294580341, 4.3110926551971716, -0.3601546530774998);
    for method in Method::ALL {
        for u in [0.4387937079502482, 1e-33] {
            let foot = project_surface(
                &surface,
                &x,
                [u, 0.5869930650092509],
                &options(method).with_max_iterations(1000),
            );
            assert_eq!(
                (foot.status, foot.location),
                (Status::OnBoundary, Location::Edge),
                "{method:?}: {foot}"
            );
        }
    }
}

/// From beside one pole the iteration must not end at the other.
#[test]
fn starts_beside_a_pole_lead_to_the_foot() {
    let x = Vector3::new(-1.1940046020137247, 0.8651656785190329, 0.0);
    let foot =
        project_surface(&sphere(), &x, [1.076748424719503, 1.5706447370285053], &LocalOptions::default());
    assert_eq!(foot.status, Status::Converged, "{foot}");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(96) })]

    #[test]
    fn feet_are_local_minima_and_never_farther_than_the_start(
        heights in heights(), x in -2.0..7.0, y in -2.0..6.0, z in -3.0..3.0, u in 0.0..=1.0, v in 0.0..=1.0,
        m in 0..5usize,
    ) {
        let surface = bumpy_surface(&heights);
        let x = Vector3::new(x, y, z);
        let options = options(Method::ALL[m]).with_max_iterations(1000);
        let foot = project_surface(&surface, &x, [u, v], &options);
        // Linear convergence may be slow.
        let linear = !matches!(Method::ALL[m], Method::PrincipalCircle | Method::Newton);
        let slow = linear && foot.status == Status::MaxIterations;
        prop_assert!(foot.status.is_converged() || slow, "{foot}");
        prop_assert!(slow || is_local_minimum(&surface, &x, foot.parameter), "{foot}");
        prop_assert!(foot.distance <= (surface.point(u, v) - x).norm() * (1.0 + 1e-13));
        let [p, q] = foot.parameter;
        prop_assert_eq!(foot.distance, (surface.point(p, q) - x).norm());
        let at_end = [p, q].map(|t| t == 0.0 || t == 1.0);
        let location = match at_end {
            [true, true] => Location::Corner,
            [false, false] => Location::Interior,
            _ => Location::Edge,
        };
        prop_assert_eq!(foot.location, location);
        prop_assert!(slow || (foot.status == Status::OnBoundary) == (location != Location::Interior));
    }

    #[test]
    fn a_good_start_gives_the_nearest_point(
        heights in heights(), x in -2.0..7.0, y in -2.0..6.0, z in -3.0..3.0,
    ) {
        let surface = bumpy_surface(&heights);
        let x = Vector3::new(x, y, z);
        let (start, sampled) = brute_force(&surface, &x, 60);
        for method in [Method::PrincipalCircle, Method::Newton] {
            let foot = project_surface(&surface, &x, start, &options(method));
            prop_assert!(foot.status.is_converged(), "{foot}");
            prop_assert!(foot.iterations <= 40, "{foot}");
            prop_assert!(foot.distance <= sampled * (1.0 + 1e-14));
        }
    }

    #[test]
    fn rigid_motions_change_nothing(
        heights in heights(), x in 0.0..5.0, y in 0.0..4.0, z in -3.0..3.0, u in 0.1..0.9, v in 0.1..0.9,
        angle in -3.0..3.0_f64, shift in -100.0..100.0_f64, m in 0..5usize,
    ) {
        let surface = bumpy_surface(&heights);
        let rotation = nalgebra::Rotation3::from_euler_angles(angle, 0.7 * angle, -angle);
        let shift = Vector3::new(shift, -shift, 0.3 * shift);
        let moved = SurfaceFn::new(surface.domain(), |u: f64, v: f64| {
            let j = surface.jet(u, v);
            SurfaceJet {
                point: rotation * j.point + shift,
                du: rotation * j.du,
                dv: rotation * j.dv,
                duu: rotation * j.duu,
                duv: rotation * j.duv,
                dvv: rotation * j.dvv,
            }
        });
        let x = Vector3::new(x, y, z);
        let options = options(Method::ALL[m]).with_max_iterations(1);
        let a = iterate_surface(&surface, &x, [u, v], &options);
        let b = iterate_surface(&moved, &(rotation * x + shift), [u, v], &options);
        for k in 0..2 {
            let (p, q) = (a.steps[0].delta[k], b.steps[0].delta[k]);
            prop_assert!((p - q).abs() < 1e-9 * (1.0 + p.abs()), "{p} {q}");
        }
    }

    #[test]
    fn spheres_are_exact_from_every_start(
        x in -2.0..2.0, y in -2.0..2.0, z in -2.0..2.0, u in 0.0..TAU, v in -FRAC_PI_2..=FRAC_PI_2,
    ) {
        let x = Vector3::new(x, y, z);
        prop_assume!(x.norm() > 0.05);
        let foot = project_surface(&sphere(), &x, [u, v], &LocalOptions::default());
        prop_assert_eq!(foot.status, Status::Converged);
        prop_assert!((foot.distance - (x.norm() - 1.0).abs()).abs() < 1e-12, "{foot}");
        prop_assert!((foot.signed_distance - (x.norm() - 1.0)).abs() < 1e-12);
    }

    #[test]
    fn inversion_recovers_parameters(heights in heights(), u in 0.0..=1.0, v in 0.0..=1.0) {
        let surface = bumpy_surface(&heights);
        let x = surface.point(u, v);
        let found = invert_surface(&surface, &x, Start::NearestSample(20), 1e-8, &LocalOptions::default()).unwrap();
        prop_assert!((found.parameter[0] - u).abs() < 1e-9 && (found.parameter[1] - v).abs() < 1e-9);
    }
}

#[test]
fn orders_of_convergence() {
    let surface = bumpy_surface(&(0..30).map(|k| (f64::from(k) * 1.7).sin()).collect::<Vec<_>>());
    let exact = [0.43, 0.57];
    let jet = surface.jet(exact[0], exact[1]);
    let x = jet.point + jet.normal_direction().normalize() * 0.4;
    for (method, low, high) in [
        (Method::FirstOrder, 0.8, 1.2),
        (Method::SecondOrder, 0.8, 1.3),
        (Method::PrincipalCircle, 1.7, 2.3),
        (Method::Newton, 1.7, 2.3),
    ] {
        let trace = iterate_surface(&surface, &x, [0.44, 0.565], &options(method).with_max_iterations(5));
        let error = |k: usize| {
            let p = trace.steps[k].parameter;
            f64::hypot(p[0] - exact[0], p[1] - exact[1])
        };
        let order = (error(3) / error(2)).ln() / (error(2) / error(1)).ln();
        assert!((low..high).contains(&order), "{method:?}: {order} {:?}", trace.steps);
    }
}

#[test]
fn poles_are_left_and_found() {
    let sphere = sphere();
    for method in Method::ALL {
        let options = options(method).with_max_iterations(500);
        // From the pole to a foot far away, in a direction that the pole's own longitude does not have.
        let x = Vector3::new(-2.0, 0.5, 0.1);
        let foot = project_surface(&sphere, &x, [0.2, FRAC_PI_2], &options);
        assert!(foot.status == Status::Converged && (foot.distance - x.norm() + 1.0).abs() < 1e-12, "{foot}");
        // To the pole from far away, and from itself.
        for start in [[1.0, 0.3], [4.0, FRAC_PI_2], [0.0, 1.5]] {
            let foot = project_surface(&sphere, &Vector3::new(0.0, 0.0, 1.7), start, &options);
            assert!((foot.distance - 0.7).abs() < 1e-12, "{method:?}: {foot}");
            assert!(foot.status == Status::Converged, "{method:?} from {start:?}: {foot}");
        }
    }
    let foot = project_surface(&sphere, &Vector3::new(0.0, 0.0, -3.0), [2.0, -1.5], &LocalOptions::default());
    assert_eq!((foot.location, foot.status), (Location::Pole, Status::Converged));
    assert!((foot.signed_distance - 2.0).abs() < 1e-12);
}

#[test]
fn a_collapsed_edge_is_a_corner_of_the_shape() {
    let fan = fan();
    for method in Method::ALL {
        let options = options(method).with_max_iterations(500);
        // Beyond the tip: nearest is the tip itself, at the boundary of the shape.
        let foot = project_surface(&fan, &Vector3::new(-1.0, -0.5, 0.3), [0.3, 0.7], &options);
        assert_eq!((foot.location, foot.status), (Location::Pole, Status::OnBoundary), "{method:?} {foot}");
        // Out of the tip along a direction other than the start's.
        let x = Vector3::new(0.1, 0.4, 0.2);
        let foot = project_surface(&fan, &x, [0.0, 0.0], &options);
        assert!(foot.status == Status::Converged && (foot.distance - 0.2).abs() < 1e-12, "{method:?} {foot}");
        // Beside the straight edge u = 0, onto it.
        let foot = project_surface(&fan, &Vector3::new(0.5, -0.5, 0.0), [0.8, 0.0], &options);
        assert!((foot.distance - 0.5).abs() < 1e-12, "{method:?} {foot}");
        assert_eq!((foot.location, foot.status), (Location::Edge, Status::OnBoundary), "{method:?} {foot}");
    }
}

#[test]
fn ridges_are_crossed_or_kept() {
    let roof = roof_surface();
    for method in Method::ALL {
        let foot = project_surface(&roof, &Vector3::new(1.2, 1.0, 3.0), [0.3, 0.9], &options(method));
        assert_eq!((foot.parameter[0], foot.status), (1.0, Status::Converged), "{method:?} {foot}");
        assert!((foot.parameter[1] - 1.0 / 3.0).abs() < 1e-12);
        let foot = project_surface(&roof, &Vector3::new(2.0, 1.0, 0.0), [0.3, 0.9], &options(method));
        assert!((foot.parameter[0] - 1.5).abs() < 1e-12 && foot.status == Status::Converged, "{foot}");
        let foot = project_surface(&roof, &Vector3::new(1.0, -2.0, 5.0), [2.0, 0.9], &options(method));
        assert_eq!((foot.parameter, foot.location), ([1.0, 0.0], Location::Edge));
    }
    // On the ridge, but inside the roof: down on either side.
    let foot = project_surface(&roof, &Vector3::new(1.0, 1.5, -1.0), [1.0, 0.5], &LocalOptions::default());
    assert!((foot.distance - 0.5_f64.sqrt()).abs() < 1e-12, "{foot}");
}

#[test]
fn saddles_and_maxima_are_left() {
    // z = (x² − y²)/2 seen from high above its saddle point, where the distance has a saddle too.
    let square = Interval::new(-2.0, 2.0).unwrap();
    let saddle = SurfaceFn::new([square, square], |u: f64, v: f64| SurfaceJet {
        point: Vector3::new(u, v, 0.5 * (u * u - v * v)),
        du: Vector3::new(1.0, 0.0, u),
        dv: Vector3::new(0.0, 1.0, -v),
        duu: Vector3::new(0.0, 0.0, 1.0),
        duv: Vector3::zeros(),
        dvv: Vector3::new(0.0, 0.0, -1.0),
    });
    let x = Vector3::new(0.0, 0.0, 2.0);
    for method in Method::ALL {
        let foot = project_surface(&saddle, &x, [0.0, 0.0], &options(method).with_max_iterations(500));
        assert!(foot.status == Status::Converged && (foot.distance - 3.0_f64.sqrt()).abs() < 1e-12, "{foot}");
    }
    let foot =
        project_surface(&sphere(), &Vector3::new(0.5, 0.0, 0.0), [TAU / 2.0, 0.0], &LocalOptions::default());
    assert!((foot.distance - 0.5).abs() < 1e-12 && foot.signed_distance < 0.0, "{foot}");
}

#[test]
fn every_status_is_reached() {
    let surface = bumpy_surface(&(0..30).map(|k| (f64::from(k) * 1.7).sin()).collect::<Vec<_>>());
    let (x, start) = (Vector3::new(2.5, 2.0, 2.5), [0.1, 0.9]);
    let default = LocalOptions::default();
    assert_eq!(project_surface(&surface, &x, start, &default).status, Status::Converged);
    let beyond = project_surface(&surface, &Vector3::new(-5.0, -5.0, 0.0), start, &default);
    assert_eq!((beyond.status, beyond.location), (Status::OnBoundary, Location::Corner));
    let few = default.with_max_iterations(1);
    assert_eq!(project_surface(&surface, &x, start, &few).status, Status::MaxIterations);
    let coarse = default.with_parameter_tolerance(1.0);
    assert_eq!(project_surface(&surface, &x, start, &coarse).status, Status::Stalled);
    let nan = Vector3::new(0.0, f64::NAN, 0.0);
    let invalid = project_surface(&surface, &nan, start, &default);
    assert_eq!(invalid.status, Status::InvalidPoint);
    assert_eq!(iterate_surface(&surface, &nan, start, &default).status, Status::InvalidPoint);
    let zero = Vector3::zeros();
    let broken = SurfaceFn::new([Interval::UNIT, Interval::UNIT], |u: f64, v: f64| SurfaceJet {
        point: Vector3::new(u, v, f64::NAN),
        du: Vector3::x(),
        dv: Vector3::y(),
        duu: zero,
        duv: zero,
        dvv: zero,
    });
    assert_eq!(project_surface(&broken, &x, start, &default).status, Status::Diverged);
    // A surface that is a single point: every parameter is a footpoint, and no step exists.
    let point = SurfaceFn::new([Interval::UNIT, Interval::UNIT], |_: f64, _: f64| SurfaceJet {
        point: zero,
        du: zero,
        dv: zero,
        duu: zero,
        duv: zero,
        dvv: zero,
    });
    let foot = project_surface(&point, &x, start, &default);
    assert!(foot.status.is_converged() && foot.distance == x.norm());
}

#[test]
fn starts_and_inversion_errors() {
    let surface = bumpy_surface(&(0..30).map(|k| 0.3 * (f64::from(k) * 1.7).sin()).collect::<Vec<_>>());
    let dynamic: &dyn ParametricSurface = &surface;
    let jet = surface.jet(0.62, 0.31);
    let x = jet.point + jet.normal_direction().normalize() * 0.1;
    let default = LocalOptions::default();
    for start in [
        Start::ControlPolygon,
        Start::NearestSample(8),
        Start::Quadrilaterals(6),
        Start::At([0.6, 0.3]),
        Start::At([f64::NAN, 0.3]),
    ] {
        let foot = project_surface(dynamic, &x, start, &default);
        assert!(
            (foot.parameter[0] - 0.62).abs() < 1e-10 && (foot.parameter[1] - 0.31).abs() < 1e-10,
            "{foot}"
        );
    }
    let error = invert_surface(&surface, &x, [0.6, 0.3], 1e-3, &default).unwrap_err();
    assert!(matches!(error, Error::NotOnShape { distance, .. } if (distance - 0.1).abs() < 1e-9));
}
