//! Parts that are put together from faces, loops and edges.

use brep_core::description::{
    EdgeCurve, EdgeDescription, EdgeUse, LoopDescription, PartDescription, VertexDescription,
};
use nalgebra::Vector3;
use nurbs_core::BsplineCurve;
use std::sync::Arc;

/// A curve as the next stretch of a loop.
#[derive(Clone, Debug)]
pub(crate) struct Stretch {
    /// The curve.
    pub(crate) curve: EdgeCurve,
    /// Parameters of start and end, increasing.
    pub(crate) range: [f64; 2],
    /// The loop runs from the start to the end.
    pub(crate) forward: bool,
    /// Number of the entity.
    pub(crate) source: u64,
    /// Point where the loop enters the stretch.
    pub(crate) enter: Vector3<f64>,
    /// The stretch in the parameters of the surface, in the direction of the edge.
    pub(crate) pcurve: Option<Arc<BsplineCurve<2>>>,
}

/// Adds a vertex to a part.
pub(crate) fn add_vertex(part: &mut PartDescription, point: Vector3<f64>, source: u64) -> usize {
    part.vertices.push(VertexDescription { source, point });
    part.vertices.len() - 1
}

/// Adds a loop with edges and vertices of its own.
pub(crate) fn add_loop(part: &mut PartDescription, stretches: Vec<Stretch>) -> LoopDescription {
    let first = part.vertices.len();
    let count = stretches.len();
    for stretch in &stretches {
        add_vertex(part, stretch.enter, stretch.source);
    }
    let uses = stretches.into_iter().enumerate().map(|(i, stretch)| {
        let (enter, leave) = (first + i, first + (i + 1) % count);
        let (start, end) = if stretch.forward { (enter, leave) } else { (leave, enter) };
        part.edges.push(EdgeDescription {
            source: stretch.source,
            curve: stretch.curve,
            range: stretch.range,
            start: Some(start),
            end: Some(end),
        });
        EdgeUse { edge: part.edges.len() - 1, forward: stretch.forward, pcurve: stretch.pcurve }
    });
    LoopDescription::Edges(uses.collect())
}
