//! How an iteration ended.

use std::fmt;

/// How an iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Status {
    /// The state no longer changes, or is as good as was asked for. In the default method of a registration also: it goes on moving
    /// along the shape without a difference to the cost.
    Converged,
    /// No step lowers the cost, although the step that the models ask for is not small.
    Stalled,
    /// The limit on iterations was reached first.
    MaxIterations,
    /// The iteration met values that are not finite, or left the region of the data; the state is the best one before.
    Diverged,
    /// Of a fit: the data leave some unknowns undetermined. Use fewer, smooth, or hold some.
    Singular,
    /// Of a registration: points and shape lie in a plane each, in which nothing fixes the motion.
    Underdetermined,
    /// Of a registration: too few points lie on the shape for the pose to mean anything.
    NoOverlap,
    /// Of a registration: the iteration converged, but the points do not speak for the pose; its support says why.
    Doubtful,
    /// The caller cancelled.
    Cancelled,
}

impl Status {
    /// Whether the state is a local minimum, and of a registration one that the points speak for.
    #[must_use]
    pub fn is_converged(self) -> bool {
        matches!(self, Self::Converged)
    }

    /// The name used in files: `converged`, `max_iterations`, …
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::Stalled => "stalled",
            Self::MaxIterations => "max_iterations",
            Self::Diverged => "diverged",
            Self::Singular => "singular",
            Self::Underdetermined => "underdetermined",
            Self::NoOverlap => "no_overlap",
            Self::Doubtful => "doubtful",
            Self::Cancelled => "cancelled",
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
