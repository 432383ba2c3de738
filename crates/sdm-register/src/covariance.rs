//! How well the pose is determined.

use crate::constraint::Freedom;
use crate::correlation::Correlation;
use crate::eigen::Eigen;
use crate::linearise::NormalSystem;
use crate::motion::{MAX_UNKNOWNS, rigid_unknowns};
use crate::solve::Scaled;
use crate::{Pose, Velocity};
use nalgebra::{DMatrix, DVector, SVector};

/// The covariance of a pose, `k σ̂² (JᵀJ)⁻¹`: normally distributed distances of the points that count are assumed, with the
/// variance `σ̂²` that the residuals show, of which `k` neighbouring ones count as one where they are correlated.
///
/// The unknowns are the displacement of [`Covariance::origin`] and the rotation vector about it, in the model's axes, and
/// the logarithm of the scale where that is estimated. Directions that are locked, or not fixed by the shape, have no
/// variance.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Covariance<const D: usize> {
    /// The matrix by rows: translations, rotations (and scale). Squared lengths, lengths times radians, squared radians.
    pub rows: Vec<Vec<f64>>,
    /// The point whose displacement is meant: the image of the centre of the cloud.
    #[cfg_attr(feature = "serde", serde(serialize_with = "crate::report::as_slice"))]
    pub origin: SVector<f64, D>,
    /// `σ̂`, the standard deviation of the distances.
    pub sigma: f64,
    /// Number of points minus number of unknowns.
    pub degrees_of_freedom: usize,
    /// `k`, the number of points that count as one independent point; 1 where no correlation is seen.
    pub points_per_independent: f64,
    /// Distance up to which the residuals of neighbours are correlated, in the model's unit; 0 where no correlation is seen.
    pub correlation_length: f64,
    /// Smallest eigenvalue of `JᵀJ` over the largest, with lengths in units of half the diagonal of the cloud.
    pub conditioning: f64,
}

/// What the residuals of the points that count add up to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Residuals {
    /// Sum of their weighted squares, in `unit`.
    pub(crate) squares: f64,
    /// The unit in which distances count, in that of the model.
    pub(crate) unit: f64,
    /// How they depend on each other.
    pub(crate) correlation: Correlation,
}

impl<const D: usize> Covariance<D> {
    /// From the sums at the end; distances are in a unit of their own, which is given in that of the model.
    pub(crate) fn new(
        system: &NormalSystem<D>,
        freedom: &Freedom<D>,
        scaled: &Scaled,
        tangent: &DMatrix<f64>,
        residuals: &Residuals,
        scale: bool,
        origin: SVector<f64, D>,
    ) -> Self {
        let unknowns = scaled.rank();
        let degrees_of_freedom = system.count.saturating_sub(unknowns);
        // Weights are relative: their mean is that of a point.
        let mean_weight = if system.count > 0 { system.weight / system.count as f64 } else { 1.0 };
        let Residuals { squares, unit, correlation } = *residuals;
        let variance = squares / mean_weight / degrees_of_freedom.max(1) as f64;
        // The fit takes its unknowns from the independent points, not from all.
        let independent = system.count as f64 / correlation.per_independent;
        let spent = |points: f64| points / (points - unknowns as f64).max(1.0);
        let growth = if correlation.per_independent > 1.0 {
            correlation.per_independent * spent(independent) / spent(system.count as f64)
        } else {
            1.0
        };
        let inverse = scaled.inverse(tangent) * (growth * variance * mean_weight);
        let full = &freedom.basis * inverse * freedom.basis.transpose();
        let shown = rigid_unknowns(D) + usize::from(scale);
        Self {
            rows: (0..shown.min(MAX_UNKNOWNS)).map(|i| (0..shown).map(|j| full[(i, j)]).collect()).collect(),
            origin,
            sigma: variance.sqrt() * unit,
            degrees_of_freedom,
            points_per_independent: correlation.per_independent,
            correlation_length: correlation.length,
            conditioning: if scaled.extremes[1] > 0.0 {
                scaled.extremes[0] / scaled.extremes[1]
            } else {
                0.0
            },
        }
    }

    /// The squared distance of another pose from the one found, measured by the covariance (`xᵀ C⁻¹ x` over the directions
    /// that have a variance): for the true pose its mean is the number of unknowns.
    #[must_use]
    pub fn squared_distance(&self, found: &Pose<D>, other: &Pose<D>) -> f64 {
        let moved = found.inverse().followed_by(other);
        let difference = Velocity::<D> {
            translation: moved.apply(&self.origin) - self.origin,
            rotation: moved.rotation_vector(),
            growth: moved.scale.ln(),
        };
        let unknowns = difference.to_unknowns();
        let n = self.rows.len();
        // Equal units for the eigenvectors: divide by the standard deviations.
        let deviation = |i: usize| self.rows[i][i].max(0.0).sqrt();
        let scaled = |i: usize, x: f64| if deviation(i) > 0.0 { x / deviation(i) } else { 0.0 };
        let correlation = DMatrix::from_fn(n, n, |i, j| scaled(i, scaled(j, self.rows[i][j])));
        let x = DVector::from_fn(n, |i, _| scaled(i, unknowns[i]));
        let eigen = Eigen::new(correlation);
        let y = eigen.vectors.tr_mul(&x);
        let largest = eigen.values.amax();
        (0..n).filter(|&i| eigen.values[i] > 1e-12 * largest).map(|i| y[i] * y[i] / eigen.values[i]).sum()
    }
}
