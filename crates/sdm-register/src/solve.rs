//! The small linear system of a step.

use crate::eigen::Eigen;
use nalgebra::{DMatrix, DVector};

/// A symmetric system `H u = −b` in the unknowns that are left, scaled to the size of the cloud, with the motions that
/// the shape does not fix taken out.
#[derive(Clone, Debug)]
pub(crate) struct Scaled {
    /// Factor of each unknown: a length for translations, 1 for others.
    units: DVector<f64>,
    /// Orthonormal directions that are fixed by the shape, one per column.
    fixed: DMatrix<f64>,
    /// Their eigenvalues in the tangent matrix as shares of the largest.
    shares: Vec<f64>,
    /// Orthonormal directions that are not.
    free: DMatrix<f64>,
    /// Smallest and largest eigenvalue of the tangent matrix.
    pub(crate) extremes: [f64; 2],
}

/// A system in the directions that are fixed, by its eigenvectors.
#[derive(Clone, Debug)]
pub(crate) struct Spectrum {
    eigen: Eigen,
    /// `−Vᵀb` in the eigenvectors.
    right: DVector<f64>,
}

impl Scaled {
    /// From the matrix of the tangent term, whose null space is that of all motions which slide the shape along
    /// itself: every normal is at right angles to them, whatever the distances are.
    ///
    /// Directions with an eigenvalue up to `tolerance` times the largest one count as free.
    pub(crate) fn new(tangent: &DMatrix<f64>, is_translation: &[bool], length: f64, tolerance: f64) -> Self {
        let n = is_translation.len();
        let units = DVector::from_fn(n, |i, _| if is_translation[i] { length } else { 1.0 });
        let eigen = Eigen::new(scale(tangent, &units));
        let largest = eigen.values.iter().fold(0.0f64, |m, &x| m.max(x));
        let smallest = eigen.values.iter().fold(f64::INFINITY, |m, &x| m.min(x));
        let (mut fixed, mut free, mut shares) = (Vec::new(), Vec::new(), Vec::new());
        for (i, &value) in eigen.values.iter().enumerate() {
            let column = eigen.vectors.column(i).into_owned();
            if value > tolerance * largest {
                fixed.push(column);
                shares.push(value / largest);
            } else {
                free.push(column);
            }
        }
        let matrix = |columns: &[DVector<f64>]| DMatrix::from_fn(n, columns.len(), |i, j| columns[j][i]);
        Self {
            units,
            fixed: matrix(&fixed),
            shares,
            free: matrix(&free),
            extremes: [smallest.max(0.0), largest],
        }
    }

    /// Number of directions that are fixed.
    pub(crate) fn rank(&self) -> usize {
        self.fixed.ncols()
    }

    /// The directions that are not fixed, as steps.
    pub(crate) fn free_steps(&self) -> Vec<DVector<f64>> {
        self.free.column_iter().map(|c| c.component_mul(&self.units)).collect()
    }

    /// The directions that are fixed, as steps, with their eigenvalues as shares of the largest: the most weakly fixed one first.
    pub(crate) fn axes(&self) -> Vec<(f64, DVector<f64>)> {
        let mut axes: Vec<_> = self
            .shares
            .iter()
            .zip(self.fixed.column_iter())
            .map(|(&share, axis)| (share, axis.component_mul(&self.units)))
            .collect();
        axes.sort_by(|a, b| a.0.total_cmp(&b.0));
        axes
    }

    /// A system by its eigenvectors.
    pub(crate) fn spectrum(&self, matrix: &DMatrix<f64>, vector: &DVector<f64>) -> Spectrum {
        let inner = self.fixed.tr_mul(&(scale(matrix, &self.units) * &self.fixed));
        let inner = (&inner + inner.transpose()) * 0.5;
        let eigen = Eigen::new(inner);
        let right = -eigen.vectors.tr_mul(&self.fixed.tr_mul(&vector.component_mul(&self.units)));
        Spectrum { eigen, right }
    }

