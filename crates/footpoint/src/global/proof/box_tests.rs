//! Tests of one box of a patch: what the Bernstein coefficients of a polynomial tell about it.

use crate::global::arithmetic::bernstein::basis_rows;
use crate::global::arithmetic::lanes::{
    Lanes, Row, WIDTH, add_scaled, differences, dot, row_max, row_min, second_differences, subtract, widen,
    zero_row,
};

/// Ranges of the differences of the coefficients of a form over a box.
pub(crate) struct Bends {
    pub(crate) du: [f64; 2],
    pub(crate) dv: [f64; 2],
    pub(crate) duu: [f64; 2],
    pub(crate) dvv: [f64; 2],
    pub(crate) duv: [f64; 2],
}

/// Largest absolute value of the coefficients.
#[inline(always)]
pub(crate) fn largest<const K: usize>(rows: &[Row<K>]) -> f64 {
    let (mut low, mut high) = (rows[0], rows[0]);
    for row in &rows[1..] {
        widen(&mut low, &mut high, row);
    }
    row_max(&high).abs().max(row_min(&low).abs())
}

/// The coefficients on the lower or upper side of direction `d`, and their degree.
#[inline(always)]
pub(crate) fn edge<const K: usize>(rows: &[Row<K>], d: usize, end: usize) -> (Row<K>, usize) {
    if d == 0 {
        return (rows[end * (rows.len() - 1)], WIDTH * K - 1);
    }
    let mut column = zero_row::<K>();
    for (i, row) in rows.iter().enumerate() {
        column[i / WIDTH].0[i % WIDTH] = if end == 0 { row[0].0[0] } else { row[K - 1].0[WIDTH - 1] };
    }
    (column, rows.len() - 1)
}

/// Row and column of the smallest coefficient.
#[inline(always)]
fn argmin_index<const K: usize>(rows: &[Row<K>]) -> (usize, usize) {
    let mut best = (f64::INFINITY, 0, 0);
    for (i, row) in rows.iter().enumerate() {
        if row_min(row) < best.0 {
            for j in 0..WIDTH * K {
                let value = row[j / WIDTH].0[j % WIDTH];
                if value < best.0 {
                    best = (value, i, j);
                }
            }
        }
    }
    (best.1, best.2)
}

/// Place of the smallest coefficient, in box parameters.
#[inline(always)]
pub(crate) fn argmin<const K: usize>(rows: &[Row<K>]) -> [f64; 2] {
    let (i, j) = argmin_index(rows);
    [i as f64 / (rows.len() - 1) as f64, j as f64 / (WIDTH * K - 1) as f64]
}

#[inline(always)]
pub(crate) fn bends<const K: usize>(rows: &[Row<K>]) -> Bends {
    let m = rows.len();
    let inf = [Lanes::splat(f64::INFINITY); K];
    let ninf = [Lanes::splat(f64::NEG_INFINITY); K];
    let (mut du, mut dv, mut duu, mut dvv, mut duv) =
        ((inf, ninf), (inf, ninf), (inf, ninf), (inf, ninf), (inf, ninf));
    let mut previous = zero_row::<K>();
    for i in 0..m {
        let along = differences(&rows[i]);
        widen(&mut dv.0, &mut dv.1, &along);
        widen(&mut dvv.0, &mut dvv.1, &second_differences(&along));
        if i + 1 < m {
            let across = subtract(&rows[i + 1], &rows[i]);
            widen(&mut du.0, &mut du.1, &across);
            widen(&mut duv.0, &mut duv.1, &differences(&across));
            if i > 0 {
                widen(&mut duu.0, &mut duu.1, &subtract(&across, &previous));
            }
            previous = across;
        }
    }
    Bends {
        du: [row_min(&du.0), row_max(&du.1)],
        dv: [row_min(&dv.0), row_max(&dv.1)],
        duu: [row_min(&duu.0), row_max(&duu.1)],
        dvv: [row_min(&dvv.0), row_max(&dvv.1)],
        duv: [row_min(&duv.0), row_max(&duv.1)],
    }
}

/// Value, gradient and Hessian (`ss`, `st`, `tt`) of `G` at a place of the box.
#[inline(always)]
pub(crate) fn evaluate<const K: usize>(rows: &[Row<K>], at: [f64; 2]) -> (f64, [f64; 2], [f64; 3]) {
    let bu = basis_rows::<K>(rows.len() - 1, at[0]);
    let mut sums = [zero_row::<K>(); 3];
    for (i, row) in rows.iter().enumerate() {
        for d in 0..3 {
            add_scaled(&mut sums[d], row, bu[d][i / WIDTH].0[i % WIDTH]);
        }
    }
    let bv = basis_rows::<K>(WIDTH * K - 1, at[1]);
    (
        dot(&sums[0], &bv[0]),
        [dot(&sums[1], &bv[0]), dot(&sums[0], &bv[1])],
        [dot(&sums[2], &bv[0]), dot(&sums[1], &bv[1]), dot(&sums[0], &bv[2])],
    )
}

/// The direction in which the control net sags most at its lowest coefficient.
#[inline(always)]
pub(crate) fn sag_direction<const K: usize>(rows: &[Row<K>]) -> usize {
    let (m, n) = (rows.len() - 1, WIDTH * K - 1);
    let (i, j) = argmin_index(rows);
    let at = |i: usize, j: usize| rows[i][j / WIDTH].0[j % WIDTH];
    let second = |a: f64, b: f64, c: f64| (a - 2.0 * b + c).abs();
    let (ci, cj) = (i.clamp(1, m.max(2) - 1), j.clamp(1, n - 1));
    let sag_u = if m >= 2 { second(at(ci - 1, j), at(ci, j), at(ci + 1, j)) * (m * m) as f64 } else { 0.0 };
    let sag_v = second(at(i, cj - 1), at(i, cj), at(i, cj + 1)) * (n * n) as f64;
    usize::from(sag_v > sag_u)
}
