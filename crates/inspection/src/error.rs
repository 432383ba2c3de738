//! What can be wrong with the input of an inspection.

/// Invalid input. A point that cannot be measured is no error: its [`Outcome`](crate::Outcome) says why.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The lower limit of a tolerance is not below the upper one, or one of them is NaN.
    ///
    /// ```
    /// use inspection::{Error, Tolerance};
    ///
    /// assert_eq!(Tolerance::new(0.2, 0.1), Err(Error::Tolerance { lower: 0.2, upper: 0.1 }));
    /// ```
    #[error("the tolerance reaches from {lower} to {upper}; the lower limit must be below the upper one")]
    Tolerance {
        /// The lower limit.
        lower: f64,
        /// The upper limit.
        upper: f64,
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
    /// The direction of measurement has no length, or is not finite.
    #[error("the direction ({x}, {y}, {z}) has no length, or is not finite")]
    Direction {
        /// First coordinate.
        x: f64,
        /// Second coordinate.
        y: f64,
        /// Third coordinate.
        z: f64,
    },
    /// Distances are to be measured along the normals of the points, or to where normals agree, but there is not one normal per point.
    #[error(
        "measuring by the normals of the points takes one normal per point, found {found} for {points} points"
    )]
    Normals {
        /// Number of normals.
        found: usize,
        /// Number of points.
        points: usize,
    },
    /// Normals are to agree with those of curves, which have none that tells a side.
    #[error("curves have no normals with which those of the points could agree; leave out the largest angle")]
    FacingCurves,
    /// Normals are to agree with those of a mesh whose triangles disagree among themselves.
    #[error(
        "neighbouring triangles disagree on the side of their normals, with which those of the points are to agree; orient the mesh, or leave out the largest angle"
    )]
    FacingUnoriented,
    /// Distances from curves are to be measured along given lines, which do not meet a curve in space.
    #[error("deviations from curves are measured along the shortest lines only")]
    AlongCurves,
    /// The nominal shape is empty.
    #[error("there is no surface or curve to measure from")]
    EmptyModel,
    /// A surface cannot be used.
    #[error(transparent)]
    Surface(#[from] nurbs_core::Error),
    /// A mesh cannot be used.
    #[error(transparent)]
    Mesh(#[from] mesh_core::Error),
    /// A projector cannot be built.
    #[error(transparent)]
    Projection(#[from] footpoint::Error),
    /// Two partial results were made with different options.
    #[error("the partial results were made with different options; inspect all tiles in the same way")]
    DifferentOptions,
    /// A partial result holds something that no inspection can have made.
    #[error("the partial result is damaged: {what}")]
    Damaged {
        /// What is wrong.
        what: &'static str,
    },
    /// There are more surface triangles or points than a 32-bit index can tell apart.
    #[error("{count} are too many for a report, at most {limit} can be numbered")]
    TooMany {
        /// How many there are.
        count: usize,
        /// How many there may be.
        limit: usize,
    },
}
