//! Polynomials in two variables in Bernstein form on the unit square.

use nalgebra::SVector;

/// Coefficients of a polynomial with values in `R^N`, row-major.
///
/// The values on the unit square lie in the convex hull of the coefficients.
#[derive(Clone, Debug)]
pub(crate) struct Net<const N: usize> {
    degrees: [usize; 2],
    values: Vec<SVector<f64, N>>,
}

impl<const N: usize> Net<N> {
    pub(crate) fn new(degrees: [usize; 2], values: Vec<SVector<f64, N>>) -> Self {
        Self { degrees, values }
    }

    /// Numbers of rows and columns less one.
    pub(crate) fn degrees(&self) -> [usize; 2] {
        self.degrees
    }

    /// Coefficients, row-major.
    pub(crate) fn values(&self) -> &[SVector<f64, N>] {
        &self.values
    }

    pub(crate) fn at(&self, i: usize, j: usize) -> SVector<f64, N> {
        self.values[i * (self.degrees[1] + 1) + j]
    }

    fn build(degrees: [usize; 2], value: impl Fn(usize, usize) -> SVector<f64, N>) -> Self {
        let columns = degrees[1] + 1;
        let values = (0..(degrees[0] + 1) * columns).map(|k| value(k / columns, k % columns)).collect();
        Self { degrees, values }
    }

    pub(crate) fn largest_norm(&self) -> f64 {
        self.values.iter().map(|v| v.norm()).fold(0.0, f64::max)
    }

    pub(crate) fn smallest_norm(&self) -> f64 {
        self.values.iter().map(|v| v.norm()).fold(f64::INFINITY, f64::min)
    }

    /// Partial derivative by the first variable.
    pub(crate) fn du(&self) -> Self {
        let [p, q] = self.degrees;
        if p == 0 {
            return Self::build([0, q], |_, _| SVector::zeros());
        }
        Self::build([p - 1, q], |i, j| (self.at(i + 1, j) - self.at(i, j)) * p as f64)
    }

    /// Partial derivative by the second variable.
    pub(crate) fn dv(&self) -> Self {
        let [p, q] = self.degrees;
        if q == 0 {
            return Self::build([p, 0], |_, _| SVector::zeros());
        }
        Self::build([p, q - 1], |i, j| (self.at(i, j + 1) - self.at(i, j)) * q as f64)
    }

    /// `self − factor · other`, of equal degrees.
    pub(crate) fn minus(mut self, factor: f64, other: &Self) -> Self {
        debug_assert_eq!(self.degrees, other.degrees);
        self.values.iter_mut().zip(&other.values).for_each(|(a, b)| *a -= b * factor);
        self
    }

    /// Product with a scalar polynomial.
    pub(crate) fn times(&self, scalar: &Net<1>) -> Self {
        let [p, q] = self.degrees;
        let [r, s] = scalar.degrees;
        let (rows, columns) = (mixing(p, r), mixing(q, s));
        let mut out = Self::build([p + r, q + s], |_, _| SVector::zeros());
        for i in 0..=p {
            for j in 0..=q {
                let value = self.at(i, j);
                for k in 0..=r {
                    for l in 0..=s {
                        let factor = scalar.at(k, l).x * rows[i * (r + 1) + k] * columns[j * (s + 1) + l];
                        out.values[(i + k) * (q + s + 1) + j + l] += value * factor;
                    }
                }
            }
        }
        out
    }

    /// The polynomial on `parts` equal strips of one variable.
    pub(crate) fn cut(&self, along_u: bool, parts: usize) -> Vec<Self> {
        let mut rest = self.clone();
        let mut out = Vec::with_capacity(parts);
        for k in (2..=parts).rev() {
            out.push(rest.split(along_u, 1.0 / k as f64));
        }
        out.push(rest);
        out
    }

    /// De Casteljau at `s`: returns the part before and keeps the part behind ([PT97, A1.5]).
    pub(crate) fn split(&mut self, along_u: bool, s: f64) -> Self {
        let [n, m] = self.degrees.map(|d| d + 1);
        let (count, stride, lines, step) = if along_u { (n, m, m, 1) } else { (m, 1, n, m) };
        let mut left = self.clone();
        for line in 0..lines {
            let at = |k: usize| line * step + k * stride;
            for level in 1..count {
                for k in 0..count - level {
                    self.values[at(k)] = self.values[at(k)] * (1.0 - s) + self.values[at(k + 1)] * s;
                }
                left.values[at(level)] = self.values[at(0)];
            }
        }
        left
    }
}

/// Factors `C(p, i) C(q, k) / C(p + q, i + k)` of a product in Bernstein form, at index `i (q + 1) + k`.
fn mixing(p: usize, q: usize) -> Vec<f64> {
    let binomials = |n: usize| {
        let mut row = vec![1.0];
        for k in 1..=n {
            row.push(row[k - 1] * (n + 1 - k) as f64 / k as f64);
        }
        row
    };
    let (a, b, c) = (binomials(p), binomials(q), binomials(p + q));
    let mut out = Vec::with_capacity((p + 1) * (q + 1));
    for i in 0..=p {
        for k in 0..=q {
            out.push(a[i] * b[k] / c[i + k]);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector1;

    #[test]
    fn product_and_derivative() {
        // a = u + 2v, b = 1 + uv; at the corner (1, 1): ab = 6, ∂u(ab) = 1·2 + 3·1 = 5.
        let net = |values: &[f64]| Net::new([1, 1], values.iter().map(|v| Vector1::new(*v)).collect());
        let (a, b) = (net(&[0.0, 2.0, 1.0, 3.0]), net(&[1.0, 1.0, 1.0, 2.0]));
        let product = a.times(&b);
        assert_eq!(product.degrees, [2, 2]);
        assert!((product.at(2, 2).x - 6.0).abs() < 1e-15 && (product.du().at(1, 2).x - 5.0).abs() < 1e-14);
        let parts = product.cut(false, 3);
        // The first strip ends at v = 1/3: (1 + 2/3)(1 + 1/3) at u = 1.
        assert!((parts[0].at(2, 2).x - 20.0 / 9.0).abs() < 1e-15);
        assert!((parts[2].at(2, 2).x - 6.0).abs() < 1e-15);
    }
}
