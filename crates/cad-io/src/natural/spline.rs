//! Sides of B-spline surfaces.

use super::{NaturalBoundary, SIDES, Side};
use brep_core::description::EdgeCurve;
use nalgebra::{Vector2, Vector3};
use nurbs_core::{
    BsplineCurve, BsplineSurface, Direction, Error, Interval, KnotVector, ParametricCurve, ParametricSurface,
};
use std::sync::Arc;

/// Share of the size of the surface within which sides are the same, and within which one is a point.
const SAME: f64 = 1e-9;

/// The boundary of a surface.
pub(crate) fn boundary(surface: &BsplineSurface) -> Result<NaturalBoundary, Error> {
    let [bottom, right, top, left] = SIDES.map(|(held, at_end, _)| side(surface, held, at_end));
    let curves = [bottom?, right?, top?, left?];
    let points = surface.control_points();
    let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
    let small = SAME * size;
    // Opposite sides that are the same curve: a seam.
    let closed = [same(&curves[3], &curves[1], small), same(&curves[0], &curves[2], small)];
    let mut sides = Vec::with_capacity(4);
    for (curve, (held, at_end, _)) in curves.into_iter().zip(SIDES) {
        let points = curve.control_points();
        let is_point = points.iter().all(|p| (p - points[0]).norm() <= small);
        let domain = curve.domain();
        sides.push(Side {
            range: [domain.start(), domain.end()],
            is_point,
            pcurve: Some(in_parameters(surface, held, at_end)?),
            curve: EdgeCurve::Nurbs(Arc::new(curve)),
        });
    }
    let sides = <[Side; 4]>::try_from(sides);
    let sides = sides.map_err(|_| Error::Argument { what: "a surface has four sides".to_owned() })?;
    Ok(NaturalBoundary { sides, closed })
}

fn same(a: &BsplineCurve<3>, b: &BsplineCurve<3>, small: f64) -> bool {
    let near = |(p, q): (&Vector3<f64>, &Vector3<f64>)| (p - q).norm() <= small;
    let count = a.control_points().len();
    a.control_points().iter().zip(b.control_points()).all(near)
        && (0..count).all(|i| (a.weight(i) / b.weight(i) - 1.0).abs() <= SAME)
}

/// The curve along one side; its control points are those of the surface where it is clamped there.
fn side(surface: &BsplineSurface, held: Direction, at_end: bool) -> Result<BsplineCurve<3>, Error> {
    let (knots, others) = match held {
        Direction::U => (surface.knots_u(), surface.knots_v()),
        Direction::V => (surface.knots_v(), surface.knots_u()),
    };
    let domain = knots.domain();
    let t = if at_end { domain.end() } else { domain.start() };
    if knots.is_periodic() || others.is_periodic() || knots.multiplicity(t) <= knots.degree() {
        return surface.iso_curve(held, t)?.clamped();
    }
    let row = if at_end { knots.basis_count() - 1 } else { 0 };
    let index = |k: usize| match held {
        Direction::U => row * surface.n_v() + k,
        Direction::V => k * surface.n_v() + row,
    };
    let count = others.basis_count();
    let points = (0..count).map(|k| surface.control_points()[index(k)]).collect();
    let weights = surface.weights().map(|weights| (0..count).map(|k| weights[index(k)]).collect());
    BsplineCurve::new(others.clone(), points, weights)
}

/// A side in the parameters of the surface, by the parameter that runs along it.
fn in_parameters(surface: &BsplineSurface, held: Direction, at_end: bool) -> Result<BsplineCurve<2>, Error> {
    let [u, v] = surface.domain();
    let end = |interval: Interval| if at_end { interval.end() } else { interval.start() };
    let (running, points) = match held {
        Direction::U => (v, [Vector2::new(end(u), v.start()), Vector2::new(end(u), v.end())]),
        Direction::V => (u, [Vector2::new(u.start(), end(v)), Vector2::new(u.end(), end(v))]),
    };
    BsplineCurve::new(KnotVector::bezier(1, running)?, points.to_vec(), None)
}
