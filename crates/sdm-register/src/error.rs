//! Errors of this crate.

/// What can be wrong with the input of a registration.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Not enough points with finite coordinates to tell a position.
    #[error("{what} has {found} usable points; at least {needed} are needed")]
    TooFewPoints {
        /// Which input: `model`, `cloud`, `view 3`.
        what: String,
        /// Number of points that can be used.
        found: usize,
        /// Number of points that are needed.
        needed: usize,
    },
    /// All points coincide, or the shape has no area.
    #[error("{what} has no extent: all of it lies in one point")]
    NoExtent {
        /// Which input.
        what: String,
    },
    /// Lists that belong together have different lengths.
    #[error("{found} {what} for {expected}")]
    LengthMismatch {
        /// What the list holds.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length it should have.
        expected: usize,
    },
    /// An option is outside its range.
    #[error("option {name} = {value} is not in {range}")]
    InvalidOption {
        /// The option.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The values that are allowed.
        range: &'static str,
    },
}
