//! Errors of this crate.

/// What can be wrong with the input of a registration.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A rigid motion is not determined by so few points.
    #[error("{finite} of {total} points can be used, at least {needed} are needed")]
    TooFewPoints {
        /// Points given.
        total: usize,
        /// Points with finite coordinates and a positive weight.
        finite: usize,
        /// Points needed.
        needed: usize,
    },
    /// A coordinate whose square is not finite.
    #[error(
        "point {index} has the coordinate {value:e}, of which no square can be computed: leave it out, or give the points in another unit"
    )]
    TooLarge {
        /// The first such point.
        index: usize,
        /// Its largest coordinate.
        value: f64,
    },
    /// Points with coordinates that are not finite, where they are to be refused.
    #[error("point {index} is not finite, the first of {count}; drop such points or allow it by the options")]
    NotFinite {
        /// The first such point.
        index: usize,
        /// Their number.
        count: usize,
    },
    /// All points lie on one line (or are equal), so that no motion is determined.
    #[error(
        "the points lie on one line, {width} (rms) from it and {length} (rms) along it, and determine no motion: give points off the line"
    )]
    Collinear {
        /// Root mean square distance from the line.
        width: f64,
        /// Root mean square extent along the line.
        length: f64,
    },
    /// An array that goes with the points has not one entry per point.
    #[error("{found} {what} for {points} points")]
    Length {
        /// What the array holds.
        what: &'static str,
        /// Its length.
        found: usize,
        /// Number of points.
        points: usize,
    },
    /// A weight that is negative or not finite.
    #[error("weight {value} of point {index} is not a finite number of at least 0")]
    Weight {
        /// The point.
        index: usize,
        /// Its weight.
        value: f64,
    },
    /// A matrix that is not that of a rigid motion, with a positive scale at most.
    #[error("not a rigid motion: the matrix deviates by {deviation}")]
    NotAMotion {
        /// How far the matrix is from a rotation, or its last row from that of a motion.
        deviation: f64,
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
    /// The shape has no point that could be found from the cloud.
    #[error("the model is empty: no footpoint was found for any of {points} points")]
    EmptyModel {
        /// Number of points that were tried.
        points: usize,
    },
    /// A method asks for normals of the points.
    #[error("{what} needs a normal for each point")]
    NormalsNeeded {
        /// The method.
        what: &'static str,
    },
    /// Datum targets that do not determine a motion.
    #[error("the datum targets leave {free} of {unknowns} degrees of freedom open")]
    OpenDatum {
        /// Degrees of freedom left.
        free: usize,
        /// All of them.
        unknowns: usize,
    },
    /// A cloud that cannot be searched.
    #[error(transparent)]
    Cloud(#[from] mesh_core::Error),
    /// Something is wrong with one of several inputs.
    #[error("{what}: {source}")]
    Input {
        /// Which one: `model`, `cloud`, `view 3` (counted from 0).
        what: String,
        /// What is wrong with it.
        source: Box<Self>,
    },
}

impl Error {
    /// The same error, with a word about which input it is about.
    pub(crate) fn of(self, what: impl Into<String>) -> Self {
        Self::Input { what: what.into(), source: Box::new(self) }
    }
}
