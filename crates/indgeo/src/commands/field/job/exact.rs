//! The distance, and the side, of every node for itself.

use super::shape::Shape;
use crate::error::Error;
use crate::runtime::progress::Progress;
use industrial_geometry::distance_field::grid::{Lattice, Seed};

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

/// Makes the distances of nodes inside negative.
pub(super) fn turn_inside<const D: usize, S: Shape<D>>(
    shape: &S,
    lattice: &Lattice<D>,
    values: &mut [f64],
) -> Result<(), Error> {
    for (chunk, values) in values.chunks_mut(CHUNK).enumerate() {
        let first = chunk * CHUNK;
        let points: Vec<_> = (first..first + values.len()).map(|node| lattice.point(node)).collect();
        for (value, is_inside) in values.iter_mut().zip(shape.inside(&points)?) {
            if is_inside {
                *value = -*value;
            }
        }
    }
    Ok(())
}

/// The exact distances of nodes near a shape, or on the faces of the box if there are none.
pub(super) fn seeds_of<const D: usize, S: Shape<D>>(
    shape: &S,
    lattice: &Lattice<D>,
    near: &[Seed],
) -> Result<Vec<Seed>, Error> {
    let counts = lattice.counts();
    let is_on_face = |node: &usize| {
        let indices = lattice.indices(*node);
        (0..D).any(|k| indices[k] == 0 || indices[k] + 1 == counts[k])
    };
    let nodes: Vec<usize> = if near.is_empty() {
        (0..lattice.len()).filter(is_on_face).collect()
    } else {
        near.iter().map(|seed| seed.node).collect()
    };
    let points: Vec<_> = nodes.iter().map(|&node| lattice.point(node)).collect();
    let found = shape.distances(&points, false)?;
    let seed = |(&node, (distance, _)): (&usize, (f64, bool))| Seed { node, distance, element: 0 };
    Ok(nodes.iter().zip(found).map(seed).filter(|seed| seed.distance.is_finite()).collect())
}
