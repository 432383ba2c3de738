//! Error terms: how the distance of a point is measured while its foot stands still.

use crate::{PrincipalFrame, QuadraticModel};
use nalgebra::SVector;

/// Which quadratic model stands for the squared distance in a step of fitting or registration.
///
/// They differ only in the weight `wᵢ` of a tangent direction with the radius of curvature `ρᵢ = 1/κᵢ`; the normal
/// and all directions in which the foot cannot move have the weight 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum ErrorTerm {
    /// Squared distance to the foot, `wᵢ = 1`: PDM, ICP. Linear convergence.
    Point,
    /// Squared distance to the tangent plane, `wᵢ = 0`: TDM, Chen and Medioni. A Gauss-Newton method.
    Tangent,
    /// The second order Taylor polynomial made nonnegative as in \[P05, sec. 3.2\]: `wᵢ = d/(d − ρᵢ)` where this is
    /// in `[0, 1]`, 0 where it is negative, and 1 beyond the centre of curvature, where the foot is not nearest.
    #[default]
    SquaredDistance,
    /// Nonnegative by another choice: `wᵢ = |d|/(|d| + |ρᵢ|)`. The same on the side away from the centre of curvature,
    /// positive on the other.
    SquaredDistanceRatio,
    /// The second order Taylor polynomial itself, `wᵢ = d/(d − ρᵢ)`, which may be indefinite: Newton's method
    /// (\[P05, eqs. (3), (5)\]).
    Taylor,
}

impl ErrorTerm {
    /// Every term, in the order from slow to fast local convergence.
    pub const ALL: [Self; 5] =
        [Self::Point, Self::Tangent, Self::SquaredDistance, Self::SquaredDistanceRatio, Self::Taylor];

    /// The weight of a tangent direction for the signed distance `d` and the normal curvature `κ` along it.
    ///
    /// At a centre of curvature (`dκ = 1`) the Taylor polynomial has no limit; there the weight of the point is
    /// returned, the largest that is bounded.
    #[must_use]
    pub fn tangent_weight(self, distance: f64, curvature: f64) -> f64 {
        // d/(d − ρ) = δ/(δ − 1) with δ = dκ; no division by κ, which may vanish.
        let delta = distance * curvature;
        match self {
            Self::Point => 1.0,
            Self::Tangent => 0.0,
            Self::SquaredDistance if delta >= 1.0 => 1.0,
            Self::SquaredDistance if delta > 0.0 => 0.0,
            Self::SquaredDistance | Self::SquaredDistanceRatio => {
                let ratio = delta.abs() / (delta.abs() + 1.0);
                // Only an infinite δ gives no ratio.
                if ratio.is_finite() { ratio } else { 1.0 }
            }
            Self::Taylor => {
                let weight = delta / (delta - 1.0);
                if weight.is_finite() { weight } else { 1.0 }
            }
        }
    }

    /// The weight of each axis of a frame: 1 for the normal and directions in which the foot cannot move.
    #[must_use]
    #[inline]
    pub fn weights<const D: usize>(self, frame: &PrincipalFrame<D>) -> SVector<f64, D> {
        let mut weights = SVector::repeat(1.0);
        for i in 0..frame.tangent_dimension.min(D) {
            weights[i] = self.tangent_weight(frame.distance, frame.curvatures[i]);
        }
        weights
    }

    /// The quadratic model of `d²` that this term takes at a frame.
    #[must_use]
    pub fn model<const D: usize>(self, frame: &PrincipalFrame<D>) -> QuadraticModel<D> {
        QuadraticModel { foot: frame.foot, axes: frame.axes, weights: self.weights(frame) }
    }

    /// The name used in files and options: `point`, `tangent`, `squared_distance`, …
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Tangent => "tangent",
            Self::SquaredDistance => "squared_distance",
            Self::SquaredDistanceRatio => "squared_distance_ratio",
            Self::Taylor => "taylor",
        }
    }
}

impl std::fmt::Display for ErrorTerm {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_by_the_side_of_the_centre() {
        // ρ = 2 on the positive side.
        let weight = |term: ErrorTerm, d: f64| term.tangent_weight(d, 0.5);
        for (d, taylor, zero, ratio) in [
            (-2.0, 0.5, 0.5, 0.5),
            (0.0, 0.0, 0.0, 0.0),
            (1.0, -1.0, 0.0, 1.0 / 3.0),
            (6.0, 1.5, 1.0, 0.75),
            (2.0, 1.0, 1.0, 0.5),
        ] {
            assert_eq!(weight(ErrorTerm::Taylor, d), taylor, "d = {d}");
            assert_eq!(weight(ErrorTerm::SquaredDistance, d), zero, "d = {d}");
            assert!((weight(ErrorTerm::SquaredDistanceRatio, d) - ratio).abs() < 1e-15, "d = {d}");
            assert_eq!((weight(ErrorTerm::Point, d), weight(ErrorTerm::Tangent, d)), (1.0, 0.0));
        }
        for term in ErrorTerm::ALL {
            assert!(term.tangent_weight(1e300, 1e300).is_finite(), "{term}");
        }
    }
}
