//! How a fit ended.

use std::fmt;

/// How the iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Status {
    /// The shape no longer changes, or is as near to the target as was asked for.
    Converged,
    /// No step lowers the cost, although the step that the models ask for is not small.
    Stalled,
    /// The limit on iterations was reached first.
    MaxIterations,
    /// The iteration met values that are not finite, or left the region of the data; the shape is the best one before.
    Diverged,
    /// The data leave some unknowns undetermined: use fewer, smooth, or hold some.
    Singular,
    /// The caller cancelled.
    Cancelled,
}

impl Status {
    /// Whether the shape is a local minimum.
    #[must_use]
    pub fn is_converged(self) -> bool {
        matches!(self, Self::Converged)
    }

    /// The status of a fit that ended within the tolerance that was asked for, or not: then its steps were enough.
    pub(crate) fn within(self, tolerance: bool) -> Self {
        if self == Self::MaxIterations && tolerance { Self::Converged } else { self }
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
            Self::Cancelled => "cancelled",
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
