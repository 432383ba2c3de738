//! Interpolation and least squares approximation through the public interface.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may panic as tests do")]
#![allow(clippy::cast_possible_truncation, reason = "small counts")]

use nalgebra::{DMatrix, SVector, Vector2, Vector3};
use nurbs_core::{
    BsplineCurve, BsplineSurface, CurveFitOptions, Direction, Error, GridOptions, Interval, KnotVector,
    ParameterMethod, ParametricCurve, ParametricSurface, SurfaceFitOptions, basis, closed_parameters,
    parameters,
};
use proptest::prelude::*;

/// Numbers in [0, 1) without a distribution to speak of, the same on every run.
struct Scramble(u64);

impl Scramble {
    fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn point<const D: usize>(&mut self) -> SVector<f64, D> {
        SVector::from_fn(|_, _| 10.0 * self.next() - 5.0)
    }
}

fn methods() -> impl Strategy<Value = ParameterMethod> {
    prop_oneof![
        Just(ParameterMethod::Uniform),
        Just(ParameterMethod::ChordLength),
        Just(ParameterMethod::Centripetal)
    ]
}

fn knots(degree: usize, periodic: bool, spans: usize) -> KnotVector {
    if periodic {
        KnotVector::uniform_periodic(degree, spans + degree).unwrap()
    } else {
        KnotVector::uniform_clamped(degree, spans + degree).unwrap()
    }
}

fn random_curve(knots: KnotVector, scramble: &mut Scramble) -> BsplineCurve<2> {
    let mut points: Vec<Vector2<f64>> = (0..knots.distinct_count()).map(|_| scramble.point()).collect();
    points.extend_from_within(..knots.basis_count() - points.len());
    BsplineCurve::new(knots, points, None).unwrap()
}

