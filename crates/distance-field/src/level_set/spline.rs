//! The cubic spline through the values of a grid, with its derivatives.
//!
//! Uniform B-splines in each direction with the condition of de Boor at the ends ("not a knot"): fourth order up to the
//! border, twice continuously differentiable.

use super::grid::Grid;
use crate::implicit::Taylor;
use nalgebra::{SMatrix, SVector};

/// Coefficients of the spline; in each direction two more than nodes.
#[derive(Clone, Debug)]
pub(crate) struct GridSpline<const D: usize> {
    counts: [usize; D],
    coefficients: Vec<f64>,
}

impl<const D: usize> GridSpline<D> {
    pub(crate) fn new(grid: &Grid<D>) -> Self {
        let mut counts = grid.counts();
        let mut values = grid.values().to_vec();
        for d in 0..D {
            let outer: usize = counts[..d].iter().product();
            let inner: usize = counts[d + 1..].iter().product();
            let n = counts[d];
            let mut next = vec![0.0; outer * (n + 2) * inner];
            let mut line = vec![0.0; n];
            let mut work = Vec::new();
            let mut out = vec![0.0; n + 2];
            for block in 0..outer {
                for i in 0..inner {
                    for (k, value) in line.iter_mut().enumerate() {
                        *value = values[(block * n + k) * inner + i];
                    }
                    interpolate(&line, &mut work, &mut out);
                    for (k, c) in out.iter().enumerate() {
                        next[(block * (n + 2) + k) * inner + i] = *c;
                    }
                }
            }
            values = next;
            counts[d] = n + 2;
        }
        Self { counts, coefficients: values }
    }

    /// Value and derivatives at a place in units of the spacing, which is kept inside the grid; derivatives by these
    /// units.
    pub(crate) fn taylor(&self, place: &SVector<f64, D>) -> Taylor<D> {
        let mut first = [0; D];
        let mut basis = [[[0.0; 4]; 3]; D];
        for d in 0..D {
            let last = self.counts[d] - 4;
            let x = place[d].clamp(0.0, (last + 1) as f64);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "clamped to the grid"
            )]
            let cell = (x as usize).min(last);
            first[d] = cell;
            basis[d] = uniform_basis(x - cell as f64);
        }
        let mut out: Taylor<D> = Taylor { value: 0.0, gradient: SVector::zeros(), hessian: SMatrix::zeros() };
        let mut strides = [1; D];
        for d in (0..D.saturating_sub(1)).rev() {
            strides[d] = strides[d + 1] * self.counts[d + 1];
        }
        for term in 0..4usize.pow(u32::try_from(D).unwrap_or(0)) {
            let mut index = 0;
            let mut at = [0; D];
            let mut rest = term;
            for d in 0..D {
                at[d] = rest % 4;
                rest /= 4;
                index += (first[d] + at[d]) * strides[d];
            }
            let c = self.coefficients[index];
            let product = |orders: [usize; D]| (0..D).fold(c, |p, d| p * basis[d][orders[d]][at[d]]);
            out.value += product([0; D]);
            for d in 0..D {
                let mut orders = [0; D];
                orders[d] = 1;
                out.gradient[d] += product(orders);
                for e in d..D {
                    let mut orders = [0; D];
                    orders[d] += 1;
                    orders[e] += 1;
                    out.hessian[(d, e)] += product(orders);
                }
            }
        }
        for d in 0..D {
            for e in 0..d {
                out.hessian[(d, e)] = out.hessian[(e, d)];
            }
        }
        out
    }
}

