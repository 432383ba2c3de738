//! Differences of the values of a grid: upwind of fifth order (Jiang & Peng, *Weighted ENO schemes for Hamilton-Jacobi equations*, 2000),
//! and central ones for the curvature.

use nalgebra::SVector;

/// Values with what is needed to find neighbours.
pub(super) struct Stencil<'a, const D: usize> {
    pub(super) values: &'a [f64],
    pub(super) counts: [usize; D],
    pub(super) strides: [usize; D],
    pub(super) spacing: SVector<f64, D>,
}

/// The fifth order derivative from five differences, from upwind to downwind.
fn weighted([a, b, c, d, e]: [f64; 5]) -> f64 {
    let parts = [
        a / 3.0 - 7.0 * b / 6.0 + 11.0 * c / 6.0,
        -b / 6.0 + 5.0 * c / 6.0 + d / 3.0,
        c / 3.0 + 5.0 * d / 6.0 - e / 6.0,
    ];
    let smoothness = [
        13.0 / 12.0 * (a - 2.0 * b + c).powi(2) + 0.25 * (a - 4.0 * b + 3.0 * c).powi(2),
        13.0 / 12.0 * (b - 2.0 * c + d).powi(2) + 0.25 * (b - d).powi(2),
        13.0 / 12.0 * (c - 2.0 * d + e).powi(2) + 0.25 * (3.0 * c - 4.0 * d + e).powi(2),
    ];
    let most = [a, b, c, d, e].iter().fold(0.0f64, |most, v| most.max(v * v));
    let tiny = 1e-6 * most + 1e-99;
    let weights: [f64; 3] = std::array::from_fn(|k| [0.1, 0.6, 0.3][k] / (smoothness[k] + tiny).powi(2));
    (0..3).map(|k| weights[k] * parts[k]).sum::<f64>() / weights.iter().sum::<f64>()
}

impl<const D: usize> Stencil<'_, D> {
    /// The value some nodes away along an axis; beyond the border it goes on with the last slope.
    fn value(&self, node: usize, at: usize, axis: usize, offset: isize) -> f64 {
        let last = self.counts[axis] - 1;
        let stride = self.strides[axis];
        let first = node - at * stride;
        let value = |index: usize| self.values[first + index * stride];
        let wanted = at.cast_signed() + offset;
        if wanted < 0 {
            let beyond = wanted.unsigned_abs() as f64;
            value(0) + beyond * (value(0) - value(1.min(last)))
        } else if wanted.cast_unsigned() > last {
            let beyond = (wanted.cast_unsigned() - last) as f64;
            value(last) + beyond * (value(last) - value(last.saturating_sub(1)))
        } else {
            value(wanted.cast_unsigned())
        }
    }

    /// The derivatives along an axis from below and from above.
    pub(super) fn one_sided(&self, node: usize, at: usize, axis: usize) -> [f64; 2] {
        let values: [f64; 7] = std::array::from_fn(|k| self.value(node, at, axis, k.cast_signed() - 3));
        let h = self.spacing[axis];
        let steps: [f64; 6] = std::array::from_fn(|k| (values[k + 1] - values[k]) / h);
        let [a, b, c, d, e, f] = steps;
        [weighted([a, b, c, d, e]), weighted([f, e, d, c, b])]
    }

    /// Gradient by central differences, and mean curvature `κ |∇φ|` of the level set through a node (the sum of the principal ones),
    /// positive where it is round as seen from outside; at most `1/h`, which is all that a grid can hold.
    pub(super) fn bent(&self, node: usize, at: &[usize; D]) -> (SVector<f64, D>, f64) {
        let neighbour = |axis: usize, offset: isize| self.value(node, at[axis], axis, offset);
        let here = self.values[node];
        let gradient =
            SVector::<f64, D>::from_fn(|k, _| (neighbour(k, 1) - neighbour(k, -1)) / (2.0 * self.spacing[k]));
        let square = gradient.norm_squared();
        if square <= 1e-12 {
            return (gradient, 0.0);
        }
        let mut sum = 0.0;
        for k in 0..D {
            let second = (neighbour(k, 1) - 2.0 * here + neighbour(k, -1)) / self.spacing[k].powi(2);
            sum += second * (square - gradient[k] * gradient[k]);
            for l in 0..k {
                let corner = |a: usize, b: usize| {
                    // The corner of the cell, or the nearest node to it.
                    let index = |axis: usize, step: usize| {
                        (at[axis] + step).saturating_sub(1).min(self.counts[axis] - 1)
                    };
                    let moved =
                        |axis: usize, step: usize| index(axis, step).cast_signed() - at[axis].cast_signed();
                    let shift = moved(k, a) * self.strides[k].cast_signed()
                        + moved(l, b) * self.strides[l].cast_signed();
                    self.values[node.saturating_add_signed(shift)]
                };
                let mixed = (corner(2, 2) - corner(2, 0) - corner(0, 2) + corner(0, 0))
                    / (4.0 * self.spacing[k] * self.spacing[l]);
                sum -= 2.0 * gradient[k] * gradient[l] * mixed;
            }
        }
        let slope = square.sqrt();
        let most = (D - 1) as f64 / self.spacing.min();
        (gradient, (sum / (square * slope)).clamp(-most, most) * slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    #[test]
    fn upwind_differences_are_of_fifth_order() {
        let error = |n: usize| {
            let h = 2.0 / n as f64;
            let values: Vec<f64> = (0..=n).map(|k| (1.5 * k as f64 * h).sin()).collect();
            let stencil =
                Stencil { values: &values, counts: [n + 1], strides: [1], spacing: SVector::repeat(h) };
            let off = |k: usize| {
                let right = 1.5 * (1.5 * k as f64 * h).cos();
                let [below, above] = stencil.one_sided(k, k, 0);
                (below - right).abs().max((above - right).abs())
            };
            (n / 4..=3 * n / 4).map(off).fold(0.0, f64::max)
        };
        let order = (error(40) / error(80)).log2();
        assert!(order > 4.5, "{order}");
    }

    #[test]
    fn circles_have_their_curvature() {
        let (n, h) = (61usize, 0.05);
        let at = |k: usize| Vector2::new((k / n) as f64 * h - 1.5, (k % n) as f64 * h - 1.5);
        let values: Vec<f64> = (0..n * n).map(|k| at(k).norm() - 1.0).collect();
        let stencil =
            Stencil { values: &values, counts: [n, n], strides: [n, 1], spacing: Vector2::repeat(h) };
        let node = 50 * n + 35;
        let (gradient, bent) = stencil.bent(node, &[50, 35]);
        assert!((bent / gradient.norm() - 1.0 / at(node).norm()).abs() < 2e-3);
    }
}
