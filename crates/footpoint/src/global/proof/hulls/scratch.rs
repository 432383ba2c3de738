//! Buffers of the proof by control nets.

use super::tiles;
use crate::global::proof::region::Region;

/// A part of a patch that is still to be examined.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    pub(super) region: Region,
    /// No point of it is nearer than this.
    pub(super) floor: f64,
    /// Error of its control points, per unit of weight.
    pub(super) error: f64,
    /// The tile that it is part of, if the net is that of a tile.
    pub(super) tile: u32,
}

/// A region to be examined.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pending {
    pub(super) region: Region,
    /// No point of it is nearer than this.
    pub(super) floor: f64,
    /// The tile that it is, if it is one.
    pub(super) tile: u32,
}

/// Buffers of this proof.
#[derive(Clone, Debug, Default)]
pub(crate) struct HullScratch {
    /// Regions to be examined, the last one first.
    pub(super) pending: Vec<Pending>,
    /// Those that a first look left open.
    pub(super) left: Vec<Pending>,
    pub(super) parts: Vec<Part>,
    /// Their nets, one after the other.
    pub(super) nets: Vec<f64>,
    /// The net of the part at hand, and a buffer.
    pub(super) current: Vec<f64>,
    pub(super) work: Vec<f64>,
    /// The same net along other axes.
    pub(super) turned: Vec<f64>,
    /// Nodes of tiles to be looked at.
    pub(super) visits: Vec<tiles::Visit>,
    /// As in [`Scratch`], to which these are given back.
    pub(super) ties: Vec<(usize, [f64; 2])>,
    pub(super) boxes_left: u32,
}
