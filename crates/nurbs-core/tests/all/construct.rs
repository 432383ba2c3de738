//! Constructed surfaces contain the curves they are made from, exactly where they promise it.

#![allow(clippy::unwrap_used, reason = "a failed construction is a failed test")]

use nalgebra::{Rotation3, Unit, Vector3};
use nurbs_core::construct::{self, SweepOptions, rotation_minimizing_frames};
use nurbs_core::{
    BsplineCurve, Circle, Error, Frame, Helix, Interval, KnotVector, Line, ParametricCurve,
    ParametricSurface, ThirdOrderCurve, Torus, arc_length,
};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn v(x: f64, y: f64, z: f64) -> Vector3<f64> {
    Vector3::new(x, y, z)
}

fn polynomial(points: &[Vector3<f64>], degree: usize) -> BsplineCurve<3> {
    let knots = KnotVector::uniform_clamped(degree, points.len()).unwrap();
    BsplineCurve::new(knots, points.to_vec(), None).unwrap()
}

/// Largest distance between a curve and an edge of a surface, both run through by fractions.
fn gap(curve: &BsplineCurve<3>, edge: impl Fn(f64) -> Vector3<f64>) -> f64 {
    let fractions = (0..=100).map(|i| f64::from(i) / 100.0);
    fractions.map(|s| (curve.point(curve.domain().lerp(s)) - edge(s)).norm()).fold(0.0, f64::max)
}

/// Four boundary curves of different degrees and knots that meet at the corners.
fn boundary() -> [BsplineCurve<3>; 4] {
    [
        polynomial(&[v(0., 0., 0.), v(1., 0., 1.), v(2., 0.5, 0.), v(3., 0., 0.)], 2),
        polynomial(&[v(0., 2., 1.), v(1., 2., 2.), v(1.5, 3., 0.), v(2., 2., 1.), v(3., 2., 1.)], 3),
        polynomial(&[v(0., 0., 0.), v(-1., 1., 0.), v(0., 2., 1.)], 1),
        polynomial(&[v(3., 0., 0.), v(4., 1., 0.), v(3., 1., 2.), v(3., 1.5, 2.), v(3., 2., 1.)], 4),
    ]
}

#[test]
fn coons_contains_its_boundary() {
    let [c0, c1, d0, d1] = boundary();
    let s = construct::coons([&c0, &c1], [&d0, &d1], 1e-9).unwrap();
    let [u, w] = s.domain();
    assert!(gap(&c0, |t| s.point(u.lerp(t), w.start())) < 1e-14 * 10.0);
    assert!(gap(&c1, |t| s.point(u.lerp(t), w.end())) < 1e-14 * 10.0);
    assert!(gap(&d0, |t| s.point(u.start(), w.lerp(t))) < 1e-14 * 10.0);
    assert!(gap(&d1, |t| s.point(u.end(), w.lerp(t))) < 1e-14 * 10.0);
    // Inside: the boolean sum of the two ruled surfaces and the bilinear patch.
    let at = |c: &BsplineCurve<3>, t: f64| c.point(c.domain().lerp(t));
    for (a, b) in [(0.3, 0.6), (0.5, 0.1), (0.9, 0.45)] {
        let ruled_v = at(&c0, a) * (1.0 - b) + at(&c1, a) * b;
        let ruled_u = at(&d0, b) * (1.0 - a) + at(&d1, b) * a;
        let low = at(&c0, 0.0) * (1.0 - a) + at(&c0, 1.0) * a;
        let high = at(&c1, 0.0) * (1.0 - a) + at(&c1, 1.0) * a;
        let expected = ruled_v + ruled_u - low * (1.0 - b) - high * b;
        assert!((s.point(u.lerp(a), w.lerp(b)) - expected).norm() < 1e-13);
    }
}

#[test]
fn coons_names_the_corner_that_is_open() {
    let [c0, c1, d0, d1] = boundary();
    let moved = polynomial(&[v(3., 0., 0.), v(4., 1., 0.), v(3., 2., 1.25)], 2);
    let error = construct::coons([&c0, &c1], [&d0, &moved], 1e-6).unwrap_err();
    assert!(matches!(error, Error::Incompatible { .. }));
    let text = error.to_string();
    assert!(text.contains("u = 1, v = 1") && text.contains("0.25"), "{text}");
    assert!(construct::coons([&c0, &c1], [&d0, &moved], 0.3).is_ok());
    assert!(construct::coons([&c0, &c1], [&d0, &d1], f64::NAN).is_err());
}

