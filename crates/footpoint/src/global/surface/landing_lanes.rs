//! The ends of walks side by side, as far as they are the usual ones: a negligible step to a foot inside a patch.

use crate::global::arithmetic::power::Wide;
use crate::global::arithmetic::simd::{Pack, Simd};
use crate::global::surface::descend::GROWTH;
use crate::global::surface::newton_lanes::{At, Round, dot, open};
use crate::tolerance::{DEGENERATE_SQ, ON_BORDER, ORTHOGONAL, ORTHOGONAL_FLOOR, STANDSTILL};

/// Feet of queries side by side.
pub(in crate::global) struct Landing<S: Simd> {
    /// Relative to the centre of the patch.
    pub(in crate::global) point: Wide<S, 3>,
    pub(in crate::global) distance: Pack<S>,
    /// Negative where the query lies on the side to which the normal points.
    pub(in crate::global) side: Pack<S>,
    /// Bit by bit: lanes that have converged to a foot inside the patch. Nothing is said about the others.
    pub(in crate::global) converged: u32,
}

/// Takes the last step, as [`land`](crate::global::surface::geometry::Geometry::land) does, and tells what
/// [`conclude`](crate::global::surface::geometry::Geometry::conclude) tells, by the same operations in the same order.
#[inline(always)]
pub(in crate::global) fn landing<S: Simd>(round: &Round<S>, from: &At<S>, size: f64) -> Landing<S> {
    let [point, du, dv, duu, duv, dvv] = &round.jets;
    let [s, t] = [round.target[0] - from.local[0], round.target[1] - from.local[1]];
    let (half_s, half_t) = (s * 0.5, t * 0.5);
    let (mut to, mut to_u, mut to_v) = (*point, *du, *dv);
    for c in 0..3 {
        let along = (du[c] + (duu[c] * half_s + duv[c] * t)) * s + (dv[c] + dvv[c] * half_t) * t;
        to[c] = point[c] + along;
        to_u[c] = du[c] + (duu[c] * s + duv[c] * t);
        to_v[c] = dv[c] + (duv[c] * s + dvv[c] * t);
    }
    let r = [to[0] - from.y[0], to[1] - from.y[1], to[2] - from.y[2]];
    let distance_sq = dot(&r, &r);
    let distance = distance_sq.sqrt();
    let lands = round.distance_sq * GROWTH - distance_sq;
    let tolerance = (distance * ORTHOGONAL).max(distance.all(ORTHOGONAL_FLOOR * size));
    let tolerance_sq = tolerance * tolerance;
    let [uu, vv] = [dot(&to_u, &to_u), dot(&to_v, &to_v)];
    let slopes = [dot(&to_u, &r), dot(&to_v, &r)];
    let stationary =
        (uu * tolerance_sq - slopes[0] * slopes[0]).min(vv * tolerance_sq - slopes[1] * slopes[1]);
    // Poles and cusps, and what may be one of them, are looked at one by one.
    let still = STANDSTILL * size;
    let gaps = [open(round.target[0]), open(round.target[1])];
    let apart = ((gaps[0] * gaps[0]) * uu).min((gaps[1] * gaps[1]) * vv) - uu.all(4.0 * still * still);
    let border = uu.all(2.0 * ON_BORDER);
    let inside = (gaps[0] - border).min(gaps[1] - border);
    let normal = [
        to_u[1] * to_v[2] - to_u[2] * to_v[1],
        to_u[2] * to_v[0] - to_u[0] * to_v[2],
        to_u[0] * to_v[1] - to_u[1] * to_v[0],
    ];
    let largest = uu.max(vv);
    let regular = dot(&normal, &normal) - largest * DEGENERATE_SQ * largest;
    // Adds nothing, or NaN where something is not finite.
    let finite = distance * 0.0;
    let positive = apart.min(inside).min(regular) + finite;
    let converged = positive.positive() & lands.min(stationary).not_negative();
    Landing { point: to, distance, side: dot(&normal, &r), converged }
}
