//! What is assumed about samples that do not belong to the shape.

use distance_field::{Kernel, quantile_in_place};

/// What is assumed about samples that do not belong to the shape.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Robust {
    /// There are none.
    #[default]
    None,
    /// A kernel weighs them down.
    Kernel {
        /// The kernel.
        kernel: Kernel,
        /// Its scale; by default [`Kernel::tuning`] times the spread of the distances, in each iteration.
        abs_scale: Option<f64>,
    },
    /// The given share of the samples, those that are furthest in each iteration, does not count.
    Trimmed {
        /// In `[0, 1)`.
        outliers: f64,
    },
}

/// The largest distance that counts where a share of outliers is trimmed, in `[0, 1)`. Reorders the distances.
#[must_use]
pub fn trim_limit(distances: &mut [f64], outliers: f64) -> f64 {
    quantile_in_place(distances, 1.0 - outliers)
}
