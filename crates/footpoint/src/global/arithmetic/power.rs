//! Patches of low degree as polynomials in the distance from an origin of their own, evaluated by Horner's scheme.
//!
//! In `s − 1/2` and `t − 1/2` no coefficient is large against the control points, so that nothing is lost against the
//! Bernstein form; a jet takes half as many operations. A patch with a collapsed edge has its origin there: the
//! coefficients that do not vanish are then multiplied by the way from the pole, and rounding errors shrink with it.
//! The scheme is written once for one place at a time and for several side by side: both give the same bits.

use crate::global::arithmetic::bernstein::binomial;
use crate::global::arithmetic::homogeneous::Homogeneous;
use crate::global::arithmetic::simd::{Pack, Simd};
use nalgebra::Vector3;
use nurbs_core::SurfaceJet;

/// Largest degree that is kept in this form. Lower degrees are filled up with zeros to 2 x 2 or 3 x 3.
pub(crate) const MAX_POWER_DEGREE: usize = 3;

/// Appends the coefficients of a patch, row by row in powers of `s` less its origin, and returns their order (3 or
/// 4); 0, and nothing appended, when the degree is too high. The weights are left out unless the patch is rational.
pub(in crate::global) fn push_powers(
    net: &[Homogeneous],
    [p, q]: [usize; 2],
    origin: [f64; 2],
    rational: bool,
    to: &mut Vec<f64>,
) -> usize {
    if p.max(q) > MAX_POWER_DEGREE {
        return 0;
    }
    let order = p.max(q).max(2) + 1;
    let (by_s, by_t) = (powers_of_bernstein(p, origin[0]), powers_of_bernstein(q, origin[1]));
    for k in 0..order {
        for l in 0..order {
            for c in 0..if rational { 4 } else { 3 } {
                let mut sum = 0.0;
                if k <= p && l <= q {
                    for i in 0..=p {
                        for j in 0..=q {
                            sum += by_s[i][k] * by_t[j][l] * net[i * (q + 1) + j][c];
                        }
                    }
                }
                to.push(sum);
            }
        }
    }
    order
}

/// `[i][k]`: coefficient of `(s − o)^k` in the Bernstein polynomial `i` of degree `n`, `o` the origin.
fn powers_of_bernstein(n: usize, origin: f64) -> Vec<Vec<f64>> {
    let power = |x: f64, k: usize| x.powi(i32::try_from(k).unwrap_or(i32::MAX));
    (0..=n)
        .map(|i| {
            // (o + h)^i (1 − o − h)^(n − i)
            let mut out = vec![0.0; n + 1];
            for a in 0..=i {
                for b in 0..=n - i {
                    let sign = if b % 2 == 0 { 1.0 } else { -1.0 };
                    out[a + b] += sign
                        * binomial(i, a)
                        * binomial(n - i, b)
                        * power(origin, i - a)
                        * power(1.0 - origin, n - i - b);
                }
            }
            out.iter().map(|c| binomial(n, i) * c).collect()
        })
        .collect()
}

/// What Horner's scheme runs on: the coordinates of one place, or of several side by side.
pub(in crate::global) trait Coordinates: Copy {
    /// A parameter of each place.
    type Parameter: Copy;
    /// Numbers per coefficient.
    const COUNT: usize;
    /// The coefficient at the front of a slice, for as many places as there are of a parameter.
    fn load(from: &[f64], t: Self::Parameter) -> Self;
    /// `self · t + next`.
    fn horner(self, t: Self::Parameter, next: Self) -> Self;
}

/// The coordinates of one place; of a polynomial patch (`C = 3`) the fourth is meaningless.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(in crate::global) struct Quad<const C: usize>(pub(in crate::global) [f64; 4]);

impl<const C: usize> Coordinates for Quad<C> {
    type Parameter = f64;
    const COUNT: usize = C;

    #[inline(always)]
    fn load(from: &[f64], _: f64) -> Self {
        // Four at once, whatever `C`: that is one vector.
        Self([from[0], from[1], from[2], from[3]])
    }

    #[inline(always)]
    fn horner(self, t: f64, next: Self) -> Self {
        let mut out = next;
        for c in 0..4 {
            out.0[c] = self.0[c] * t + next.0[c];
        }
        out
    }
}

