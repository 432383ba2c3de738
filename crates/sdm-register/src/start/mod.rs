//! A start without a guess: poses from which a registration converges, found from any position.
//!
//! Poses are proposed by principal axes and by pairs of oriented points ([`StartMethod`]), scored on a grid of nearest
//! samples, improved by a few Gauss-Newton steps, and ranked. What is left is a short list of [`StartCandidate`]s, from the
//! best few of which the exact registration is to be run.

mod axes;
mod grid;
mod options;
mod oriented;
mod pairs;
mod placement;
mod pool;
pub(crate) mod random;
mod refine;
mod report;
mod score;
mod search;
mod thin;
mod turning;

pub(crate) use placement::Placement;
pub(crate) use search::{axis_placements, refine_placement};
pub(crate) use turning::Turning;

pub use options::{StartMethod, StartOptions};
pub use oriented::OrientedPoints;
pub use report::{StartCandidate, StartReport, StartStatus};
pub use search::{CoarseStart, StartSearch, coarse_start};

/// Indices of about as many items as are wanted, evenly picked.
pub(crate) fn thin_evenly(count: usize, most: usize) -> Vec<usize> {
    (0..count).step_by(count.div_ceil(most).max(1)).collect()
}
