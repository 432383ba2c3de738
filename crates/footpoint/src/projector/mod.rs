//! Projectors: shapes prepared once, for any number of queries.

mod all_feet;
mod batch;
pub(crate) mod classify;
mod classify_curve;
mod curve;
mod facing;
mod frame;
mod local_minimum;
pub(crate) mod pool;
mod surface;
mod update;

pub use all_feet::{CurveFeet, SurfaceFeet};
pub use curve::CurveProjector;
pub use surface::SurfaceProjector;

use std::ops::ControlFlow;

/// Told the number of points done and the total; a break cancels what is left.
pub type Progress<'a> = &'a (dyn Fn(usize, usize) -> ControlFlow<()> + Sync);

/// A progress callback that does nothing.
///
/// # Errors
/// Never breaks.
pub fn no_progress(_done: usize, _total: usize) -> ControlFlow<()> {
    ControlFlow::Continue(())
}