/// Values, first and second derivatives of the four uniform cubic B-splines that do not vanish at `t` in `[0, 1]`.
fn uniform_basis(t: f64) -> [[f64; 4]; 3] {
    let r = 1.0 - t;
    [
        [
            r * r * r / 6.0,
            (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0,
            (4.0 - 6.0 * r * r + 3.0 * r * r * r) / 6.0,
            t * t * t / 6.0,
        ],
        [-0.5 * r * r, 1.5 * t * t - 2.0 * t, 2.0 * r - 1.5 * r * r, 0.5 * t * t],
        [r, 3.0 * t - 2.0, 3.0 * r - 2.0, t],
    ]
}

/// The `n + 2` coefficients of the uniform cubic spline through `n ≥ 4` values.
fn interpolate(f: &[f64], work: &mut Vec<f64>, out: &mut [f64]) {
    let n = f.len();
    // Coefficient `i + 1` belongs to node `i`. The third derivative does not jump at nodes 1 and n − 2; with the
    // conditions of interpolation around them that leaves one unknown each.
    let near = |a: f64, b: f64, c: f64| (8.0 * b - a - c) / 6.0;
    out[2] = near(f[0], f[1], f[2]);
    out[n - 1] = near(f[n - 1], f[n - 2], f[n - 3]);
    // c[i − 1] + 4 c[i] + c[i + 1] = 6 f[i] in between: elimination without pivots, diagonally dominant.
    work.clear();
    work.resize(n, 0.0);
    for i in 2..n.saturating_sub(2) {
        let pivot = 4.0 - if i > 2 { work[i - 1] } else { 0.0 };
        let mut right = 6.0 * f[i] - out[i];
        if i + 3 == n {
            right -= out[n - 1];
        }
        work[i] = 1.0 / pivot;
        out[i + 1] = right / pivot;
    }
    for i in (2..n.saturating_sub(3)).rev() {
        out[i + 1] -= work[i] * out[i + 2];
    }
    out[1] = 6.0 * f[1] - 4.0 * out[2] - out[3];
    out[0] = 6.0 * f[0] - 4.0 * out[1] - out[2];
    out[n] = 6.0 * f[n - 2] - 4.0 * out[n - 1] - out[n - 2];
    out[n + 1] = 6.0 * f[n - 1] - 4.0 * out[n] - out[n - 1];
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector2, Vector3};

    #[test]
    fn cubics_are_reproduced() {
        let f = |p: &Vector2<f64>| 1.0 + p.x * p.x * p.y - 0.3 * p.y.powi(3) + 0.2 * (p.x * p.y).powi(3);
        for counts in [[4, 5], [6, 7], [9, 4]] {
            let grid = Grid::sample(Vector2::new(-1.0, 0.5), Vector2::repeat(1.0), counts, f).unwrap();
            let spline = GridSpline::new(&grid);
            for k in 0..50 {
                let span = Vector2::new(counts[0] as f64 - 1.0, counts[1] as f64 - 1.0);
                let place = span.component_mul(&Vector2::new(
                    (0.37 * f64::from(k)).fract(),
                    (0.61 * f64::from(k)).fract(),
                ));
                let p = grid.point(&place);
                let t = spline.taylor(&place);
                let scale = 1.0 + f(&p).abs();
                assert!((t.value - f(&p)).abs() < 1e-11 * scale);
                let gradient = Vector2::new(
                    2.0 * p.x * p.y + 0.6 * p.x.powi(2) * p.y.powi(3),
                    p.x * p.x - 0.9 * p.y * p.y + 0.6 * p.x.powi(3) * p.y.powi(2),
                );
                assert!((t.gradient - gradient).norm() < 1e-10 * (1.0 + gradient.norm()), "{counts:?}");
                let mixed = 2.0 * p.x + 1.8 * p.x.powi(2) * p.y.powi(2);
                assert!((t.hessian[(1, 0)] - mixed).abs() < 1e-9 * (1.0 + mixed.abs()));
            }
        }
    }

    #[test]
    fn the_error_is_of_fourth_order() {
        let f = |p: &Vector3<f64>| (p.x + 0.5 * p.y).sin() * (p.z - p.y).cos();
        let error = |n: usize| {
            let h = 2.0 / (n - 1) as f64;
            let grid = Grid::sample(Vector3::zeros(), Vector3::repeat(h), [n; 3], f).unwrap();
            let spline = GridSpline::new(&grid);
            (0..200)
                .map(|k| {
                    let at = |a: f64| 2.0 * (a * f64::from(k)).fract();
                    let p = Vector3::new(at(0.618), at(0.414), at(0.732));
                    (spline.taylor(&grid.place(&p)).value - f(&p)).abs()
                })
                .fold(0.0, f64::max)
        };
        let order = (error(11) / error(21)).log2();
        assert!(order > 3.6, "{order}");
    }
}