fn random_surface(u: KnotVector, v: KnotVector, scramble: &mut Scramble) -> BsplineSurface {
    let (du, dv) = (u.distinct_count(), v.distinct_count());
    let points: Vec<Vector3<f64>> = (0..du * dv).map(|_| scramble.point()).collect();
    let net = (0..u.basis_count())
        .flat_map(|i| (0..v.basis_count()).map(move |j| (i % du) * dv + j % dv))
        .map(|k| points[k])
        .collect();
    BsplineSurface::new(u, v, net, None).unwrap()
}

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        rng_seed: prop::test_runner::RngSeed::Fixed(8),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config(96))]

    #[test]
    fn open_interpolation_passes_through(n in 2..40_usize, p in 1..6_usize, method in methods(), seed: u64) {
        let mut scramble = Scramble::new(seed);
        let points: Vec<Vector3<f64>> = (0..n).map(|_| scramble.point()).collect();
        let p = p.min(n - 1);
        let curve = BsplineCurve::interpolate(&points, p, method).unwrap();
        prop_assert_eq!((curve.degree(), curve.control_points().len()), (p, n));
        for (t, x) in parameters(&points, method).unwrap().iter().zip(&points) {
            prop_assert!((curve.point(*t) - x).norm() < 1e-10);
        }
    }

    #[test]
    fn end_derivatives_are_taken(n in 3..30_usize, p in 2..6_usize, at_start: bool, at_end: bool, seed: u64) {
        let mut scramble = Scramble::new(seed);
        let points: Vec<Vector2<f64>> = (0..n).map(|_| scramble.point()).collect();
        let (a, b) = (scramble.point::<2>() * 3.0, scramble.point::<2>() * 3.0);
        let p = p.min(n - 1);
        let method = ParameterMethod::ChordLength;
        let (start, end) = (at_start.then_some(a), at_end.then_some(b));
        let curve = BsplineCurve::interpolate_with_derivatives(&points, p, method, start, end).unwrap();
        for (t, x) in parameters(&points, method).unwrap().iter().zip(&points) {
            prop_assert!((curve.point(*t) - x).norm() < 1e-9);
        }
        prop_assert!(!at_start || (curve.jet(0.0).d1 - a).norm() < 1e-9);
        prop_assert!(!at_end || (curve.jet(1.0).d1 - b).norm() < 1e-9);
    }

    #[test]
    fn closed_interpolation_is_smooth_and_passes_through(n in 6..40_usize, p in 1..6_usize, method in methods(), seed: u64) {
        // A bumpy circle, unevenly sampled.
        let mut scramble = Scramble::new(seed);
        let points: Vec<Vector2<f64>> = (0..n)
            .map(|i| {
                let a = (i as f64 + 0.6 * scramble.next()) / n as f64 * std::f64::consts::TAU;
                Vector2::new(a.cos(), a.sin()) * (3.0 + scramble.next())
            })
            .collect();
        let curve = BsplineCurve::interpolate_closed(&points, p, method).unwrap();
        prop_assert_eq!(curve.period(), Some(curve.domain().length()));
        for (t, x) in closed_parameters(&points, method).unwrap().iter().zip(&points) {
            prop_assert!((curve.point(*t) - x).norm() < 1e-9, "{t}");
        }
        let (a, b) = (curve.domain().start(), curve.domain().end());
        let before = BsplineCurve::derivatives(&curve.clamped().unwrap(), b, p - 1);
        let after = curve.derivatives(a, p - 1);
        for (x, y) in before.iter().zip(&after) {
            prop_assert!((x - y).norm() <= 1e-8 * (1.0 + x.norm()), "{x} {y}");
        }
    }

    #[test]
    fn least_squares_reproduces_splines(p in 1..6_usize, spans in 3..12_usize, periodic: bool, seed: u64) {
        let mut scramble = Scramble::new(seed);
        let curve = random_curve(knots(p, periodic, spans), &mut scramble);
        let n = 12 * (spans + p);
        let mut params: Vec<f64> = (0..n).map(|i| curve.domain().lerp(i as f64 / (n - 1) as f64)).collect();
        let (i, j) = (n / 3, n / 2);
        params.swap(i, j);
        let points: Vec<Vector2<f64>> = params.iter().map(|&t| curve.point(t)).collect();
        let weights = (0..n).map(|_| 0.1 + scramble.next()).collect();
        let options = CurveFitOptions::default().with_weights(weights);
        let fit = BsplineCurve::approximate(curve.knots().clone(), &params, &points, &options).unwrap();
        prop_assert!(fit.max < 1e-11, "{fit}");
        for (a, b) in fit.shape.control_points().iter().zip(curve.control_points()) {
            prop_assert!((a - b).norm() < 1e-9);
        }
    }

    #[test]
    fn least_squares_is_the_dense_solution(p in 1..5_usize, spans in 2..8_usize, periodic: bool, seed: u64) {
        let mut scramble = Scramble::new(seed);
        let knots = knots(p, periodic, spans);
        let (n, m) = (knots.distinct_count(), 10 * (spans + p));
        let params: Vec<f64> = (0..m).map(|i| knots.domain().lerp((i as f64 + scramble.next()) / m as f64)).collect();
        let points: Vec<Vector2<f64>> = (0..m).map(|_| scramble.point()).collect();
        let weights: Vec<f64> = (0..m).map(|_| 0.2 + scramble.next()).collect();
        let mut a = DMatrix::zeros(m, n);
        for (k, &t) in params.iter().enumerate() {
            let span = knots.span(t);
            let mut row = [0.0; nurbs_core::MAX_DEGREE + 1];
            basis::values(&knots, span, t, &mut row);
            (0..=p).for_each(|j| a[(k, (span - p + j) % n)] += row[j] * weights[k].sqrt());
        }
        let b = DMatrix::from_fn(m, 2, |k, c| points[k][c] * weights[k].sqrt());
        let dense = (a.transpose() * &a).cholesky().unwrap().solve(&(a.transpose() * b));
        let options = CurveFitOptions::default().with_weights(weights);
        let fit = BsplineCurve::approximate(knots, &params, &points, &options).unwrap();
        for (i, c) in fit.shape.control_points().iter().enumerate() {
            let (x, y) = (dense[(i % n, 0)], dense[(i % n, 1)]);
            prop_assert!((c - Vector2::new(x, y)).norm() < 1e-8 * (1.0 + c.norm()), "{i}: {c} {x} {y}");
        }
        let largest = params.iter().zip(&points).map(|(&t, x)| (fit.shape.point(t) - x).norm());
        prop_assert!((largest.fold(0.0, f64::max) - fit.max).abs() < 1e-12);
    }

    #[test]
    fn fixed_ends_stay(p in 2..5_usize, spans in 4..9_usize, seed: u64) {
        let mut scramble = Scramble::new(seed);
        let knots = knots(p, false, spans);
        let params: Vec<f64> = (0..80).map(|i| f64::from(i) / 79.0).collect();
        let points: Vec<Vector2<f64>> = params.iter().map(|_| scramble.point()).collect();
        let (start, end) = (vec![scramble.point(), scramble.point(), scramble.point()], vec![scramble.point(), scramble.point()]);
        let options = CurveFitOptions::default().with_start(start.clone()).with_end(end.clone());
        let fit = BsplineCurve::approximate(knots, &params, &points, &options).unwrap();
        for (t, wanted) in [(0.0, &start), (1.0, &end)] {
            for (d, x) in fit.shape.derivatives(t, wanted.len() - 1).iter().zip(wanted) {
                prop_assert!((d - x).norm() < 1e-9, "{d} {x}");
            }
        }
    }

    #[test]
    fn knots_for_approximation_hold_data(n in 10..200_usize, p in 1..5_usize, share in 0.1..1.0, periodic: bool, seed: u64) {
        let mut scramble = Scramble::new(seed);
        let params: Vec<f64> = (0..n).map(|_| scramble.next().powi(3)).collect();
        let count = ((n as f64 * share) as usize).max(p + 1);
        let knots = if periodic {
            KnotVector::for_periodic_approximation(p, &params, Interval::new(0.0, 1.0).unwrap(), count).unwrap()
        } else {
            KnotVector::for_approximation(p, &params, count).unwrap()
        };
        prop_assert_eq!(knots.distinct_count(), count);
        for span in knots.spans() {
            let interval = knots.span_interval(span);
            prop_assert!(params.iter().any(|&t| interval.contains(t)));
        }
    }
}

