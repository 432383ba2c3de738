//! How a command ended.

/// How a command ended that was not refused.
#[derive(Debug)]
pub(crate) struct Outcome {
    /// For a person to read.
    pub(crate) summary: String,
    /// Whether everything that was asked for was found.
    pub(crate) converged: bool,
    /// What the report calls it if not.
    pub(crate) otherwise: &'static str,
}

impl Outcome {
    /// The usual outcome: points converged, or not.
    pub(crate) fn new(summary: String, converged: bool) -> Self {
        Self { summary, converged, otherwise: "not_converged" }
    }
}