/// The coordinates of several places.
pub(in crate::global) type Wide<S, const C: usize> = [Pack<S>; C];

impl<S: Simd, const C: usize> Coordinates for Wide<S, C> {
    type Parameter = Pack<S>;
    const COUNT: usize = C;

    #[inline(always)]
    fn load(from: &[f64], t: Pack<S>) -> Self {
        let mut out = [t; C];
        for c in 0..C {
            out[c] = t.all(from[c]);
        }
        out
    }

    #[inline(always)]
    fn horner(self, t: Pack<S>, next: Self) -> Self {
        let mut out = next;
        for c in 0..C {
            out[c] = self[c] * t + next[c];
        }
        out
    }
}

/// Value, s, t, ss, st, tt of a patch of order `N`, at the parameters `s` and `t` less its origin.
#[inline(always)]
pub(in crate::global) fn jet<const N: usize, V: Coordinates>(
    net: &[f64],
    s: V::Parameter,
    t: V::Parameter,
) -> [V; 6] {
    // What is not set in the first round is not read before it is.
    let mut a = [V::load(net, s); 6];
    for done in 0..N {
        let row = (N - 1 - done) * N;
        let load = |j: usize| V::load(&net[(row + j) * V::COUNT..], t);
        // Value, derivative, and half of the second derivative of the row.
        let mut value = load(N - 1);
        let (mut first, mut second) = (value, value);
        for taken in 1..N {
            if taken > 2 {
                second = second.horner(t, first);
            } else if taken == 2 {
                second = first;
            }
            first = if taken > 1 { first.horner(t, value) } else { value };
            value = value.horner(t, load(N - 1 - taken));
        }
        if done == 0 {
            (a[0], a[2], a[5]) = (value, first, second);
            continue;
        }
        if done > 2 {
            a[3] = a[3].horner(s, a[1]);
        } else if done == 2 {
            a[3] = a[1];
        }
        if done > 1 {
            (a[1], a[4]) = (a[1].horner(s, a[0]), a[4].horner(s, a[2]));
        } else {
            (a[1], a[4]) = (a[0], a[2]);
        }
        (a[0], a[2], a[5]) = (a[0].horner(s, value), a[2].horner(s, first), a[5].horner(s, second));
    }
    a
}

/// The value alone.
#[inline(always)]
pub(in crate::global) fn value<const N: usize, V: Coordinates>(
    net: &[f64],
    s: V::Parameter,
    t: V::Parameter,
) -> V {
    let row = |i: usize| {
        let load = |j: usize| V::load(&net[(i * N + j) * V::COUNT..], t);
        let mut value = load(N - 1);
        for j in (0..N - 1).rev() {
            value = value.horner(t, load(j));
        }
        value
    };
    let mut value = row(N - 1);
    for i in (0..N - 1).rev() {
        value = value.horner(s, row(i));
    }
    value
}

/// The jet of one place, from what [`jet`] returns.
#[inline(always)]
pub(in crate::global) fn surface_jet<const C: usize>(a: &[Quad<C>; 6]) -> SurfaceJet {
    let v = |k: usize| Vector3::new(a[k].0[0], a[k].0[1], a[k].0[2]);
    let (duu, dvv) = (v(3) * 2.0, v(5) * 2.0);
    if C == 3 {
        return SurfaceJet { point: v(0), du: v(1), dv: v(2), duu, duv: v(4), dvv };
    }
    let w = |k: usize| a[k].0[3];
    let (wuu, wvv) = (w(3) * 2.0, w(5) * 2.0);
    let inverse = 1.0 / w(0);
    let point = v(0) * inverse;
    let du = (v(1) - point * w(1)) * inverse;
    let dv = (v(2) - point * w(2)) * inverse;
    SurfaceJet {
        point,
        du,
        dv,
        duu: (duu - du * (2.0 * w(1)) - point * wuu) * inverse,
        duv: (v(4) - du * w(2) - dv * w(1) - point * w(4)) * inverse,
        dvv: (dvv - dv * (2.0 * w(2)) - point * wvv) * inverse,
    }
}

