//! Errors of this crate.

/// What can be wrong with an image, a volume, or a level set.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Bytes that are no image or no grid.
    #[error("{format}, byte {byte}: {what}")]
    Malformed {
        /// The format, as `PNG`.
        format: &'static str,
        /// Where, from the beginning of the file.
        byte: usize,
        /// What is wrong.
        what: String,
    },
    /// An image or a grid that would take too much memory.
    #[error(
        "{what} take {bytes} bytes as numbers, more than the {most} allowed; take a part of it, or a smaller one"
    )]
    TooLarge {
        /// What it is: its size in words.
        what: String,
        /// How much it would take.
        bytes: u128,
        /// How much is allowed.
        most: u64,
    },
    /// An image with too few pixels for a cubic.
    #[error("{width} x {height} pixels are too few: a contour needs 4 or more in each direction")]
    TooSmall {
        /// Pixels from left to right.
        width: usize,
        /// Pixels from top to bottom.
        height: usize,
    },
    /// A value that is no number.
    #[error("value {index} (from 0) is {value}, not a finite number; fill or leave out such places first")]
    NotFinite {
        /// Its index.
        index: usize,
        /// The value.
        value: f64,
    },
    /// An image whose values are all the same, or nearly so.
    #[error("the image has no contrast: all of its values are {value}; there is no contour in it")]
    NoContrast {
        /// The value.
        value: f64,
    },
    /// A level that no value crosses.
    #[error(
        "the level {level} is not between the smallest value, {least}, and the largest, {most}; give one that is"
    )]
    Level {
        /// The level.
        level: f64,
        /// Smallest value.
        least: f64,
        /// Largest value.
        most: f64,
    },
    /// A level set without a point.
    #[error("the level set is empty: {what}")]
    Empty {
        /// How that came about, and what can be done.
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
    /// The level function cannot be used.
    #[error(transparent)]
    Field(#[from] distance_field::Error),
    /// A curve cannot be made.
    #[error(transparent)]
    Curve(#[from] nurbs_core::Error),
    /// A curve cannot be fitted.
    #[error(transparent)]
    Fit(#[from] sdm_fit::Error),
    /// A mesh or polyline cannot be made.
    #[error(transparent)]
    Mesh(#[from] mesh_core::Error),
}

impl Error {
    pub(crate) fn malformed(format: &'static str, byte: usize, what: impl Into<String>) -> Self {
        Self::Malformed { format, byte, what: what.into() }
    }
}

/// Most bytes that the values of an image or of a grid may take.
pub(crate) const MOST_BYTES: u64 = 4 << 30;

/// Makes sure that so many numbers may be held.
pub(crate) fn check_size(counts: &[u64], what: impl FnOnce() -> String) -> Result<usize, Error> {
    let bytes = counts.iter().fold(8u128, |bytes, &count| bytes.saturating_mul(u128::from(count)));
    if bytes > u128::from(MOST_BYTES) {
        return Err(Error::TooLarge { what: what(), bytes, most: MOST_BYTES });
    }
    usize::try_from(bytes / 8).map_err(|_| Error::TooLarge { what: what(), bytes, most: MOST_BYTES })
}
