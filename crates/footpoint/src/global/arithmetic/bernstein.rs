//! Polynomials in Bernstein form: products, degree elevation, halving, evaluation [Fa12].

use crate::global::arithmetic::lanes::{Lanes, Row, WIDTH};
use nurbs_core::MAX_DEGREE;

/// Binomial coefficient as a double (exact for all degrees that occur).
pub(crate) fn binomial(n: usize, k: usize) -> f64 {
    let k = k.min(n - k);
    (1..=k).fold(1.0, |value, i| value * (n + 1 - i) as f64 / i as f64)
}

/// Matrix that writes a polynomial of degree `from` in degree `to`: entry `[j][i]` is the share of old
/// coefficient `i` in new coefficient `j`.
pub(crate) fn elevation_matrix(from: usize, to: usize) -> Vec<Vec<f64>> {
    let gain = to - from;
    let entry = |j: usize, i: usize| {
        if i > j || j - i > gain { 0.0 } else { binomial(from, i) * binomial(gain, j - i) / binomial(to, j) }
    };
    (0..=to).map(|j| (0..=from).map(|i| entry(j, i)).collect()).collect()
}

/// `out[j]` = value (`[0]`), first and second derivative of the Bernstein polynomials of degree `n` at `s`.
///
/// `out` needs `n + 1` entries.
#[inline(always)]
pub(crate) fn basis_jet(n: usize, s: f64, out: &mut [[f64; 3]]) {
    let r = 1.0 - s;
    match n {
        1 => {
            out[0] = [r, -1.0, 0.0];
            out[1] = [s, 1.0, 0.0];
        }
        2 => {
            out[0] = [r * r, -2.0 * r, 2.0];
            out[1] = [2.0 * r * s, 2.0 * (r - s), -4.0];
            out[2] = [s * s, 2.0 * s, 2.0];
        }
        3 => {
            let (rr, rs, ss) = (r * r, 2.0 * r * s, s * s);
            out[0] = [rr * r, -3.0 * rr, 6.0 * r];
            out[1] = [1.5 * rs * r, 3.0 * (rr - rs), 6.0 * (s - 2.0 * r)];
            out[2] = [1.5 * rs * s, 3.0 * (rs - ss), 6.0 * (r - 2.0 * s)];
            out[3] = [ss * s, 3.0 * ss, 6.0 * s];
        }
        _ => general_basis_jet(n, s, out),
    }
}

#[inline(always)]
fn general_basis_jet(n: usize, s: f64, out: &mut [[f64; 3]]) {
    let r = 1.0 - s;
    // Degree n − 2 first, then raised twice; derivatives are differences of the lower degrees. Function i is
    // kept at index i + 2, so that its missing neighbours are zeros.
    let mut b = [0.0; 2 * MAX_DEGREE + 16];
    b[2] = 1.0;
    let raise = |b: &mut [f64; 2 * MAX_DEGREE + 16], j: usize| {
        for i in (2..j + 3).rev() {
            b[i] = r * b[i] + s * b[i - 1];
        }
    };
    for j in 1..=n - 2 {
        raise(&mut b, j);
    }
    let nf = n as f64;
    for j in 0..=n {
        out[j][2] = nf * (nf - 1.0) * (b[j] - 2.0 * b[j + 1] + b[j + 2]);
    }
    raise(&mut b, n - 1);
    for j in 0..=n {
        out[j][1] = nf * (b[j + 1] - b[j + 2]);
    }
    raise(&mut b, n);
    for j in 0..=n {
        out[j][0] = b[j + 2];
    }
}

/// Values, first and second derivatives of the Bernstein polynomials of degree `n < 8 K` at `s`, as rows that are
/// filled up with zeros.
#[inline(always)]
pub(crate) fn basis_rows<const K: usize>(n: usize, s: f64) -> [Row<K>; 3] {
    let r = 1.0 - s;
    let mut values = [[0.0f64; WIDTH]; K];
    let mut first = values;
    let mut second = values;
    {
        let (b, d1, d2) = (values.as_flattened_mut(), first.as_flattened_mut(), second.as_flattened_mut());
        b[0] = 1.0;
        let nf = n as f64;
        for degree in 0..n {
            // `b` holds the polynomials of this degree; derivatives are differences of lower degrees.
            if degree + 2 == n {
                for i in 0..=degree {
                    let c = nf * (nf - 1.0) * b[i];
                    d2[i] += c;
                    d2[i + 1] -= 2.0 * c;
                    d2[i + 2] += c;
                }
            }
            if degree + 1 == n {
                for i in 0..=degree {
                    d1[i] -= nf * b[i];
                    d1[i + 1] += nf * b[i];
                }
            }
            for i in (1..degree + 2).rev() {
                b[i] = r * b[i] + s * b[i - 1];
            }
            b[0] *= r;
        }
    }
    [values, first, second].map(|row| row.map(Lanes))
}

/// The share of the way from `low` to `high` at which a parameter lies, kept between 0 and 1; NaN counts as 0.
pub(crate) fn unit(parameter: f64, low: f64, high: f64) -> f64 {
    let share = (parameter - low) / (high - low);
    if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn basis_jets_agree_with_differences() {
        for n in 1..=12 {
            let (s, h) = (0.3, 1e-4);
            let mut b = [[[0.0; 3]; 13]; 3];
            for (k, row) in b.iter_mut().enumerate() {
                basis_jet(n, s + h * (k as f64 - 1.0), row);
            }
            let sum: f64 = b[1].iter().map(|v| v[0]).sum();
            assert!((sum - 1.0).abs() < 1e-14);
            for j in 0..=n {
                let first = (b[2][j][0] - b[0][j][0]) / (2.0 * h);
                let second = (b[2][j][0] - 2.0 * b[1][j][0] + b[0][j][0]) / (h * h);
                assert!((first - b[1][j][1]).abs() < 1e-5, "{n} {j}");
                assert!((second - b[1][j][2]).abs() < 1e-4, "{n} {j}: {second} {:?}", b[1][j]);
            }
        }
    }

    #[test]
    fn elevation_keeps_the_polynomial() {
        let m = elevation_matrix(3, 7);
        let coefficients = [1.0, -2.0, 0.5, 4.0];
        let raised: Vec<f64> =
            m.iter().map(|row| row.iter().zip(coefficients).map(|(a, b)| a * b).sum()).collect();
        let value = |c: &[f64]| {
            let mut b = [[0.0; 3]; 8];
            basis_jet(c.len() - 1, 0.37, &mut b);
            c.iter().zip(b).map(|(c, b)| c * b[0]).sum::<f64>()
        };
        assert!((value(&coefficients) - value(&raised)).abs() < 1e-14);
    }
}
