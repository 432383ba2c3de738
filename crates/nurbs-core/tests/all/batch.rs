//! Batches give what one evaluation after the other gives, for every kind of shape and parameter.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use nurbs_core::nalgebra::{Vector2, Vector3};
use nurbs_core::{BsplineCurve, BsplineSurface, Error, KnotVector, ParametricCurve, ParametricSurface};
use proptest::prelude::*;

fn noise(i: usize) -> f64 {
    (i as f64 * 0.754_877_666_246_693).fract()
}

/// A surface with uneven knots in `u`, periodic in `v`.
fn surface(p: usize, q: usize, rational: bool) -> BsplineSurface {
    let mut knots = vec![-1.0; p + 1];
    knots.extend([-0.9, -0.2, 0.0, 2.0, 2.1]);
    knots.extend(vec![3.0; p + 1]);
    let (n_u, distinct) = (p + 6, q + 3);
    let knots_v = KnotVector::uniform_periodic(q, distinct).unwrap();
    let at = |i: usize, j: usize| i * distinct + j % distinct;
    let indices: Vec<usize> = (0..n_u).flat_map(|i| (0..distinct + q).map(move |j| at(i, j))).collect();
    let points = indices.iter().map(|&k| Vector3::new(noise(k), noise(3 * k + 1), noise(7 * k + 2)));
    let weights = rational.then(|| indices.iter().map(|&k| 0.5 + noise(5 * k)).collect());
    BsplineSurface::new(KnotVector::new(p, knots).unwrap(), knots_v, points.collect(), weights).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, rng_seed: prop::test_runner::RngSeed::Fixed(4), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn surface_batches_are_the_single_evaluations(
        p in 1usize..=6, q in 1usize..=6, rational: bool,
        params in prop::collection::vec((-2.0..4.0, -1.5..2.5), 0..300),
    ) {
        let params: Vec<[f64; 2]> = params.into_iter().map(|(u, v)| [u, v]).collect();
        let s = surface(p, q, rational);
        let mut jets = vec![s.jet(0.0, 0.0); params.len()];
        let mut points = vec![Vector3::zeros(); params.len()];
        s.jets(&params, &mut jets).unwrap();
        s.points(&params, &mut points).unwrap();
        for (i, &[u, v]) in params.iter().enumerate() {
            prop_assert_eq!(jets[i], s.jet(u, v));
            prop_assert_eq!(points[i], s.point(u, v));
        }
    }

    #[test]
    fn curve_batches_are_the_single_evaluations(
        p in 1usize..=6, rational: bool, params in prop::collection::vec(-2.0..3.0, 0..300),
    ) {
        let n = p + 5;
        let points = (0..n).map(|k| Vector2::new(noise(k), noise(3 * k + 1))).collect();
        let weights = rational.then(|| (0..n).map(|k| 0.5 + noise(5 * k)).collect());
        let c = BsplineCurve::new(KnotVector::uniform_clamped(p, n).unwrap(), points, weights).unwrap();
        let mut jets = vec![c.jet(0.0); params.len()];
        let mut points = vec![Vector2::zeros(); params.len()];
        c.jets(&params, &mut jets).unwrap();
        c.points(&params, &mut points).unwrap();
        for (i, &t) in params.iter().enumerate() {
            prop_assert_eq!(jets[i], c.jet(t));
            prop_assert_eq!(points[i], c.point(t));
        }
    }

    #[test]
    fn jets_agree_with_the_general_derivatives(
        p in 1usize..=7, q in 1usize..=7, rational: bool, u in -1.0..3.0, v in 0.0..1.0,
    ) {
        let s = surface(p, q, rational);
        let (jet, d) = (s.jet(u, v), s.derivatives(u, v, 2));
        let pairs = [
            (jet.point, d[0][0]), (jet.du, d[1][0]), (jet.dv, d[0][1]),
            (jet.duu, d[2][0]), (jet.duv, d[1][1]), (jet.dvv, d[0][2]),
        ];
        for (k, (a, b)) in pairs.into_iter().enumerate() {
            // Terms of the size of a difference quotient over the shortest span cancel.
            let scale = [1.0, 1e2, 1e2, 1e4, 1e4, 1e4][k];
            prop_assert!((a - b).norm() <= 1e-13 * (scale + b.norm()), "{k}: {a} {b}");
        }
        prop_assert!((s.point(u, v) - jet.point).norm() <= 1e-14);
    }
}

#[test]
fn parameters_that_are_no_numbers_stay_among_themselves() {
    let s = surface(3, 3, false);
    let mut params: Vec<[f64; 2]> = (0..100).map(|i| [noise(i), noise(2 * i)]).collect();
    params[17] = [f64::NAN, 0.5];
    params[18] = [0.5, f64::INFINITY];
    let mut jets = vec![s.jet(0.0, 0.0); params.len()];
    s.jets(&params, &mut jets).unwrap();
    assert!(jets[17].point.x.is_nan());
    for (i, &[u, v]) in params.iter().enumerate().filter(|&(i, _)| i != 17 && i != 18) {
        assert_eq!(jets[i], s.jet(u, v), "{i}");
    }
}

#[test]
fn lengths_must_agree() {
    let s = surface(2, 3, false);
    let mut jets = vec![s.jet(0.0, 0.0); 3];
    assert!(matches!(s.jets(&[[0.0; 2]; 4], &mut jets), Err(Error::Argument { .. })));
    assert!(s.jets(&[], &mut []).is_ok());
}

#[test]
fn clamped_ends_are_control_points() {
    for p in 1..=5 {
        let mut knots = vec![0.0; p + 1];
        knots.extend([0.1, 0.25, 0.7]);
        knots.extend(vec![1.0; p + 1]);
        let points: Vec<_> = (0..p + 4).map(|k| Vector3::new(noise(k), noise(3 * k), noise(5 * k))).collect();
        let c = BsplineCurve::new(KnotVector::new(p, knots).unwrap(), points.clone(), None).unwrap();
        assert!((c.point(0.0) - points[0]).norm() <= 2.0 * f64::EPSILON);
        assert!((c.point(1.0) - points[p + 3]).norm() <= 2.0 * f64::EPSILON);
    }
}
