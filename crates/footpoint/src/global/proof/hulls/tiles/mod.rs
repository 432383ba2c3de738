//! Patches of high degree, steep ones and those of unequal weights, divided beforehand.
//!
//! Each such patch is a tree of parts with a box along its tangents around each. The parts at its ends, the tiles, are so small that
//! their first derivatives change little, as far as the number of tiles allows; the ranges of the derivatives of the surface on
//! each are kept. For a query a tile is dropped when its box is too far away, or when the squared distance is convex on it, or has a
//! valley on it, and is not low enough anywhere (see [`convex`](super::convex)): whatever the degree, that takes a few operations
//! and a jet. What is left goes to the control nets.

mod build;
mod prove;
mod reduce;
mod span;
#[cfg(test)]
mod tests;

use super::convex::{Jets, noise};
use super::error_of_cut;
#[cfg(test)]
use super::net::Layout;
use super::net::{COMPONENTS, Ranges, Reduction};
use crate::global::arithmetic::homogeneous::Homogeneous;
use crate::global::proof::region::Region;
use crate::global::surface::geometry::{Geometry, Patch};
use crate::global::surface::patch::PatchSet;
use nalgebra::Vector3;

/// What a node and a tile cost, in units of [`max_boxes`](crate::ProjectionOptions::max_boxes), and how many control points add one
/// to the latter.
const NODE: u32 = 1;
const TILE: u32 = 8;
const POINTS: usize = 9;

/// A part of a patch.
#[derive(Clone, Debug)]
struct Node {
    /// A box around it, relative to the centre of the patch: its middle, unit vectors along its sides, half of their lengths.
    centre: [f64; 3],
    axes: [[f64; 3]; 3],
    half: [f64; 3],
    /// The part of the patch: halves of halves, which numbers of half the length hold.
    low: [f32; 2],
    high: [f32; 2],
    /// The first of its two halves, or 0.
    next: u32,
    /// Where there are none: what is known about it.
    leaf: u32,
}

/// What is known about a tile, in parameters between 0 and 1.
#[derive(Clone, Debug)]
struct Leaf {
    /// By component: middle and half of the length of the ranges of the point, relative to the middle of the box, and of its
    /// derivatives `u`, `v`, `uu`, `uv`, `vv`, `uuu`, `uuv`, `uvv`, `vvv`.
    spans: [[[f32; 2]; 10]; 3],
    /// Rounding errors of value and derivatives, in such of the value.
    sums: f32,
    /// How much the derivatives of orders 0 to 3 differ from those that the net tells: coordinates times weights, and weights.
    reduction: [[f32; 4]; 2],
    /// Bound of the weights from below.
    least: f32,
    /// Where the net begins, or `u32::MAX` if none is good enough.
    net: u32,
}

/// The divided patches of a model.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tiles {
    /// By patch: its first node, or `u32::MAX`; empty if no patch is divided.
    roots: Vec<u32>,
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
    /// Nets of tiles, of degree 5, relative to the middle of the box; none for bicubic patches.
    nets: Vec<f32>,
}

/// A part that is to be looked at, and how far it is at least.
#[derive(Clone, Copy, Debug)]
pub(super) struct Visit {
    node: u32,
    floor: f64,
}

impl Tiles {
    /// The first node of a patch, if it is divided.
    #[inline(always)]
    fn root(&self, patch: usize) -> Option<u32> {
        self.roots.get(patch).copied().filter(|&root| root != u32::MAX)
    }

    #[inline(always)]
    fn leaf(&self, node: u32) -> &Leaf {
        &self.leaves[self.nodes[node as usize].leaf as usize]
    }

    /// The net of a tile and what it is relative to, from the centre of the patch, if there is one that is good enough.
    #[inline(always)]
    pub(super) fn net(&self, node: u32, length: usize) -> Option<(&[f32], [f64; 3])> {
        if node == super::NONE {
            return None;
        }
        let net = self.nets.get(self.leaf(node).net as usize..)?.get(..length)?;
        Some((net, self.nodes[node as usize].centre))
    }

