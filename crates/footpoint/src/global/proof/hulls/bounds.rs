//! What parts, and what is computed from their nets, may be off; and where parts are cut.

use super::convex::thirds;
use super::net::{COMPONENTS, Layout, Ranges, Reduction, widen_thirds};
use super::tiles::Tiles;
use crate::global::proof::region::Region;
use crate::global::surface::foot::Foot;
use crate::global::surface::geometry::Patch;
use nalgebra::Vector3;

/// Cuts beside the footpoint keep it away from the other part by this share.
const MARGIN: f64 = 0.25;

/// How much a bend along the shape counts beside one away from it, when it is decided where to cut.
const SIDEWAYS: f64 = 0.05;

/// A few jets cost one for so many control points.
const JETS: usize = 6;

/// How much `u`, `v`, `uu`, `uv`, `vv` of a part may differ, along any axis, from what its net tells.
#[inline(always)]
pub(super) fn slack(error: f64, layout: Layout, reduction: Option<&Reduction>) -> [f64; 5] {
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
pub(super) fn jets_cost(patch: &Patch) -> u32 {
    let [p, q] = patch.degrees();
    u32::try_from((p + 1) * (q + 1) / JETS).unwrap_or(u32::MAX / 2)
}

/// The ranges of the third derivatives of `g` on a part.
#[inline(always)]
pub(super) fn thirds_of(
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
pub(super) fn error_of_cut(sums: usize, patch: &Patch, y: &Vector3<f64>) -> f64 {
    2.0 * f64::EPSILON * sums as f64 * (patch.radius + y.norm())
}

/// Errors of the second derivatives, from those of the control points.
#[inline(always)]
pub(super) fn derivative_error(error: f64, layout: Layout, ranges: &Ranges) -> f64 {
    let (p, q) = (layout.p as f64, layout.q as f64);
    4.0 * error * (p * p + q * q) * ranges.most_weight_sq().sqrt()
}

/// The squared length of the way to a place of the part.
#[inline(always)]
pub(super) fn facet_height(r: &[f64; 3]) -> f64 {
    (r[0] * r[0] + r[1] * r[1]) + r[2] * r[2]
}

/// Whether a place of the patch lies in a region.
#[inline(always)]
pub(super) fn holds(region: &Region, place: [f64; 2]) -> bool {
    (0..2).all(|d| (region.low[d]..=region.high[d]).contains(&place[d]))
}

/// In the middle, but beside a footpoint at some distance from it.
#[inline(always)]
pub(super) fn cut_place(region: &Region, d: usize, best: &Foot, index: usize) -> f64 {
    if best.patch != index || !holds(region, best.local) {
        return 0.5;
    }
    let s = region.local(best.local)[d];
    if s < 0.5 { s + MARGIN } else { s - MARGIN }
}

/// The direction in which a part bends more, above all away from its tangents.
#[inline(always)]
pub(super) fn direction_of_cut(ranges: &Ranges, normal: &[f64; 3], limit: f64) -> usize {
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
