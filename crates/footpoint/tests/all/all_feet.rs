//! All local minima of the distance, against closed forms and against minima of dense samples.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

use footpoint::{CurveProjector, Error, Location, Multiplicity, ProjectionOptions, SurfaceProjector};
use nalgebra::{Vector2, Vector3};
use nurbs_core::construct::bilinear;
use nurbs_core::{
    BsplineCurve, BsplineSurface, Circle, Cylinder, Ellipse, Frame, Interval, KnotVector, ParametricCurve,
    ParametricSurface, Sphere, Torus,
};
use proptest::prelude::*;

fn options() -> ProjectionOptions {
    ProjectionOptions::default()
}

fn rectangle(z: f64) -> BsplineSurface {
    let p = |x: f64, y: f64| Vector3::new(x, y, z);
    bilinear([[p(-1.0, -1.0), p(-1.0, 1.0)], [p(1.0, -1.0), p(1.0, 1.0)]]).unwrap()
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-9
}

#[test]
fn two_parallel_planes() {
    let model = SurfaceProjector::for_model(&[rectangle(0.0), rectangle(2.0)]).unwrap();
    let x = Vector3::new(0.3, 0.2, 0.9);
    let one = model.feet_within(&x, 1.0, &options()).unwrap();
    assert!(one.complete && one.feet.len() == 1 && close(one.feet[0].distance, 0.9), "{one:?}");
    let both = model.feet_within(&x, 1.3, &options()).unwrap();
    assert!(both.complete && !both.continuum, "{both:?}");
    let found: Vec<_> = both.feet.iter().map(|f| (f.shape, f.multiplicity)).collect();
    assert_eq!(found, [(0, Multiplicity::Unique), (1, Multiplicity::Unique)]);
    let tied = model.feet_within(&Vector3::new(0.3, 0.2, 1.0), 1.0, &options()).unwrap();
    assert!(tied.complete && tied.feet.len() == 2, "{tied:?}");
    assert!(tied.feet.iter().all(|f| f.multiplicity == Multiplicity::Tied && f.status.is_converged()));
    assert!(tied.feet.iter().all(|f| f.gap() < 1e-6));
}

#[test]
fn edges_and_corners() {
    let model = SurfaceProjector::for_model(&[rectangle(0.0), rectangle(2.0)]).unwrap();
    for (x, location) in [
        (Vector3::new(2.0, 0.3, 0.5), Location::Edge),
        (Vector3::new(2.0, 1.5, 0.5), Location::Corner),
        (Vector3::new(1.0, 1.0, 0.5), Location::Corner),
        (Vector3::new(0.1, 1.0, 0.5), Location::Edge),
    ] {
        let all = model.feet_within(&x, 10.0, &options()).unwrap();
        assert!(all.complete, "{x} {all:?}");
        assert_eq!(all.feet.len(), 2, "{x} {all:?}");
        assert!(all.feet.iter().all(|f| f.location == location && f.status.is_converged()), "{all:?}");
    }
}

#[test]
fn an_ellipse_has_two_minima_inside() {
    let ellipse = Ellipse::new(Vector2::new(0.0, 0.0), [2.0, 1.0]).unwrap().to_nurbs().unwrap();
    let projector = CurveProjector::new(&ellipse);
    // Inside the evolute: four stationary points, of which two are minima.
    let all = projector.feet_within(&Vector2::new(0.2, 0.1), 5.0, &options()).unwrap();
    assert!(all.complete && !all.continuum, "{all:?}");
    assert_eq!(all.feet.len(), 2, "{all:?}");
    assert!(all.feet[0].point.y > 0.9 && all.feet[1].point.y < -0.9);
    // At the centre the two are tied; the far ends of the long axis are maxima.
    let tied = projector.feet_within(&Vector2::zeros(), 1.0, &options()).unwrap();
    assert!(tied.complete && tied.feet.len() == 2, "{tied:?}");
    assert!(tied.feet.iter().all(|f| f.multiplicity == Multiplicity::Tied && close(f.distance, 1.0)));
    // Far outside there is one.
    let one = projector.feet_within(&Vector2::new(5.0, 3.0), 10.0, &options()).unwrap();
    assert!(one.complete && one.feet.len() == 1, "{one:?}");
}

#[test]
fn a_seam_is_reported_once() {
    let ellipse = Ellipse::new(Vector2::new(0.0, 0.0), [1.0, 2.0]).unwrap().to_nurbs().unwrap();
    let all = CurveProjector::new(&ellipse).feet_within(&Vector2::zeros(), 1.0, &options()).unwrap();
    // The curve begins and ends at (1, 0).
    assert!(all.complete && all.feet.len() == 2, "{all:?}");
    assert_eq!(all.feet.iter().filter(|f| f.location == Location::Seam).count(), 1, "{all:?}");

    let torus = Torus::new(Frame::WORLD, 3.0, 1.0).unwrap().to_nurbs().unwrap();
    let on_seam = Vector3::new(3.25, 0.0, 0.0);
    let all = SurfaceProjector::new(&torus).feet_within(&on_seam, 1.0, &options()).unwrap();
    assert!(all.complete && all.feet.len() == 1, "{all:?}");
    assert_eq!(all.feet[0].location, Location::Seam);
}

