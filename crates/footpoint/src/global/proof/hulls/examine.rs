//! The search for parts of a patch that may be nearer than the footpoint, by their nets.

use super::bounds::{
    cut_place, derivative_error, direction_of_cut, error_of_cut, facet_height, holds, jets_cost, slack,
    thirds_of,
};
use super::convex::{Net, bend, valley};
use super::graph::{graph, is_slanted};
use super::net::{COMPONENTS, Layout};
use super::plane::{distance_along, facet};
use super::tiles::Tiles;
use super::{HullScratch, NONE, Part, Pending, VALLEYS};
use crate::global::arithmetic::simd::vectorized;
use crate::global::gap::Gap;
use crate::global::proof::prove::IMPROVEMENT;
use crate::global::proof::region::Region;
use crate::global::surface::foot::Foot;
use crate::global::surface::geometry::{Geometry, Patch};
use crate::global::surface::scratch::note_tie;
use nalgebra::Vector3;

/// Cuts after which a part is left as it is.
const MAX_DEPTH: u32 = 160;

/// What a part costs, in units of [`max_boxes`](crate::ProjectionOptions::max_boxes): so much, and one more for so many control points
/// times degrees.
const COST: u32 = 11;
const UNIT: usize = 45;

/// Cuts of a part by its reduced net after which it is left to the net of the patch.
const REDUCED_DEPTH: u32 = 12;

/// What a look at a part says.
enum Finding {
    Dropped,
    /// Open: no point is nearer than this; where to cut.
    Open {
        floor: f64,
        direction: usize,
    },
    /// A place that is nearer than the footpoint.
    Nearer([f64; 2]),
}

/// How the numbers of the nets of a run are to be taken.
#[derive(Clone, Copy)]
enum Source<'a> {
    /// They are those of the patch.
    Patch,
    /// They are approximations on tiles.
    Tiles(&'a Tiles),
}

impl Geometry {
    /// Examines the pending regions by the net of the patch.
    pub(super) fn prove_by_hulls(
        &self,
        x: &Vector3<f64>,
        index: usize,
        best: &mut Foot,
        gap: &Gap,
        hulls: &mut HullScratch,
    ) -> f64 {
        let patch = &self.patches[index];
        let layout = Layout::new(patch.degrees(), patch.rational);
        vectorized(
            #[inline(always)]
            || {
                // Degrees known to the compiler make loops of known lengths.
                if layout == Layout::BICUBIC {
                    self.examine_all(x, index, Layout::BICUBIC, Source::Patch, best, gap, hulls)
                } else {
                    self.examine_all(x, index, layout, Source::Patch, best, gap, hulls)
                }
            },
        )
    }