    /// How much a part of a tile, seen from a query at `y` from the centre of the patch, differs from what the net of the tile tells;
    /// and how much the points do.
    #[inline(always)]
    pub(super) fn reduction(&self, node: u32, region: &Region, y: &Vector3<f64>) -> (Reduction, f64) {
        let tile = &self.nodes[node as usize];
        let leaf = self.leaf(node);
        let side =
            |d: usize| (region.high[d] - region.low[d]) / (f64::from(tile.high[d]) - f64::from(tile.low[d]));
        let (a, b) = (side(0), side(1));
        let r = [y.x - tile.centre[0], y.y - tile.centre[1], y.z - tile.centre[2]];
        let reach = ((r[0] * r[0] + r[1] * r[1]) + r[2] * r[2]).sqrt();
        let factors = [1.0, a, b, a * a, a * b, b * b, a * a * a, a * a * b, a * b * b, b * b * b];
        let mut reduction = [[0.0; 10]; 2];
        for k in 0..10 {
            let order = [0, 1, 1, 2, 2, 2, 3, 3, 3, 3][k];
            let weight = f64::from(leaf.reduction[1][order]);
            // Coordinates are taken from the query, times weights.
            reduction[0][k] = (f64::from(leaf.reduction[0][order]) + reach * weight) * factors[k];
            reduction[1][k] = weight * factors[k];
        }
        // A quotient is off by what numerator and denominator are, the latter times the quotient.
        let [h, k, l] = tile.half;
        let farthest = reach + 2.0 * ((h * h + k * k) + l * l).sqrt();
        let distance = (reduction[0][0] + farthest * reduction[1][0]) / f64::from(leaf.least);
        (reduction, distance)
    }

    /// A region of a tile, to be evaluated for a query at `y` from the centre of the patch.
    #[inline(always)]
    pub(super) fn tile<'a>(
        &self,
        set: &'a Geometry,
        index: usize,
        y: &Vector3<f64>,
        node: u32,
        region: Region,
        homogeneous: bool,
    ) -> Tile<'a> {
        let patch = &set.patches[index];
        Tile {
            set,
            patch,
            y: *y,
            region,
            error: error_of_points(patch, y),
            sums: f64::from(self.leaf(node).sums),
            homogeneous,
        }
    }

    /// Bytes held.
    pub(crate) fn memory(&self) -> usize {
        size_of_val(&self.roots[..])
            + size_of_val(&self.nodes[..])
            + size_of_val(&self.leaves[..])
            + size_of_val(&self.nets[..])
    }
}

impl Node {
    /// How far from a place, relative to the centre of the patch, the box is.
    #[inline(always)]
    fn distance(&self, y: &Vector3<f64>) -> f64 {
        let r = [y.x - self.centre[0], y.y - self.centre[1], y.z - self.centre[2]];
        let mut sum = 0.0;
        for k in 0..3 {
            let axis = &self.axes[k];
            let beyond = ((axis[0] * r[0] + axis[1] * r[1]) + axis[2] * r[2]).abs() - self.half[k];
            let beyond = if beyond > 0.0 { beyond } else { 0.0 };
            sum += beyond * beyond;
        }
        // The axes are at right angles, and of length 1, up to rounding errors.
        sum.sqrt() * (1.0 - 32.0 * f64::EPSILON)
    }

    #[inline(always)]
    fn region(&self) -> Region {
        Region { low: self.low.map(f64::from), high: self.high.map(f64::from), ..Region::UNIT }
    }
}

/// Rounding errors of the points of a patch.
#[inline(always)]
fn error_of_points(patch: &Patch, y: &Vector3<f64>) -> f64 {
    let [p, q] = patch.degrees();
    // In powers, the larger weights make errors where the smaller ones count.
    let spread = if patch.order() > 0 { (patch.max_weight_sq / patch.min_weight_sq).sqrt() } else { 1.0 };
    error_of_cut(4 * (p + q) + 16, patch, y) * spread
}

/// A region of a tile and one query.
pub(super) struct Tile<'a> {
    set: &'a Geometry,
    patch: &'a Patch,
    y: Vector3<f64>,
    region: Region,
    /// Error of points.
    error: f64,
    sums: f64,
    /// Whether coordinates are wanted times weights, and these.
    homogeneous: bool,
}