proptest! {
    #![proptest_config(config(32))]

    #[test]
    fn grids_are_interpolated(nu in 5..12_usize, nv in 5..12_usize, p in 1..4_usize, q in 1..4_usize, cu: bool, cv: bool, seed: u64) {
        let mut scramble = Scramble::new(seed);
        let tau = std::f64::consts::TAU;
        let points: Vec<Vector3<f64>> = (0..nu * nv)
            .map(|k| {
                let (a, b) = ((k / nv) as f64 / nu as f64 * tau, (k % nv) as f64 / nv as f64 * tau);
                let r = 5.0 + 2.0 * b.cos();
                Vector3::new(r * a.cos(), r * a.sin(), 2.0 * b.sin()) + scramble.point::<3>() * 0.03
            })
            .collect();
        let options = GridOptions::default().with_degrees(p, q).with_closed(cu, cv);
        let surface = BsplineSurface::interpolate_grid(&points, [nu, nv], &options).unwrap();
        prop_assert_eq!(surface.period().map(|p| p.is_some()), [cu, cv]);
        let [us, vs] = nurbs_core::grid_parameters(&points, [nu, nv], [cu, cv], options.method).unwrap();
        for (i, u) in us.iter().enumerate() {
            for (j, v) in vs.iter().enumerate() {
                prop_assert!((surface.point(*u, *v) - points[i * nv + j]).norm() < 1e-9);
            }
        }
    }

    #[test]
    fn surface_least_squares_reproduces_splines(p in 1..4_usize, q in 1..4_usize, pu: bool, pv: bool, seed: u64) {
        let mut scramble = Scramble::new(seed);
        let surface = random_surface(knots(p, pu, 5), knots(q, pv, 4), &mut scramble);
        let params: Vec<[f64; 2]> = (0..1600)
            .map(|k| [(f64::from(k / 40) + scramble.next()) / 40.0, (f64::from(k % 40) + scramble.next()) / 40.0])
            .collect();
        let points: Vec<Vector3<f64>> = params.iter().map(|&[u, v]| surface.point(u, v)).collect();
        let knots = [surface.knots_u().clone(), surface.knots_v().clone()];
        let options = SurfaceFitOptions::default().with_boundary_of(&surface);
        for options in [SurfaceFitOptions::default(), options] {
            let fit = BsplineSurface::approximate(knots.clone(), &params, &points, &options).unwrap();
            prop_assert!(fit.max < 1e-10, "{fit}");
            for (a, b) in fit.shape.control_points().iter().zip(surface.control_points()) {
                prop_assert!((a - b).norm() < 1e-8);
            }
        }
    }

    #[test]
    fn surface_boundaries_stay(seed: u64) {
        let mut scramble = Scramble::new(seed);
        let model = random_surface(knots(3, false, 4), knots(2, false, 5), &mut scramble);
        let params: Vec<[f64; 2]> = (0..900).map(|_| [scramble.next(), scramble.next()]).collect();
        let points: Vec<Vector3<f64>> = params.iter().map(|_| scramble.point()).collect();
        let knots = [model.knots_u().clone(), model.knots_v().clone()];
        let options = SurfaceFitOptions::default().with_boundary_of(&model).with_regularization(1e-6);
        let fit = BsplineSurface::approximate(knots, &params, &points, &options).unwrap();
        for i in 0..=20 {
            let s = f64::from(i) / 20.0;
            for (u, v) in [(0.0, s), (1.0, s), (s, 0.0), (s, 1.0)] {
                prop_assert!((fit.shape.point(u, v) - model.point(u, v)).norm() < 1e-12);
            }
        }
    }
}

