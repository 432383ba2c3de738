//! Lower bounds of parts that are graphs over a tangent plane, however uneven and slanted their parameters are.
//!
//! Let `z₀` be a place of the part, `n` the unit normal there, towards the side on which the query is not, `h = ⟨S − x, n⟩` and `w` the
//! way from `S(z₀)` along the tangent plane. Along the segment from `z₀` to `z₀ + δ` the first is `h₀ + φ`, where `φ` and its first
//! derivative are zero at `z₀`, and `w = M̄ δ` with a mean `M̄` of the first derivatives. So `2 φ = δᵀ H̄ δ = wᵀ M̄⁻ᵀ H̄ M̄⁻¹ w` with a
//! mean `H̄` of the second derivatives of `h`, and with `τ`, the tangential part of the way from the query to `S(z₀)`,
//!
//! `|S − x|² ≥ |S(z₀) − x|² + 2 ⟨τ, w⟩ + wᵀ (1 + h₀ M̄⁻ᵀ H̄ M̄⁻¹) w`.
//!
//! Ranges of the derivatives, taken along the axes of the tangent plane, bound all that is unknown.

use super::convex::{Jets, Low, flattest, product};
use super::net::{COMPONENTS, Layout, Ranges};
use crate::global::arithmetic::homogeneous::Homogeneous;

/// Steps towards the lowest place.
const STEPS: usize = 6;

/// A step that is shorter than this, in parameters of the part, is the last one.
const SHORT: f64 = 1e-3;

/// Square of the sine of the angle between parameter lines down to which a part is not slanted.
const UPRIGHT: f64 = 0.1;

/// Ratio of squared speeds below which parameters are so unlike that the part may be a slanted one.
const UNLIKE: f64 = 1e-3;

/// A range, by its ends.
type Span = [f64; 2];

#[inline(always)]
fn times(a: Span, b: Span) -> Span {
    let [p, q, r, s] = [a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1]];
    [p.min(q).min(r.min(s)), p.max(q).max(r.max(s))]
}

#[inline(always)]
fn plus(a: Span, b: Span) -> Span {
    [a[0] + b[0], a[1] + b[1]]
}

#[inline(always)]
fn minus(a: Span, b: Span) -> Span {
    [a[0] - b[1], a[1] - b[0]]
}

#[inline(always)]
fn scaled(a: Span, factor: f64) -> Span {
    times(a, [factor, factor])
}

#[inline(always)]
fn most(a: Span) -> f64 {
    a[0].abs().max(a[1].abs())
}

#[inline(always)]
fn dot(a: &Homogeneous, b: &Homogeneous) -> f64 {
    product(a, b, 0.0)
}

#[inline(always)]
fn cross(a: &Homogeneous, b: &Homogeneous) -> Homogeneous {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0], 0.0]
}

#[inline(always)]
fn along(a: &Homogeneous, factor: f64) -> Homogeneous {
    [a[0] * factor, a[1] * factor, a[2] * factor, 0.0]
}

/// Axes of a tangent plane, the second of them along the way that a change of the parameters goes farthest, and its normal.
#[inline(always)]
fn axes(u: &Homogeneous, v: &Homogeneous, r: &Homogeneous) -> Option<[Homogeneous; 3]> {
    let normal = cross(u, v);
    let length = dot(&normal, &normal).sqrt();
    let sign = if dot(&normal, r) < 0.0 { -1.0 } else { 1.0 };
    let normal = along(&normal, sign / length);
    let (a, c, b) = (dot(u, u), dot(u, v), dot(v, v));
    let (_, [e, f]) = flattest(a, c, b);
    // That of the largest speed is across that of the least.
    let long = [0, 1, 2, 3].map(|k| v[k] * e - u[k] * f);
    let long = along(&long, 1.0 / dot(&long, &long).sqrt());
    let other = cross(&normal, &long);
    let finite = [normal, long, other].as_flattened().iter().all(|c| c.is_finite());
    finite.then_some([other, long, normal])
}

