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
mod net;
mod plane;

use super::descend::Foot;
use super::gap::Gap;
use super::geometry::Patch;
use super::patch::PatchSet;
use super::products::restrict;
use super::prove::IMPROVEMENT;
use super::scratch::{Region, Scratch};
use super::simd::vectorized;
use convex::{bend, thirds, valley};
use nalgebra::Vector3;
use net::{COMPONENTS, Layout, Ranges};
use plane::{distance_along, facet};

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
const COST: u32 = 8;
const UNIT: usize = 60;

/// A part of a patch that is still to be examined.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    region: Region,
    /// No point of it is nearer than this.
    floor: f64,
    /// Error of its control points, per unit of weight.
    error: f64,
}

/// Buffers of this proof.
#[derive(Clone, Debug, Default)]
pub(crate) struct HullScratch {
    parts: Vec<Part>,
    /// Their nets, one after the other.
    nets: Vec<f64>,
    /// The net of the part at hand, and a buffer.
    current: Vec<f64>,
    work: Vec<f64>,
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
        let patch = &self.patches[index];
        let layout = Layout::new(patch.degrees(), patch.rational);
        vectorized(
            #[inline(always)]
            || {
                // Degrees known to the compiler make loops of known lengths.
                if K == 1 && layout == Layout::BICUBIC {
                    self.prove_by_hulls_inline(x, index, Layout::BICUBIC, best, gap, scratch)
                } else {
                    self.prove_by_hulls_inline(x, index, layout, best, gap, scratch)
                }
            },
        )
    }

    #[inline(always)]
    fn prove_by_hulls_inline(
        &self,
        x: &Vector3<f64>,
        index: usize,
        layout: Layout,
        best: &mut Foot,
        gap: &Gap,
        scratch: &mut Scratch<K>,
    ) -> f64 {
        let patch = &self.patches[index];
        let y = x - patch.centre;
        let length = layout.length();
        let cost =
            COST + u32::try_from(layout.count() * (layout.p + layout.q) / UNIT).unwrap_or(u32::MAX / 2);
        let mut hulls = std::mem::take(&mut scratch.hulls);
        self.begin(patch, &y, layout, &mut hulls, scratch);
        let mut unresolved = f64::INFINITY;
        while let Some(mut part) = hulls.parts.pop() {
            let first = hulls.parts.len() * length;
            let mut chase = true;
            loop {
                let limit = gap.limit_sq(best.distance_sq).sqrt();
                if part.floor >= limit {
                    break;
                }
                if scratch.boxes_left < cost || part.region.depth >= MAX_DEPTH {
                    unresolved = unresolved.min(part.floor);
                    break;
                }
                scratch.boxes_left -= cost;
                hulls.current.clear();
                hulls.current.extend_from_slice(&hulls.nets[first..first + length]);
                let net = (&hulls.current[..], &mut hulls.work);
                match self.examine(x, index, layout, net, &mut part, chase, best, gap, cost, scratch) {
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
                        let parts = part.region.split(direction, at);
                        hulls.parts.extend(parts.map(|region| Part { region, floor, error }));
                        break;
                    }
                }
            }
        }
        scratch.hulls = hulls;
        unresolved
    }

    /// The nets of the regions that are left.
    fn begin(
        &self,
        patch: &Patch,
        y: &Vector3<f64>,
        layout: Layout,
        hulls: &mut HullScratch,
        scratch: &mut Scratch<K>,
    ) {
        hulls.parts.clear();
        hulls.nets.clear();
        let (p, q) = (layout.p, layout.q);
        let error = error_of_cut(2 * (p + q) + 4, patch, y);
        for region in scratch.regions.drain(..) {
            let net = &mut scratch.net;
            net.clear();
            net.extend(self.net(patch).iter().map(|c| {
                let w = c[3];
                [c[0] - w * y.x, c[1] - w * y.y, c[2] - w * y.z, w]
            }));
            for j in 0..=q {
                restrict(net, j, q + 1, p, region.low[0], region.high[0]);
            }
            for i in 0..=p {
                restrict(net, i * (q + 1), 1, q, region.low[1], region.high[1]);
            }
            layout.push(net, &mut hulls.nets);
            let region = Region { depth: 0, ..region };
            hulls.parts.push(Part { region, floor: 0.0, error });
        }
    }

    /// Looks at one part.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "the query, the part and what is known")]
    fn examine(
        &self,
        x: &Vector3<f64>,
        index: usize,
        layout: Layout,
        (net, work): (&[f64], &mut Vec<f64>),
        part: &mut Part,
        chase: bool,
        best: &Foot,
        gap: &Gap,
        cost: u32,
        scratch: &mut Scratch<K>,
    ) -> Finding {
        let patch = &self.patches[index];
        let region = part.region;
        let limit_sq = gap.limit_sq(best.distance_sq);
        let limit = limit_sq.sqrt();
        let facet = facet(layout, net);
        let mut floor = part.floor.max(distance_along(layout, net, &facet.nearest) - part.error);
        let mut normal = facet.nearest;
        if floor < limit {
            let place = region.place(facet.place);
            let r = self.point(patch, place[0], place[1]) - (x - patch.centre);
            if chase && r.norm_squared() < best.distance_sq * (1.0 - IMPROVEMENT) {
                return Finding::Nearer(place);
            }
            normal = r.into();
            floor = floor.max(distance_along(layout, net, &normal) - part.error);
        }
        let focus = (best.patch == index && holds(&region, best.local)).then(|| region.local(best.local));
        if floor >= limit {
            if focus.is_none() && floor * floor <= gap.reach_sq(best.distance_sq) {
                scratch.note_tie(index, region.place(facet.place));
            }
            return Finding::Dropped;
        }
        let ranges = layout.ranges(net, work);
        // What `g` may lose and still be high enough somewhere.
        let height = 0.5 * (facet_height(&normal).max(best.distance_sq) - limit_sq) * ranges.most_weight_sq();
        let start = focus.unwrap_or(facet.place);
        let low = match bend(&ranges, limit_sq, derivative_error(part.error, layout, &ranges)) {
            Some(bend) if bend.least_loss() <= height => {
                scratch.boxes_left = scratch.boxes_left.saturating_sub(cost);
                bend.lowest(layout, net, limit_sq, start, part.error)
            }
            Some(bend) if bend.least_loss() <= VALLEYS * height => {
                scratch.boxes_left = scratch.boxes_left.saturating_sub(cost);
                let thirds = thirds(&ranges, &layout.thirds(net, work), limit_sq);
                valley(layout, net, &thirds, limit_sq, start, part.error)
            }
            _ => return Finding::Open { floor, direction: direction_of_cut(&ranges, &normal, limit) },
        };
        if low.bound >= low.noise {
            let tie = 0.5 * (gap.reach_sq(best.distance_sq) - limit_sq) * ranges.most_weight_sq();
            if focus.is_none() && low.value <= tie {
                scratch.note_tie(index, region.place(low.place));
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
        Finding::Open { floor, direction: direction_of_cut(&ranges, &normal, limit) }
    }
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
