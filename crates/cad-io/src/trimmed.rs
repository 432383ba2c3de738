//! Loops in the parameters of a surface as loops of edges.

use crate::builder::{self, Stretch};
use brep_core::description::{EdgeCurve, LoopDescription, PartDescription};
use nalgebra::{Vector2, Vector3};
use nurbs_core::{BsplineCurve, BsplineSurface, Error, KnotVector, ParametricSurface, TrimLoops};
use std::sync::Arc;

/// Distance of an edge from the surface, as a share of its size, and how often a piece is halved for that at most.
const NEAR: f64 = 1e-5;
const HALVED: usize = 8;

/// One edge for each loop, a polygon of degree 1 through points of the surface that begins and ends in one vertex.
pub(crate) fn loops(
    surface: &BsplineSurface,
    trim: &TrimLoops,
    part: &mut PartDescription,
) -> Result<Vec<LoopDescription>, Error> {
    let net = surface.control_points();
    let size = net.iter().map(|p| (p - net[0]).norm()).fold(0.0, f64::max);
    let mut found = Vec::with_capacity(trim.loops().len());
    for vertices in trim.loops() {
        let [u, v] = surface.domain();
        let clamped =
            |p: &[f64; 2]| Vector2::new(p[0].clamp(u.start(), u.end()), p[1].clamp(v.start(), v.end()));
        let mut places = Vec::new();
        for (a, b) in vertices.iter().zip(vertices.iter().cycle().skip(1)) {
            divide(surface, clamped(a), clamped(b), NEAR * size, HALVED, &mut places);
        }
        places.dedup();
        if let Some(&first) = places.first() {
            places.push(first);
        }
        let points: Vec<Vector3<f64>> = places.iter().map(|p| surface.point(p.x, p.y)).collect();
        let count = places.len();
        // Knots at the vertices: one parameter for the edge in space and in the parameters of the surface.
        let inner = (0..count).map(|k| k as f64);
        let last = count.saturating_sub(1) as f64;
        let knots: Vec<f64> = std::iter::once(0.0).chain(inner).chain(std::iter::once(last)).collect();
        let knots = KnotVector::new(1, knots)?;
        let enter = points.first().copied().unwrap_or_else(Vector3::zeros);
        let stretch = Stretch {
            curve: EdgeCurve::Nurbs(Arc::new(BsplineCurve::new(knots.clone(), points, None)?)),
            range: [0.0, last],
            forward: true,
            source: 0,
            enter,
            pcurve: Some(Arc::new(BsplineCurve::new(knots, places, None)?)),
        };
        found.push(builder::add_loop(part, vec![stretch]));
    }
    Ok(found)
}

/// The first end of a segment, and places between that and the other one where the surface leaves the chord.
fn divide(
    surface: &BsplineSurface,
    a: Vector2<f64>,
    b: Vector2<f64>,
    near: f64,
    halved: usize,
    out: &mut Vec<Vector2<f64>>,
) {
    let middle = (a + b) * 0.5;
    let at = |p: &Vector2<f64>| surface.point(p.x, p.y);
    let off = (at(&middle) - (at(&a) + at(&b)) * 0.5).norm();
    if halved == 0 || off.is_nan() || off <= near {
        out.push(a);
        return;
    }
    divide(surface, a, middle, near, halved - 1, out);
    divide(surface, middle, b, near, halved - 1, out);
}
