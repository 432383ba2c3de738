//! Working memory of a search, reused from query to query.

use super::lanes::Row;
use super::line::Segment;
use super::tree::Visit;

/// A box of the local parameter square of a patch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Region {
    start: [f64; 2],
    length: [f64; 2],
    pub(crate) depth: u32,
}

impl Region {
    pub(crate) const UNIT: Self = Self { start: [0.0; 2], length: [1.0; 2], depth: 0 };

    /// Parameters of the patch at box parameters.
    #[inline(always)]
    pub(crate) fn place(&self, at: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|d| (self.start[d] + at[d] * self.length[d]).min(1.0))
    }

    /// The box parameters nearest to a place of the patch.
    #[inline(always)]
    pub(crate) fn local(&self, place: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|d| ((place[d] - self.start[d]) / self.length[d]).max(0.0).min(1.0))
    }

    /// Whether the lower or upper side in direction `d` is a side of the patch.
    #[inline(always)]
    pub(crate) fn at_border(&self, d: usize, end: usize) -> bool {
        // Halving is exact in binary arithmetic.
        if end == 0 { self.start[d] == 0.0 } else { self.start[d] + self.length[d] == 1.0 }
    }

    #[inline(always)]
    pub(crate) fn halves(&self, d: usize) -> [Self; 2] {
        let mut low = Self { depth: self.depth + 1, ..*self };
        low.length[d] *= 0.5;
        let mut high = low;
        high.start[d] += low.length[d];
        [low, high]
    }
}

/// Buffers of one search at a time.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch<const K: usize> {
    pub(crate) visits: Vec<Visit>,
    /// Patches that may hold a nearer point, with the squared distance of their boxes.
    pub(crate) candidates: Vec<(usize, f64)>,
    pub(crate) regions: Vec<Region>,
    pub(crate) rows: Vec<Row<K>>,
    /// The rows of the box at hand.
    pub(crate) current: Vec<Row<K>>,
    pub(crate) segments: Vec<Segment<K>>,
    /// Places that may be as near as the footpoint.
    pub(crate) ties: Vec<(usize, [f64; 2])>,
}

/// Ties remembered per query; one that is apart from the footpoint is enough.
const MAX_TIES: usize = 24;

impl<const K: usize> Scratch<K> {
    #[inline(always)]
    pub(crate) fn note_tie(&mut self, patch: usize, place: [f64; 2]) {
        if self.ties.len() < MAX_TIES {
            self.ties.push((patch, place));
        }
    }
}
