//! Eight doubles that the compiler keeps in vector registers, and rows of Bernstein coefficients.

use std::ops::{Add, Div, Mul, Sub};

/// Number of doubles in a [`Lanes`].
pub(crate) const WIDTH: usize = 8;

/// Eight doubles side by side.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct Lanes(pub(crate) [f64; WIDTH]);

macro_rules! lanewise {
    ($trait:ident, $method:ident, $op:tt) => {
        impl $trait for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                let mut out = self;
                for l in 0..WIDTH {
                    out.0[l] = self.0[l] $op other.0[l];
                }
                out
            }
        }
    };
}
lanewise!(Add, add, +);
lanewise!(Sub, sub, -);
lanewise!(Mul, mul, *);
lanewise!(Div, div, /);

impl Mul<f64> for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        let mut out = self;
        for l in 0..WIDTH {
            out.0[l] = self.0[l] * factor;
        }
        out
    }
}

impl Lanes {
    #[inline(always)]
    pub(crate) fn splat(value: f64) -> Self {
        Self([value; WIDTH])
    }

    /// Lane by lane the smaller value (the one of `other` when `self` is NaN).
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        let mut out = self;
        for l in 0..WIDTH {
            out.0[l] = if self.0[l] < other.0[l] { self.0[l] } else { other.0[l] };
        }
        out
    }

    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        let mut out = self;
        for l in 0..WIDTH {
            out.0[l] = if self.0[l] > other.0[l] { self.0[l] } else { other.0[l] };
        }
        out
    }

    #[inline(always)]
    pub(crate) fn horizontal_min(self) -> f64 {
        let a = self.0;
        let m = |x: f64, y: f64| if x < y { x } else { y };
        m(m(m(a[0], a[4]), m(a[1], a[5])), m(m(a[2], a[6]), m(a[3], a[7])))
    }

    #[inline(always)]
    pub(crate) fn horizontal_max(self) -> f64 {
        let a = self.0;
        let m = |x: f64, y: f64| if x > y { x } else { y };
        m(m(m(a[0], a[4]), m(a[1], a[5])), m(m(a[2], a[6]), m(a[3], a[7])))
    }

    /// Sum in a fixed order.
    #[inline(always)]
    pub(crate) fn sum(self) -> f64 {
        let a = self.0;
        ((a[0] + a[4]) + (a[1] + a[5])) + ((a[2] + a[6]) + (a[3] + a[7]))
    }
}

/// `8 K` Bernstein coefficients: a polynomial of degree `8 K − 1` in one variable.
pub(crate) type Row<const K: usize> = [Lanes; K];

#[inline(always)]
pub(crate) fn zero_row<const K: usize>() -> Row<K> {
    [Lanes::splat(0.0); K]
}

/// `row + other · factor`.
#[inline(always)]
pub(crate) fn add_scaled<const K: usize>(row: &mut Row<K>, other: &Row<K>, factor: f64) {
    for k in 0..K {
        row[k] = row[k] + other[k] * factor;
    }
}

#[inline(always)]
pub(crate) fn subtract<const K: usize>(a: &Row<K>, b: &Row<K>) -> Row<K> {
    let mut out = *a;
    for k in 0..K {
        out[k] = a[k] - b[k];
    }
    out
}

/// The forward differences `x_{j+1} − x_j`; the last one is repeated to fill the row.
#[inline(always)]
pub(crate) fn differences<const K: usize>(row: &Row<K>) -> Row<K> {
    let mut out = shifted(row);
    for k in 0..K {
        out[k] = out[k] - row[k];
    }
    out[K - 1].0[WIDTH - 1] = out[K - 1].0[WIDTH - 2];
    out
}

/// The second differences of a row, from its first ones; the last one is repeated to fill the row.
#[inline(always)]
pub(crate) fn second_differences<const K: usize>(first: &Row<K>) -> Row<K> {
    let mut out = differences(first);
    out[K - 1].0[WIDTH - 2] = out[K - 1].0[WIDTH - 3];
    out[K - 1].0[WIDTH - 1] = out[K - 1].0[WIDTH - 3];
    out
}

/// Every coefficient replaced by its successor; the last one stays.
#[inline(always)]
fn shifted<const K: usize>(row: &Row<K>) -> Row<K> {
    let mut out = *row;
    for k in 0..K {
        for l in 0..WIDTH - 1 {
            out[k].0[l] = row[k].0[l + 1];
        }
        if k + 1 < K {
            out[k].0[WIDTH - 1] = row[k + 1].0[0];
        }
    }
    out
}

/// The smallest coefficient of a row.
#[inline(always)]
pub(crate) fn row_min<const K: usize>(row: &Row<K>) -> f64 {
    let mut all = row[0];
    for k in 1..K {
        all = all.min(row[k]);
    }
    all.horizontal_min()
}

/// The largest coefficient of a row.
#[inline(always)]
pub(crate) fn row_max<const K: usize>(row: &Row<K>) -> f64 {
    let mut all = row[0];
    for k in 1..K {
        all = all.max(row[k]);
    }
    all.horizontal_max()
}

/// Lane by lane smaller, and larger, values of two rows.
#[inline(always)]
pub(crate) fn widen<const K: usize>(low: &mut Row<K>, high: &mut Row<K>, row: &Row<K>) {
    for k in 0..K {
        low[k] = low[k].min(row[k]);
        high[k] = high[k].max(row[k]);
    }
}

/// `Σ row_j · values_j`.
#[inline(always)]
pub(crate) fn dot<const K: usize>(row: &Row<K>, values: &Row<K>) -> f64 {
    let mut all = row[0] * values[0];
    for k in 1..K {
        all = all + row[k] * values[k];
    }
    all.sum()
}
