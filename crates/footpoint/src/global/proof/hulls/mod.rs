//! Lower bounds by control nets: for patches that the proof by coefficients of the squared distance does not settle soon.
//!
//! Those coefficients grow with the square of the slope of a patch, and with its degree. What counts is the shape: the points of a
//! part lie in the convex hull of its control points, however uneven the parameters are. A part is dropped when
//! - a plane separates its control points from the ball that is to be empty (see [`plane`]);
//! - the squared distance is convex on it, or nearly so, or has a valley on it, and is not low enough anywhere (see [`convex`]);
//!
//! and is cut in two otherwise, across the direction in which it bends more. Everything is computed from differences to the
//! query, so that rounding errors shrink with the distance.

mod bounds;
mod convex;
mod examine;
mod graph;
mod net;
mod plane;
pub(crate) mod scratch;
pub(crate) mod tiles;

use crate::global::gap::Gap;
use crate::global::surface::foot::Foot;
use crate::global::surface::geometry::Geometry;
use crate::global::surface::patch::PatchSet;
use crate::global::surface::scratch::Scratch;
use bounds::{error_of_cut, facet_height, holds};
use nalgebra::Vector3;
use net::Layout;
use scratch::{HullScratch, Part, Pending};

/// So many times as far from convex as what convexity settles, a part may have a valley.
const VALLEYS: f64 = 64.0;

/// No tile.
const NONE: u32 = u32::MAX;

impl<const K: usize> PatchSet<K> {
    /// Shows that no point of the regions of a patch that are left in `scratch` is nearer than the limit that `gap` sets for `best`,
    /// improving `best` where one is.
    ///
    /// Returns the distance below which there is none where this was not shown, or infinity.
    pub(in crate::global) fn prove_by_hulls(
        &self,
        x: &Vector3<f64>,
        index: usize,
        best: &mut Foot,
        gap: &Gap,
        scratch: &mut Scratch<K>,
    ) -> f64 {
        let mut hulls = enter(scratch);
        hulls.pending.clear();
        let pending = scratch.regions.drain(..).map(|region| Pending { region, floor: 0.0, tile: NONE });
        hulls.pending.extend(pending);
        let unresolved = Geometry::prove_by_hulls(self, x, index, best, gap, &mut hulls);
        leave(hulls, scratch);
        unresolved
    }

    /// The same for the whole of a patch that is divided.
    pub(in crate::global) fn prove_divided(
        &self,
        x: &Vector3<f64>,
        index: usize,
        best: &mut Foot,
        gap: &Gap,
        scratch: &mut Scratch<K>,
    ) -> f64 {
        let mut hulls = enter(scratch);
        let unresolved = self.prove_by_tiles(self.tiles(), x, index, best, gap, &mut hulls);
        let mut unresolved = unresolved;
        let patch = &self.patches[index];
        if Layout::new(patch.degrees(), patch.rational) != Layout::BICUBIC {
            unresolved =
                unresolved.min(self.prove_by_tile_nets(self.tiles(), x, index, best, gap, &mut hulls));
            let HullScratch { left, pending, .. } = &mut hulls;
            std::mem::swap(left, pending);
            pending.reverse();
        }
        unresolved = unresolved.min(Geometry::prove_by_hulls(self, x, index, best, gap, &mut hulls));
        leave(hulls, scratch);
        unresolved
    }
}

/// The buffers, with what is common to all proofs.
fn enter<const K: usize>(scratch: &mut Scratch<K>) -> HullScratch {
    let mut hulls = std::mem::take(&mut scratch.hulls);
    std::mem::swap(&mut hulls.ties, &mut scratch.ties);
    hulls.boxes_left = scratch.boxes_left;
    hulls
}

fn leave<const K: usize>(mut hulls: HullScratch, scratch: &mut Scratch<K>) {
    std::mem::swap(&mut hulls.ties, &mut scratch.ties);
    scratch.boxes_left = hulls.boxes_left;
    scratch.hulls = hulls;
}