#[test]
fn a_torus() {
    let projector = SurfaceProjector::new(&Torus::new(Frame::WORLD, 3.0, 1.0).unwrap().to_nurbs().unwrap());
    for x in [[4.0, 1.5, 1.0], [0.5, 0.2, 0.3]] {
        // The opposite side of the ring is a saddle of the distance, the rest are maxima.
        let all = projector.feet_within(&Vector3::from(x), 20.0, &options()).unwrap();
        assert!(all.complete && all.feet.len() == 1, "{all:?}");
    }
    // On the axis whole circles are as near.
    let axis = projector.feet_within(&Vector3::new(0.0, 0.0, 0.5), 1.0, &options()).unwrap();
    assert!(axis.continuum && !axis.complete && axis.feet.len() == 1, "{axis:?}");
    assert_eq!(axis.feet[0].multiplicity, Multiplicity::Continuum);
    assert!(axis.boxes < 3000, "{}", axis.boxes);
    // On the core circle the meridian circle is.
    let core = projector.feet_within(&Vector3::new(2.4, 1.8, 0.0), 1.0, &options()).unwrap();
    assert!(core.continuum && !core.complete && core.feet.len() == 1, "{core:?}");
    assert!(core.boxes < 3000, "{}", core.boxes);
}

#[test]
fn spheres_and_their_poles() {
    let projector = SurfaceProjector::new(&Sphere::new(Frame::WORLD, 2.0).unwrap().to_nurbs().unwrap());
    let centre = projector.feet_within(&Vector3::zeros(), 1.5, &options()).unwrap();
    assert!(centre.continuum && !centre.complete && centre.feet.len() == 1, "{centre:?}");
    assert!(centre.boxes < 1000, "{}", centre.boxes);
    // One minimum wherever else the point is, on the axis, and next to it: the antipode is a maximum.
    for x in [[0.3, 0.2, 0.1], [3.0, -1.0, 0.5], [0.0, 0.0, 3.0], [0.0, 0.0, -0.5], [1e-6, 0.0, 1.0]] {
        let all = projector.feet_within(&Vector3::from(x), 50.0, &options()).unwrap();
        assert_eq!(all.feet.len(), 1, "{x:?} {all:?}");
        assert!(all.complete, "{x:?} {all:?}");
        let d = (Vector3::from(x).norm() - 2.0).abs();
        assert!(close(all.feet[0].distance, d) && all.feet[0].status.is_converged(), "{x:?} {all:?}");
        assert!(all.boxes < 4000, "{x:?} {}", all.boxes);
    }
}

#[test]
fn continua_that_are_apart() {
    let cylinder = |x: f64| {
        let frame = Frame::from_axis(Vector3::new(x, 0.0, 0.0), Vector3::z()).unwrap();
        Cylinder::new(frame, 1.0, Interval::new(-1.0, 1.0).unwrap()).unwrap().to_nurbs().unwrap()
    };
    let model = SurfaceProjector::for_model(&[cylinder(0.0), cylinder(5.0)]).unwrap();
    let axis = model.feet_within(&Vector3::new(0.0, 0.0, 0.25), 3.5, &options()).unwrap();
    assert!(axis.continuum && !axis.complete && axis.feet.len() == 1, "{axis:?}");
    let more = model.feet_within(&Vector3::new(0.0, 0.0, 0.25), 4.5, &options()).unwrap();
    assert_eq!(more.feet.len(), 2, "{more:?}");
    assert_eq!(more.feet[1].multiplicity, Multiplicity::Unique);
    // Beyond the end the whole end circle is nearest.
    let end = model.feet_within(&Vector3::new(0.0, 0.0, 3.0), 1.0, &options()).unwrap();
    assert!(end.continuum && end.feet.len() == 1, "{end:?}");

    let circle = Circle::new(Vector2::new(1.0, 2.0), 3.0).unwrap().to_nurbs().unwrap();
    let all = CurveProjector::new(&circle).feet_within(&Vector2::new(1.0, 2.0), 1.0, &options()).unwrap();
    assert!(all.continuum && !all.complete && all.feet.len() == 1, "{all:?}");
}

