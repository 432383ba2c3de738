//! The boundary that a B-spline surface has by itself: its sides, with seams where it is closed and without poles.

use crate::builder;
use brep_core::description::{
    EdgeCurve, EdgeDescription, EdgeUse, LoopDescription, PartDescription,
};
use nalgebra::{Vector2, Vector3};
use nurbs_core::{
    BsplineCurve, BsplineSurface, Direction, Error, Interval, KnotVector, ParametricCurve, ParametricSurface,
};
use std::sync::Arc;

/// Share of the size of the surface within which sides are the same, and within which one is a point.
const SAME: f64 = 1e-9;

/// Edges and vertices of the boundary, and the loop that they make.
#[derive(Clone, Debug)]
pub(crate) struct NaturalBoundary {
    source: u64,
    vertices: Vec<Vector3<f64>>,
    /// Curves with their vertices at start and end.
    edges: Vec<(BsplineCurve<3>, [usize; 2])>,
    /// Edges in the order of the loop, counter-clockwise in the parameters, and whether it runs along them.
    uses: Vec<(usize, bool, BsplineCurve<2>)>,
}

/// The sides of the parameter rectangle in the order of the loop: which parameter is held, at its end or start, and
/// whether the loop runs towards larger values of the other one.
const SIDES: [(Direction, bool, bool); 4] = [
    (Direction::V, false, true),
    (Direction::U, true, true),
    (Direction::V, true, false),
    (Direction::U, false, false),
];

/// The boundary of a surface.
pub(crate) fn boundary(surface: &BsplineSurface, source: u64) -> Result<NaturalBoundary, Error> {
    let sides = SIDES.map(|(held, at_end, _)| side(surface, held, at_end));
    let [bottom, right, top, left] = sides;
    let sides = [bottom?, right?, top?, left?];
    let points = surface.control_points();
    let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
    let small = SAME * size;
    let is_point: [bool; 4] = std::array::from_fn(|i| {
        let points = sides[i].control_points();
        points.iter().all(|p| (p - points[0]).norm() <= small)
    });
    // Opposite sides that are the same curve: a seam.
    let closed = [same(&sides[3], &sides[1], small), same(&sides[0], &sides[2], small)];
    let corners = corners(closed, is_point);
    let mut found = NaturalBoundary { source, vertices: Vec::new(), edges: Vec::new(), uses: Vec::new() };
    let mut numbers = [None; 4];
    let mut vertex = |found: &mut NaturalBoundary, corner: usize| {
        let first = corners[corner];
        *numbers[first].get_or_insert_with(|| {
            found.vertices.push(corner_point(&sides, first));
            found.vertices.len() - 1
        })
    };
    let mut edge_of = [None; 4];
    for (i, (held, at_end, forward)) in SIDES.into_iter().enumerate() {
        if is_point[i] {
            continue;
        }
        let seam = match held {
            Direction::U => closed[0],
            Direction::V => closed[1],
        };
        let twin = (i + 2) % 4;
        let known = edge_of[twin].filter(|_| seam);
        let edge = match known {
            Some(edge) => edge,
            None => {
                // Corners in the direction of growing parameters.
                let ends = if forward { [i, (i + 1) % 4] } else { [(i + 1) % 4, i] };
                let ends = ends.map(|corner| vertex(&mut found, corner));
                found.edges.push((sides[i].clone(), ends));
                found.edges.len() - 1
            }
        };
        edge_of[i] = Some(edge);
        found.uses.push((edge, forward, in_parameters(surface, held, at_end)?));
    }
    Ok(found)
}

/// The corner that stands for each, where seams and poles make several one. Corner `i` is where side `i` begins in the
/// order of the loop.
fn corners(closed: [bool; 2], is_point: [bool; 4]) -> [usize; 4] {
    let mut first = [0, 1, 2, 3];
    let mut join = |a: usize, b: usize| {
        let (low, high) = (first[a].min(first[b]), first[a].max(first[b]));
        for corner in &mut first {
            if *corner == high {
                *corner = low;
            }
        }
    };
    if closed[0] {
        join(0, 1);
        join(3, 2);
    }
    if closed[1] {
        join(0, 3);
        join(1, 2);
    }
    for (i, is_point) in is_point.into_iter().enumerate() {
        if is_point {
            join(i, (i + 1) % 4);
        }
    }
    first
}

/// Where side `corner` begins in the order of the loop.
fn corner_point(sides: &[BsplineCurve<3>; 4], corner: usize) -> Vector3<f64> {
    let (_, _, forward) = SIDES[corner];
    let domain = sides[corner].domain();
    sides[corner].point(if forward { domain.start() } else { domain.end() })
}

fn same(a: &BsplineCurve<3>, b: &BsplineCurve<3>, small: f64) -> bool {
    let near = |(p, q): (&Vector3<f64>, &Vector3<f64>)| (p - q).norm() <= small;
    let weights = |curve: &BsplineCurve<3>, i: usize| curve.weight(i);
    let count = a.control_points().len();
    a.control_points().iter().zip(b.control_points()).all(near)
        && (0..count).all(|i| (weights(a, i) / weights(b, i) - 1.0).abs() <= SAME)
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

impl NaturalBoundary {
    /// Adds vertices, edges and the loop to a part. A surface whose sides are all points has no loop.
    pub(crate) fn add_to(self, part: &mut PartDescription) -> Option<LoopDescription> {
        let (first_vertex, first_edge) = (part.vertices.len(), part.edges.len());
        for point in self.vertices {
            builder::add_vertex(part, point, self.source);
        }
        for (curve, ends) in self.edges {
            let domain = curve.domain();
            let [start, end] = ends.map(|end| Some(first_vertex + end));
            part.edges.push(EdgeDescription {
                source: self.source,
                range: [domain.start(), domain.end()],
                curve: EdgeCurve::Nurbs(Arc::new(curve)),
                start,
                end,
            });
        }
        let uses = self.uses.into_iter().map(|(edge, forward, pcurve)| EdgeUse {
            edge: first_edge + edge,
            forward,
            pcurve: Some(Arc::new(pcurve)),
        });
        Some(LoopDescription::Edges(uses.collect())).filter(|found| *found != LoopDescription::Edges(Vec::new()))
    }
}
