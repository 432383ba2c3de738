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
    /// A shape of `nurbs-core` cannot be made.
    #[error(transparent)]
    Shape(#[from] nurbs_core::Error),
}
