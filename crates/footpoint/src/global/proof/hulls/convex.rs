//! Lower bounds of parts on which the squared distance is convex, or nearly so.
//!
//! With `N = w (S − x)` the function `g = (|N|² − (w L)²) / 2` is nowhere negative on a part that is nowhere nearer than `L`. Its
//! second derivatives `⟨N_a, N_b⟩ + ⟨N, N_ab⟩`, in the product that takes `L² w w` off, are bounded by the ranges of the factors.
//! Where they are at least `−μ e eᵀ`, `g(z) ≥ g(z₀) + g'(z₀) (z − z₀) − μ (e · (z − z₀))² / 2` (the convex underestimators of
//! \[AMF95\] in one direction).

use super::net::{COMPONENTS, Layout, Ranges};
use crate::global::arithmetic::homogeneous::Homogeneous;

/// Steps towards the lowest place.
const STEPS: usize = 4;

/// A part of a patch that can be evaluated, in parameters between 0 and 1.
pub(super) trait Jets {
    /// Value, `u`, `v`, `uu`, `uv`, `vv` of the components at a place.
    fn jet(&self, place: [f64; 2]) -> [Homogeneous; 6];
    /// Rounding errors of `g` and of what its slopes add up to on the part, from value, `u` and `v`; of the derivatives up to an order.
    fn noise(&self, jet: &[Homogeneous; 6], limit_sq: f64, order: i32) -> f64;
}

/// A part by its control net; `error` is that of the numbers of the net, per unit of weight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Net<'a> {
    pub(super) layout: Layout,
    pub(super) net: &'a [f64],
    pub(super) error: f64,
}

impl Jets for Net<'_> {
    #[inline(always)]
    fn jet(&self, place: [f64; 2]) -> [Homogeneous; 6] {
        self.layout.jet(self.net, place)
    }

    #[inline(always)]
    fn noise(&self, jet: &[Homogeneous; 6], limit_sq: f64, order: i32) -> f64 {
        let (p, q) = (self.layout.p as f64, self.layout.q as f64);
        let noise = noise(jet, limit_sq, self.error, 1.0 + 2.0 * (p + q));
        if order < 3 {
            return noise;
        }
        // Third differences add up errors.
        let [value, ..] = jet;
        let sums = 8.0 * (p * p * p + q * q * q);
        noise + sums * self.error * product(value, value, -limit_sq).sqrt() * value[3].abs()
    }
}

/// What is known about the second derivatives of `g` on a part.
pub(super) struct Bend {
    /// Direction of the least second derivative, in units of the part.
    flattest: [f64; 2],
    /// Second derivatives in it are at least `−lack`.
    lack: f64,
}

/// Where a part is lowest, and how low it may be.
pub(super) struct Low {
    pub(super) place: [f64; 2],
    /// `g` there and at least everywhere, and their rounding error.
    pub(super) value: f64,
    pub(super) bound: f64,
    pub(super) noise: f64,
}

/// The product of two vectors with the square of the limit taken off by the weights.
#[inline(always)]
pub(super) fn product(a: &Homogeneous, b: &Homogeneous, limit_sq: f64) -> f64 {
    ((a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]) - limit_sq * (a[3] * b[3])
}