#[test]
fn polynomials_are_reproduced() {
    // Interpolation of degree p reproduces polynomials of degree p, far from the origin too.
    let offset = Vector2::new(4.0e6, -7.0e6);
    for p in 1..=5_i32 {
        let f = |t: f64| Vector2::new(t.powi(p) - t, 2.0 - t.powi(p - 1));
        let params: Vec<f64> = (0..15).map(|i| (f64::from(i) / 14.0).powf(1.3)).collect();
        let points: Vec<_> = params.iter().map(|&t| f(t) + offset).collect();
        let knots = KnotVector::averaged(usize::try_from(p).unwrap(), &params).unwrap();
        let curve = BsplineCurve::interpolate_at(knots.clone(), &params, &points).unwrap();
        let fit = BsplineCurve::approximate(knots, &params, &points, &CurveFitOptions::default()).unwrap();
        for i in 0..=50 {
            let t = f64::from(i) / 50.0;
            assert!((curve.point(t) - offset - f(t)).norm() < 1e-8);
            assert!((fit.shape.point(t) - offset - f(t)).norm() < 1e-8);
        }
    }
}

#[test]
fn regularization_bridges_gaps_and_its_absence_is_an_error() {
    let knots = KnotVector::uniform_clamped(3, 20).unwrap();
    let params: Vec<f64> =
        (0..200).map(|i| f64::from(i) / 199.0).filter(|t| !(0.3..0.7).contains(t)).collect();
    let points: Vec<_> = params.iter().map(|&t| Vector2::new(t, 3.0 * t - 1.0)).collect();
    let plain = BsplineCurve::approximate(knots.clone(), &params, &points, &CurveFitOptions::default());
    let Err(Error::Singular { what }) = plain else { panic!("{plain:?}") };
    // The functions 9 and 10 live in the middle of the gap.
    assert!(what.contains("9, 10"), "{what}");
    let options = CurveFitOptions::default().with_regularization(1e-9);
    let fit = BsplineCurve::approximate(knots, &params, &points, &options).unwrap();
    // A straight line costs no energy.
    assert!((fit.shape.point(0.5) - Vector2::new(0.5, 0.5)).norm() < 1e-6);
    assert!(fit.max < 1e-8, "{fit}");
}

