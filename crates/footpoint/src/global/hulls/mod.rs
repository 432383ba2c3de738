//! Lower bounds by control nets: for patches that the proof by coefficients of the squared distance does not settle soon.
//!
//! Those coefficients grow with the square of the slope of a patch, and with its degree. What counts is the shape: the points of a
//! part lie in the convex hull of its control points, however uneven the parameters are. A part is dropped when
//! - a plane separates its control points from the ball that is to be empty (see [`plane`]);
//! - the squared distance is convex on it, or nearly so, or has a valley on it, and is not low enough anywhere (see [`convex`]);
//!
//! and is cut in two otherwise, across the direction in which it bends more. Everything is computed from differences to the
//! query, so that rounding errors shrink with the distance.

mod convex;
mod graph;
mod net;
mod plane;
pub(crate) mod tiles;

use super::descend::Foot;
use super::gap::Gap;
use super::geometry::{Geometry, Patch};
use super::patch::PatchSet;
use super::prove::IMPROVEMENT;
use super::scratch::{Region, Scratch, note_tie};
use super::simd::vectorized;
use convex::{Net, bend, thirds, valley};
use graph::{graph, is_slanted};
use nalgebra::Vector3;
use net::{COMPONENTS, Layout, Ranges, Reduction, widen_thirds};
use plane::{distance_along, facet};
use tiles::Tiles;

/// Cuts after which a part is left as it is.
const MAX_DEPTH: u32 = 160;

/// Cuts beside the footpoint keep it away from the other part by this share.
const MARGIN: f64 = 0.25;

/// So many times as far from convex as what convexity settles, a part may have a valley.
const VALLEYS: f64 = 64.0;

/// How much a bend along the shape counts beside one away from it, when it is decided where to cut.
const SIDEWAYS: f64 = 0.05;

/// What a part costs, in units of [`max_boxes`](crate::ProjectionOptions::max_boxes): so much, and one more for so many control points
/// times degrees.
const COST: u32 = 11;
const UNIT: usize = 45;

/// A few jets cost one for so many control points.
const JETS: usize = 6;

/// Cuts of a part by its reduced net after which it is left to the net of the patch.
const REDUCED_DEPTH: u32 = 12;

/// A region to be examined.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pending {
    region: Region,
    /// No point of it is nearer than this.
    floor: f64,
    /// The tile that it is, if it is one.
    tile: u32,
}

/// No tile.
const NONE: u32 = u32::MAX;

/// A part of a patch that is still to be examined.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    region: Region,
    /// No point of it is nearer than this.
    floor: f64,
    /// Error of its control points, per unit of weight.
    error: f64,
    /// The tile that it is part of, if the net is that of a tile.
    tile: u32,
}

/// Buffers of this proof.
#[derive(Clone, Debug, Default)]
pub(crate) struct HullScratch {
    /// Regions to be examined, the last one first.
    pending: Vec<Pending>,
    /// Those that a first look left open.
    left: Vec<Pending>,
    parts: Vec<Part>,
    /// Their nets, one after the other.
    nets: Vec<f64>,
    /// The net of the part at hand, and a buffer.
    current: Vec<f64>,
    work: Vec<f64>,
    /// The same net along other axes.
    turned: Vec<f64>,
    /// Nodes of tiles to be looked at.
    visits: Vec<tiles::Visit>,
    /// As in [`Scratch`], to which these are given back.
    ties: Vec<(usize, [f64; 2])>,
    boxes_left: u32,
}

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