/// Bounds of the second derivatives, or nothing where they do not help; `error` is that of the numbers of the net.
#[inline(always)]
pub(super) fn bend(ranges: &Ranges, limit_sq: f64, error: f64) -> Option<Bend> {
    // Middle and half of the length of the ranges of `uu`, `uv`, `vv` of `g`, and the size of the terms.
    let mut middle = [0.0; 3];
    let mut half = [0.0; 3];
    let mut terms = 0.0;
    for (c, [value, u, v, uu, uv, vv]) in ranges.parts.iter().enumerate() {
        let factor = if c + 1 == COMPONENTS { -limit_sq } else { 1.0 };
        let most = |a: &[f64; 2]| a[0].abs() + a[1];
        for (k, (a, b, second)) in [(u, u, uu), (u, v, uv), (v, v, vv)].into_iter().enumerate() {
            middle[k] += factor * (a[0] * b[0] + value[0] * second[0]);
            let first = a[0].abs() * b[1] + b[0].abs() * a[1] + a[1] * b[1];
            let rest = value[0].abs() * second[1] + second[0].abs() * value[1] + value[1] * second[1];
            half[k] += factor.abs() * (first + rest);
            terms += factor.abs()
                * (4.0 * f64::EPSILON * (most(a) * most(b) + most(value) * most(second))
                    + error * (most(value) + most(a) + most(b)));
        }
    }
    let [a, c, b] = middle;
    let (low, e) = flattest(a, c, b);
    let high = a + b - low;
    let (e0, e1) = (e[0].abs(), e[1].abs());
    // Products of absolute values, and a little for the rounding errors of the basis.
    let spread = |x: [f64; 2], y: [f64; 2]| {
        x[0] * y[0] * half[0] + (x[0] * y[1] + x[1] * y[0]) * half[1] + x[1] * y[1] * half[2]
    };
    let rounding = terms + 1e-14 * (half[0] + half[2]);
    let (ee, ff, ef) = (
        spread([e0, e1], [e0, e1]) + rounding,
        spread([e1, e0], [e1, e0]) + rounding,
        spread([e0, e1], [e1, e0]) + rounding,
    );
    let across = high - ff;
    if across.is_nan() || across <= 0.0 {
        return None;
    }
    let lack = (ef * ef / across - (low - ee)).max(0.0);
    lack.is_finite().then_some(Bend { flattest: e, lack })
}

impl Bend {
    /// How much the lack of convexity may take off at most, seen from the middle of the part.
    #[inline(always)]
    pub(super) fn least_loss(&self) -> f64 {
        let reach = 0.5 * (self.flattest[0].abs() + self.flattest[1].abs());
        0.5 * self.lack * reach * reach
    }

    /// Looks for the lowest place of the part from `start`.
    #[inline(always)]
    pub(super) fn lowest(&self, part: &impl Jets, limit_sq: f64, start: [f64; 2]) -> Low {
        let mut at = start;
        let mut best = Low { place: start, value: f64::INFINITY, bound: f64::NEG_INFINITY, noise: 0.0 };
        for _ in 0..STEPS {
            let jet = part.jet(at);
            let [value, u, v, uu, uv, vv] = &jet;
            let of = |a: &Homogeneous, b: &Homogeneous| product(a, b, limit_sq);
            let here = 0.5 * of(value, value);
            let slope = [of(u, value), of(v, value)];
            let [e, f] = self.flattest;
            let reach =
                [0, 1].map(|i| [0, 1].map(|j| (e * (i as f64 - at[0]) + f * (j as f64 - at[1])).abs()));
            let reach = reach.as_flattened().iter().copied().fold(0.0, f64::max);
            let fall = |d: usize| (slope[d] * -at[d]).min(slope[d] * (1.0 - at[d]));
            let bound = (here + fall(0).min(0.0) + fall(1).min(0.0)) - 0.5 * self.lack * reach * reach;
            let noise = part.noise(&jet, limit_sq, 2);
            if bound - noise > best.bound - best.noise || best.value == f64::INFINITY {
                best = Low { place: at, value: here, bound, noise };
            }
            if bound >= noise || here < -noise {
                break;
            }
            let [mut a, c, mut b] =
                [of(u, u) + of(value, uu), of(u, v) + of(value, uv), of(v, v) + of(value, vv)];
            a += self.lack * e * e;
            b += self.lack * f * f;
            let c = c + self.lack * e * f;
            let free =
                [0, 1].map(|d| !((at[d] <= 0.0 && slope[d] > 0.0) || (at[d] >= 1.0 && slope[d] < 0.0)));
            let det = a * b - c * c;
            let step = match free {
                [true, true] => [(c * slope[1] - b * slope[0]) / det, (c * slope[0] - a * slope[1]) / det],
                [true, false] => [-slope[0] / a, 0.0],
                [false, true] => [0.0, -slope[1] / b],
                [false, false] => break,
            };
            let next = [0, 1].map(|d| (at[d] + step[d]).clamp(0.0, 1.0));
            if !(next[0].is_finite() && next[1].is_finite()) || next == at {
                break;
            }
            at = next;
        }
        best
    }
}

