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
    /// Smallest singular value of the Jacobian over the largest, its columns scaled to unit length.
    pub conditioning: f64,
    /// Covariance of [`Elements::values`], `σ̂² G H⁻¹ Gᵀ`, by rows; empty unless asked for.
    pub covariance: Vec<Vec<f64>>,
}

impl<S, const D: usize> PrimitiveFit<S, D> {
    /// Whether the shape is a local minimum of the sum of squared distances.
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