impl<const K: usize> PatchSet<K> {
    /// Shows that no point of the regions of a patch that are left in `scratch` is nearer than the limit that `gap` sets for `best`,
    /// improving `best` where one is.
    ///
    /// Returns the distance below which there is none where this was not shown, or infinity.
    pub(super) fn prove_by_hulls(
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
    pub(super) fn prove_divided(
        &self,
        x: &Vector3<f64>,
        index: usize,
        best: &mut Foot,
        gap: &Gap,
        scratch: &mut Scratch<K>,
    ) -> f64 {
        let mut hulls = enter(scratch);
        let unresolved = self.prove_by_tiles(&self.tiles, x, index, best, gap, &mut hulls);
        let mut unresolved = unresolved;
        let patch = &self.patches[index];
        if Layout::new(patch.degrees(), patch.rational) != Layout::BICUBIC {
            unresolved =
                unresolved.min(self.prove_by_tile_nets(&self.tiles, x, index, best, gap, &mut hulls));
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

impl Geometry {
    /// Examines the pending regions by the net of the patch.
    fn prove_by_hulls(
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
    fn prove_by_tile_nets(
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

/// How much `u`, `v`, `uu`, `uv`, `vv` of a part may differ, along any axis, from what its net tells.
#[inline(always)]
fn slack(error: f64, layout: Layout, reduction: Option<&Reduction>) -> [f64; 5] {
    let (p, q) = (layout.p as f64, layout.q as f64);
    // Twice, for those of turning the net.
    let mut slack = [4.0 * p, 4.0 * q, 8.0 * p * p, 8.0 * p * q, 8.0 * q * q].map(|sums| sums * error);
    if let Some(reduction) = reduction {
        for k in 0..5 {
            // From one component to the length of three.
            slack[k] += 1.8 * reduction[0][1 + k];
        }
    }
    slack
}

/// What a few jets of a patch cost.
#[inline(always)]
fn jets_cost(patch: &Patch) -> u32 {
    let [p, q] = patch.degrees();
    u32::try_from((p + 1) * (q + 1) / JETS).unwrap_or(u32::MAX / 2)
}

/// The ranges of the third derivatives of `g` on a part.
#[inline(always)]
fn thirds_of(
    layout: Layout,
    net: &[f64],
    work: &mut Vec<f64>,
    ranges: &Ranges,
    reduction: Option<&(&Tiles, Reduction)>,
    limit_sq: f64,
) -> [[f64; 2]; 4] {
    let mut all = layout.thirds(net, work);
    if let Some((_, reduction)) = reduction {
        widen_thirds(&mut all, reduction);
    }
    thirds(ranges, &all, limit_sq)
}

/// Rounding errors of coordinates that go through so many sums of two.
#[inline(always)]
fn error_of_cut(sums: usize, patch: &Patch, y: &Vector3<f64>) -> f64 {
    2.0 * f64::EPSILON * sums as f64 * (patch.radius + y.norm())
}

/// Errors of the second derivatives, from those of the control points.
#[inline(always)]
fn derivative_error(error: f64, layout: Layout, ranges: &Ranges) -> f64 {
    let (p, q) = (layout.p as f64, layout.q as f64);
    4.0 * error * (p * p + q * q) * ranges.most_weight_sq().sqrt()
}

/// The squared length of the way to a place of the part.
#[inline(always)]
fn facet_height(r: &[f64; 3]) -> f64 {
    (r[0] * r[0] + r[1] * r[1]) + r[2] * r[2]
}

/// Whether a place of the patch lies in a region.
#[inline(always)]
fn holds(region: &Region, place: [f64; 2]) -> bool {
    (0..2).all(|d| (region.low[d]..=region.high[d]).contains(&place[d]))
}

/// In the middle, but beside a footpoint at some distance from it.
#[inline(always)]
fn cut_place(region: &Region, d: usize, best: &Foot, index: usize) -> f64 {
    if best.patch != index || !holds(region, best.local) {
        return 0.5;
    }
    let s = region.local(best.local)[d];
    if s < 0.5 { s + MARGIN } else { s - MARGIN }
}

/// The direction in which a part bends more, above all away from its tangents.
#[inline(always)]
fn direction_of_cut(ranges: &Ranges, normal: &[f64; 3], limit: f64) -> usize {
    let length = facet_height(normal).sqrt().max(f64::MIN_POSITIVE);
    let mut along = [0.0; COMPONENTS];
    for c in 0..3 {
        along[c] = normal[c] / length;
    }
    along[3] = -limit;
    // Away from the shape, and all in all.
    let size = |k: usize| {
        let (mut middle, mut half, mut all) = (0.0, 0.0, 0.0);
        for (c, part) in ranges.parts.iter().enumerate() {
            let [m, h] = part[k];
            middle += along[c] * m;
            half += along[c].abs() * h;
            all += (m.abs() + h) * if c == 3 { limit } else { 1.0 };
        }
        [middle.abs() + half, all]
    };
    let [u, v, uu, uv, vv] = [1, 2, 3, 4, 5].map(size);
    let both = u[1] + v[1];
    let score = |first: [f64; 2], second: [f64; 2]| {
        let share = if both > 0.0 { first[1] / both } else { 0.5 };
        (second[0] + SIDEWAYS * second[1]) + share * (uv[0] + SIDEWAYS * uv[1] + 1e-6 * both)
    };
    usize::from(score(v, vv) > score(u, uu))
}
