//! Closest points, sides and areas of solids whose distance is known in closed form.

use crate::shapes::{Builder, cuboid, disc, frame, moved, points};
use brep_core::description::{Carrier, EdgeCurve, InstanceDescription, Placement};
use brep_core::{Model, On, Side};
use footpoint::Facing;
use nalgebra::{Vector2, Vector3};
use nurbs_core::{BsplineSurface, Frame, Interval, KnotVector, Sphere};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

/// Checks distances, sides and certificates against a signed distance.
fn check(model: &Model, expected: impl Fn(&Vector3<f64>) -> f64, size: f64) {
    for x in points(1500, size) {
        let foot = model.nearest(&x).unwrap();
        let distance = expected(&x);
        assert!((foot.distance - distance.abs()).abs() < 1e-9, "{x:?}: {distance} expected, {foot:?}");
        assert!(foot.gap() < 1e-9, "{foot:?}");
        assert!(((x - foot.point).norm() - foot.distance).abs() < 1e-12);
        if distance.abs() > 1e-6 {
            let side = if distance > 0.0 { Side::Positive } else { Side::Negative };
            assert_eq!(foot.side, side, "{x:?}: {foot:?}");
        }
    }
}

/// Signed distance from a solid of revolution whose profile is a convex polygon in `(ρ, z)`, counterclockwise, closed by
/// the axis.
fn revolved(profile: &[[f64; 2]], x: &Vector3<f64>) -> f64 {
    let p = Vector2::new(x.x.hypot(x.y), x.z);
    let (mut distance, mut outside) = (f64::INFINITY, f64::NEG_INFINITY);
    for pair in profile.windows(2) {
        let [a, b] = [Vector2::from(pair[0]), Vector2::from(pair[1])];
        let d = b - a;
        let s = ((p - a).dot(&d) / d.norm_squared()).clamp(0.0, 1.0);
        distance = distance.min((p - a - d * s).norm());
        outside = outside.max(Vector2::new(d.y, -d.x).dot(&(p - a)));
    }
    if outside > 0.0 { distance } else { -distance }
}

#[test]
fn box_with_edges_and_corners() {
    let model = cuboid([1.0, 2.0, 0.5]).model();
    let half = Vector3::new(0.5, 1.0, 0.25);
    let signed = |x: &Vector3<f64>| {
        let q = (x - half).abs() - half;
        q.sup(&Vector3::zeros()).norm() + q.max().min(0.0)
    };
    check(&model, signed, 3.0);
    for (face, area) in [(0, 1.0), (2, 0.5), (4, 2.0)] {
        assert!((model.parts()[0].area(face) - area).abs() < 1e-12);
    }
    let corner = model.nearest(&Vector3::new(-1.0, -1.0, -1.0)).unwrap();
    assert!(matches!(corner.on, On::Vertex { .. }));
}

/// A frustum from radius `bottom` at 0 to `top` at `height`, whose circles start anywhere.
fn frustum(bottom: f64, top: f64, height: f64, turn: f64) -> Builder {
    let mut b = Builder::default();
    let low = b.circle(bottom, 0.0, turn);
    let angle = ((top - bottom) / height).atan();
    let high = (top > 0.0).then(|| b.circle(top, height, 1.0 - turn));
    let carrier = if angle == 0.0 {
        Carrier::Cylinder { frame: frame(0.0, 1.0, turn), radius: bottom }
    } else {
        // The radius of the file may be given at any height.
        let at = 0.25 * height;
        let radius = bottom + at * angle.tan();
        Carrier::Cone { frame: frame(at, 1.0, turn), radius, half_angle: angle }
    };
    match high {
        Some(high) => b.face(carrier, true, &[&[(low, true)], &[(high, false)]]),
        None => b.face(carrier, true, &[&[(low, true)]]),
    }
    disc(&mut b, low, 0.0, -1.0);
    if let Some(high) = high {
        disc(&mut b, high, height, 1.0);
    }
    b
}

#[test]
fn cylinders_without_a_seam() {
    for turn in [0.0, 1.0, PI, -2.0, FRAC_PI_2] {
        let model = frustum(1.0, 1.0, 2.0, turn).model();
        check(&model, |x| revolved(&[[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 2.0]], x), 3.0);
        assert!((model.parts()[0].area(0) - 2.0 * TAU).abs() < 1e-9);
        // On the seam of the parameters and on the axis.
        for k in 0..64 {
            let a = turn + f64::from(k) / 64.0 * TAU;
            let x = Vector3::new(1.5 * a.cos(), 1.5 * a.sin(), 1.0);
            assert!((model.nearest(&x).unwrap().distance - 0.5).abs() < 1e-12);
        }
        let axis = model.nearest(&Vector3::new(0.0, 0.0, 1.0)).unwrap();
        assert!((axis.distance - 1.0).abs() < 1e-12);
    }
}

