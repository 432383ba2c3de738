//! Errors of this crate.

/// What can be wrong with a cloud that is to be parameterised, or with what is asked of it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A step needs more points.
    #[error("{usable} of {total} points can be used, at least {needed} are needed")]
    TooFewPoints {
        /// Points given.
        total: usize,
        /// Points that can be used: finite, and not equal to others where that matters.
        usable: usize,
        /// Points needed.
        needed: usize,
    },
    /// More points than 32-bit indices can number.
    #[error("{count} points are too many")]
    TooManyPoints {
        /// Points given.
        count: usize,
    },
    /// A point with a coordinate that is not finite, where that is not allowed.
    #[error("point {index} is not finite")]
    NotFinite {
        /// The first such point.
        index: usize,
    },
    /// A rectangle without area.
    #[error("the domain [{low}, {high}] has no extent")]
    EmptyDomain {
        /// Its start.
        low: f64,
        /// Its end.
        high: f64,
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
    /// The cloud has not the shape that a step takes for granted.
    #[error("the cloud is not {wanted}: {why}")]
    Shape {
        /// What it should be.
        wanted: &'static str,
        /// What was found instead, and what to do.
        why: String,
    },
    /// The caller cancelled.
    #[error("cancelled")]
    Cancelled,
    /// A curve or surface could not be made.
    #[error(transparent)]
    Nurbs(#[from] nurbs_core::Error),
    /// A surface could not be finished by squared distance minimisation.
    #[error(transparent)]
    Fit(#[from] sdm_fit::Error),
    /// The neighbours of points could not be found.
    #[error(transparent)]
    Cloud(#[from] mesh_core::Error),
}
