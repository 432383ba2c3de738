//! Lower bounds of parts on which the squared distance is convex, or nearly so.
//!
//! With `N = w (S − x)` the function `g = (|N|² − (w L)²) / 2` is nowhere negative on a part that is nowhere nearer than `L`. Its
//! second derivatives `⟨N_a, N_b⟩ + ⟨N, N_ab⟩`, in the product that takes `L² w w` off, are bounded by the ranges of the factors.
//! Where they are at least `−μ e eᵀ`, `g(z) ≥ g(z₀) + g'(z₀) (z − z₀) − μ (e · (z − z₀))² / 2` (the convex underestimators of
//! \[AMF95\] in one direction).

use super::net::{COMPONENTS, Layout, Ranges};
use crate::global::geometry::Homogeneous;

/// Steps towards the lowest place.
const STEPS: usize = 4;

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
fn product(a: &Homogeneous, b: &Homogeneous, limit_sq: f64) -> f64 {
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
    let root = (0.25 * (a - b) * (a - b) + c * c).sqrt();
    let [low, high] = [0.5 * (a + b) - root, 0.5 * (a + b) + root];
    // The eigenvector of the smaller eigenvalue, from the row that says more.
    let rows = [[a - low, c], [c, b - low]];
    let row = if rows[0][0].abs() + rows[0][1].abs() > rows[1][0].abs() + rows[1][1].abs() {
        rows[0]
    } else {
        rows[1]
    };
    let length = row[0].hypot(row[1]);
    let e = if length > 0.0 { [-row[1] / length, row[0] / length] } else { [1.0, 0.0] };
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
    // Written so that NaN fails.
    if !(across > 0.0) {
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

    /// Looks for the lowest place of the part from `start`; `error` is that of the numbers of the net, per unit of weight.
    #[inline(always)]
    pub(super) fn lowest(
        &self,
        layout: Layout,
        net: &[f64],
        limit_sq: f64,
        start: [f64; 2],
        error: f64,
    ) -> Low {
        let mut at = start;
        let mut best = Low { place: start, value: f64::INFINITY, bound: f64::NEG_INFINITY, noise: 0.0 };
        for _ in 0..STEPS {
            let jet = layout.jet(net, at);
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
            let weight = value[3].abs();
            let length = |a: &Homogeneous| (product(a, a, 0.0) + limit_sq * a[3] * a[3]).sqrt();
            let degrees = (1 + 2 * layout.p + 2 * layout.q) as f64;
            let noise = error * weight * (degrees * length(value) + length(u) + length(v));
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