#[test]
fn cones_with_and_without_apex() {
    for turn in [0.0, 2.5] {
        let model = frustum(1.0, 0.4, 1.5, turn).model();
        check(&model, |x| revolved(&[[0.0, 0.0], [1.0, 0.0], [0.4, 1.5], [0.0, 1.5]], x), 3.0);
        let model = frustum(0.4, 1.0, 1.5, turn).model();
        check(&model, |x| revolved(&[[0.0, 0.0], [0.4, 0.0], [1.0, 1.5], [0.0, 1.5]], x), 3.0);
        let model = frustum(1.0, 0.0, 1.5, turn).model();
        check(&model, |x| revolved(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.5]], x), 3.0);
        let area = PI * 1f64.hypot(1.5);
        assert!((model.parts()[0].area(0) - area).abs() < 1e-9 * area);
    }
}

/// The upper half of a ball, or what is left of the ball above or below a plane.
fn cap(height: f64, above: bool, tilt: f64) -> Builder {
    let mut b = Builder::default();
    let circle = b.circle((1.0 - height * height).sqrt(), height, 0.7);
    // The axis of the parameters need not be that of the circle.
    let axis = Vector3::new(tilt.sin(), 0.0, tilt.cos());
    let sphere = Frame::from_axis(Vector3::zeros(), axis).unwrap();
    b.face(Carrier::Sphere { frame: sphere, radius: 1.0 }, true, &[&[(circle, above)]]);
    disc(&mut b, circle, height, if above { -1.0 } else { 1.0 });
    b
}

#[test]
fn caps_of_spheres_at_any_tilt() {
    for (height, above, tilt) in [
        (0.0, true, 0.0),
        (0.0, true, FRAC_PI_2),
        (0.3, true, 0.4),
        (0.3, false, 0.4),
        (-0.5, true, 0.0),
        (-0.5, false, PI),
        (0.6, false, 1.2),
    ] {
        let model = cap(height, above, tilt).model();
        let rim = (1.0f64 - height * height).sqrt();
        let signed = |x: &Vector3<f64>| {
            let sign = if above { 1.0 } else { -1.0 };
            let (rho, z) = (x.x.hypot(x.y), x.z);
            let on_cap = x.z * sign >= height * sign * x.norm();
            let sphere = if on_cap { (x.norm() - 1.0).abs() } else { f64::INFINITY };
            let plane = if rho <= rim { (z - height).abs() } else { f64::INFINITY };
            let edge = (rho - rim).hypot(z - height);
            let distance = sphere.min(plane).min(edge);
            if x.norm() < 1.0 && z * sign > height * sign { -distance } else { distance }
        };
        check(&model, signed, 2.0);
        let area = TAU * (1.0 - if above { height } else { -height });
        let found = model.parts()[0].area(0);
        assert!((found - area).abs() < 1e-8, "{height} {above} {tilt}: {area} expected, {found}");
    }
}

#[test]
fn balls_and_tori_without_loops() {
    let mut b = Builder::default();
    b.face(Carrier::Sphere { frame: frame(0.0, 1.0, 0.0), radius: 1.5 }, true, &[]);
    check(&b.model(), |x| x.norm() - 1.5, 3.0);
    let mut b = Builder::default();
    let torus = Carrier::Torus { frame: frame(0.0, 1.0, 0.0), major_radius: 2.0, minor_radius: 0.5 };
    b.face(torus, true, &[]);
    let model = b.model();
    check(&model, |x| (x.x.hypot(x.y) - 2.0).hypot(x.z) - 0.5, 3.0);
    assert!((model.parts()[0].area(0) - TAU * TAU).abs() < 1e-9);
}

#[test]
fn half_a_torus_between_two_circles() {
    // The outer or the inner half of a tube, in loops around the axis.
    for outer in [true, false] {
        let mut b = Builder::default();
        let (low, high) = (b.circle(2.0, -0.5, 0.2), b.circle(2.0, 0.5, 3.0));
        let torus = Carrier::Torus { frame: frame(0.0, 1.0, 0.4), major_radius: 2.0, minor_radius: 0.5 };
        b.face(torus, true, &[&[(low, outer)], &[(high, !outer)]]);
        let description = b.description(false);
        let model = Model::new(&description).unwrap();
        for x in points(1500, 3.0) {
            let (rho, z) = (x.x.hypot(x.y) - 2.0, x.z);
            let on = (rho >= 0.0) == outer;
            let distance =
                if on { (rho.hypot(z) - 0.5).abs() } else { rho.hypot(z - 0.5).min(rho.hypot(z + 0.5)) };
            let foot = model.nearest(&x).unwrap();
            assert!((foot.distance - distance).abs() < 1e-9, "{outer} {x:?}: {distance}, {foot:?}");
        }
        let half = PI * 0.5 * if outer { TAU * 2.0 + 2.0 } else { TAU * 2.0 - 2.0 };
        let area = model.parts()[0].area(0);
        assert!((area - half).abs() < 1e-8, "{outer}: {half} expected, {area}");
    }
}

