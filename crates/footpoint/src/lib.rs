//! Orthogonal projection of points onto parametric curves and surfaces.

mod error;
mod footpoint;
mod status;

pub use error::Error;
pub use footpoint::{CurveFootpoint, SurfaceFootpoint};
pub use status::{Location, Multiplicity, Status};
