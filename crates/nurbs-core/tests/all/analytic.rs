//! Analytic shapes: closest points against brute force, and the exact NURBS forms.

#![allow(clippy::unwrap_used, reason = "a failed construction is a failed test")]

use nalgebra::{SVector, Vector2, Vector3};
use nurbs_core::{
    AnalyticSurface, Circle, Cone, Cylinder, Ellipse, Error, Frame, Interval, Line, ParametricCurve,
    ParametricSurface, Plane, Sphere, SurfaceFoot, Torus,
};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn frame() -> Frame {
    Frame::new(Vector3::new(3.0, -2.0, 7.0), Vector3::new(1.0, 2.0, 2.0), Vector3::new(0.3, -1.0, 0.4))
        .unwrap()
}

fn interval(a: f64, b: f64) -> Interval {
    Interval::new(a, b).unwrap()
}

fn surfaces() -> Vec<AnalyticSurface> {
    let f = frame();
    vec![
        Plane::new(f, interval(-1.0, 2.0), interval(0.5, 3.0)).into(),
        Sphere::new(f, 2.0).unwrap().into(),
        Sphere::new(f, 2.0).unwrap().with_domain(interval(-0.5, 1.7), interval(-0.3, 1.2)).unwrap().into(),
        Sphere::new(f, 2.0)
            .unwrap()
            .with_domain(interval(1.0, 6.0), interval(0.2, FRAC_PI_2))
            .unwrap()
            .into(),
        Cylinder::new(f, 1.5, interval(-1.0, 2.0)).unwrap().into(),
        Cylinder::new(f, 1.5, interval(0.0, 2.0)).unwrap().with_angles(interval(2.0, 4.0)).unwrap().into(),
        Cone::new(f, 2.0, 0.5, 3.0).unwrap().into(),
        Cone::new(f, 0.0, 1.5, 2.0).unwrap().with_angles(interval(-1.0, 3.0)).unwrap().into(),
        Torus::new(f, 3.0, 1.0).unwrap().into(),
        Torus::new(f, 3.0, 1.0).unwrap().with_domain(interval(0.3, 4.0), interval(2.0, 5.0)).unwrap().into(),
    ]
}

/// Points all around: a deterministic low-discrepancy set in a cube of half side 6.
fn queries() -> impl Iterator<Item = Vector3<f64>> {
    (0..60).map(|i| {
        let t = f64::from(i) + 0.5;
        let fraction = |a: f64| 12.0 * (t * a).fract() - 6.0;
        frame().point(&Vector3::new(fraction(0.819_172_5), fraction(0.671_043_6), fraction(0.549_700_5)))
    })
}

#[test]
fn footpoints_of_surfaces_are_closest() {
    for surface in surfaces() {
        let [u, v] = surface.domain();
        for x in queries() {
            let foot: SurfaceFoot = surface.footpoint(&x);
            let [a, b] = foot.parameters;
            assert!(u.contains(a) && v.contains(b), "{surface:?} {foot:?}");
            assert!((surface.point(a, b) - foot.point).norm() == 0.0);
            assert!(((x - foot.point).norm() - foot.distance).abs() == 0.0);
            let n = 60;
            for i in 0..=n {
                for j in 0..=n {
                    let s = surface
                        .point(u.lerp(f64::from(i) / f64::from(n)), v.lerp(f64::from(j) / f64::from(n)));
                    assert!((x - s).norm() >= foot.distance - 1e-12, "{surface:?} {x} {foot:?}");
                }
            }
        }
    }
}

fn check_curve<const D: usize>(
    curve: &impl ParametricCurve<D>,
    foot: impl Fn(&SVector<f64, D>) -> nurbs_core::CurveFoot<D>,
    queries: &[SVector<f64, D>],
) {
    for x in queries {
        let found = foot(x);
        assert!(curve.domain().contains(found.parameter));
        for i in 0..=2000 {
            let c = curve.point(curve.domain().lerp(f64::from(i) / 2000.0));
            assert!((x - c).norm() >= found.distance - 1e-12, "{x} {found:?}");
        }
    }
}

