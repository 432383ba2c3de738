//! The grid on which a shape is sampled.

use crate::Error;
use crate::error::check_size;
use nalgebra::Vector3;

/// Cells that are left free around the shape.
const MARGIN: f64 = 2.5;
/// Nodes along the longest side at least and at most.
const NODES: std::ops::RangeInclusive<usize> = 8..=2000;

/// Nodes around a shape.
pub(super) struct Lattice {
    pub(super) origin: Vector3<f64>,
    pub(super) cell: f64,
    pub(super) counts: [usize; 3],
    pub(super) total: usize,
}

impl Lattice {
    /// A grid with some free cells around points, with `nodes` along the longest side of their box; points that are not finite are left
    /// out.
    pub(super) fn around<'a>(
        points: impl Iterator<Item = &'a Vector3<f64>>,
        nodes: usize,
    ) -> Result<Self, Error> {
        if !NODES.contains(&nodes) {
            let what = "it must be from 8 to 2000 nodes along the longest side";
            return Err(Error::Option { option: "grid", value: nodes as f64, what });
        }
        let (low, high) = points
            .filter(|p| p.iter().all(|c| c.is_finite()))
            .fold((Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)), |(low, high), p| {
                (low.inf(p), high.sup(p))
            });
        let sides = high - low;
        let cell = sides.amax() / (nodes as f64 - 1.0 - 2.0 * MARGIN);
        if !(cell.is_finite() && cell > 0.0) {
            return Err(Error::Empty { what: "the shape has no extent".to_owned() });
        }
        let counts: [usize; 3] =
            std::array::from_fn(|k| to_count((sides[k] / cell + 2.0 * MARGIN).ceil() + 1.0));
        let total = check_size(&counts.map(|count| count as u64), || {
            format!("{} x {} x {} nodes", counts[0], counts[1], counts[2])
        })?;
        // Off the middle of the box by a little that no part is made with: nodes on faces of the shape have no side.
        let origin = (low + high) * 0.5
            - Vector3::from_fn(|k, _| (0.5 * (counts[k] - 1) as f64 + 0.012_345 * (k + 1) as f64) * cell);
        Ok(Self { origin, cell, counts, total })
    }

    /// Where a node is.
    pub(super) fn position(&self, node: usize) -> Vector3<f64> {
        let [_, n1, n2] = self.counts;
        let at = [node / (n1 * n2), node / n2 % n1, node % n2];
        self.origin + Vector3::from_fn(|k, _| at[k] as f64 * self.cell)
    }
}

/// A number of nodes.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most a few thousand")]
fn to_count(value: f64) -> usize {
    value as usize
}
