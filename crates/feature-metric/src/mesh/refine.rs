//! Refinement of an image where the normals of neighbours differ much.

use super::fillets::{Image, Place};
use crate::Error;
use std::collections::BTreeMap;

/// Largest difference of the normals of neighbours, `2 sin 7.5°`: a chord of the unit sphere is then too short by .3 %.
const MOST: f64 = 0.261;
/// Rounds of splitting: each halves the differences.
const ROUNDS: usize = 8;
/// Most vertices.
const LIMIT: usize = 8_000_000;

impl Image {
    /// Splits edges between normals that differ much.
    ///
    /// # Errors
    /// [`Error::TooLarge`].
    pub(crate) fn refine(&mut self) -> Result<(), Error> {
        for _ in 0..ROUNDS {
            let mut middles: BTreeMap<[u32; 2], u32> = BTreeMap::new();
            let mut triangles = Vec::with_capacity(self.triangles.len());
            for triangle in std::mem::take(&mut self.triangles) {
                let [a, b, c] = triangle;
                let middle = [[a, b], [b, c], [c, a]].map(|edge| self.middle(edge, &mut middles));
                split(triangle, middle, &mut triangles);
            }
            self.triangles = triangles;
            if middles.is_empty() {
                break;
            }
            if self.places.len() > LIMIT {
                return Err(Error::TooLarge { most: LIMIT });
            }
        }
        Ok(())
    }

    /// The place in the middle of an edge, if it is to be split.
    fn middle(&mut self, [a, b]: [u32; 2], middles: &mut BTreeMap<[u32; 2], u32>) -> Option<u32> {
        let [one, other] = [a, b].map(|index| self.places[index as usize]);
        if (one.normal - other.normal).norm() <= MOST {
            return None;
        }
        let sum = one.normal + other.normal;
        // Opposite normals have no middle.
        if sum.norm() < 1e-6 {
            return None;
        }
        Some(*middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            let index = u32::try_from(self.places.len()).unwrap_or(u32::MAX);
            let point = nalgebra::center(&one.point, &other.point);
            self.places.push(Place { point, normal: sum.normalize() });
            index
        }))
    }
}

/// The parts of a triangle some of whose edges have middles.
pub(crate) fn split(triangle: [u32; 3], middles: [Option<u32>; 3], out: &mut Vec<[u32; 3]>) {
    // Turned so that the first edge is split, and the last one is not unless all are.
    for turn in 0..3 {
        let at = |k: usize| triangle[(turn + k) % 3];
        let [a, b, c] = [at(0), at(1), at(2)];
        match [0, 1, 2].map(|k| middles[(turn + k) % 3]) {
            [None, None, None] => return out.push(triangle),
            [Some(ab), Some(bc), Some(ca)] => {
                return out.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
            }
            [Some(ab), Some(bc), None] => return out.extend([[ab, b, bc], [a, ab, c], [ab, bc, c]]),
            [Some(ab), None, None] => return out.extend([[a, ab, c], [ab, b, c]]),
            _ => {}
        }
    }
}