#[test]
fn footpoints_of_curves_are_closest() {
    let space: Vec<_> = queries().collect();
    let plane: Vec<_> = queries()
        .map(|x| x.xy() * 0.5)
        .chain(
            [(0.0, 0.0), (0.1, 0.0), (0.0, 0.2), (-3.0, 0.0), (0.0, -1e-9), (1e-300, 1e-300)]
                .map(|(x, y)| Vector2::new(x, y)),
        )
        .collect();
    let line = Line::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(4.0, -2.0, 3.5)).unwrap();
    check_curve(&line, |x| line.footpoint(x), &space);
    let circle = Circle::in_frame(&frame(), 2.0).unwrap();
    check_curve(&circle, |x| circle.footpoint(x), &space);
    let arc = circle.with_arc(interval(2.0, 5.5)).unwrap();
    check_curve(&arc, |x| arc.footpoint(x), &space);
    for semi in [[3.0, 1.0], [1.0, 3.0], [2.0, 2.0], [5.0, 1e-3]] {
        let ellipse = Ellipse::new(Vector2::zeros(), semi).unwrap();
        check_curve(&ellipse, |x| ellipse.footpoint(x), &plane);
    }
}

#[test]
fn nurbs_forms_are_the_same_surfaces() {
    for surface in surfaces() {
        let nurbs = surface.to_nurbs().unwrap();
        assert_eq!(nurbs.domain(), surface.domain(), "{surface:?}");
        let [u, v] = nurbs.domain();
        for i in 0..=40 {
            for j in 0..=40 {
                let (a, b) = (u.lerp(f64::from(i) / 40.0), v.lerp(f64::from(j) / 40.0));
                let foot = surface.footpoint(&nurbs.point(a, b));
                assert!(foot.distance < 1e-13 * 20.0, "{surface:?} {a} {b} {foot:?}");
                // The rational parameter never runs far from the angle.
                let near = (surface.point(a, b) - nurbs.point(a, b)).norm();
                assert!(near < 0.1, "{near}");
            }
        }
        for (a, b) in [(u.start(), v.start()), (u.end(), v.end())] {
            assert!((surface.point(a, b) - nurbs.point(a, b)).norm() < 1e-14 * 20.0);
        }
    }
}

#[test]
fn arcs_of_every_sweep() {
    for sweep in [1e-6, 0.3, FRAC_PI_2, 1.6, PI, 4.0, 1.5 * PI, 6.0, TAU] {
        let arc =
            Circle::new(Vector2::new(1.0, 2.0), 3.0).unwrap().with_arc(interval(-0.7, sweep - 0.7)).unwrap();
        let nurbs = arc.to_nurbs().unwrap();
        assert_eq!(nurbs.bezier_curves().len() as f64, (sweep / FRAC_PI_2 - 1e-12).ceil());
        for i in 0..=100 {
            let p = nurbs.point(nurbs.domain().lerp(f64::from(i) / 100.0));
            assert!(((p - arc.centre()).norm() - 3.0).abs() < 4e-14, "{sweep}");
            assert!(arc.footpoint(&p).distance < 1e-14 * 8.0);
        }
        let closed = nurbs.control_points().first() == nurbs.control_points().last();
        assert_eq!(closed, sweep == TAU);
    }
    let ellipse = Ellipse::in_frame(&frame(), [4.0, 1.0]).unwrap();
    let nurbs = ellipse.to_nurbs().unwrap();
    for i in 0..=100 {
        let p = nurbs.point(TAU * f64::from(i) / 100.0);
        assert!(ellipse.footpoint(&p).distance < 1e-13);
    }
}

#[test]
fn jets_of_surfaces_match_differences() {
    for surface in surfaces() {
        let [u, v] = surface.domain();
        let (a, b, h) = (u.lerp(0.37), v.lerp(0.61), 1e-4);
        let jet = surface.jet(a, b);
        let s = |i: f64, j: f64| surface.point(a + i * h, b + j * h);
        let close = |x: Vector3<f64>, y: Vector3<f64>| assert!((x - y).norm() < 1e-6, "{surface:?} {x} {y}");
        close((s(1.0, 0.0) - s(-1.0, 0.0)) / (2.0 * h), jet.du);
        close((s(0.0, 1.0) - s(0.0, -1.0)) / (2.0 * h), jet.dv);
        close((s(1.0, 0.0) + s(-1.0, 0.0) - jet.point * 2.0) / (h * h), jet.duu);
        close((s(0.0, 1.0) + s(0.0, -1.0) - jet.point * 2.0) / (h * h), jet.dvv);
        close((s(1.0, 1.0) + s(-1.0, -1.0) - s(1.0, -1.0) - s(-1.0, 1.0)) / (4.0 * h * h), jet.duv);
    }
}

