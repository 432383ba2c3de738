//! The methods: which quadratic model is minimised in a step, and how far one goes.

use distance_field::ErrorTerm;

/// Which step is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Method {
    /// The tangent term while far, which goes far, and Newton's method as soon as its model foretells what a step
    /// does: quadratic convergence also where residuals stay.
    #[default]
    Adaptive,
    /// One error term throughout, with the motion linearised (\[P05, sec. 5\]): ICP, Chen and Medioni, SDM.
    Term(ErrorTerm),
    /// Newton's method throughout: exact second derivatives of the distance and of the motion.
    Newton,
    /// The symmetric objective of \[Ru19\]: distances along the sum of the normals at the point and at its foot. Needs
    /// normals of the points; where there is none, the tangent term.
    Symmetric,
    /// The point term with Anderson acceleration (\[PNG18\]).
    AndersonPoint,
}

impl Method {
    /// The classical iterated closest point algorithm.
    pub const ICP: Self = Self::Term(ErrorTerm::Point);
    /// The algorithm of Chen and Medioni: point to tangent plane.
    pub const TANGENT: Self = Self::Term(ErrorTerm::Tangent);
    /// Squared distance minimisation with nonnegative models.
    pub const SDM: Self = Self::Term(ErrorTerm::SquaredDistance);

    /// The error term of the linear steps.
    pub(crate) fn term(self) -> ErrorTerm {
        match self {
            Self::Term(term) => term,
            Self::AndersonPoint => ErrorTerm::Point,
            Self::Adaptive | Self::Newton | Self::Symmetric => ErrorTerm::Tangent,
        }
    }

    /// Whether second derivatives are needed.
    pub(crate) fn needs_taylor(self) -> bool {
        matches!(self, Self::Adaptive | Self::Newton)
    }

    /// The name used in files and options.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Adaptive => "adaptive",
            Self::Term(term) => term.name(),
            Self::Newton => "newton",
            Self::Symmetric => "symmetric",
            Self::AndersonPoint => "anderson_point",
        }
    }
}
