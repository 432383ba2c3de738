//! What can be wrong with the input of a projection.

/// Invalid input; a projection that merely fails to converge says so in its [`Status`](crate::Status).
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A shape could not be prepared.
    #[error(transparent)]
    Shape(#[from] nurbs_core::Error),
    /// There is nothing to project onto.
    #[error("the model has no shapes; give at least one curve or surface")]
    EmptyModel,
    /// A point to be projected is not finite.
    #[error("point {index} has a coordinate that is not finite")]
    NonFinitePoint {
        /// Index of the point (0 for a single one).
        index: usize,
    },
    /// An option has a value that cannot be used.
    #[error("option `{option}` is {value}: {what}")]
    Option {
        /// Name of the option.
        option: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        what: &'static str,
    },
    /// The number of initial parameters differs from the number of points.
    #[error("{found} initial parameters given for {needed} points")]
    StartCount {
        /// Number of initial parameters.
        found: usize,
        /// Number of points.
        needed: usize,
    },
    /// The point of an inversion does not lie on the shape.
    #[error("the point is {distance} away from the shape, more than the tolerance {tolerance}")]
    NotOnShape {
        /// Distance of the point from the shape.
        distance: f64,
        /// The tolerance that was asked for.
        tolerance: f64,
    },
}