#[test]
fn poles_and_axes() {
    let sphere = Sphere::new(frame(), 2.0).unwrap();
    assert!(sphere.jet(1.0, FRAC_PI_2).unit_normal().is_none());
    let nurbs = sphere.to_nurbs().unwrap();
    assert!(nurbs.jet(1.0, FRAC_PI_2).unit_normal().is_none());
    let pole = nurbs.control_point(0, nurbs.n_v() - 1);
    assert!((0..nurbs.n_u()).all(|i| nurbs.control_point(i, nurbs.n_v() - 1) == pole));
    let centre = sphere.footpoint(&frame().origin());
    assert_eq!((centre.parameters, centre.distance.round()), ([0.0, -FRAC_PI_2], 2.0));
    let nan = sphere.footpoint(&Vector3::repeat(f64::NAN));
    assert!(nan.distance.is_nan() && sphere.domain()[0].contains(nan.parameters[0]));
}

#[test]
fn invalid_shapes_are_refused() {
    let bad = |r: Result<AnalyticSurface, Error>| assert!(matches!(r, Err(Error::Argument { .. })), "{r:?}");
    bad(Sphere::new(frame(), -1.0).map(Into::into));
    bad(Sphere::new(frame(), f64::NAN).map(Into::into));
    bad(Torus::new(frame(), 1.0, 1.0).map(Into::into));
    bad(Cone::new(frame(), 0.0, 0.0, 1.0).map(Into::into));
    bad(Cone::new(frame(), -1.0, 1.0, 1.0).map(Into::into));
    bad(Sphere::new(frame(), 1.0)
        .unwrap()
        .with_domain(interval(0.0, 7.0), interval(0.0, 1.0))
        .map(Into::into));
    bad(Sphere::new(frame(), 1.0)
        .unwrap()
        .with_domain(interval(0.0, 1.0), interval(0.0, 1.6))
        .map(Into::into));
    assert!(Line::new(Vector2::zeros(), Vector2::zeros()).is_err());
    assert!(Circle::with_axes(Vector2::zeros(), [Vector2::x(), Vector2::x()], 1.0).is_err());
    assert!(Ellipse::new(Vector2::zeros(), [1.0, 0.0]).is_err());
}

#[test]
fn json_round_trip() {
    for surface in surfaces() {
        let text = serde_json::to_string(&surface).unwrap();
        let back: AnalyticSurface = serde_json::from_str(&text).unwrap();
        assert_eq!(back, surface, "{text}");
    }
    let text = r#"{"kind":"sphere","frame":{"origin":[0,0,0],"z":[0,0,1],"x":[1,0,0]},"radius":2.5}"#;
    let sphere: Sphere = serde_json::from_str(text).unwrap();
    assert_eq!(sphere, Sphere::new(Frame::WORLD, 2.5).unwrap());
    let wrong = serde_json::from_str::<Torus>(text).unwrap_err().to_string();
    assert!(wrong.contains("not `torus`"), "{wrong}");
    let negative = serde_json::from_str::<Sphere>(&text.replace("2.5", "-2.5")).unwrap_err().to_string();
    assert!(negative.contains("must be positive"), "{negative}");
    let arc = Circle::in_frame(&frame(), 2.0).unwrap().with_arc(interval(1.0, 2.0)).unwrap();
    let text = serde_json::to_string(&arc).unwrap();
    assert_eq!(serde_json::from_str::<Circle<3>>(&text).unwrap(), arc);
    assert!(serde_json::from_str::<Circle<2>>(&text).unwrap_err().to_string().contains("where 2 are needed"));
    let line = Line::new(Vector2::new(1.0, 2.0), Vector2::new(4.0, -2.0)).unwrap();
    let text = serde_json::to_string(&line).unwrap();
    assert_eq!(serde_json::from_str::<Line<2>>(&text).unwrap(), line);
    let interval = serde_json::from_str::<Interval>(r#"{"start":2,"end":1}"#);
    assert!(interval.unwrap_err().to_string().contains("empty"));
}

#[test]
fn knot_vectors_are_checked_on_reading() {
    use nurbs_core::KnotVector;
    for knots in [KnotVector::uniform_clamped(3, 7).unwrap(), KnotVector::uniform_periodic(2, 5).unwrap()] {
        let text = serde_json::to_string(&knots).unwrap();
        assert_eq!(serde_json::from_str::<KnotVector>(&text).unwrap(), knots);
    }
    let wrong = serde_json::from_str::<KnotVector>(r#"{"degree":1,"knots":[0,0,2,1]}"#).unwrap_err();
    assert!(wrong.to_string().contains("knot 3 is smaller"), "{wrong}");
}
