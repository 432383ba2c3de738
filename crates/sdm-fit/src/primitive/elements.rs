//! Where a shape is, which way it points and how large it is.

use super::PrimitiveStatus;
use nalgebra::SVector;

/// Location, direction and sizes of a shape, in the coordinates of the points.
///
/// Where the shape leaves the location open (a plane, a line, an axis), it is the point nearest to the mean of the points.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Elements<const D: usize> {
    /// A point of the line or plane, the centre of a circle, sphere or torus, a point of the axis of a cylinder or cone.
    #[cfg_attr(feature = "serde", serde(serialize_with = "as_slice"))]
    pub location: SVector<f64, D>,
    /// Unit vector along a line or an axis, or normal to a plane; its largest component is positive, but for cones, which
    /// widen along it.
    #[cfg_attr(feature = "serde", serde(serialize_with = "as_option"))]
    pub direction: Option<SVector<f64, D>>,
    /// Radius; of a cone the one at the location, of a torus that of the middle circle of the tube.
    pub radius: Option<f64>,
    /// Radius of the tube of a torus.
    pub minor_radius: Option<f64>,
    /// Angle between the axis of a cone and its generators, radians.
    pub half_angle: Option<f64>,
}

impl<const D: usize> Elements<D> {
    /// The elements as one list: location, direction, radius, minor radius, angle, without those that do not exist.
    #[must_use]
    pub fn values(&self) -> Vec<f64> {
        let direction = self.direction.iter().flat_map(|d| d.iter().copied());
        let sizes = [self.radius, self.minor_radius, self.half_angle].into_iter().flatten();
        self.location.iter().copied().chain(direction).chain(sizes).collect()
    }

    /// The same shape after `x ↦ centre + scale · x`.
    pub(super) fn placed(self, centre: &SVector<f64, D>, scale: f64) -> Self {
        Self {
            location: centre + self.location * scale,
            radius: self.radius.map(|r| r * scale),
            minor_radius: self.minor_radius.map(|r| r * scale),
            ..self
        }
    }
}

/// A direction without a sign of its own, with its largest component positive.
pub(super) fn upright<const D: usize>(direction: SVector<f64, D>) -> SVector<f64, D> {
    if direction[direction.iamax()] < 0.0 { -direction } else { direction }
}

/// A shape fitted by least squares of orthogonal distances.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct PrimitiveFit<S, const D: usize> {
    /// The piece of the shape over which the points lie: as long as they reach along a line, a plane or an axis, and all
    /// around.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub shape: S,
    /// Location, direction and sizes, without the rounding that the ends of the piece bring along.
    pub elements: Elements<D>,
    /// How the iteration ended.
    pub status: PrimitiveStatus,
    /// Root mean square of the orthogonal distances of the points that count.
    pub rms: f64,
    /// Largest distance of a point that counts.
    pub max: f64,
    /// Number of steps.
    pub iterations: usize,
    /// Number of points.
    pub points: usize,
    /// Number of points left out because they are not finite.
    pub dropped: usize,
    /// Number of points that count; fewer than are finite only where outliers are told apart.
    pub used: usize,
    /// Distance of each point in the order of the input, NaN for those left out: positive outside of a circle in the plane or a
    /// surface, on the side of a plane to which its direction points, on the left of a line in the plane; of lines and circles in
    /// space without sign.
    pub residuals: Vec<f64>,
    /// Largest minus smallest residual of the points that count: the width of the zone that holds them. Of lines and circles in
    /// space the diameter of the tube, twice the largest distance.
    pub form_error: f64,
    /// The points that count furthest from the shape, by index, the furthest first: [`PrimitiveOptions::worst`] of them.
    ///
    /// [`PrimitiveOptions::worst`]: super::PrimitiveOptions::worst
    pub worst: Vec<usize>,
    /// Number of residuals of different points that count minus number of unknowns: with 0 the shape goes through all points.
    pub redundancy: usize,
    /// Number of different shapes found whose sums of squares are the same to a millionth.
    pub solutions: usize,
    /// Number of starts, or of random subsets where outliers are told apart.
    pub starts: usize,
    /// How likely the search missed a better shape, by what it has seen.
    ///
    /// Without outliers `(1 − h/n)ⁿ`, the probability that all of `n` starts miss a minimum that is reached as easily as the one
    /// given, which `h` of them reached; 0 if the points lie on the shape. With outliers `(1 − qᵐ)ᵏ`, the probability that none of `k` random
    /// subsets of `m` points, as many as the shape needs, was free of them, `q` being the share of the points that count
    /// (\[FB81\]). 0 for lines and planes, whose least squares solution is in closed form.
    pub miss_probability: f64,
    /// Smallest singular value of the Jacobian over the largest, its columns scaled to unit length.
    pub conditioning: f64,
    /// Covariance of [`Elements::values`], `σ̂² G H⁻¹ Gᵀ`, by rows; empty unless asked for.
    pub covariance: Vec<Vec<f64>>,
}

impl<const D: usize> PrimitiveFit<(), D> {
    /// The report with a shape.
    pub(super) fn with_shape<S>(self, shape: S) -> PrimitiveFit<S, D> {
        PrimitiveFit {
            shape,
            elements: self.elements,
            status: self.status,
            rms: self.rms,
            max: self.max,
            iterations: self.iterations,
            points: self.points,
            dropped: self.dropped,
            used: self.used,
            residuals: self.residuals,
            form_error: self.form_error,
            worst: self.worst,
            redundancy: self.redundancy,
            solutions: self.solutions,
            starts: self.starts,
            miss_probability: self.miss_probability,
            conditioning: self.conditioning,
            covariance: self.covariance,
        }
    }
}

impl<S, const D: usize> PrimitiveFit<S, D> {
    /// Whether the shape is a minimum of the sum of squared distances that nothing speaks against.
    #[must_use]
    pub fn is_converged(&self) -> bool {
        self.status == PrimitiveStatus::Converged
    }
}

impl<S, const D: usize> std::fmt::Display for PrimitiveFit<S, D> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} after {} steps, rms {:.4e}, max {:.4e}, {} of {} points",
            self.status, self.iterations, self.rms, self.max, self.used, self.points
        )
    }
}

#[cfg(feature = "serde")]
fn as_slice<S: serde::Serializer, const D: usize>(
    vector: &SVector<f64, D>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serde::Serialize::serialize(vector.as_slice(), serializer)
}

#[cfg(feature = "serde")]
fn as_option<S: serde::Serializer, const D: usize>(
    vector: &Option<SVector<f64, D>>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serde::Serialize::serialize(&vector.as_ref().map(|v| v.as_slice().to_vec()), serializer)
}
