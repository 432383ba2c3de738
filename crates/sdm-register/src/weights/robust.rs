//! How outliers are dealt with, and the rule that one step goes by.

use distance_field::{Kernel, Spread};
use sdm_core::trim_limit;

/// What is assumed about points that do not belong to the shape.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Outliers {
    /// Least squares over all points, unless the residuals show that some of them do not belong to the shape. Then the
    /// distance that counts is narrowed from a third of the size of the cloud down to the noise, which is estimated,
    /// and the result is the least squares solution over the points within it (away from the boundary of the shape).
    #[default]
    Automatic,
    /// There are none: least squares over all points.
    None,
    /// A kernel whose scale is narrowed as above, down to the given one or to [`Kernel::tuning`] times the estimated
    /// noise.
    Kernel {
        /// The kernel.
        kernel: Kernel,
        /// Its final scale, in the model's unit; estimated if there is none.
        abs_scale: Option<f64>,
    },
    /// The given share of the points, those that are furthest at each step, does not count.
    Trimmed {
        /// In `[0, 1)`.
        outliers: f64,
    },
}

/// How far a point may be off, in lengths of the last step, before it counts as an outlier.
const STILL: f64 = 3.0;

/// The rule for the weights of one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Weighting {
    /// A kernel with the scale `c`.
    Kernel { kernel: Kernel, scale: f64 },
    /// All points up to a distance.
    Cut { limit: f64 },
}

/// The value of a robust kernel at a distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct KernelValue {
    /// The loss `ρ`, a squared length.
    pub(crate) loss: f64,
    /// The weight `ω = ρ'`.
    pub(crate) weight: f64,
    /// What the change of the weight adds to the second derivative along the gradient, `2 s ρ''`.
    pub(crate) weight_change: f64,
}

impl Weighting {
    /// Least squares.
    pub(crate) const SQUARES: Self = Self::Kernel { kernel: Kernel::Square, scale: 1.0 };

    /// The scale of the kernel or the limit; `None` for least squares.
    pub(crate) fn scale(&self) -> Option<f64> {
        match *self {
            Self::Kernel { kernel: Kernel::Square, .. } => None,
            Self::Kernel { scale, .. } => Some(scale),
            Self::Cut { limit } => Some(limit),
        }
    }

    /// Loss and weight at a distance.
    #[inline]
    pub(crate) fn evaluate(&self, distance: f64) -> KernelValue {
        let square = distance * distance;
        match *self {
            Self::Kernel { kernel: Kernel::Square, .. } => {
                KernelValue { loss: square, weight: 1.0, weight_change: 0.0 }
            }
            Self::Kernel { kernel, scale } => {
                let s = square / (scale * scale);
                if s.is_nan() {
                    // No noise at all: a point on the shape counts, any other does not.
                    return KernelValue { loss: 0.0, weight: 1.0, weight_change: 0.0 };
                }
                let weight_change = if s.is_finite() { 2.0 * s * kernel.weight_slope(s) } else { 0.0 };
                KernelValue { loss: scale * scale * kernel.loss(s), weight: kernel.weight(s), weight_change }
            }
            Self::Cut { limit } if distance.abs() <= limit => {
                KernelValue { loss: square, weight: 1.0, weight_change: 0.0 }
            }
            Self::Cut { limit } => KernelValue { loss: limit * limit, weight: 0.0, weight_change: 0.0 },
        }
    }
}

/// Where the scale of the rule of a step comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Rule {
    /// Always the same.
    Fixed(Weighting),
    /// The kernel with the tuned multiple of the estimated noise, never wider than `limit` nor narrower than `floor`.
    Estimated { kernel: Kernel, limit: f64, floor: f64 },
    /// All but a share of the points.
    Trimmed { outliers: f64 },
}

impl Rule {
    /// The weights for the distances (not negative) of a step, after a step by the length `moving`. Reorders them.
    ///
    /// While the cloud moves, points are off by as much, and others that fit already say nothing about their noise.
    pub(crate) fn weighting(&self, distances: &mut [f64], moving: f64) -> Weighting {
        match *self {
            Self::Fixed(weighting) => weighting,
            Self::Estimated { kernel, limit, floor } => {
                let sigma = Spread::of(distances, Kernel::Tukey.tuning()).sigma;
                Weighting::Kernel {
                    kernel,
                    scale: (kernel.tuning() * sigma).max(STILL * moving).min(limit).max(floor),
                }
            }
            Self::Trimmed { outliers } => Weighting::Cut { limit: trim_limit(distances, outliers) },
        }
    }

    /// Whether the rule depends on the distances.
    pub(crate) fn adapts(&self) -> bool {
        !matches!(self, Self::Fixed(_))
    }
}
