//! What a fit found.

use crate::Status;
use distance_field::PrincipalFrame;
use nalgebra::SVector;

/// One iteration of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct FitStep {
    /// Number of the iteration, from 1.
    pub iteration: usize,
    /// Factor of the energy in this step.
    pub lambda: f64,
    /// Root mean square distance after the step, with the weights of the samples.
    pub rms: f64,
    /// Largest distance of a sample that counts, after the step.
    pub max: f64,
    /// What was minimised, after the step: mean squared distance plus `λ` times the energy.
    pub cost: f64,
    /// How far a coefficient moved at most, as a share of the size of the shape.
    pub displacement: f64,
    /// Factor of the step taken by Armijo's rule, otherwise 1.
    pub factor: f64,
    /// Damping of the displacements as a share of the mean of the diagonal; 0 for a full step.
    pub damping: f64,
    /// How many times all footpoints were found for this step.
    pub evaluations: usize,
    /// Number of samples with a weight.
    pub samples: usize,
    /// Number of coefficients of the shape.
    pub coefficients: usize,
    /// Whether the matrix of the step was not positive definite and a multiple of the unit matrix was added to it, so that it is no
    /// literal Newton step: the Taylor model away from a minimum, or rounding.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub lifted: bool,
}

/// How a fit went.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct FitReport {
    /// How the iteration ended.
    pub status: Status,
    /// Root mean square distance before the first step.
    pub initial_rms: f64,
    /// Root mean square distance of the samples, with their weights.
    pub rms: f64,
    /// Largest distance of a sample that counts.
    pub max: f64,
    /// Index of that sample.
    pub max_index: usize,
    /// The factor of the energy at the end.
    pub lambda: f64,
    /// Number of samples: data points or sensor points.
    pub samples: usize,
    /// Number of those that count at the end.
    #[cfg_attr(feature = "serde", serde(rename = "points_used"))]
    pub used: usize,
    /// Every iteration.
    pub history: Vec<FitStep>,
}

/// The status of a fit that ended within the tolerance that was asked for, or not: then its steps were enough.
pub(crate) fn status_within(status: Status, tolerance: bool) -> Status {
    if status == Status::MaxIterations && tolerance { Status::Converged } else { status }
}

impl FitReport {
    /// Whether the shape is a local minimum.
    #[must_use]
    pub fn is_converged(&self) -> bool {
        self.status.is_converged()
    }
}

impl std::fmt::Display for FitReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} after {} iterations, rms {:.4e}, max {:.4e}, {} of {} samples",
            self.status,
            self.history.len(),
            self.rms,
            self.max,
            self.used,
            self.samples
        )
    }
}

/// A fitted shape.
#[derive(Clone, Debug)]
pub struct Fitted<S, const D: usize> {
    /// The shape.
    pub shape: S,
    /// How it came about.
    pub report: FitReport,
    /// The frame of every sample at the end: for data points the foot on the shape, with its parameter as hint; for sensor
    /// points that on the model.
    pub frames: Vec<PrincipalFrame<D>>,
    /// The coefficients before the first and after every iteration, if they were to be kept.
    pub evolution: Vec<Vec<SVector<f64, D>>>,
}
