//! What can be wrong with a description.

/// Why no model can be built from a description.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A number of the description cannot be used.
    #[error("{what}: {why}")]
    Description {
        /// What it belongs to: `face #12 "top"`, `edge #7`.
        what: String,
        /// What is wrong with it.
        why: String,
    },
    /// No instance holds a face or a curve.
    #[error("the model has no faces; export the part as solids or surfaces")]
    Empty,
}

impl Error {
    pub(crate) fn of(what: impl Into<String>, why: impl ToString) -> Self {
        Self::Description { what: what.into(), why: why.to_string() }
    }
}
