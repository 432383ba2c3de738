//! Shapes from points: interpolation and least squares approximation, which need the feature `fit`, and parameters for them.

#[cfg(feature = "fit")]
mod collocation;
#[cfg(feature = "fit")]
mod constraints;
#[cfg(feature = "fit")]
mod curve;
#[cfg(feature = "fit")]
mod energy;
mod gauss;
#[cfg(feature = "fit")]
mod grid;
#[cfg(feature = "fit")]
mod interpolate;
#[cfg(feature = "fit")]
mod normal;
#[cfg(feature = "fit")]
mod observations;
mod parameters;
mod placement;
#[cfg(feature = "fit")]
mod project;
#[cfg(feature = "fit")]
mod report;
#[cfg(feature = "fit")]
mod surface;

#[cfg(feature = "fit")]
pub use curve::CurveFitOptions;
pub use gauss::gauss_legendre;
#[cfg(feature = "fit")]
pub use grid::GridOptions;
pub use parameters::{ParameterMethod, closed_parameters, grid_parameters, parameters};
#[cfg(feature = "fit")]
pub(crate) use project::project;
#[cfg(feature = "fit")]
pub use report::Fitted;
#[cfg(feature = "fit")]
pub use surface::SurfaceFitOptions;
