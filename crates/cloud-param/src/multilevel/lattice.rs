//! Lattices of coefficients of uniform bicubic splines.

use super::Weighting;

/// Coefficients `φ_ij`, `i = −1, …, m + 1` and `j = −1, …, n + 1`, of a uniform bicubic spline on `[0, m] × [0, n]`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Lattice {
    spans: [usize; 2],
    /// Row by row, `i` outer.
    pub(super) values: Vec<f64>,
}

/// The four uniform cubic basis functions at `t` in `[0, 1]`.
#[inline]
pub(super) fn basis(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    let (t2, s2) = (t * t, s * s);
    [s2 * s / 6.0, (4.0 - 6.0 * t2 + 3.0 * t2 * t) / 6.0, (4.0 - 6.0 * s2 + 3.0 * s2 * s) / 6.0, t2 * t / 6.0]
}

/// Their derivatives.
pub(super) fn slopes(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [-0.5 * s * s, -2.0 * t + 1.5 * t * t, 2.0 * s - 1.5 * s * s, 0.5 * t * t]
}

/// Cell and place in it; the last cell includes its end.
#[inline]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the lattice")]
pub(super) fn locate(x: f64, spans: usize) -> (usize, f64) {
    let cell = (x.max(0.0) as usize).min(spans - 1);
    (cell, x - cell as f64)
}

impl Lattice {
    pub(super) fn zeros(spans: [usize; 2]) -> Self {
        Self { spans, values: vec![0.0; (spans[0] + 3) * (spans[1] + 3)] }
    }

    pub(super) fn spans(&self) -> [usize; 2] {
        self.spans
    }

    fn width(&self) -> usize {
        self.spans[1] + 3
    }

    /// The approximation of scattered data `(x, y, z)`, `x` and `y` in units of the lattice divided by `factor`
    /// ([MPK, eqs. (3)-(6)]).
    ///
    /// A datum alone is met by `φ_c = w_c z / Σ w²`, with the products `w_c = B_k(s) B_l(t)`; a coefficient with several
    /// data is the mean of their `φ_c` with the weights `w_c²` (eq. (5)) or `w_c` (eq. (6), the sum of the weights in the
    /// denominator).
    pub(super) fn approximate(
        spans: [usize; 2],
        factor: f64,
        data: &[[f64; 3]],
        weighting: Weighting,
    ) -> Self {
        let mut sums = vec![[0.0f64; 2]; (spans[0] + 3) * (spans[1] + 3)];
        let width = spans[1] + 3;
        for &[x, y, z] in data {
            let ((i, s), (j, t)) = (locate(x * factor, spans[0]), locate(y * factor, spans[1]));
            let (a, b) = (basis(s), basis(t));
            let square = |v: &[f64; 4]| v.iter().map(|x| x * x).sum::<f64>();
            let share = z / (square(&a) * square(&b));
            for (k, a) in a.iter().enumerate() {
                let row = (i + k) * width + j;
                let row = &mut sums[row..row + 4];
                for (slot, b) in row.iter_mut().zip(&b) {
                    let w = a * b;
                    let weight = match weighting {
                        Weighting::Squared => w * w,
                        Weighting::Linear => w,
                    };
                    slot[0] += weight * (w * share);
                    slot[1] += weight;
                }
            }
        }
        // A coefficient without data stays 0 ([MPK], below eq. (5)).
        let values =
            sums.iter().map(|[sum, weight]| if *weight > 0.0 { sum / weight } else { 0.0 }).collect();
        Self { spans, values }
    }

    /// Takes the spline off the data.
    pub(super) fn subtract_from(&self, data: &mut [[f64; 3]], factor: f64) {
        for point in data {
            point[2] -= self.value(point[0] * factor, point[1] * factor);
        }
    }

    /// The value at a place in units of the lattice ([MPK, eq. (1)]).
    #[inline]
    pub(super) fn value(&self, x: f64, y: f64) -> f64 {
        let ((i, s), (j, t)) = (locate(x, self.spans[0]), locate(y, self.spans[1]));
        self.combine(i, j, &basis(s), &basis(t))
    }

    #[inline]
    pub(super) fn combine(&self, i: usize, j: usize, a: &[f64; 4], b: &[f64; 4]) -> f64 {
        let width = self.width();
        let mut sum = 0.0;
        for (k, a) in a.iter().enumerate() {
            let row = (i + k) * width + j;
            let row = &self.values[row..row + 4];
            sum += a * (row[0] * b[0] + row[1] * b[1] + row[2] * b[2] + row[3] * b[3]);
        }
        sum
    }