#[test]
fn coons_of_rational_arcs() {
    // The four sides of a square patch with two opposite circular edges.
    let arc = |y: f64| {
        let f = Frame::new(v(0., y, 0.), -Vector3::y(), Vector3::x()).unwrap();
        let angles = Interval::new(0.25 * PI, 0.75 * PI).unwrap();
        Circle::in_frame(&f, 2.0).unwrap().with_arc(angles).unwrap().to_nurbs().unwrap()
    };
    let (c0, c1) = (arc(0.0), arc(3.0));
    let ends = |c: &BsplineCurve<3>| [c.control_points()[0], c.control_points()[2]];
    let line = |k: usize| Line::new(ends(&c0)[k], ends(&c1)[k]).unwrap().to_nurbs().unwrap();
    let s = construct::coons([&c0, &c1], [&line(0), &line(1)], 1e-9).unwrap();
    let [u, w] = s.domain();
    for i in 0..=20 {
        for j in 0..=20 {
            let p = s.point(u.lerp(f64::from(i) / 20.0), w.lerp(f64::from(j) / 20.0));
            assert!((p.x.hypot(p.z) - 2.0).abs() < 1e-14 * 10.0, "{p}");
        }
    }
}

#[test]
fn ruled_extruded_and_translated() {
    let [c0, c1, _, d1] = boundary();
    let s = construct::ruled(&c0, &c1).unwrap();
    for (a, b) in [(0.2, 0.3), (0.7, 0.9)] {
        let at = |c: &BsplineCurve<3>| c.point(c.domain().lerp(a));
        assert!((s.point(s.domain()[0].lerp(a), b) - at(&c0) * (1.0 - b) - at(&c1) * b).norm() < 1e-13);
    }
    let circle = Circle::in_frame(&Frame::WORLD, 2.0).unwrap().to_nurbs().unwrap();
    let tube = construct::extrude(&circle, &v(0., 0., 3.)).unwrap();
    assert!((tube.point(1.0, 2.0) - circle.point(1.0) - v(0., 0., 2.)).norm() < 1e-14 * 4.0);
    let moved = construct::translate_along(&circle, &d1).unwrap();
    for (a, b) in [(0.5, 0.3), (4.0, 0.8)] {
        let expected = circle.point(a) + d1.point(b) - d1.point(0.0);
        assert!((moved.point(a, b) - expected).norm() < 1e-13);
    }
    let mixed = construct::ruled(&circle, &c0).unwrap();
    assert!(gap(&circle, |t| mixed.point(mixed.domain()[0].lerp(t), 0.0)) < 1e-13);
    assert!(gap(&c0, |t| mixed.point(mixed.domain()[0].lerp(t), 1.0)) < 1e-13);
    assert!(construct::extrude(&circle, &Vector3::zeros()).is_err());
}

#[test]
fn periodic_curves_stay_periodic() {
    let knots = KnotVector::uniform_periodic(3, 6).unwrap();
    let ring = |r: f64, z: f64| {
        let points = (0..9).map(|i| v(r * f64::from(i).cos(), r * f64::from(i).sin(), z));
        let mut points: Vec<_> = points.collect();
        for i in 0..3 {
            points[6 + i] = points[i];
        }
        BsplineCurve::new(knots.clone(), points, None).unwrap()
    };
    let s = construct::ruled(&ring(1.0, 0.0), &ring(2.0, 1.0)).unwrap();
    assert!(s.period()[0].is_some());
    let open = construct::ruled(&ring(1.0, 0.0), &boundary()[0]).unwrap();
    assert!(open.period()[0].is_none());
    assert!(gap(&ring(1.0, 0.0), |t| open.point(open.domain()[0].lerp(t), 0.0)) < 1e-12);
}

#[test]
fn revolution() {
    let profile = polynomial(&[v(1., 0., 0.), v(2., 0., 1.), v(0.5, 0., 2.), v(0., 0., 3.)], 3);
    for angle in [0.3, FRAC_PI_2, 4.0, TAU] {
        let s = construct::revolve(&profile, &Vector3::zeros(), &v(0., 0., 2.), angle).unwrap();
        assert!(gap(&profile, |t| s.point(0.0, t)) < 1e-14);
        for (a, b) in [(0.35, 0.2), (0.8, 0.7), (1.0, 0.4)] {
            let (p, q) = (s.point(a * angle, b), profile.point(b));
            assert!((p.z - q.z).abs() < 1e-14 * 10.0 && (p.xy().norm() - q.x).abs() < 1e-14 * 10.0);
        }
        let turn = Rotation3::from_axis_angle(&Unit::new_normalize(Vector3::z()), angle);
        assert!((s.point(angle, 0.3) - turn * profile.point(0.3)).norm() < 1e-13);
    }
    let bad = |angle: f64| construct::revolve(&profile, &Vector3::zeros(), &Vector3::z(), angle);
    assert!(bad(0.0).is_err() && bad(7.0).is_err() && bad(f64::NAN).is_err());
    assert!(construct::revolve(&profile, &Vector3::zeros(), &Vector3::zeros(), 1.0).is_err());
}

