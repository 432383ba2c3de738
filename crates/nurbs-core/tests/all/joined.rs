//! Surfaces that continue others: common edges and common tangent planes.

#![allow(clippy::unwrap_used, reason = "a failed construction is a failed test")]

use nalgebra::Vector3;
use nurbs_core::{
    BsplineCurve, BsplineSurface, Direction, KnotVector, ParametricCurve, ParametricSurface, construct,
};

/// A patch over a rectangle of the plane with heights `f`, of degree 3.
fn height_patch(x: [f64; 2], y: [f64; 2], f: impl Fn(f64, f64) -> f64) -> BsplineSurface {
    let knots = KnotVector::uniform_clamped(3, 7).unwrap();
    let domain = knots.domain();
    let places: Vec<f64> = knots.greville().iter().map(|t| domain.fraction(*t)).collect();
    let net = places.iter().flat_map(|a| {
        let (f, x, y) = (&f, x, y);
        places.iter().map(move |b| {
            let (px, py) = (x[0] + (x[1] - x[0]) * a, y[0] + (y[1] - y[0]) * b);
            Vector3::new(px, py, f(px, py))
        })
    });
    BsplineSurface::new(knots.clone(), knots.clone(), net.collect(), None).unwrap()
}

/// The largest gap along a common edge of two surfaces, and the largest angle between their normals there.
fn gap_and_angle(a: &BsplineSurface, b: &BsplineSurface, [on_a, on_b]: [construct::Side; 2]) -> [f64; 2] {
    let place = |s: &BsplineSurface, side: construct::Side, t: f64| {
        let [u, v] = s.domain();
        let end = f64::from(u8::from(side.is_end()));
        match side.constant() {
            Direction::U => s.jet(u.lerp(end), v.lerp(t)),
            Direction::V => s.jet(u.lerp(t), v.lerp(end)),
        }
    };
    let mut out = [0.0f64; 2];
    for k in 0..=100 {
        let t = f64::from(k) / 100.0;
        let one = place(a, on_a, t);
        let other = [t, 1.0 - t].map(|t| place(b, on_b, t));
        let other = other
            .iter()
            .min_by(|p, q| (p.point - one.point).norm().total_cmp(&(q.point - one.point).norm()))
            .unwrap();
        let angle = one.du.cross(&one.dv).cross(&other.du.cross(&other.dv)).norm()
            / (one.du.cross(&one.dv).norm() * other.du.cross(&other.dv).norm());
        out = [out[0].max((one.point - other.point).norm()), out[1].max(angle)];
    }
    out
}

#[test]
fn surfaces_continue_their_neighbours_from_every_side() {
    let wave = |x: f64, y: f64| 0.3 * (1.3 * x).sin() * (0.7 * y + 0.2).cos();
    let neighbour = height_patch([-2.0, 0.0], [0.0, 2.0], wave);
    // Roughly in place, not fitting, and turned and reversed in all ways.
    let start = height_patch([0.05, 2.0], [-0.03, 2.04], |x, y| 0.1 * x * y + 0.05);
    for turn in 0..8 {
        let mut turned = start.clone();
        if turn & 1 == 1 {
            turned = turned.transposed().unwrap();
        }
        if turn & 2 == 2 {
            turned = turned.reversed(Direction::U).unwrap();
        }
        if turn & 4 == 4 {
            turned = turned.reversed(Direction::V).unwrap();
        }
        let both = [construct::Continuity::Position, construct::Continuity::TangentPlane];
        for continuity in both {
            let made =
                construct::joined(turned.clone(), [0; 4], std::slice::from_ref(&neighbour), continuity)
                    .unwrap();
            let [gap, angle] = gap_and_angle(&made.surface, &neighbour, made.sides[0]);
            assert!(gap < 1e-13, "{turn} {gap}");
            assert_eq!(made.held.iter().sum::<usize>(), continuity.rows());
            let is_smooth = angle < 1e-12;
            assert_eq!(is_smooth, continuity == construct::Continuity::TangentPlane, "{turn} {angle}");
        }
    }
}

#[test]
fn surfaces_between_boundary_curves_are_joined_only_where_these_allow_it() {
    let wave = |x: f64, y: f64| 0.3 * (1.3 * x).sin() * (0.7 * y + 0.2).cos();
    let neighbours = [
        height_patch([-2.0, 0.0], [0.0, 2.0], wave),
        height_patch([2.0, 4.0], [0.0, 2.0], |x, y| wave(x, y) + 0.4),
    ];
    // Boundary curves that leave the edges of the neighbours in their tangent planes: cubics with their derivatives at the ends.
    let [left, right] = [neighbours[0].iso_curve_u(1.0).unwrap(), neighbours[1].iso_curve_u(0.0).unwrap()];
    let across = |k: usize, u: f64, v: f64| neighbours[k].jet(u, v).du / neighbours[k].jet(u, v).du.x;
    let lower = |v: f64, bend: f64| {
        let [a, b] = [neighbours[0].point(1.0, v), neighbours[1].point(0.0, v)];
        let [p, q] = [across(0, 1.0, v), across(1, 0.0, v)];
        let bent = Vector3::z() * bend;
        BsplineCurve::bezier(vec![a, a + p * 0.6 + bent, b - q * 0.6, b], None).unwrap()
    };
    let along_u = |bend: f64| [lower(0.0, bend), lower(1.0, 0.0)];
    let coons = |bend: f64| {
        let [first, second] = along_u(bend);
        construct::coons([&first, &second], [&left, &right], 1e-9).unwrap()
    };
    let made =
        construct::joined(coons(0.0), [1; 4], &neighbours, construct::Continuity::TangentPlane).unwrap();
    for (neighbour, sides) in neighbours.iter().zip(&made.sides) {
        let [gap, angle] = gap_and_angle(&made.surface, neighbour, *sides);
        assert!(gap < 1e-12 && angle < 1e-11, "{gap} {angle}");
    }
    // The other two boundary curves are as they were.
    for k in 0..=20 {
        let t = f64::from(k) / 20.0;
        let [u, v] = made.surface.domain();
        for (end, curve) in [0.0, 1.0].into_iter().zip(along_u(0.0)) {
            assert!((made.surface.point(u.lerp(t), v.lerp(end)) - curve.point(t)).norm() < 1e-12);
        }
    }
    let refused = construct::joined(coons(0.1), [1; 4], &neighbours, construct::Continuity::TangentPlane);
    assert!(refused.unwrap_err().to_string().contains("leaves the tangent plane"));
    let apart = [height_patch([-2.0, -0.5], [0.0, 2.0], wave)];
    let refused = construct::joined(coons(0.0), [1; 4], &apart, construct::Continuity::Position);
    assert!(refused.unwrap_err().to_string().contains("no edge of neighbour 0"));
}
