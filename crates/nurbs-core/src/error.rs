//! What can be wrong with the data of a curve or surface.

/// Invalid input to a constructor or an operation of this crate.
///
/// Every variant carries the numbers that are needed to find the fault.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An interval is empty, reversed or not finite.
    #[error("interval [{start}, {end}] is empty or not finite; its start must be smaller than its end")]
    EmptyInterval {
        /// Lower end as given.
        start: f64,
        /// Upper end as given.
        end: f64,
    },
    /// The degree is outside `1..=MAX_DEGREE`.
    #[error("degree {degree} is not supported; it must be between 1 and {max}", max = crate::MAX_DEGREE)]
    Degree {
        /// Degree as given.
        degree: usize,
    },
    /// There are too few knots for the degree.
    #[error("{found} knots are too few for degree {degree}; at least {needed} are needed")]
    TooFewKnots {
        /// Number of knots given.
        found: usize,
        /// Degree of the basis.
        degree: usize,
        /// Least number of knots: `2 (degree + 1)`, or `3 degree + 1` of a periodic vector.
        needed: usize,
    },
    /// A knot is NaN or infinite.
    #[error("knot {index} is {value}; knots must be finite")]
    NonFiniteKnot {
        /// Index of the knot.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// The knot vector decreases.
    ///
    /// ```
    /// # use nurbs_core::{Error, KnotVector};
    /// let knots = vec![0.0, 0.0, 2.0, 1.0];
    /// assert!(matches!(KnotVector::new(1, knots), Err(Error::DecreasingKnot { index: 3, .. })));
    /// ```
    #[error("knot {index} is smaller than its predecessor ({value} < {previous})")]
    DecreasingKnot {
        /// Index of the smaller knot.
        index: usize,
        /// Its value.
        value: f64,
        /// The value before it.
        previous: f64,
    },
    /// A knot is repeated more often than a continuous shape allows.
    #[error("knot {value} (index {index}) has multiplicity {multiplicity}; at most {max} is allowed there")]
    KnotMultiplicity {
        /// Index of the first of the equal knots.
        index: usize,
        /// Their value.
        value: f64,
        /// How often it occurs.
        multiplicity: usize,
        /// How often it may occur.
        max: usize,
    },
    /// The domain `[t_p, t_n]` of the knot vector has no length.
    #[error("the domain of the knot vector is empty: knots {degree} and {last} are both {value}")]
    EmptyDomain {
        /// Index of the first knot of the domain (the degree).
        degree: usize,
        /// Index of the last knot of the domain.
        last: usize,
        /// Their common value.
        value: f64,
    },
    /// The knots of a periodic vector do not repeat with its period.
    #[error("knot {index} is {value}, but a periodic vector with period {period} needs {expected}")]
    NotPeriodic {
        /// Index of the knot.
        index: usize,
        /// Its value.
        value: f64,
        /// The value that the period asks for.
        expected: f64,
        /// Length of the domain.
        period: f64,
    },
    /// The numbers of control points, knots and the degree do not fit together.
    #[error("{found} control points do not fit: {knots} knots of degree {degree} need {needed}")]
    ControlPointCount {
        /// Number of control points given.
        found: usize,
        /// Number needed, `knots − degree − 1`.
        needed: usize,
        /// Number of knots.
        knots: usize,
        /// Degree.
        degree: usize,
    },
    /// The number of weights differs from the number of control points.
    #[error("{found} weights given for {needed} control points")]
    WeightCount {
        /// Number of weights.
        found: usize,
        /// Number of control points.
        needed: usize,
    },
    /// A control point has a NaN or infinite coordinate.
    #[error("control point {index} has a coordinate that is not finite")]
    NonFiniteControlPoint {
        /// Index of the control point (row-major on surfaces).
        index: usize,
    },
    /// A control point has a coordinate with which nothing can be computed any more.
    #[error("control point {index} has the coordinate {value:?}; coordinates are allowed up to {max:e}: scale the shape down", max = crate::MAX_COORDINATE)]
    Magnitude {
        /// Index of the control point (row-major on surfaces).
        index: usize,
        /// The coordinate.
        value: f64,
    },
    /// A weight is so much smaller than another that its control point would be lost in rounding errors.
    #[error("weight {index} is {value:?} and the largest is {largest:?}; weights may differ by a factor of {max:e} at most", max = crate::MAX_WEIGHT_RATIO)]
    WeightRatio {
        /// Index of the weight (row-major on surfaces).
        index: usize,
        /// Its value.
        value: f64,
        /// The largest weight of the shape.
        largest: f64,
    },
    /// A weight is not a positive finite number.
    #[error("weight {index} is {value}; weights must be positive and finite")]
    Weight {
        /// Index of the weight (row-major on surfaces).
        index: usize,
        /// Its value.
        value: f64,
    },
    /// The last `degree` control points of a periodic shape do not repeat the first ones.
    #[error("control point {index} of a periodic shape must repeat control point {first}")]
    PeriodicControlPoint {
        /// Index of the point at the end.
        index: usize,
        /// Index of the point at the start that it must equal.
        first: usize,
    },
    /// A parameter lies outside the domain, or is NaN.
    #[error("parameter {value} lies outside the domain [{start}, {end}]")]
    Parameter {
        /// The parameter.
        value: f64,
        /// Lower end of the domain.
        start: f64,
        /// Upper end of the domain.
        end: f64,
    },
    /// An argument of an operation is unusable; the text says which and why.
    #[error("{what}")]
    Argument {
        /// What is wrong and what to do.
        what: String,
    },
    /// Two shapes cannot be combined; the text says why.
    #[error("{what}")]
    Incompatible {
        /// What does not fit together.
        what: String,
    },
    /// A system of linear equations is singular or not positive definite.
    #[error("the linear system for the control points is singular: {what}")]
    Singular {
        /// Which data cause it and what to do.
        what: String,
    },
    /// A JSON form has a field that is missing or wrong.
    #[error("field `{field}`: {what}")]
    Form {
        /// Name of the field.
        field: &'static str,
        /// What is wrong with it.
        what: String,
    },
}

impl Error {
    /// [`Error::Argument`] from any text.
    pub(crate) fn argument(what: impl Into<String>) -> Self {
        Self::Argument { what: what.into() }
    }
}
