//! Working memory of a search, reused from query to query.

use super::descend::Foot;
use super::geometry::Homogeneous;
use super::hulls::HullScratch;
use super::lanes::Row;
use super::line::Segment;
use super::seeds::Dip;
use super::tree::Visit;

/// A box of the local parameter square of a patch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Region {
    pub(crate) low: [f64; 2],
    pub(crate) high: [f64; 2],
    pub(crate) depth: u32,
    /// Rounding errors of its rows.
    pub(crate) noise: f64,
}

impl Region {
    pub(crate) const UNIT: Self = Self { low: [0.0; 2], high: [1.0; 2], depth: 0, noise: 0.0 };

    /// Parameters of the patch at box parameters.
    #[inline(always)]
    pub(crate) fn place(&self, at: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|d| ((1.0 - at[d]) * self.low[d] + at[d] * self.high[d]).min(1.0))
    }

    /// The box parameters nearest to a place of the patch.
    #[inline(always)]
    pub(crate) fn local(&self, place: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|d| ((place[d] - self.low[d]) / (self.high[d] - self.low[d])).clamp(0.0, 1.0))
    }

    /// Whether the lower or upper side in direction `d` is a side of the patch.
    #[inline(always)]
    pub(crate) fn at_border(&self, d: usize, end: usize) -> bool {
        if end == 0 { self.low[d] == 0.0 } else { self.high[d] == 1.0 }
    }

    /// The two parts below and above the box parameter `at` in direction `d`.
    #[inline(always)]
    pub(crate) fn split(&self, d: usize, at: f64) -> [Self; 2] {
        let mut low = Self { depth: self.depth + 1, ..*self };
        let mut high = low;
        let middle = low.low[d] + at * (low.high[d] - low.low[d]);
        low.high[d] = middle;
        high.low[d] = middle;
        [low, high]
    }
}

/// A patch that may hold a nearer point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    pub(crate) patch: usize,
    /// Squared distance of its box.
    pub(crate) box_sq: f64,
    /// The most likely place of such a point, and its squared distance.
    pub(crate) place: [f64; 2],
    pub(crate) sample_sq: f64,
}

impl Candidate {
    /// Nothing known yet.
    pub(crate) const NONE: Self =
        Self { patch: usize::MAX, box_sq: 0.0, place: [0.0; 2], sample_sq: f64::INFINITY };
}

/// Buffers of one search at a time.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch<const K: usize> {
    pub(crate) visits: Vec<Visit>,
    /// Patches that may hold a nearer point.
    pub(crate) candidates: Vec<Candidate>,
    pub(crate) regions: Vec<Region>,
    /// Boxes that may still be examined for the query at hand.
    pub(crate) boxes_left: u32,
    pub(super) hulls: HullScratch,
    pub(crate) rows: Vec<Row<K>>,
    /// The rows of the box at hand.
    pub(crate) current: Vec<Row<K>>,
    /// Samples of a form, and those of them from which to start.
    pub(crate) grid: Vec<Row<K>>,
    pub(crate) dips: Vec<Dip>,
    pub(crate) segments: Vec<Segment<K>>,
    /// A control net relative to the query.
    pub(crate) net: Vec<Homogeneous>,
    /// Rows with the directions exchanged.
    pub(crate) transposed: Vec<Row<K>>,
    /// How to split rows elsewhere than in the middle.
    pub(crate) splitting: [Vec<Row<K>>; 2],
    /// Places that may be as near as the footpoint.
    pub(crate) ties: Vec<(usize, [f64; 2])>,
    /// Where the iterations from there ended, but for the footpoint.
    pub(crate) rivals: Vec<Foot>,
}

/// Ties remembered per query; one that is apart from the footpoint is enough.
const MAX_TIES: usize = 24;

/// Remembers a place that may be as near as the footpoint.
#[inline(always)]
pub(super) fn note_tie(ties: &mut Vec<(usize, [f64; 2])>, patch: usize, place: [f64; 2]) {
    if ties.len() < MAX_TIES {
        ties.push((patch, place));
    }
}

impl<const K: usize> Scratch<K> {
    #[inline(always)]
    pub(crate) fn note_tie(&mut self, patch: usize, place: [f64; 2]) {
        note_tie(&mut self.ties, patch, place);
    }
}
