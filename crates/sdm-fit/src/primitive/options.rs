//! Options of the fit of a primitive, and how it can end.

use crate::Error;

/// What is assumed about points that do not belong to the shape.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum PrimitiveOutliers {
    /// There are none: least squares over all points.
    #[default]
    None,
    /// Tukey's biweight: points beyond the scale do not count.
    Tukey {
        /// Distance from which points do not count; `None` finds 4.685 standard deviations of the inliers.
        abs_scale: Option<f64>,
    },
    /// The given share of the points, those that are furthest, does not count.
    Trimmed {
        /// In `[0, 1)`.
        outliers: f64,
    },
}

/// How a primitive is fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct PrimitiveOptions {
    /// What is assumed about outliers; default [`PrimitiveOutliers::None`].
    pub outliers: PrimitiveOutliers,
    /// Most steps; default 200.
    pub max_iterations: usize,
    /// Whether the covariance of the result is computed; default not.
    pub covariance: bool,
    /// How many of the points furthest from the shape are listed; default 10.
    pub worst: usize,
}

impl Default for PrimitiveOptions {
    fn default() -> Self {
        Self { outliers: PrimitiveOutliers::None, max_iterations: 200, covariance: false, worst: 10 }
    }
}

impl PrimitiveOptions {
    /// The same options with another assumption about outliers.
    #[must_use]
    pub fn with_outliers(self, outliers: PrimitiveOutliers) -> Self {
        Self { outliers, ..self }
    }

    /// The same options with another limit on the steps.
    #[must_use]
    pub fn with_max_iterations(self, max_iterations: usize) -> Self {
        Self { max_iterations, ..self }
    }

    /// The same options with or without the covariance.
    #[must_use]
    pub fn with_covariance(self, covariance: bool) -> Self {
        Self { covariance, ..self }
    }

    /// The same options with another number of points furthest from the shape that are listed.
    #[must_use]
    pub fn with_worst(self, worst: usize) -> Self {
        Self { worst, ..self }
    }

    /// Checks every number.
    pub(super) fn check(&self) -> Result<(), Error> {
        match self.outliers {
            PrimitiveOutliers::Trimmed { outliers } if !(0.0..1.0).contains(&outliers) => {
                Err(Error::Option { name: "outliers", value: outliers, allowed: "in [0, 1)" })
            }
            PrimitiveOutliers::Tukey { abs_scale: Some(scale) } if !(scale > 0.0 && scale.is_finite()) => {
                Err(Error::Option { name: "abs_scale", value: scale, allowed: "a positive number" })
            }
            _ => Ok(()),
        }
    }
}

/// How the fit of a primitive ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum PrimitiveStatus {
    /// The shape is a minimum as far as numbers can tell, the lowest of all that were found, and a lower one is unlikely
    /// ([`PrimitiveFit::miss_probability`](super::PrimitiveFit::miss_probability)).
    Converged,
    /// No step lowers the sum of squares, although the gradient is not yet zero.
    Stalled,
    /// The limit on steps was reached first.
    MaxIterations,
    /// The points leave the shape open (all on one circle for a sphere, say): one of many is given.
    Undetermined,
    /// A minimum, but other shapes fit as well, or the points are no more than the shape has unknowns, so that several go
    /// through all of them: the measured one need not be among those found
    /// ([`PrimitiveFit::solutions`](super::PrimitiveFit::solutions)).
    Ambiguous,
    /// The sum of squares falls towards shapes that are not of this kind (a torus whose tube meets the axis, or one as good as a
    /// cylinder, cone or plane; a circle as straight as a line): the shape given is the best that was found on this side.
    OnBoundary,
    /// A minimum that may not be the one looked for: a lower one was missed with a chance above 1 in 20, or outliers were to be
    /// told apart and hardly a point was left out of a shape that the points do not lie close to, or those left out lie no less
    /// densely along it than those that count.
    Doubtful,
}

impl PrimitiveStatus {
    /// The name used in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::Stalled => "stalled",
            Self::MaxIterations => "max_iterations",
            Self::Undetermined => "undetermined",
            Self::Ambiguous => "ambiguous",
            Self::OnBoundary => "on_boundary",
            Self::Doubtful => "doubtful",
        }
    }
}

impl std::fmt::Display for PrimitiveStatus {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
