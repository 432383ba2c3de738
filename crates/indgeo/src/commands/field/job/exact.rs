//! The distance of every node for itself.

use super::shape::Shape;
use crate::error::Error;
use crate::runtime::progress::Progress;
use industrial_geometry::distance_field::grid::Lattice;

/// Nodes at a time.
const CHUNK: usize = 1 << 15;

/// Distances at the nodes, and how many of them are not proven or were not found.
pub(super) fn distances<const D: usize, S: Shape<D>>(
    shape: &S,
    lattice: &Lattice<D>,
    signed: bool,
    progress: &Progress,
) -> Result<(Vec<f64>, usize), Error> {
    let nodes = lattice.len();
    let mut values = Vec::with_capacity(nodes);
    let mut not_proven = 0;
    while values.len() < nodes {
        let chunk: Vec<_> =
            (values.len()..nodes.min(values.len() + CHUNK)).map(|node| lattice.point(node)).collect();
        for (value, is_proven) in shape.distances(&chunk, signed)? {
            values.push(value);
            not_proven += usize::from(!is_proven);
        }
        let _ = progress.report(values.len(), nodes);
    }
    Ok((values, not_proven))
}
