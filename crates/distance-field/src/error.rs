//! Errors of this crate.

/// What can be wrong with the input of a distance field.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The shape cannot be projected onto.
    #[error(transparent)]
    Footpoint(#[from] footpoint::Error),
    /// The curve or surface cannot be used.
    #[error(transparent)]
    Shape(#[from] nurbs_core::Error),
    /// The mesh or cloud cannot be used.
    #[error(transparent)]
    Mesh(#[from] mesh_core::Error),
    /// A cloud without any point to measure the distance from.
    #[error("none of {count} points has finite coordinates; a distance needs at least one")]
    NoPoints {
        /// Number of points.
        count: usize,
    },
    /// A cloud without any normal.
    #[error(
        "none of {count} points has a normal, and their neighbours span no plane from which it could be estimated"
    )]
    NoNormals {
        /// Number of points.
        count: usize,
    },
    /// A mesh that surrounds nothing, so that distances from it have no sign.
    #[error("the mesh surrounds nothing: seen from its triangles, {:.0} % of what would be its inside is open", 100.0 * (1.0 - closure))]
    NoInside {
        /// See [`Inside::closure`](crate::grid::Inside::closure).
        closure: f64,
    },
    /// A grid of values cannot be used.
    #[error("grid: {what}")]
    Grid {
        /// What is wrong with it.
        what: String,
    },
    /// An option has a value that cannot be used.
    #[error("option {option} is {value}: {what}")]
    Option {
        /// Its name.
        option: &'static str,
        /// Its value.
        value: f64,
        /// What is asked of it.
        what: &'static str,
    },
}
