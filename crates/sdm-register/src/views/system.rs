//! The system of equations for the motions of all views.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix6, Vector3, Vector6};

use super::matching::Matches;
use crate::parallel;

/// Eigenvalues of the system below this share of the largest belong to motions that nothing resists.
const FREE_SHARE: f64 = 1e-7;
/// Pivots of its factor below this share of the largest element of the diagonal make it worth while to look for such motions.
const SUSPICIOUS: f64 = 1e-4;

/// Normal equations of one directed pair: `JᵀWJ`, `JᵀWd`, `Σ w d²`, `Σ w`.
struct Block {
    matrix: Matrix6<f64>,
    gradient: Vector6<f64>,
    cost: f64,
    weight: f64,
}

/// Normal equations of all views that move.
#[derive(Debug)]
pub(crate) struct System {
    /// Row of the first unknown of each view; `None` for a view that is held.
    rows: Vec<Option<usize>>,
    matrix: DMatrix<f64>,
    gradient: DVector<f64>,
    /// The centre of each view, in the frame of the twists.
    centres: Vec<Vector3<f64>>,
    /// `Σ w d²`.
    pub(crate) cost: f64,
    /// `Σ w`.
    pub(crate) weight: f64,
}

impl System {
    /// Sums up the matches, each with Tukey's weight for the distance `limit`; views with `held` do not move.
    pub(crate) fn new(matches: &[Matches], held: &[bool], centres: Vec<Vector3<f64>>, limit: f64) -> Self {
        let mut size = 0;
        let rows: Vec<Option<usize>> = held
            .iter()
            .map(|held| {
                (!held).then(|| {
                    size += 6;
                    size - 6
                })
            })
            .collect();
        let blocks = parallel::tasks(matches.len(), |k| block(&matches[k], limit));
        let mut out = Self {
            rows,
            matrix: DMatrix::zeros(size, size),
            gradient: DVector::zeros(size),
            centres,
            cost: 0.0,
            weight: 0.0,
        };
        for (pair, block) in matches.iter().zip(blocks) {
            let [moving, still] = pair.views.map(|view| out.rows[view]);
            out.cost += block.cost;
            out.weight += block.weight;
            for (row, sign) in [(moving, 1.0), (still, -1.0)] {
                let Some(row) = row else { continue };
                let mut diagonal = out.matrix.fixed_view_mut::<6, 6>(row, row);
                diagonal += block.matrix;
                let mut part = out.gradient.fixed_rows_mut::<6>(row);
                part += block.gradient * sign;
            }
            if let (Some(a), Some(b)) = (moving, still) {
                for (i, j) in [(a, b), (b, a)] {
                    let mut mixed = out.matrix.fixed_view_mut::<6, 6>(i, j);
                    mixed -= block.matrix;
                }
            }
        }
        out
    }

    /// The twist `(c, c̄)` of each view, 0 for those that are held; `None` if the system has no solution.
    ///
    /// Motions that nothing resists are not made.
    pub(crate) fn solve(&self) -> Option<Vec<Vector6<f64>>> {
        let factor = self.factor(1e-12);
        let is_weak = factor.as_ref().is_none_or(|factor| {
            let pivots = factor.l_dirty().diagonal().map(|pivot| pivot * pivot);
            pivots.min() <= SUSPICIOUS * self.matrix.diagonal().amax()
        });
        let solution = match factor {
            Some(factor) if !is_weak => factor.solve(&-&self.gradient),
            _ => self.resisted_solution(),
        };
        if !solution.iter().all(|value| value.is_finite()) {
            return None;
        }
        let twist = |row: &Option<usize>| {
            row.map_or_else(Vector6::zeros, |row| solution.fixed_rows::<6>(row).into_owned())
        };
        Some(self.rows.iter().map(twist).collect())
    }

    /// The solution without the motions that nothing resists: what else would move the views along them is rounding, or what the
    /// surfaces between the points are not known to.
    fn resisted_solution(&self) -> DVector<f64> {
        if self.matrix.is_empty() {
            return DVector::zeros(0);
        }
        let about = self.about_centres();
        let eigen = (about.tr_mul(&self.matrix) * &about).symmetric_eigen();
        let limit = FREE_SHARE * eigen.eigenvalues.max();
        let right = eigen.eigenvectors.tr_mul(&about.tr_mul(&self.gradient));
        let inner = right.zip_map(
            &eigen.eigenvalues,
            |right, value| {
                if value > limit { -right / value } else { 0.0 }
            },
        );
        about * (&eigen.eigenvectors * inner)
    }

    /// Takes turns about the centre of each view, and displacements of it, to twists: far from the origin of these, turns and
    /// displacements can hardly be told apart.
    fn about_centres(&self) -> DMatrix<f64> {
        let mut out = DMatrix::identity(self.matrix.nrows(), self.matrix.nrows());
        for (row, centre) in self.rows.iter().zip(&self.centres) {
            let Some(row) = *row else { continue };
            out.fixed_view_mut::<3, 3>(row + 3, row).copy_from(&centre.cross_matrix());
        }
        out
    }

    /// Number of independent motions of the views that no distance resists.
    pub(crate) fn free_motions(&self) -> usize {
        if self.matrix.is_empty() {
            return 0;
        }
        let about = self.about_centres();
        let values = (about.tr_mul(&self.matrix) * about).symmetric_eigenvalues();
        let largest = values.max();
        values.iter().filter(|&&value| value <= FREE_SHARE * largest).count()
    }

    /// Root mean square distance over the root of the number of points, as far as they have weight.
    pub(crate) fn standard_error(&self) -> f64 {
        self.cost.sqrt() / self.weight.max(f64::MIN_POSITIVE)
    }

    /// `σ̂² (JᵀJ)⁻¹`, the block of each view; 0 for those that are held.
    pub(crate) fn covariances(&self, count: usize) -> Option<Vec<Matrix6<f64>>> {
        let freedom = count.checked_sub(self.matrix.nrows()).filter(|&freedom| freedom > 0)?;
        let variance = self.cost / self.weight.max(f64::MIN_POSITIVE) * count as f64 / freedom as f64;
        let inverse = self.factor(0.0)?.inverse() * variance;
        let block = |row: &Option<usize>| {
            row.map_or_else(Matrix6::zeros, |row| inverse.fixed_view::<6, 6>(row, row).into_owned())
        };
        Some(self.rows.iter().map(block).collect())
    }

    fn factor(&self, damping: f64) -> Option<Cholesky<f64, Dyn>> {
        let mut matrix = self.matrix.clone();
        let damping = damping * matrix.diagonal().amax();
        for i in 0..matrix.nrows() {
            matrix[(i, i)] += damping;
        }
        matrix.cholesky()
    }
}

fn block(pair: &Matches, limit: f64) -> Block {
    let mut out = Block { matrix: Matrix6::zeros(), gradient: Vector6::zeros(), cost: 0.0, weight: 0.0 };
    for found in &pair.list {
        let inside = 1.0 - (found.distance / limit).powi(2);
        if inside > 0.0 {
            let arm = found.point.cross(&found.normal);
            let n = found.normal;
            let row = Vector6::new(arm.x, arm.y, arm.z, n.x, n.y, n.z);
            let weight = inside * inside;
            let weighted = row * weight;
            out.matrix.ger(1.0, &weighted, &row, 1.0);
            out.gradient.axpy(found.distance, &weighted, 1.0);
            out.cost += weight * found.distance * found.distance;
            out.weight += weight;
        }
    }
    out
}