#[test]
fn kinks_count_only_when_both_sides_rise() {
    let p = |x: f64, y: f64| Vector2::new(x, y);
    let knots = KnotVector::new(1, vec![0.0, 0.0, 1.0, 2.0, 3.0, 3.0]).unwrap();
    let zigzag =
        BsplineCurve::new(knots, vec![p(-2.0, 0.0), p(-1.0, 1.0), p(0.0, 0.0), p(1.0, 2.0)], None).unwrap();
    let projector = CurveProjector::new(&zigzag);
    // Above the peak: the kink at (−1, 1) and the slope to the right.
    let above = projector.feet_within(&p(-1.0, 2.0), 3.0, &options()).unwrap();
    assert!(above.complete && above.feet.len() == 2, "{above:?}");
    assert!(close(above.feet[0].distance, 1.0) && above.feet[1].point.x > 0.0);
    // Beside it the distance falls along one of the legs.
    let beside = projector.feet_within(&p(-2.5, 1.0), 1.01, &options()).unwrap();
    assert!(beside.complete && beside.feet.len() == 1, "{beside:?}");
    assert!(beside.feet[0].point.x < -1.1);

    // A roof: the ridge is nearest from above, the slopes from below.
    let line = KnotVector::bezier(1, Interval::UNIT).unwrap();
    let folded = KnotVector::new(1, vec![0.0, 0.0, 1.0, 2.0, 2.0]).unwrap();
    let net = [[-1.0, 0.0], [0.0, 1.0], [1.0, 0.0]]
        .iter()
        .flat_map(|&[x, z]| [Vector3::new(x, -1.0, z), Vector3::new(x, 1.0, z)])
        .collect();
    let roof = SurfaceProjector::new(&BsplineSurface::new(folded, line, net, None).unwrap());
    let above = roof.feet_within(&Vector3::new(0.0, 0.1, 3.0), 3.0, &options()).unwrap();
    assert!(above.complete && above.feet.len() == 1 && close(above.feet[0].distance, 2.0), "{above:?}");
    let below = roof.feet_within(&Vector3::new(0.0, 0.1, 0.2), 3.0, &options()).unwrap();
    assert!(below.complete && below.feet.len() == 2, "{below:?}");
    let d = 0.8 / 2f64.sqrt();
    assert!(below.feet.iter().all(|f| close(f.distance, d)), "{below:?}");
}

#[test]
fn invalid_input() {
    let projector = SurfaceProjector::new(&rectangle(0.0));
    let x = Vector3::zeros();
    for factor in [0.5, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            projector.feet_within(&x, factor, &options()),
            Err(Error::Option { option: "factor", .. })
        ));
    }
    let nan = Vector3::new(0.0, f64::NAN, 0.0);
    assert_eq!(projector.feet_within(&nan, 1.0, &options()), Err(Error::NonFinitePoint { index: 0 }));
    let on = projector.feet_within(&x, 1e300, &options()).unwrap();
    assert!(on.complete && on.feet.len() == 1 && on.feet[0].distance == 0.0, "{on:?}");
    let far = projector.feet_within(&Vector3::new(1e9, 0.3, 0.0), 2.0, &options()).unwrap();
    assert!(far.feet.len() == 1 && far.feet[0].location == Location::Edge, "{far:?}");
}

#[test]
fn a_small_budget_is_admitted() {
    let options = ProjectionOptions { max_boxes: 0, ..options() };
    let flat = SurfaceProjector::new(&rectangle(0.0)).feet_within(&Vector3::z(), 1.0, &options).unwrap();
    assert!(flat.complete, "64 boxes are plenty here: {flat:?}");
    let sphere = Sphere::new(Frame::WORLD, 2.0).unwrap().to_nurbs().unwrap();
    let all = SurfaceProjector::new(&sphere).feet_within(&Vector3::zeros(), 1.0, &options).unwrap();
    assert!(!all.complete && !all.feet.is_empty());
}

/// Minima of samples on a grid, each followed downhill by a pattern search.
fn oracle(distance: &impl Fn([f64; 2]) -> f64, n: [usize; 2]) -> Vec<([f64; 2], f64)> {
    let step = n.map(|n| if n == 0 { 0.0 } else { 1.0 / n as f64 });
    let mut minima: Vec<([f64; 2], f64)> = Vec::new();
    let value: Vec<Vec<f64>> = (0..=n[0])
        .map(|i| (0..=n[1]).map(|j| distance([i as f64 * step[0], j as f64 * step[1]])).collect())
        .collect();
    let around = |k: usize, n: usize| k.saturating_sub(1)..=(k + 1).min(n);
    for i in 0..=n[0] {
        for j in 0..=n[1] {
            if around(i, n[0]).any(|k| around(j, n[1]).any(|l| value[k][l] < value[i][j])) {
                continue;
            }
            let (mut at, mut best) = ([i as f64 * step[0], j as f64 * step[1]], value[i][j]);
            let mut h = 1.0f64;
            while h > 1e-9 {
                let found = (0..16)
                    .map(|k| {
                        let (sin, cos) = (f64::from(k) * std::f64::consts::PI / 8.0).sin_cos();
                        let place = [at[0] + h * step[0] * cos, at[1] + h * step[1] * sin];
                        place.map(|c| c.clamp(0.0, 1.0))
                    })
                    .map(|place| (place, distance(place)))
                    .min_by(|a, b| a.1.total_cmp(&b.1))
                    .unwrap();
                if found.1 < best {
                    (at, best) = found;
                } else {
                    h *= 0.5;
                }
            }
            minima.push((at, best));
        }
    }
    minima
}