/// A place of the part from which the distance does not fall much, as far as a few steps from another tell, and the jet there.
///
/// Steps are those of Newton's method, bent so that they keep to the tangent plane as far as second derivatives tell.
#[inline(always)]
fn settled(part: &impl Jets, start: [f64; 2], first: &[Homogeneous; 6]) -> ([f64; 2], [Homogeneous; 6]) {
    let (mut at, mut jet) = (start, *first);
    let mut share = 1.0;
    for _ in 0..STEPS {
        let [r, u, v, uu, uv, vv] = &jet;
        let slope = [dot(u, r), dot(v, r)];
        let metric = [dot(u, u), dot(u, v), dot(v, v)];
        let mut h = [metric[0] + dot(uu, r), metric[1] + dot(uv, r), metric[2] + dot(vv, r)];
        if h[0] * h[2] - h[1] * h[1] <= 1e-3 * (metric[0] * metric[2] - metric[1] * metric[1]) || h[0] <= 0.0
        {
            h = metric;
        }
        let blocked = [0, 1].map(|d| (at[d] <= 0.0 && slope[d] > 0.0) || (at[d] >= 1.0 && slope[d] < 0.0));
        let solve = |h: [f64; 3], g: [f64; 2]| match blocked {
            [true, true] => [0.0; 2],
            [true, false] => [0.0, -g[1] / h[2]],
            [false, true] => [-g[0] / h[0], 0.0],
            [false, false] => {
                let det = h[0] * h[2] - h[1] * h[1];
                [(h[1] * g[1] - h[2] * g[0]) / det, (h[1] * g[0] - h[0] * g[1]) / det]
            }
        };
        let step = solve(h, slope).map(|s| share * s);
        let mut bent = [0.0; 4];
        for c in 0..3 {
            let (a, b) = (step[0], step[1]);
            bent[c] = 0.5 * ((uu[c] * a + 2.0 * uv[c] * b) * a + vv[c] * (b * b));
        }
        let more = solve(metric, [dot(u, &bent), dot(v, &bent)]);
        let to = [0, 1].map(|d| (at[d] + (step[d] + more[d])).clamp(0.0, 1.0));
        if !(to[0].is_finite() && to[1].is_finite()) || to == at {
            break;
        }
        let there = part.jet(to);
        if dot(&there[0], &there[0]) > dot(r, r) {
            share *= 0.4;
            continue;
        }
        let short = (to[0] - at[0]).abs() < SHORT && (to[1] - at[1]).abs() < SHORT;
        (at, jet) = (to, there);
        share = 1.0;
        if short {
            break;
        }
    }
    (at, jet)
}

/// Whether a part is so slanted that it is worth a look, from the ranges of its derivatives.
#[inline(always)]
pub(super) fn is_slanted(ranges: &Ranges) -> bool {
    let of = |k: usize, l: usize| {
        let [x, y, z, _] = &ranges.parts;
        (x[k][0] * x[l][0] + y[k][0] * y[l][0]) + z[k][0] * z[l][0]
    };
    let (a, c, b) = (of(1, 1), of(1, 2), of(2, 2));
    a * b - c * c < UPRIGHT * a * b || a.min(b) < UNLIKE * a.max(b)
}

/// The bound of `g` (see [`convex`](super::convex)) on a part without weights, whose derivatives `u`, `v`, `uu`, `uv`, `vv` may differ
/// by `slack` from those that the net tells; if there is one. `work` and `turned` are buffers.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "the part, the query and buffers")]
pub(super) fn graph(
    part: &impl Jets,
    layout: Layout,
    net: &[f64],
    slack: [f64; 5],
    limit_sq: f64,
    start: [f64; 2],
    work: &mut Vec<f64>,
    turned: &mut Vec<f64>,
) -> Option<Low> {
    if layout.components == COMPONENTS {
        return None;
    }
    let n = layout.count();
    turned.resize(3 * n, 0.0);
    let (mut place, mut jet) = (start, part.jet(start));
    for attempt in 0..2 {
        let [r, u, v, ..] = &jet;
        let axes = axes(u, v, r)?;
        for c in 0..3 {
            let axis = &axes[c];
            let to = &mut turned[c * n..(c + 1) * n];
            let (x, y, z) = (&net[..n], &net[n..2 * n], &net[2 * n..3 * n]);
            for k in 0..n {
                to[k] = (axis[0] * x[k] + axis[1] * y[k]) + axis[2] * z[k];
            }
        }
        let ranges = layout.ranges(turned, work);
        let [other, long, normal] = &axes;
        let way = [dot(other, r), dot(long, r), dot(normal, r)];
        let first = [[dot(other, u), dot(other, v)], [dot(long, u), dot(long, v)]];
        let loss = loss(&ranges, slack, place, way, first)?;
        // The normal is not quite one.
        let tilt = |a: &Homogeneous| dot(normal, a).abs() + 8.0 * f64::EPSILON * dot(a, a).sqrt();
        let value = 0.5 * (dot(r, r) - limit_sq);
        let noise = part.noise(&jet, limit_sq, 2) + way[2] * (tilt(u) + tilt(v));
        let bound = value - 0.5 * loss;
        if attempt == 1 || bound >= noise || value < -noise {
            return Some(Low { place, value, bound, noise });
        }
        // So far only the slope is in the way.
        (place, jet) = settled(part, start, &jet);
    }
    None
}