#[test]
fn surfaces_name_the_control_points_without_data() {
    let knots = [KnotVector::uniform_clamped(2, 8).unwrap(), KnotVector::uniform_clamped(2, 8).unwrap()];
    let all: Vec<[f64; 2]> =
        (0..2500).map(|k| [f64::from(k / 50) / 49.0, f64::from(k % 50) / 49.0]).collect();
    let params: Vec<[f64; 2]> = all.into_iter().filter(|[u, v]| u + v < 1.66).collect();
    let points: Vec<_> = params.iter().map(|&[u, v]| Vector3::new(u, v, 1.0 + u - v)).collect();
    let plain = BsplineSurface::approximate(knots.clone(), &params, &points, &SurfaceFitOptions::default());
    let Err(Error::Singular { what }) = plain else { panic!("{plain:?}") };
    assert!(what.contains("(7, 7)"), "{what}");
    let options = SurfaceFitOptions::default().with_regularization(1e-8);
    let fit = BsplineSurface::approximate(knots, &params, &points, &options).unwrap();
    assert!((fit.shape.point(1.0, 1.0) - Vector3::new(1.0, 1.0, 1.0)).norm() < 1e-4);
    // Too few points in a cell, none without data: numerically, not structurally singular.
    let one = [[0.3, 0.4]; 30];
    let bezier = [KnotVector::uniform_clamped(2, 3).unwrap(), KnotVector::uniform_clamped(2, 3).unwrap()];
    let few =
        BsplineSurface::approximate(bezier, &one, &[Vector3::zeros(); 30], &SurfaceFitOptions::default());
    assert!(matches!(few, Err(Error::Singular { .. })), "{few:?}");
}

#[test]
fn energy_matches_quadrature() {
    // With a huge factor the fit is the straight line of regression.
    let knots = KnotVector::uniform_clamped(3, 9).unwrap();
    let params: Vec<f64> = (0..50).map(|i| f64::from(i) / 49.0).collect();
    let points: Vec<_> = params.iter().map(|&t| Vector2::new(t, t * t)).collect();
    let options = CurveFitOptions::default().with_regularization(1e6);
    let fit = BsplineCurve::approximate(knots, &params, &points, &options).unwrap();
    let n = 50.0;
    let (st, sy) = (params.iter().sum::<f64>() / n, points.iter().map(|p| p.y).sum::<f64>() / n);
    let slope = params.iter().zip(&points).map(|(t, p)| (t - st) * (p.y - sy)).sum::<f64>()
        / params.iter().map(|t| (t - st).powi(2)).sum::<f64>();
    for i in 0..=10 {
        let t = f64::from(i) / 10.0;
        assert!((fit.shape.point(t).y - (sy + slope * (t - st))).abs() < 1e-5);
    }
}

