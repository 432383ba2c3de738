//! Spheres, cylinders, cones, tori and circles as NURBS: distances have a closed form.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

use crate::projector_support::answer::{Answer, Judge};
use crate::projector_support::config;
use crate::projector_support::random::frame;
use footpoint::{CurveProjector, SurfaceProjector};
use nalgebra::Vector3;
use nurbs_core::{
    AnalyticSurface, Circle, Cone, Cylinder, Frame, Interval, ParametricCurve, ParametricSurface, Sphere,
    Torus,
};
use proptest::prelude::*;

/// A sphere, cylinder, cone (with an apex, or without) or torus of sizes 0.3 to 6, anywhere.
fn surface() -> impl Strategy<Value = AnalyticSurface> {
    (frame(), 0_usize..5, 0.3..3.0, 0.1..0.9_f64).prop_map(|(frame, kind, radius, share)| match kind {
        0 => AnalyticSurface::Sphere(Sphere::new(frame, radius).unwrap()),
        1 => {
            let heights = Interval::new(-share, 2.0 * radius).unwrap();
            AnalyticSurface::Cylinder(Cylinder::new(frame, radius, heights).unwrap())
        }
        2 => AnalyticSurface::Cone(Cone::new(frame, radius, 0.0, 2.0 * share).unwrap()),
        3 => AnalyticSurface::Cone(Cone::new(frame, share * radius, radius, 1.0).unwrap()),
        _ => AnalyticSurface::Torus(Torus::new(frame, radius, share * radius).unwrap()),
    })
}

fn frame_of(surface: &AnalyticSurface) -> Frame {
    match surface {
        AnalyticSurface::Sphere(s) => *s.frame(),
        AnalyticSurface::Cylinder(s) => *s.frame(),
        AnalyticSurface::Cone(s) => *s.frame(),
        AnalyticSurface::Torus(s) => *s.frame(),
        AnalyticSurface::Plane(s) => *s.frame(),
        _ => Frame::WORLD,
    }
}

/// Where a query is taken.
#[derive(Clone, Debug)]
enum Query {
    /// A place on the surface, and an offset as a share of the size.
    Near([f64; 2], Vector3<f64>),
    /// A place on the axis, by its height as a share of the size, and an offset.
    Axis(f64, Vector3<f64>),
}

fn queries() -> impl Strategy<Value = Vec<Query>> {
    let offset = || {
        let scale = prop_oneof![Just(0.0), Just(1e-12), Just(1e-6), Just(1e-2), Just(0.2), Just(4.0)];
        ([-1.0..1.0, -1.0..1.0, -1.0..1.0], scale).prop_map(|(d, scale)| Vector3::from(d) * scale)
    };
    // Corners of the parameter square are seams, ends, apices and poles.
    let share = || prop_oneof![4 => 0.0..=1.0, 1 => Just(0.0), 1 => Just(1.0)];
    let height = prop_oneof![3 => -3.0..3.0, 1 => Just(0.0)];
    let query = prop_oneof![
        3 => ([share(), share()], offset()).prop_map(|(at, d)| Query::Near(at, d)),
        1 => (height, offset()).prop_map(|(z, d)| Query::Axis(z, d)),
    ];
    prop::collection::vec(query, 24)
}

proptest! {
    #![proptest_config(config(64))]

    #[test]
    fn distances_of_surfaces(surface in surface(), queries in queries()) {
        let nurbs = surface.to_nurbs().unwrap();
        let projector = SurfaceProjector::new(&nurbs);
        let size = nurbs.size();
        let domain = surface.domain();
        let frame = frame_of(&surface);
        for query in &queries {
            let x = match query {
                Query::Near([s, t], offset) => {
                    surface.point(domain[0].lerp(*s), domain[1].lerp(*t)) + offset * size
                }
                Query::Axis(z, offset) => frame.point(&Vector3::new(0.0, 0.0, z * size)) + offset * size,
            };
            let expected = surface.footpoint(&x).distance;
            let found: Answer<3> = projector.project(&x).into();
            prop_assert_eq!(nurbs.inconsistency(&x, &found), None, "{:?} {:?}", query, found);
            prop_assert!((found.distance - expected).abs() <= 1e-9 * size, "{} {:?} {:?}", expected, query, found);
            prop_assert!(found.lower_bound <= expected + 1e-12 * size, "{} {:?} {:?}", expected, query, found);
            prop_assert!(found.status.is_converged(), "{:?} {:?}", query, found);
        }
    }

    #[test]
    fn distances_of_circles(frame in frame(), radius in 0.3..3.0, turn in 0.5..6.2, whole in any::<bool>(), queries in queries()) {
        let circle = Circle::in_frame(&frame, radius).unwrap();
        let circle = if whole { circle } else { circle.with_arc(Interval::new(0.2, 0.2 + turn).unwrap()).unwrap() };
        let nurbs = circle.to_nurbs().unwrap();
        let projector = CurveProjector::new(&nurbs);
        let size = nurbs.size();
        for query in &queries {
            let x = match query {
                Query::Near([s, _], offset) => circle.point(circle.domain().lerp(*s)) + offset * size,
                Query::Axis(z, offset) => frame.point(&Vector3::new(0.0, 0.0, z * size)) + offset * size,
            };
            let expected = circle.footpoint(&x).distance;
            let found: Answer<3> = projector.project(&x).into();
            prop_assert_eq!(nurbs.inconsistency(&x, &found), None, "{:?} {:?}", query, found);
            prop_assert!((found.distance - expected).abs() <= 1e-9 * size, "{} {:?} {:?}", expected, query, found);
            prop_assert!(found.lower_bound <= expected + 1e-12 * size, "{} {:?} {:?}", expected, query, found);
            prop_assert!(found.status.is_converged(), "{:?} {:?}", query, found);
        }
    }
}