fn knots(degree: usize, n: usize) -> KnotVector {
    KnotVector::uniform_clamped(degree, n).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn random_surfaces(
        heights in prop::collection::vec(-1.0..1.0f64, 25),
        weights in prop::option::of(prop::collection::vec(0.4..2.5f64, 25)),
        x in [-0.2..1.2f64, -0.2..1.2f64, -1.0..1.0f64],
        factor in 1.0..4.0f64,
    ) {
        let net = heights.iter().enumerate()
            .map(|(k, &z)| Vector3::new((k / 5) as f64 / 4.0, (k % 5) as f64 / 4.0, z))
            .collect();
        let surface = BsplineSurface::new(knots(3, 5), knots(3, 5), net, weights).unwrap();
        let x = Vector3::from(x);
        let all = SurfaceProjector::new(&surface).feet_within(&x, factor, &options()).unwrap();
        prop_assert!(all.complete && !all.continuum, "{:?}", all);
        let [du, dv] = [surface.knots_u(), surface.knots_v()].map(KnotVector::domain);
        let distance = |[s, t]: [f64; 2]| (surface.point(du.lerp(s), dv.lerp(t)) - x).norm();
        let least = all.feet[0].distance;
        let mut expected = 0;
        for (at, d) in oracle(&distance, [64, 64]) {
            prop_assert!(d >= least * (1.0 - 1e-9));
            if d > least * factor * (1.0 - 1e-6) && d > least * (1.0 + 1e-6) {
                continue;
            }
            expected += 1;
            let place = surface.point(du.lerp(at[0]), dv.lerp(at[1]));
            let found = all.feet.iter().any(|f| {
                (f.distance - d).abs() < 1e-6 && (f.point - place).norm() < 1e-2
            });
            prop_assert!(found, "minimum at {:?}, {} away, not in {:#?}", at, d, all);
        }
        prop_assert!(expected > 0);
        for (i, foot) in all.feet.iter().enumerate() {
            prop_assert!(foot.status.is_converged() && foot.distance <= least * factor * (1.0 + 1e-8));
            prop_assert!(all.feet[..i].iter().all(|f| (f.point - foot.point).norm() > 1e-7));
            for k in 0..32 {
                let (sin, cos) = (f64::from(k) * std::f64::consts::PI / 16.0).sin_cos();
                let [u, v] = foot.parameter;
                let near = [du.clamp(u + 1e-4 * cos), dv.clamp(v + 1e-4 * sin)];
                let d = (surface.point(near[0], near[1]) - x).norm();
                prop_assert!(d >= foot.distance - 1e-12, "{} below {:?}", d, foot);
            }
        }
    }

    #[test]
    fn random_curves(
        points in prop::collection::vec([-1.0..1.0f64, -1.0..1.0f64], 9),
        weights in prop::option::of(prop::collection::vec(0.4..2.5f64, 9)),
        x in [-1.0..1.0f64, -1.0..1.0f64],
        degree in 1usize..6,
        factor in 1.0..5.0f64,
    ) {
        let net = points.into_iter().map(Vector2::from).collect();
        let curve = BsplineCurve::new(knots(degree, 9), net, weights).unwrap();
        let x = Vector2::from(x);
        let all = CurveProjector::new(&curve).feet_within(&x, factor, &options()).unwrap();
        prop_assert!(all.complete && !all.continuum, "{:?}", all);
        let domain = curve.knots().domain();
        let distance = |[s, _]: [f64; 2]| (curve.point(domain.lerp(s)) - x).norm();
        let least = all.feet[0].distance;
        for (at, d) in oracle(&distance, [2000, 0]) {
            let place = curve.point(domain.lerp(at[0]));
            let found = all.feet.iter().any(|f| (f.point - place).norm() < 1e-4);
            prop_assert!(found || d > least * factor * (1.0 - 1e-6), "{:?} {} not in {:#?}", at, d, all);
        }
        for foot in &all.feet {
            prop_assert!(foot.status.is_converged() && foot.distance <= least * factor * (1.0 + 1e-8));
            for t in [foot.parameter - 1e-5, foot.parameter + 1e-5] {
                let d = (curve.point(domain.clamp(t)) - x).norm();
                prop_assert!(d >= foot.distance - 1e-12, "{} below {:?}", d, foot);
            }
        }
    }
}
