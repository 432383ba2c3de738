//! Random shapes that are awkward: collapsed edges, cusps, loops.

use super::random;
use nalgebra::{SVector, Vector2, Vector3};
use nurbs_core::{BsplineCurve, BsplineSurface, KnotVector};
use proptest::prelude::*;

/// Surfaces of degrees 1 to 5, clamped or periodic, polynomial or rational, some with an edge drawn into a point.
pub(crate) fn surface() -> impl Strategy<Value = BsplineSurface> {
    (random::surface(), 0_usize..8).prop_map(|(surface, edge)| collapsed(surface, edge))
}

/// The surface with its edge `0..4` collapsed; others, and periodic directions, leave it as it is.
fn collapsed(surface: BsplineSurface, edge: usize) -> BsplineSurface {
    let [nu, nv] = [surface.n_u(), surface.n_v()];
    let (direction, end) = (edge / 2, edge % 2);
    let periodic = [surface.knots_u().is_periodic(), surface.knots_v().is_periodic()];
    if edge >= 4 || periodic[direction] {
        return surface;
    }
    let (knots_u, knots_v, mut points, weights) = surface.into_parts();
    let index = |k: usize| if direction == 0 { end * (nu - 1) * nv + k } else { k * nv + end * (nv - 1) };
    let first = points[index(0)];
    for k in 0..if direction == 0 { nv } else { nu } {
        points[index(k)] = first;
    }
    BsplineSurface::new(knots_u, knots_v, points, weights).unwrap()
}

/// Curves in space of degrees 1 to 5, some with a cusp: inner control points drawn together.
pub(crate) fn space_curve() -> impl Strategy<Value = BsplineCurve<3>> {
    (random::curve(), any::<bool>()).prop_map(|(curve, cusp)| {
        let (knots, mut points, weights) = curve.into_parts();
        let last = points.len() - 1;
        if cusp && !knots.is_periodic() && last > 2 {
            points[last / 2 + 1] = points[last / 2];
        }
        BsplineCurve::new(knots, points, weights).unwrap()
    })
}

/// The shadow of a curve in space on a coordinate plane: plane curves, most with crossings.
pub(crate) fn plane_curve() -> impl Strategy<Value = BsplineCurve<2>> {
    space_curve().prop_map(|curve| {
        let (knots, points, weights) = curve.into_parts();
        BsplineCurve::new(knots, points.iter().map(|p| p.xy()).collect(), weights).unwrap()
    })
}

/// Points near and far of shapes whose control points lie within 5 of the origin.
pub(crate) fn query<const D: usize>() -> impl Strategy<Value = SVector<f64, D>> {
    (prop::collection::vec(-6.0..6.0, D), prop_oneof![4 => Just(1.0), 1 => Just(10.0), 1 => Just(0.01)])
        .prop_map(|(x, scale)| SVector::from_column_slice(&x) * scale)
}

/// The rectangle `[0, a] × [0, b]` at height `z`.
pub(crate) fn rectangle(a: f64, b: f64, z: f64) -> BsplineSurface {
    let line = KnotVector::uniform_clamped(1, 2).unwrap();
    let corners = vec![
        Vector3::new(0.0, 0.0, z),
        Vector3::new(0.0, b, z),
        Vector3::new(a, 0.0, z),
        Vector3::new(a, b, z),
    ];
    BsplineSurface::new(line.clone(), line, corners, None).unwrap()
}

/// The parabola `y = x²` over `[−1, 1]`.
pub(crate) fn parabola() -> BsplineCurve<2> {
    let points = vec![Vector2::new(-1.0, 1.0), Vector2::new(0.0, -1.0), Vector2::new(1.0, 1.0)];
    BsplineCurve::bezier(points, None).unwrap()
}
