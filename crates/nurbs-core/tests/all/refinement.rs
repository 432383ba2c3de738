//! Laws of the operations that change the description of a shape and not the shape.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may panic as tests do")]
#![allow(clippy::cast_possible_truncation, reason = "small counts")]

use nalgebra::{Isometry3, SVector, Vector2, Vector3};
use nurbs_core::{
    BsplineCurve, BsplineSurface, Direction, Error, Interval, KnotVector, ParametricCurve, ParametricSurface,
};
use proptest::prelude::*;

/// Knots of one of the three kinds from positive steps; some steps are zero (multiple knots).
fn knot_vector(degree: usize, kind: usize, steps: &[u8]) -> KnotVector {
    // Multiplicity at most the degree.
    let mut run = degree;
    let mut t = 0.0;
    let mut inner = Vec::new();
    for &step in steps {
        run = if step < 2 && run + 1 < degree { run + 1 } else { 0 };
        if run == 0 {
            t += f64::from(step % 7) * 0.25 + 0.2;
        }
        inner.push(t);
    }
    let end = t + 0.4;
    match kind {
        0 => {
            let ends = |t| std::iter::repeat_n(t, degree + 1);
            KnotVector::new(degree, ends(0.0).chain(inner).chain(ends(end)).collect()).unwrap()
        }
        1 => {
            let before = (1..=degree).rev().map(|i| -0.3 * i as f64).chain([0.0]);
            let after = (0..=degree).map(|i| end + 0.2 * i as f64);
            KnotVector::new(degree, before.chain(inner).chain(after).collect()).unwrap()
        }
        _ => {
            let cycle: Vec<f64> = std::iter::once(0.0).chain(inner).collect();
            let m = cycle.len() as isize;
            let at = |i: isize| {
                let k = i - degree as isize;
                cycle[k.rem_euclid(m) as usize] + end * k.div_euclid(m) as f64
            };
            KnotVector::periodic(degree, (0..m + 2 * degree as isize + 1).map(at).collect()).unwrap()
        }
    }
}

fn knots_strategy() -> impl Strategy<Value = KnotVector> {
    (1..=5_usize, 0..3_usize, prop::collection::vec(0..20_u8, 6..12))
        .prop_map(|(p, kind, steps)| knot_vector(p, kind, &steps))
}

fn net<const D: usize>(count: usize, seed: u64) -> (Vec<SVector<f64, D>>, Vec<f64>) {
    // A fixed scramble: points need no distribution, only variety.
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let points = (0..count).map(|_| SVector::from_fn(|_, _| 10.0 * next() - 5.0)).collect();
    (points, (0..count).map(|_| 0.3 + 2.0 * next()).collect())
}

fn curve_on(knots: KnotVector, rational: bool, seed: u64) -> BsplineCurve<3> {
    let (mut points, mut weights) = net(knots.distinct_count(), seed);
    let repeated = knots.basis_count() - points.len();
    points.extend_from_within(..repeated);
    weights.extend_from_within(..repeated);
    BsplineCurve::new(knots, points, rational.then_some(weights)).unwrap()
}

fn surface_on(u: KnotVector, v: KnotVector, rational: bool, seed: u64) -> BsplineSurface {
    let (du, dv) = (u.distinct_count(), v.distinct_count());
    let (points, weights) = net::<3>(du * dv, seed);
    let index: Vec<usize> = (0..u.basis_count())
        .flat_map(|i| (0..v.basis_count()).map(move |j| (i % du) * dv + j % dv))
        .collect();
    let weights = index.iter().map(|&i| weights[i]).collect();
    let points = index.iter().map(|&i| points[i]).collect();
    BsplineSurface::new(u, v, points, rational.then_some(weights)).unwrap()
}

fn curve_strategy() -> impl Strategy<Value = BsplineCurve<3>> {
    (knots_strategy(), any::<bool>(), any::<u64>()).prop_map(|(k, r, s)| curve_on(k, r, s))
}

fn surface_strategy() -> impl Strategy<Value = BsplineSurface> {
    (knots_strategy(), knots_strategy(), any::<bool>(), any::<u64>())
        .prop_map(|(u, v, r, s)| surface_on(u, v, r, s))
}

const SIZE: f64 = 10.0;

fn samples(domain: Interval) -> impl Iterator<Item = f64> {
    (0..=40).map(move |i| domain.lerp(f64::from(i) / 40.0))
}

