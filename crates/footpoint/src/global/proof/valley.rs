//! Lower bounds for boxes that are convex in one parameter.
//!
//! `G(u, v) = Σ B_j(v) c_j(u)`: where every `c_j` is a convex polynomial of one variable, the least of their minima
//! is a lower bound of `G`, and the minima are found by Newton's method, for all `j` at once. This settles axes and
//! centres, where whole curves of points are equally near, and the surroundings of poles.

use crate::global::arithmetic::lanes::{Lanes, Row, WIDTH, row_min, zero_row};

/// Steps of Newton's method.
const STEPS: usize = 3;

/// A lower bound of a box, and where the first and last of the convex polynomials are lowest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Valley {
    pub(crate) bound: f64,
    pub(crate) ends: [f64; 2],
}

/// Share of the depth of the control net below zero that must come from its distance to the polynomials for a
/// valley to be worth looking at.
const RECOVERED: f64 = 0.8;

/// Whether the minima of the polynomials in `u` may be above zero though coefficients down to `min` are below: each
/// polynomial lies above its coefficients by about `s (1 − s) (m − 1) / 2` second differences.
#[inline(always)]
pub(crate) fn is_promising_u<const K: usize>(rows: &[Row<K>], min: f64) -> bool {
    let m = rows.len() - 1;
    let enough = Lanes::splat((1.0 - RECOVERED) * min);
    let mut low = [Lanes::splat(0.0); K];
    for i in 0..=m {
        let s = i as f64 / m as f64;
        let factor = 0.5 * s * (1.0 - s) * (m as f64 - 1.0);
        let (before, after) = (&rows[i.max(1) - 1], &rows[(i + 1).min(m)]);
        for k in 0..K {
            let bend = (before[k] - rows[i][k]) + (after[k] - rows[i][k]);
            low[k] = low[k].min(rows[i][k] + bend * factor - enough);
        }
    }
    row_min(&low) >= 0.0
}

/// As [`is_promising_u`], for the polynomials in `v`.
#[inline(always)]
pub(crate) fn is_promising_v<const K: usize>(rows: &[Row<K>], min: f64) -> bool {
    let n = WIDTH * K - 1;
    let enough = (1.0 - RECOVERED) * min;
    let mut factors = zero_row::<K>();
    for j in 1..n {
        let s = j as f64 / n as f64;
        factors[j / WIDTH].0[j % WIDTH] = 0.5 * s * (1.0 - s) * (n as f64 - 1.0);
    }
    let mut low = zero_row::<K>();
    for row in rows {
        for k in 0..K {
            let mut value = row[k];
            for l in 0..WIDTH {
                let j = k * WIDTH + l;
                let (a, c) = (j.max(1) - 1, (j + 1).min(n));
                let bend =
                    (row[a / WIDTH].0[a % WIDTH] - row[k].0[l]) + (row[c / WIDTH].0[c % WIDTH] - row[k].0[l]);
                value.0[l] = row[k].0[l] + bend * factors[k].0[l] - enough;
            }
            low[k] = low[k].min(value);
        }
    }
    row_min(&low) >= 0.0
}

/// Lower bound of the box from polynomials in `u`, if all are convex; `slack` is taken off their second differences,
/// `start` is a guess.
#[inline(always)]
pub(crate) fn valley<const K: usize>(
    rows: &[Row<K>],
    count: usize,
    start: f64,
    slack: f64,
) -> Option<Valley> {
    let m = rows.len() - 1;
    if m < 2 {
        return None;
    }
    let mut bound = f64::INFINITY;
    let mut ends = [0.0; 2];
    for k in 0..K {
        if k * WIDTH >= count {
            break;
        }
        let mut bend = Lanes::splat(f64::INFINITY);
        for i in 1..m {
            bend = bend.min((rows[i - 1][k] - rows[i][k]) + (rows[i + 1][k] - rows[i][k]));
        }
        let strength = (bend - Lanes::splat(slack)) * (m * (m - 1)) as f64;
        let mut s = Lanes::splat(start);
        for step in 0..=STEPS {
            let [value, slope, second] = lanes_jet(rows, k, s);
            let mut next = s;
            for l in 0..WIDTH {
                // A slope that points out of the box at its border takes nothing away.
                let blocked = (s.0[l] <= 0.0 && slope.0[l] > 0.0) || (s.0[l] >= 1.0 && slope.0[l] < 0.0);
                let fall = if blocked { 0.0 } else { slope.0[l] };
                if step < STEPS {
                    next.0[l] = (s.0[l] - fall / second.0[l].max(strength.0[l])).clamp(0.0, 1.0);
                } else if k * WIDTH + l < count {
                    let here = value.0[l] - 0.5 * fall * fall / strength.0[l];
                    // Written so that NaN fails.
                    if !(strength.0[l] > 0.0 && here > f64::NEG_INFINITY) {
                        return None;
                    }
                    bound = bound.min(here);
                }
            }
            s = next;
        }
        if k == 0 {
            ends[0] = s.0[0];
        }
        if k == (count - 1) / WIDTH {
            ends[1] = s.0[(count - 1) % WIDTH];
        }
    }
    Some(Valley { bound, ends })
}

