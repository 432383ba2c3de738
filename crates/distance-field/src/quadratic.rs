//! Quadratic models of the squared distance function.

use nalgebra::{SMatrix, SVector};

/// `F(x) = Σ wᵢ ⟨eᵢ, x − f⟩²` with orthonormal axes `eᵢ` at the foot `f` (\[P05, eqs. (3)-(5)\]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadraticModel<const D: usize> {
    /// The footpoint, where the model vanishes.
    pub foot: SVector<f64, D>,
    /// Orthonormal axes, one per column.
    pub axes: SMatrix<f64, D, D>,
    /// The weight of each axis.
    pub weights: SVector<f64, D>,
}

impl<const D: usize> QuadraticModel<D> {
    /// The value `F(x)`, a squared length.
    #[must_use]
    pub fn value(&self, x: &SVector<f64, D>) -> f64 {
        let local = self.axes.tr_mul(&(x - self.foot));
        local.component_mul(&local).dot(&self.weights)
    }

    /// The gradient `2 Σ wᵢ ⟨eᵢ, x − f⟩ eᵢ`.
    #[must_use]
    pub fn gradient(&self, x: &SVector<f64, D>) -> SVector<f64, D> {
        let local = self.axes.tr_mul(&(x - self.foot));
        self.axes * local.component_mul(&self.weights) * 2.0
    }

    /// The matrix `Q = Σ wᵢ eᵢ eᵢᵀ`, with `F(x) = (x − f)ᵀ Q (x − f)`.
    #[must_use]
    pub fn matrix(&self) -> SMatrix<f64, D, D> {
        let mut out = SMatrix::zeros();
        for i in 0..D {
            let axis = self.axes.column(i);
            out += axis * axis.transpose() * self.weights[i];
        }
        out
    }

    /// The Hessian `2 Q`, the same everywhere.
    #[must_use]
    pub fn hessian(&self) -> SMatrix<f64, D, D> {
        self.matrix() * 2.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Vector2};

    #[test]
    fn value_gradient_and_hessian_agree() {
        let (sine, cosine) = 0.3f64.sin_cos();
        let model = QuadraticModel {
            foot: Vector2::new(1.0, -2.0),
            axes: Matrix2::new(cosine, -sine, sine, cosine),
            weights: Vector2::new(-0.5, 1.0),
        };
        let (x, step) = (Vector2::new(2.0, 0.5), Vector2::new(-0.25, 0.75));
        let taylor = model.value(&x)
            + model.gradient(&x).dot(&step)
            + 0.5 * (step.transpose() * model.hessian() * step).x;
        assert!((taylor - model.value(&(x + step))).abs() < 1e-14);
        assert_eq!(model.value(&model.foot), 0.0);
    }
}