/// The jets of several places, from what [`jet`] returns: x, y, z of value, s, t, ss, st, tt.
#[inline(always)]
pub(in crate::global) fn wide_jets<S: Simd, const C: usize>(a: &[Wide<S, C>; 6]) -> [Wide<S, 3>; 6] {
    let mut out = [[a[0][0]; 3]; 6];
    for c in 0..3 {
        for k in 0..6 {
            out[k][c] = if k == 3 || k == 5 { a[k][c] * 2.0 } else { a[k][c] };
        }
    }
    if C == 3 {
        return out;
    }
    let w: [Pack<S>; 6] = std::array::from_fn(|k| a[k][C - 1]);
    let (wuu, wvv) = (w[3] * 2.0, w[5] * 2.0);
    let inverse = w[0].all(1.0) / w[0];
    for c in 0..3 {
        let point = out[0][c] * inverse;
        let du = (out[1][c] - point * w[1]) * inverse;
        let dv = (out[2][c] - point * w[2]) * inverse;
        out[3][c] = (out[3][c] - du * (w[1] * 2.0) - point * wuu) * inverse;
        out[4][c] = (out[4][c] - du * w[2] - dv * w[1] - point * w[4]) * inverse;
        out[5][c] = (out[5][c] - dv * (w[2] * 2.0) - point * wvv) * inverse;
        (out[0][c], out[1][c], out[2][c]) = (point, du, dv);
    }
    out
}

#[cfg(test)]
#[expect(clippy::cast_possible_truncation, reason = "small degrees")]
mod tests {
    use super::super::simd::Scalar;
    use super::*;

    #[test]
    fn powers_give_the_bernstein_polynomials() {
        for n in 1..=MAX_POWER_DEGREE {
            for origin in [0.0, 0.5, 1.0] {
                let powers = powers_of_bernstein(n, origin);
                for s in [0.0, 0.3, 0.5, 1.0f64] {
                    for i in 0..=n {
                        let value: f64 = (0..=n).map(|k| powers[i][k] * (s - origin).powi(k as i32)).sum();
                        let exact = binomial(n, i) * s.powi(i as i32) * (1.0 - s).powi((n - i) as i32);
                        assert!((value - exact).abs() < 2e-15, "{n} {i} {s}: {value} {exact}");
                    }
                }
            }
        }
    }

    /// `Σ c_kl s^k t^l` with `c_kl = 1 + k + 2 l`, weights included, against derivatives by hand.
    #[test]
    fn one_place_and_several_have_the_same_bits() {
        let net: Vec<f64> =
            (0..64).map(|i| (f64::from(i) * 0.754_877_666).fract() + 0.25).chain([0.0]).collect();
        let (s, t) = (0.1, -0.3);
        let single = jet::<4, Quad<4>>(&net, s, t);
        let pack = |value| Pack::splat(Scalar, value);
        let wide = jet::<4, Wide<Scalar, 4>>(&net, pack(s), pack(t));
        for k in 0..6 {
            for c in 0..4 {
                let (i_min, j_min) = ([0, 1, 0, 2, 1, 0][k], [0, 0, 1, 0, 1, 2][k]);
                let mut sum = 0.0;
                for i in i_min..4usize {
                    for j in j_min..4usize {
                        let taken = |n: usize, d: usize| {
                            [1.0, n as f64, (n * n) as f64 - n as f64][d] / [1.0, 1.0, 2.0][d]
                        };
                        sum += net[(4 * i + j) * 4 + c]
                            * taken(i, i_min)
                            * taken(j, j_min)
                            * s.powi((i - i_min) as i32)
                            * t.powi((j - j_min) as i32);
                    }
                }
                assert!((single[k].0[c] - sum).abs() < 1e-14, "{k} {c}");
                assert_eq!(wide[k][c].at(0), single[k].0[c]);
            }
        }
        let (one, lanes) = (surface_jet(&single), wide_jets(&wide));
        for (vector, lane) in [one.point, one.du, one.dv, one.duu, one.duv, one.dvv].iter().zip(&lanes) {
            for c in 0..3 {
                assert_eq!(lane[c].at(0), vector[c]);
            }
        }
        assert_eq!(value::<4, Quad<4>>(&net, s, t).0, single[0].0);
    }
}