/// Value, first and second derivative in `u` of eight of the polynomials, each at a parameter of its own.
#[inline(always)]
fn lanes_jet<const K: usize>(rows: &[Row<K>], k: usize, s: Lanes) -> [Lanes; 3] {
    // Counts known to the compiler keep the basis in registers: those of quadratic and cubic patches, and of their
    // transposed forms.
    match rows.len() {
        5 => lanes_jet_of(rows, 5, k, s),
        7 => lanes_jet_of(rows, 7, k, s),
        8 => lanes_jet_of(rows, 8, k, s),
        count => lanes_jet_of(rows, count, k, s),
    }
}

/// [`lanes_jet`] of `count` rows.
#[inline(always)]
fn lanes_jet_of<const K: usize>(rows: &[Row<K>], count: usize, k: usize, s: Lanes) -> [Lanes; 3] {
    let m = count - 1;
    let r = Lanes::splat(1.0) - s;
    // The basis of degree m − 2 meets the coefficients and their differences.
    let mut basis = [[Lanes::splat(0.0); WIDTH]; K];
    let basis = &mut basis.as_flattened_mut()[..m - 1];
    basis[0] = Lanes::splat(1.0);
    for degree in 1..m - 1 {
        basis[degree] = basis[degree - 1] * s;
        for i in (1..degree).rev() {
            basis[i] = basis[i] * r + basis[i - 1] * s;
        }
        basis[0] = basis[0] * r;
    }
    // The last three control points of de Casteljau's scheme.
    let mut last = [Lanes::splat(0.0); 3];
    for i in 0..m - 1 {
        for (d, slot) in last.iter_mut().enumerate() {
            *slot = *slot + basis[i] * rows[i + d][k];
        }
    }
    let [a, b, c] = last;
    let (low, high) = (r * a + s * b, r * b + s * c);
    let m = m as f64;
    [r * low + s * high, (high - low) * m, ((a - b) + (c - b)) * (m * (m - 1.0))]
}

/// Rows with the two directions exchanged; lanes beyond the number of rows are zero.
#[inline(always)]
pub(crate) fn transpose<const K: usize>(rows: &[Row<K>], out: &mut Vec<Row<K>>) {
    out.clear();
    out.resize(WIDTH * K, zero_row());
    for (i, row) in rows.iter().enumerate() {
        for k in 0..K {
            for l in 0..WIDTH {
                out[k * WIDTH + l][i / WIDTH].0[i % WIDTH] = row[k].0[l];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Coefficients of `(s − a)² + e` in degree 2.
    fn parabola(a: f64, e: f64) -> [f64; 3] {
        [a * a + e, a * a - a + e, (1.0 - a) * (1.0 - a) + e]
    }

    #[test]
    fn the_least_of_the_minima() {
        let columns: Vec<[f64; 3]> =
            (0..8).map(|j| parabola(0.1 * f64::from(j), 1.0 - 0.1 * f64::from(j))).collect();
        let rows: Vec<Row<1>> = (0..3).map(|i| [Lanes(std::array::from_fn(|j| columns[j][i]))]).collect();
        let found = valley(&rows, 8, 0.5, 0.0).unwrap();
        assert!((found.bound - 0.3).abs() < 1e-14, "{found:?}");
        assert!((found.ends[0]).abs() < 1e-14 && (found.ends[1] - 0.7).abs() < 1e-14, "{found:?}");
        let mut across = Vec::new();
        transpose(&rows, &mut across);
        assert!((0..8).all(|j| (0..3).all(|i| across[j][0].0[i] == rows[i][0].0[j])));
        // Three of the eight polynomials of the other direction are wanted; too much slack leaves none convex.
        assert!(valley(&across, 3, 0.5, 1.0).is_none());
    }

    /// Value of a polynomial in Bernstein form.
    fn value(coefficients: &[f64], s: f64) -> f64 {
        let mut c = coefficients.to_vec();
        while c.len() > 1 {
            c = c.windows(2).map(|w| (1.0 - s) * w[0] + s * w[1]).collect();
        }
        c[0]
    }

    #[test]
    fn bounds_are_below_the_minima_from_bad_starts() {
        let mut state = 7u64;
        let mut unit = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        for case in 0..2000 {
            let degree = [4, 5, 6, 7][case % 4];
            // Flat where the minimum is, and much more bent where the iteration starts, so that it does not get there.
            let mut bends: Vec<f64> = (0..degree - 1).map(|_| 0.5 + 1.5 * unit()).collect();
            bends[degree - 2] *= 10f64.powf(1.0 + 2.0 * unit());
            let mut step = -unit() * bends[..degree - 2].iter().sum::<f64>();
            let mut coefficients = vec![0.0, step];
            for bend in bends {
                step += bend;
                coefficients.push(coefficients.last().unwrap() + step);
            }
            let rows: Vec<Row<1>> = coefficients.iter().map(|&c| [Lanes([c; WIDTH])]).collect();
            let bound = valley(&rows, 1, 1.0, 0.0).unwrap().bound;
            let least =
                (0..=400).map(|k| value(&coefficients, f64::from(k) / 400.0)).fold(f64::INFINITY, f64::min);
            let scale = coefficients.iter().fold(0.0f64, |all, c| all.max(c.abs()));
            assert!(bound <= least + 1e-13 * scale, "case {case}: {bound} above {least}, {coefficients:?}");
        }
    }
}