#[test]
fn skin_passes_through_its_sections() {
    let sections = [
        polynomial(&[v(0., 0., 0.), v(1., 0., 1.), v(3., 0., 0.)], 2),
        polynomial(&[v(0., 1., 0.), v(1., 1., 2.), v(2., 1., 0.), v(3., 1., 0.)], 3),
        polynomial(&[v(0., 3., 1.), v(3., 3., 1.)], 1),
        polynomial(&[v(0., 4., 0.), v(1., 4., 1.), v(2., 4., -1.), v(2., 4., 0.), v(3., 4., 0.)], 2),
    ];
    let parameters = [0.0, 0.2, 0.7, 1.0];
    let s = construct::skin_at(&sections, &parameters, 3).unwrap();
    for (section, b) in sections.iter().zip(parameters) {
        assert!(gap(section, |t| s.point(s.domain()[0].lerp(t), b)) < 1e-13);
    }
    let s = construct::skin(&sections, 2).unwrap();
    assert!(gap(&sections[0], |t| s.point(s.domain()[0].lerp(t), 0.0)) < 1e-13);
    assert!(gap(&sections[3], |t| s.point(s.domain()[0].lerp(t), 1.0)) < 1e-13);
    assert!(construct::skin(&sections, 4).is_err());
    let twice = [sections[0].clone(), sections[0].clone(), sections[1].clone()];
    assert!(construct::skin(&twice, 2).unwrap_err().to_string().contains("sections 0 and 1 coincide"));
    assert!(construct::skin(&[], 1).is_err());
    // Rational: circles of different size.
    let circle = |r: f64, z: f64| {
        let f = Frame::from_axis(v(0., 0., z), Vector3::z()).unwrap();
        Circle::in_frame(&f, r).unwrap().to_nurbs().unwrap()
    };
    let horn = construct::skin(&[circle(1.0, 0.0), circle(2.0, 1.0), circle(1.5, 3.0)], 2).unwrap();
    for i in 0..=30 {
        let p = horn.point(TAU * f64::from(i) / 30.0, 1.0);
        assert!((p.xy().norm() - 1.5).abs() < 1e-13 && (p.z - 3.0).abs() < 1e-13);
    }
}

#[test]
fn sweeping_a_circle_around_a_circle_gives_a_torus() {
    let torus = Torus::new(Frame::WORLD, 5.0, 1.0).unwrap();
    let path = Circle::in_frame(&Frame::WORLD, 5.0).unwrap();
    let place = Frame::new(v(5., 0., 0.), Vector3::y(), Vector3::x()).unwrap();
    let section = Circle::in_frame(&place, 1.0).unwrap().to_nurbs().unwrap();
    let sweep = construct::sweep(&section, &path, &SweepOptions::default()).unwrap();
    assert!(sweep.within_tolerance, "{} {}", sweep.deviation, sweep.sections);
    let [u, w] = sweep.surface.domain();
    for i in 0..=40 {
        for j in 0..=40 {
            let p = sweep.surface.point(u.lerp(f64::from(i) / 40.0), w.lerp(f64::from(j) / 40.0));
            assert!(torus.footpoint(&p).distance < 1e-6 * 40.0);
        }
    }
    let coarse = SweepOptions::default().with_max_sections(10).with_relative_tolerance(1e-12);
    let sweep = construct::sweep(&section, &path, &coarse).unwrap();
    assert!(!sweep.within_tolerance && sweep.sections <= 10 && sweep.deviation > 0.0);
    let corner = polynomial(&[v(5., 0., 0.), v(5., 1., 0.), v(4., 1., 0.)], 1);
    assert!(construct::sweep(&section, &corner, &coarse).unwrap_err().to_string().contains("corner"));
}

#[test]
fn helix_is_exact() {
    let f = Frame::from_axis(v(1., 2., 3.), v(1., 1., 0.)).unwrap();
    let helix = Helix::new(f, 2.0, -1.5, 2.25).unwrap();
    assert!((arc_length(&helix, 1e-12).value / helix.length() - 1.0).abs() < 1e-12);
    let jet = helix.jet(3.3);
    assert!((jet.curvature().unwrap() - helix.curvature()).abs() < 1e-14);
    assert!((jet.torsion(&helix.third_derivative(3.3)).unwrap() - helix.torsion()).abs() < 1e-14);
    assert!(helix.torsion() < 0.0);
    assert!(Helix::new(f, 0.0, 1.0, 1.0).is_err() && Helix::new(f, 1.0, f64::NAN, 1.0).is_err());
}

#[test]
fn frames_of_a_plane_path_do_not_turn_about_it() {
    let path = polynomial(&[v(0., 0., 0.), v(2., 3., 0.), v(3., -4., 0.), v(6., 0., 0.)], 3);
    let parameters: Vec<f64> = (0..=50).map(|i| f64::from(i) / 50.0).collect();
    let frames = rotation_minimizing_frames(&path, &parameters, Some(&v(1., 1., 5.))).unwrap();
    for frame in &frames {
        // The angle to the plane's normal stays what it was.
        assert!((frame.normal.z - frames[0].normal.z).abs() < 1e-13);
        assert!((frame.tangent.cross(&frame.normal) - frame.binormal).norm() < 1e-15);
    }
    assert!(rotation_minimizing_frames(&path, &[], None).is_err());
    assert!(rotation_minimizing_frames(&path, &parameters, Some(&Vector3::zeros())).is_err());
    let tangent = path.jet(0.0).d1;
    assert!(rotation_minimizing_frames(&path, &parameters, Some(&tangent)).is_err());
}
