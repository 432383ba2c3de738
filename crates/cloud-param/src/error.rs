//! Errors of this crate.

/// What can be wrong with a cloud that is to be parameterised.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A step needs more points.
    #[error("{finite} of {total} points can be used, at least {needed} are needed")]
    TooFewPoints {
        /// Points given.
        total: usize,
        /// Points with finite coordinates.
        finite: usize,
        /// Points needed.
        needed: usize,
    },
}
