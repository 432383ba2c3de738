//! Tensor product surfaces.

mod active;
pub(crate) mod apart;
mod approximate;
mod base;
mod base_shape;
mod conic_starts;
mod edge;
mod fit;
mod fold_bounds;
mod folds;
pub(crate) mod given;
mod held;
mod initial;
mod judge;
mod options;
mod rational;
mod rational_system;
mod refine;
mod report;
mod runs;
mod to_model;
mod tolerance;

pub use active::ActiveSurface;
pub(crate) use approximate::{approximate, knots};
pub(crate) use base::{Base, choose};
pub use base_shape::{BaseShape, NetSize};
pub use fit::{fit_cloud, fit_cloud_with_progress, fit_surface, fit_surface_with_progress};
pub use folds::Folds;
pub(crate) use initial::centred;
pub use initial::{InitialSurface, initial_surface};
pub use judge::{
    SurfaceCost, SurfaceDistances, cut_to_feet, residual_disagreement, surface_costs, surface_frames,
};
pub use options::SurfaceOptions;
pub use refine::with_controls;
pub use report::{SurfaceFit, SurfaceReport};
pub use to_model::{fit_surface_to_model, fit_surface_to_model_with_progress};