    /// Examines the pending regions by the nets of their tiles; those for which these are too coarse are left.
    pub(super) fn prove_by_tile_nets(
        &self,
        tiles: &Tiles,
        x: &Vector3<f64>,
        index: usize,
        best: &mut Foot,
        gap: &Gap,
        hulls: &mut HullScratch,
    ) -> f64 {
        let rational = self.patches[index].rational;
        vectorized(
            #[inline(always)]
            || {
                if rational {
                    let layout = const { Layout::reduced(true) };
                    self.examine_all(x, index, layout, Source::Tiles(tiles), best, gap, hulls)
                } else {
                    let layout = const { Layout::reduced(false) };
                    self.examine_all(x, index, layout, Source::Tiles(tiles), best, gap, hulls)
                }
            },
        )
    }

    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "the query, the nets and what is known")]
    fn examine_all(
        &self,
        x: &Vector3<f64>,
        index: usize,
        layout: Layout,
        source: Source<'_>,
        best: &mut Foot,
        gap: &Gap,
        hulls: &mut HullScratch,
    ) -> f64 {
        let patch = &self.patches[index];
        let y = x - patch.centre;
        let length = layout.length();
        let cost =
            COST + u32::try_from(layout.count() * (layout.p + layout.q) / UNIT).unwrap_or(u32::MAX / 2);
        hulls.parts.clear();
        let mut unresolved = f64::INFINITY;
        loop {
            let part = if let Some(part) = hulls.parts.pop() {
                part
            } else if let Some(pending) = hulls.pending.pop() {
                if pending.floor >= gap.limit_sq(best.distance_sq).sqrt() {
                    continue;
                }
                if !self.begin(patch, &y, layout, source, &pending, hulls) {
                    hulls.left.push(pending);
                    continue;
                }
                let [p, q] = patch.degrees();
                let error = error_of_cut(2 * (p + q) + 4, patch, &y);
                let region = Region { depth: 0, ..pending.region };
                Part { region, floor: pending.floor, error, tile: pending.tile }
            } else {
                break;
            };
            let first = hulls.parts.len() * length;
            let mut chase = true;
            loop {
                let limit = gap.limit_sq(best.distance_sq).sqrt();
                if part.floor >= limit {
                    break;
                }
                if matches!(source, Source::Tiles(_)) && part.region.depth >= REDUCED_DEPTH {
                    hulls.left.push(Pending { region: part.region, floor: part.floor, tile: NONE });
                    break;
                }
                if hulls.boxes_left < cost || part.region.depth >= MAX_DEPTH {
                    unresolved = unresolved.min(part.floor);
                    break;
                }
                hulls.boxes_left -= cost;
                hulls.current.clear();
                hulls.current.extend_from_slice(&hulls.nets[first..first + length]);
                match self.examine(x, index, layout, source, &part, chase, best, gap, cost, hulls) {
                    Finding::Dropped => break,
                    Finding::Nearer(place) => {
                        let found = self.descend(x, index, place, 30);
                        best.steps += found.steps;
                        // What is nearer by rounding errors only is not chased again.
                        chase = found.distance_sq < best.distance_sq;
                        if chase {
                            *best = Foot { steps: best.steps, ..found };
                        }
                    }
                    Finding::Open { floor, direction } => {
                        let at = cut_place(&part.region, direction, best, index);
                        let error = part.error + error_of_cut(layout.degree(direction), patch, &y);
                        hulls.nets.resize(first + 2 * length, 0.0);
                        let (low, high) = hulls.nets[first..].split_at_mut(length);
                        layout.cut(low, high, direction, at, &mut hulls.work);
                        for region in part.region.split(direction, at) {
                            hulls.parts.push(Part { region, floor, error, ..part });
                        }
                        break;
                    }
                }
            }
        }
        unresolved
    }

    /// The net of a region, first of all nets; false if there is none that is good enough.
    #[inline(always)]
    fn begin(
        &self,
        patch: &Patch,
        y: &Vector3<f64>,
        layout: Layout,
        source: Source<'_>,
        pending: &Pending,
        hulls: &mut HullScratch,
    ) -> bool {
        let (n, length) = (layout.count(), layout.length());
        hulls.nets.resize(length, 0.0);
        if let Source::Tiles(tiles) = source {
            let Some((net, centre)) = tiles.net(pending.tile, length) else { return false };
            for k in 0..n {
                let w = if layout.components == COMPONENTS { f64::from(net[3 * n + k]) } else { 1.0 };
                for c in 0..3 {
                    hulls.nets[c * n + k] = f64::from(net[c * n + k]) + w * (centre[c] - y[c]);
                }
                if layout.components == COMPONENTS {
                    hulls.nets[3 * n + k] = w;
                }
            }
            return true;
        }
        for (k, c) in self.net(patch).iter().enumerate() {
            let w = c[3];
            hulls.nets[k] = c[0] - w * y.x;
            hulls.nets[n + k] = c[1] - w * y.y;
            hulls.nets[2 * n + k] = c[2] - w * y.z;
            if layout.components == COMPONENTS {
                hulls.nets[3 * n + k] = w;
            }
        }
        let HullScratch { nets, current, work, .. } = hulls;
        layout.restrict(nets, pending.region.low, pending.region.high, current, work);
        true
    }

    /// Looks at one part, whose net is the current one.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "the query, the part and what is known")]
    fn examine(
        &self,
        x: &Vector3<f64>,
        index: usize,
        layout: Layout,
        source: Source<'_>,
        part: &Part,
        chase: bool,
        best: &Foot,
        gap: &Gap,
        cost: u32,
        hulls: &mut HullScratch,
    ) -> Finding {
        let HullScratch { current, work, turned, ties, boxes_left, .. } = hulls;
        let net = &current[..];
        let patch = &self.patches[index];
        let y = x - patch.centre;
        let region = part.region;
        let limit_sq = gap.limit_sq(best.distance_sq);
        let limit = limit_sq.sqrt();
        // How the part differs from what its net tells.
        let reduction = match source {
            Source::Tiles(tiles) => Some((tiles, tiles.reduction(part.tile, &region, &y))),
            Source::Patch => None,
        };
        let error = part.error + reduction.as_ref().map_or(0.0, |(_, (_, distance))| *distance);
        let facet = facet(layout, net);
        let mut floor = part.floor.max(distance_along(layout, net, &facet.nearest) - error);
        let mut normal = facet.nearest;
        if floor < limit {
            let place = region.place(facet.place);
            let r = self.point(patch, place[0], place[1]) - y;
            if chase && r.norm_squared() < best.distance_sq * (1.0 - IMPROVEMENT) {
                return Finding::Nearer(place);
            }
            normal = r.into();
            floor = floor.max(distance_along(layout, net, &normal) - error);
        }
        let focus = (best.patch == index && holds(&region, best.local)).then(|| region.local(best.local));
        if floor >= limit {
            if focus.is_none() && floor * floor <= gap.reach_sq(best.distance_sq) {
                note_tie(ties, index, region.place(facet.place));
            }
            return Finding::Dropped;
        }
        let mut ranges = layout.ranges(net, work);
        if let Some((_, (reduction, _))) = &reduction {
            ranges.widen(reduction);
        }
        let reduction = reduction.map(|(tiles, (reduction, _))| (tiles, reduction));
        // What `g` may lose and still be high enough somewhere.
        let height = 0.5 * (facet_height(&normal).max(best.distance_sq) - limit_sq) * ranges.most_weight_sq();
        let start = focus.unwrap_or(facet.place);
        let tie = 0.5 * (gap.reach_sq(best.distance_sq) - limit_sq) * ranges.most_weight_sq();
        let exact = Net { layout, net, error: part.error };
        let tile = reduction
            .as_ref()
            .map(|(tiles, _)| tiles.tile(self, index, &y, part.tile, region, patch.rational));
        // Jets of the patch cost as much as its degree tells.
        let cost = if tile.is_some() { cost + jets_cost(patch) } else { cost };
        for attempt in 0..2 {
            let low = if attempt == 0 {
                match bend(&ranges, limit_sq, derivative_error(part.error, layout, &ranges)) {
                    Some(bend) if bend.least_loss() <= height => match &tile {
                        Some(tile) => bend.lowest(tile, limit_sq, start),
                        None => bend.lowest(&exact, limit_sq, start),
                    },
                    Some(bend) if bend.least_loss() <= VALLEYS * height => {
                        let thirds = thirds_of(layout, net, work, &ranges, reduction.as_ref(), limit_sq);
                        match &tile {
                            Some(tile) => valley(tile, &thirds, limit_sq, start),
                            None => valley(&exact, &thirds, limit_sq, start),
                        }
                    }
                    _ => continue,
                }
            } else {
                if layout.components == COMPONENTS || !is_slanted(&ranges) {
                    break;
                }
                *boxes_left = boxes_left.saturating_sub(cost);
                let slack = slack(part.error, layout, reduction.as_ref().map(|(_, reduction)| reduction));
                let low = match &tile {
                    Some(tile) => graph(tile, layout, net, slack, limit_sq, start, work, turned),
                    None => graph(&exact, layout, net, slack, limit_sq, start, work, turned),
                };
                match low {
                    Some(low) => low,
                    None => break,
                }
            };
            *boxes_left = boxes_left.saturating_sub(cost);
            if low.bound >= low.noise {
                if focus.is_none() && low.value <= tie {
                    note_tie(ties, index, region.place(low.place));
                }
                return Finding::Dropped;
            }
            let place = region.place(low.place);
            if chase
                && low.value < -low.noise
                && self.distance_sq(x, index, place) < best.distance_sq * (1.0 - IMPROVEMENT)
            {
                return Finding::Nearer(place);
            }
        }
        Finding::Open { floor, direction: direction_of_cut(&ranges, &normal, limit) }
    }
}
