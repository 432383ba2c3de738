//! Tensor product surfaces.

mod active;
pub(crate) mod apart;
mod base;
mod edge;
mod fit;
mod fold_bounds;
mod folds;
pub(crate) mod given;
mod initial;
mod judge;
mod options;
mod rational;
mod refine;
mod runs;
mod to_model;
mod tolerance;

pub use active::ActiveSurface;
pub(crate) use base::{Base, choose};
pub use fit::{
    SurfaceFit, SurfaceReport, fit_cloud, fit_cloud_with_progress, fit_surface, fit_surface_with_progress,
};
pub use folds::Folds;
pub use initial::{BaseShape, InitialSurface, NetSize, initial_surface};
pub(crate) use initial::{approximate, centred, knots};
pub use judge::{
    SurfaceCost, SurfaceDistances, cut_to_feet, residual_disagreement, surface_costs, surface_frames,
};
pub use options::SurfaceOptions;
pub use refine::with_controls;
pub use to_model::{fit_surface_to_model, fit_surface_to_model_with_progress};
