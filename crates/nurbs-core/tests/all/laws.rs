//! Laws that hold for every curve and surface, tried on random ones: clamped and periodic, polynomial and
//! rational, with repeated knots.

#![allow(clippy::unwrap_used, reason = "a failed construction is a failed test")]

use crate::random;
use crate::random::{curve, frame, knots, regular_surface, surface};
use nalgebra::{Isometry3, SVector, Vector2, Vector3};
use nurbs_core::{
    ArcLength, BsplineCurve, BsplineSurface, Circle, Cone, Cylinder, Frame, Interval, KnotVector, MAX_DEGREE,
    ParametricCurve, ParametricSurface, Sphere, Torus, arc_length, area, basis,
};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

fn close<const D: usize>(
    a: SVector<f64, D>,
    b: SVector<f64, D>,
    tolerance: f64,
) -> Result<(), TestCaseError> {
    prop_assert!((a - b).norm() <= tolerance, "{a} and {b} differ by {}", (a - b).norm());
    Ok(())
}

/// Point at the fraction `s` of a random span, kept off its ends.
fn inside(knots: &KnotVector, s: f64) -> (f64, f64) {
    let spans: Vec<usize> = knots.spans().collect();
    let place = s * spans.len() as f64;
    let k = (0..spans.len()).rev().find(|&k| k as f64 <= place).unwrap_or(0);
    let interval = knots.span_interval(spans[k]);
    (interval.lerp(0.2 + 0.6 * (place - k as f64)), 0.01 * interval.length())
}