/// What is taken off the squared distance of a place at most, from the ranges of the derivatives along the axes, the way from the query
/// and the first derivatives there.
#[inline(always)]
fn loss(
    ranges: &Ranges,
    slack: [f64; 5],
    place: [f64; 2],
    [tau, sigma, height]: [f64; 3],
    m: [[f64; 2]; 2],
) -> Option<f64> {
    // Derivative `k` along an axis.
    let span = |axis: usize, k: usize| -> Span {
        let [middle, half] = ranges.parts[axis][k];
        let half = (half + slack[k - 1]) * (1.0 + 1e-12) + 1e-13 * middle.abs();
        [middle - half, middle + half]
    };
    let determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0];
    // Parameters in which the first derivatives at the place are those of the axes: δ = E ξ.
    let e =
        [[m[1][1] / determinant, -m[0][1] / determinant], [-m[1][0] / determinant, m[0][0] / determinant]];
    let first = |axis: usize, column: usize| {
        plus(scaled(span(axis, 1), e[0][column]), scaled(span(axis, 2), e[1][column]))
    };
    let (a, b, c, d) = (first(0, 0), first(0, 1), first(1, 0), first(1, 1));
    let det = minus(times(a, d), times(b, c));
    if !(det[0] > 0.0 && det[1].is_finite()) {
        return None;
    }
    let inverse = [1.0 / det[1], 1.0 / det[0]];
    // ξ = Q w.
    let q = [
        [times(d, inverse), times(scaled(b, -1.0), inverse)],
        [times(scaled(c, -1.0), inverse), times(a, inverse)],
    ];
    // The second derivatives of the height by ξ, and by w.
    let second = |i: usize, j: usize| {
        let mixed = e[0][i] * e[1][j] + e[1][i] * e[0][j];
        let pure = plus(scaled(span(2, 3), e[0][i] * e[0][j]), scaled(span(2, 5), e[1][i] * e[1][j]));
        plus(pure, scaled(span(2, 4), mixed))
    };
    let h = [second(0, 0), second(0, 1), second(1, 1)];
    let square = |x: Span| {
        let [low, high] = [x[0].abs(), x[1].abs()];
        [if x[0] * x[1] <= 0.0 { 0.0 } else { (low * low).min(high * high) }, (low * low).max(high * high)]
    };
    let by_w = |i: usize| {
        let (p, s) = (q[0][i], q[1][i]);
        plus(plus(times(square(p), h[0]), times(square(s), h[2])), scaled(times(times(p, s), h[1]), 2.0))
    };
    let mixed = {
        let pure = plus(times(times(q[0][0], q[0][1]), h[0]), times(times(q[1][0], q[1][1]), h[2]));
        plus(pure, times(plus(times(q[0][0], q[1][1]), times(q[0][1], q[1][0])), h[1]))
    };
    // The least eigenvalue of a symmetric matrix of ranges.
    let middle = |x: Span| 0.5 * (x[0] + x[1]);
    let half = |x: Span| 0.5 * (x[1] - x[0]);
    let (x, y) = (by_w(0), by_w(1));
    let (least, _) = flattest(middle(x), middle(mixed), middle(y));
    let bend = least - half(x).max(half(y)) - half(mixed) - 1e-12 * (most(x) + most(y) + most(mixed));
    let strength = 1.0 + height * bend - 1e-12;
    if !(strength > 0.0 && strength.is_finite()) {
        return None;
    }
    // What the slopes add, one parameter at a time: nothing where they only rise.
    let mut fall = 0.0;
    for k in 0..2 {
        let slope = plus(scaled(span(0, 1 + k), tau), scaled(span(1, 1 + k), sigma));
        let blocked = (place[k] <= 0.0 && slope[0] >= 0.0) || (place[k] >= 1.0 && slope[1] <= 0.0);
        if !blocked {
            // |δ_k| ≤ |row k of E Q| |w|.
            let row = |i: usize| most(plus(scaled(q[0][i], e[k][0]), scaled(q[1][i], e[k][1])));
            fall += most(slope) * (row(0) * row(0) + row(1) * row(1)).sqrt();
        }
    }
    let loss = fall * fall / strength;
    loss.is_finite().then_some(loss * (1.0 + 1e-9))
}

