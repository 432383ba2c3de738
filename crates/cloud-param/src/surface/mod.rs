//! Base surfaces: through base curves, drawn to the cloud, relaxed.

mod boundary;
mod grid;
mod refine;
mod unfold;

pub use boundary::dynamic_base_surface;
pub use grid::{SampleGrid, grid_of_curves};
pub use refine::{RefineOptions, RefineReport, RefineStep, refine};
