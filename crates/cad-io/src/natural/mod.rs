//! The boundary that a surface has by itself: the sides of its parameter rectangle, with seams where it is closed and
//! without sides that are points.

mod analytic;
mod spline;

use crate::builder;
use brep_core::description::{EdgeCurve, EdgeDescription, EdgeUse, LoopDescription, PartDescription};
use nalgebra::Vector3;
use nurbs_core::{BsplineCurve, Direction};
use std::sync::Arc;

pub(crate) use analytic::{boundary as of_analytic, carrier};
pub(crate) use spline::boundary as of_spline;

/// The sides of the parameter rectangle in the order of the loop, counter-clockwise: which parameter is held, at its end
/// or start, and whether the loop runs towards larger values of the other one.
const SIDES: [(Direction, bool, bool); 4] = [
    (Direction::V, false, true),
    (Direction::U, true, true),
    (Direction::V, true, false),
    (Direction::U, false, false),
];

/// One side: a curve that runs with growing parameters, or a point.
#[derive(Clone, Debug)]
struct Side {
    curve: EdgeCurve,
    range: [f64; 2],
    is_point: bool,
    /// The side in the parameters of the surface.
    pcurve: Option<BsplineCurve<2>>,
}

/// The four sides, and in which directions the surface is closed.
#[derive(Clone, Debug)]
pub(crate) struct NaturalBoundary {
    sides: [Side; 4],
    closed: [bool; 2],
}

impl NaturalBoundary {
    /// Adds vertices, edges and the loop to a part. A surface whose sides are all points has no loop.
    ///
    /// Seams are one edge that the loop passes along in both directions.
    pub(crate) fn add_to(self, part: &mut PartDescription, source: u64) -> Option<LoopDescription> {
        let corners = self.corners();
        let mut vertices = [None; 4];
        let mut edge_of = [None; 4];
        let mut uses = Vec::with_capacity(4);
        for (i, (held, _, forward)) in SIDES.into_iter().enumerate() {
            let side = &self.sides[i];
            if side.is_point {
                continue;
            }
            let seam = match held {
                Direction::U => self.closed[0],
                Direction::V => self.closed[1],
            };
            let known = edge_of[(i + 2) % 4].filter(|_| seam);
            let edge = known.unwrap_or_else(|| {
                // Corners in the direction of growing parameters.
                let ends = if forward { [i, (i + 1) % 4] } else { [(i + 1) % 4, i] };
                let [start, end] =
                    ends.map(|corner| {
                        let first = corners[corner];
                        let vertex = &mut vertices[first];
                        Some(*vertex.get_or_insert_with(|| {
                            builder::add_vertex(part, self.corner_point(first), source)
                        }))
                    });
                let Side { curve, range, .. } = side.clone();
                part.edges.push(EdgeDescription { source, curve, range, start, end });
                part.edges.len() - 1
            });
            edge_of[i] = Some(edge);
            uses.push(EdgeUse { edge, forward, pcurve: side.pcurve.clone().map(Arc::new) });
        }
        Some(uses).filter(|uses| !uses.is_empty()).map(LoopDescription::Edges)
    }

    /// The corner that stands for each, where seams and poles make several one. Side `i` begins at corner `i` in the
    /// order of the loop.
    fn corners(&self) -> [usize; 4] {
        let mut first = [0, 1, 2, 3];
        let mut join = |a: usize, b: usize| {
            let (low, high) = (first[a].min(first[b]), first[a].max(first[b]));
            for corner in &mut first {
                if *corner == high {
                    *corner = low;
                }
            }
        };
        if self.closed[0] {
            join(0, 1);
            join(3, 2);
        }
        if self.closed[1] {
            join(0, 3);
            join(1, 2);
        }
        for (i, side) in self.sides.iter().enumerate() {
            if side.is_point {
                join(i, (i + 1) % 4);
            }
        }
        first
    }

    fn corner_point(&self, corner: usize) -> Vector3<f64> {
        let (_, _, forward) = SIDES[corner];
        let Side { curve, range, .. } = &self.sides[corner];
        curve.point(if forward { range[0] } else { range[1] })
    }
}
