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
}