fn assert_same_curve(a: &BsplineCurve<3>, b: &BsplineCurve<3>, on: Interval, tolerance: f64) {
    for t in samples(on) {
        let gap = (a.point(t) - b.point(t)).norm();
        assert!(gap <= tolerance * SIZE, "at {t}: {gap:e}");
    }
}

fn assert_same_surface(a: &BsplineSurface, b: &BsplineSurface, on: [Interval; 2], tolerance: f64) {
    for u in samples(on[0]).step_by(5) {
        for v in samples(on[1]).step_by(5) {
            let gap = (a.point(u, v) - b.point(u, v)).norm();
            assert!(gap <= tolerance * SIZE, "at {u} {v}: {gap:e}");
        }
    }
}

/// A direction and the other, from a coin.
fn direction(coin: bool) -> Direction {
    if coin { Direction::U } else { Direction::V }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, rng_seed: prop::test_runner::RngSeed::Fixed(6), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn refinement_keeps_the_curve(curve in curve_strategy(), at in prop::collection::vec(0.01..0.99, 1..5)) {
        let domain = curve.domain();
        let values: Vec<f64> = at.iter().map(|&s| domain.lerp(s)).collect();
        let finer = curve.refine(&values).unwrap();
        prop_assert_eq!(finer.control_points().len(), curve.control_points().len() + values.len());
        prop_assert_eq!(finer.knots().is_periodic(), curve.knots().is_periodic());
        assert_same_curve(&curve, &finer, domain, 1e-13);
    }

    #[test]
    fn full_multiplicity_is_reached_and_not_passed(curve in curve_strategy(), s in 0.01..0.99) {
        let (t, p) = (curve.domain().lerp(s), curve.degree());
        let present = curve.knots().multiplicity(t);
        let finer = curve.insert_knot(t, p - present).unwrap();
        assert_same_curve(&curve, &finer, curve.domain(), 1e-13);
        prop_assert!(finer.control_points().iter().any(|c| (c - curve.point(t)).norm() < 1e-12 * SIZE));
        let error = finer.insert_knot(t, 1);
        prop_assert!(matches!(error, Err(Error::KnotMultiplicity { .. })), "{error:?}");
    }

    #[test]
    fn seam_of_periodic_curves_takes_knots(steps in prop::collection::vec(0..20_u8, 6..12), p in 2..5_usize, seed: u64) {
        let curve = curve_on(knot_vector(p, 2, &steps), seed % 2 == 0, seed);
        let finer = curve.insert_knot(0.0, p - 1).unwrap();
        prop_assert_eq!(finer.domain(), curve.domain());
        assert_same_curve(&curve, &finer, curve.domain(), 1e-13);
        let (back, report) = finer.remove_knot(0.0, p - 1, 1e-10).unwrap();
        prop_assert_eq!(report.removed, p - 1);
        assert_same_curve(&curve, &back, curve.domain(), 1e-12);
    }

    #[test]
    fn removal_undoes_insertion(curve in curve_strategy(), s in 0.01..0.99, times in 1..3_usize) {
        let t = curve.domain().lerp(s);
        let times = times.min(curve.degree() - curve.knots().multiplicity(t));
        let finer = curve.insert_knot(t, times).unwrap();
        if times > 0 {
            let (coarse, report) = finer.remove_knot(t, times, 1e-9).unwrap();
            prop_assert_eq!(report.removed, times);
            prop_assert!(report.error < 1e-9);
            prop_assert_eq!(coarse.knots().as_slice().len(), curve.knots().as_slice().len());
            assert_same_curve(&curve, &coarse, curve.domain(), 1e-10);
        }
    }

    #[test]
    fn removal_keeps_its_bound(curve in curve_strategy(), tolerance in 0.1..4.0) {
        let (coarse, report) = curve.remove_all_within(tolerance).unwrap();
        prop_assert!(report.error <= tolerance);
        let gap = (0..=200)
            .map(|i| curve.domain().lerp(f64::from(i) / 200.0))
            .map(|t| (curve.point(t) - coarse.point(t)).norm())
            .fold(0.0, f64::max);
        prop_assert!(gap <= report.error * (1.0 + 1e-9) + 1e-10, "{gap} {}", report.error);
        let before = curve.knots().as_slice().len();
        prop_assert_eq!(coarse.knots().as_slice().len() + report.removed, before);
    }

    #[test]
    fn reduction_of_refined_data_finds_the_coarse_curve(curve in curve_strategy(), n in 1..6_i32) {
        let values: Vec<f64> = (0..n).map(|i| curve.domain().lerp((f64::from(i) + 0.317) / f64::from(n))).collect();
        let finer = curve.refine(&values).unwrap();
        let (coarse, report) = finer.remove_all_within(1e-8).unwrap();
        prop_assert!(report.removed >= values.len());
        assert_same_curve(&curve, &coarse, curve.domain(), 1e-8);
    }

    #[test]
    fn elevation_keeps_the_curve_and_reduction_undoes_it(curve in curve_strategy(), by in 1..4_usize) {
        let higher = curve.elevated(by).unwrap();
        prop_assert_eq!(higher.degree(), curve.degree() + by);
        assert_same_curve(&curve, &higher, curve.domain(), 1e-13);
        let (lower, error) = higher.reduced(by, 1e-7).unwrap();
        prop_assert!(error < 1e-8, "{error:e}");
        prop_assert_eq!(lower.degree(), curve.degree());
        assert_same_curve(&curve, &lower, curve.domain(), 1e-9);
    }

    #[test]
    fn reduction_keeps_its_bound(curve in curve_strategy()) {
        prop_assume!(curve.degree() > 1);
        if let Ok((lower, error)) = curve.reduced(1, f64::INFINITY) {
            for t in samples(curve.domain()) {
                let gap = (curve.point(t) - lower.point(t)).norm();
                prop_assert!(gap <= error * (1.0 + 1e-9) + 1e-11, "{gap} {error}");
            }
            let refused = matches!(curve.reduced(1, 0.5 * error), Err(Error::Argument { .. }));
            prop_assert!(error == 0.0 || refused);
        } else {
            // Only the weights of a rational curve can make it impossible.
            prop_assert!(curve.weights().is_some());
        }
    }

    #[test]
    fn parts_are_parts(curve in curve_strategy(), a in 0.0..0.45, b in 0.55..1.0) {
        let domain = curve.domain();
        let part = curve.trimmed(Interval::new(domain.lerp(a), domain.lerp(b)).unwrap()).unwrap();
        prop_assert!(part.knots().is_clamped());
        assert_same_curve(&curve, &part, part.domain(), 1e-13);
        let (left, right) = curve.split(domain.lerp(b)).unwrap_or_else(|_| curve.split(domain.lerp(0.5)).unwrap());
        assert_same_curve(&curve, &left, left.domain(), 1e-13);
        // The start of the right part belongs to it, its end is the seam of a periodic curve.
        assert_same_curve(&curve, &right, right.domain(), 1e-13);
        let whole = left.join(&right, 1e-10).unwrap();
        assert_same_curve(&curve, &whole, domain, 1e-12);
        assert_same_curve(&curve, &curve.clamped().unwrap(), domain, 1e-13);
    }

    #[test]
    fn periodic_parts_cross_the_seam(
        steps in prop::collection::vec(0..20_u8, 6..12), p in 1..5_usize, seed: u64, s in -3.0..3.0, l in 0.01..1.0
    ) {
        let curve = curve_on(knot_vector(p, 2, &steps), seed % 2 == 0, seed);
        let period = curve.period().unwrap();
        let part = curve.trimmed(Interval::new(s * period, (s + l) * period).unwrap()).unwrap();
        assert_same_curve(&curve, &part, part.domain(), 1e-11);
        let open = curve.opened_at(s * period).unwrap();
        assert_same_curve(&curve, &open, open.domain(), 1e-11);
        prop_assert!(open.is_closed(1e-9).unwrap());
        prop_assert!(curve.is_closed(1e-9).unwrap());
        for k in curve.knots().distinct_knots() {
            let open = curve.opened_at(k.0 - 2.0 * period).unwrap();
            assert_same_curve(&curve, &open, open.domain(), 1e-11);
        }
    }

    #[test]
    fn reversal_and_new_parameters(curve in curve_strategy(), a in -50.0..50.0, l in 0.1..50.0) {
        let domain = curve.domain();
        let back = curve.reversed().unwrap();
        let to = Interval::new(a, a + l).unwrap();
        let moved = curve.reparameterized(to).unwrap();
        for i in 1..40 {
            let s = f64::from(i) / 40.0;
            let point = curve.point(domain.lerp(s));
            prop_assert!((point - back.point(domain.lerp(1.0 - s))).norm() < 1e-10);
            prop_assert!((point - moved.point(to.lerp(s))).norm() < 1e-9);
        }
    }

    #[test]
    fn derivative_curve_is_the_derivative(knots in knots_strategy(), seed: u64) {
        let curve = curve_on(knots, false, seed);
        if let Ok(derivative) = curve.derivative_curve() {
            for t in samples(curve.domain()) {
                let gap = (derivative.point(t) - curve.jet(t).d1).norm();
                prop_assert!(gap < 1e-10 * (1.0 + curve.jet(t).d1.norm()), "{t}: {gap:e}");
            }
        } else {
            let corner = curve.knots().distinct_knots().iter().any(|m| m.1 >= curve.degree());
            prop_assert!(corner || curve.degree() == 1);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, rng_seed: prop::test_runner::RngSeed::Fixed(6), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn surfaces_stay_the_same(surface in surface_strategy(), coin: bool, s in 0.05..0.95) {
        let d = direction(coin);
        let domain = surface.domain();
        let t = domain[d.index()].lerp(s);
        assert_same_surface(&surface, &surface.refine(d, &[t]).unwrap(), domain, 1e-13);
        assert_same_surface(&surface, &surface.elevated(d, 2).unwrap(), domain, 1e-13);
        assert_same_surface(&surface, &surface.clamped(d).unwrap(), domain, 1e-13);
        let (a, b) = surface.split(d, t).unwrap();
        assert_same_surface(&surface, &a, a.domain(), 1e-13);
        assert_same_surface(&surface, &b, b.domain(), 1e-13);
        let (lower, error) = surface.elevated(d, 1).unwrap().reduced(d, 1, 1e-7).unwrap();
        prop_assert!(error < 1e-8);
        assert_same_surface(&surface, &lower, domain, 1e-9);
        let (coarse, report) = surface.refine(d, &[t]).unwrap().remove_all_within(d, 1e-8).unwrap();
        prop_assert!(report.removed >= 1);
        assert_same_surface(&surface, &coarse, domain, 1e-8);
        let (coarse, report) = surface.remove_all_within(d, 2.0).unwrap();
        for u in samples(domain[0]).step_by(3) {
            for v in samples(domain[1]).step_by(3) {
                let gap = (surface.point(u, v) - coarse.point(u, v)).norm();
                prop_assert!(gap <= report.error * (1.0 + 1e-9) + 1e-10, "{gap} {}", report.error);
            }
        }
    }

    #[test]
    fn iso_curves_transposition_and_motion(surface in surface_strategy(), s in 0.0..1.0, r in 0.0..1.0) {
        let [du, dv] = surface.domain();
        let (u, v) = (du.lerp(s), dv.lerp(r));
        let point = surface.point(u, v);
        prop_assert!((surface.iso_curve_u(u).unwrap().point(v) - point).norm() < 1e-11);
        prop_assert!((surface.iso_curve_v(v).unwrap().point(u) - point).norm() < 1e-11);
        prop_assert!((surface.transposed().unwrap().point(v, u) - point).norm() < 1e-11);
        let motion = Isometry3::new(Vector3::new(1.0, -2.0, 3.0), Vector3::new(0.3, 0.9, -1.0));
        let moved = surface.moved(&motion).unwrap();
        let expected = motion.rotation * point + motion.translation.vector;
        prop_assert!((moved.point(u, v) - expected).norm() < 1e-11);
        let linear = motion.rotation.to_rotation_matrix();
        let same = surface.transformed(linear.matrix(), &motion.translation.vector).unwrap();
        prop_assert!((same.point(u, v) - expected).norm() < 1e-11);
        let centre = Vector3::new(1.0, 1.0, 0.0);
        let small = surface.scaled(0.5, &centre).unwrap().translated(&-centre).unwrap();
        prop_assert!((small.point(u, v) - (point - centre) * 0.5).norm() < 1e-11);
    }
}

fn quarter_circle() -> BsplineCurve<2> {
    let points = vec![Vector2::new(1.0, 0.0), Vector2::new(1.0, 1.0), Vector2::new(0.0, 1.0)];
    BsplineCurve::bezier(points, Some(vec![1.0, 0.5_f64.sqrt(), 1.0])).unwrap()
}

#[test]
fn joined_arcs_stay_on_their_circles() {
    let arc = quarter_circle();
    let line = BsplineCurve::bezier(vec![Vector2::new(0.0, 1.0), Vector2::new(-2.0, 1.0)], None).unwrap();
    let both = arc.join(&line, 1e-12).unwrap();
    assert_eq!((both.degree(), both.domain()), (2, Interval::new(0.0, 2.0).unwrap()));
    for i in 0..=10 {
        let t = f64::from(i) / 10.0;
        assert!((both.point(t).norm() - 1.0).abs() < 1e-15);
        assert!((both.point(1.0 + t) - line.point(t)).norm() < 1e-15);
    }
    assert!(matches!(line.join(&arc, 1e-3), Err(Error::Incompatible { .. })));
    assert!(matches!(arc.join(&line, f64::NAN), Err(Error::Argument { .. })));
}

#[test]
fn elevated_circle_is_a_circle() {
    let quintic = quarter_circle().elevated(3).unwrap();
    for i in 0..=20 {
        assert!((quintic.point(f64::from(i) / 20.0).norm() - 1.0).abs() < 1e-15);
    }
    assert!(matches!(quarter_circle().elevated(30), Err(Error::Degree { degree: 32 })));
    assert!(matches!(quarter_circle().reduced(2, 1.0), Err(Error::Argument { .. })));
}

#[test]
fn large_offsets_lose_nothing() {
    let far = Vector2::new(3.0e6, -5.0e6);
    let arc = quarter_circle().translated(&far).unwrap();
    let finer = arc.refine(&[0.3, 0.6]).unwrap();
    let (coarse, report) = finer.remove_all_within(1e-7).unwrap();
    assert_eq!((report.removed, coarse.control_points().len()), (2, 3));
    for i in 0..=20 {
        let t = f64::from(i) / 20.0;
        assert!(((finer.point(t) - far).norm() - 1.0).abs() < 1e-8);
        assert!(((coarse.point(t) - far).norm() - 1.0).abs() < 1e-8);
    }
}

#[test]
fn refuses_with_a_reason() {
    let arc = quarter_circle();
    assert!(matches!(arc.insert_knot(1.5, 1), Err(Error::Parameter { .. })));
    assert!(matches!(arc.insert_knot(f64::NAN, 1), Err(Error::Parameter { .. })));
    assert!(matches!(arc.insert_knot(0.0, 1), Err(Error::KnotMultiplicity { max: 3, .. })));
    assert!(matches!(arc.split(0.0), Err(Error::Argument { .. })));
    assert!(matches!(arc.split(f64::NAN), Err(Error::Parameter { .. })));
    assert!(matches!(arc.trimmed(Interval::new(0.5, 2.0).unwrap()), Err(Error::Parameter { .. })));
    assert!(matches!(arc.remove_knot(0.5, 1, 1.0), Err(Error::Argument { .. })));
    assert!(matches!(arc.remove_all_within(-1.0), Err(Error::Argument { .. })));
    assert!(matches!(arc.derivative_curve(), Err(Error::Argument { .. })));
    assert!(matches!(arc.opened_at(0.5), Err(Error::Argument { .. })));
    assert!(matches!(arc.insert_knot(0.5, usize::MAX), Err(Error::KnotMultiplicity { .. })));
    assert!(matches!(arc.elevated(usize::MAX), Err(Error::Degree { .. })));
    assert!(matches!(arc.reduced(usize::MAX, 1.0), Err(Error::Argument { .. })));
    let ring = curve_on(KnotVector::uniform_periodic(3, 6).unwrap(), true, 3);
    assert!(matches!(ring.remove_knot(f64::NAN, 1, 1.0), Err(Error::Argument { .. })));
    assert!(matches!(ring.remove_knot(0.0, 1, 1.0), Err(Error::Argument { .. })));
    assert!(matches!(ring.join(&ring, 1.0), Err(Error::Incompatible { .. })));
    assert!(matches!(ring.opened_at(f64::NAN), Err(Error::EmptyInterval { .. })));
    assert!(matches!(ring.trimmed(Interval::new(0.0, 1.5).unwrap()), Err(Error::Argument { .. })));
    assert!(!arc.is_closed(1e-9).unwrap());
    assert_eq!(arc.remove_all_within(1.0).unwrap().1.removed, 0);
}
