//! The triangles of an image by their lengths alone, and their division.

use crate::mesh::split;
use crate::{Error, MetricMesh};
use std::collections::{BTreeMap, BTreeSet};

/// A triangle with the lengths of its sides, the first from the first corner to the second.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub(super) corners: [u32; 3],
    pub(super) lengths: [f64; 3],
}

impl Piece {
    /// The tangents of half the angles at the corners.
    pub(super) fn half_tangents(&self) -> [f64; 3] {
        let half = 0.5 * self.lengths.iter().sum::<f64>();
        // What is left of half the circumference beyond a side is rounded by units of it.
        let beyond = |k: usize| (half - self.lengths[k % 3]).max(0.0);
        let least = half * f64::EPSILON;
        [0, 1, 2].map(|k| {
            // Opposite of a corner lies the side after the next one.
            let (beside, across) = (beyond(k) * beyond(k + 2), beyond(k + 1).max(least));
            (beside / (half * across)).sqrt()
        })
    }

    /// The corners in the plane.
    fn places(&self) -> [[f64; 2]; 3] {
        let [ab, bc, ca] = self.lengths;
        let along = (ab * ab + ca * ca - bc * bc) / (2.0 * ab);
        [[0.0, 0.0], [ab, 0.0], [along, (ca * ca - along * along).max(0.0).sqrt()]]
    }
}

/// The triangles of an image.
pub(super) fn pieces(image: &MetricMesh) -> Result<Vec<Piece>, Error> {
    let mesh = &image.connectivity;
    let mut found = Vec::with_capacity(mesh.triangles().len());
    for first in mesh.half_edges().filter(|half_edge| half_edge.edge() == 0) {
        let sides = [first, first.next(), first.previous()];
        let lengths = sides.map(|side| image.length(side));
        if lengths.iter().any(|length| length.is_nan() || *length <= 0.0) {
            return Err(Error::Unsolvable);
        }
        found.push(Piece { corners: sides.map(|side| mesh.origin(side)), lengths });
    }
    Ok(found)
}

/// The triangles with the given edges divided in their middles, which become vertices from `count` on; and the number of vertices then.
pub(super) fn divided(pieces: Vec<Piece>, count: usize, edges: &BTreeSet<[u32; 2]>) -> (Vec<Piece>, usize) {
    if edges.is_empty() {
        return (pieces, count);
    }
    let first = u32::try_from(count).unwrap_or(u32::MAX);
    let middles: BTreeMap<[u32; 2], u32> = edges.iter().copied().zip(first..).collect();
    let mut found = Vec::with_capacity(pieces.len());
    for piece in pieces {
        let own = [0, 1, 2].map(|k| {
            let [a, b] = [piece.corners[k], piece.corners[(k + 1) % 3]];
            middles.get(&[a.min(b), a.max(b)]).copied()
        });
        if own == [None; 3] {
            found.push(piece);
            continue;
        }
        let places = piece.places();
        let at = |vertex: u32| -> [f64; 2] {
            if let Some(k) = piece.corners.iter().position(|corner| *corner == vertex) {
                return places[k];
            }
            let k = own.iter().position(|middle| *middle == Some(vertex)).unwrap_or(0);
            let [a, b] = [places[k], places[(k + 1) % 3]];
            [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
        };
        let mut parts = Vec::new();
        split(piece.corners, own, &mut parts);
        found.extend(parts.into_iter().map(|corners| Piece {
            corners,
            lengths: [0, 1, 2].map(|k| {
                let [a, b] = [at(corners[k]), at(corners[(k + 1) % 3])];
                (b[0] - a[0]).hypot(b[1] - a[1])
            }),
        }));
    }
    (found, count + middles.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tangents_of_half_angles() {
        let right = Piece { corners: [0, 1, 2], lengths: [4.0, 5.0, 3.0] };
        let [a, b, c] = right.half_tangents();
        assert!((a - 1.0).abs() < 1e-15);
        for (tangent, angle) in [(b, f64::atan2(3.0, 4.0)), (c, f64::atan2(4.0, 3.0))] {
            assert!((tangent - (0.5 * angle).tan()).abs() < 1e-15);
        }
    }

    #[test]
    fn divided_triangles_have_the_same_area() {
        let heron = |p: &Piece| {
            let s = 0.5 * p.lengths.iter().sum::<f64>();
            (s * p.lengths.iter().map(|l| s - l).product::<f64>()).sqrt()
        };
        let whole = Piece { corners: [4, 7, 9], lengths: [3.0, 2.5, 2.0] };
        for edges in [vec![[4, 7]], vec![[4, 7], [7, 9]], vec![[4, 7], [7, 9], [4, 9]]] {
            let (parts, count) = divided(vec![whole], 10, &edges.iter().copied().collect());
            assert_eq!((parts.len(), count), (edges.len() + 1, 10 + edges.len()));
            assert!((parts.iter().map(heron).sum::<f64>() - heron(&whole)).abs() < 1e-12);
        }
    }
}
