//! Working memory of a search, reused from query to query.

use crate::global::arithmetic::homogeneous::Homogeneous;
use crate::global::arithmetic::lanes::Row;
use crate::global::proof::hulls::scratch::HullScratch;
use crate::global::proof::line::Segment;
use crate::global::proof::region::Region;
use crate::global::surface::foot::Foot;
use crate::global::surface::sampling::Dip;
use crate::global::tree::Visit;

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
    pub(in crate::global) hulls: HullScratch,
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
pub(in crate::global) fn note_tie(ties: &mut Vec<(usize, [f64; 2])>, patch: usize, place: [f64; 2]) {
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
