//! How a registration ended.

use std::fmt;

/// How the iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Status {
    /// What is left of the motion is below the tolerance; or, by the default method, it goes on along the shape without a
    /// difference to the cost.
    Converged,
    /// No step lowers the cost, although the motion is not below the tolerance.
    Stalled,
    /// The limit on iterations was reached first.
    MaxIterations,
    /// The iteration met values that are not finite.
    Diverged,
    /// Points and shape lie in a plane each, in which nothing fixes the motion.
    Underdetermined,
    /// Too few points lie on the shape for the pose to mean anything.
    NoOverlap,
    /// The iteration converged, but the points do not speak for the pose; [`Support::doubt`](crate::Support::doubt) says why.
    Doubtful,
    /// The caller cancelled.
    Cancelled,
}

impl Status {
    /// Whether the pose is a local minimum that the points speak for.
    #[must_use]
    pub fn is_converged(self) -> bool {
        matches!(self, Self::Converged)
    }

    /// The name used in files: `converged`, `no_overlap`, …
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::Stalled => "stalled",
            Self::MaxIterations => "max_iterations",
            Self::Diverged => "diverged",
            Self::NoOverlap => "no_overlap",
            Self::Doubtful => "doubtful",
            Self::Underdetermined => "underdetermined",
            Self::Cancelled => "cancelled",
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