    /// The same spline on a lattice of half the spacing ([LWS97, sec. 4.3]).
    pub(super) fn refined(&self) -> Self {
        let [m, n] = self.spans;
        let half = refine_rows(&self.values, m, n + 3);
        // Columns are refined as rows of the transposed lattice.
        let turned = refine_rows(&transpose(&half, 2 * m + 3, n + 3), n, 2 * m + 3);
        Self { spans: [2 * m, 2 * n], values: transpose(&turned, 2 * n + 3, 2 * m + 3) }
    }

    pub(super) fn add(&mut self, other: &Self) {
        for (slot, value) in self.values.iter_mut().zip(&other.values) {
            *slot += value;
        }
    }

    /// Adds `a + b x + c y`; uniform cubic splines have linear functions as their own coefficients.
    pub(super) fn add_plane(&mut self, [a, b, c]: [f64; 3]) {
        let width = self.width();
        for (i, row) in self.values.chunks_exact_mut(width).enumerate() {
            for (j, slot) in row.iter_mut().enumerate() {
                *slot += a + b * (i as f64 - 1.0) + c * (j as f64 - 1.0);
            }
        }
    }
}

/// Halves the spacing across `spans` for rows of `width` numbers.
fn refine_rows(values: &[f64], spans: usize, width: usize) -> Vec<f64> {
    let row = |i: usize| &values[i * width..(i + 1) * width];
    let mut out = Vec::with_capacity((2 * spans + 3) * width);
    // New index −1 + r: odd ones lie between two old coefficients, even ones at an old one.
    for r in 0..2 * spans + 3 {
        let i = r / 2;
        if r % 2 == 0 {
            out.extend(row(i).iter().zip(row(i + 1)).map(|(a, b)| 0.5 * (a + b)));
        } else {
            let (before, at, after) = (row(i), row(i + 1), row(i + 2));
            out.extend((0..width).map(|k| (before[k] + 6.0 * at[k] + after[k]) / 8.0));
        }
    }
    out
}

fn transpose(values: &[f64], rows: usize, columns: usize) -> Vec<f64> {
    let mut out = Vec::with_capacity(values.len());
    for j in 0..columns {
        out.extend((0..rows).map(|i| values[i * columns + j]));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refinement_keeps_the_spline() {
        let mut lattice = Lattice::zeros([3, 2]);
        for (i, value) in lattice.values.iter_mut().enumerate() {
            *value = ((i * 7919) % 31) as f64 - 15.0;
        }
        let fine = lattice.refined();
        for k in 0..200 {
            let (x, y) = (f64::from(k) * 0.618 % 3.0, f64::from(k) * 0.366 % 2.0);
            assert!((lattice.value(x, y) - fine.value(2.0 * x, 2.0 * y)).abs() < 1e-12);
        }
    }

    #[test]
    fn one_datum_is_met() {
        for weighting in [Weighting::Squared, Weighting::Linear] {
            let lattice = Lattice::approximate([4, 5], 1.0, &[[1.3, 4.9, 7.0]], weighting);
            assert!((lattice.value(1.3, 4.9) - 7.0).abs() < 1e-13);
        }
    }

    #[test]
    fn the_printed_form_of_equation_6_diverges_where_ours_does_not() {
        // Many equal data in one cell: eq. (6) as printed has Σ w φ / Σ w², which is not a mean.
        let data: Vec<_> =
            (0..100).map(|i| [f64::from(i % 10) / 10.0, f64::from(i / 10) / 10.0, 1.0]).collect();
        let ours = Lattice::approximate([1, 1], 1.0, &data, Weighting::Linear);
        assert!(ours.values.iter().all(|v| v.abs() < 3.0), "{:?}", ours.values);
        let largest = data
            .iter()
            .map(|d| {
                let (a, b) = (basis(d[0]), basis(d[1]));
                let w = a[0] * b[0];
                let squares = a.iter().map(|x| x * x).sum::<f64>() * b.iter().map(|x| x * x).sum::<f64>();
                (w * w / squares, w * w)
            })
            .fold((0.0, 0.0), |s, d| (s.0 + d.0, s.1 + d.1));
        assert!(largest.0 / largest.1 > 4.0);
    }
}
