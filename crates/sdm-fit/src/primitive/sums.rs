//! Sums over the points: cost, gradient, triangular factor of the Jacobian.

use super::model::{MAX_UNKNOWNS, Model};
use crate::parallel;
use nalgebra::{DMatrix, DVector, SVector};

/// What a distance is worth.
#[derive(Clone, Copy, Debug)]
pub(super) enum Worth {
    /// Its square.
    Square,
    /// Tukey's biweight of the scale `c`: the square near 0, constant beyond `c`.
    Tukey(f64),
}

impl Worth {
    /// Loss and weight (its derivative by `d²`).
    pub(super) fn of(self, distance_sq: f64) -> (f64, f64) {
        match self {
            Self::Square => (distance_sq, 1.0),
            Self::Tukey(scale) => {
                let rest = (1.0 - distance_sq / (scale * scale)).max(0.0);
                (scale * scale / 3.0 * (1.0 - rest.powi(3)), rest * rest)
            }
        }
    }

    /// Whether a point at this distance counts.
    pub(super) fn counts(self, distance_sq: f64) -> bool {
        match self {
            Self::Square => true,
            Self::Tukey(scale) => distance_sq < scale * scale,
        }
    }
}

/// Sum of the losses.
pub(super) fn cost<const D: usize, M: Model<D>>(model: &M, points: &[SVector<f64, D>], worth: Worth) -> f64 {
    let part = |range: std::ops::Range<usize>| {
        points[range].iter().map(|x| worth.of(model.distance_sq(x)).0).sum::<f64>()
    };
    parallel::ranges(points.len(), part).iter().sum()
}

/// Half the gradient of the cost, `Σ w r ∂r`.
pub(super) fn gradient<const D: usize, M: Model<D>>(
    model: &M,
    points: &[SVector<f64, D>],
    worth: Worth,
) -> DVector<f64> {
    let part = |range: std::ops::Range<usize>| {
        let mut sum = [0.0; MAX_UNKNOWNS];
        for x in &points[range] {
            let rows = model.rows(x);
            let (_, weight) = worth.of(rows.iter().map(|r| r.residual * r.residual).sum());
            for row in &rows[..M::ROWS] {
                for k in 0..M::UNKNOWNS {
                    sum[k] += weight * row.residual * row.slopes[k];
                }
            }
        }
        sum
    };
    let mut total = DVector::zeros(M::UNKNOWNS);
    for sum in parallel::ranges(points.len(), part) {
        for k in 0..M::UNKNOWNS {
            total[k] += sum[k];
        }
    }
    total
}

/// The triangular factor of the weighted Jacobian with the residuals as last column: `[R q; 0 ρ]`, so that the step of
/// Gauss and Newton is `−R⁻¹ q`. Orthogonal reductions only: the condition is not squared.
pub(super) fn factor<const D: usize, M: Model<D>>(
    model: &M,
    points: &[SVector<f64, D>],
    worth: Worth,
) -> DMatrix<f64> {
    let columns = M::UNKNOWNS + 1;
    let part = |range: std::ops::Range<usize>| {
        let mut rows = DMatrix::zeros((range.len() * M::ROWS).max(columns), columns);
        for (i, x) in points[range].iter().enumerate() {
            let found = model.rows(x);
            let root = worth.of(found.iter().map(|r| r.residual * r.residual).sum()).1.sqrt();
            for (j, row) in found[..M::ROWS].iter().enumerate() {
                for k in 0..M::UNKNOWNS {
                    rows[(i * M::ROWS + j, k)] = root * row.slopes[k];
                }
                rows[(i * M::ROWS + j, columns - 1)] = root * row.residual;
            }
        }
        rows.qr().unpack_r()
    };
    let mut total = DMatrix::zeros(columns, columns);
    for r in parallel::ranges(points.len(), part) {
        let mut stacked = DMatrix::zeros(2 * columns, columns);
        stacked.rows_mut(0, columns).copy_from(&total);
        stacked.rows_mut(columns, columns).copy_from(&r);
        total = stacked.qr().unpack_r();
    }
    total
}
