//! Eigenvalues of small symmetric matrices, empty and hopeless ones included.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Eigenvalues and orthonormal eigenvectors, one per column. A matrix with numbers that are not finite has the
/// eigenvalues 0, so that nothing counts as determined by it.
#[derive(Clone, Debug)]
pub(crate) struct Eigen {
    pub(crate) values: DVector<f64>,
    pub(crate) vectors: DMatrix<f64>,
}

impl Eigen {
    /// Of a symmetric matrix.
    pub(crate) fn new(matrix: DMatrix<f64>) -> Self {
        let n = matrix.nrows();
        // The library panics on an empty matrix and does not end on NaN.
        if n == 0 || !matrix.iter().all(|c| c.is_finite()) {
            return Self { values: DVector::zeros(n), vectors: DMatrix::identity(n, n) };
        }
        let eigen = SymmetricEigen::new(matrix);
        Self { values: eigen.eigenvalues, vectors: eigen.eigenvectors }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_and_bad_matrices_have_an_answer() {
        assert_eq!(Eigen::new(DMatrix::zeros(0, 0)).values.len(), 0);
        assert_eq!(Eigen::new(DMatrix::repeat(2, 2, f64::NAN)).values, DVector::zeros(2));
        let matrix = DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 1.0, 2.0]);
        let eigen = Eigen::new(matrix.clone());
        let back = &eigen.vectors * DMatrix::from_diagonal(&eigen.values) * eigen.vectors.transpose();
        assert!((back - matrix).norm() < 1e-14);
    }
}
