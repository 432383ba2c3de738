//! Tensor product surfaces.

mod active;
mod base;
mod edge;
mod fit;
mod folds;
mod initial;
mod rational;
mod refine;
mod runs;
mod tolerance;

pub use active::ActiveSurface;
pub use fit::{
    SurfaceFit, SurfaceOptions, SurfaceReport, fit_cloud, fit_cloud_with_progress, fit_surface,
    fit_surface_with_progress,
};
pub use folds::Folds;
pub use initial::{BaseShape, InitialSurface, NetSize, initial_surface};
pub use refine::with_controls;
pub(crate) use runs::share_within;