/// Middle and half of the length of the ranges of the third derivatives `uuu`, `uuv`, `uvv`, `vvv` of `g`, from those of the net.
#[inline(always)]
pub(super) fn thirds(ranges: &Ranges, thirds: &[[[f64; 2]; 4]; COMPONENTS], limit_sq: f64) -> [[f64; 2]; 4] {
    let mut sums = [[0.0; 2]; 4];
    for (c, ([value, u, v, uu, uv, vv], third)) in ranges.parts.iter().zip(thirds).enumerate() {
        let factor = if c + 1 == COMPONENTS { limit_sq } else { 1.0 };
        let sign = if c + 1 == COMPONENTS { -1.0 } else { 1.0 };
        let products = [
            [(3.0, uu, u), (0.0, uu, u), (1.0, value, &third[0])],
            [(2.0, uv, u), (1.0, uu, v), (1.0, value, &third[1])],
            [(2.0, uv, v), (1.0, vv, u), (1.0, value, &third[2])],
            [(3.0, vv, v), (0.0, vv, v), (1.0, value, &third[3])],
        ];
        for (sum, products) in sums.iter_mut().zip(products) {
            for (times, a, b) in products {
                sum[0] += sign * factor * times * a[0] * b[0];
                let rounding = 1e-14 * (a[0].abs() + a[1]) * (b[0].abs() + b[1]);
                sum[1] += factor * times * (a[0].abs() * b[1] + b[0].abs() * a[1] + a[1] * b[1] + rounding);
            }
        }
    }
    sums
}

/// A lower bound from the polynomial of second order at a place and the third derivatives on the part.
///
/// In coordinates `s` along the flattest direction there and `t` across it, `g` is at least a polynomial in `s` and, for each `s`, a
/// parabola in `t` whose lowest point may lie off the line `t = 0` by as much as the valley bends. What this takes off grows with the
/// fourth power of the size of a part along a valley in which the distance does not change, in whatever direction it runs.
#[inline(always)]
pub(super) fn valley(part: &impl Jets, thirds: &[[f64; 2]; 4], limit_sq: f64, place: [f64; 2]) -> Low {
    let jet = part.jet(place);
    let noise = part.noise(&jet, limit_sq, 3);
    let [value, u, v, uu, uv, vv] = jet;
    let of = |a: &Homogeneous, b: &Homogeneous| product(a, b, limit_sq);
    let here = 0.5 * of(&value, &value);
    let low = Low { place, value: here, bound: f64::NEG_INFINITY, noise };
    let slope = [of(&u, &value), of(&v, &value)];
    let [a, c, b] =
        [of(&u, &u) + of(&value, &uu), of(&u, &v) + of(&value, &uv), of(&v, &v) + of(&value, &vv)];
    let (least, [e, f]) = flattest(a, c, b);
    let most = a + b - least;
    // The largest coordinates on the part.
    let reach = |x: f64, y: f64| {
        let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]];
        corners.iter().fold(0.0f64, |all, [i, j]| all.max((x * (i - place[0]) + y * (j - place[1])).abs()))
    };
    let (along, across) = (reach(e, f), reach(-f, e));
    // Third derivatives in three directions: the largest absolute value.
    let third = |x: [f64; 2], y: [f64; 2], z: [f64; 2]| {
        let shares = [
            x[0] * y[0] * z[0],
            x[0] * y[0] * z[1] + x[0] * y[1] * z[0] + x[1] * y[0] * z[0],
            x[0] * y[1] * z[1] + x[1] * y[0] * z[1] + x[1] * y[1] * z[0],
            x[1] * y[1] * z[1],
        ];
        let sizes = [x.map(f64::abs), y.map(f64::abs), z.map(f64::abs)];
        let [x, y, z] = sizes;
        let most = [
            x[0] * y[0] * z[0],
            x[0] * y[0] * z[1] + x[0] * y[1] * z[0] + x[1] * y[0] * z[0],
            x[0] * y[1] * z[1] + x[1] * y[0] * z[1] + x[1] * y[1] * z[0],
            x[1] * y[1] * z[1],
        ];
        let (mut middle, mut half) = (0.0, 0.0);
        for k in 0..4 {
            middle += shares[k] * thirds[k][0];
            half += most[k] * thirds[k][1];
        }
        middle.abs() + half
    };
    let (x, y) = ([e, f], [-f, e]);
    let rounding = 1e-13 * (a.abs() + b.abs());
    let bent = most - rounding - third(x, y, y) * along - third(y, y, y) * across / 3.0;
    if bent.is_nan() || bent <= 0.0 {
        return low;
    }
    let slope_along = (slope[0] * e + slope[1] * f).abs();
    let slope_across = (slope[1] * e - slope[0] * f).abs();
    let off = slope_across + rounding * along + 0.5 * third(x, x, y) * along * along;
    let lack = (rounding - least).max(0.0);
    let fall = (slope_along + (0.5 * lack + third(x, x, x) * along / 6.0) * along) * along;
    let bound = here - fall - off * off / (2.0 * bent);
    Low { bound, ..low }
}