/// First and second derivative by central differences of the sixth order with step `h`.
fn differences<const D: usize>(f: impl Fn(f64) -> SVector<f64, D>, h: f64) -> [SVector<f64, D>; 2] {
    let odd = |k: f64| f(k * h) - f(-k * h);
    let even = |k: f64| f(k * h) + f(-k * h) - f(0.0) * 2.0;
    [
        (odd(1.0) * 45.0 - odd(2.0) * 9.0 + odd(3.0)) / (60.0 * h),
        (even(1.0) * 270.0 - even(2.0) * 27.0 + even(3.0) * 2.0) / (180.0 * h * h),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, rng_seed: prop::test_runner::RngSeed::Fixed(3), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn partition_of_unity(knots in knots(), s in 0.0_f64..=1.0) {
        let t = knots.domain().lerp(s);
        let mut rows = vec![[0.0; MAX_DEGREE + 1]; 4];
        basis::derivatives(&knots, knots.span(t), t, 3, &mut rows);
        let p = knots.degree();
        for (order, row) in rows.iter().enumerate() {
            let sum: f64 = row[..=p].iter().sum();
            let size: f64 = row[..=p].iter().map(|x| x.abs()).sum();
            let expected = if order == 0 { 1.0 } else { 0.0 };
            prop_assert!((sum - expected).abs() <= 1e-13 * size.max(1.0), "order {order}: {sum}");
            if order == 0 {
                prop_assert!(row[..=p].iter().all(|x| *x >= 0.0));
            }
        }
    }

    #[test]
    fn curve_jets_are_derivatives(curve in curve(), s in 0.0_f64..1.0) {
        let (t, h) = inside(curve.knots(), s);
        let jet = curve.jet(t);
        let [d1, d2] = differences(|x| curve.point(t + x), h);
        // The step is a hundredth of a span: the truncation error of the sixth order is below 1e-7.
        let sizes = curve.derivatives(t, 3);
        let scale = sizes.iter().rev().fold(0.0, |sum, d| sum * h + d.norm());
        close(d1 * h, jet.d1 * h, 1e-7 * (scale + 1.0))?;
        close(d2 * h * h, jet.d2 * h * h, 1e-7 * (scale + 1.0))?;
        close(jet.point, curve.point(t), 1e-13 * 10.0)?;
        let general = curve.derivatives(t, 2);
        close(general[1], jet.d1, 1e-11 * (1.0 + jet.d1.norm()))?;
        close(general[2], jet.d2, 1e-10 * (1.0 + jet.d2.norm() + jet.d1.norm()))?;
    }

    #[test]
    fn bezier_pieces_are_the_curve(curve in curve(), s in 0.0_f64..=1.0) {
        for piece in curve.bezier_curves() {
            let bezier = BsplineCurve::bezier(piece.control_points.clone(), piece.weights.clone()).unwrap();
            close(bezier.point(s), curve.point(piece.interval.lerp(s).min(piece.interval.end())), 1e-11)?;
        }
    }

    #[test]
    fn bezier_patches_are_the_surface(surface in surface(), s in 0.0..0.999, t in 0.0..0.999) {
        for patch in surface.bezier_patches() {
            let knots = |k: usize| KnotVector::bezier(patch.degrees[k], Interval::UNIT).unwrap();
            let bezier = BsplineSurface::new(
                knots(0), knots(1), patch.control_points.clone(), patch.weights.clone(),
            ).unwrap();
            let [u, v] = patch.intervals;
            close(bezier.point(s, t), surface.point(u.lerp(s), v.lerp(t)), 1e-11)?;
        }
    }

    #[test]
    fn surface_jets_are_derivatives(surface in surface(), s in 0.0_f64..1.0, r in 0.0_f64..1.0) {
        let ((u, h), (v, k)) = (inside(surface.knots_u(), s), inside(surface.knots_v(), r));
        let jet = surface.jet(u, v);
        let scale = 1e-7 * (1.0 + jet.point.norm() + (jet.du * h).norm() + (jet.dv * k).norm());
        let [du, duu] = differences(|x| surface.point(u + x, v), h);
        let [dv, dvv] = differences(|x| surface.point(u, v + x), k);
        let [duv, _] = differences(|x| surface.jet(u, v + x).du, k);
        close(du * h, jet.du * h, scale)?;
        close(dv * k, jet.dv * k, scale)?;
        close(duu * h * h, jet.duu * h * h, scale)?;
        close(dvv * k * k, jet.dvv * k * k, scale)?;
        close(duv * h * k, jet.duv * h * k, scale)?;
    }

    #[test]
    fn boxes_are_tight(curve in curve(), surface in surface()) {
        let (hull, tight) = (curve.control_box(), curve.bounding_box(1e-9));
        let samples = (0..=400).map(|i| curve.point(curve.domain().lerp(f64::from(i) / 400.0)));
        let sampled: Vec<_> = samples.collect();
        prop_assert!(sampled.iter().all(|p| tight.contains(p) && hull.inflated(1e-12).contains(p)));
        // Every side is touched: a point that near is found by a fine search around the best sample.
        for k in 0..3 {
            for sign in [1.0, -1.0] {
                let value = |t: f64| sign * curve.point(t)[k];
                let best = random::maximize(&value, curve.domain(), &curve.breaks());
                let side = sign * if sign > 0.0 { tight.max[k] } else { tight.min[k] };
                prop_assert!(side - best <= 3e-9 * hull.diagonal() + 1e-12, "{} {}", side, best);
            }
        }
        let tight = surface.bounding_box(1e-6);
        // Each span by itself: a surface of degree 1 has its peaks at knots.
        let samples = |knots: &KnotVector| -> Vec<f64> {
            let spans = knots.spans().map(|span| knots.span_interval(span));
            spans.flat_map(|i| (0..=12).map(move |k| i.lerp(f64::from(k) / 12.0))).collect()
        };
        let (us, vs) = (samples(surface.knots_u()), samples(surface.knots_v()));
        let mut best = [[f64::NEG_INFINITY; 2]; 3];
        for u in &us {
            for v in &vs {
                let p = surface.point(*u, *v);
                prop_assert!(tight.contains(&p));
                for k in 0..3 {
                    best[k] = [best[k][0].max(p[k]), best[k][1].max(-p[k])];
                }
            }
        }
        for k in 0..3 {
            let loose = 0.05 * surface.control_box().diagonal();
            prop_assert!(tight.max[k] - best[k][0] < loose && -best[k][1] - tight.min[k] < loose);
        }
    }

    #[test]
    fn curvatures_do_not_depend_on_position_or_parameter(
        surface in regular_surface(), frame in frame(), s in 0.05..0.95, r in 0.05..0.95,
    ) {
        let matrix = nalgebra::Matrix3::from_columns(&[frame.x(), frame.y(), frame.z()]);
        let rotation = nalgebra::UnitQuaternion::from_matrix(&matrix);
        let moved = surface.moved(&Isometry3::from_parts(frame.origin().into(), rotation)).unwrap();
        let domain = [Interval::new(-3.0, 5.0).unwrap(), Interval::new(10.0, 10.5).unwrap()];
        let moved = moved.reparameterized(domain).unwrap();
        let at = |surface: &BsplineSurface| {
            let [u, v] = surface.domain();
            surface.jet(u.lerp(s), v.lerp(r)).principal_frame().unwrap()
        };
        let (a, b) = (at(&surface), at(&moved));
        close(rotation * a.normal, b.normal, 1e-9)?;
        let size = a.curvatures[0].abs() + a.curvatures[1].abs();
        for k in 0..2 {
            prop_assert!((a.curvatures[k] - b.curvatures[k]).abs() < 1e-9 * (1.0 + size));
        }
        if a.curvatures[0] - a.curvatures[1] > 1e-3 * (1.0 + size) {
            prop_assert!((rotation * a.directions[0]).cross(&b.directions[0]).norm() < 1e-6);
        }
        let jet = surface.jet(surface.domain()[0].lerp(s), surface.domain()[1].lerp(r));
        let product = a.curvatures[0] * a.curvatures[1];
        prop_assert!((jet.gauss_curvature().unwrap() - product).abs() < 1e-10 * (1.0 + size * size));
        let (first, second) = (jet.first_form(), jet.second_form().unwrap());
        prop_assert!((second.determinant() / first.determinant() - product).abs() < 1e-9 * (1.0 + size * size));
        for k in 0..2 {
            let normal_curvature = jet.normal_curvature(&a.parameter_directions[k]).unwrap();
            prop_assert!((normal_curvature - a.curvatures[k]).abs() < 1e-9 * (1.0 + size));
        }
    }

    #[test]
    fn lengths_are_additive_and_invertible(curve in curve(), s in 0.0_f64..=1.0) {
        let table = ArcLength::new(&curve, 1e-10);
        let total = table.total().value;
        let t = table.parameter_at(s * total).unwrap();
        prop_assert!((table.at(t) - s * total).abs() < 1e-9 * total);
        // Chords from below: many in each span, none across a knot.
        let mut ends = vec![curve.domain().start()];
        ends.extend(curve.breaks());
        ends.push(curve.domain().end());
        let polygon: f64 = ends
            .windows(2)
            .map(|w| {
                let points: Vec<_> = (0..=2000).map(|i| w[0] + (w[1] - w[0]) * f64::from(i) / 2000.0).collect();
                points.windows(2).map(|t| (curve.point(t[1]) - curve.point(t[0])).norm()).sum::<f64>()
            })
            .sum();
        prop_assert!(polygon <= total * (1.0 + 1e-9) && polygon > total * (1.0 - 1e-3), "{polygon} {total}");
    }

    #[test]
    fn closed_forms(f in frame(), r in 0.1..3.0, h in 0.1..3.0, extra in 0.1..2.0, turn in 0.1..TAU) {
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * b.abs();
        let arc = Circle::in_frame(&f, r).unwrap().with_arc(Interval::new(-1.0, turn - 1.0).unwrap()).unwrap();
        prop_assert!(near(arc_length(&arc, 1e-10).value, r * turn));
        prop_assert!(near(arc_length(&arc.to_nurbs().unwrap(), 1e-10).value, r * turn));
        let sphere = Sphere::new(f, r).unwrap();
        let torus = Torus::new(f, r + extra, r).unwrap();
        let cylinder = Cylinder::new(f, r, Interval::new(-1.0, h - 1.0).unwrap()).unwrap();
        let cone = Cone::new(f, r, 0.0, h).unwrap();
        let areas = [
            (area(&sphere, 1e-10), area(&sphere.to_nurbs().unwrap(), 1e-10), 4.0 * PI * r * r),
            (area(&torus, 1e-10), area(&torus.to_nurbs().unwrap(), 1e-10), 4.0 * PI * PI * r * (r + extra)),
            (area(&cylinder, 1e-10), area(&cylinder.to_nurbs().unwrap(), 1e-10), TAU * r * h),
            (area(&cone, 1e-10), area(&cone.to_nurbs().unwrap(), 1e-10), PI * r * r.hypot(h)),
        ];
        for (analytic, nurbs, exact) in areas {
            prop_assert!(near(analytic.value, exact) && near(nurbs.value, exact), "{analytic:?} {nurbs:?} {exact}");
        }
    }
}

#[test]
fn frenet_frame_of_a_rational_circle() {
    let circle = Circle::new(Vector2::new(5.0, 1.0), 2.5).unwrap().to_nurbs().unwrap();
    for i in 0..30 {
        let jet = circle.jet(0.2 * f64::from(i));
        let frame = jet.frenet_frame().unwrap();
        assert!((frame.curvature - 0.4).abs() < 1e-13);
        assert!((jet.centre_of_curvature().unwrap() - Vector2::new(5.0, 1.0)).norm() < 1e-12);
        assert!((jet.signed_curvature().unwrap() - 0.4).abs() < 1e-13);
    }
}

#[test]
fn frame_of_world() {
    assert_eq!(Frame::WORLD.local(&Vector3::new(1.0, 2.0, 3.0)), Vector3::new(1.0, 2.0, 3.0));
}
