//! Ranges of numbers, as middle and half of the length.

use crate::global::arithmetic::simd::vectorized;
use crate::global::proof::hulls::net::{COMPONENTS, Layout};
use std::ops::{Add, Mul, Sub};

/// All numbers that are at most `half` away from `middle`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Span {
    pub(super) middle: f64,
    pub(super) half: f64,
}

/// Share by which results are widened for the rounding errors of an operation.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

impl Span {
    pub(super) fn new([middle, half]: [f64; 2]) -> Self {
        Self { middle, half }
    }

    /// Widened for the rounding errors of operands of this size.
    fn widened(self, size: f64) -> Self {
        Self { half: self.half + ROUNDING * size, ..self }
    }

    /// Largest absolute value.
    pub(super) fn most(self) -> f64 {
        self.middle.abs() + self.half
    }

    /// One over all of the numbers; without bounds unless they are positive.
    pub(super) fn inverse(self) -> Self {
        let (low, high) = (self.middle - self.half, self.middle + self.half);
        if !(low > 0.0 && high.is_finite()) {
            return Self { middle: 0.0, half: f64::INFINITY };
        }
        let (low, high) = (1.0 / high, 1.0 / low);
        Self { middle: 0.5 * (low + high), half: 0.5 * (high - low) }.widened(high)
    }
}

impl Add for Span {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let size = self.most() + other.most();
        Self { middle: self.middle + other.middle, half: self.half + other.half }.widened(size)
    }
}

impl Sub for Span {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + other * -1.0
    }
}

impl Mul<f64> for Span {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self { middle: self.middle * factor, half: self.half * factor.abs() }
            .widened(self.most() * factor.abs())
    }
}

impl Mul for Span {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let half = self.middle.abs() * other.half + other.middle.abs() * self.half + self.half * other.half;
        Self { middle: self.middle * other.middle, half }.widened(self.most() * other.most())
    }
}

/// The ranges of the components of a net: value, `u`, `v`, `uu`, `uv`, `vv`, `uuu`, `uuv`, `uvv`, `vvv`.
pub(super) fn spans(layout: Layout, net: &[f64]) -> [[Span; 10]; COMPONENTS] {
    let mut work = Vec::new();
    let (ranges, thirds) = vectorized(
        #[inline(always)]
        || (layout.ranges(net, &mut work), layout.thirds(net, &mut work)),
    );
    let mut all = [[Span::default(); 10]; COMPONENTS];
    for (c, all) in all.iter_mut().enumerate() {
        for (k, span) in all.iter_mut().enumerate() {
            *span = Span::new(if k < 6 { ranges.parts[c][k] } else { thirds[c][k - 6] });
        }
    }
    all
}

/// Value and derivatives of quotients, from those of numerators and denominators, and the range of the quotients themselves.
pub(super) fn quotient(a: &[Span; 10], w: &[Span; 10], value: Span) -> [Span; 10] {
    let inverse = w[0].inverse();
    let s = value;
    let u = (a[1] - s * w[1]) * inverse;
    let v = (a[2] - s * w[2]) * inverse;
    let uu = (a[3] - u * w[1] * 2.0 - s * w[3]) * inverse;
    let uv = (a[4] - u * w[2] - v * w[1] - s * w[4]) * inverse;
    let vv = (a[5] - v * w[2] * 2.0 - s * w[5]) * inverse;
    let uuu = (a[6] - uu * w[1] * 3.0 - u * w[3] * 3.0 - s * w[6]) * inverse;
    let uuv = (a[7] - uv * w[1] * 2.0 - uu * w[2] - v * w[3] - u * w[4] * 2.0 - s * w[7]) * inverse;
    let uvv = (a[8] - uv * w[2] * 2.0 - vv * w[1] - u * w[5] - v * w[4] * 2.0 - s * w[8]) * inverse;
    let vvv = (a[9] - vv * w[2] * 3.0 - v * w[5] * 3.0 - s * w[9]) * inverse;
    [s, u, v, uu, uv, vv, uuu, uuv, uvv, vvv]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ends(span: Span) -> [f64; 2] {
        [span.middle - span.half, span.middle + span.half]
    }

    #[test]
    fn results_hold_all_combinations() {
        let spans = [[2.0, 1.0], [-1.0, 0.5], [0.25, 1.0], [3.0, 0.0]].map(Span::new);
        for a in spans {
            for b in spans {
                for i in -2..=2 {
                    for j in -2..=2 {
                        let at = |span: Span, k: i32| span.middle + span.half * 0.5 * f64::from(k);
                        let (x, y) = (at(a, i), at(b, j));
                        for (found, value) in
                            [(a + b, x + y), (a - b, x - y), (a * b, x * y), (a * 1.5, x * 1.5)]
                        {
                            let [low, high] = ends(found);
                            assert!(low <= value && value <= high, "{a:?} {b:?} {value}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn inverses_are_those_of_the_ends() {
        let [low, high] = ends(Span::new([3.0, 1.0]).inverse());
        assert!((low - 0.25).abs() < 1e-14 && (high - 0.5).abs() < 1e-14);
        assert_eq!(Span::new([1.0, 1.0]).inverse().half, f64::INFINITY);
    }
}