/// The unit square as a B-spline surface of degree 2, with uneven speed.
fn square() -> BsplineSurface {
    let u = KnotVector::new(2, vec![0.0, 0.0, 0.0, 0.3, 1.0, 1.0, 1.0]).unwrap();
    let v = KnotVector::bezier(1, Interval::UNIT).unwrap();
    let rows = [-2.0, -1.5, 0.5, 2.0];
    let points =
        rows.iter().flat_map(|x| [Vector3::new(*x, -2.0, 0.0), Vector3::new(*x, 2.0, 0.0)]).collect();
    BsplineSurface::new(u, v, points, None).unwrap()
}

#[test]
fn trimmed_splines_agree_with_planes() {
    let build = |carrier: Carrier| {
        let mut b = Builder::default();
        let outer = b.circle(1.2, 0.0, 0.1);
        let inner = b.circle(0.5, 0.0, -2.0);
        b.face(carrier, true, &[&[(outer, true)], &[(inner, false)]]);
        Model::new(&b.description(false)).unwrap()
    };
    let model = build(Carrier::Nurbs(Arc::new(square())));
    for x in points(1500, 2.5) {
        let rho = x.x.hypot(x.y);
        let beside = (rho - 1.2).max(0.5 - rho).max(0.0);
        let foot = model.nearest(&x).unwrap();
        assert!((foot.distance - beside.hypot(x.z)).abs() < 1e-8, "{x:?} {foot:?}");
        assert!(foot.gap() < 1e-6);
        assert_eq!(foot.beyond_boundary, beside > 0.0);
    }
    let area = PI * (1.44 - 0.25);
    let found = model.parts()[0].area(0);
    assert!((found - area).abs() < 1e-7, "{area} expected, {found}");
}

#[test]
fn spheres_as_splines_with_poles_and_seam() {
    // A cap around the pole, and one away from it across the seam.
    for (height, above, tilt) in
        [(0.3, true, 0.0), (0.3, false, 0.0), (0.4, true, FRAC_PI_2), (0.4, true, 1.0)]
    {
        let mut b = cap(height, above, 0.0);
        let axis = Vector3::new(f64::sin(tilt), 0.0, f64::cos(tilt));
        let position =
            Frame::new(Vector3::zeros(), axis, Vector3::new(f64::cos(tilt), 0.1, -f64::sin(tilt))).unwrap();
        let sphere = Sphere::new(position, 1.0).unwrap().to_nurbs().unwrap();
        b.part.faces[0].carrier = Carrier::Nurbs(Arc::new(sphere));
        b.part.faces.truncate(1);
        let model = Model::new(&b.description(false)).unwrap();
        let sign = if above { 1.0 } else { -1.0 };
        let rim = (1.0f64 - height * height).sqrt();
        for x in points(700, 2.0) {
            let on_cap = x.z * sign >= height * sign * x.norm();
            let edge = (x.x.hypot(x.y) - rim).hypot(x.z - height);
            let distance = if on_cap { (x.norm() - 1.0).abs() } else { edge };
            let foot = model.nearest(&x).unwrap();
            assert!(
                (foot.distance - distance).abs() < 1e-7,
                "{height} {above} {tilt} {x:?}: {distance} {foot:?}"
            );
        }
        let area = TAU * (1.0 - height * sign);
        let found = model.parts()[0].area(0);
        assert!((found - area).abs() < 1e-7, "{height} {above} {tilt}: {area} expected, {found}");
    }
}

