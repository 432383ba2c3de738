//! The proof that no point of a divided patch is nearer, as far as tiles tell.

use super::super::convex::{bend, thirds, valley};
use super::super::{HullScratch, Pending, VALLEYS, facet_height, holds};
use super::{Leaf, NODE, POINTS, TILE, Tile, Tiles, Visit, error_of_points, guess};
use crate::global::arithmetic::simd::vectorized;
use crate::global::gap::Gap;
use crate::global::proof::prove::IMPROVEMENT;
use crate::global::surface::foot::Foot;
use crate::global::surface::geometry::Geometry;
use crate::global::surface::scratch::note_tie;
use nalgebra::Vector3;

/// What a look at a tile says.
enum Finding {
    Dropped,
    Open,
    /// A place of the patch that is nearer than the footpoint.
    Nearer([f64; 2]),
}

impl Geometry {
    /// Shows that no point of a divided patch is nearer than the limit that `gap` sets for `best`, improving `best` where one is, but
    /// for the tiles that are left pending.
    ///
    /// Returns the distance below which there is none where this was not shown, or infinity.
    pub(in crate::global::proof::hulls) fn prove_by_tiles(
        &self,
        tiles: &Tiles,
        x: &Vector3<f64>,
        index: usize,
        best: &mut Foot,
        gap: &Gap,
        hulls: &mut HullScratch,
    ) -> f64 {
        vectorized(
            #[inline(always)]
            || self.prove_by_tiles_inline(tiles, x, index, best, gap, hulls),
        )
    }

    #[inline(always)]
    fn prove_by_tiles_inline(
        &self,
        tiles: &Tiles,
        x: &Vector3<f64>,
        index: usize,
        best: &mut Foot,
        gap: &Gap,
        hulls: &mut HullScratch,
    ) -> f64 {
        let patch = &self.patches[index];
        hulls.pending.clear();
        hulls.left.clear();
        hulls.visits.clear();
        let Some(root) = tiles.root(index) else { return 0.0 };
        let y = x - patch.centre;
        let [p, q] = patch.degrees();
        let error = error_of_points(patch, &y);
        let cost = TILE + u32::try_from((p + 1) * (q + 1) / POINTS).unwrap_or(u32::MAX / 2);
        let floor = |node: u32| (tiles.nodes[node as usize].distance(&y) - error).max(0.0);
        hulls.visits.push(Visit { node: root, floor: floor(root) });
        let mut unresolved = f64::INFINITY;
        while let Some(visit) = hulls.visits.pop() {
            let node = &tiles.nodes[visit.node as usize];
            if visit.floor * visit.floor > gap.reach_sq(best.distance_sq) {
                continue;
            }
            if hulls.boxes_left < cost {
                unresolved = unresolved.min(visit.floor);
                continue;
            }
            if node.next != 0 {
                hulls.boxes_left -= NODE;
                let [a, b] = [node.next, node.next + 1].map(|node| Visit { node, floor: floor(node) });
                // The nearer one first.
                if b.floor < a.floor {
                    hulls.visits.push(a);
                    hulls.visits.push(b);
                } else {
                    hulls.visits.push(b);
                    hulls.visits.push(a);
                }
                continue;
            }
            let leaf = tiles.leaf(visit.node);
            let shift = [y.x - node.centre[0], y.y - node.centre[1], y.z - node.centre[2]];
            let tile = tiles.tile(self, index, &y, visit.node, node.region(), false);
            let mut chase = true;
            loop {
                hulls.boxes_left = hulls.boxes_left.saturating_sub(cost);
                match self.examine_tile(index, &tile, leaf, shift, visit.floor, chase, best, gap, hulls) {
                    Finding::Dropped => break,
                    Finding::Open => {
                        hulls.pending.push(Pending {
                            region: tile.region,
                            floor: visit.floor,
                            tile: visit.node,
                        });
                        break;
                    }
                    Finding::Nearer(place) => {
                        let found = self.descend(x, index, place, 30);
                        best.steps += found.steps;
                        // What is nearer by rounding errors only is not chased again.
                        chase = found.distance_sq < best.distance_sq;
                        if chase {
                            *best = Foot { steps: best.steps, ..found };
                        }
                    }
                }
            }
        }
        // The nearest ones, found first, are examined first.
        hulls.pending.reverse();
        unresolved
    }

    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "the query, the tile and what is known")]
    fn examine_tile(
        &self,
        index: usize,
        tile: &Tile<'_>,
        leaf: &Leaf,
        shift: [f64; 3],
        floor: f64,
        chase: bool,
        best: &Foot,
        gap: &Gap,
        hulls: &mut HullScratch,
    ) -> Finding {
        let limit_sq = gap.limit_sq(best.distance_sq);
        let region = &tile.region;
        let focus = (best.patch == index && holds(region, best.local)).then(|| region.local(best.local));
        let ranges = leaf.ranges(shift);
        let start = focus.unwrap_or_else(|| guess(&ranges));
        if floor * floor >= limit_sq {
            if focus.is_none() && floor * floor <= gap.reach_sq(best.distance_sq) {
                note_tie(&mut hulls.ties, index, region.place(start));
            }
            return Finding::Dropped;
        }
        let way = [ranges.parts[0][0][0], ranges.parts[1][0][0], ranges.parts[2][0][0]];
        let height = 0.5 * (facet_height(&way).max(best.distance_sq) - limit_sq);
        let low = match bend(&ranges, limit_sq, 0.0) {
            Some(bend) if bend.least_loss() <= height => bend.lowest(tile, limit_sq, start),
            Some(bend) if bend.least_loss() <= VALLEYS * height => {
                valley(tile, &thirds(&ranges, &leaf.thirds(), limit_sq), limit_sq, start)
            }
            _ => {
                let place = region.place(start);
                let r = self.point(tile.patch, place[0], place[1]) - tile.y;
                let nearer = chase && r.norm_squared() < best.distance_sq * (1.0 - IMPROVEMENT);
                return if nearer { Finding::Nearer(place) } else { Finding::Open };
            }
        };
        if low.bound >= low.noise {
            if focus.is_none() && low.value <= 0.5 * (gap.reach_sq(best.distance_sq) - limit_sq) {
                note_tie(&mut hulls.ties, index, region.place(low.place));
            }
            return Finding::Dropped;
        }
        let nearer = 2.0 * low.value + limit_sq < best.distance_sq * (1.0 - IMPROVEMENT);
        if chase && low.value < -low.noise && nearer {
            return Finding::Nearer(region.place(low.place));
        }
        Finding::Open
    }
}
