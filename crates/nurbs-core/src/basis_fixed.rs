//! Basis functions of degrees 1 to 5, compiled for each degree and for any number of lanes.
//!
//! The recurrence of [PT97, A2.2] with the reciprocals of the knot differences taken from the knot
//! vector's table. The derivatives are differences of `N / (t_right − t_left)` of one degree less, which
//! the recurrence computes anyway. Every level is a function of constant length: loops over a triangle
//! would not be unrolled, and the rows would live in memory (five times slower).

use crate::KnotVector;
use crate::simd::Lanes;

/// The distances from `t` to the knots around its span, and the reciprocals of the span.
struct Distances<'a, V, const N: usize> {
    reciprocals: &'a [f64],
    /// `t_{s+1+r} − t`.
    right: [V; N],
    /// `t − t_{s−r}`.
    left: [V; N],
}

impl<'a, V: Copy, const N: usize> Distances<'a, V, N> {
    #[inline(always)]
    fn new<L: Lanes<V = V>>(l: L, knots: &'a KnotVector, span: usize, t: V) -> Self {
        let p = N - 1;
        let around = &knots.as_slice()[span + 1 - p..][..2 * p];
        let (mut right, mut left) = ([t; N], [t; N]);
        for r in 0..p {
            right[r] = l.sub(l.splat(around[p + r]), t);
            left[r] = l.sub(t, l.splat(around[p - 1 - r]));
        }
        Self { reciprocals: &knots.table().reciprocals(p, span)[..p * N / 2], right, left }
    }

    /// From the functions of degree `J − 1`: them divided by the length of their support.
    #[inline(always)]
    fn quotients<L: Lanes<V = V>, const J: usize>(&self, l: L, row: &[V; N]) -> [V; N] {
        let mut out = *row;
        for r in 0..J {
            out[r] = l.mul(row[r], l.splat(self.reciprocals[J * (J - 1) / 2 + r]));
        }
        out
    }

    /// From these quotients to the functions of degree `J`.
    #[inline(always)]
    fn raise<L: Lanes<V = V>, const J: usize>(&self, l: L, quotients: &[V; N], row: &mut [V; N]) {
        row[0] = l.mul(self.right[0], quotients[0]);
        for r in 1..J {
            let falling = l.mul(self.left[J - r], quotients[r - 1]);
            row[r] = l.add(falling, l.mul(self.right[r], quotients[r]));
        }
        row[J] = l.mul(self.left[0], quotients[J - 1]);
    }

    /// Level `J` of the recurrence for the values alone.
    #[inline(always)]
    fn value_level<L: Lanes<V = V>, const J: usize>(&self, l: L, row: &mut [V; N]) {
        if J < N {
            let quotients = self.quotients::<L, J>(l, row);
            self.raise::<L, J>(l, &quotients, row);
        }
    }

    /// Level `J` of the recurrence, derivatives included.
    #[inline(always)]
    fn jet_level<L: Lanes<V = V>, const J: usize>(&self, l: L, rows: &mut [[V; N]; 3]) {
        let p = N - 1;
        if J > p {
            return;
        }
        let quotients = self.quotients::<L, J>(l, &rows[0]);
        if J + 1 == p {
            // The derivatives of degree p − 1, but for the factor p − 1 …
            rows[2] = differences::<L, J, N>(l, &quotients);
        }
        if J == p {
            let mut scaled = quotients;
            for r in 0..J {
                scaled[r] = l.mul(quotients[r], l.splat(p as f64));
            }
            rows[1] = differences::<L, J, N>(l, &scaled);
            if p > 1 {
                // … and from them the second ones of degree p.
                let mut scaled = rows[2];
                for r in 0..J {
                    let factor = (p * (p - 1)) as f64 * self.reciprocals[J * (J - 1) / 2 + r];
                    scaled[r] = l.mul(scaled[r], l.splat(factor));
                }
                rows[2] = differences::<L, J, N>(l, &scaled);
            }
        }
        self.raise::<L, J>(l, &quotients, &mut rows[0]);
    }
}

/// `from[r − 1] − from[r]` for `r = 0…J`, where `from[−1] = from[J] = 0`.
#[inline(always)]
fn differences<L: Lanes, const J: usize, const N: usize>(l: L, from: &[L::V; N]) -> [L::V; N] {
    let mut out = *from;
    out[0] = l.sub(l.splat(0.0), from[0]);
    for r in 1..J {
        out[r] = l.sub(from[r - 1], from[r]);
    }
    out[J] = from[J - 1];
    out
}

/// Values of the `N = p + 1` functions of a span.
#[inline(always)]
pub(crate) fn values<L: Lanes, const N: usize>(l: L, knots: &KnotVector, span: usize, t: L::V) -> [L::V; N] {
    let distances = Distances::<L::V, N>::new(l, knots, span, t);
    let mut row = [l.splat(1.0); N];
    distances.value_level::<L, 1>(l, &mut row);
    distances.value_level::<L, 2>(l, &mut row);
    distances.value_level::<L, 3>(l, &mut row);
    distances.value_level::<L, 4>(l, &mut row);
    distances.value_level::<L, 5>(l, &mut row);
    row
}

/// Values, first and second derivatives of the `N = p + 1` functions of a span.
#[inline(always)]
pub(crate) fn jet<L: Lanes, const N: usize>(
    l: L,
    knots: &KnotVector,
    span: usize,
    t: L::V,
) -> [[L::V; N]; 3] {
    let distances = Distances::<L::V, N>::new(l, knots, span, t);
    let mut rows = [[l.splat(1.0); N], [l.splat(0.0); N], [l.splat(0.0); N]];
    distances.jet_level::<L, 1>(l, &mut rows);
    distances.jet_level::<L, 2>(l, &mut rows);
    distances.jet_level::<L, 3>(l, &mut rows);
    distances.jet_level::<L, 4>(l, &mut rows);
    distances.jet_level::<L, 5>(l, &mut rows);
    rows
}