#[test]
fn ellipses_bound_cut_cylinders() {
    // A cylinder cut by a tilted plane: the upper edge is an ellipse.
    let mut b = Builder::default();
    let low = b.circle(1.0, 0.0, 0.3);
    let position =
        Frame::new(Vector3::new(0.0, 0.0, 2.0), Vector3::new(-1.0, 0.0, 1.0), Vector3::new(1.0, 0.0, 1.0));
    let position = position.unwrap();
    let curve = EdgeCurve::Ellipse { frame: position, semi_axes: [2f64.sqrt(), 1.0] };
    let vertex = b.vertex(curve.point(1.0));
    let high = b.edge(curve, [1.0, 1.0 + TAU], [vertex, vertex]);
    b.face(
        Carrier::Cylinder { frame: frame(0.0, 1.0, 2.0), radius: 1.0 },
        true,
        &[&[(low, true)], &[(high, false)]],
    );
    disc(&mut b, low, 0.0, -1.0);
    b.face(Carrier::Plane { frame: position }, true, &[&[(high, true)]]);
    let model = b.model();
    for x in points(1000, 4.0) {
        let inside = x.x.hypot(x.y) < 1.0 && x.z > 0.0 && x.z < 2.0 + x.x;
        let foot = model.nearest(&x).unwrap();
        assert_eq!(foot.side == Side::Negative, inside, "{x:?} {foot:?}");
        // No sample of the surface is nearer.
        for k in 0..720 {
            let a = f64::from(k) / 720.0 * TAU;
            let top = 2.0 + a.cos();
            let on = Vector3::new(a.cos(), a.sin(), x.z.clamp(0.0, top));
            assert!((x - on).norm() >= foot.distance - 1e-9);
        }
    }
    assert!((model.parts()[0].area(0) - 2.0 * TAU).abs() < 1e-9);
    assert!((model.parts()[0].area(2) - PI * 2f64.sqrt()).abs() < 1e-9);
}

#[test]
fn instances_are_placed_and_scaled() {
    let mut description = cuboid([1.0; 3]).description(true);
    let alone = Model::new(&description).unwrap();
    let placement = moved(2.5);
    description.instances[0].placement = placement;
    let mirror = Placement { rotation: -placement.rotation, ..Placement::IDENTITY };
    description.instances.push(InstanceDescription {
        part: 0,
        name: "mirrored".to_owned(),
        placement: mirror,
    });
    let model = Model::new(&description).unwrap();
    for x in points(500, 15.0) {
        let foot = model.nearest(&x).unwrap();
        let [a, b] = [placement, mirror].map(|p| {
            let foot = alone.nearest(&p.inverse_point(&x)).unwrap();
            (foot.distance * p.scale, foot.side)
        });
        let (distance, side) = if a.0 <= b.0 { a } else { b };
        assert!((foot.distance - distance).abs() < 1e-9);
        assert_eq!(foot.side, side);
    }
}

#[test]
fn batches_equal_single_queries() {
    let model = frustum(1.0, 0.4, 1.5, 0.0).model();
    let all = points(300, 2.0);
    let batch = model.nearest_many(&all);
    assert!(all.iter().zip(batch).all(|(x, foot)| model.nearest(x) == foot));
}

#[test]
fn chosen_faces_are_measured_alone() {
    let mut description = cuboid([1.0; 3]).description(true);
    description.retain_faces(|_, face| face.source == 6);
    let model = Model::new(&description).unwrap();
    assert_eq!(model.parts()[0].faces().len(), 1);
    // The top face: other edges of the box count no more.
    let foot = model.nearest(&Vector3::new(0.5, 0.5, -2.0)).unwrap();
    assert!((foot.distance - 3.0).abs() < 1e-12, "{foot:?}");
    assert!(!model.parts()[0].shells()[0].is_closed());
}

#[test]
fn points_at_any_distance_have_a_side_and_the_right_foot() {
    let model = cuboid([1.0, 2.0, 3.0]).model();
    let [low, high] = [Vector3::zeros(), Vector3::new(1.0, 2.0, 3.0)];
    let facing = Facing::new(&Vector3::x(), 1.0).unwrap();
    for exponent in [3, 9, 10, 11, 12, 14, 16, 17, 18, 100, 154, 200, 300, 308] {
        let far = 10f64.powi(exponent);
        for axis in 0..3 {
            for (sign, end) in [(-1.0, low[axis]), (1.0, high[axis])] {
                let mut x = (low + high) * 0.5;
                x[axis] = sign * far;
                let foot = model.nearest(&x).unwrap();
                let expected = (x[axis] - end).abs();
                assert!((foot.distance / expected - 1.0).abs() < 1e-15, "{x}: {foot:?}");
                assert_eq!(foot.side, Side::Positive, "{x}: {foot:?}");
                assert!((foot.point[axis] - end).abs() < 1e-9 && foot.gap() < 1e-9, "{x}: {foot:?}");
            }
        }
        let x = Vector3::new(far, 1.0, 1.5);
        assert_eq!(model.nearest_facing(&x, &facing).map(|foot| foot.side), Some(Side::Positive));
    }
    // A distance that is no number is no answer.
    assert!(
        model.nearest(&Vector3::repeat(1.7e308)).is_none()
            && model.nearest(&Vector3::repeat(f64::NAN)).is_none()
    );
}
