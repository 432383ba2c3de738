//! How a projection ended, and where its footpoint lies.

use std::fmt;

/// How an iteration or a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Status {
    /// The optimality (Karush-Kuhn-Tucker) conditions hold in the interior of the domain.
    Converged,
    /// They hold at the boundary of the domain: the distance would decrease outside only.
    OnBoundary,
    /// The optimality conditions hold, in the interior or at the boundary, but a certificate was asked for and stayed open:
    /// `distance − lower_bound` is larger than the options allow, so that another point may be nearer by as much.
    /// Rounding does not count: the square of a lower bound on a curve is not known better than some 1e-14 of the squared size.
    Uncertified,
    /// Steps became negligible, but the optimality conditions do not hold.
    Stalled,
    /// The limit on iterations was reached first.
    MaxIterations,
    /// The iteration left every bound or met values that are not finite.
    Diverged,
    /// The caller cancelled the run before this point was treated.
    Cancelled,
    /// The point has a coordinate that is not finite; nothing was computed.
    InvalidPoint,
    /// No foot of the point has a normal that agrees with the direction given ([`Facing`](crate::Facing)).
    NoMatchingFoot,
    /// The point has no normal, though only feet count whose normals agree with it; nothing was computed.
    NoNormal,
}

impl Status {
    /// Whether the footpoint satisfies the optimality conditions, proven to be the nearest or not.
    #[must_use]
    pub fn is_converged(self) -> bool {
        matches!(self, Self::Converged | Self::OnBoundary | Self::Uncertified)
    }

    /// The name used in files: `converged`, `on_boundary`, …
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::OnBoundary => "on_boundary",
            Self::Uncertified => "uncertified",
            Self::Stalled => "stalled",
            Self::MaxIterations => "max_iterations",
            Self::Diverged => "diverged",
            Self::Cancelled => "cancelled",
            Self::InvalidPoint => "invalid_point",
            Self::NoMatchingFoot => "no_matching_foot",
            Self::NoNormal => "no_normal",
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Where on its shape a footpoint lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Location {
    /// Inside the domain.
    Interior,
    /// On a boundary curve of a surface, or at an end of a curve.
    Edge,
    /// At a corner of the domain of a surface.
    Corner,
    /// Where a closed shape meets itself: the same point has a second parameter.
    Seam,
    /// At a point into which an edge of the domain is collapsed.
    Pole,
}

/// Whether other points of the shape are as near as the footpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Multiplicity {
    /// Not examined (local and fast modes).
    Unknown,
    /// The search met no other point at the same distance.
    Unique,
    /// At least one other point, apart from this one, is as near.
    Tied,
    /// A whole curve or surface piece of points is as near: the query is a centre or on an axis.
    Continuum,
}
