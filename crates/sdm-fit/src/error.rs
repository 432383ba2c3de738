//! Errors of this crate.

/// What can be wrong with the input of a fit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A shape is not determined by so few points.
    #[error("{finite} of {total} points can be used, at least {needed} are needed")]
    TooFewPoints {
        /// Points given.
        total: usize,
        /// Points with finite coordinates and a positive weight.
        finite: usize,
        /// Points needed.
        needed: usize,
    },
    /// The points lie so that the shape is not determined.
    #[error("the points lie {what}: {shape} is not determined by them")]
    Degenerate {
        /// The shape that was asked for.
        shape: &'static str,
        /// Where the points lie.
        what: &'static str,
    },
    /// Points so near to each other, or so far apart, that squares of lengths cannot be computed with.
    #[error(
        "the cloud is {size:.1e} wide, but sizes from {least:.0e} to {most:.0e} can be computed with; use another unit of length"
    )]
    Magnitude {
        /// Largest distance from the middle of the points, doubled.
        size: f64,
        /// Least size.
        least: f64,
        /// Largest size.
        most: f64,
    },
    /// The points lie on several curves that do not touch each other.
    #[error(
        "the points lie on {} curves that are apart from each other ({}): fit each by itself, or say how wide a gap may be",
        sizes.len(),
        sizes.iter().map(|n| format!("{n} points")).collect::<Vec<_>>().join(", ")
    )]
    SeveralParts {
        /// Number of points on each.
        sizes: Vec<usize>,
    },
    /// An option outside its range.
    #[error("option {name} is {value}, but must be {allowed}")]
    Option {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Points with coordinates that are not finite.
    #[error("point {index} is not finite, the first of {count}; leave such points out")]
    NotFinite {
        /// The first such point.
        index: usize,
        /// Their number.
        count: usize,
    },
    /// An array that goes with the points has not one entry per point.
    #[error("{found} {what} for {points} points")]
    Length {
        /// What the array holds.
        what: &'static str,
        /// Its length.
        found: usize,
        /// Number of points.
        points: usize,
    },
    /// A weight that is negative or not finite.
    #[error("weight {value} of point {index} is not a finite number of at least 0")]
    Weight {
        /// The point.
        index: usize,
        /// Its weight.
        value: f64,
    },
    /// Side conditions that contradict each other or name an unknown that does not exist.
    #[error("side condition {index}: {what}")]
    Constraint {
        /// Index of the condition.
        index: usize,
        /// What is wrong with it.
        what: &'static str,
    },
    /// A rational shape where one is needed that is linear in its unknowns.
    #[error("the shape has weights: it is not linear in its unknowns; take one without")]
    Rational,
    /// A surface that is to be ruled and is not of degree 1 in v.
    #[error(
        "the degree in v is {degree}: a ruled surface has degree 1, its rulings in v; transpose it, or take another one"
    )]
    NotRuled {
        /// Its degree in v.
        degree: usize,
    },
    /// A shape of `nurbs-core` cannot be made.
    #[error(transparent)]
    Shape(#[from] nurbs_core::Error),
    /// The active shape cannot be projected onto.
    #[error("the active shape cannot be projected onto: {reason}")]
    Field {
        /// Why not.
        reason: String,
    },
}

impl From<distance_field::Error> for Error {
    fn from(error: distance_field::Error) -> Self {
        Self::Field { reason: error.to_string() }
    }
}

impl From<mesh_core::Error> for Error {
    fn from(error: mesh_core::Error) -> Self {
        Self::Field { reason: error.to_string() }
    }
}