/// Rounding errors of `g` and of what its slopes add up to, from the error of the values and the sum of those of all derivatives, in
/// such errors.
#[inline(always)]
pub(super) fn noise(jet: &[Homogeneous; 6], limit_sq: f64, error: f64, sums: f64) -> f64 {
    let [value, u, v, ..] = jet;
    let length = |a: &Homogeneous| (product(a, a, 0.0) + limit_sq * a[3] * a[3]).sqrt();
    error * value[3].abs() * (sums * length(value) + length(u) + length(v))
}

/// The smaller eigenvalue of a symmetric matrix, and its direction.
#[inline(always)]
pub(super) fn flattest(a: f64, c: f64, b: f64) -> (f64, [f64; 2]) {
    let low = 0.5 * (a + b) - (0.25 * (a - b) * (a - b) + c * c).sqrt();
    // From the row that says more.
    let row = if (a - low).abs() > (b - low).abs() { [a - low, c] } else { [c, b - low] };
    let length = (row[0] * row[0] + row[1] * row[1]).sqrt();
    (low, if length > 0.0 { [-row[1] / length, row[0] / length] } else { [1.0, 0.0] })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Part of a patch about `(0, 0, 1)` over a square of the given size, bent by chance, with weights if rational.
    fn net(seed: u64, layout: Layout, size: f64) -> Vec<f64> {
        let mut state = seed;
        let mut unit = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let mut points = Vec::new();
        for i in 0..=layout.p {
            for j in 0..=layout.q {
                let (u, v) = (i as f64 / layout.p as f64 - 0.5, j as f64 / layout.q as f64 - 0.5);
                let w = if layout.components == COMPONENTS { 1.0 + 0.2 * size * unit() } else { 1.0 };
                let bend = if seed.is_multiple_of(4) { 0.15 } else { 0.04 } * size * size * (unit() + u * v);
                points.push([w * size * (u + 0.5 * v), w * size * v, w * (1.0 + bend), w]);
            }
        }
        let mut net = Vec::new();
        layout.push(&points, &mut net);
        net
    }

    #[test]
    fn bounds_hold_and_are_sharp() {
        let (mut convex, mut nearly) = (0, 0);
        for case in 0..400usize {
            let layout = Layout::new([[3, 3], [2, 4], [5, 3]][case % 3], case % 2 == 0);
            let size = [0.8, 0.3, 0.05][case % 5 % 3];
            let net = net(case as u64, layout, size);
            let limit_sq = [0.9, 1.0, 1.02][case % 7 % 3];
            let ranges = layout.ranges(&net, &mut Vec::new());
            let Some(bend) = bend(&ranges, limit_sq, 0.0) else { continue };
            let low = bend.lowest(&Net { layout, net: &net, error: 1e-16 }, limit_sq, [0.9, 0.2]);
            let mut least = f64::INFINITY;
            for k in 0..=20 {
                for l in 0..=20 {
                    let value = layout.jet(&net, [0.05 * f64::from(k), 0.05 * f64::from(l)])[0];
                    least = least.min(0.5 * product(&value, &value, limit_sq));
                }
            }
            assert!(low.bound - low.noise <= least + 1e-15, "case {case}: {} above {least}", low.bound);
            assert!(low.value >= least - 0.01 * size * size, "case {case}: {} below {least}", low.value);
            convex += usize::from(bend.lack == 0.0);
            nearly += usize::from(bend.lack > 0.0);
        }
        assert!(convex > 15 && nearly > 50, "{convex} {nearly}");
    }

    #[test]
    fn second_derivatives_are_at_least_what_is_said() {
        for case in 0..200 {
            let layout = Layout::new([3, 3], case % 2 == 0);
            let net = net(1000 + case, layout, 0.5);
            let Some(bend) = bend(&layout.ranges(&net, &mut Vec::new()), 1.0, 0.0) else { continue };
            let [e, f] = bend.flattest;
            for k in 0..=10 {
                for l in 0..=10 {
                    let [value, u, v, uu, uv, vv] =
                        layout.jet(&net, [0.1 * f64::from(k), 0.1 * f64::from(l)]);
                    let of = |a: &Homogeneous, b: &Homogeneous| product(a, b, 1.0);
                    let a = of(&u, &u) + of(&value, &uu) + bend.lack * e * e;
                    let c = of(&u, &v) + of(&value, &uv) + bend.lack * e * f;
                    let b = of(&v, &v) + of(&value, &vv) + bend.lack * f * f;
                    assert!(
                        a + b >= 0.0 && a * b - c * c >= -1e-12 * (a + b) * (a + b),
                        "case {case}: {a} {c} {b}"
                    );
                }
            }
        }
    }

    #[test]
    fn valleys_in_which_the_distance_stays() {
        // Next to the axis of a bowl every point of a circle is equally near. A part of it, from an angle to another, by size.
        let bowl = |size: f64| {
            let layout = Layout::new([2, 2], false);
            let (x, y) = (0.6, 0.5);
            let half = 0.61f64;
            // z = x² + y²: the coefficients of a square over an interval are those of its blossom.
            let square = |m: f64, i: usize| {
                [(m - size) * (m - size), (m - size) * (m + size), (m + size) * (m + size)][i]
            };
            let at = |m: f64, i: usize| m + size * (i as f64 - 1.0);
            let height = half + 0.5;
            let points: Vec<Homogeneous> = (0..9)
                .map(|k| [at(x, k / 3), at(y, k % 3), square(x, k / 3) + square(y, k % 3) - height, 1.0])
                .collect();
            let mut net = Vec::new();
            layout.push(&points, &mut net);
            // The distance of the circle of radius² 0.61 from the point at its height and a half above.
            (layout, net, half + 0.25)
        };
        let loss = |size: f64| {
            let (layout, net, distance_sq) = bowl(size);
            let ranges = layout.ranges(&net, &mut Vec::new());
            let thirds = thirds(&ranges, &layout.thirds(&net, &mut Vec::new()), distance_sq);
            let better = valley(&Net { layout, net: &net, error: 1e-16 }, &thirds, distance_sq, [0.5; 2]);
            let mut least = f64::INFINITY;
            for k in 0..=20 {
                for l in 0..=20 {
                    let value = layout.jet(&net, [0.05 * f64::from(k), 0.05 * f64::from(l)])[0];
                    least = least.min(0.5 * product(&value, &value, distance_sq));
                }
            }
            assert!(better.bound <= least + 1e-14, "{size}: {} above {least}", better.bound);
            -better.bound
        };
        let [large, small] = [loss(0.04), loss(0.02)];
        assert!(large < 4e-5 && small > 0.0 && large / small > 12.0, "{large} {small}");
    }

    #[test]
    fn what_a_bent_valley_takes_off() {
        // (t + a s²)² − (a s²)², half of it: at the sides, where s = 1/2, it is lowest at t = −a / 4, and there −a² / 32.
        let layout = Layout::new([2, 1], true);
        for a in [0.01, 0.1, 0.5] {
            let points: Vec<Homogeneous> = (0..6)
                .map(|k| {
                    let square = a * [0.25, -0.25, 0.25][k / 2];
                    [[-0.5, 0.5][k % 2] + square, 0.0, 0.0, square]
                })
                .collect();
            let mut net = Vec::new();
            layout.push(&points, &mut net);
            let ranges = layout.ranges(&net, &mut Vec::new());
            let thirds = thirds(&ranges, &layout.thirds(&net, &mut Vec::new()), 1.0);
            let low = valley(&Net { layout, net: &net, error: 1e-16 }, &thirds, 1.0, [0.5; 2]);
            let truth = -a * a / 32.0;
            assert!(
                low.bound <= truth && low.bound > 20.0 * truth - 0.1 * a,
                "{a}: {} instead of {truth}",
                low.bound
            );
        }
    }
}