#[test]
fn poles_and_bad_data() {
    // A cone tip: one row of the grid is a point.
    let grid: Vec<_> = (0..5)
        .flat_map(|i| {
            (0..8).map(move |j| {
                let a = f64::from(j) / 8.0 * std::f64::consts::TAU;
                Vector3::new(a.cos(), a.sin(), 0.0) * f64::from(i) + Vector3::new(0.0, 0.0, f64::from(i))
            })
        })
        .collect();
    let options = GridOptions::default().with_closed(false, true);
    let cone = BsplineSurface::interpolate_grid(&grid, [5, 8], &options).unwrap();
    assert!(cone.point(0.0, 0.37).norm() < 1e-12);
    assert!(cone.is_closed(Direction::V, 1e-9).unwrap());

    let twice =
        [Vector2::new(0.0, 0.0), Vector2::new(1.0, 1.0), Vector2::new(1.0, 1.0), Vector2::new(2.0, 0.0)];
    let method = ParameterMethod::ChordLength;
    let error = BsplineCurve::interpolate(&twice, 3, method).unwrap_err();
    assert!(error.to_string().contains("points 1 and 2 coincide"), "{error}");
    assert!(BsplineCurve::interpolate(&twice, 3, ParameterMethod::Uniform).is_ok());
    let closed = [Vector2::new(0.0, 0.0), Vector2::new(1.0, 1.0), Vector2::new(0.0, 0.0)];
    assert!(closed_parameters(&closed, method).unwrap_err().to_string().contains("not repeated"));
    let bad = [Vector2::new(0.0, f64::NAN), Vector2::new(1.0, 1.0)];
    assert!(matches!(BsplineCurve::interpolate(&bad, 1, method), Err(Error::Argument { .. })));
    assert!(matches!(BsplineCurve::interpolate(&twice[..1], 1, method), Err(Error::Argument { .. })));
    assert!(matches!(BsplineCurve::interpolate(&twice[..2], 3, method), Err(Error::Argument { .. })));
    assert!(matches!(BsplineCurve::<2>::interpolate(&[], 3, method), Err(Error::Argument { .. })));
    assert!(BsplineSurface::interpolate_grid(&grid, [5, 9], &options).is_err());
    assert!(BsplineSurface::interpolate_grid(&[], [0, 0], &options).is_err());

    let knots = KnotVector::uniform_clamped(1, 3).unwrap();
    let fit = |params: &[f64], options: &CurveFitOptions<2>| {
        BsplineCurve::approximate(knots.clone(), params, &twice, options).map(|fit| fit.max)
    };
    let plain = CurveFitOptions::default();
    assert!(matches!(fit(&[0.0, 0.5, 1.0], &plain), Err(Error::Argument { .. })));
    assert!(matches!(fit(&[0.0, 0.5, 1.0, 1.1], &plain), Err(Error::Argument { .. })));
    assert!(matches!(fit(&[0.0, 0.5, 1.0, f64::NAN], &plain), Err(Error::Argument { .. })));
    let weighted = |w: f64| plain.clone().with_weights(vec![1.0, 1.0, 1.0, w]);
    assert!(matches!(fit(&[0.0, 0.5, 0.6, 1.0], &weighted(-1.0)), Err(Error::Argument { .. })));
    assert!(matches!(fit(&[0.0, 0.1, 0.5, 1.0], &weighted(0.0)), Err(Error::Singular { .. })));
    assert!(fit(&[0.0, 0.5, 0.6, 1.0], &weighted(1.0)).is_ok());
    let negative = plain.clone().with_regularization(-1.0);
    assert!(matches!(fit(&[0.0, 0.5, 0.6, 1.0], &negative), Err(Error::Argument { .. })));
    let nothing = BsplineCurve::<2>::approximate(knots.clone(), &[], &[], &plain);
    assert!(matches!(nothing, Err(Error::Singular { .. })), "{nothing:?}");
    let lazy = BsplineCurve::interpolate_at(knots, &[0.0, 0.1, 0.2], &twice[..3]);
    assert!(matches!(lazy, Err(Error::Singular { .. })), "{lazy:?}");
}

#[test]
fn the_same_bits_every_time() {
    let mut scramble = Scramble::new(7);
    let params: Vec<[f64; 2]> = (0..500).map(|_| [scramble.next(), scramble.next()]).collect();
    let points: Vec<Vector3<f64>> = params.iter().map(|_| scramble.point()).collect();
    let run = || {
        let knots = [knots(3, true, 4), knots(3, false, 4)];
        let options = SurfaceFitOptions::default().with_regularization(1e-5);
        BsplineSurface::approximate(knots, &params, &points, &options).unwrap()
    };
    assert_eq!(run(), run());
}
