//! Shapes from points: interpolation and least squares approximation.

mod collocation;
mod constraints;
mod curve;
mod energy;
mod gauss;
mod grid;
mod interpolate;
mod normal;
mod observations;
mod parameters;
mod placement;
mod project;
mod report;
mod surface;

pub use curve::CurveFitOptions;
pub use gauss::gauss_legendre;
pub use grid::GridOptions;
pub use parameters::{ParameterMethod, closed_parameters, grid_parameters, parameters};
pub(crate) use project::project;
pub use report::Fitted;
pub use surface::SurfaceFitOptions;