    /// The step of a system: `u = −(H + μI)⁻¹ b` in scaled unknowns.
    pub(crate) fn step(&self, spectrum: &Spectrum, damping: f64) -> DVector<f64> {
        let inner = DVector::from_fn(spectrum.right.len(), |i, _| {
            let value = spectrum.eigen.values[i] + damping;
            if value == 0.0 { 0.0 } else { spectrum.right[i] / value }
        });
        (&self.fixed * (&spectrum.eigen.vectors * inner)).component_mul(&self.units)
    }

    /// The inverse of a matrix in the directions that are fixed, 0 in the others.
    pub(crate) fn inverse(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        let zero = DVector::zeros(self.units.len());
        let spectrum = self.spectrum(matrix, &zero);
        let vectors = &self.fixed * &spectrum.eigen.vectors;
        let inverse =
            DMatrix::from_diagonal(&spectrum.eigen.values.map(|x| if x > 0.0 { 1.0 / x } else { 0.0 }));
        scale(&(&vectors * inverse * vectors.transpose()), &self.units)
    }
}

impl Spectrum {
    /// Derivative of the cost along the step under a damping.
    pub(crate) fn slope(&self, damping: f64) -> f64 {
        let terms = self.right.iter().zip(self.eigen.values.iter());
        -2.0 * terms.map(|(r, v)| if v + damping == 0.0 { 0.0 } else { r * r / (v + damping) }).sum::<f64>()
    }

    /// The smallest eigenvalue; infinite where there is no unknown.
    pub(crate) fn smallest(&self) -> f64 {
        self.eigen.values.iter().fold(f64::INFINITY, |m, &x| m.min(x))
    }

    /// The largest eigenvalue, at least 0.
    pub(crate) fn largest(&self) -> f64 {
        self.eigen.values.iter().fold(0.0, |m, &x| m.max(x))
    }
}

/// `diag(s) M diag(s)`.
fn scale(matrix: &DMatrix<f64>, units: &DVector<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(units.len(), units.len(), |i, j| units[i] * matrix[(i, j)] * units[j])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_directions_are_left_alone() {
        // Singular along (1, 2, 0).
        let a = DMatrix::from_row_slice(2, 3, &[2.0, -1.0, 1.0, -2.0, 1.0, 3.0]);
        let matrix = a.tr_mul(&a);
        let scaled = Scaled::new(&matrix, &[true, true, false], 1.0, 1e-10);
        assert_eq!(scaled.free_steps().len(), 1);
        let free = &scaled.free_steps()[0];
        assert!((&matrix * free).norm() < 1e-12);
        let b = &matrix * DVector::from_vec(vec![1.0, 1.0, 1.0]);
        let step = scaled.step(&scaled.spectrum(&matrix, &b), 0.0);
        assert!((&matrix * &step + &b).norm() < 1e-12 && step.dot(free).abs() < 1e-12);
        let inverse = scaled.inverse(&matrix);
        assert!((&matrix * &inverse * &matrix - &matrix).norm() < 1e-10);
        let damped = scaled.step(&scaled.spectrum(&matrix, &b), 1e9);
        assert!(damped.norm() < 1e-7);
    }

    #[test]
    fn units_do_not_matter() {
        let a = DMatrix::from_row_slice(2, 2, &[2.0, -1.0, 1.0, 3.0]);
        let (matrix, b) = (a.tr_mul(&a), DVector::from_vec(vec![1.0, -2.0]));
        let step = |length: f64| {
            let units = DVector::from_vec(vec![1.0 / length, 1.0]);
            let (matrix, b) = (scale(&matrix, &units), b.component_mul(&units));
            let scaled = Scaled::new(&matrix, &[true, false], length, 1e-10);
            scaled
                .step(&scaled.spectrum(&matrix, &b), 0.5)
                .component_div(&DVector::from_vec(vec![length, 1.0]))
        };
        assert!((step(1.0) - step(1e3)).norm() < 1e-14);
    }
}
