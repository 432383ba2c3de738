//! What a registration found.

use crate::{Covariance, FreeMotion, Pose, Status, Support};

/// One step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct RegisterStep {
    /// Stage the step belongs to.
    pub stage: &'static str,
    /// What was minimised: the name of an error term, `newton`, `symmetric`, …
    pub step: &'static str,
    /// Number of points with a weight.
    pub points: usize,
    /// Root mean square distance of the points with their weights, after the step.
    pub rms: f64,
    /// How far the points moved (root mean square) as a share of the size of the cloud.
    pub motion: f64,
    /// Angle of the rotation, radians.
    pub angle: f64,
    /// Damping of Levenberg and Marquardt as a share of the largest eigenvalue; 0 for a full step.
    pub damping: f64,
    /// Factor of the step taken by Armijo's rule, otherwise 1.
    pub factor: f64,
    /// How many times all footpoints were found for this step.
    pub evaluations: usize,
    /// Scale of the robust kernel, or limit of the distance; `None` for least squares.
    pub scale: Option<f64>,
}

/// Where the cloud stands at the end, and how it came there.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct RegisterReport<const D: usize> {
    /// Takes points of the source to the frame of the model.
    pub pose: Pose<D>,
    /// How the iteration ended.
    pub status: Status,
    /// Root mean square distance of the points that count, with their weights.
    pub rms: f64,
    /// The same of the same points, with the same weights, in the starting pose; of more than 1000, of about so many that are evenly
    /// picked.
    pub initial_rms: f64,
    /// What the points that count say about the pose, and why it is not believed where it is not.
    pub support: Support,
    /// Number of steps on all points, and on the coarse ones.
    pub iterations: usize,
    /// How many times the footpoints of a cloud were found, trial steps included.
    pub evaluations: usize,
    /// Number of points in the source.
    pub points: usize,
    /// Number of points left out because they are not finite.
    pub dropped: usize,
    /// Number of points that count at the end.
    pub used: usize,
    /// Largest distance that counts at the end, where outliers were told apart.
    pub limit: Option<f64>,
    /// How well the pose is determined; `None` if too few points count.
    pub covariance: Option<Covariance<D>>,
    /// The motions that the shape does not fix as far as the cloud can tell; the cloud is not moved along them.
    pub free_motions: Vec<FreeMotion<D>>,
    /// Every step.
    pub history: Vec<RegisterStep>,
}

impl<const D: usize> RegisterReport<D> {
    /// Whether the pose is a local minimum.
    #[must_use]
    pub fn is_converged(&self) -> bool {
        self.status.is_converged()
    }
}

impl<const D: usize> std::fmt::Display for RegisterReport<D> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} after {} steps, rms {:.4e}, {} of {} points",
            self.status, self.iterations, self.rms, self.used, self.points
        )?;
        if let Some(doubt) = self.support.doubt {
            write!(f, " ({}: {})", doubt.name(), self.support)?;
        }
        for (i, motion) in self.free_motions.iter().enumerate() {
            write!(f, "{} {motion}", if i == 0 { "; not fixed:" } else { "," })?;
        }
        Ok(())
    }
}

/// Writes a vector, or a matrix column by column, as a list of numbers.
#[cfg(feature = "serde")]
pub(crate) fn as_slice<S: serde::Serializer, const R: usize, const C: usize>(
    matrix: &nalgebra::SMatrix<f64, R, C>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serde::Serialize::serialize(matrix.as_slice(), serializer)
}
