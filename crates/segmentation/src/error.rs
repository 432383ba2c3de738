//! Errors of this crate.

/// Why a cloud cannot be segmented.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The neighbours cannot be found.
    #[error(transparent)]
    Mesh(#[from] mesh_core::Error),
    /// Fewer points than a surface needs.
    #[error("{count} points are too few to segment, at least {needed} are needed")]
    TooFewPoints {
        /// Number of points.
        count: usize,
        /// Fewest.
        needed: usize,
    },
    /// A coordinate or normal is NaN or infinite.
    #[error("{what} {index} (counted from 0) is not finite; remove it first")]
    NotFinite {
        /// Point or normal.
        what: &'static str,
        /// Its number.
        index: usize,
    },
    /// Points that span no surface.
    #[error("all points lie {what}, so there is no surface to segment")]
    Degenerate {
        /// Where.
        what: &'static str,
    },
    /// Points too near or too far for squares of distances.
    #[error("the cloud has the size {size:e}, but sizes must lie between 1e-100 and 1e100; scale the points")]
    Magnitude {
        /// Largest extent along an axis.
        size: f64,
    },
    /// Normals given for another number of points.
    #[error("{normals} normals were given for {points} points")]
    Normals {
        /// Number of normals.
        normals: usize,
        /// Number of points.
        points: usize,
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
}