#[cfg(test)]
mod tests {
    use super::super::convex::Net;
    use super::*;

    /// Part of a patch, `[x, y, z]` in its parameters between −1/2 and 1/2, whose control points are those of polynomials of degree 2.
    fn part(point: impl Fn(f64, f64) -> [f64; 3]) -> (Layout, Vec<f64>) {
        let layout = Layout::BICUBIC;
        // Values at four places in each direction, and the control points of the cubic polynomials through them.
        let inverse = [
            [1.0, 0.0, 0.0, 0.0],
            [-5.0 / 6.0, 3.0, -1.5, 1.0 / 3.0],
            [1.0 / 3.0, -1.5, 3.0, -5.0 / 6.0],
            [0.0, 0.0, 0.0, 1.0],
        ];
        let mut net = vec![0.0; layout.length()];
        for i in 0..4 {
            for j in 0..4 {
                for k in 0..4 {
                    for l in 0..4 {
                        let value = point(k as f64 / 3.0 - 0.5, l as f64 / 3.0 - 0.5);
                        for c in 0..3 {
                            net[16 * c + 4 * i + j] += inverse[i][k] * inverse[j][l] * value[c];
                        }
                    }
                }
            }
        }
        (layout, net)
    }

    fn bound_of(layout: Layout, net: &[f64], limit_sq: f64, start: [f64; 2]) -> Option<(Low, f64)> {
        let exact = Net { layout, net, error: 1e-16 };
        let low = graph(&exact, layout, net, [0.0; 5], limit_sq, start, &mut Vec::new(), &mut Vec::new())?;
        let mut least = f64::INFINITY;
        for k in 0..=60 {
            for l in 0..=60 {
                let [value, ..] = layout.jet(net, [f64::from(k) / 60.0, f64::from(l) / 60.0]);
                least = least.min(0.5 * product(&value, &value, limit_sq));
            }
        }
        Some((low, least))
    }

    #[test]
    fn a_bent_wall_is_bounded_at_once() {
        // A steep graph with bent level lines: at right angles to the query's way, 500 times as high as wide.
        for turn in [0.0, 0.7, 2.0] {
            let (layout, net) = part(|x, y| {
                let (x, y) = (0.02 * x, 0.02 * y);
                let height = 500.0 * (x + 2.0 * (y * y + x * y));
                let (a, b) = (
                    f64::cos(turn) * x - f64::sin(turn) * height,
                    f64::sin(turn) * x + f64::cos(turn) * height,
                );
                // The wall stands at x = 0, the query 0.1 beside it.
                [a + 0.1 * f64::cos(turn), b + 0.1 * f64::sin(turn), y]
            });
            let (low, least) = bound_of(layout, &net, 0.0098, [0.4, 0.6]).unwrap();
            assert!(low.bound <= least + 1e-12, "{turn}: {} above {least}", low.bound);
            // A grid is too coarse for this: along the wall its places are 0.16 apart.
            assert!(low.bound > 0.9e-4, "{turn}: {} instead of 1e-4", low.bound);
        }
    }

    #[test]
    fn bounds_are_never_above_the_truth() {
        let mut state = 5u64;
        let mut unit = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let (mut found, mut sharp) = (0, 0);
        for case in 0..600 {
            let size = [0.1, 0.4, 1.0][case % 3];
            let c: Vec<f64> = (0..18).map(|_| unit()).collect();
            let (layout, net) = part(|x, y| {
                let (s, t) = (size * (x + 0.3 * c[0] * y), size * (0.8 * y + c[1] * x));
                let bend = |k: usize| c[k] * s * s + c[k + 1] * s * t + c[k + 2] * t * t;
                [s + bend(2) + 0.3 * c[14], t + bend(5) + 0.3 * c[15], 0.6 + bend(8) + c[11] * s + c[12] * t]
            });
            let start = [0.5 + unit(), 0.5 + unit()];
            let Some((low, least)) = bound_of(layout, &net, 0.2, start) else { continue };
            assert!(low.bound <= least + 1e-12, "case {case}: {} above {least}", low.bound);
            found += usize::from(low.bound > f64::NEG_INFINITY);
            sharp += usize::from(low.bound > least - 1e-3);
        }
        assert!(found > 200 && sharp > 100, "{found} {sharp}");
    }
}
