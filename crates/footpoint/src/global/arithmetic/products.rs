//! Products of control nets, and parts of nets and rows.

use crate::global::arithmetic::bernstein::binomial;
use crate::global::arithmetic::homogeneous::Homogeneous;
use crate::global::arithmetic::lanes::{Lanes, Row, WIDTH, add_scaled, zero_row};

/// Bernstein coefficients of products of a net with itself, row-major in degrees `(2p, 2q)`.
pub(crate) fn product<const N: usize>(
    net: &[Homogeneous],
    [p, q]: [usize; 2],
    multiply: impl Fn(&Homogeneous, &Homogeneous) -> [f64; N],
) -> Vec<[f64; N]> {
    let columns = 2 * q + 1;
    let mut out = vec![[0.0; N]; (2 * p + 1) * columns];
    // Products of Bernstein polynomials are convolutions of the coefficients, up to binomials.
    let share = |n: usize, i: usize, j: usize| binomial(n, i) * binomial(n, j) / binomial(2 * n, i + j);
    let shares_v: Vec<f64> = (0..(q + 1) * (q + 1)).map(|k| share(q, k / (q + 1), k % (q + 1))).collect();
    for i in 0..=p {
        for k in 0..=p {
            let share_u = share(p, i, k);
            for j in 0..=q {
                for l in 0..=q {
                    let factor = share_u * shares_v[j * (q + 1) + l];
                    let value = multiply(&net[i * (q + 1) + j], &net[k * (q + 1) + l]);
                    let slot = &mut out[(i + k) * columns + j + l];
                    for c in 0..N {
                        slot[c] += factor * value[c];
                    }
                }
            }
        }
    }
    out
}

/// Coefficients raised to the degree of a row, one degree at a time.
pub(crate) fn elevate_row<const K: usize>(coefficients: impl ExactSizeIterator<Item = f64>) -> Row<K> {
    let mut degree = coefficients.len() - 1;
    let mut flat = [[0.0; WIDTH]; K];
    let b = flat.as_flattened_mut();
    for (slot, value) in b.iter_mut().zip(coefficients) {
        *slot = value;
    }
    while degree < WIDTH * K - 1 {
        degree += 1;
        b[degree] = b[degree - 1];
        for j in (1..degree).rev() {
            let share = j as f64 / degree as f64;
            b[j] = share * b[j - 1] + (1.0 - share) * b[j];
        }
    }
    flat.map(Lanes)
}

/// Bézier points `net[first + k · stride]`, `k = 0..=n`, restricted to the parameters from `low` to `high`.
pub(crate) fn restrict(net: &mut [Homogeneous], first: usize, stride: usize, n: usize, low: f64, high: f64) {
    let mut blend = |a: usize, b: usize, to: usize, s: f64| {
        for c in 0..4 {
            net[to][c] = (1.0 - s) * net[a][c] + s * net[b][c];
        }
    };
    let at = |k: usize| first + k * stride;
    if high < 1.0 {
        for level in 1..=n {
            for k in (level..=n).rev() {
                blend(at(k - 1), at(k), at(k), high);
            }
        }
    }
    if low > 0.0 {
        let s = low / high;
        for level in 1..=n {
            for k in 0..=n - level {
                blend(at(k), at(k + 1), at(k), s);
            }
        }
    }
}

/// What a product of two Bernstein polynomials is made of, for the degrees that occur in a model.
#[derive(Clone, Debug, Default)]
pub(crate) struct Products<const K: usize> {
    /// By degree `n`, entry `(n + 1) i + j`: the share of the product of coefficients `i` and `j` in coefficient
    /// `i + j` of degree `2 n`.
    pub(crate) shares: Vec<Vec<f64>>,
    /// The same as contributions to the coefficients of a row.
    pub(crate) rows: Vec<Vec<Row<K>>>,
}

impl<const K: usize> Products<K> {
    /// Prepares a degree.
    pub(crate) fn add(&mut self, n: usize) {
        if self.shares.len() <= n {
            self.shares.resize(n + 1, Vec::new());
            self.rows.resize(n + 1, Vec::new());
        }
        if !self.shares[n].is_empty() {
            return;
        }
        for i in 0..=n {
            for j in 0..=n {
                let share = binomial(n, i) * binomial(n, j) / binomial(2 * n, i + j);
                let unit = (0..=2 * n).map(|k| if k == i + j { share } else { 0.0 });
                self.shares[n].push(share);
                self.rows[n].push(elevate_row(unit.collect::<Vec<_>>().into_iter()));
            }
        }
    }
}

/// Row `l` is what coefficient `l` contributes to the part below, and above, the parameter `at`.
pub(crate) fn splitting_rows<const K: usize>(at: f64, out: &mut [Vec<Row<K>>; 2]) {
    let n = WIDTH * K - 1;
    for part in out.iter_mut() {
        part.clear();
        part.resize(n + 1, zero_row());
    }
    // The Bernstein polynomials of all degrees up to `n` at `at`, one degree at a time.
    let mut basis = vec![0.0; n + 2];
    basis[1] = 1.0;
    for degree in 0..=n {
        for l in 0..=degree {
            out[0][l][degree / WIDTH].0[degree % WIDTH] = basis[l + 1];
            let (j, from) = (n - degree, n - degree + l);
            out[1][from][j / WIDTH].0[j % WIDTH] = basis[l + 1];
        }
        for l in (1..=(degree + 2).min(n + 1)).rev() {
            basis[l] = (1.0 - at) * basis[l] + at * basis[l - 1];
        }
    }
}

/// `row` restricted to the part that `splitting` was made for.
#[inline(always)]
pub(crate) fn part_of_row<const K: usize>(row: &Row<K>, splitting: &[Row<K>]) -> Row<K> {
    let mut out = zero_row::<K>();
    for k in 0..K {
        for l in 0..WIDTH {
            add_scaled(&mut out, &splitting[k * WIDTH + l], row[k].0[l]);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::lanes::dot;
    use super::*;
    use crate::global::arithmetic::bernstein::basis_rows;

    #[test]
    fn parts_of_rows_are_the_same_polynomial() {
        let row = [Lanes([1.0, -2.0, 0.5, 3.0, -1.0, 2.0, 0.25, 4.0])];
        let at = 0.3;
        let mut splitting = [Vec::new(), Vec::new()];
        splitting_rows::<1>(at, &mut splitting);
        let value = |row: &Row<1>, s: f64| dot(row, &basis_rows::<1>(7, s)[0]);
        let [low, high] = [0, 1].map(|k| part_of_row(&row, &splitting[k]));
        for s in [0.0, 0.2, 0.7, 1.0] {
            assert!((value(&low, s) - value(&row, at * s)).abs() < 1e-14);
            assert!((value(&high, s) - value(&row, at + (1.0 - at) * s)).abs() < 1e-14);
        }
    }
}