impl Jets for Tile<'_> {
    #[inline(always)]
    fn jet(&self, place: [f64; 2]) -> [Homogeneous; 6] {
        let [s, t] = self.region.place(place);
        let [a, b] = [0, 1].map(|d| self.region.high[d] - self.region.low[d]);
        if self.homogeneous {
            let mut jet = self.set.homogeneous_jet(self.patch, s, t);
            for (part, factor) in jet.iter_mut().zip([1.0, a, b, a * a, a * b, b * b]) {
                let w = part[3];
                for c in 0..3 {
                    part[c] = (part[c] - w * self.y[c]) * factor;
                }
                part[3] = w * factor;
            }
            return jet;
        }
        let jet = self.set.jet(self.patch, s, t);
        let r = jet.point - self.y;
        let scaled = |d: &Vector3<f64>, factor: f64| [d.x * factor, d.y * factor, d.z * factor, 0.0];
        [
            [r.x, r.y, r.z, 1.0],
            scaled(&jet.du, a),
            scaled(&jet.dv, b),
            scaled(&jet.duu, a * a),
            scaled(&jet.duv, a * b),
            scaled(&jet.dvv, b * b),
        ]
    }

    #[inline(always)]
    fn noise(&self, jet: &[Homogeneous; 6], limit_sq: f64, _: i32) -> f64 {
        noise(jet, limit_sq, self.error, self.sums)
    }
}

impl Leaf {
    /// The ranges of the way from the query, which is at `shift` from the middle of the box, and of its derivatives.
    #[inline(always)]
    fn ranges(&self, shift: [f64; 3]) -> Ranges {
        let mut parts = [[[0.0; 2]; 6]; COMPONENTS];
        for c in 0..3 {
            for k in 0..6 {
                parts[c][k] = [f64::from(self.spans[c][k][0]), f64::from(self.spans[c][k][1])];
            }
            parts[c][0][0] -= shift[c];
        }
        parts[3][0][0] = 1.0;
        Ranges { parts }
    }

    #[inline(always)]
    fn thirds(&self) -> [[[f64; 2]; 4]; COMPONENTS] {
        let mut thirds = [[[0.0; 2]; 4]; COMPONENTS];
        for c in 0..3 {
            for k in 0..4 {
                thirds[c][k] = [f64::from(self.spans[c][6 + k][0]), f64::from(self.spans[c][6 + k][1])];
            }
        }
        thirds
    }
}

/// Where a tile would be nearest if it were its tangent plane.
#[inline(always)]
fn guess(ranges: &Ranges) -> [f64; 2] {
    let of = |k: usize| [ranges.parts[0][k][0], ranges.parts[1][k][0], ranges.parts[2][k][0]];
    let (r, u, v) = (of(0), of(1), of(2));
    let dot = |a: [f64; 3], b: [f64; 3]| (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
    let (a, c, b) = (dot(u, u), dot(u, v), dot(v, v));
    let slope = [dot(u, r), dot(v, r)];
    let det = a * b - c * c;
    let step = [(c * slope[1] - b * slope[0]) / det, (c * slope[0] - a * slope[1]) / det];
    [0, 1].map(|d| if step[d].is_nan() { 0.5 } else { (0.5 + step[d]).clamp(0.0, 1.0) })
}

impl<const K: usize> PatchSet<K> {
    /// Whether a patch is divided.
    #[inline(always)]
    pub(crate) fn is_tiled(&self, index: usize) -> bool {
        self.tiles().root(index).is_some()
    }

    /// A place of a divided patch near the query, unless all of it is as far as a limit.
    pub(crate) fn promising_tile(&self, x: &Vector3<f64>, index: usize, limit: f64) -> Option<[f64; 2]> {
        let tiles = self.tiles();
        let patch = &self.patches[index];
        let y = x - patch.centre;
        let mut node = &tiles.nodes[tiles.root(index)? as usize];
        if node.distance(&y) > limit {
            return None;
        }
        while node.next != 0 {
            let [a, b] = [0, 1].map(|k| &tiles.nodes[node.next as usize + k]);
            node = if b.distance(&y) < a.distance(&y) { b } else { a };
        }
        let leaf = tiles.leaves.get(node.leaf as usize)?;
        let shift = [y.x - node.centre[0], y.y - node.centre[1], y.z - node.centre[2]];
        Some(node.region().place(guess(&leaf.ranges(shift))))
    }
}
